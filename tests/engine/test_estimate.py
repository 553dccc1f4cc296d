"""What a run will take: memory, times in words, and the coarse grid on which the speed is measured."""

import numpy as np
import pytest

from sweep.engine import estimate
from sweep.engine.estimate import coarse
from sweep.request.spec import SweepSpec


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.24, "0.2 s"),
        (9.94, "9.9 s"),
        (9.96, "10 s"),
        (119.4, "119 s"),
        (600, "10 min"),
        (9000, "2.5 h"),
        (400000, "4.7 days"),
    ],
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


@pytest.mark.parametrize(
    "spec",
    [
        SweepSpec(roll_rate="1:4:100000", tilt="1deg:5deg:100000"),
        SweepSpec(roll_rate="1:4:100000", tilt="1deg:5deg:100000", boundary="refined"),
        SweepSpec(roll_rate="1:4:2000", precession_rate="1:4:2000", tilt="1deg:5deg:2000"),
    ],
)
def test_the_memory_of_a_run_does_not_grow_with_its_cells(spec):
    """A run of 1e10 cells stays below 1 GB."""
    assert estimate.memory_bytes(spec) < 1e9
    few = spec.replace(roll_rate="1:4:1000")
    assert spec.size - few.size > estimate.memory_bytes(spec)
