"""A look at a run that is not finished: how far it is, and an atlas of what there is."""

import contextlib
import json
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sweep.atlas import declarations
from sweep.engine import estimate
from sweep.engine.blocks import Span
from sweep.engine.runner import Block
from sweep.files import store
from sweep.runs.claims import check_same
from sweep.runs.journal import MANIFEST, SUFFIX, DamagedBlockError, Journal
from sweep.runs.manifest import Manifest


def unfinished(path: Path) -> Path | None:
    """Return the folder of the run that is to make a file, or that is given itself; None if there is none."""
    for folder in (path, path.parent / (path.name + SUFFIX)):
        if os.path.isfile(folder / MANIFEST):
            return folder
    return None


def describe(folder: Path) -> str:
    """Return how far a run is, in words.

    Raises
    ------
    RequestError
        If its manifest is damaged.
    """
    book = Journal.at(folder)
    spec, held = book.manifest.spec, book.held()
    done = sum(len(book.spans[number]) for number in held)
    taken = 0
    for paths in held.values():
        # the run may be going on, and done at any moment
        with contextlib.suppress(FileNotFoundError):
            taken += paths[0].stat().st_size
    return "\n".join(
        [
            f"{folder}: a run that is not finished",
            f"blocks      {len(held)} of {len(book.spans)}, {done} of {spec.size} cells "
            f"({100 * done / spec.size:.0f} %), {estimate.size(taken)}",
            f"begun       {book.manifest.created} {book.manifest.command}",
            f"program     {', '.join(f'{name} {text[:16]}' for name, text in book.manifest.arithmetic.items())}",
        ]
    )


def write_partial(folder: Path, path: Path, *, overwrite: bool = False) -> tuple[int, int]:
    """Write an atlas of the blocks that there are; the cells of the others are marked as not computed.

    Parameters
    ----------
    folder : Path
        The run's folder, which is only read: the run may be going on.
    path : Path
        The file; it appears only when it is complete.
    overwrite : bool

    Returns
    -------
    (done, cells) : int
        Cells that were there, and cells in all.

    Raises
    ------
    RequestError
        If the file exists or cannot be written, the manifest is damaged, or the run is another program's.
    """
    book = Journal.at(folder)
    manifest = book.manifest
    # the file will say that this program made it
    check_same(book, manifest.spec)
    store.check_target(path, overwrite)
    estimate.check_room(path, estimate.file_bytes(manifest.spec))
    done: list[int] = []
    held = book.held()
    attributes = declarations.global_attributes(manifest.spec, manifest.command, manifest.created)
    attributes["versions"] = json.dumps(manifest.versions, sort_keys=True)
    attributes["comment"] = (
        f"Partial: {len(held)} of {len(book.spans)} blocks; the other cells are not computed."
    )
    with store.published(path) as nearly:
        store.write(manifest.spec, nearly, _filled_up(book, held, done), attributes)
    return sum(done), manifest.spec.size


def _filled_up(book: Journal, held: dict[int, list[Path]], done: list[int]) -> Iterator[Block]:
    for number in range(len(book.spans)):
        try:
            # of two results for one block neither is trusted
            (path,) = held[number]
            block = book.read(number, path)
            done.append(len(block.span))
        except (KeyError, ValueError, DamagedBlockError):
            block = _not_computed(book.manifest, book.spans[number])
        yield block


def _not_computed(manifest: Manifest, span: Span) -> Block:
    kinds = {each.name: each.dtype for each in declarations.cell_declarations(manifest.spec)}
    # 0 is not_computed among the endings, and undecided among the verdicts
    empty = {name: np.nan if kind.startswith("f") else 0 for name, kind in kinds.items()}
    return Block(span, {name: np.full(len(span), empty[name], kind) for name, kind in kinds.items()})
