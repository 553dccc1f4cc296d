"""What a run will take: memory, times in words, and the coarse grid on which the speed is measured."""

import numpy as np
import pytest

from sweep.engine import estimate
from sweep.engine.estimate import coarse
from sweep.request.spec import SweepSpec


def test_a_coarse_grid_is_spread_over_the_grid():
    """It has about as many cells as asked for, at most those of the grid, and values of the grid's own axes."""
    for cells in [1, 10, 500, 10**6]:
        spec = SweepSpec.preset("rolling")
        sample = coarse(spec, cells)
        assert min(cells, spec.size) / 4 <= sample.size <= min(4 * cells, spec.size)
        for name in spec.axes:
            value = getattr(sample, name)
            assert set(np.atleast_1d(value.array())) <= set(getattr(spec, name).array())


def test_the_memory_of_a_run_holds_the_verdicts_and_what_the_boundary_has():
    """A byte of each cell and 40 of each row; for curves three more of a cell, and 160 of each point."""
    spec = SweepSpec(roll_rate="1:4:10000", tilt="1deg:5deg:100000")
    process = estimate.memory_bytes(SweepSpec(roll_rate="1:4:10000", tilt="1deg:5deg:99"))
    assert estimate.memory_bytes(spec) - process == pytest.approx(1e9 + 40 * 1e5 + 800 * 2**16, rel=0.01)
    more = estimate.memory_bytes(spec.replace(boundary="refined")) - estimate.memory_bytes(spec)
    assert more == pytest.approx(3e9 + 160 * 110000)


def test_what_a_file_stores_as_it_is():
    """The axes and the edge of a million rows of three cells, as numbers of bytes: half of what the cells take."""
    spec = SweepSpec(roll_rate="1:4:3", tilt="1deg:5deg:1000000")
    assert estimate.plain_bytes(spec) == 8 * 1000003 + 33 * 1000000
    assert estimate.plain_bytes(spec.replace(roll_rate=2.0)) == 8 * 1000000
