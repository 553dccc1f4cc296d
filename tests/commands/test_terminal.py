"""Progress on a terminal and in a log; signals: what is computed is kept, and the message says how to continue."""

import contextlib
import io
import os
import shlex
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from sweep.cli import main
from sweep.commands import terminal
from sweep.runs import executor
from sweep.runs.progress import Status

CHECKOUT = Path(__file__).parents[2]
LONG = ["rolling", "roll_rate=0.5:6:4000", "tilt=0.01deg:20deg:4000", "--block-cells", "20000"]
SMALL = "run rolling roll_rate=2:4:9 tilt=0.1deg,1deg --block-cells 5 -o a.nc"


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self):
        """Say so."""
        return True


@pytest.fixture
def clock(monkeypatch):
    """Return a clock that stands still until it is set, and shows 2026-01-02 03:04:05 UTC plus its seconds."""
    clock = [0.0]
    monkeypatch.setattr(terminal.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(terminal.time, "time", lambda: 1767323045.0 + clock[0])
    return clock


@pytest.fixture
def ticks(monkeypatch):
    """Let a log write its next line when the test says so, instead of every few seconds."""

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
    monkeypatch.setattr(terminal, "Event", lambda: ticks)
    return ticks


def test_a_log_gets_a_line_every_few_seconds(clock, ticks):
    """Each line says when it was written, what is being done, how far it is, and how long all will take from then on.

    Between two reports the time to go becomes shorter, but as long as there is something to do it is not "0 s".
    """
    stream = io.StringIO()
    with terminal.showing(stream) as show:
        ticks.line()
        show(Status("computing", 0, 1000, None))
        ticks.line()
        show(Status("computing", 250, 1000, 61.2))
        clock[0] = 5.0
        ticks.line()
        clock[0] = 90.0
        ticks.line()
        show(Status("searching the boundary", 0, 0, 0.2))
        ticks.line()
        show(Status("checking", 1000, 1000, 0.0))
        ticks.line()
    assert stream.getvalue().splitlines() == [
        "eulerdisk: 2026-01-02T03:04:05Z preparing",
        "eulerdisk: 2026-01-02T03:04:05Z computing 0 of 1000 cells (0 %)",
        "eulerdisk: 2026-01-02T03:04:10Z computing 250 of 1000 cells (25 %), 56 s to go",
        "eulerdisk: 2026-01-02T03:05:35Z computing 250 of 1000 cells (25 %), 1.0 s to go",
        "eulerdisk: 2026-01-02T03:05:35Z searching the boundary, 1.0 s to go",
        "eulerdisk: 2026-01-02T03:05:35Z checking 1000 of 1000 cells (100 %)",
    ]


def test_a_short_run_leaves_a_log_alone():
    """A run of less than five seconds says nothing on the way, and does not wait for them."""
    stream, began = io.StringIO(), time.monotonic()
    with terminal.showing(stream) as show:
        show(Status("computing", 1000, 1000, 1.0))
    assert time.monotonic() - began < 4.0
    assert stream.getvalue() == ""


def test_each_line_of_a_log_is_there_at_once(clock, ticks):
    """A line is flushed when it is written: whoever follows the log sees it."""
    flushed = []
    stream = io.StringIO()
    stream.flush = lambda: flushed.append(stream.getvalue())
    with terminal.showing(stream) as show:
        show(Status("computing", 1, 2, 10.0))
        ticks.line()
        assert flushed[-1].endswith("10 s to go\n")


def test_standard_error_is_the_usual_stream(capsys, clock, ticks):
    """Without a stream it is standard error: results on standard output stay clean."""
    with terminal.reporting(what="frames") as report:
        report(0, 10)
        clock[0] = 10.0
        report(5, 10)
        ticks.line()
    out, err = capsys.readouterr()
    assert (out, err) == ("", "eulerdisk: 2026-01-02T03:04:15Z computing 5 of 10 frames (50 %), 10 s to go\n")


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()], ids=["log", "terminal"])
def test_quiet_is_quiet(ticks, stream):
    """Whoever asks for no progress gets none, in a log and on a terminal."""
    with terminal.showing(stream, quiet=True) as show, terminal.reporting(stream, quiet=True) as report:
        show(Status("computing", 1, 2, 10.0))
        report(1, 2)
    assert stream.getvalue() == ""


@pytest.mark.parametrize("line", ["run {} -o a.nc", "block --run a.nc.run --part 1/1", "assemble a.nc.run"])
def test_commands_can_be_quiet(command, monkeypatch, line):
    """Each command with progress has the option."""
    asked = []

    @contextlib.contextmanager
    def showing(quiet):
        asked.append(quiet)
        yield lambda _: None

    words = SMALL.removeprefix("run ").removesuffix(" -o a.nc")
    assert command(f"prepare {words} -o a.nc")[0] == 0
    if line.startswith("assemble"):
        assert command("block --run a.nc.run --part 1/1")[0] == 0
    monkeypatch.setattr("sweep.commands.run.showing", showing)
    assert command(line.format(words) + " --quiet")[0] == 0
    assert asked == [True]


