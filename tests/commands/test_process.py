"""Whatever surrounds a command, it ends with a sentence and the right status, and a run with its file."""

import io
import os
import resource
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from sweep import cli, platforms
from sweep.commands import process, run
from sweep.errors import RequestError

CHECKOUT = Path(__file__).parents[2]
SMALL = "run rolling roll_rate=2:4:9 tilt=0.1deg,1deg -o a.nc"


def shell(line, folder, **environment):
    """Run a line of the shell in which `eulerdisk` is this program, and return what came of it."""
    program = f"{shlex.quote(sys.executable)} -m sweep"
    return subprocess.run(
        ["bash", "-c", line.replace("eulerdisk", program)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT), **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


@pytest.fixture(scope="module")
def atlas(tmp_path_factory):
    """Return the folder of a small atlas, which a run without any of the three streams has made."""
    folder = tmp_path_factory.mktemp("atlas")
    done = shell(f"eulerdisk {SMALL} <&- >&- 2>&-", folder)
    assert done.returncode == 0
    assert [path.name for path in folder.iterdir()] == ["a.nc"]
    return folder


def test_a_run_needs_no_streams(atlas):
    """With all three streams closed, or a full disk behind the messages, a run completes and its file is whole."""
    with open(atlas / "a.nc", "rb") as file:
        assert file.read(4) == b"\x89HDF"
    done = shell(f"eulerdisk {SMALL} --overwrite 2>/dev/full", atlas)
    assert (done.returncode, done.stdout) == (0, "")


def test_a_result_that_cannot_be_written(atlas):
    """Status 3, as for a file, and one sentence."""
    for where, why in [(">/dev/full", "No space left on device"), (">&-", "Bad file descriptor")]:
        done = shell(f"eulerdisk info a.nc {where}", atlas)
        assert done.returncode == 3
        assert done.stderr.startswith(f"eulerdisk: standard output: The results cannot be written: {why}.")
        assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("NUMBA_NUM_THREADS", "0"),
        ("NUMBA_NUM_THREADS", "-1"),
        ("NUMBA_NUM_THREADS", "two"),
        ("NUMBA_NUM_THREADS", "1000000"),
        ("NUMBA_NUM_THREADS", "\uff11"),
    ],
)
def test_a_number_of_threads_that_cannot_be(monkeypatch, setting, value):
    """It is refused before Numba reads it, with the variable to unset."""
    monkeypatch.setenv(setting, value)
    with pytest.raises(RequestError, match=rf"must be a number from 1 to 9999.*unset {setting}"):
        platforms.check_settings.__wrapped__()


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"FEATURES": "+nonsense,,x"}, "FEATURES asks for [+]nonsense"),
        ({"FEATURES": "+sse2,,x"}, r"FEATURES must be a list like .* got '\+sse2,,x'"),
        ({"FEATURES": "avx"}, "FEATURES must be a list"),
        (
            {"FEATURES": "+sse2,+amx-tile"},
            r"FEATURES asks for \+amx-tile, which this processor does not have",
        ),
        (
            {"NAME": "diamondrapids", "FEATURES": ""},
            "FEATURES must not stand beside NUMBA_CPU_NAME=diamondrapids",
        ),
        ({"NAME": "x86-64-v4", "FEATURES": ""}, "NAME is x86-64-v4, which has avx512f"),
        ({"NAME": "diamondrapids"}, ""),
        ({"NAME": "generic", "FEATURES": ""}, ""),
        ({"NAME": "here", "FEATURES": "-fma,+sse2"}, ""),
        ({}, ""),
    ],
)
def test_a_processor_that_is_not_this_one(monkeypatch, settings, told):
    """Code for it would end the process without a sentence: what this processor lacks is refused before Numba."""
    monkeypatch.setattr(platforms, "host_features", lambda: {"sse2": True, "fma": True, "amx-tile": False})
    monkeypatch.setattr(platforms, "processor", lambda: "here")
    for name in ("NAME", "FEATURES"):
        monkeypatch.delenv(f"NUMBA_CPU_{name}", raising=False)
    for name, value in settings.items():
        monkeypatch.setenv(f"NUMBA_CPU_{name}", value)
    if not told:
        platforms.check_settings.__wrapped__()
        return
    with pytest.raises(RequestError, match=f"NUMBA_CPU_{told}"):
        platforms.check_settings.__wrapped__()


def test_an_empty_number_of_threads_is_none(monkeypatch):
    """A script passes an empty text on where a variable is not set."""
    monkeypatch.setenv("NUMBA_NUM_THREADS", "")
    platforms.check_settings.__wrapped__()
    assert "NUMBA_NUM_THREADS" not in os.environ


def test_a_traceback_is_no_command_to_a_terminal(monkeypatch, command):
    """Control characters in the text of a defect are escaped; its lines are kept."""

    def fail(*_):
        raise ValueError("\x1b[31mred\nnext")

    monkeypatch.setattr(run, "read_request", fail)
    status, _, err = command(SMALL)
    assert (status, "\x1b" in err) == (70, False)
    assert "\nValueError: \\x1b[31mred\nnext\n" in err


