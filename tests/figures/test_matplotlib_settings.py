"""Matplotlib settings do not change figures."""

import os
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest

import sweep
from sweep.figures import plots

CHECKOUT = Path(__file__).resolve().parents[2]

MATPLOTLIBRC = (
    "lines.linewidth: 20\ntext.usetex: True\naxes.facecolor: red\nsavefig.bbox: tight\nfont.size: 30\n"
)


@pytest.fixture(scope="module")
def hostile(tmp_path_factory):
    """Return a folder with matplotlib settings and a small atlas."""
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "matplotlibrc").write_text(MATPLOTLIBRC, encoding="utf-8")
    sweep.run_to_file(sweep.SweepSpec(tilt="1deg:2deg:3", roll_rate="2:3:4"), folder / "atlas.nc")
    return folder


def started(folder, *line, **more):
    """Run Python in a folder and return the finished process."""
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT), **more}
    return subprocess.run(
        [sys.executable, *line], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.slow_lane
def test_a_figure_is_a_function_of_its_atlas(hostile, tmp_path):
    """The command draws the same bytes with a matplotlibrc and with settings in the environment."""
    with sweep.open_atlas(hostile / "atlas.nc") as atlas:
        plots.save(plots.figure([atlas]), tmp_path / "here.png")
    line = ["-m", "sweep", "plot", "atlas.nc", "-o", str(tmp_path / "there.png")]
    done = started(hostile, *line, MATPLOTLIBRC=str(hostile / "matplotlibrc"), MPLBACKEND="bad")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "there.png").read_bytes() == (tmp_path / "here.png").read_bytes()


@pytest.mark.slow_lane
def test_a_program_may_set_matplotlib_up_and_gets_the_same_figure(hostile, tmp_path):
    """In Python, the program's settings neither change a figure nor are changed by it."""
    with sweep.open_atlas(hostile / "atlas.nc") as atlas:
        plots.save(plots.figure([atlas]), tmp_path / "plain.png")
        with matplotlib.rc_context(
            {"lines.linewidth": 20.0, "axes.facecolor": "red", "savefig.bbox": "tight"}
        ):
            before = dict(matplotlib.rcParams)
            plots.save(plots.figure([atlas]), tmp_path / "set-up.png")
            assert dict(matplotlib.rcParams) == before
    assert (tmp_path / "plain.png").read_bytes() == (tmp_path / "set-up.png").read_bytes()
