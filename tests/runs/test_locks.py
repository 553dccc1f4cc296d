"""The lock of a run's folder: one writer, or all jobs of an array; it is released when the holder dies."""

import errno
import fcntl
import os
import subprocess
import sys
from pathlib import Path

import pytest
from messages import refused

from sweep.runs.folder import locked

CHECKOUT = Path(__file__).parents[2]

_HOLD = """
import sys, time
from pathlib import Path
from sweep.runs.folder import locked
with locked(Path(sys.argv[1]), shared=sys.argv[2] == "shared"):
    print("held", flush=True)
    time.sleep(60)
"""


def holding(folder, how="alone"):
    """Start a process that holds the lock."""
    process = subprocess.Popen(
        [sys.executable, "-c", _HOLD, str(folder), how],
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stdout=subprocess.PIPE,
        text=True,
    )
    with process.stdout as out:
        assert out.readline() == "held\n"
    return process


def test_one_writer_at_a_time(tmp_path):
    """While one process holds it, others are refused with process, machine and time; kill -9 releases it."""
    process = holding(tmp_path)
    for shared in (False, True):
        with (
            refused("being written", f"process {process.pid}"),
            locked(tmp_path, shared=shared),
        ):
            pass
    process.kill()
    process.wait()
    with locked(tmp_path):
        pass


def test_array_jobs_share_the_lock(tmp_path):
    """Shared holders can hold it together; a request for exclusive access is refused."""
    process = holding(tmp_path, "shared")
    with locked(tmp_path, shared=True):
        pass
    with refused("being written"), locked(tmp_path):
        pass
    process.kill()
    process.wait()


def test_a_file_system_without_locks(tmp_path, monkeypatch):
    """Without locks a run is refused, because two runs could write one output."""

    def unsupported(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", unsupported)
    for shared in (False, True):
        with (
            refused("locks", "No locks available"),
            locked(tmp_path, shared=shared),
        ):
            pass


def test_a_lock_on_a_file_that_was_replaced_is_none(tmp_path, monkeypatch):
    """A finished run removes the lock file; a process that had opened it locks the new file instead."""
    system, path, replaced = fcntl.flock, tmp_path / "lock", []

    def replace_first(handle, kind):
        if not replaced:
            replaced.append(path.unlink())
        system(handle, kind)

    monkeypatch.setattr(fcntl, "flock", replace_first)
    with locked(tmp_path):
        assert path.exists()
        with refused("being written"), locked(tmp_path):
            pass


@pytest.mark.parametrize("code", [errno.EACCES, errno.EROFS])
def test_a_run_of_another_user(tmp_path, monkeypatch, code):
    """A user without write permission for the folder gets a message and status 2."""

    def refuse(path, *_):
        raise OSError(code, os.strerror(code), path)

    monkeypatch.setattr("sweep.runs.folder.os.open", refuse)
    with (
        refused(os.strerror(code)) as caught,
        locked(tmp_path),
    ):
        pass
    assert caught.value.status == 2
    assert (caught.value.where, str(tmp_path) in caught.value.message) == (str(tmp_path), False)


def test_a_lock_on_a_full_disk(tmp_path, monkeypatch):
    """The lock can be held even if the disk has no room for the holder's name."""

    def refuse(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("sweep.runs.folder.os.pwrite", refuse)
    with locked(tmp_path):
        assert (tmp_path / "lock").exists()


def test_a_folder_that_goes_meanwhile(tmp_path):
    """If the run that held the lock removes the folder, the next process creates a new one."""
    with locked(tmp_path / "a.nc.run"):
        assert (tmp_path / "a.nc.run" / "lock").exists()
