"""The first command of the README where it cannot work, or is stopped: a message and an exit status, no traceback."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[2]
SCRIPT = [sys.executable, str(CHECKOUT / "scripts" / "compute_atlases.py")]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(CHECKOUT)}


@pytest.mark.parametrize("name", ["there.txt", "there.txt/below"])
def test_an_output_that_can_be_no_folder(tmp_path, name):
    """A file in the place of the folder is refused with 2, by its name, and left as it is."""
    (tmp_path / "there.txt").write_text("mine")
    done = subprocess.run(
        [*SCRIPT, "-o", name], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"scripts/atlas: {name}: ")
    assert "folder" in done.stderr
    assert done.stderr.count("\n") == 1
    assert (tmp_path / "there.txt").read_text() == "mine"


@pytest.mark.compiled
def test_a_key_press_stops_it(tmp_path):
    """Ctrl-C while an atlas is computed ends with 130 and the command that goes on; no atlas is half there."""
    running = subprocess.Popen(SCRIPT, cwd=tmp_path, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)
    out = tmp_path / "atlas-out"
    end = time.monotonic() + 60.0
    while not any(out.glob("*.nc.run/blocks")) and time.monotonic() < end:
        time.sleep(0.005)
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert "interrupted" in err
    assert "scripts/atlas" in err
    assert "Traceback" not in err
    assert not (out / "circling.nc").exists()
