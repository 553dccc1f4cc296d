"""Progress display: lines in a log, a bar on a terminal and in a notebook, nothing in scripts and tests."""

import io
import re
import sys
import threading
import time
from types import SimpleNamespace

import pytest
from messages import assert_facts, assert_in_order, refused
from rich.console import Console

from sweep.progress import display
from sweep.progress.timetable import Status


class Terminal(io.StringIO):
    """A stream that claims to be a terminal."""

    def isatty(self):
        """Return True."""
        return True


@pytest.fixture(autouse=True)
def noticed(monkeypatch):
    """Allow log lines, which the tests otherwise switch off."""
    monkeypatch.delenv("EULERDISK_NOTICES")


@pytest.fixture
def clock(monkeypatch):
    """Return a clock that stands still until it is set; it shows 2026-01-02 03:04:05 UTC plus its seconds."""
    clock = [0.0]
    monkeypatch.setattr(display.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(display.time, "time", lambda: 1767323045.0 + clock[0])
    return clock


@pytest.fixture
def ticks(monkeypatch):
    """Let the test decide when the log writes its next line, instead of every few seconds."""

    class Ticks:
        def __init__(self):
            self.waiting, self.done, self.ended = threading.Semaphore(0), threading.Semaphore(0), False

        def wait(self, interval):
            assert interval == 5.0
            self.done.release()
            self.waiting.acquire()
            return self.ended

        def set(self):
            self.ended = True
            self.waiting.release()

        def line(self):
            self.done.acquire()
            self.waiting.release()
            self.done.acquire()
            self.done.release()

    ticks = Ticks()
    monkeypatch.setattr(display, "Event", lambda: ticks)
    return ticks


def test_a_log_gets_a_line_every_few_seconds(clock, ticks):
    """Each line has the time, the stage, the share done and the time to go.

    The time to go falls between reports, but is never "0 s" while work remains; work that takes seconds
    longer than expected is not repeatedly promised for the next second.
    """
    stream = io.StringIO()
    with display.showing(stream) as show:
        ticks.line()
        show(Status("computing", 0, 1000, None))
        ticks.line()
        show(Status("computing", 250, 1000, 61.2))
        clock[0] = 5.0
        ticks.line()
        clock[0] = 61.9
        ticks.line()
        clock[0] = 90.0
        ticks.line()
        show(Status("searching the boundary", 0, 0, 0.2))
        ticks.line()
        show(Status("checking", 1000, 1000, 0.0))
        ticks.line()
    expected = [
        ("04:05", ["compiling", "kernels"]),
        ("04:05", ["computing", "0 of 1000 cells", "0 %"]),
        ("04:10", ["computing", "250 of 1000 cells", "25 %", "56 s"]),
        ("05:06", ["computing", "250 of 1000 cells", "25 %", "1.0 s"]),
        ("05:35", ["computing", "250 of 1000 cells", "25 %", "longer"]),
        ("05:35", ["searching the boundary", "1.0 s"]),
        ("05:35", ["checking", "1000 of 1000 cells", "100 %"]),
    ]
    for line, (moment, facts) in zip(stream.getvalue().splitlines(), expected, strict=True):
        before, _, said = line.partition(f"2026-01-02T03:{moment}Z ")
        assert before == "eulerdisk: "
        assert_in_order(said, *facts)
        # No other time appears.
        assert re.findall(r"[\d.]+ s\b", said) == [each for each in facts if each.endswith(" s")]


def test_a_short_run_leaves_a_log_alone(monkeypatch):
    """A run that ends before the first line is due prints nothing and does not wait for it."""
    monkeypatch.setattr(display, "_LOG_INTERVAL", 300.0)
    stream, began = io.StringIO(), time.monotonic()
    with display.showing(stream) as show:
        show(Status("computing", 1000, 1000, 1.0))
    assert time.monotonic() - began < 100.0
    assert stream.getvalue() == ""


def test_each_line_of_a_log_is_there_at_once(clock, ticks):
    """Each line is flushed when written, so anyone following the log sees it."""
    flushed = []
    stream = io.StringIO()
    stream.flush = lambda: flushed.append(stream.getvalue())
    with display.showing(stream) as show:
        show(Status("computing", 1, 2, 10.0))
        ticks.line()
        assert flushed[-1].endswith("\n")
        assert_facts(flushed[-1], "10 s")


def test_without_notices_a_log_is_empty(ticks, monkeypatch):
    """EULERDISK_NOTICES=no keeps standard error empty, however long a run takes."""
    monkeypatch.setenv("EULERDISK_NOTICES", "no")
    stream = io.StringIO()
    with display.showing(stream) as show:
        show(Status("computing", 1, 2, 10.0))
    assert (stream.getvalue(), ticks.ended) == ("", False)


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()], ids=["log", "terminal"])
def test_quiet_is_quiet(ticks, stream):
    """`quiet` disables progress in a log and on a terminal."""
    with display.showing(stream, quiet=True) as show:
        show(Status("computing", 1, 2, 10.0))
    assert stream.getvalue() == ""


