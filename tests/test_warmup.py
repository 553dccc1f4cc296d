"""`eulerdisk warmup`, and what the commands load before they know that they have something to do."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import sweep
from sweep.engine.compiled import cache_folder

CHECKOUT = Path(__file__).parents[1]
SLOW_TO_LOAD = {"numba", "llvmlite", "xarray", "scipy", "matplotlib", "pandas", "pint"}


def run(folder, *words, before=(), **environment):
    """Run the command in a folder."""
    return subprocess.run(
        [sys.executable, *before, "-m", "sweep", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT), **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


@pytest.mark.compiled
def test_warmup_fills_the_cache(tmp_path):
    """Afterwards the kernels of both methods lie in the folder that it names, and nothing else was written."""
    done = run(tmp_path, "warmup")
    assert (done.returncode, done.stderr) == (0, "")
    first, second, last = done.stdout.splitlines()
    assert first.startswith("rk4    ready after ")
    assert second.startswith("exact  ready after ")
    assert last == f"cache  {cache_folder()}"
    compiled = {path.name.partition("-")[0] for path in cache_folder().rglob("*.nbc")}
    assert {"schedule.integrate", "extremes.reduce", "legendre.build_tables"} <= compiled
    assert list(tmp_path.iterdir()) == []


def test_warmup_says_that_nothing_was_kept(tmp_path):
    """Where the kernels cannot be kept, here because nothing is compiled, it ends with 2 and says what to do."""
    done = run(tmp_path, "warmup", NUMBA_DISABLE_JIT="1", EULERDISK_CACHE_DIR=str(tmp_path / "cache"))
    assert done.returncode == 2
    assert "could not be kept" in done.stderr
    assert "set EULERDISK_CACHE_DIR" in done.stderr


@pytest.mark.parametrize(
    "line",
    [
        "--help",
        "warmup --help",
        "run roling -o b.nc",
        "run rolling tilt=1:2:0 -o b.nc",
        "run rolling device=gpu -o b.nc",
        "run rolling -o missing/b.nc",
        "run rolling -o a.nc",
        "run missing.toml -o b.nc",
        "info missing.nc",
        "plan rolling --no-calibrate",
        "verify missing.nc",
        "plot missing.nc -o b.png",
        "plot a.nc -o b.gif",
    ],
)
def test_what_needs_nothing_heavy_loads_nothing_heavy(tmp_path, line):
    """Help, and every request that can be refused by its words and file names, is answered without waiting."""
    (tmp_path / "a.nc").write_text("old")
    done = run(tmp_path, *line.split(), before=("-X", "importtime"))
    lines = [line for line in done.stderr.splitlines() if line.startswith("import time:")]
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in lines}
    assert done.returncode == (0 if "--help" in line or "plan" in line else 2)
    assert "typer" in loaded
    assert loaded & SLOW_TO_LOAD == set()


def test_the_package_loads_light():
    """`import sweep` and a spec wait for none of them either."""
    code = "import sys, sweep; sweep.SweepSpec.preset('rolling'); print(*{n.partition('.')[0] for n in sys.modules})"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    assert set(done.stdout.split()) & SLOW_TO_LOAD == set()
    assert sweep.__name__ in done.stdout
