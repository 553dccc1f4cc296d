"""An atlas read by programs that know nothing of this project: names, units, flags, missing values and a mean.

scripts/test installs these programs where it may (scripts/readers.sh). Away from CI a missing one is skipped, and the
summary names it; in CI it is an error.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

import sweep
from sweep.model.disk.model import DISK
from sweep.model.lossy_disk.model import LOSSY_DISK

pytestmark = pytest.mark.slow_lane

READERS = Path(__file__).with_name("readers")

#: A few disks fall: `fall_time` has values and gaps. The title is to be read by programs that only know ASCII.
SPEC = sweep.SweepSpec(roll_rate="0:3:6", tilt="5deg:40deg:7", title="Münze", criterion="departure:5deg")

#: The same motions as a list of random starts: one dimension, and parameters that are auxiliary coordinates.
LIST = SPEC.replace(roll_rate="uniform:0:3", tilt="uniform:5deg:40deg", samples=42)

#: Disks with losses: some of them break the criterion, so that `breach_time` has values and gaps.
LOSSY = SPEC.replace(
    roll_rate=3.0,
    rolling_friction="0,1mm,5mm",
    contour_damping=0.01,
    mass="2kg",
    duration="3s",
    criterion="departure:30deg",
)

#: A time that some cells lack, by the name of the model.
TIMES = {DISK.name: "fall_time", LOSSY_DISK.name: "breach_time"}


@dataclass(frozen=True)
class Facts:
    """What every reader has to find of a time that some cells lack, and of the file."""

    shape: list[int]
    units: str
    known: int
    mean: float
    meanings: str
    flags: list[int]
    criterion: str


@pytest.fixture(scope="module", params=[SPEC, LIST, LOSSY], ids=["grid", "list", "losses"])
def spec(request):
    """Return what the atlas was made from."""
    return request.param


@pytest.fixture(scope="module")
def path(tmp_path_factory, spec):
    """Return an atlas."""
    path = tmp_path_factory.mktemp("readers") / "atlas.nc"
    sweep.run_to_file(spec, path)
    return path


@pytest.fixture(scope="module")
def name(spec):
    """Return the name of the time that is looked at."""
    return TIMES[spec.model.name]


@pytest.fixture(scope="module")
def truth(path, name):
    """Return what xarray finds, which is not all missing and not all known."""
    with xr.open_dataset(path, engine="netcdf4") as atlas:
        time, ending = atlas[name], atlas["ending"]
        known = int(time.notnull().sum())
        assert 0 < known < time.size
        return Facts(
            list(time.shape),
            time.attrs["units"],
            known,
            pytest.approx(float(time.mean()), rel=1e-14),
            ending.attrs["flag_meanings"],
            ending.attrs["flag_values"].tolist(),
            atlas.attrs["criterion"],
        )


def program(*names):
    """Skip the test if one of the programs is missing; in CI that is a failure."""
    missing = [name for name in names if not shutil.which(name)]
    if missing and os.environ.get("CI") == "true":
        pytest.fail(f"CI has every reader, but {', '.join(missing)} is missing: see scripts/readers.sh")
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)} (scripts/test says how)")


def said(command, *paths):
    """Run a command line, which must end well, and return what it printed."""
    done = subprocess.run(
        [*shlex.split(command), *paths], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def facts(text):
    """Return the facts that a program printed, one a line."""
    found = dict(line.split(maxsplit=1) for line in text.splitlines())
    assert len(found) == 7, text
    return Facts(
        [int(each) for each in found["shape"].split()],
        found["units"].strip(),
        int(found["known"]),
        float(found["mean"]),
        found["meanings"].strip(),
        [int(each) for each in found["flags"].split()],
        found["criterion"].strip(),
    )


def test_c(path, name, truth, tmp_path):
    """Twenty lines of C find every fact: text attributes are plain characters, flags are bytes."""
    program("cc", "nc-config")
    libraries = shlex.split(said("nc-config --cflags --libs"))
    said("cc -Wall -Werror -o", tmp_path / "read", READERS / "read.c", *libraries)
    assert facts(said(str(tmp_path / "read"), path, name)) == truth


@pytest.mark.parametrize(
    ("command", "library", "probe"),
    [
        ("Rscript --vanilla read.R", "ncdf4", 'Rscript -e "library(ncdf4)"'),
        ("octave-cli --no-gui -q -f read.m", "netcdf", 'octave-cli -f --eval "pkg load netcdf"'),
    ],
    ids=["R", "Octave"],
)
def test_script(path, name, truth, command, library, probe):
    """R and Octave find every fact, and Octave lists the whole file, which one foreign type would prevent."""
    language, *_, script = command.split()
    program(language)
    if subprocess.run(shlex.split(probe), capture_output=True, check=False).returncode:
        assert os.environ.get("CI") != "true", f"CI has every reader, but {language} lacks {library}"
        pytest.skip(f"not installed: {library} of {language} (scripts/test says how)")
    assert facts(said(command.replace(script, str(READERS / script)), path, name)) == truth


def test_ncdump(path, name, truth):
    """The text of ncdump shows the classic model, units, flags as bytes, and gaps as gaps; all of it ASCII."""
    program("ncdump")
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


def test_cdo(path, spec, name, truth):
    """CDO finds all variables on the grid, units, flags, the gaps, and the mean of a field."""
    program("cdo")
    names = said("cdo -s showname", path).split()
    assert set(names) >= set(spec.model.variables)
    assert said(f"cdo -s showunit -selname,{name}", path).strip() == truth.units
    assert f'flag_meanings = "{truth.meanings}"' in said("cdo -s showattribute,ending@flag_meanings", path)
    assert f'criterion = "{truth.criterion}"' in said("cdo -s showattribute,criterion", path)
    table = said(f"cdo -s infon -selname,{name}", path).splitlines()[1].split()
    assert table[5:7] == [str(np.prod(truth.shape)), str(np.prod(truth.shape) - truth.known)]
    # CDO sums with weights 1/n, so that the last digit is its own
    assert float(said(f"cdo -s outputf,%.17g -fldmean -selname,{name}", path)) == truth.mean


@pytest.mark.parametrize("operator", ["copy", "selname"])
def test_what_cdo_writes_again_is_still_an_atlas(path, spec, operator, tmp_path, command):
    """CDO leaves the scalar coordinates out and adds missing_value: a grid is read and verified still."""
    program("cdo")
    with xr.open_dataset(path, engine="netcdf4") as atlas:
        names = f",{','.join(map(str, atlas.data_vars))}" if operator == "selname" else ""
    copy = tmp_path / "copy.nc"
    said(f"cdo -s {operator}{names}", path, copy)
    with netCDF4.Dataset(copy) as file:
        assert "alpha" not in file.variables
        assert file["tilt_min"].missing_value == file["tilt_min"]._FillValue
    if spec is LIST:
        # it leaves the parameters of the starts out too, and no spec of a table holds them
        assert "start must be whole numbers" in command(f"info {copy}")[2]
        return
    assert "alpha 0.5" in command(f"info {copy}")[1]
    again = tmp_path / "again.nc"
    for line in (
        f"verify {copy}",
        f"run --from {copy} -o {again}",
        f"compare {copy} {again} --exact",
    ):
        status, out, err = command(line)
        assert status == 0, out + err
    assert command(f"boundary {copy}") == command(f"boundary {path}")


def test_cdo_keeps_the_fixed_parameters(path, spec, name, tmp_path):
    """Selecting a variable leaves out the coordinates of no dimension; the attributes with their numbers stay."""
    program("cdo")
    said(f"cdo -s selname,{name}", path, tmp_path / "part.nc")
    with netCDF4.Dataset(path) as whole, netCDF4.Dataset(tmp_path / "part.nc") as part:
        for each in ("alpha", "radius", "gravity", *(["contour_damping", "mass"] if spec is LOSSY else [])):
            assert part.getncattr(each) == whole[each][...].item()
            assert part.getncattr(f"{each}_units") == whole[each].units
        assert part.getncattr("criterion_meaning") == whole.getncattr("criterion_meaning")


def test_nco(path, spec, name, truth, tmp_path):
    """NCO finds units and flags, and its mean leaves the gaps out, which it would not do with NaN as fill value."""
    program("ncwa", "ncks")
    said(f"ncwa -O -y avg -v {name}", path, tmp_path / "mean.nc")
    with netCDF4.Dataset(tmp_path / "mean.nc") as file:
        assert float(file[name][...]) == truth.mean
    found = json.loads(said("ncks --json -m -M", path))
    assert found["dimensions"] == dict(zip(spec.axes, truth.shape, strict=True))
    assert found["variables"][name]["attributes"]["units"] == truth.units
    assert found["variables"]["ending"]["attributes"]["flag_values"] == truth.flags
    assert found["variables"]["ending"]["type"] == "byte"
    assert found["attributes"]["criterion"] == truth.criterion


def test_gdal(path, spec, name, truth, tmp_path):
    """GDAL's multidimensional driver finds names, units, gaps and the mean."""
    program("gdalmdiminfo")
    # it leaves its statistics beside the file
    copy = shutil.copy(path, tmp_path / "atlas.nc")
    whole = json.loads(said("gdalmdiminfo", copy))
    assert set(whole["arrays"]) >= {*spec.model.variables, *spec.axes, *spec.listed}
    assert whole["attributes"]["criterion"] == truth.criterion
    assert whole["arrays"]["ending"]["attributes"]["flag_meanings"] == truth.meanings
    assert whole["arrays"]["ending"]["attributes"]["flag_values"] == truth.flags
    field = json.loads(said(f"gdalmdiminfo -stats -array {name}", copy))
    assert (field["dimension_size"], field["unit"]) == (truth.shape, truth.units)
    assert field["statistics"]["valid_sample_count"] == truth.known
    assert field["statistics"]["mean"] == truth.mean


