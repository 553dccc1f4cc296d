"""The other process in which a netCDF file is opened first."""

import os
import signal
import sys

import h5py
import pytest

import sweep
from sweep.files import trial


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with an atlas, and one in which a link to the root group takes the place of a variable."""
    folder = tmp_path_factory.mktemp("trial")
    sweep.run_to_file(sweep.SweepSpec(tilt="1deg:2deg:3", roll_rate=3), folder / "whole.nc")
    (folder / "circle.nc").write_bytes((folder / "whole.nc").read_bytes())
    with h5py.File(folder / "circle.nc", "r+") as file:
        del file["tilt_min"]
        file["tilt_min"] = h5py.SoftLink("/")
    return folder


@pytest.mark.parametrize("way", [trial._in_a_fork, trial._in_a_new_process])
def test_what_ends_or_holds_the_library_is_told(folder, way):
    """In a fork and in a new process alike a whole file passes, and one that the library cannot open does not."""
    assert way(folder / "whole.nc") == (0, "")
    assert way(folder / "circle.nc")[0] != 0
    status, words = way(folder / "missing.nc")
    assert status == 1
    assert "missing.nc" in words


def test_the_limits_are_those_of_the_other_process(folder, monkeypatch):
    """A file that takes longer than it may is refused in words; this process goes on."""
    monkeypatch.setattr(trial, "_MOST_WORK", 1)

    def never(path, wait):
        trial._limit(wait)
        while True:
            pass

    monkeypatch.setattr(trial, "_attempt", never)
    assert trial._in_a_fork(folder / "whole.nc") == (-1, "")
    for way in ("_in_a_fork", "_in_a_new_process"):
        monkeypatch.setattr(trial, way, lambda path: (-1, ""))
    with pytest.raises(OSError, match=r"more than 1 s or 512 MB"):
        trial.check_opens(folder / "whole.nc")


def test_a_fork_that_waits_for_ever_is_replaced(folder, monkeypatch):
    """Where a fork waits for a lock that nobody gives back, a new process opens the file."""
    monkeypatch.setattr(trial, "_MOST_WAIT_FORKED", 1)

    def waiting(path, wait):
        trial._limit(wait)
        signal.pause()

    monkeypatch.setattr(trial, "_attempt", waiting)
    assert trial._in_a_fork(folder / "whole.nc") == (0, "")


def test_ended_processes_may_be_forgotten(folder, monkeypatch):
    """Where SIGCHLD is ignored the system keeps no status of a child: good and bad files are told apart without."""
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        trial.check_opens(folder / "whole.nc")
        for name in ("circle.nc", "missing.nc"):
            with pytest.raises(OSError, match=name):
                trial.check_opens(folder / name)
        # a fork that was ended is not one that found nothing wrong, and neither is a new process
        monkeypatch.setattr(trial, "_attempt", lambda *_: os.kill(os.getpid(), signal.SIGKILL))
        assert trial._in_a_fork(folder / "missing.nc")[0] == 1
        monkeypatch.setattr(sys, "executable", "/bin/true")
        assert trial._in_a_fork(folder / "whole.nc") == (-1, "")
    finally:
        signal.signal(signal.SIGCHLD, before)
