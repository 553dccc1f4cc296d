"""The pytest plugin in another project: a run of pytest in a separate folder."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import netCDF4
import pytest
from messages import assert_facts, assert_in_order

import sweep

CHECKOUT = Path(__file__).parents[1]
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join([str(CHECKOUT), os.environ.get("PYTHONPATH", "")])}

#: A preset, a spec file next to the test, and a reference to be damaged.
TESTS = """
def test_file(eulerdisk_atlas):
    eulerdisk_atlas("mine.toml alpha=1", "data/file.nc")

def test_changed(eulerdisk_atlas):
    eulerdisk_atlas("rolling roll_rate=3 tilt=1deg", "data/changed.nc")

def test_allowed(eulerdisk_atlas):
    eulerdisk_atlas("rolling roll_rate=3 tilt=1deg", "data/changed.nc", tolerances={"tilt_max": 1.0})

def test_exact(eulerdisk_atlas):
    eulerdisk_atlas("mine.toml alpha=1", "data/file.nc", exact=True)

def test_other(eulerdisk_atlas):
    eulerdisk_atlas("rolling roll_rate=3 tilt=1deg", "data/other.nc")
"""

#: Impossible requests: an unknown word, and a missing folder.
WRONG = """
def test_word(eulerdisk_atlas):
    eulerdisk_atlas("rolling roll_rte=3", "data/word.nc")

def test_folder(eulerdisk_atlas):
    eulerdisk_atlas("rolling roll_rate=3 tilt=1deg", "missing/folder.nc")
"""


@pytest.fixture
def project(tmp_path):
    """Return a folder with tests that use the plugin."""
    (tmp_path / "data").mkdir()
    (tmp_path / "test_mine.py").write_text(TESTS)
    (tmp_path / "mine.toml").write_text('roll_rate = 3\ntilt = "1deg:2deg:3"\n')
    return tmp_path


def run(folder, *words):
    """Run pytest in a folder, without other plugins' effects, and return its status and output."""
    without = [
        word for name in ("cacheprovider", "hypothesispytest", "zarr") for word in ("-p", f"no:{name}")
    ]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-rA", *without, *words],
        cwd=folder,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout


@pytest.mark.slow_lane
def test_references_are_written_and_compared(project):
    """Without references the tests fail with advice; once written, they pass unless a reference differs."""
    status, said = run(project)
    assert status == 1
    assert said.count("pytest --eulerdisk-regen") >= 3
    status, said = run(project, "--eulerdisk-regen")
    assert (status, "5 skipped" in said) == (0, True)
    assert re.search(r"^eulerdisk: data/file\.nc ", said, re.MULTILINE)
    with sweep.open_atlas(project / "data" / "file.nc") as atlas:
        assert atlas.attrs["history"].endswith("Z eulerdisk run mine.toml alpha=1 -o data/file.nc")
        assert float(atlas["alpha"]) == 1.0
    with netCDF4.Dataset(project / "data" / "changed.nc", "a") as file:
        file["tilt_max"][...] = 0.5
    shutil.copy(project / "data" / "file.nc", project / "data" / "other.nc")
    status, said = run(project)
    assert (status, "2 failed, 3 passed" in said) == (1, True)
    (line,) = {each.strip("E ") for each in said.splitlines() if "DIFFERENT" in each and "1 of 1" in each}
    assert_in_order(line, "tilt_max", "1 of 1")
    assert_facts(said, "worst cell", "differ in alpha")


@pytest.mark.slow_lane
def test_a_wrong_request_is_one_line(project):
    """An impossible request fails the test with the command's message, without a traceback."""
    (project / "test_mine.py").write_text(WRONG)
    status, said = run(project, "--eulerdisk-regen")
    assert (status, "2 failed" in said) == (1, True)
    assert_facts(said, "roll_rate?")
    assert str(project / "missing") in said
    assert "RequestError" not in said
