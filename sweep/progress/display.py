"""Display of progress: a bar in a notebook or on a terminal, lines in a log, nothing in scripts and tests."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from importlib import import_module
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, TextIO

from sweep import notices
from sweep.errors import RequestError, shown
from sweep.progress.timetable import Progress, Show, Status, duration

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress as RichProgress

#: Seconds between two lines in a log, and between two updates of a bar in a notebook.
_LOG_INTERVAL, _NOTEBOOK_INTERVAL = 5.0, 0.1

#: Seconds after the expected end at which the display stops showing a time.
_LATE = 2.0

#: Text before the first stage: the first use of a kernel compiles it.
_FIRST = "compiling the kernels"

#: Seconds of work before a bar appears that nobody asked for.
_PATIENCE = 0.5


@contextmanager
def following(progress: Progress) -> Iterator[Show]:
    """Yield a function that shows the status of some work, as the argument `progress` of a Python function asks.

    Parameters
    ----------
    progress : bool, callable or None
        True: a bar in a notebook or on a terminal, otherwise lines on standard error. False: nothing.
        None: a bar in a notebook or an interactive session, after half a second of work; nothing in scripts and tests.
        A function is called with every `sweep.progress.timetable.Status`; its return value is ignored.

    Raises
    ------
    RequestError
        If `progress` is anything else.
    """
    if callable(progress):
        yield progress
        return
    if not isinstance(progress, bool) and progress is not None:
        raise RequestError(
            f"progress must be True, False, None or a function; got {shown(progress)}.",
            hint="Leave it out: notebooks and interactive sessions then show a bar.",
            where="progress",
        )
    in_notebook = _in_notebook()
    opened = _notebook if in_notebook else showing
    if progress:
        with _shown(opened, 0.0) as show:
            yield show
    elif progress is None and (in_notebook or _in_session()):
        with _shown(opened, _PATIENCE) as show:
            yield show
    else:
        yield lambda _: None


def _in_notebook() -> bool:
    """Return whether this code runs in the kernel of a notebook, which has imported IPython."""
    ipython: Any = sys.modules.get("IPython")
    shell = ipython.get_ipython() if hasattr(ipython, "get_ipython") else None
    return getattr(shell, "kernel", None) is not None


def _in_session() -> bool:
    """Return whether this interpreter is interactive with its standard error on a terminal."""
    return hasattr(sys, "ps1") and sys.stderr.isatty()


@contextmanager
def _shown(opened: Callable[[], AbstractContextManager[Show]], patience: float) -> Iterator[Show]:
    """Open a display after `patience` seconds of work; its last line is the total time."""
    began, show = time.monotonic(), None
    with ExitStack() as stack:

        def show_late(status: Status) -> None:
            nonlocal show
            if show is None and time.monotonic() - began >= patience:
                show = stack.enter_context(opened())
            if show is not None:
                show(status)

        yield show_late
        if show is not None:
            show(Status(f"finished after {duration(time.monotonic() - began)}", 1, 1, None))


@contextmanager
def showing(stream: TextIO | None = None, quiet: bool = False) -> Iterator[Show]:
    """Yield a function that shows the status of a run: a bar on a terminal, a line every few seconds in a log.

    The default stream is standard error. Shows nothing if `quiet`, or in a log if notices are not wanted.
    """
    stream = stream or sys.stderr
    if quiet or not (stream.isatty() or notices.are_wanted()):
        yield lambda _: None
        return
    with _bar(stream) if stream.isatty() else _log(stream) as show:
        yield show


class _Latest:
    """The latest status, and the text for the remaining time."""

    def __init__(self) -> None:
        self.status: Status | None = None
        self._at = 0.0

    def take(self, status: Status) -> None:
        """Replace the previous status."""
        self._at, self.status = time.monotonic(), status

    def to_go(self) -> str:
        """Return the remaining time of all stages as text; empty if it is not known, or if all is done."""
        if self.status is None or not self.status.seconds:
            return ""
        left = self.status.seconds - (time.monotonic() - self._at)
        if left < -_LATE:
            return "longer than expected"
        # unfinished work takes some time, whatever was expected
        return f"{duration(max(1.0, left))} to go"

    def line(self) -> str:
        """Return the line of a log."""
        if self.status is None:
            return f"{_utc()} {_FIRST}"
        done, size = self.status.done, self.status.size
        share = f" {done} of {size} {self.status.things} ({100 * done / size:.0f} %)" if size else ""
        return ", ".join(filter(None, (f"{_utc()} {self.status.stage}{share}", self.to_go())))


def _utc() -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(time.time()))


@contextmanager
def _log(stream: TextIO) -> Iterator[Show]:
    latest, ended = _Latest(), Event()

    def write() -> None:
        while not ended.wait(_LOG_INTERVAL):
            stream.write(f"eulerdisk: {latest.line()}\n")
            stream.flush()

    # a thread, because a block or the search for a boundary may take minutes without a status
    writer = Thread(target=write, daemon=True)
    writer.start()
    try:
        yield latest.take
    finally:
        ended.set()
        writer.join()


@contextmanager
def _bar(stream: TextIO) -> Iterator[Show]:
    from rich.console import Console

    bar, show = _rich_bar(Console(file=stream))
    with bar:
        yield show


@contextmanager
def _notebook() -> Iterator[Show]:
    """Show a bar in the output of the cell that is being executed; it stays there.

    It is drawn as HTML and replaced, because rich's own live display needs ipywidgets, which may be missing.
    """
    from rich.console import Console

    bar, take = _rich_bar(Console())
    # imported here: IPython may be missing without a notebook
    place: Any = import_module("IPython.display").display(bar.make_tasks_table(bar.tasks), display_id=True)
    drawn, stage = time.monotonic(), ""

    def draw() -> None:
        nonlocal drawn
        drawn = time.monotonic()
        place.update(bar.make_tasks_table(bar.tasks))

    def show(status: Status) -> None:
        nonlocal stage
        take(status)
        # every update is a message to the browser
        if status.stage != stage or time.monotonic() - drawn >= _NOTEBOOK_INTERVAL:
            stage = status.stage
            draw()

    try:
        yield show
    finally:
        draw()


def _rich_bar(console: "Console") -> "tuple[RichProgress, Show]":
    """Return a bar that is not shown yet, and a function that updates it with a status."""
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TaskProgressColumn, TextColumn
    from rich.text import Text

    latest = _Latest()

    class ToGo(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(latest.to_go())

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), ToGo())
    bar = Progress(*columns, console=console)
    task = bar.add_task(_FIRST, total=None)

    def show(status: Status) -> None:
        latest.take(status)
        bar.update(task, description=status.stage, completed=status.done, total=status.size or None)

    return bar, show
