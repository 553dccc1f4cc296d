"""The commands that check atlases: `verify` against theory, `compare` with another atlas, `explain` one cell."""

from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import AtlasFile, Overwrite, seed_number
from sweep.commands.terminal import show


def verify(
    atlas: AtlasFile,
    write: Annotated[
        Path | None, typer.Option("--write", metavar="AUDIT.nc", help="Write the differences to a new file.")
    ] = None,
    overwrite: Overwrite = False,
    seed: Annotated[
        int | None,
        typer.Option(
            parser=seed_number,
            metavar="INTEGER",
            help="Seed of the sample that is recomputed, for an atlas with losses or of your own system.",
        ),
    ] = None,
) -> None:
    """Check an atlas against the exact reduction or a second method.

    Without losses, every cell is compared with the exact reduction. For your own systems, a sample is recomputed with
    DOP853. With losses, every cell is checked for consistency, and a sample is recomputed with another method.

    Exit status 0 if all cells agree within the tolerance stored in the atlas; 1 if some do not, or none could be
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
    new: Annotated[Path, typer.Argument(metavar="NEW.nc", help="The atlas to check.")],
    reference: Annotated[Path, typer.Argument(metavar="REFERENCE.nc", help="The trusted atlas.")],
    *,
    common: Annotated[
        bool, typer.Option("--common", help="If the grids differ, compare the cells that both have.")
    ] = False,
    tolerance: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="Largest difference allowed in a variable, in SI or with a unit. Can be repeated.",
            show_default=False,
        ),
    ] = None,
    exact: Annotated[
        bool, typer.Option("--exact", help="Require all variables to be equal to the last bit.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of words.")] = False,
    junit: Annotated[
        Path | None, typer.Option(metavar="OUT.xml", help="Also write JUnit XML, for a CI server.")
    ] = None,
) -> None:
    """Check an atlas against a trusted one.

    Endings and verdicts must be equal. Measures must agree within the tolerances, errors and half-widths that the two
    atlases state. Cells on the edge between two verdicts are counted separately. Differences in provenance, and
    variables that only NEW.nc has, are reported but not judged.

    Exit status: 0 identical or within tolerance, 1 different, 2 not comparable.
    """
    import json
    import time

    from sweep.checks.compare import compare as compared
    from sweep.checks.comparison_report import in_words, to_junit
    from sweep.files.paths import check_apart, check_atlas, check_target
    from sweep.files.publish import published
    from sweep.files.reading import opened
    from sweep.request.words import pairs

    tolerances = pairs(tolerance or [])
    if junit is not None:
        check_target(junit, True)
        for atlas in (new, reference):
            check_atlas(atlas)
        check_apart(junit, new, reference)
    began = time.monotonic()
    with opened(new, indexed=False) as left, opened(reference, indexed=False) as right:
        comparison = compared(left, right, common=common, tolerances=tolerances, exact=exact)
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
            metavar="FIG", help="Also draw its motion: png, pdf or svg. An existing file is replaced."
        ),
    ] = None,
) -> None:
    """Explain the nearest cell: its numbers, a recomputation, the exact values, theory, and why its verdict.

    The last line is the command that follows its motion in time.

    eulerdisk explain rolling.nc roll_rate=2.4 tilt=1deg --plot cell.png

    Exit status 1 if the recomputation differs by more than the tolerances, or the motion in time contradicts the cell.
    """
    from sweep.request.words import pairs

    place = pairs(cell or [])
    if plot is not None:
        from sweep.files.paths import check_format, check_target

        check_format(plot)
        check_target(plot, True)
    from sweep.checks.explain import explain as explained
    from sweep.commands.simulate import command_of_motion
    from sweep.files.reading import opened

    with opened(atlas, indexed=False) as dataset:
        explanation = explained(dataset, place)
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
