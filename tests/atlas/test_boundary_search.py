"""The variables of a boundary: their values by hand, and from cells that come in spans."""

import tracemalloc

import numpy as np
import pytest

from sweep.atlas import boundary, boundary_search
from sweep.atlas.boundary_search import BoundarySearch
from sweep.atlas.dataset import boundaries
from sweep.engine.estimate import boundary_bytes
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE
from sweep.request.spec import SweepSpec

#: Verdicts written as they look along an axis: stable, unstable, undecided.
_CODES = {"s": STABLE, "u": UNSTABLE, "?": UNDECIDED}


def verdicts(*rows):
    """Stability of one row of text per row of cells."""
    return np.array([[_CODES[letter] for letter in row] for row in rows], np.int8)


def variables(spec, stability):
    """The variables of the boundary by their names."""
    return {declared.name: values for declared, values in boundaries(spec, stability)}


def test_the_measured_boundary_and_its_halfwidth():
    """The boundary is the middle of its bracket, the half-width reaches both ends, none is NaN."""
    spec = SweepSpec(roll_rate="2,2.5,3,4", tilt="0.01,0.02,0.03")
    found = variables(spec, verdicts("uuss", "u??s", "uuuu").T)
    measured, halfwidth = found["boundary_roll_rate"], found["boundary_roll_rate_halfwidth"]
    assert "boundary_lower_roll_rate" not in found
    assert measured == pytest.approx([2.75, 3.0, np.nan], nan_ok=True, rel=1e-15)
    assert halfwidth == pytest.approx([0.25, 1.0, np.nan], nan_ok=True, rel=1e-15)
    assert np.array_equal(np.isnan(measured), np.isnan(halfwidth))
    assert found["critical_roll_rate"] == pytest.approx([np.sqrt(9.81 / 1.5)] * 3, rel=1e-14)


def test_both_edges_of_a_band_through_zero():
    """Along rates of both signs the unstable band has two edges, mirror images in theory."""
    spec = SweepSpec(tilt="0.01,0.02", roll_rate="-4,-3,-1,0,1,3,4")
    found = variables(spec, verdicts("ssuuuss", "suuuuus"))
    assert list(found["boundary_roll_rate"]) == [2.0, 3.5]
    assert list(found["boundary_lower_roll_rate"]) == [-2.0, -3.5]
    assert np.array_equal(found["predicted_lower_roll_rate"], -found["predicted_roll_rate"])
    assert np.array_equal(found["critical_lower_roll_rate"], -found["critical_roll_rate"])


def test_a_grid_without_a_rate_axis_has_no_boundary():
    """Over tilts alone no boundary along a rate is looked for."""
    spec = SweepSpec(tilt="0.01,0.02", roll_rate=3.0)
    assert boundaries(spec, np.array([STABLE, UNSTABLE])) == []


@pytest.mark.parametrize("start", [0, 3, 5])
def test_cells_come_in_order(start):
    """Cells that do not follow on those before, or that the grid does not have, are refused."""
    search = BoundarySearch(SweepSpec(tilt="0.01,0.02", roll_rate="1,2,3"))
    search.add(0, verdicts("uu")[0])
    with pytest.raises(ValueError, match=f"cells 2 to 6 come next, not {start} to"):
        search.add(start, verdicts("su")[0])
    with pytest.raises(ValueError, match="cells 2 to 6 come next, not 2 to 7"):
        search.add(2, verdicts("susus")[0])


def test_all_cells_are_needed():
    """A boundary that the missing cells may change is not given out."""
    search = BoundarySearch(SweepSpec(tilt="0.01,0.02", roll_rate="1,2,3"))
    search.add(0, verdicts("uusuu")[0])
    with pytest.raises(ValueError, match="only 5 of 6 cells"):
        next(search.variables())


#: Rows of a plane and of a cube, with a boundary along one rate or both.
SPECS = {
    "band": SweepSpec(roll_rate="-4:4:9", tilt="-2deg:2deg:5", boundary="refined:1e-3"),
    "first axis": SweepSpec(tilt="0.1deg:2deg:7", precession_rate="1:4:8"),
    "both rates": SweepSpec(alpha="0.5,1", roll_rate="0:4:5", precession_rate="0:2:4", tilt="1deg:9deg:3"),
    "circling": SweepSpec.preset("circling").replace(tilt="2deg:25deg:6", precession_rate="0.2:5:7"),
}


@pytest.mark.compiled
@pytest.mark.parametrize("name", SPECS)
def test_rows_at_a_time_change_no_bit(name, monkeypatch):
    """Brackets, lines of theory and codes are the same however many rows are worked on at a time."""
    spec = SPECS[name]
    stability = np.random.default_rng(3).choice([0, 1, 2], spec.shape, p=[0.1, 0.5, 0.4]).astype(np.int8)
    expected = variables(spec, stability)
    monkeypatch.setattr(boundary, "AT_ONCE", 3)
    monkeypatch.setattr(boundary_search, "AT_ONCE", 2)
    found = variables(spec, stability)
    assert list(found) == list(expected)
    for each in found:
        np.testing.assert_array_equal(found[each], expected[each], each)


@pytest.mark.parametrize("order", ["rows are contiguous", "rows are strided"])
def test_the_memory_grows_with_the_rows_and_not_with_the_cells(order, monkeypatch):
    """Of 6e6 cells in 2e4 rows less is held than one byte per cell: what is expected per row, and the work at hand."""
    for module in (boundary, boundary_search):
        monkeypatch.setattr(module, "AT_ONCE", 2**11)
    monkeypatch.setattr("sweep.atlas.row_search._AT_ONCE", 2**13)
    axes = {"tilt": "0.1deg:4deg:20000", "roll_rate": "1:4:300"}
    if order == "rows are strided":
        axes = {"roll_rate": "1:4:300", "alpha": "0.5:1:10", "gravity": "1:9:20", "tilt": "0.1deg:4deg:100"}
    spec = SweepSpec(**axes)
    block = np.repeat(np.array([UNSTABLE, STABLE], np.int8), 150000)
    tracemalloc.start()
    search = BoundarySearch(spec)
    for start in range(0, spec.size, block.size):
        search.add(start, block)
    for _, values in search.variables():
        assert values.size == 20000
        del values
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < boundary_bytes(spec) + 1e6 < 3e6
