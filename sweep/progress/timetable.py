"""Progress and remaining time of work in stages, each with a number of cells and a time per cell."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

#: Names of the stages that every sweep has.
COMPUTING: Final = "computing"
SEARCHING: Final = "searching the boundary"


@dataclass(frozen=True)
class Status:
    """The state of a run: `done` of `size` cells or other `things`, and the seconds to go, None if not known yet.

    The seconds are for this stage and all later ones.
    """

    stage: str
    done: int
    size: int
    seconds: float | None
    things: str = "cells"


@dataclass(frozen=True)
class Stage:
    """A stage of some work: its name, its number of cells, and the expected seconds per cell.

    `pace` is None for a stage that integrates cells: its time is not known in advance.
    """

    name: str
    cells: int
    pace: float | None = None


#: Called with every new status.
Show = Callable[[Status], object]

#: The argument `progress` of Python functions; see `sweep.progress.display.following`.
Progress = bool | Show | None


class Timetable:
    """The stages of some work, begun one after the other, and the remaining time.

    Parameters
    ----------
    stages : sequence of Stage
        In their order.
    show : callable
    clock : callable
        Returns a time [s].
    things : str
        The name of the things counted.
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
        """Begin the next stage with this name; cells that are done already do not count for its pace."""
        self._at = next(i for i in range(self._at + 1, len(self._stages)) if self._stages[i].name == name)
        self._began, self._before = self._clock(), done
        self.report(done)

    def measure_from(self, done: int) -> None:
        """Report the number of cells done, and measure the pace from here, after the kernels were compiled."""
        self._began, self._before = self._clock(), done
        self.report(done)

    def report(self, done: int) -> None:
        """Report the number of cells of the stage that are done."""
        stage, new = self._stages[self._at], done - self._before
        pace = (self._clock() - self._began) / new if new > 0 else self._pace(stage)
        if stage.pace is None and new > 0:
            self._integration = pace
        parts = [_time(stage.cells - done, pace)]
        parts += [_time(later.cells, self._pace(later)) for later in self._stages[self._at + 1 :]]
        known = [part for part in parts if part is not None]
        seconds = sum(known) if len(known) == len(parts) else None
        self._show(Status(stage.name, done, stage.cells, seconds, self._things))

    def _pace(self, stage: Stage) -> float | None:
        return self._integration if stage.pace is None else stage.pace


def _time(cells: int, pace: float | None) -> float | None:
    """Return the seconds for cells at a pace, None if it is not known; 0 for no cells."""
    return None if pace is None and cells > 0 else max(cells, 0) * (pace or 0.0)


def duration(seconds: float) -> str:
    """Return a time [s] as text, in the format of plans and progress."""
    if seconds < 120.0:
        return f"{seconds:.1f} s" if seconds < 9.95 else f"{seconds:.0f} s"
    if seconds < 7200.0:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h" if seconds < 172800.0 else f"{math.ceil(seconds / 8640) / 10:.1f} days"
