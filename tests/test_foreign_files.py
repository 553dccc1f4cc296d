"""Every command that reads an atlas refuses what is none: exit 2, what it is, what was expected, nothing written."""

import shlex
import sys

import netCDF4
import pytest

import sweep
from sweep.cli import main

COMMANDS = [
    "info {}",
    "explain {} tilt=1deg",
    "compare {} good.nc",
    "compare good.nc {} --junit out.xml",
    "export {} --to csv -o out.csv",
    "run --from {} -o out.nc",
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with an atlas and four files that only look like one."""
    folder = tmp_path_factory.mktemp("files")
    sweep.run_to_file(sweep.SweepSpec(tilt="1deg:2deg:3", roll_rate=3), folder / "good.nc")
    whole = (folder / "good.nc").read_bytes()
    (folder / "text.nc").write_text("tilt,rate\n")
    (folder / "cut.nc").write_bytes(whole[: len(whole) // 2])
    (folder / "newer.nc").write_bytes(whole)
    with netCDF4.Dataset(folder / "newer.nc", "a") as file:
        file.eulerdisk_format = file.eulerdisk_format + 1
    with netCDF4.Dataset(folder / "foreign.nc", "w") as file:
        file.title = "Sea surface temperature"
    return folder


@pytest.mark.parametrize(
    ("name", "what", "expected"),
    [
        ("text.nc", "not a readable netCDF file", "a netCDF-4 file, whole"),
        ("cut.nc", "not a readable netCDF file", "a netCDF-4 file, whole"),
        ("foreign.nc", "not a stability atlas", "titled 'Sea surface temperature'"),
        ("newer.nc", "newer than this program", "formats up to"),
        ("missing.nc", "no such file", "an atlas is a netCDF file"),
    ],
)
@pytest.mark.parametrize("line", COMMANDS)
def test_what_is_no_atlas_is_refused(folder, monkeypatch, capsys, line, name, what, expected):
    """The message names the file, what it is and what was expected; no output file appears."""
    monkeypatch.chdir(folder)
    before = sorted(folder.iterdir())
    monkeypatch.setattr(sys, "argv", ["eulerdisk", *shlex.split(line.format(name))])
    with pytest.raises(SystemExit) as end:
        main()
    out, err = capsys.readouterr()
    assert (end.value.code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"eulerdisk: {name}: ")
    assert what in err
    assert expected in err
    assert sorted(folder.iterdir()) == before
