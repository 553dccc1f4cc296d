"""An interrupt of `sweep.run` ends it after the current block, keeps nothing, and recommends a run to a file."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
import xarray as xr
from messages import assert_facts, refused

import sweep
from sweep.errors import StoppedError
from sweep.progress.timetable import COMPUTING, SEARCHING
from sweep.runs import in_memory, run_directory
from sweep.runs.executor import interruptible

CHECKOUT = Path(__file__).parents[2]
SPEC = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:20", tilt="0.1deg:5deg:10")


class Interrupter:
    """A progress function that sends SIGINT after a given number of cells and records all statuses."""

    def __init__(self, at=None, stage=COMPUTING):
        self.at, self.stage, self.heard = at, stage, []

    def __call__(self, status):
        """Record a status."""
        self.heard.append((status.stage, status.done))
        if self.at is not None and status.stage == self.stage and status.done >= self.at:
            os.kill(os.getpid(), signal.SIGINT)
            self.at = None


def interrupted(spec=SPEC, at=60, **how):
    """Interrupt a call and return its message."""
    with pytest.raises(KeyboardInterrupt) as caught:
        sweep.run(spec, block_cells=20, progress=Interrupter(at, **how))
    return str(caught.value)


def same(one, other):
    """Check that two atlases have the same bits, except for their creation time."""
    xr.testing.assert_identical(one.drop_attrs(deep=False), other.drop_attrs(deep=False))


def test_an_interrupt_keeps_nothing():
    """The current block is completed; the same call then starts from scratch, with the same bits."""
    undisturbed = sweep.run(SPEC)
    assert_facts(interrupted(), "60 of 200 cells", "nothing", "sweep.run_to_file")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    again = Interrupter()
    same(sweep.run("rolling", roll_rate="2:4:20", tilt="0.1deg:5deg:10", progress=again), undisturbed)
    assert again.heard[:3] == [(COMPUTING, 0), (COMPUTING, 200), (SEARCHING, 0)]


def test_the_search_for_the_boundary_can_be_interrupted():
    """The message then counts all cells as computed."""
    refined = SPEC.replace(boundary="refined:1e-6")
    assert_facts(interrupted(refined, at=0, stage=SEARCHING), "200 of 200 cells", "nothing")


def test_an_error_of_the_progress_function_goes_on_to_the_caller():
    """The next call is not affected."""

    def broken(status):
        if status.done == 60:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        sweep.run(SPEC, block_cells=20, progress=broken)
    assert sweep.run(SPEC).sizes == {"roll_rate": 20, "tilt": 10}


def test_a_handler_of_the_caller_stays_in_charge():
    """A SIGINT handler of the caller is called, and the run is not interrupted."""
    arrived = []
    before = signal.signal(signal.SIGINT, lambda *_: arrived.append(1))
    try:
        sweep.run(SPEC, block_cells=20, progress=Interrupter(60))
    finally:
        signal.signal(signal.SIGINT, before)
    assert arrived == [1]


def test_another_thread_computes_too():
    """Outside the main thread no handler can be set, so none is."""
    found = []
    thread = threading.Thread(target=lambda: found.append(sweep.run(SPEC)))
    thread.start()
    thread.join()
    same(found[0], sweep.run(SPEC))


def test_an_interrupt_at_the_very_end_is_not_lost(tmp_path, monkeypatch):
    """The interrupt still stops a notebook; the file is complete."""

    def interrupted_there(*given):
        os.kill(os.getpid(), signal.SIGINT)
        publish(*given)

    publish = run_directory.publish_file
    monkeypatch.setattr(run_directory, "publish_file", interrupted_there)
    with refused("all", error=KeyboardInterrupt):
        sweep.run_to_file(SPEC, tmp_path / "a.nc")
    with sweep.open_atlas(tmp_path / "a.nc") as atlas:
        assert atlas.sizes == {"roll_rate": 20, "tilt": 10}


def test_blocks_take_a_quarter_of_a_second():
    """They are at least as large as the first one and at most an ordinary block of the engine."""
    for cells, seconds, then in [
        (2**12, 0.001, 2**17),
        (2**12, 0.0, 2**17),
        (2**14, 0.5, 2**13),
        (2**12, 9.0, 2**12),
        (2**17, 0.1, 2**17),
    ]:
        assert in_memory._next_size(cells, seconds) == then


def test_what_cannot_be_is_refused():
    """The message is a sentence, and nothing is computed."""
    for how, facts in [({"block_cells": 0}, ["at least 1", "0"]), ({"progress": 3}, ["progress", "3"])]:
        with refused(*facts):
            sweep.run(SPEC, **how)


#: A program that is interrupted by a terminal's or notebook's signal and then calls again.
PROGRAM = """
import sys, sweep
spec = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:300", tilt="0.1deg:5deg:300")
call = {"memory": lambda how: sweep.run(spec, block_cells=5000, progress=how),
        "file": lambda how: sweep.run_to_file(spec, "a.nc", block_cells=5000, progress=how)}[sys.argv[1]]
waited, dones = [], []

def wait(status):
    if status.done >= 10000 and not waited:
        waited.append(status)
        print("ready", flush=True)
        sys.stdin.readline()

try:
    call(wait)
except KeyboardInterrupt as end:
    print(end, flush=True)
call(lambda status: status.stage == "computing" and dones.append(status.done))
print(dones[0], dones[-1])
call(wait) if sys.argv[2:] else None
"""


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize("where", ["memory", "file"])
def test_a_signal_from_outside(tmp_path, where):
    """After a real SIGINT the message says what is kept; the same call resumes, in memory from scratch."""
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, where],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate("on\n", timeout=300)
    assert (process.returncode, err) == (0, "")
    said, numbers = out.splitlines()
    done, total = map(int, numbers.split())
    assert total == 90000
    if where == "memory":
        assert done == 0
        assert_facts(said, "90000 cells", "nothing", "sweep.run_to_file")
    else:
        assert 10000 <= done < 90000
        assert_facts(said, f"{done // 5000} of 18 blocks")
        assert_facts(said, "a.nc.run", "call again")
        assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]


# -- the request to stop


def test_an_interrupt_is_a_request_to_stop():
    """The block is completed; the KeyboardInterrupt has the message of the stop."""

    def work():
        with interruptible() as stopping:
            assert not stopping()
            os.kill(os.getpid(), signal.SIGINT)
            assert stopping()
            raise StoppedError("3 blocks are kept")

    with refused("3 blocks", "call again", error=KeyboardInterrupt):
        work()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_stop_without_an_interrupt_is_none():
    """If an executor stops early without a key press, its own error is raised."""
    with refused("no block", error=StoppedError), interruptible():
        raise StoppedError("no block was finished")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_second_interrupt_does_not_wait():
    """It raises immediately."""
    reached = []

    def work():
        with interruptible():
            for number in range(2):
                os.kill(os.getpid(), signal.SIGINT)
                reached.append(number)

    with pytest.raises(KeyboardInterrupt):
        work()
    assert reached == [0]


def test_a_caller_that_says_itself_when_to_stop_keeps_its_signals():
    """The caller's function is used unchanged, and Python's own handler stays."""

    def mine():
        return True

    with interruptible(mine) as stopping:
        assert stopping is mine
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_that_nothing_heeds_is_not_lost():
    """If the work ends without checking, the interrupt is raised afterwards."""
    with refused("all", error=KeyboardInterrupt), interruptible():
        os.kill(os.getpid(), signal.SIGINT)