def test_a_terminal_gets_a_bar(monkeypatch):
    """The bar shows the share done; before the first block it says that kernels are compiling."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR")
    stream = Terminal()
    with display.showing(stream) as show:
        assert "compiling" in stream.getvalue()
        show(Status("computing", 25, 100, 42.0))
        time.sleep(0.5)
        show(Status("checking", 100, 100, 0.0))
    for words in ("computing", "25%", "42 s", "checking", "100%"):
        assert words in stream.getvalue()
    assert " 0 s" not in stream.getvalue()


def test_a_bar_gives_the_terminal_back_when_the_run_breaks(monkeypatch):
    """After an interrupt the cursor is visible again and the interrupt propagates."""
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()

    def break_off():
        with display.showing(stream) as show:
            show(Status("computing", 1, 100, None))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        break_off()
    assert stream.getvalue().rindex("\x1b[?25h") > stream.getvalue().rindex("\x1b[?25l")


#: The statuses of some longer work.
WORK = (Status("computing", 25, 100, 42.0), Status("computing", 75, 100, 14.0))


def typed_at(monkeypatch):
    """Return the terminal of an interactive session; no fixture, because pytest replaces its streams."""
    stream = Terminal()
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "ps1", ">>> ", raising=False)
    monkeypatch.setattr(sys, "stderr", stream)
    return stream


def followed(progress, clock, seconds=1.0):
    """Work for some seconds between two statuses."""
    with display.following(progress) as show:
        show(WORK[0])
        clock[0] += seconds
        show(WORK[1])


def test_a_function_gets_every_status(clock):
    """It is called with each status, and its return value is ignored."""
    heard = []
    followed(lambda status: heard.append(status) or 1 / 2, clock)
    assert tuple(heard) == WORK


@pytest.mark.parametrize(("progress", "seconds"), [(None, 1.0), (True, 0.0)], ids=["by itself", "asked for"])
def test_somebody_who_types_sees_a_bar(monkeypatch, clock, progress, seconds):
    """It appears after half a second by default, at once if requested, and ends with the total time."""
    session = typed_at(monkeypatch)
    followed(progress, clock, seconds)
    for words in (f"finished after {seconds:.1f} s", "100%"):
        assert words in session.getvalue()


@pytest.mark.parametrize(("progress", "seconds"), [(None, 0.4), (False, 9.0)], ids=["short", "not wanted"])
def test_short_work_leaves_no_trace(monkeypatch, clock, progress, seconds):
    """Neither does longer work if no bar is wanted."""
    session = typed_at(monkeypatch)
    followed(progress, clock, seconds)
    assert session.getvalue() == ""


@pytest.mark.parametrize("stream", [Terminal(), io.StringIO()], ids=["terminal", "log"])
def test_a_script_is_not_spoken_to(monkeypatch, clock, stream):
    """Without an interactive session nothing is shown by default, even on a terminal."""
    monkeypatch.delattr(sys, "ps1", raising=False)
    monkeypatch.setattr(sys, "stderr", stream)
    followed(None, clock, 100.0)
    assert stream.getvalue() == ""


def test_a_script_that_asks_gets_the_lines_of_a_log(monkeypatch, clock, ticks):
    """True gives people a bar and logs their lines, as on the command line."""
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with display.following(True) as show:
        show(WORK[0])
        ticks.line()
    (line,) = stream.getvalue().splitlines(keepends=True)
    assert line.endswith("\n")
    assert_in_order(line, "2026-01-02T03:04:05Z", "25 of 100 cells", "25 %", "42 s")


def test_another_wish_is_refused():
    """The message lists the allowed values."""
    for wrong in ["yes", 1, []]:
        with refused("progress", "True", "False", "None"):
            display.following(wrong).__enter__()


def test_work_that_breaks_is_not_finished(monkeypatch, clock):
    """The error propagates, and the bar does not claim completion."""
    session = typed_at(monkeypatch)

    def work():
        with display.following(True) as show:
            show(WORK[0])
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        work()
    assert "computing" in session.getvalue()
    assert "finished" not in session.getvalue()


def test_a_notebook_has_one_bar_that_is_replaced(monkeypatch, clock):
    """It updates at most ten times a second, at once for a new stage, and ends with the last status."""
    pictures = []

    def drawn(bar):
        text = io.StringIO()
        Console(file=text, width=120).print(bar)
        return text.getvalue()

    def show_first(bar, display_id):
        pictures.append(drawn(bar))
        return SimpleNamespace(update=lambda later: pictures.append(drawn(later)))

    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=show_first))
    monkeypatch.setattr(display, "_in_notebook", lambda: True)
    with display.following(True) as show:
        for done in range(5):
            clock[0] += 0.03
            show(Status("integrating", 10 * done, 200, None))
        assert len(pictures) == 3
        show(Status("writing", 25, 200, None))
        assert len(pictures) == 4
        show(Status("writing", 150, 200, None))
        assert len(pictures) == 4
    assert_facts(pictures[1], "integrating")
    assert_facts(pictures[3], "writing")
    assert_facts(pictures[-1], "100%")
