"""Check atlases: `verify` against the reference of the model, `compare` with a reference, `explain` one cell."""

from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import AtlasFile, Overwrite, seed_number
from sweep.commands.terminal import show


def verify(
    atlas: AtlasFile,
    write: Annotated[
        Path | None, typer.Option("--write", metavar="AUDIT.nc", help="Store the differences in a new file.")
    ] = None,
    overwrite: Overwrite = False,
    seed: Annotated[
        int | None,
        typer.Option(
            parser=seed_number,
            metavar="INTEGER",
            help="Which cells of an atlas with losses, or of a system, are computed a second time.",
        ),
    ] = None,
) -> None:
    """Check an atlas against the exact reduction, or with losses a second method.

    Without losses every cell is compared with the reduction, of a system of your own a sample with DOP853; with
    losses every cell is checked by its own rules, and a sample by a second computation.
    Exit status 0 if all cells agree within the tolerance that the atlas records, 1 otherwise and if none could be
    compared.
    """
    from sweep.atlas.dataset import spec_named
    from sweep.checks.verify import findings, findings_of
    from sweep.checks.verify import verify as audit_of
    from sweep.commands.audit_report import audit_text
    from sweep.files.netcdf import save
    from sweep.files.paths import check_apart, check_atlas_name, check_target
    from sweep.files.reading import opened

    if write is not None:
        check_atlas_name(write)
    with opened(atlas, indexed=False) as dataset:
        spec = spec_named(dataset)
        if write is None:
            found = findings_of(dataset, seed)
            show(audit_text(found, spec))
        else:
            check_apart(write, atlas)
            check_target(write, overwrite)
            audit = audit_of(dataset, seed=seed)
            found = findings(audit)
            show(audit_text(found, spec))
            save(audit, write, overwrite=overwrite)
    if not found.passed:
        raise typer.Exit(1)


def compare(
    new: Annotated[Path, typer.Argument(metavar="NEW.nc", help="The atlas to be checked.")],
    reference: Annotated[Path, typer.Argument(metavar="REFERENCE.nc", help="The atlas that is trusted.")],
    *,
    common: Annotated[
        bool, typer.Option("--common", help="Compare the cells that both have, if the grids differ.")
    ] = False,
    tolerance: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="Largest difference allowed in a variable, in SI or with a unit; may be repeated.",
            show_default=False,
        ),
    ] = None,
    exact: Annotated[
        bool, typer.Option("--exact", help="All bits of all variables have to be the same.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of words.")] = False,
    junit: Annotated[
        Path | None, typer.Option(metavar="OUT.xml", help="Write JUnit XML too, for a CI server.")
    ] = None,
) -> None:
    """Check an atlas against a trusted one. Exit status: 0 identical or within tolerance, 1 different, 2 neither.

    Endings and verdicts have to be equal, measures equal within what the two atlases state: their tolerances, errors
    and half-widths. Cells on the edge between two verdicts are counted separately. A variable of the cells that only
    NEW.nc has is named, not judged; so is provenance.
    """
    import json
    import time

    from sweep.checks.compare import compare as compared
    from sweep.checks.comparison_report import in_words, to_junit
    from sweep.files.paths import check_apart, check_atlas, check_target
    from sweep.files.publish import published
    from sweep.files.reading import opened
    from sweep.request.words import pairs

    given = pairs(tolerance or [])
    if junit is not None:
        check_target(junit, True)
        for atlas in (new, reference):
            check_atlas(atlas)
        check_apart(junit, new, reference)
    began = time.monotonic()
    with opened(new, indexed=False) as left, opened(reference, indexed=False) as right:
        comparison = compared(left, right, common=common, tolerances=given, exact=exact)
    if junit is not None:
        with published(junit) as unfinished:
            unfinished.write_text(to_junit(comparison, new.name, time.monotonic() - began), encoding="utf-8")
    if as_json:
        files = {"new": str(new), "reference": str(reference)}
        show(json.dumps(files | comparison.to_dict(), indent=1, allow_nan=False))
    else:
        show(in_words(comparison))
    if not comparison.same:
        raise typer.Exit(1)


def explain(
    atlas: AtlasFile,
    cell: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME=VALUE",
            help="The cell: a value for each axis, e.g. tilt=1deg.",
            show_default=False,
        ),
    ] = None,
    *,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FIG", help="Draw its motion too: png, pdf or svg; one that exists is replaced."
        ),
    ] = None,
) -> None:
    """Explain the nearest cell: its numbers, a new run of it, the exact values, theory, and the reason of its verdict.

    The last line is the command that follows its motion in time.

    eulerdisk explain rolling.nc roll_rate=2.4 tilt=1deg --plot cell.png

    Exit status 1 if the run cannot be repeated within the tolerances, or the motion in time contradicts the cell.
    """
    from sweep.request.words import pairs

    given = pairs(cell or [])
    if plot is not None:
        from sweep.files.paths import check_format, check_target

        check_format(plot)
        check_target(plot, True)
    from sweep.checks.explain import explain as explained
    from sweep.commands.simulate import command_of_motion
    from sweep.files.reading import opened

    with opened(atlas, indexed=False) as dataset:
        explanation = explained(dataset, given)
        command = command_of_motion(dataset, atlas, cell or [])
    show(explanation.text)
    if command:
        show(f"\nmotion      {command}")
    if plot is not None:
        from sweep.figures import plots

        draw = plots.of_the_model(explanation.spec.model, "trajectory", "--plot")
        plots.save(draw(explanation), plot)
    if not (explanation.repeated and explanation.confirmed):
        raise typer.Exit(1)
