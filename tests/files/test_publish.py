"""Files that are published are complete or not there, and the errors of a file system say what to do."""

import errno
import os

import pytest

from sweep.atomic import publish_bytes
from sweep.errors import RequestError, StorageError
from sweep.files import publish
from sweep.files.publish import published, refusals


def test_no_right_is_not_no_room(tmp_path):
    """Where the right to write is missing, the user is not told to free space."""
    with (
        pytest.raises(StorageError, match="Get the right to write there") as caught,
        refusals(tmp_path / "a"),
    ):
        raise PermissionError(errno.EACCES, "Permission denied", "a.nc.run/blocks/000000.tmp")
    assert "Free some" not in str(caught.value)


def test_an_error_without_a_number_is_probed(tmp_path, monkeypatch):
    """HDF5 may not say why it could not write: then the system is asked whether there is room."""
    monkeypatch.setattr(
        "sweep.files.publish._probe", lambda folder, size: errno.ENOSPC if size == 5000 else 0
    )
    with pytest.raises(StorageError, match="There is no room left"), refusals(tmp_path / "a", lambda: 5000.0):
        raise OSError("HDF5: unable to extend file")


def test_other_errors_of_the_program_pass():
    """A defect keeps its own exception: only errors of the file system and of netCDF are told as such."""
    with pytest.raises(RuntimeError, match="a defect"), refusals(None):
        raise RuntimeError("a defect")


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_file_that_cannot_be_published(tmp_path, monkeypatch, step):
    """If the file system refuses, the old file is unchanged and no temporary file is left."""
    path = tmp_path / "a"
    path.write_bytes(b"old")

    def refuse(*_):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, step, refuse)
    with pytest.raises(OSError, match="Input/output error"):
        publish_bytes(path, b"new")
    with pytest.raises(StorageError, match="Input/output error"), published(path) as unfinished:
        unfinished.write_bytes(b"new")
    assert [(each.name, each.read_bytes()) for each in tmp_path.iterdir()] == [("a", b"old")]


def test_others_of_the_group_may_read_what_is_published(tmp_path):
    """A published file has the rights that the user's umask gives, as every other file."""
    before = os.umask(0o027)
    try:
        publish_bytes(tmp_path / "a", b"new")
    finally:
        os.umask(before)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize(
    ("needed", "hint"), [(0.0, "Raise the limit (ulimit -f)."), (5000.0, "Raise the limit: `ulimit -f 5`.")]
)
def test_a_limit_of_files_is_told_in_the_units_of_the_shell(tmp_path, needed, hint):
    """The hint has the number that `ulimit -f` takes, and none where it is not known."""
    with pytest.raises(StorageError) as caught, refusals(tmp_path / "a", lambda: needed):
        raise OSError(errno.EFBIG, "File too large")
    assert caught.value.hint == hint


@pytest.mark.parametrize(
    ("needed", "free", "told"),
    [
        (101e3, 98e3, "about 101 kB, and 98 kB are free in .*: 3 kB too little"),
        (3.06e6, 3.04e6, "about 3.1 MB, and 3.0 MB are free in .*: 20 kB too little"),
        (4.0e9, 1.0e6, "about 4000 MB, and 1.0 MB are free in .*: 3999 MB too little"),
    ],
)
def test_what_does_not_fit_is_told_with_what_lacks(tmp_path, machine, needed, free, told):
    """Two numbers that are written alike would not say why; nothing is written."""
    machine(free_bytes=free)
    with pytest.raises(RequestError, match=told):
        publish.check_room(tmp_path / "a.nc", needed)
    publish.check_room(tmp_path / "a.nc", free)
    assert list(tmp_path.iterdir()) == []
