"""The stages of a run, and how long each takes of which that is known beforehand."""

import math
from typing import Final

from sweep.progress.timetable import COMPUTING, SEARCHING, Show, Stage, Timetable
from sweep.request.spec import SweepSpec

#: Seconds per cell to read and check a block of the journal; of one thread to derive, filter and write a cell; and to
#: check the file and synchronise it. Measured with 1e7 cells of 52 bytes on a busy machine.
_READING, _WRITING, CHECKING_PACE = 8e-8, 5e-7, 5e-8


#: Names of stages, beside those that every sweep has.
READING: Final = "reading what is there"
WRITING: Final = "writing"
CHECKING: Final = "checking"


def of_run(spec: SweepSpec, missing: int, threads: int | None, show: Show) -> Timetable:
    """Return the timetable of a run that has to compute `missing` of its cells.

    `threads` write all cells when the last one is computed; None if they are written while they are computed.
    """
    computing = [Stage(COMPUTING, spec.size)] if missing else []
    writing = [Stage(WRITING, spec.size, _WRITING / threads)] if threads else []
    return Timetable([*computing, *writing, *_last_stages(spec)], show)


def of_part(cells: int, show: Show) -> Timetable:
    """Return the timetable of a job that computes so many cells and leaves the file to another one."""
    return Timetable([Stage(READING, cells, _READING), Stage(COMPUTING, cells)], show)


def of_journal(spec: SweepSpec, threads: int, show: Show) -> Timetable:
    """Return the timetable of making the file of a run whose cells are all computed."""
    stages = [Stage(READING, spec.size, _READING), Stage(WRITING, spec.size, _WRITING / threads)]
    return Timetable([*stages, *_last_stages(spec)], show)


def _last_stages(spec: SweepSpec) -> list[Stage]:
    return [Stage(SEARCHING, bisected_cells(spec)), Stage(CHECKING, spec.size, CHECKING_PACE)]


def bisected_cells(spec: SweepSpec) -> int:
    """Return about how many cells the bisection of the boundary integrates: a bracket in every row."""
    width = spec.boundary_width
    if width is None:
        return 0
    cells = 0
    for axis in spec.model.controls(spec.axes):
        low, high = getattr(spec, axis).ends()
        count = len(getattr(spec, axis))
        halvings = math.log2(max(1.0, (high - low) / max(count - 1, 1) / width))
        cells += spec.size // count * math.ceil(halvings)
    # the edges, and in a plane the curves again
    return cells * (1 if len(spec.axes) < 2 else 2)
