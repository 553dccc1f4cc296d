"""Atlases in other formats: `export`."""

from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import AtlasFile


def export(
    atlas: AtlasFile,
    *,
    kind: Annotated[str, typer.Option("--to", metavar="FORMAT", help="csv, parquet or zarr.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="OUT", help="What to write; beside the atlas, if not given."),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace OUT if it exists.")] = False,
) -> None:
    """Write an atlas as a table of cells (csv, parquet) or as zarr."""
    from sweep.files.export import export as exported
    from sweep.files.paths import check_apart
    from sweep.files.reading import opened

    target = output or atlas.with_suffix(f".{kind}")
    with opened(atlas) as dataset:
        check_apart(target, atlas)
        exported(dataset, target, kind, overwrite=overwrite)
