"""Every file of the project follows the conventions that it declares, by the IOOS compliance checker."""

import json
import re
import subprocess
import sys
from pathlib import Path

import lossy_runner
import netCDF4
import pytest

import sweep
from sweep.checks.verify import verify

pytestmark = pytest.mark.release

CHECKER = Path(sys.executable).with_name("compliance-checker")
SPECS = {
    "rolling": sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:9", tilt="0.1deg:30deg:5:log"),
    "circling": sweep.SweepSpec.preset("circling").replace(tilt="5deg:15deg:3", precession_rate="0:5:12"),
    "cube": sweep.SweepSpec(alpha="0.5,1", tilt="1deg,2deg", precession_rate="3:6:7", title="Münze"),
    "cell": sweep.SweepSpec(tilt="1deg", roll_rate=3),
    "refined": sweep.SweepSpec(
        roll_rate="2:3:5", tilt="0.1deg:1deg:4", alpha=[0.5, 1.0], boundary="refined:1e-6"
    ),
    "steady": sweep.SweepSpec(
        tilt="5deg,10deg", precession_rate="steady-slow", roll_rate="-8:8:5", tilt_rate=1e-3
    ),
    "random": sweep.SweepSpec(roll_rate="uniform:2:4", tilt="normal:1deg:0.2deg", samples=30),
    "lossy": sweep.SweepSpec(
        roll_rate="10:40:4",
        rolling_friction="0,10um,100um",
        contour_damping=1e-8,
        air_law="bildsten",
        air_viscosity=1.8e-5,
        air_density=1.2,
        mass="7.5g",
        radius="12mm",
        friction=0.5,
        tilt="1deg",
        duration="1s",
    ),
    "table": sweep.SweepSpec(starts={"roll_rate": [2.0, 3.5], "alpha": [0.5, 1.0]}, tilt="1deg"),
}


def complaints(results):
    """Return the results of a checklist that lose points, as text."""
    return [
        each["name"] + "; ".join(each["msgs"]) for each in results if each["value"][0] != each["value"][1]
    ]


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """Return the checker's results for every kind of file: name -> checklist -> results."""
    folder = tmp_path_factory.mktemp("files")
    with lossy_runner.general_kernels():
        for name, spec in SPECS.items():
            sweep.run_to_file(spec, folder / f"{name}.nc")
    sweep.save(sweep.run(SPECS["rolling"]), folder / "saved.nc")
    with sweep.open_atlas(folder / "circling.nc") as atlas:
        sweep.save(sweep.reclassify(atlas, "departure:2deg"), folder / "reclassified.nc")
        sweep.save(verify(atlas), folder / "audit.nc")
    with sweep.open_atlas(folder / "random.nc") as atlas:
        sweep.save(verify(atlas), folder / "audited-list.nc")
    with lossy_runner.general_kernels(), sweep.open_atlas(folder / "lossy.nc") as atlas:
        sweep.save(verify(atlas), folder / "audited-lossy.nc")
    stopping = sweep.simulate("toy", tilt="80deg", contour_friction="0.1mm")
    sweep.save(stopping, folder / "stopping.nc")
    sweep.run_to_file(SPECS["circling"].replace(method="exact"), folder / "exact.nc")
    sweep.run_to_file(SPECS["circling"].replace(contact="yes"), folder / "contact.nc")
    sweep.save(sweep.simulate(tilt=0.1, tilt_rate=0.1), folder / "motion.nc")
    ring = sweep.simulate(body="torus", tube=0.2, tilt=0.1, tilt_rate=0.1, duration="1s")
    sweep.save(ring, folder / "ring.nc")
    sweep.run_to_file(SPECS["cell"], folder / "spoiled.nc")
    with netCDF4.Dataset(folder / "spoiled.nc", "a") as file:
        file.delncattr("title")
        file["tilt_min"].units = "degrees of angle"
        file["stability"].flag_meanings = "undecided stable"
    words = [CHECKER, "-t", "cf:1.11", "-t", "acdd:1.3", "-f", "json_new", "-o", folder / "report.json"]
    subprocess.run([*words, *folder.glob("*.nc")], capture_output=True, check=False)
    report = json.loads((folder / "report.json").read_text())
    assert len(report) == 20
    return {Path(name).name: lists for name, lists in report.items()}


def test_cf(judged):
    """The files have no error or warning of CF 1.11."""
    for name, lists in judged.items():
        results = lists["cf:1.11"]["all_priorities"]
        assert len(results) > 10, name
        assert name == "spoiled.nc" or complaints(results) == [], name


def test_acdd(judged):
    """They have all that ACDD 1.3 highly recommends, except standard names (CF has none for rigid bodies)."""
    for name, lists in judged.items():
        results = lists["acdd:1.3"]["high_priorities"]
        assert len(results) > 3, name
        for each in results if name != "spoiled.nc" else ():
            assert set(each["msgs"]) <= {"standard_name"}, (name, complaints([each]))


def test_the_checker_sees_what_is_wrong(judged):
    """A file with a missing title, wrong units and a wrong flag does not pass."""
    lists = judged["spoiled.nc"]
    said = " ".join(complaints(lists["cf:1.11"]["all_priorities"]))
    assert re.search("tilt_min", said)
    assert re.search("flag_meanings", said)
    assert "title" in " ".join(complaints(lists["acdd:1.3"]["high_priorities"]))


def test_the_ending_is_the_status_flag_of_the_measures():
    """CF readers find when to trust a value: the ancillary variables include a status flag."""
    atlas = sweep.run(SPECS["rolling"])
    assert atlas["ending"].attrs["standard_name"] == "status_flag"
    assert atlas["tilt_max"].attrs["ancillary_variables"] == "ending"
    linked = ["boundary_roll_rate_halfwidth", "boundary_roll_rate_status"]
    assert atlas["boundary_roll_rate"].attrs["ancillary_variables"].split() == linked
    assert atlas[linked[1]].attrs["standard_name"] == "status_flag"
