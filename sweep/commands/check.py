"""Check atlases: `compare`."""

from pathlib import Path
from typing import Annotated

import typer

NewFile = Annotated[Path, typer.Argument(metavar="NEW.nc", help="The atlas to be checked.")]
ReferenceFile = Annotated[Path, typer.Argument(metavar="REFERENCE.nc", help="The atlas that is trusted.")]


def compare(
    new: NewFile,
    reference: ReferenceFile,
    *,
    common: Annotated[
        bool, typer.Option("--common", help="Compare the cells that both have, if the grids differ.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of words.")] = False,
    junit: Annotated[
        Path | None, typer.Option(metavar="OUT.xml", help="Write JUnit XML too, for a CI server.")
    ] = None,
) -> None:
    """Check an atlas against a trusted one. Exit status: 0 the same, 1 different, 2 not comparable.

    Endings and verdicts have to be equal, measures within the tolerances of the project; cells that flip on an edge
    are counted apart. Provenance is listed, not judged.
    """
    import json

    from sweep.checks.compare import compare as compared
    from sweep.checks.regression import in_words, to_junit
    from sweep.files.paths import check_apart, check_atlas, check_target
    from sweep.files.publish import published
    from sweep.files.reading import opened

    if junit is not None:
        check_target(junit, True)
        for atlas in (new, reference):
            check_atlas(atlas)
        check_apart(junit, new, reference)
    with opened(new) as left, opened(reference) as right:
        comparison = compared(left, right, common=common)
    if junit is not None:
        with published(junit) as unfinished:
            unfinished.write_text(to_junit(comparison, new.name), encoding="utf-8")
    if as_json:
        files = {"new": str(new), "reference": str(reference)}
        print(json.dumps(files | comparison.to_dict(), indent=1, allow_nan=False))
    else:
        print(in_words(comparison))
    if not comparison.same:
        raise typer.Exit(1)
