"""Small files are read whole, and only if they are files and small."""

import os

import pytest

from sweep.request.regular_files import read_regular


def test_a_file_is_read_up_to_its_limit(tmp_path):
    """All bytes of a file, or a refusal that says how many it has."""
    path = tmp_path / "a"
    path.write_bytes(b"abc")
    assert read_regular(path, 3) == b"abc"
    with pytest.raises(OSError, match="3 bytes or more, of at most 2"):
        read_regular(path, 2)


def test_what_is_no_file_is_not_waited_for(tmp_path):
    """A pipe without a writer, a device without an end and a folder are refused at once."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "zero").symlink_to("/dev/zero")
    for name in ("pipe", "zero"):
        with pytest.raises(OSError, match="not a regular file"):
            read_regular(tmp_path / name, 10)
    with pytest.raises(IsADirectoryError):
        read_regular(tmp_path, 10)


def test_a_file_without_a_size_has_a_limit_too():
    """What the system says is empty, and is not, is read no further than the limit."""
    with pytest.raises(OSError, match="of at most 5"):
        read_regular("/proc/self/environ", 5)
