"""What a run takes, before anything is computed: bytes on disk and in memory, seconds, in words for people."""

import math
import shutil
from collections.abc import Collection
from pathlib import Path

import numpy as np

from sweep.engine.blocks import MOST_BLOCK_CELLS
from sweep.errors import RequestError
from sweep.request.spec import SweepSpec
from sweep.schema import PARAMETERS
from sweep.schema.exact import DERIVED, atlas_variables

#: An atlas compresses to about this share of its cells' bytes at most (measured: 0.3 to 0.75).
FILE_SHARE = 0.8

#: A crash costs the blocks in the making: of about this many seconds.
_BLOCK_SECONDS = 1.5

#: Cells per second that one thread writes to the file, packed (measured: 0.7 to 1.3 million).
_FILE_CELLS_PER_SECOND = 1e6

#: Bytes of a process that holds the compiler and the libraries of files, before it has a cell.
_PROCESS_BYTES = 270e6

#: Bytes per cell of a block in all its stages at once: being computed, being written, being compressed.
_STAGES_BYTES = 500

#: Bytes per cell of the whole grid: its verdicts, and what the search for the boundary makes of them.
_GRID_BYTES = 6


def cell_bytes(spec: SweepSpec, without: Collection[str] = ()) -> int:
    """Return the bytes of one cell's variables, without those that are named."""
    kinds = {name: each.dtype for name, each in atlas_variables(spec.method, spec.contact).items()}
    if spec.computed_rate is not None:
        kinds[spec.computed_rate] = PARAMETERS[spec.computed_rate].dtype
    return sum(np.dtype(kind).itemsize for name, kind in kinds.items() if name not in without)


def journal_bytes(spec: SweepSpec, cells: int) -> float:
    """Return the bytes that finished blocks of so many cells take on disk, at most: of what repeats they have less."""
    return 1.01 * cells * cell_bytes(spec, DERIVED) + 1e4


def file_bytes(spec: SweepSpec) -> float:
    """Return the bytes of the finished file, at most."""
    return FILE_SHARE * spec.size * cell_bytes(spec) + 1e5


def memory_bytes(spec: SweepSpec, block_cells: int = MOST_BLOCK_CELLS) -> float:
    """Return the resident bytes of a run at their largest."""
    return _PROCESS_BYTES + _STAGES_BYTES * min(block_cells, spec.size) + _GRID_BYTES * spec.size


def run_bytes(spec: SweepSpec) -> float:
    """Return the bytes on disk at the end of a run, when the journal and the file are both there, at most."""
    return journal_bytes(spec, spec.size) + file_bytes(spec)


def block_cells(rate: float, least: int) -> int:
    """Return the cells of a block, a multiple of `least`, at `rate` cells per second."""
    wanted = int(rate * _BLOCK_SECONDS) // least * least
    return min(max(wanted, least), max(MOST_BLOCK_CELLS, least))


def seconds(cells: int, rate: float, threads: int, processors: int) -> float:
    """Return how long a run takes [s].

    Parameters
    ----------
    cells : int
    rate : float
        Cells per second that `threads` compute.
    threads, processors : int
        One more thread writes the file while these compute the next blocks, on the processors that there are.
    """
    computing, writing = cells / rate, cells / _FILE_CELLS_PER_SECOND
    return max(computing, writing, (min(threads, processors) * computing + writing) / processors)


def describe(
    spec: SweepSpec, path: Path, rate: float | None, cells: int | None, threads: int = 1, processors: int = 1
) -> list[str]:
    """Return what a run takes, one line each: cells, blocks, time, memory, disk.

    Parameters
    ----------
    spec : SweepSpec
    path : Path
        The file of the end.
    rate : float or None
        Cells per second, if they were measured.
    cells : int or None
        Cells of a block, if they are decided.
    threads, processors : int
        As in `seconds`.
    """
    most = cells or MOST_BLOCK_CELLS
    shape = " x ".join(map(str, spec.shape)) or "one"
    blocks = f"{math.ceil(spec.size / most)} of {min(most, spec.size)} cells"
    time = "not measured"
    if rate is not None:
        expected = seconds(spec.size, rate, threads, processors)
        time = f"about {duration(expected)} ({rate:.3g} cells per second)"
    free = _free(path)
    room = f"{size(free)} free" if math.isfinite(free) else "nobody knows how much is free"
    return [
        f"cells    {spec.size} ({shape})",
        f"blocks   {blocks}" if cells else f"blocks   at least {blocks} at most",
        f"time     {time}",
        f"memory   about {size(memory_bytes(spec, most))}",
        f"disk     at most {size(journal_bytes(spec, spec.size))} for the journal, which goes at the end, and at most "
        f"{size(file_bytes(spec))} for the file; {room} in {path.parent.resolve()}",
    ]


def check_room(path: Path, needed: float) -> None:
    """Refuse what does not fit the disk.

    Parameters
    ----------
    path : Path
        A file on that disk, which need not exist; its folder does.
    needed : float
        Bytes to be written.

    Raises
    ------
    RequestError
    """
    free = _free(path)
    if needed > free:
        raise RequestError(
            "the atlas does not fit on the disk",
            f"about {size(needed)} are free for the file and the journal that it is made from",
            f"{size(free)} free in {path.parent.resolve()}",
            f"free {size(needed - free)}, use fewer cells or another disk",
            str(path),
        )


def _free(path: Path) -> float:
    # a file system that has no size does not say what it takes: /proc takes nothing, some network mounts anything
    usage = shutil.disk_usage(path.parent)
    return usage.free if usage.total else math.inf


def size(count: float) -> str:
    """Return a number of bytes for people."""
    for factor, unit in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB")):
        if count >= 10 * factor:
            return f"{count / factor:.0f} {unit}"
    return f"{count / 1e6:.1f} MB"


def duration(time: float) -> str:
    """Return a time for people: what `plan` expects and what `run` has to go are told alike."""
    if time < 120.0:
        return f"{time:.0f} s"
    if time < 7200.0:
        return f"{time / 60:.0f} min"
    return f"{time / 3600:.1f} h" if time < 172800.0 else f"{math.ceil(time / 8640) / 10:.1f} days"
