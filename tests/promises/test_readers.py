"""Other programs read an atlas: names, units, flags, missing values and a mean.

scripts/test installs these programs if it may (scripts/readers.sh). Outside CI a missing one is skipped and
named in the summary; in CI it is an error.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import lossy_runner
import netCDF4
import numpy as np
import pytest
import xarray as xr

import sweep
from sweep.model.disk.model import DISK
from sweep.model.lossy_disk.model import LOSSY_DISK

pytestmark = pytest.mark.slow_lane

READERS = Path(__file__).with_name("readers")

#: A few disks fall, so `fall_time` has gaps. The title tests programs that only know ASCII.
SPEC = sweep.SweepSpec(roll_rate="0:3:6", tilt="5deg:40deg:7", title="Münze", criterion="departure:5deg")

#: The same motions as random starts: one dimension, with parameters as auxiliary coordinates.
LIST = SPEC.replace(roll_rate="uniform:0:3", tilt="uniform:5deg:40deg", samples=42)

#: Lossy disks: some of them break the criterion, so `breach_time` has gaps.
LOSSY = SPEC.replace(
    roll_rate=3.0,
    rolling_friction="0,1mm,5mm",
    contour_damping=0.01,
    mass="2kg",
    duration="3s",
    criterion="departure:30deg",
)

#: A time that some cells lack, by model name.
TIMES = {DISK.name: "fall_time", LOSSY_DISK.name: "breach_time"}


@dataclass(frozen=True)
class Facts:
    """What every reader must find about the file and a time that some cells lack."""

    shape: list[int]
    units: str
    known: int
    mean: float
    meanings: str
    flags: list[int]
    criterion: str


@dataclass(frozen=True)
class Atlas:
    """A file, its spec, the name of the examined time, and what xarray finds."""

    path: Path
    spec: sweep.SweepSpec
    name: str
    truth: Facts


@pytest.fixture(scope="module", autouse=True)
def general():
    """Use the general kernels instead of compiling those for the laws of this file."""
    with lossy_runner.general_kernels():
        yield


@pytest.fixture(scope="module")
def atlases(tmp_path_factory):
    """Return an atlas of each kind, in which the examined time has values and gaps."""
    made = []
    for number, spec in enumerate((SPEC, LIST, LOSSY)):
        path = tmp_path_factory.mktemp("readers") / f"atlas{number}.nc"
        sweep.run_to_file(spec, path)
        name = TIMES[spec.model.name]
        with xr.open_dataset(path, engine="netcdf4") as atlas:
            time, ending = atlas[name], atlas["ending"]
            known = int(time.notnull().sum())
            assert 0 < known < time.size
            truth = Facts(
                list(time.shape),
                time.attrs["units"],
                known,
                pytest.approx(float(time.mean()), rel=1e-14),
                ending.attrs["flag_meanings"],
                ending.attrs["flag_values"].tolist(),
                atlas.attrs["criterion"],
            )
        made.append(Atlas(path, spec, name, truth))
    return made


def program(*names):
    """Skip the test if one of the programs is missing; in CI fail instead."""
    missing = [name for name in names if not shutil.which(name)]
    if missing and os.environ.get("CI") == "true":
        pytest.fail(f"CI has every reader, but {', '.join(missing)} is missing: see scripts/readers.sh")
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)} (scripts/test says how)")


def said(command, *paths):
    """Run a command line, which must succeed, and return its output."""
    done = subprocess.run(
        [*shlex.split(command), *paths], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def facts(text):
    """Return the facts that a program printed for each file, one per line."""
    found = []
    for part in text.split("shape ")[1:]:
        shape, *lines = part.splitlines()
        of = dict(line.split(maxsplit=1) for line in lines)
        assert len(of) == 6, text
        found.append(
            Facts(
                [int(each) for each in shape.split()],
                of["units"].strip(),
                int(of["known"]),
                float(of["mean"]),
                of["meanings"].strip(),
                [int(each) for each in of["flags"].split()],
                of["criterion"].strip(),
            )
        )
    return found


def test_c(atlases, tmp_path):
    """A short C program finds every fact: text attributes are plain characters, flags are bytes."""
    program("cc", "nc-config")
    libraries = shlex.split(said("nc-config --cflags --libs"))
    said("cc -Wall -Werror -o", tmp_path / "read", READERS / "read.c", *libraries)
    for each in atlases:
        assert facts(said(str(tmp_path / "read"), each.path, each.name)) == [each.truth]


@pytest.mark.parametrize(
    ("command", "library", "probe"),
    [
        ("Rscript --vanilla read.R", "ncdf4", 'Rscript -e "library(ncdf4)"'),
        ("octave-cli --no-gui -q -f read.m", "netcdf", 'octave-cli -f --eval "pkg load netcdf"'),
    ],
    ids=["R", "Octave"],
)
def test_script(atlases, command, library, probe):
    """R and Octave find every fact; Octave lists the whole file, which one unknown type would prevent."""
    language, *_, script = command.split()
    program(language)
    if subprocess.run(shlex.split(probe), capture_output=True, check=False).returncode:
        assert os.environ.get("CI") != "true", f"CI has every reader, but {language} lacks {library}"
        pytest.skip(f"not installed: {library} of {language} (scripts/test says how)")
    words = [word for each in atlases for word in (each.path, each.name)]
    found = facts(said(command.replace(script, str(READERS / script)), *words))
    assert found == [each.truth for each in atlases]


def test_ncdump(atlases):
    """The text of ncdump shows the classic model, units, flags as bytes, and gaps, all in ASCII."""
    program("ncdump")
    for path, name, truth in ((each.path, each.name, each.truth) for each in atlases):
        assert said("ncdump -k", path).strip() == "netCDF-4 classic model"
        text = said(f"ncdump -p 9,17 -v {name}", path)
        assert text.isascii()
        assert 'title = "M\\\\xfcnze"' in text
        assert f'{name}:units = "{truth.units}" ;' in text
        assert f'ending:flag_meanings = "{truth.meanings}" ;' in text
        assert f"ending:flag_values = {', '.join(f'{flag}b' for flag in truth.flags)} ;" in text
        values = re.search(rf"\n {name} =\s(.*?) ;", text, re.DOTALL)[1].replace(",", " ").split()
        known = [float(each) for each in values if each != "_"]
        assert (len(values), len(known)) == (np.prod(truth.shape), truth.known)
        assert np.mean(known) == truth.mean


def test_cdo(atlases):
    """CDO finds all variables on the grid, units, flags, gaps, and the mean of a field."""
    program("cdo")
    for path, spec, name, truth in ((each.path, each.spec, each.name, each.truth) for each in atlases):
        assert set(said("cdo -s showname", path).split()) >= set(spec.model.variables)
        assert said(f"cdo -s showunit -selname,{name}", path).strip() == truth.units
        assert f'flag_meanings = "{truth.meanings}"' in said(
            "cdo -s showattribute,ending@flag_meanings", path
        )
        assert f'criterion = "{truth.criterion}"' in said("cdo -s showattribute,criterion", path)
        table = said(f"cdo -s infon -selname,{name}", path).splitlines()[1].split()
        assert table[5:7] == [str(np.prod(truth.shape)), str(np.prod(truth.shape) - truth.known)]
        # CDO sums with weights 1/n, so its last digit may differ.
        assert float(said(f"cdo -s outputf,%.17g -fldmean -selname,{name}", path)) == truth.mean


@pytest.mark.parametrize("operator", ["copy", "selname"])
def test_what_cdo_writes_again_is_still_an_atlas(atlases, operator, tmp_path, command):
    """CDO drops the scalar coordinates and adds missing_value; a grid can still be read and verified."""
    program("cdo")
    for path, spec in ((each.path, each.spec) for each in atlases):
        with xr.open_dataset(path, engine="netcdf4") as atlas:
            names = f",{','.join(map(str, atlas.data_vars))}" if operator == "selname" else ""
        copy, again = tmp_path / f"copy-{path.name}", tmp_path / f"again-{path.name}"
        said(f"cdo -s {operator}{names}", path, copy)
        with netCDF4.Dataset(copy) as file:
            assert "alpha" not in file.variables
            assert file["tilt_min"].missing_value == file["tilt_min"]._FillValue
        if spec is LIST:
            # It also drops the start parameters, and a table's spec does not contain them.
            assert "start must be whole numbers" in command(f"info {copy}")[2]
            continue
        assert "alpha 0.5" in command(f"info {copy}")[1]
        for line in (f"verify {copy}", f"run --from {copy} -o {again}", f"compare {copy} {again} --exact"):
            status, out, err = command(line)
            assert status == 0, out + err
        assert command(f"boundary {copy}") == command(f"boundary {path}")


def test_cdo_keeps_the_fixed_parameters(atlases, tmp_path):
    """Selecting a variable drops scalar coordinates, but their numbers remain as attributes."""
    program("cdo")
    for atlas in atlases:
        said(f"cdo -s -O selname,{atlas.name}", atlas.path, tmp_path / "part.nc")
        more = ("contour_damping", "mass") if atlas.spec is LOSSY else ()
        with netCDF4.Dataset(atlas.path) as whole, netCDF4.Dataset(tmp_path / "part.nc") as part:
            for each in ("alpha", "radius", "gravity", *more):
                assert part.getncattr(each) == whole[each][...].item()
                assert part.getncattr(f"{each}_units") == whole[each].units
            assert part.getncattr("criterion_meaning") == whole.getncattr("criterion_meaning")


def test_nco(atlases, tmp_path):
    """NCO finds units and flags, and its mean skips gaps, which fails with NaN as the fill value."""
    program("ncwa", "ncks")
    for path, spec, name, truth in ((each.path, each.spec, each.name, each.truth) for each in atlases):
        said(f"ncwa -O -y avg -v {name}", path, tmp_path / "mean.nc")
        with netCDF4.Dataset(tmp_path / "mean.nc") as file:
            assert float(file[name][...]) == truth.mean
        found = json.loads(said("ncks --json -m -M", path))
        assert found["dimensions"] == dict(zip(spec.axes, truth.shape, strict=True))
        assert found["variables"][name]["attributes"]["units"] == truth.units
        assert found["variables"]["ending"]["attributes"]["flag_values"] == truth.flags
        assert found["variables"]["ending"]["type"] == "byte"
        assert found["attributes"]["criterion"] == truth.criterion


def test_gdal(atlases, tmp_path):
    """GDAL's multidimensional driver finds names, units, gaps and the mean."""
    program("gdalmdiminfo")
    for path, spec, name, truth in ((each.path, each.spec, each.name, each.truth) for each in atlases):
        # GDAL writes its statistics next to the file.
        copy = shutil.copy(path, tmp_path / path.name)
        whole = json.loads(said("gdalmdiminfo", copy))
        assert set(whole["arrays"]) >= {*spec.model.variables, *spec.axes, *spec.listed}
        assert whole["attributes"]["criterion"] == truth.criterion
        assert whole["arrays"]["ending"]["attributes"]["flag_meanings"] == truth.meanings
        assert whole["arrays"]["ending"]["attributes"]["flag_values"] == truth.flags
        field = json.loads(said(f"gdalmdiminfo -stats -array {name}", copy))
        assert (field["dimension_size"], field["unit"]) == (truth.shape, truth.units)
        assert field["statistics"]["valid_sample_count"] == truth.known
        assert field["statistics"]["mean"] == truth.mean


