"""Every command that reads an atlas refuses what is none: exit 2, what it is, what was expected, nothing written."""

import shlex
import sys

import h5py
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


#: Files that were an atlas, before somebody worked on them.
SPOILED = {
    "format.nc": lambda file: file.setncattr("eulerdisk_format", "one"),
    "verdict.nc": lambda file: file.renameVariable("stability", "opinion"),
}


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
    for name, change in SPOILED.items():
        (folder / name).write_bytes(whole)
        with netCDF4.Dataset(folder / name, "a") as file:
            change(file)
    return folder


@pytest.mark.parametrize(
    ("name", "what", "expected"),
    [
        ("text.nc", "not a readable netCDF file", "a netCDF-4 file, whole"),
        ("cut.nc", "not a readable netCDF file", "a netCDF-4 file, whole"),
        ("foreign.nc", "not a stability atlas", "titled 'Sea surface temperature'"),
        ("newer.nc", "newer than this program", "formats up to"),
        ("format.nc", "not a stability atlas", "eulerdisk_format, a number"),
        ("verdict.nc", "lacks stability", "as eulerdisk run made it"),
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


def run(monkeypatch, capsys, line):
    """Return exit status, output and messages of a command."""
    monkeypatch.setattr(sys, "argv", ["eulerdisk", *shlex.split(line)])
    with pytest.raises(SystemExit) as end:
        main()
    out, err = capsys.readouterr()
    return end.value.code, out, err


@pytest.mark.parametrize(
    "line",
    [
        "info {}",
        "explain {} tilt=1deg",
        "compare {} good.nc",
        "compare good.nc {}",
        "export {} --to csv -o out.csv",
        "export {} --to parquet -o out.parquet",
        "export {} --to zarr -o out.zarr",
        "plot {} good.nc -o out.png",
        "boundary {} --criterion departure:1deg",
        "verify {}",
    ],
)
def test_a_damaged_part_is_found_out(folder, tmp_path, monkeypatch, capsys, line):
    """Where the values of one variable cannot be read, the file and the variable are named; nothing is written."""
    monkeypatch.chdir(tmp_path)
    whole = bytearray((folder / "good.nc").read_bytes())
    (tmp_path / "good.nc").write_bytes(whole)
    with h5py.File(folder / "good.nc") as file:
        for name in ("ending", "peak_tilt", "tilt_min"):
            chunk = file[name].id.get_chunk_info(0)
            for i in range(chunk.byte_offset, chunk.byte_offset + chunk.size):
                whole[i] ^= 0x5A
    (tmp_path / "bad.nc").write_bytes(whole)
    status, out, err = run(monkeypatch, capsys, line.format("bad.nc"))
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert f"{tmp_path / 'bad.nc'}: " in err
    assert "peak_tilt" in err or "ending" in err
    assert "can be read" in err or "cannot be read" in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.nc", "good.nc"]


@pytest.mark.parametrize(
    ("line", "names"),
    [("info {}", "tilt_error"), ("explain {} tilt=1deg", "tilt_max"), ("verify {}", "nutation_period")],
)
def test_what_a_command_needs_is_named(folder, tmp_path, monkeypatch, capsys, line, names):
    """An atlas from which a variable was taken is refused by the commands that cannot do without it."""
    path = tmp_path / "less.nc"
    with sweep.open_atlas(folder / "good.nc") as atlas:
        atlas.drop_vars(names).to_netcdf(path)
    status, _, err = run(monkeypatch, capsys, line.format(path))
    assert status == 2
    assert f"{path}: " in err
    assert f"lacks {names}" in err


@pytest.mark.parametrize("line", ["info {}", "explain {} tilt=1deg"])
def test_provenance_that_was_taken_away_is_unknown(folder, tmp_path, monkeypatch, capsys, line):
    """Another program may have dropped attributes that no number depends on: that is said, and the rest is told."""
    path = tmp_path / "bare.nc"
    with sweep.open_atlas(folder / "good.nc") as atlas:
        for name in ("title", "history", "source", "sweep_fingerprint", "kernel_hash"):
            del atlas.attrs[name]
        sweep.save(atlas, path)
    status, out, err = run(monkeypatch, capsys, line.format(path))
    assert (status, err) == (0, "")
    assert "unknown" in out


@pytest.mark.parametrize("line", ["info {}", "run --from {} -o out.nc"])
def test_a_spec_that_cannot_be_read_is_told_with_its_file(folder, tmp_path, monkeypatch, capsys, line):
    """What is wrong with the contents of an atlas names the file too."""
    path = tmp_path / "spec.nc"
    path.write_bytes((folder / "good.nc").read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file.sweep_spec = "{}"
    status, _, err = run(monkeypatch, capsys, line.format(path))
    assert status == 2
    assert err.startswith(f"eulerdisk: {path}: {{}} is not what SweepSpec.canonical() wrote")


@pytest.mark.parametrize(
    "line",
    [
        "export a.nc --to csv -o a.nc --overwrite",
        "export a.nc --to parquet -o ./a.nc --overwrite",
        "verify a.nc --write a.nc --overwrite",
        "compare a.nc good.nc --junit a.nc",
        "compare good.nc a.nc --junit a.nc",
    ],
)
def test_an_atlas_is_not_lost_to_what_is_made_of_it(folder, tmp_path, monkeypatch, capsys, line):
    """Whatever may be replaced, the atlas that is read may not."""
    monkeypatch.chdir(tmp_path)
    whole = (folder / "good.nc").read_bytes()
    for name in ("a.nc", "good.nc"):
        (tmp_path / name).write_bytes(whole)
    status, out, err = run(monkeypatch, capsys, line)
    assert (status, out) == (2, "")
    assert "this would replace the atlas that is read" in err
    assert (tmp_path / "a.nc").read_bytes() == whole
