import io

import pytest

from sweep.commands import progress


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self):
        """Say so."""
        return True


@pytest.fixture
def clock(monkeypatch):
    """Return a clock that stands still until it is set."""
    clock = [1000.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    return clock


def test_a_log_gets_a_line_now_and_then(clock):
    """In a log, at most every ten seconds, one line says how far the run is and how long it will take.

    The pace is that since the first report, here at 1 s: 240 cells in 19.5 s leave 60.9 s for the other 750.
    """
    stream = io.StringIO()
    with progress.reporting(stream) as report:
        for second, done in [(1, 10), (9.9, 99), (10, 100), (12, 120), (19.9, 190), (20.5, 250), (40, 1000)]:
            clock[0] = 1000.0 + second
            report(done, 1000)
    assert stream.getvalue().splitlines() == [
        "eulerdisk: 100 of 1000 cells (10 %), 90 s to go",
        "eulerdisk: 250 of 1000 cells (25 %), 61 s to go",
        "eulerdisk: 1000 of 1000 cells (100 %), 0 s to go",
    ]


def test_blocks_of_an_earlier_run_do_not_count_as_pace(clock):
    """A run that goes on from 900 of 1000 cells, and needs 10 s for 10 more, has 90 s to go, not 1."""
    stream = io.StringIO()
    with progress.reporting(stream) as report:
        report(900, 1000)
        clock[0] += 10.0
        report(910, 1000)
    assert stream.getvalue() == "eulerdisk: 910 of 1000 cells (91 %), 90 s to go\n"


def test_a_short_run_leaves_a_log_alone(clock):
    """A run of less than ten seconds says nothing on the way."""
    stream = io.StringIO()
    with progress.reporting(stream) as report:
        clock[0] += 9.0
        report(1000, 1000)
    assert stream.getvalue() == ""


def test_each_line_of_a_log_is_there_at_once(clock):
    """A line is flushed when it is written: whoever follows the log sees it."""
    flushed = []
    stream = io.StringIO()
    stream.flush = lambda: flushed.append(stream.getvalue())
    with progress.reporting(stream) as report:
        clock[0] += 10.0
        report(1, 2)
        assert flushed[-1].endswith("10 s to go\n")


def test_standard_error_is_the_usual_stream(capsys, clock):
    """Without a stream it is standard error: results on standard output stay clean."""
    with progress.reporting() as report:
        clock[0] += 10.0
        report(5, 10)
    out, err = capsys.readouterr()
    assert (out, err) == ("", "eulerdisk: 5 of 10 cells (50 %), 10 s to go\n")


def test_a_terminal_gets_a_bar(monkeypatch):
    """On a terminal a bar shows the share that is done; before the first block it says what is waited for."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR")
    stream = Terminal()
    with progress.reporting(stream) as report:
        assert "preparing" in stream.getvalue()
        report(25, 100)
        report(100, 100)
    assert "cells" in stream.getvalue()
    assert "100%" in stream.getvalue()
    assert "0 s to go" in stream.getvalue()


def test_a_bar_gives_the_terminal_back_when_the_run_breaks(monkeypatch):
    """After an interrupt the cursor is shown again and the interrupt goes on."""
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()

    def break_off():
        with progress.reporting(stream) as report:
            report(1, 100)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        break_off()
    assert stream.getvalue().rindex("\x1b[?25h") > stream.getvalue().rindex("\x1b[?25l")


@pytest.mark.parametrize(
    ("elapsed", "done", "to_go"), [(10.0, 1, 9990.0), (10.0, 500, 10.0), (7.0, 1000, 0.0)]
)
def test_the_rest_takes_as_long_as_what_is_done(elapsed, done, to_go):
    """The time to go is that of the cells done, per cell, times the cells to go."""
    assert progress.remaining(elapsed, done, 1000) == pytest.approx(to_go, rel=1e-15)
