"""How far a run is, and how long it will take: the stages of its work, each as long as its cells take."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from sweep.request.spec import SweepSpec

#: Seconds per cell to read and check a block of the journal; of one thread to derive, filter and write a cell; and to
#: check the file and synchronise it. Measured with 1e7 cells of 52 bytes on a busy machine.
_READING, _WRITING, CHECKING_PACE = 8e-8, 5e-7, 5e-8


@dataclass(frozen=True)
class Status:
    """What a run is doing: `done` of `size` cells or other `things`, and the seconds to go, None if not known yet.

    The seconds are those of this stage and of all that follow.
    """

    stage: str
    done: int
    size: int
    seconds: float | None
    things: str = "cells"


@dataclass(frozen=True)
class Stage:
    """A stage of some work: its name, how many cells it goes through, and the seconds expected for one.

    `pace` is None for a stage that integrates cells: nobody knows beforehand how long that takes.
    """

    name: str
    cells: int
    pace: float | None = None


#: Called with every new status.
Show = Callable[[Status], None]


class Timetable:
    """The stages of some work, of which one after the other is begun, and what is left of them.

    Parameters
    ----------
    stages : sequence of Stage
        In the order in which they come.
    show : callable
    clock : callable
        Returns a time [s].
    things : str
        What is counted.
    """

    def __init__(
        self,
        stages: Sequence[Stage],
        show: Show,
        clock: Callable[[], float] = time.monotonic,
        things: str = "cells",
    ) -> None:
        self._stages, self._show, self._clock, self._things = list(stages), show, clock, things
        self._at = -1
        #: Seconds per cell of the integrations so far.
        self._integration: float | None = None

    def begin(self, name: str, done: int = 0) -> None:
        """Begin the next stage of this name; cells that are done already tell nothing of its pace."""
        self._at = next(i for i in range(self._at + 1, len(self._stages)) if self._stages[i].name == name)
        self._began, self._before = self._clock(), done
        self.report(done)

    def report(self, done: int) -> None:
        """Show how many cells of the stage are done."""
        stage, new = self._stages[self._at], done - self._before
        pace = (self._clock() - self._began) / new if new > 0 else self._pace(stage)
        if stage.pace is None and new > 0:
            self._integration = pace
        parts = [_time(stage.cells - done, pace)]
        parts += [_time(each.cells, self._pace(each)) for each in self._stages[self._at + 1 :]]
        known = [part for part in parts if part is not None]
        seconds = sum(known) if len(known) == len(parts) else None
        self._show(Status(stage.name, done, stage.cells, seconds, self._things))

    def _pace(self, stage: Stage) -> float | None:
        return self._integration if stage.pace is None else stage.pace


def _time(cells: int, pace: float | None) -> float | None:
    """Return the seconds that cells take at a pace, None if it is not known; no cells take none."""
    return None if pace is None and cells > 0 else max(cells, 0) * (pace or 0.0)


#: Names of the stages of a run.
READING: Final = "reading what is there"
COMPUTING: Final = "computing"
WRITING: Final = "writing"
SEARCHING: Final = "searching the boundary"
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
