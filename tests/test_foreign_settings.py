"""Settings of other libraries in the current folder change neither numbers nor figures."""

import os
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest

import sweep
from sweep.figures import plots

CHECKOUT = Path(__file__).resolve().parents[1]

MATPLOTLIBRC = (
    "lines.linewidth: 20\ntext.usetex: True\naxes.facecolor: red\nsavefig.bbox: tight\nfont.size: 30\n"
)
NUMBA_CONFIG = "disable_jit: 1\ncpu_name: generic\nopt: 1\n"

#: What Numba is told, in a process that imports this package first, or after Numba.
_TOLD = "import {}, {}; from numba import config; print(config.DISABLE_JIT, config.CPU_NAME, int(config.OPT))"


@pytest.fixture(scope="module")
def hostile(tmp_path_factory):
    """Return a folder with settings of Numba and matplotlib, and a small atlas."""
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "matplotlibrc").write_text(MATPLOTLIBRC, encoding="utf-8")
    (folder / ".numba_config.yaml").write_text(NUMBA_CONFIG, encoding="utf-8")
    sweep.run_to_file(sweep.SweepSpec(tilt="1deg:2deg:3", roll_rate="2:3:4"), folder / "atlas.nc")
    return folder


def started(folder, *line, **more):
    """Run Python in a folder, and return the process that has ended."""
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT), **more}
    return subprocess.run(
        [sys.executable, *line], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("order", [("sweep", "numba"), ("numba", "sweep")])
def test_numbas_file_has_no_effect(hostile, order):
    """Whichever of the two is imported first, Numba compiles as it does without the file."""
    pytest.importorskip("yaml")
    done = started(hostile, "-W", "ignore", "-c", _TOLD.format(*order), NUMBA_DISABLE_JIT="0")
    assert done.stdout.split() == ["0", "None", "3"]


def test_numbas_variables_keep_theirs(hostile):
    """What the environment says of Numba holds."""
    done = started(
        hostile, "-c", _TOLD.format("sweep", "numba"), NUMBA_CPU_NAME="generic", NUMBA_DISABLE_JIT="0"
    )
    assert done.stdout.split() == ["0", "generic", "3"]


def test_a_figure_is_a_function_of_its_atlas(hostile, tmp_path):
    """The command draws the same bytes beside a matplotlibrc and with settings in the environment."""
    with sweep.open_atlas(hostile / "atlas.nc") as atlas:
        plots.save(plots.figure([atlas]), tmp_path / "here.png")
    line = ["-m", "sweep", "plot", "atlas.nc", "-o", str(tmp_path / "there.png")]
    done = started(hostile, *line, MATPLOTLIBRC=str(hostile / "matplotlibrc"), MPLBACKEND="bad")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "there.png").read_bytes() == (tmp_path / "here.png").read_bytes()


def test_a_matplotlibrc_that_cannot_be_read_is_not_read(tmp_path):
    """What would end the import of matplotlib does not end the command."""
    (tmp_path / "matplotlibrc").write_bytes(b"\xff\xfe: [")
    ignored = "from sweep.foreign_settings import ignore_matplotlibrc as ignore; ignore(); ignore()"
    done = started(
        tmp_path,
        "-c",
        f"{ignored}; import matplotlib, os; print(matplotlib.rcParams['font.size'], os.getcwd())",
    )
    assert (done.stdout.split(), done.stderr) == (["10.0", str(tmp_path)], "")


def test_a_program_may_set_matplotlib_up_and_gets_the_same_figure(hostile, tmp_path):
    """In Python the settings of the program neither change a figure nor are changed by it."""
    with sweep.open_atlas(hostile / "atlas.nc") as atlas:
        plots.save(plots.figure([atlas]), tmp_path / "plain.png")
        with matplotlib.rc_context(
            {"lines.linewidth": 20.0, "axes.facecolor": "red", "savefig.bbox": "tight"}
        ):
            before = dict(matplotlib.rcParams)
            plots.save(plots.figure([atlas]), tmp_path / "set-up.png")
            assert dict(matplotlib.rcParams) == before
    assert (tmp_path / "plain.png").read_bytes() == (tmp_path / "set-up.png").read_bytes()


@pytest.mark.parametrize("name", [".ncrc", ".dodsrc"])
def test_netcdfs_file_is_not_read(hostile, tmp_path, name):
    """A pipe of that name in the current folder, which would hold its reader for ever, does not hold the command."""
    os.mkfifo(tmp_path / name)
    line = [sys.executable, "-m", "sweep", "info", str(hostile / "atlas.nc")]
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    done = subprocess.run(line, cwd=tmp_path, env=environment, capture_output=True, check=False, timeout=20)
    assert done.returncode == 0
