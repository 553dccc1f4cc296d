"""Every command that reads an atlas refuses other files: exit 2, what it is, what was expected, no output."""

import re

import h5py
import netCDF4
import pytest
from messages import missing

import sweep

COMMANDS = [
    "info {}",
    "explain {} tilt=1deg",
    "compare {} good.nc",
    "compare good.nc {} --junit out.xml",
    "export {} --to csv -o out.csv",
    "run --from {} -o out.nc",
]


#: Files that were atlases before someone changed them.
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


#: File -> what the refusal calls it, and what was expected.
REFUSED = {
    "text.nc": ("netCDF-4", "10 bytes"),
    "cut.nc": ("netCDF-4", "bytes"),
    "foreign.nc": ("stability atlas", "'Sea surface temperature'"),
    "newer.nc": ("newer", "format 2"),
    "format.nc": ("stability atlas", "eulerdisk_format, a number"),
    "verdict.nc": ("stability", "eulerdisk run"),
    "missing.nc": ("no such file", "netCDF"),
}


@pytest.fixture
def refused(command, monkeypatch):
    """Return a function that runs a command which must refuse in one line and write no file."""

    def run(folder, line, *said):
        monkeypatch.chdir(folder)
        before = {path.name: path.read_bytes() for path in folder.iterdir()}
        status, out, err = command(line)
        assert (status, out, err.count("\n")) == (2, "", 1), (line, err)
        assert missing(err, said) == [], (line, err)
        assert {path.name: path.read_bytes() for path in folder.iterdir()} == before, line
        return err

    return run


def test_what_is_no_atlas_is_refused(folder, refused):
    """The message names the file, what it is and what was expected; nothing is written."""
    for name, said in REFUSED.items():
        for line in COMMANDS:
            err = refused(folder, line.format(name), *said)
            assert err.startswith(f"eulerdisk: {name}: "), line


def test_a_damaged_part_is_found_out(folder, tmp_path, refused):
    """If a variable's values cannot be read, the message names file and variable; nothing is written."""
    whole = bytearray((folder / "good.nc").read_bytes())
    (tmp_path / "good.nc").write_bytes(whole)
    with h5py.File(folder / "good.nc") as file:
        for name in ("ending", "peak_tilt", "tilt_min"):
            chunk = file[name].id.get_chunk_info(0)
            for i in range(chunk.byte_offset, chunk.byte_offset + chunk.size):
                whole[i] ^= 0x5A
    (tmp_path / "bad.nc").write_bytes(whole)
    for line in (
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
    ):
        err = refused(tmp_path, line.format("bad.nc"), "bad.nc:")
        assert re.search(r"\b(peak_tilt|ending)\b", err), err


def test_what_a_command_needs_is_named(folder, tmp_path, refused):
    """Commands that need a missing variable refuse the atlas."""
    for line, name in (
        ("info {}", "tilt_error"),
        ("explain {} tilt=1deg", "tilt_max"),
        ("verify {}", "nutation_period"),
    ):
        path = tmp_path / f"no_{name}.nc"
        with sweep.open_atlas(folder / "good.nc") as atlas:
            atlas.drop_vars(name).to_netcdf(path)
        refused(tmp_path, line.format(path.name), f"{path.name}:", name)


def test_provenance_that_was_taken_away_is_unknown(folder, tmp_path, command):
    """Missing attributes that no number depends on are shown as unknown; everything else is reported."""
    with sweep.open_atlas(folder / "good.nc") as atlas:
        for name in ("title", "history", "source", "sweep_fingerprint", "kernel_hash"):
            del atlas.attrs[name]
        sweep.save(atlas, tmp_path / "bare.nc")
    for line in ("info bare.nc", "explain bare.nc tilt=1deg"):
        status, out, err = command(line)
        assert (status, err) == (0, "")
        assert "unknown" in out


def test_a_spec_that_cannot_be_read_is_told_with_its_file(folder, tmp_path, refused):
    """An error in an atlas's contents also names the file."""
    (tmp_path / "spec.nc").write_bytes((folder / "good.nc").read_bytes())
    with netCDF4.Dataset(tmp_path / "spec.nc", "a") as file:
        file.sweep_spec = "{}"
    for line in ("info spec.nc", "run --from spec.nc -o out.nc"):
        refused(tmp_path, line, "spec.nc:", "SweepSpec.canonical()")


def test_an_atlas_is_not_lost_to_what_is_made_of_it(folder, tmp_path, refused):
    """No option lets a command overwrite the atlas that it reads."""
    for name in ("a.nc", "good.nc"):
        (tmp_path / name).write_bytes((folder / "good.nc").read_bytes())
    for line in (
        "export a.nc --to csv -o a.nc --overwrite",
        "export a.nc --to parquet -o ./a.nc --overwrite",
        "verify a.nc --write a.nc --overwrite",
        "compare a.nc good.nc --junit a.nc",
        "compare good.nc a.nc --junit a.nc",
    ):
        refused(tmp_path, line, "replace")
