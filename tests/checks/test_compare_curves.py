"""The regression check on atlases with a bisected boundary, whose curves belong to no cell, and with computed rates."""

import numpy as np
import pytest
from comparing import CIRCLING, REFINED, SPEC, STEADY, changed, finding, found

import sweep
from sweep.checks.compare import compare
from sweep.checks.comparison_report import in_words
from sweep.errors import RequestError
from sweep.model.quantity import STABLE, UNSTABLE


@pytest.fixture(scope="module")
def reference():
    """Return an atlas whose boundary lies between cells."""
    return sweep.run(SPEC)


@pytest.fixture(scope="module")
def refined():
    """Return the same atlas with its boundary bisected, and stored as curves."""
    return sweep.run(REFINED)


def test_a_moved_curve_differs(refined):
    """A point of a curve beyond its tolerance differs, and the report names the point."""
    comparison = compare(changed(refined, "curve_tilt", 2, float(refined.curve_tilt[2]) + 1e-3), refined)
    assert found(comparison) == {"curve_tilt": 1}
    assert finding(comparison, "curve_tilt").worst.where == {"curve_point": 2.0}
    assert "worst cell: curve_point 2:" in in_words(comparison)


def test_a_curve_of_other_length_differs(refined):
    """Curves with a point less are not the same, and the lengths are told."""
    comparison = compare(refined.isel(curve_point=slice(1, None)), refined)
    assert set(found(comparison)) == {
        "curve_roll_rate", "curve_roll_rate_halfwidth", "curve_tilt", "curve_tilt_halfwidth",
    }  # fmt: skip
    length = refined.sizes["curve_point"]
    assert finding(comparison, "curve_tilt").note == f"{length - 1} values, in the reference {length}"


def test_curves_move_with_a_cell_that_flips_on_an_edge(refined):
    """Where a cell may be stable or not, so may the curves around it lie here or there."""
    stable = refined["stability"].values == STABLE
    place = tuple(np.argwhere(stable)[np.argmax(refined["tilt_max"].values[stable])])
    edge = sweep.reclassify(refined, f"departure:{float(refined['tilt_max'].values[place])!r}rad")
    moved = changed(changed(edge, "stability", place, UNSTABLE), "curve_tilt", 0, 9.0)
    comparison = compare(moved, edge)
    assert comparison.same
    assert finding(comparison, "curve_tilt").on_edge == 1


def test_brackets_of_any_width_have_to_overlap(reference, refined):
    """A boundary between cells and a bisected one are compared by their brackets; half-widths and curves are not."""
    for new, old in ((reference, refined), (refined, reference)):
        comparison = compare(new, old)
        assert comparison.same
        names = {each.name for each in comparison.findings}
        assert not any(name.startswith("curve_") or name.endswith("_halfwidth") for name in names)
        assert {"tilt_max", "predicted_roll_rate", "critical_roll_rate"} <= names
        halfwidths = float((reference.boundary_roll_rate_halfwidth + refined.boundary_roll_rate_halfwidth)[0])
        boundary = finding(comparison, "boundary_roll_rate")
        assert 0.0 < boundary.largest < boundary.allowed == pytest.approx(halfwidths, rel=1e-9)
        told = [note for note in comparison.notes if "boundary differs" in note]
        assert len(told) == 1 + sum(name.startswith("curve_") for name in refined.data_vars)
        place = int(np.flatnonzero(np.isfinite(new["boundary_roll_rate"].values))[0])
        beyond = float(old["boundary_roll_rate"][place]) + 1.001 * halfwidths
        assert found(compare(changed(new, "boundary_roll_rate", place, beyond), old)) == {
            "boundary_roll_rate": 1
        }


def test_another_steady_rate_is_another_motion():
    """The slower and the faster of the two steady precessions are not compared, nor a computed rate and a given one."""
    slow = sweep.run(STEADY)
    for other in (STEADY.replace(precession_rate="steady-fast"), CIRCLING):
        with pytest.raises(RequestError, match=r"differ in precession_rate \("):
            compare(slow, sweep.run(other))
