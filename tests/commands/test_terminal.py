"""Signals keep the computed blocks, and the message says how to continue."""

import contextlib
import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from messages import assert_facts

from sweep import notices
from sweep.cli import main
from sweep.commands import terminal
from sweep.runs import executor

CHECKOUT = Path(__file__).parents[2]
LONG = ["rolling", "roll_rate=0.5:6:4000", "tilt=0.01deg:20deg:4000", "--block-cells", "20000"]
SMALL = "run rolling roll_rate=2:4:9 tilt=0.1deg,1deg --block-cells 5 -o a.nc"


def test_work_of_a_single_stage_is_reported_on_standard_error(capsys, monkeypatch):
    """`reporting` turns (done, all) into a stage of progress; standard output stays empty."""
    heard = []

    @contextlib.contextmanager
    def showing(stream, quiet):
        assert (stream, quiet) == (None, False)
        yield heard.append

    monkeypatch.setattr(terminal, "showing", showing)
    with terminal.reporting(what="frames") as report:
        report(0, 10)
        report(5, 10)
    assert [(each.stage, each.done, each.size, each.things) for each in heard] == [
        ("computing", 0, 10, "frames"),
        ("computing", 5, 10, "frames"),
    ]
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("line", ["run {} -o a.nc", "block --run a.nc.run --part 1/1", "assemble a.nc.run"])
def test_commands_can_be_quiet(command, monkeypatch, line):
    """Every command with progress has --quiet."""
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


@pytest.mark.parametrize(
    "line",
    ["run {} -o b.nc", "block --run a.nc.run --part 1/1", "assemble a.nc.run", "batch sweeps.toml -o c"],
)
def test_a_quiet_command_says_nothing_of_what_went_well(command, tmp_path, line):
    """With --quiet there is no progress, success message or compile notice; errors are printed."""
    words = SMALL.removeprefix("run ").removesuffix(" -o a.nc")
    table = '[[sweep]]\nname = "one"\nroll_rate = "2:4:9"\ntilt = "0.1deg,1deg"\n'
    (tmp_path / "sweeps.toml").write_text(table, encoding="utf-8")
    assert command(f"prepare {words} -o a.nc")[0] == 0
    assert notices._listener is not None
    if line.startswith("assemble"):
        assert command("block --run a.nc.run --part 1/1")[0] == 0
    status, _, told = command(line.format(words) + " -q")
    assert (status, told) == (0, "")
    assert notices._listener is None
    status, _, told = command(line.format(words) + " -q --threads 0")
    assert status == 2
    assert told.startswith("eulerdisk: ")


def started(words, folder):
    """Start a run as a process and wait until its first block is kept."""
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
    """Return the names of the kept blocks."""
    return {each.name for each in folder.glob("a.nc.run/blocks/*")}


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize("existing", [False, True], ids=["new", "overwrite"])
@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["INT", "TERM"]
)
def test_a_signal_keeps_what_is_computed(tmp_path, number, status, existing):
    """A signal soon ends a long run with its own status; blocks are kept, and an old file is unchanged."""
    if existing:
        (tmp_path / "a.nc").write_text("old")
    words = [*LONG, "-o", "a.nc", "--overwrite"]
    process = started(words, tmp_path)
    process.send_signal(number)
    _, err = process.communicate(timeout=300)
    kept = blocks(tmp_path)
    assert process.returncode == status
    assert_facts(err, "second signal", f"{len(kept)} of 800 blocks", "a.nc.run")
    assert err.endswith(f"\n    {sys.executable} -m sweep run {shlex.join(words)}\n")
    assert all(name.endswith(".block") for name in kept)
    assert not list(tmp_path.glob("a.nc.run/assembled.nc"))
    assert [path.read_text() for path in tmp_path.glob("*.nc")] == ["old"] * existing


@pytest.mark.compiled
def test_a_second_signal_ends_at_once(tmp_path):
    """A second signal does not wait for the block, which takes minutes here, and the message says how to continue."""
    slow = [
        "tilt=0.001deg:0.01deg:40000",
        "roll_rate=4",
        "step=1e-7",
        "duration=10",
        "--block-cells",
        "20000",
    ]
    for pause in (0.5, 3.0, 15.0):
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
        time.sleep(pause)
        process.send_signal(signal.SIGINT)
        # on a busy machine the first signal may arrive before the block starts: wait longer
        time.sleep(pause)
        if process.poll() is None:
            break
        process.communicate()
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=300)
    # well below the minutes of the block, even on a busy machine
    assert time.monotonic() - began < 30.0
    assert process.returncode == 130
    assert_facts(err, "\neulerdisk: stopped", "kept")
    assert err.endswith("-o a.nc\n")


@pytest.mark.slow_lane
@pytest.mark.parametrize("on_path", [True, False], ids=["activated", "by its path"])
def test_the_command_that_goes_on_can_be_pasted(tmp_path, on_path):
    """The command for continuing starts the program as before, and file names are quoted."""
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
    _, err = process.communicate(timeout=300)
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
    assert_facts(told.stderr, "rm -r 'of mine.nc.run'")


def test_a_signal_takes_effect_between_blocks(monkeypatch, machine, capsys, tmp_path):
    """A signal lets the current block finish and starts no other; then the same command continues."""
    # with many processors, several blocks are computed at once
    machine(processors=2)
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
    assert capsys.readouterr().err.endswith(f"\n    eulerdisk {SMALL}\n")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 0
    assert len(begun) == 4
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]


@pytest.mark.slow_lane
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_compiler(tmp_path, number, status):
    """A signal does not wait for a kernel to compile, half a minute here, and leaves nothing behind."""
    states = ", ".join(f"x{k}=0.{k + 1}" for k in range(9))
    rates = ", ".join(f"x{(k + 1) % 9}**2 - {k + 1}.5*x{k}" for k in range(9))
    (tmp_path / "long.py").write_text(f'@system(duration="10")\ndef long({states}):\n    return {rates}\n')
    process = subprocess.Popen(
        [sys.executable, "-m", "sweep", "run", "long.py", "x0=1,2", "-o", "a.nc"],
        cwd=tmp_path,
        env={
            **os.environ,
            "PYTHONPATH": str(CHECKOUT),
            "EULERDISK_CACHE_DIR": str(tmp_path / "cache"),
            "EULERDISK_NOTICES": "yes",
        },
        stderr=subprocess.PIPE,
        text=True,
    )
    for line in process.stderr:
        if "compiling" in line:
            break
    # well into compilation
    time.sleep(2.0)
    assert process.poll() is None
    began = time.monotonic()
    process.send_signal(number)
    _, err = process.communicate(timeout=120)
    # 2 s on an idle machine; a busy one takes longer
    assert time.monotonic() - began < 8.0
    assert process.returncode == status
    assert_facts(err, "interrupted", "compiled")
    assert not (tmp_path / "a.nc").exists()
