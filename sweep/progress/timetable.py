"""How far some work is, and how long it will take: its stages, each as long as its cells take."""

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

    `pace` is None for a stage that integrates cells: how long that takes is not known beforehand.
    """

    name: str
    cells: int
    pace: float | None = None


#: Called with every new status.
Show = Callable[[Status], object]

#: How a Python function is asked for its progress; see `sweep.progress.display.following`.
Progress = bool | Show | None


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

    def measure_from(self, done: int) -> None:
        """Show how many cells of the stage are done, and measure its pace from here: before, kernels were compiled."""
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


def duration(seconds: float) -> str:
    """Return a time [s] for people: plans and progress use the same format."""
    if seconds < 120.0:
        return f"{seconds:.1f} s" if seconds < 9.95 else f"{seconds:.0f} s"
    if seconds < 7200.0:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h" if seconds < 172800.0 else f"{math.ceil(seconds / 8640) / 10:.1f} days"
