"""Unfinished runs: their progress, and an atlas of their finished blocks."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sweep.atlas.cf_metadata import cell_declarations
from sweep.engine.compute import Block, derive_block, usable_threads
from sweep.engine.grid import starts_of
from sweep.errors import counted
from sweep.files.atlas_writer import AtlasWriter
from sweep.files.paths import check_target
from sweep.files.publish import check_room, published, size
from sweep.runs.executor import no_op
from sweep.runs.forecast import file_bytes, of_run
from sweep.runs.journal import DamagedBlockError, Journal
from sweep.runs.run import attributes_of, write_atlas
from sweep.runs.run_directory import check_same_run


def describe(folder: Path) -> str:
    """Return the progress of a run in words."""
    journal = Journal.at(folder)
    spec, finished = journal.spec, journal.held()
    done = journal.cells(finished)
    taken = 0
    for paths in finished.values():
        # another process may finish the run and remove the file at any time
        with contextlib.suppress(FileNotFoundError):
            taken += paths[0].stat().st_size
    return "\n".join(
        [
            f"{folder}: an unfinished run",
            f"blocks      {len(finished)} of {len(journal.spans)}, {counted(done, 'cell', spec.size)} "
            f"({100 * done / spec.size:.0f} %), {size(taken)}",
            f"begun       {journal.manifest.created} {journal.manifest.command}",
            f"program     {', '.join(f'{name} {text[:16]}' for name, text in journal.manifest.arithmetic.items())}",
        ]
    )


def write_partial(folder: Path, path: Path) -> tuple[int, int]:
    """Write an atlas of the finished blocks; the cells of other blocks are marked as not computed.

    The folder of the run is only read, because another process may be computing its blocks. Returns the number of
    finished cells, and the number of all cells.
    """
    journal = Journal.at(folder)
    spec = journal.spec
    # the file will state that this program made it
    check_same_run(journal, spec)
    check_target(path, False)
    check_room(path, file_bytes(spec))
    done: list[int] = []
    finished = journal.held()
    attributes = attributes_of(journal.manifest) | {
        "comment": f"Partial: {counted(len(finished), 'block', len(journal.spans))}; the other cells are not computed."
    }
    with published(path) as temporary:
        writer = AtlasWriter(temporary, spec, attributes, usable_threads(None))
        cells = writer.write_cells(_fill_missing(journal, finished, done))
        write_atlas(writer, cells, of_run(spec, 0, None, no_op))
    return sum(done), spec.size


def _fill_missing(journal: Journal, finished: dict[int, list[Path]], done: list[int]) -> Iterator[Block]:
    """Yield all blocks, missing ones without values, and append the numbers of cells of finished ones to `done`."""
    for number, span in enumerate(journal.spans):
        try:
            measured = journal.read(number, finished.get(number, ()))
        except DamagedBlockError:
            # 0 is the ending not_computed, and the verdict undecided
            empty = {
                variable.name: np.full(
                    len(span), np.nan if variable.dtype.startswith("f") else 0, variable.dtype
                )
                for variable in cell_declarations(journal.spec)
            }
            starts = starts_of(journal.spec, span)
            yield Block(span, empty | {name: starts[name] for name in journal.spec.listed})
        else:
            done.append(len(span))
            yield Block(span, derive_block(journal.spec, span, measured))