def test_h5netcdf(path):
    """h5netcdf, which reads HDF5 without the netCDF library, gives xarray the same dataset."""
    with (
        xr.open_dataset(path, engine="h5netcdf") as found,
        xr.open_dataset(path, engine="netcdf4") as expected,
    ):
        # the one library gives a lone number as an array of one; the text and all values are compared exactly
        xr.testing.assert_equal(found, expected)
        for name in expected.variables:
            assert found[name].dtype == expected[name].dtype, name
            assert found[name].attrs.get("units") == expected[name].attrs.get("units"), name
        assert (
            found["ending"].attrs["flag_values"].tolist() == expected["ending"].attrs["flag_values"].tolist()
        )
        assert found.attrs["sweep_spec"] == expected.attrs["sweep_spec"]


@pytest.mark.parametrize(
    "units",
    sorted({
        each.units
        for model in (DISK, LOSSY_DISK)
        for table in (model.parameters, model.settings, model.variables)
        for each in table.values()
    }),
)  # fmt: skip
def test_udunits(units):
    """The library that CF names for units reads every one that a file can hold."""
    program("udunits2")
    assert said(f"udunits2 -H '{units}' -W '{units}'").strip().startswith(("1 ", f"1 {units}"))


@pytest.mark.parametrize(
    ("user", "ci", "asked", "said"),
    [
        (1000, "", "", "sudo apt-get install --no-install-recommends netcdf-bin cdo nco"),
        (0, "", "", "sudo apt-get install --no-install-recommends netcdf-bin cdo nco"),
        (1000, "", "install", "The installation failed, see "),
        (0, "", "install", "The installation failed, see "),
        (1000, "true", "install", "The installation failed, see "),
    ],
    ids=["developer", "root", "developer installs", "root installs", "CI installs"],
)
def test_the_set_up_says_what_is_missing_and_goes_on(tmp_path, user, ci, asked, said):
    """Programs are installed only when asked for; a missing program or a failed installation stops nothing."""
    stubs = {"id": f"echo {user}", "dpkg-query": "exit 1", "apt-get": f'echo "$@" >>{tmp_path}/asked; exit 1'}
    stubs["sudo"] = '[ "$1" != -n ] || shift; exec "$@"'
    for name, body in stubs.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / name).chmod(0o755)
    (tmp_path / ".venv").mkdir()
    script = Path(__file__).parents[2] / "scripts" / "readers.sh"
    done = subprocess.run(
        ["bash", "-uc", f"checkout={tmp_path}; source {script}; prepare_readers {asked}"],
        env={"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}", "CI": ci},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "")
    assert said in done.stderr
    assert (tmp_path / "asked").exists() == bool(asked)
