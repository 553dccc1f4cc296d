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
    from sweep import store
    from sweep.audit import audit, findings
    from sweep.report import audit_text

    with store.open_atlas(atlas) as dataset:
        if write is not None:
            store.check_target(write, overwrite, 2.0 * dataset.nbytes)
        audited = audit(dataset)
    if write is not None:
        store.save(audited, write, overwrite=overwrite)
    found = findings(audited)
    print(audit_text(found))
    if not found.passed:
        raise typer.Exit(1)