def test_a_terminal_gets_a_bar(monkeypatch):
    """On a terminal a bar shows the share that is done; before the first block it says what is waited for."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR")
    stream = Terminal()
    with terminal.showing(stream) as show:
        assert "preparing" in stream.getvalue()
        show(Status("computing", 25, 100, 42.0))
        time.sleep(0.5)
        show(Status("checking", 100, 100, 0.0))
    for words in ("computing", "25%", "42 s to go", "checking", "100%"):
        assert words in stream.getvalue()
    assert " 0 s to go" not in stream.getvalue()


def test_a_bar_gives_the_terminal_back_when_the_run_breaks(monkeypatch):
    """After an interrupt the cursor is shown again and the interrupt goes on."""
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()

    def break_off():
        with terminal.reporting(stream) as report:
            report(1, 100)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        break_off()
    assert stream.getvalue().rindex("\x1b[?25h") > stream.getvalue().rindex("\x1b[?25l")


def started(words, folder):
    """Start a run as a process, and wait until its first block is kept."""
    process = subprocess.Popen(
        [sys.executable, "-m", "sweep", "run", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 60
    while not list(folder.glob("*.run/blocks/*.block")) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert process.poll() is None
    return process


def blocks(folder):
    """Return the names of what is kept."""
    return {each.name for each in folder.glob("a.nc.run/blocks/*")}


@pytest.mark.compiled
@pytest.mark.parametrize("existing", [False, True], ids=["new", "overwrite"])
@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["INT", "TERM"]
)
def test_a_signal_keeps_what_is_computed(tmp_path, number, status, existing):
    """A signal ends a long run soon with its own status; blocks are kept, no file is left, an old one is as it was."""
    if existing:
        (tmp_path / "a.nc").write_text("old")
    words = [*LONG, "-o", "a.nc", "--overwrite"]
    process = started(words, tmp_path)
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    kept = blocks(tmp_path)
    assert process.returncode == status
    assert "a second signal stops at once" in err
    assert f"{len(kept)} of 800 blocks are kept in a.nc.run" in err
    assert err.endswith(f"\n    {sys.executable} -m sweep run {shlex.join(words)}\n")
    assert all(name.endswith(".block") for name in kept)
    assert not list(tmp_path.glob("a.nc.run/assembled.nc"))
    assert [path.read_text() for path in tmp_path.glob("*.nc")] == ["old"] * existing


@pytest.mark.compiled
def test_a_second_signal_ends_at_once(tmp_path):
    """A second signal does not wait for the block, which here would take minutes, and says how to go on."""
    slow = [
        "tilt=0.001deg:0.01deg:40000",
        "roll_rate=4",
        "step=1e-7",
        "duration=10",
        "--block-cells",
        "20000",
    ]
    process = subprocess.Popen(
        [sys.executable, "-m", "sweep", "run", "rolling", *slow, "-o", "a.nc"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stderr=subprocess.PIPE,
        text=True,
    )
    while not list(tmp_path.glob("a.nc.run/assembled.nc")):
        assert process.poll() is None
        time.sleep(0.02)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    time.sleep(0.5)
    assert process.poll() is None
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert time.monotonic() - began < 2.0
    assert process.returncode == 130
    assert "\neulerdisk: stopped at once; finished blocks are kept. To go on, " in err
    assert err.endswith("-o a.nc\n")


@pytest.mark.parametrize("on_path", [True, False], ids=["activated", "by its path"])
def test_the_command_that_goes_on_can_be_pasted(tmp_path, on_path):
    """It starts the program as it was started: by its name only where that leads to it; names are quoted."""
    program = Path(sys.executable).with_name("eulerdisk")
    places = os.environ["PATH"].split(os.pathsep)
    elsewhere = [place for place in places if not os.path.exists(os.path.join(place, "eulerdisk"))]
    path = os.pathsep.join([*([str(program.parent)] if on_path else []), *elsewhere])
    words = [*LONG[:3], "--block-cells", "20000", "-o", "of mine.nc"]
    process = subprocess.Popen(
        ["eulerdisk" if on_path else program, "run", *words],
        cwd=tmp_path,
        env={**os.environ, "PATH": path},
        executable=program,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not list(tmp_path.glob("*.run/blocks/*.block")):
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=60)
    again = err.splitlines()[-1].strip()
    assert again.startswith("eulerdisk run " if on_path else f"{program} run ")
    assert shlex.split(again)[2:] == words
    shorter = again.replace("roll_rate=0.5:6:4000", "roll_rate=0.5:6:3")
    told = subprocess.run(
        shorter,
        shell=True,
        cwd=tmp_path,
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert told.returncode == 2
    assert "rm -r 'of mine.nc.run'" in told.stderr


def test_a_signal_takes_effect_between_blocks(monkeypatch, capsys, tmp_path):
    """The block ends in which the signal comes, it is kept, and no other is begun; then the same command goes on."""
    begun = []

    def interrupted(spec, span):
        if not begun:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.2)
        begun.append(span)
        return measure_block(spec, span)

    measure_block = executor.measure_block
    monkeypatch.setattr(executor, "measure_block", interrupted)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["eulerdisk", *shlex.split(SMALL)])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 130
    assert len(begun) == len(blocks(tmp_path)) == 1
    assert capsys.readouterr().err.endswith(f"run the same command again:\n    eulerdisk {SMALL}\n")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 0
    assert len(begun) == 4
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
