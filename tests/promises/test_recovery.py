"""Runs survive kill -9 at any moment, full disks, file-size limits and damaged blocks (cf. scripts/soak)."""

import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

import pytest
from messages import assert_facts
from processes import CHECKOUT, python

from sweep.errors import are

DATED = {"SOURCE_DATE_EPOCH": "1700000000"}
WORDS = ["rolling", "roll_rate=2:4:100", "tilt=0.1deg:5deg:100", "--block-cells", "500", "-o", "a.nc"]


def run(folder, *words, **how):
    """Run a command in a folder and return its result."""
    return python("-m", "sweep", *words, folder=folder, environment=DATED, **how)


@pytest.mark.release
@pytest.mark.compiled
def test_kills_and_damages_change_no_byte(tmp_path):
    """A short soak test: after any kill or damage, files are absent or equal to an undisturbed run's."""
    soak = CHECKOUT / "scripts" / "fault_injection.py"
    few = ["--moments", "1", "--damages", "60", "--every", "4", "--cells", "0"]
    done = python(soak, *few, folder=tmp_path, environment=DATED)
    assert done.returncode == 0, done.stdout + done.stderr
    kills = [int(found) for found in re.findall(r"(\d+) kills", done.stdout)]
    assert len(kills) == 6
    assert min(kills) >= 1
    assert int(re.search(r"crashed: before (\d+) of", done.stdout)[1]) >= 8
    assert "damaged: 60 of 60 caught; file after mending 4 blocks the same: True" in done.stdout


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize(("limit", "where"), [(8_000, "block"), (300_000, "file")])
def test_a_limit_on_file_sizes(tmp_path, limit, where):
    """If a block or the file exceeds it: status 3, whole blocks are kept, advice, and the run can resume."""

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    done = run(tmp_path, "run", *WORDS, preexec_fn=limited)
    assert done.returncode == 3, done.stderr
    assert re.search(r"\[Errno 27\]|HDF error", done.stderr)
    assert re.search(r"`ulimit -f \d+`", done.stderr)
    assert not (tmp_path / "a.nc").exists()
    kept = list(tmp_path.glob("a.nc.run/blocks/*.block"))
    assert_facts(done.stderr, *(["20 of 20 blocks", "a.nc.run"] if kept else ["no block"]))
    assert len(kept) == (0 if where == "block" else 20)
    assert not [each for each in tmp_path.rglob("*") if each.suffix == ".tmp" or each.name == "assembled.nc"]
    again = run(tmp_path, "run", *WORDS)
    assert again.returncode == 0, again.stderr
    assert [each.name for each in tmp_path.iterdir()] == ["a.nc"]


@pytest.fixture
def small_disk(tmp_path):
    """Yield a disk of two megabytes."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", str(folder)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("needs the right to mount a small disk")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize("left", [200_000, 600_000], ids=["journal", "file"])
def test_a_full_disk(small_disk, left):
    """If the disk fills up: status 3, whole blocks are kept, the needed space is named, resuming works."""
    ballast = small_disk / "ballast"
    # The room check is disabled, as if others filled the disk later.
    code = (
        "import sys, shutil; sys.argv = ['eulerdisk', 'run', *sys.argv[1:]]\n"
        "from sweep.runs import forecast; forecast.check_room = lambda *_: None\n"
        "from sweep.cli import main; main()"
    )

    def begun():
        return python("-c", code, *WORDS, folder=small_disk, environment=DATED)

    ballast.write_bytes(bytes(2_090_000 - left))
    done = begun()
    assert done.returncode == 3, done.stderr
    assert re.search(r"\bFree\b.*\b\d+ MB\b", done.stderr)
    kept = list(small_disk.glob("a.nc.run/blocks/*.block"))
    assert 0 < len(kept) <= 20
    assert not (small_disk / "a.nc").exists()
    ballast.unlink()
    again = begun()
    assert again.returncode == 0, again.stderr
    assert f"{len(kept)} of 20 blocks {are(len(kept))} finished" in again.stderr
    assert [each.name for each in small_disk.iterdir()] == ["a.nc"]


_PROGRAM = """
import sweep
spec = sweep.SweepSpec.from_words("rolling", ["roll_rate=2:4:600", "tilt=0.1deg:5deg:600"])
sweep.run_to_file(spec, "a.nc", block_cells=1000, command="x")
"""


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_an_interrupted_python_program(tmp_path):
    """Ctrl-C in a program that calls `run_to_file` ends it at once; finished blocks are kept for resuming."""
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    command = [sys.executable, "-c", _PROGRAM]
    process = subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True)
    while len(list(tmp_path.glob("a.nc.run/blocks/*.block"))) < 5:
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=300)
    assert process.returncode != 0
    assert "KeyboardInterrupt" in err
    kept = list(tmp_path.glob("a.nc.run/blocks/*"))
    assert len(kept) >= 5
    assert all(path.suffix == ".block" for path in kept)
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc.run"]
    assert python("-c", _PROGRAM, folder=tmp_path).returncode == 0
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
