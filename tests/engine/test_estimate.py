"""What a run will take: memory, times in words, and the coarse grid on which the speed is measured."""

import numpy as np
import pytest

from sweep.engine import estimate
from sweep.engine.estimate import coarse
from sweep.request.spec import SweepSpec


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
        SweepSpec(roll_rate="1:4:1050", tilt="1deg:5deg:1000000000"),
        SweepSpec(tilt="1deg:5deg:1000000000", roll_rate="1:4:1050"),
        SweepSpec(tilt="1deg:5deg:1000000000", roll_rate="1:4:1050", boundary="refined"),
        SweepSpec(alpha="0.5:1:1000", roll_rate="1:4:1050", tilt="1deg:5deg:900000", boundary="refined"),
    ],
)
def test_the_memory_of_a_run_does_not_grow_with_its_cells(spec):
    """A run of 1e10 cells and more stays below 1 GB, also in 1e9 rows, and with 1e9 points of curves in one plane."""
    assert estimate.memory_bytes(spec) < 1e9
    few = spec.replace(roll_rate="1:4:1000")
    assert spec.size - few.size > estimate.memory_bytes(spec)


def test_curves_need_disk_while_they_are_joined():
    """A curve through 1e8 rows takes 33 bytes a point then and 32 in the file; one of 1e5 points needs no disk."""
    spec = SweepSpec(roll_rate="1:4:3", tilt="1deg:5deg:100000000", boundary="refined")
    assert estimate.scratch_bytes(spec) == pytest.approx(3.3e9)
    more = estimate.plain_bytes(spec) - estimate.plain_bytes(spec.replace(boundary="grid"))
    assert more == pytest.approx(3.2e9)
    assert estimate.scratch_bytes(spec.replace(tilt="1deg:5deg:100000")) == 0.0
    assert estimate.scratch_bytes(spec.replace(boundary="grid")) == 0.0


def test_what_a_file_stores_as_it_is():
    """The axes and the edge of a million rows of three cells, as numbers of bytes: half of what the cells take."""
    spec = SweepSpec(roll_rate="1:4:3", tilt="1deg:5deg:1000000")
    assert estimate.plain_bytes(spec) == 8 * 1000003 + 33 * 1000000
    assert estimate.plain_bytes(spec.replace(roll_rate=2.0)) == 8 * 1000000
