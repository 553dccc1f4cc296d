"""What a run will take is said beforehand, quickly and in words."""

import subprocess
import sys
from collections import namedtuple

import numpy as np
import pytest

from sweep.engine import estimate
from sweep.engine.calibrate import coarse
from sweep.request.spec import SweepSpec


def test_plan_writes_nothing_and_counts_right(command, tmp_path):
    """Cells and blocks follow from the grid; without calibration no time is promised."""
    status, out, err = command(
        "plan rolling roll_rate=0.5:6:1000 tilt=0.1deg:9deg:300 --block-cells 70000 --no-calibrate"
    )
    assert (status, err) == (0, "")
    assert out.splitlines()[:3] == [
        "cells    300000 (1000 x 300)",
        "blocks   5 of 70000 cells",
        "time     not measured",
    ]
    # 46 bytes a cell, the types in the table of variables but for those that follow from the others; 63 in all
    assert (
        "disk     at most 14 MB for the journal, which goes at the end, and at most 15 MB for the file" in out
    )
    assert list(tmp_path.iterdir()) == []


def test_plan_without_calibration_loads_no_numba(tmp_path):
    """Neither numba nor the file libraries are loaded, and the answer is quick."""
    code = (
        "import sys; sys.argv = ['eulerdisk', 'plan', 'rolling', '--no-calibrate']\n"
        "from sweep.cli import main\n"
        "try: main()\n"
        "finally: print(*{name.partition('.')[0] for name in sys.modules}, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (
        set(done.stderr.split()) & {"numba", "llvmlite", "xarray", "netCDF4", "scipy", "matplotlib"} == set()
    )
    assert done.stdout.startswith("cells    160200 (801 x 200)\n")


@pytest.mark.compiled
def test_plan_measures(command):
    """With calibration a time is given, in the words in which a run says what it has to go."""
    status, out, _ = command("plan rolling")
    assert status == 0
    assert "time     about " in out
    assert " s (" in out
    assert " cells per second)" in out


def test_plan_says_what_does_not_fit(command):
    """A run larger than the disk: status 1."""
    status, out, _ = command("plan rolling roll_rate=0:9:1000000 tilt=0:1:900000 --no-calibrate")
    assert status == 1
    assert "does not fit" in out


def test_plan_refuses_an_output_that_cannot_be(command):
    """As `run` does, with status 2 and one message."""
    status, out, err = command("plan rolling --no-calibrate -o nowhere/a.nc")
    assert (status, out) == (2, "")
    assert err.startswith("eulerdisk: nowhere/a.nc: no such folder. Rule: ")


def test_a_file_system_without_a_size_is_not_a_full_one(command, monkeypatch):
    """Some say that they have no room at all, and take what comes."""
    monkeypatch.setattr(
        estimate.shutil, "disk_usage", lambda _: namedtuple("usage", "total used free")(0, 0, 0)
    )
    status, out, _ = command("plan rolling --no-calibrate")
    assert status == 0
    assert "nobody knows how much is free in " in out
    assert command("run rolling roll_rate=2:4:3 tilt=1deg -o a.nc")[0] == 0


@pytest.mark.parametrize(
    ("rate", "threads", "processors", "expected"),
    [
        (1e3, 1, 2, 1000.0),  # computing is all
        (1e9, 2, 2, 1.0),  # writing is all
        (1e6, 1, 2, 1.0),  # both at once
        (1e6, 2, 2, 1.5),  # both at once, but the writer takes a processor from those who compute
        (1e6, 1, 1, 2.0),  # one after the other
        (1e6, 8, 64, 1.0),
    ],
)
def test_the_time_of_a_run(rate, threads, processors, expected):
    """A million cells are written in a second, while others are computed, on as many processors as there are."""
    assert estimate.seconds(10**6, rate, threads, processors) == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.2, "0 s"), (119.4, "119 s"), (600, "10 min"), (9000, "2.5 h"), (400000, "4.7 days")],
)
def test_times_for_people(seconds, text):
    """Seconds, minutes, hours or days, whichever is read at a glance."""
    assert estimate.duration(seconds) == text


@pytest.mark.parametrize("cells", [1, 10, 500, 10**6])
def test_a_coarse_grid_is_spread_over_the_grid(cells):
    """It has about as many cells as asked for, at most those of the grid, and values of the grid's own axes."""
    spec = SweepSpec.preset("rolling")
    sample = coarse(spec, cells)
    assert min(cells, spec.size) / 4 <= sample.size <= min(4 * cells, spec.size)
    for name in spec.axes:
        value = getattr(sample, name)
        assert set(np.atleast_1d(value.array())) <= set(getattr(spec, name).array())
