"""In any environment, a command ends with a message and the right status, and a run with its file."""

import io
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from messages import assert_facts, refused

from sweep import cli, platforms
from sweep.commands import process, run

CHECKOUT = Path(__file__).parents[2]
SMALL = "run rolling roll_rate=2:4:9 tilt=0.1deg,1deg -o a.nc"


def shell(line, folder, **environment):
    """Run a shell command line in which `eulerdisk` is this program, and return the finished process."""
    program = f"{shlex.quote(sys.executable)} -m sweep"
    return subprocess.run(
        ["bash", "-c", line.replace("eulerdisk", program)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT), **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


@pytest.fixture(scope="module")
def atlas(tmp_path_factory):
    """Return the folder of a small atlas made by a run without the three standard streams."""
    folder = tmp_path_factory.mktemp("atlas")
    done = shell(f"eulerdisk {SMALL} <&- >&- 2>&-", folder)
    assert done.returncode == 0
    assert [path.name for path in folder.iterdir()] == ["a.nc"]
    return folder


@pytest.mark.slow_lane
def test_a_run_needs_no_streams(atlas):
    """A run completes its file even if all three streams are closed or messages go to a full disk."""
    with open(atlas / "a.nc", "rb") as file:
        assert file.read(4) == b"\x89HDF"
    done = shell(f"eulerdisk {SMALL} --overwrite 2>/dev/full", atlas)
    assert (done.returncode, done.stdout) == (0, "")


@pytest.mark.slow_lane
def test_a_result_that_cannot_be_written(atlas):
    """Unwritable standard output gives status 3, as for a file, and one message."""
    done = shell("eulerdisk info a.nc >/dev/full", atlas)
    assert done.returncode == 3
    assert "No space left on device" in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_number_of_threads_that_cannot_be(monkeypatch):
    """A bad NUMBA_NUM_THREADS is refused before Numba reads it, with the command to unset it."""
    for value in ("0", "-1", "two", "1000000", "\uff11"):
        monkeypatch.setenv("NUMBA_NUM_THREADS", value)
        with refused("1", "9999", value, "unset NUMBA_NUM_THREADS"):
            platforms.most_threads()


def test_an_empty_number_of_threads_is_none(monkeypatch):
    """An empty NUMBA_NUM_THREADS counts as unset, because scripts often pass it that way."""
    monkeypatch.setenv("NUMBA_NUM_THREADS", "")
    platforms.most_threads()
    assert "NUMBA_NUM_THREADS" not in os.environ


def test_a_traceback_is_no_command_to_a_terminal(monkeypatch, command):
    """Control characters in an unexpected error are escaped; its line breaks are kept."""

    def fail(*_):
        raise ValueError("\x1b[31mred\nnext")

    monkeypatch.setattr(run, "read_request", fail)
    status, _, err = command(SMALL)
    assert (status, "\x1b" in err) == (70, False)
    assert "\nValueError: \\x1b[31mred\nnext\n" in err


@pytest.mark.release
def test_a_window_system_is_not_asked_for(atlas):
    """Figures need no window system: a bad MPLBACKEND, which breaks matplotlib's import, does not matter."""
    done = shell("eulerdisk plot a.nc -o a.png", atlas, MPLBACKEND="bad")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.slow_lane
def test_files_may_not_become_large(atlas):
    """With a file size limit of 20 kB, where HDF5 would end the process, --write is refused after the findings."""
    done = shell("ulimit -f 20; eulerdisk verify a.nc --write b.nc", atlas)
    assert (done.returncode, done.stderr.count("\n")) == (3, 1)
    assert_facts(done.stdout.splitlines()[0], "18 agrees")
    assert_facts(done.stderr, "b.nc", "large")
    assert not list(atlas.glob(".eulerdisk*"))


def test_little_memory_is_refused_before_it_is_needed(machine, command, tmp_path):
    """Below 400 MB, where libraries crash or hang, a run exits with status 2 and states the limit to set."""
    machine(address_space=400 * 2**20)
    status, out, told = command(SMALL)
    assert (status, out, told.count("\n")) == (2, "", 1)
    assert_facts(told, "419 MB")
    assert "`ulimit -v " in told
    assert command("run --help")[0] == 0
    assert list(tmp_path.iterdir()) == []


def test_memory_is_needed_for_each_thread(machine, monkeypatch):
    """The memory needed grows with the number of threads, at most NUMBA_NUM_THREADS."""
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    machine(address_space=950e6, processors=1)
    platforms.check_memory()
    machine(processors=8)
    with refused("1600 MB"):
        platforms.check_memory()
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    platforms.check_memory()


@pytest.mark.parametrize(
    ("problem", "status", "fact"),
    [
        (ValueError("boom"), 70, "ValueError: boom"),
        (EOFError("pickle"), 70, "EOFError: pickle"),
        (FileNotFoundError(2, "No such file"), 70, "FileNotFoundError: [Errno 2] No such file"),
        (RecursionError("deep"), 70, "RecursionError: deep"),
        (OSError(28, "No space left on device"), 3, "[Errno 28] No space left on device"),
        (MemoryError(), 3, "memory"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
    ids=lambda each: type(each).__name__ if isinstance(each, BaseException) else "",
)
def test_a_defect_has_a_status_of_its_own(monkeypatch, command, problem, status, fact):
    """A defect gives status 70, its traceback and a request to report it; other errors have no traceback."""

    def fail(*_):
        raise problem

    monkeypatch.setattr(run, "read_request", fail)
    ended, out, err = command(SMALL)
    assert (ended, out) == (status, "")
    assert_facts(err, fact)
    assert ("Traceback" in err) == (status == 70)
    assert ("defect" in err.splitlines()[-1]) == (status == 70)


def test_an_interrupt_before_the_words_are_read_is_told_too(monkeypatch, command):
    """Ctrl-C while the parser is built is reported like any other interrupt."""

    def fail(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "parser", fail)
    status, out, err = command("info a.nc")
    assert (status, out, err.count("\n")) == (130, "", 1)
    assert_facts(err, "eulerdisk", "interrupted")


def test_messages_cannot_fail(monkeypatch):
    """Messages to a terminal that has gone away are dropped without an error."""

    def fail(*_):
        raise OSError(5, "Input/output error")

    messages = io.TextIOWrapper(process._Messages(), write_through=True)
    monkeypatch.setattr(process.os, "write", fail)
    print("lost", file=messages, flush=True)
    monkeypatch.undo()
    with pytest.raises(io.UnsupportedOperation):
        messages.read()


def test_the_statuses_are_listed(command):
    """`eulerdisk --help`, docs/commands.md and the docstring of `cli` list every status."""
    _, listed, _ = command("--help")
    for text in (
        " ".join(listed.split()),
        " ".join((CHECKOUT / "docs" / "commands.md").read_text().replace("|", " ").split()),
        cli.__doc__,
    ):
        for status in ("0 done", "2 ", "3 ", "70 ", "130"):
            assert status in text
