"""Check atlases: `verify`."""

from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import AtlasFile
from sweep.errors import RequestError


def verify(
    atlas: AtlasFile,
    write: Annotated[
        Path | None, typer.Option("--write", metavar="AUDIT.nc", help="Store the differences in a new file.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace AUDIT.nc if it exists.")] = False,
) -> None:
    """Hold every cell of an atlas against the exact reduction.

    Exit status 0 if all cells agree within the tolerance that the atlas records, 1 otherwise.
    """
    from sweep.checks import audit
    from sweep.commands.report import audit_text
    from sweep.files import store
    from sweep.files.reading import opened

    with opened(atlas) as dataset:
        if write is not None:
            _check_apart(atlas, write)
            store.check_target(write, overwrite)
        audited = audit.verify(dataset)
    if write is not None:
        store.save(audited, write, overwrite=overwrite)
    found = audit.findings(audited)
    print(audit_text(found))
    if not found.passed:
        raise typer.Exit(1)


def _check_apart(atlas: Path, write: Path) -> None:
    if write.exists() and write.samefile(atlas):
        raise RequestError(
            "an audit does not replace its atlas",
            "--write names another file",
            str(write),
            "give it another name, e.g. audit.nc",
            "--write",
        )