def test_h5netcdf(atlases):
    """h5netcdf, which reads HDF5 without the netCDF library, gives xarray the same dataset."""
    for path in (each.path for each in atlases):
        with (
            xr.open_dataset(path, engine="h5netcdf") as found,
            xr.open_dataset(path, engine="netcdf4") as expected,
        ):
            # One library returns a single number as an array of one; texts and values are compared exactly.
            xr.testing.assert_equal(found, expected)
            for name in expected.variables:
                assert found[name].dtype == expected[name].dtype, name
                assert found[name].attrs.get("units") == expected[name].attrs.get("units"), name
            flags = [each["ending"].attrs["flag_values"].tolist() for each in (found, expected)]
            assert flags[0] == flags[1]
            assert found.attrs["sweep_spec"] == expected.attrs["sweep_spec"]


def test_udunits():
    """UDUNITS, the library that CF names for units, parses every unit that a file can contain."""
    program("udunits2")
    tables = (
        table for model in (DISK, LOSSY_DISK) for table in (model.parameters, model.settings, model.variables)
    )
    for units in sorted({each.units for table in tables for each in table.values()}):
        assert said(f"udunits2 -H '{units}' -W '{units}'").strip().startswith(("1 ", f"1 {units}")), units


def test_the_set_up_says_what_is_missing_and_goes_on(tmp_path):
    """Programs are installed only on request; a missing program or a failed installation stops nothing."""
    asked = tmp_path / "asked"
    stubs = {"id": "echo $USER_ID", "dpkg-query": "exit 1", "apt-get": f'echo "$@" >>{asked}; exit 1'}
    stubs["sudo"] = '[ "$1" != -n ] || shift; exec "$@"'
    for name, body in stubs.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / name).chmod(0o755)
    (tmp_path / ".venv").mkdir()
    script = Path(__file__).parents[2] / "scripts" / "readers.sh"
    by_hand = (
        "scripts/test --readers, or\n    sudo apt-get install --no-install-recommends netcdf-bin cdo nco"
    )
    for user, ci, word, expected in (
        ("1000", "", "", by_hand),
        ("0", "", "", by_hand),
        ("1000", "", "install", "The installation failed, see "),
        ("0", "", "install", "The installation failed, see "),
        ("1000", "true", "install", "The installation failed, see "),
    ):
        asked.unlink(missing_ok=True)
        done = subprocess.run(
            ["bash", "-uc", f"checkout={tmp_path}; source {script}; prepare_readers {word}"],
            env={"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}", "CI": ci, "USER_ID": user},
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.returncode, done.stdout) == (0, "")
        assert expected in done.stderr, (user, ci, word)
        assert asked.exists() == bool(word)
    update, install = asked.read_text().splitlines()
    assert update.endswith(" update")
    assert " install --no-install-recommends netcdf-bin cdo" in install
