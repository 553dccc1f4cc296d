"""The variables of a boundary, checked against values by hand and computed in batches of rows."""

import numpy as np
import pytest

from sweep.atlas import boundary
from sweep.atlas.boundary_search import boundary_groups
from sweep.atlas.dataset import boundaries
from sweep.engine.compute import compute
from sweep.engine.grid import whole
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE
from sweep.request.spec import SweepSpec

#: Verdict codes by letter: stable, unstable, undecided.
_CODES = {"s": STABLE, "u": UNSTABLE, "?": UNDECIDED}


def verdicts(*rows):
    """Return the stability of rows of cells, each written as text."""
    return np.array([[_CODES[letter] for letter in row] for row in rows], np.int8)


def variables(spec, stability):
    """Return the boundary variables by name."""
    return {declared.name: values for declared, values in boundaries(spec, stability)}


def test_the_measured_boundary_and_its_halfwidth():
    """The boundary is the middle of its bracket, the half-width reaches both ends, and neither is NaN."""
    spec = SweepSpec(roll_rate="2,2.5,3,4", tilt="0.01,0.02,0.03")
    found = variables(spec, verdicts("uuss", "u??s", "uuuu").T)
    measured, halfwidth = found["boundary_roll_rate"], found["boundary_roll_rate_halfwidth"]
    assert "boundary_lower_roll_rate" not in found
    assert measured == pytest.approx([2.75, 3.0, np.nan], nan_ok=True, rel=1e-15)
    assert halfwidth == pytest.approx([0.25, 1.0, np.nan], nan_ok=True, rel=1e-15)
    assert np.array_equal(np.isnan(measured), np.isnan(halfwidth))
    assert found["critical_roll_rate"] == pytest.approx([np.sqrt(9.81 / 1.5)] * 3, rel=1e-14)


def test_both_edges_of_a_band_through_zero():
    """With rates of both signs, the unstable band has two edges; in theory they are mirror images."""
    spec = SweepSpec(tilt="0.01,0.02", roll_rate="-4,-3,-1,0,1,3,4")
    found = variables(spec, verdicts("ssuuuss", "suuuuus"))
    assert list(found["boundary_roll_rate"]) == [2.0, 3.5]
    assert list(found["boundary_lower_roll_rate"]) == [-2.0, -3.5]
    assert np.array_equal(found["predicted_lower_roll_rate"], -found["predicted_roll_rate"])
    assert np.array_equal(found["critical_lower_roll_rate"], -found["critical_roll_rate"])


def test_an_edge_that_theory_alone_has_is_there():
    """If only theory has a lower edge, its measured values are NaN in every row and its lines are finite."""
    spec = SweepSpec(tilt="0.01,0.02", roll_rate="-4,-3,-1,0,1,3,4")
    found = variables(spec, verdicts("uuuuuss", "uuuuuus"))
    assert np.isnan(found["boundary_lower_roll_rate"]).all()
    assert np.isfinite(found["critical_lower_roll_rate"]).all()
    assert np.isfinite(found["boundary_roll_rate"]).all()


def test_a_grid_without_a_rate_axis_has_no_boundary():
    """A grid over tilts only has no boundary."""
    spec = SweepSpec(tilt="0.01,0.02", roll_rate=3.0)
    assert boundaries(spec, np.array([STABLE, UNSTABLE])) == []


#: Rows of a plane and of a cube, with a boundary along one or two rates.
SPECS = {
    "band": SweepSpec(roll_rate="-4:4:9", tilt="-2deg:2deg:5", boundary="refined:1e-3"),
    "first axis": SweepSpec(tilt="0.1deg:2deg:7", precession_rate="1:4:8"),
    "both rates": SweepSpec(alpha="0.5,1", roll_rate="0:4:5", precession_rate="0:2:4", tilt="1deg:9deg:3"),
    "circling": SweepSpec.preset("circling").replace(tilt="2deg:25deg:6", precession_rate="0.2:5:7"),
}


@pytest.mark.compiled
@pytest.mark.parametrize("at_once", [2, 7])
@pytest.mark.parametrize("name", SPECS)
def test_rows_at_a_time_change_no_bit(name, at_once, monkeypatch):
    """Brackets, lines of theory and codes do not depend on the number of rows per batch."""
    spec = SPECS[name]
    stability = np.random.default_rng(3).choice([0, 1, 2], spec.shape, p=[0.1, 0.5, 0.4]).astype(np.int8)
    expected = variables(spec, stability)
    monkeypatch.setattr(boundary, "AT_ONCE", at_once)
    found = variables(spec, stability)
    assert list(found) == list(expected)
    for each in found:
        np.testing.assert_array_equal(found[each], expected[each], each)


@pytest.mark.compiled
def test_it_says_how_far_it_is():
    """Progress rises from 0 to 1 in many steps while the brackets are bisected."""
    spec = SweepSpec.preset("circling").replace(
        tilt="2deg:25deg:6", precession_rate="0.2:5:7", boundary="refined:1e-6"
    )
    stability = np.asarray(compute(spec, whole(spec))["stability"])
    heard = []
    boundary_groups(spec, stability.reshape(spec.shape), heard.append)
    assert heard == sorted(heard)
    assert (heard[0], heard[-1]) == (0.0, 1.0)
    assert len(heard) > 50
