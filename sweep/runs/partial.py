"""An unfinished run: how far it is, and an atlas of its finished blocks."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sweep.atlas.cf_metadata import cell_declarations
from sweep.engine import estimate
from sweep.engine.compute import Block, derive_block
from sweep.engine.grid import Span
from sweep.files.paths import check_target
from sweep.files.publish import published
from sweep.request.spec import SweepSpec
from sweep.runs.journal import DamagedBlockError, Journal
from sweep.runs.manifest import MANIFEST
from sweep.runs.run import attributes_of, write_atlas
from sweep.runs.run_directory import check_same_run, directory_of


def unfinished(path: Path) -> Path | None:
    """Return the folder of the unfinished run that makes a file, or that is given itself; None if there is none."""
    for folder in (path, directory_of(path)):
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
    journal = Journal.at(folder)
    spec, held = journal.spec, journal.held()
    done = sum(len(journal.spans[number]) for number in held)
    taken = 0
    for paths in held.values():
        # another process may be going on with the run, and end it at any moment
        with contextlib.suppress(FileNotFoundError):
            taken += paths[0].stat().st_size
    return "\n".join(
        [
            f"{folder}: a run that is not finished",
            f"blocks      {len(held)} of {len(journal.spans)}, {done} of {spec.size} cells "
            f"({100 * done / spec.size:.0f} %), {estimate.size(taken)}",
            f"begun       {journal.manifest.created} {journal.manifest.command}",
            f"program     {', '.join(f'{name} {text[:16]}' for name, text in journal.manifest.arithmetic.items())}",
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
    journal = Journal.at(folder)
    manifest = journal.manifest
    # the file will state that this program made it
    check_same_run(journal, manifest.spec)
    check_target(path, overwrite)
    estimate.check_room(path, estimate.file_bytes(manifest.spec))
    done: list[int] = []
    held = journal.held()
    attributes = attributes_of(manifest) | {
        "comment": f"Partial: {len(held)} of {len(journal.spans)} blocks; the other cells are not computed."
    }
    with published(path) as temporary:
        write_atlas(temporary, manifest.spec, attributes, _filled_up(journal, held, done))
    return sum(done), manifest.spec.size


def _filled_up(journal: Journal, held: dict[int, list[Path]], done: list[int]) -> Iterator[Block]:
    for number, span in enumerate(journal.spans):
        try:
            measured = journal.read(number, held.get(number, ()))
        except DamagedBlockError:
            yield _not_computed(journal.spec, span)
        else:
            done.append(len(span))
            yield Block(span, derive_block(journal.spec, span, measured))


def _not_computed(spec: SweepSpec, span: Span) -> Block:
    kinds = {each.name: each.dtype for each in cell_declarations(spec)}
    # 0 is not_computed among the endings, and undecided among the verdicts
    empty = {name: np.nan if kind.startswith("f") else 0 for name, kind in kinds.items()}
    return Block(span, {name: np.full(len(span), empty[name], kind) for name, kind in kinds.items()})
