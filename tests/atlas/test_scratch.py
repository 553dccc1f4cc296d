"""Columns that grow beyond memory: the same numbers wherever they are, and no file that stays."""

import errno
import io
import os
import re
import tempfile
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep import atomic
from sweep.atlas import scratch
from sweep.atlas.scratch import Scratch

PARTS = st.lists(st.lists(st.integers(-(2**62), 2**62), max_size=9), max_size=9)


@given(st.data(), PARTS, st.integers(0, 100))
def test_a_column_is_a_list(data, parts, held):
    """Read in any parts, before and after some numbers were replaced, whatever is in the file and what in memory."""
    expected = [number for part in parts for number in part]
    with mock.patch.object(scratch, "_MOST_HELD", held), Scratch() as place:
        column = place.column("i8")
        for part in parts:
            column.append(np.array(part, np.int64))
        assert len(column) == len(expected)
        start = data.draw(st.integers(0, len(expected)))
        stop = data.draw(st.integers(start, len(expected) + 3))
        assert column.read(start, stop).tolist() == expected[start:stop]
        new = [7 * number for number in range(len(expected[start:stop]))]
        column.replace(start, np.array(new, np.int64).tobytes())
        expected[start:stop] = new
        assert column.read(0, len(expected)).tolist() == expected


def test_files_have_no_name_and_end_with_it(tmp_path, monkeypatch):
    """While a column is written its folder is empty, so that a kill leaves nothing; its space is free at the end."""
    monkeypatch.setattr(scratch, "_MOST_HELD", 100)
    before = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0
    with Scratch(tmp_path) as place:
        columns = [place.column("i8"), place.column("i1")]
        for column in columns:
            column.append(np.ones(1000))
        assert os.listdir(tmp_path) == []
        assert not before or len(os.listdir("/proc/self/fd")) == before + 2
    assert not before or len(os.listdir("/proc/self/fd")) == before


def test_a_file_that_was_cut_is_an_error(tmp_path, monkeypatch):
    """Fewer bytes than were written are never taken for numbers."""
    monkeypatch.setattr(scratch, "_MOST_HELD", 100)
    opened, open_scratch = [], atomic.open_scratch
    monkeypatch.setattr(
        scratch, "open_scratch", lambda folder: opened.append(open_scratch(folder)) or opened[-1]
    )
    with Scratch(tmp_path) as place:
        column = place.column("i8")
        column.append(np.ones(1000))
        opened[0].truncate(4000)
        assert column.read(0, 500).tolist() == [1.0] * 500
        with pytest.raises(OSError, match="shorter"):
            column.read(0, 1000)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_named(tmp_path, monkeypatch):
    """The file has no name, and the folder may be on another disk than the atlas: the error says where it is."""
    monkeypatch.setattr(scratch, "_MOST_HELD", 100)
    monkeypatch.setattr(scratch, "open_scratch", lambda _: io.FileIO("/dev/full", "r+"))
    with Scratch(tmp_path) as place, pytest.raises(OSError, match=re.escape(str(tmp_path))) as refusal:
        place.column("i8").append(np.ones(1000))
    assert refusal.value.errno == errno.ENOSPC


def test_no_folder_for_temporary_files(monkeypatch):
    """What Python says where no folder takes a file is an error of the surroundings, not of the program."""

    def refuse():
        raise FileNotFoundError(errno.ENOENT, "No usable temporary directory found in ['/tmp']")

    monkeypatch.setattr(tempfile, "gettempdir", refuse)
    with Scratch() as place, pytest.raises(OSError, match="No usable temporary directory") as refusal:
        place.open_file()
    assert refusal.value.errno == errno.EACCES
