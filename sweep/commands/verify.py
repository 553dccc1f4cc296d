"""Check atlases: `verify`."""

from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import AtlasFile


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
    from sweep.files.netcdf import save
    from sweep.files.paths import check_apart, check_target
    from sweep.files.reading import opened

    with opened(atlas) as dataset:
        if write is not None:
            check_apart(write, atlas)
            check_target(write, overwrite)
        audited = audit.verify(dataset)
    if write is not None:
        save(audited, write, overwrite=overwrite)
    found = audit.findings(audited)
    print(audit_text(found))
    if not found.passed:
        raise typer.Exit(1)
