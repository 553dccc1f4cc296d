"""A test run: a dying test affects no other, and only the folders of failed tests remain."""

import os
import subprocess
import sys

import pytest

SUITE = """
import os, tempfile
import pytest

@pytest.mark.parametrize("number", range(12))
def test_small(number, tmp_path, tmp_path_factory):
    for folder in (tmp_path, tmp_path_factory.mktemp("shared"), tempfile.mkdtemp()):
        with open(os.path.join(folder, "text"), "w") as file:
            file.write("x")
    if number == 4:
        os._exit(1)
    assert number != 9

def test_large(tmp_path):
    with open(tmp_path / "bytes", "wb") as file:
        file.write(bytes(2_000_000))
"""

PLUGIN = """
import whole_run
from whole_run import WholeRun

whole_run.MOST_WRITTEN = 1e6

def pytest_addoption(parser):
    parser.addoption("--seed", type=int, default=0)

def pytest_configure(config):
    config.pluginmanager.register(WholeRun(config))
"""


@pytest.fixture
def run(tmp_path):
    """Return a function that runs the suite above with options; it returns the run and its file folder."""
    (tmp_path / "conftest.py").write_text(PLUGIN)
    (tmp_path / "test_suite.py").write_text(SUITE)
    (tmp_path / "pytest.ini").write_text("[pytest]\ntmp_path_retention_policy = failed\n")
    environment = {**os.environ, "PYTHONPATH": os.path.dirname(__file__), "PYTEST_ADDOPTS": ""}
    for name in list(environment):
        if name.startswith("PYTEST_XDIST"):
            del environment[name]

    def run(*options):
        done = subprocess.run(
            [
                sys.executable,
                "-m",
                "pytest",
                "-p",
                "no:cacheprovider",
                f"--basetemp={tmp_path / 'files'}",
                *options,
            ],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        return done, tmp_path / "files"

    return run


@pytest.mark.slow_lane
def test_a_test_that_dies_is_named_and_all_others_run(run):
    """With several processes the last lines count the tests that ran; only folders of failed tests remain."""
    done, files = run("-n", "2", "--dist", "load")
    assert done.returncode == 1
    failed = {line.split()[1] for line in done.stdout.splitlines() if line.startswith("FAILED ")}
    names = {"test_small[4]", "test_small[9]", "test_large"}
    assert failed == {f"test_suite.py::{name}" for name in names}
    assert "13 of 13 tests ran" in done.stdout.splitlines()[-2:]
    assert "2 MB" in done.stdout
    left = {path.parent.name for path in files.rglob("*") if path.is_file()}
    assert left == {"test_small_4_0", "test_small_9_0", "test_large0"}


@pytest.mark.slow_lane
def test_a_green_run_leaves_nothing(run):
    """One process runs some of the tests."""
    done, files = run("-k", "small and not 4 and not 9")
    assert (done.returncode, files.exists()) == (0, False)
    assert "10 of 10 tests ran" in done.stdout


@pytest.mark.slow_lane
def test_a_full_disk_ends_it_before_it_begins(run, tmp_path):
    """The run ends with status 2, the required bytes, and the variable for another folder."""
    with open(tmp_path / "conftest.py", "a") as file:
        file.write("whole_run.LEAST_FREE = 1e18\n")
    done, _ = run()
    assert done.returncode == 2
    assert "TMPDIR" in done.stdout + done.stderr
    assert "passed" not in done.stdout
