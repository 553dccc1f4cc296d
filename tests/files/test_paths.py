"""Paths are checked before anything is computed and without loading a heavy library."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from messages import refused

from sweep.errors import RequestError
from sweep.files.paths import (
    _check_no_device,
    check_apart,
    check_atlas,
    check_atlas_name,
    check_format,
    check_table_name,
    check_target,
)

CHECKOUT = Path(__file__).parents[2]


def test_unknown_format():
    """A figure name with another ending is refused with the list of endings."""
    for name in ["figure.jpg", "figure", "figure.png.gz"]:
        with refused(".png", ".pdf", ".svg"):
            check_format(name)


def test_ending_may_be_capital():
    """The case of the ending does not matter."""
    assert check_format("FIGURE.PNG") == "png"
    for name in ("rolling.nc", "ROLLING.NC", "rolling"):
        check_atlas_name(Path(name))
    with refused("rolling.nc"):
        check_atlas_name(Path("rolling.CSV"))
    with refused("rolling.csv"):
        check_table_name(Path("rolling.NC"), "csv")


def test_an_atlas_exists(tmp_path):
    """A missing file, a folder, a pipe and a name that is too long are refused by name with the reason."""
    os.mkfifo(tmp_path / "pipe")
    for name, what in (
        ("missing.nc", "no such file"),
        ("y" * 300, "no such file"),
        (".", "folder"),
        ("pipe", "regular file"),
    ):
        with refused(what, "netCDF") as caught:
            check_atlas(tmp_path / name)
        assert caught.value.where == str(tmp_path / name)
    (tmp_path / "a.nc").touch()
    check_atlas(tmp_path / "a.nc")


def test_a_target_may_be_replaced_only_when_asked(tmp_path):
    """A new name is accepted, an existing file only with overwrite, and a folder never."""
    check_target(tmp_path / "a.nc", False)
    (tmp_path / "a.nc").touch()
    check_target(tmp_path / "a.nc", True)
    with refused("--overwrite"):
        check_target(tmp_path / "a.nc", False)
    with refused("file"):
        check_target(tmp_path, True)
    with refused(f"mkdir -p {tmp_path / 'missing'}"):
        check_target(tmp_path / "missing" / "a.nc", False)


def test_a_message_names_a_path_once(tmp_path, monkeypatch):
    """The path is at the start of the message and not repeated, except possibly in the hint."""
    monkeypatch.setattr("os.access", lambda *_: False)
    for name in ("missing/a.nc", "a.nc"):
        with pytest.raises(RequestError) as caught:
            check_target(tmp_path / name, False)
        assert str(tmp_path) not in caught.value.message
        assert caught.value.where == str(tmp_path / name)


def test_a_source_is_not_replaced(tmp_path):
    """An input file is not overwritten, whatever name leads to it."""
    (tmp_path / "a.nc").touch()
    (tmp_path / "link.nc").symlink_to("a.nc")
    check_apart(tmp_path / "b.nc", tmp_path / "a.nc")
    with refused("replace"):
        check_apart(tmp_path / "link.nc", tmp_path / "a.nc")


def test_the_checks_are_light():
    """The checks load neither the compiler nor the file and figure libraries."""
    code = (
        "import sys, sweep.files.paths, sweep.files.publish\n"
        "print([name for name in ('numba', 'netCDF4', 'xarray', 'matplotlib') if name in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no /proc")
def test_a_stream_is_no_target(tmp_path):
    """A link to a stream is refused even if the stream is a file, because the link would be replaced."""
    with open(tmp_path / "file", "wb") as file:
        os.symlink(f"/proc/self/fd/{file.fileno()}", tmp_path / "stream")
        os.symlink("stream", tmp_path / "link")
        for path in (tmp_path / "stream", tmp_path / "link", Path(f"/proc/self/fd/{file.fileno()}")):
            with refused("device"):
                check_target(path, True)
        with refused("/dev/a.nc", "device"):
            _check_no_device(Path("/dev/a.nc"))
    _check_no_device(Path("/dev/shm/a.nc"))
    os.symlink("file", tmp_path / "plain")
    check_target(tmp_path / "plain", True)