def test_a_window_system_is_not_asked_for(atlas):
    """Figures need none: its name, with which matplotlib could not be imported, does not matter."""
    done = shell("eulerdisk plot a.nc -o a.png", atlas, MPLBACKEND="bad")
    assert (done.returncode, done.stderr) == (0, "")


def test_files_may_not_become_large(atlas):
    """Where a file may have 20 kB, as by `ulimit -f 20`, HDF5 would end the process: the refusal comes before."""
    done = shell("ulimit -f 20; eulerdisk verify a.nc --write b.nc", atlas)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (3, "", 1)
    assert "may not become that large" in done.stderr
    assert not list(atlas.glob(".eulerdisk*"))


def test_little_memory_is_refused_before_it_is_needed(monkeypatch, command, tmp_path):
    """Under 400 MB the libraries would end the process or wait for ever: status 2, with the limit to set."""
    monkeypatch.setattr(resource, "getrlimit", lambda kind: (400 * 2**20, resource.RLIM_INFINITY))
    status, out, told = command(SMALL)
    assert (status, out, told.count("\n")) == (2, "", 1)
    assert "419 MB" in told
    assert "Raise the limit: `ulimit -v" in told
    assert command("run --help")[0] == 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "light"),
    [
        ("info a.nc", True),
        ("boundary a.nc", True),
        ("compare a.nc b.nc", True),
        ("export a.nc --to csv", True),
        ("export a.nc --to parquet", True),
        ("plan rolling --no-calibrate", True),
        ("plan rolling", False),
        ("boundary a.nc --refine=1e-9", False),
        ("boundary a.nc --criterion departure:2deg", False),
        ("info a.nc --partial p.nc", False),
        ("export a.nc --to zarr", False),
        (SMALL, False),
    ],
)
def test_reading_needs_less_memory(monkeypatch, words, light):
    """500 MB are enough for one processor where no kernel is loaded; for others each thread that may run counts."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0}, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    limit = 500e6 if light else 950e6
    monkeypatch.setattr(resource, "getrlimit", lambda kind: (limit, resource.RLIM_INFINITY))
    platforms.check_memory(words.split())
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {*range(8)}, raising=False)
    with pytest.raises(RequestError, match="740 MB" if light else "1600 MB"):
        platforms.check_memory(words.split())
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    if not light:
        platforms.check_memory(words.split())


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not limit address space")
def test_an_atlas_is_read_in_half_a_gigabyte(atlas):
    """What the limit lets through ends well."""
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    limit = (420 + 40 * processors) * 1000
    done = shell(f"ulimit -v {limit}; eulerdisk info a.nc", atlas)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("problem", "status", "told"),
    [
        (ValueError("boom"), 70, "This is a defect of eulerdisk"),
        (EOFError("pickle"), 70, "This is a defect of eulerdisk"),
        (FileNotFoundError(2, "No such file"), 70, "This is a defect of eulerdisk"),
        (RecursionError("deep"), 70, "This is a defect of eulerdisk"),
        (OSError(28, "No space left on device"), 3, "The system refuses: [Errno 28] No space left on device"),
        (MemoryError(), 3, "The memory that this process may use is not enough"),
        (KeyboardInterrupt(), 130, "eulerdisk: interrupted; no unfinished file was written.\n"),
    ],
    ids=lambda each: type(each).__name__ if isinstance(each, BaseException) else "",
)
def test_a_defect_has_a_status_of_its_own(monkeypatch, command, problem, status, told):
    """70 and not compare's 1, the traceback, and last the request to report it; what is no defect is told without."""

    def fail(*_):
        raise problem

    monkeypatch.setattr(run, "read_request", fail)
    ended, out, err = command(SMALL)
    assert (ended, out) == (status, "")
    assert told in err
    assert ("Traceback" in err) == (status == 70)
    assert ("report it" in err.splitlines()[-1]) == (status == 70)


def test_an_interrupt_before_the_words_are_read_is_told_too(monkeypatch, command):
    """While the parser is built, Ctrl-C is an interrupt like any other."""

    def fail(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "parser", fail)
    assert command("info a.nc") == (130, "", "eulerdisk: interrupted; no unfinished file was written.\n")


def test_messages_cannot_fail(monkeypatch):
    """A terminal that has gone away gives errors, which a stream of messages ignores, and one of results does not."""

    def fail(*_):
        raise OSError(5, "Input/output error")

    messages, results = process._text(process._Messages(), None), process._Results()
    monkeypatch.setattr(process.os, "write", fail)
    print("lost", file=messages, flush=True)
    with pytest.raises(RequestError, match="Input/output error") as caught:
        results.write(b"kept")
    assert caught.value.status == 3
    monkeypatch.undo()
    with pytest.raises(io.UnsupportedOperation):
        messages.read()


def test_the_statuses_are_listed(command):
    """`eulerdisk --help`, the page of the command line and its own text name every status."""
    _, listed, _ = command("--help")
    for text in (
        " ".join(listed.split()),
        " ".join((CHECKOUT / "docs" / "commands.md").read_text().replace("|", " ").split()),
        cli.__doc__,
    ):
        for status in ("0 done", "2 ", "3 ", "70 ", "130"):
            assert status in text
