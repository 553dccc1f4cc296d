"""Published files are complete or absent, and file system errors come with advice."""

import errno
import os

import pytest
from messages import assert_facts, assert_in_order, refused

from sweep.atomic import publish_bytes
from sweep.errors import StorageError
from sweep.files import publish
from sweep.files.publish import published, refusals


def test_no_right_is_not_no_room(tmp_path):
    """If permission to write is missing, the hint does not suggest freeing space."""
    with pytest.raises(StorageError) as caught, refusals(tmp_path / "a"):
        raise PermissionError(errno.EACCES, "Permission denied", "a.nc.run/blocks/000000.tmp")
    assert_facts(str(caught.value), "a.nc.run/blocks/000000.tmp", "Permission denied")
    assert_facts(caught.value.hint, "permission", "folder")
    assert "free" not in caught.value.hint.lower()


def test_an_error_without_a_number_is_probed(tmp_path, monkeypatch):
    """If HDF5 does not say why it could not write, the free space is checked."""
    monkeypatch.setattr(
        "sweep.files.publish._probe", lambda folder, size: errno.ENOSPC if size == 5000 else 0
    )
    with pytest.raises(StorageError) as caught, refusals(tmp_path / "a", lambda: 5000.0):
        raise OSError("HDF5: unable to extend file")
    assert_facts(caught.value.hint, "Free", "1 MB")


def test_other_errors_of_the_program_pass():
    """Only errors of the file system and of netCDF are converted; other exceptions pass unchanged."""
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
    """A published file has the permissions of the user's umask, like any other file."""
    before = os.umask(0o027)
    try:
        publish_bytes(tmp_path / "a", b"new")
    finally:
        os.umask(before)
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize(("needed", "limit"), [(0.0, "ulimit -f"), (5000.0, "ulimit -f 5")])
def test_a_limit_of_files_is_told_in_the_units_of_the_shell(tmp_path, needed, limit):
    """The hint gives the number for `ulimit -f`, if it is known."""
    with pytest.raises(StorageError) as caught, refusals(tmp_path / "a", lambda: needed):
        raise OSError(errno.EFBIG, "File too large")
    assert_facts(caught.value.hint, limit)
    assert ("5" in caught.value.hint) == (needed > 0.0)


@pytest.mark.parametrize(
    ("needed", "free", "told"),
    [
        (101e3, 98e3, ["101 kB", "98 kB", "3 kB"]),
        (3.06e6, 3.04e6, ["3.1 MB", "3.0 MB", "20 kB"]),
        (4.0e9, 1.0e6, ["4000 MB", "1.0 MB", "3999 MB"]),
    ],
)
def test_what_does_not_fit_is_told_with_what_lacks(tmp_path, machine, needed, free, told):
    """The message states needed and free space with enough digits to differ; nothing is written."""
    machine(free_bytes=free)
    with refused("a.nc", str(tmp_path.resolve())) as caught:
        publish.check_room(tmp_path / "a.nc", needed)
    assert_in_order(caught.value.message, *told)
    assert_facts(caught.value.hint, told[-1])
    publish.check_room(tmp_path / "a.nc", free)
    assert list(tmp_path.iterdir()) == []
