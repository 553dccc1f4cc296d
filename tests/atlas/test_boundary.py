import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.atlas import boundary
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE
from sweep.request.spec import SweepSpec

#: Verdicts written as they look along an axis: stable, unstable, undecided.
_CODES = {"s": STABLE, "u": UNSTABLE, "?": UNDECIDED}


def verdicts(*rows):
    """Stability of one row of text per row of cells."""
    return np.array([[_CODES[letter] for letter in row] for row in rows], np.int8)


@pytest.mark.parametrize(
    ("row", "upper", "lower"),
    [
        ("uuuss", (2, 3), (-1, -1)),
        ("ssuuu", (-1, -1), (2, 1)),
        ("suus", (2, 3), (1, 0)),
        ("us", (0, 1), (-1, -1)),
        ("su", (-1, -1), (1, 0)),
        ("uu??ss", (1, 4), (-1, -1)),
        ("s??u?s", (3, 5), (3, 0)),
        ("ususs", (2, 3), (-1, -1)),
        ("uuu", (-1, -1), (-1, -1)),
        ("sss", (-1, -1), (-1, -1)),
        ("???", (-1, -1), (-1, -1)),
        ("u???", (-1, -1), (-1, -1)),
        ("?s", (-1, -1), (-1, -1)),
        ("u", (-1, -1), (-1, -1)),
    ],
)
def test_brackets_by_hand(row, upper, lower):
    """The bracket runs from the outermost unstable cell to the next stable one; undecided cells widen it."""
    found = boundary.upper_bracket(verdicts(row)), boundary.lower_bracket(verdicts(row))
    assert [(int(inside[0]), int(outside[0])) for inside, outside in found] == [upper, lower]


def brute_upper(row):
    """Last unstable cell and the first stable one above it, by looking at every cell."""
    for last in reversed(range(len(row))):
        if row[last] == UNSTABLE:
            for first in range(last + 1, len(row)):
                if row[first] == STABLE:
                    return last, first
            break
    return -1, -1


@given(
    st.integers(1, 8).flatmap(
        lambda n: st.lists(st.lists(st.sampled_from([0, 1, 2]), min_size=n, max_size=n), min_size=1)
    )
)
def test_brackets_by_brute_force(rows):
    """Both brackets equal a search cell by cell, for the lower one from the other end."""
    n = len(rows[0])
    last, first = boundary.upper_bracket(np.array(rows, np.int8))
    assert [(int(a), int(b)) for a, b in zip(last, first, strict=True)] == [brute_upper(row) for row in rows]
    low, below = boundary.lower_bracket(np.array(rows, np.int8))
    mirrored = [brute_upper(row[::-1]) for row in rows]
    expected = [(-1, -1) if a < 0 else (n - 1 - a, n - 1 - b) for a, b in mirrored]
    assert [(int(a), int(b)) for a, b in zip(low, below, strict=True)] == expected


def test_brackets_of_a_cube_are_those_of_its_rows():
    """Further dimensions are kept: each row is looked at by itself."""
    rows = verdicts("uuss", "uuus", "ssss", "suus", "u?s?", "????").reshape(2, 3, 4)
    last, first = boundary.upper_bracket(rows)
    assert last.tolist() == [[1, 2, -1], [2, 0, -1]]
    assert first.tolist() == [[2, 3, -1], [3, 2, -1]]


def test_the_measured_boundary_and_its_halfwidth():
    """The boundary is the middle of its bracket, the half-width reaches both ends, none is NaN."""
    spec = SweepSpec(roll_rate="2,2.5,3,4", tilt="0.01,0.02,0.03")
    found = boundary.edges(spec, verdicts("uuss", "u??s", "uuuu").T)
    edge = found["roll_rate", "upper"]
    assert list(found) == [("roll_rate", "upper")]
    assert edge.measured == pytest.approx([2.75, 3.0, np.nan], nan_ok=True, rel=1e-15)
    assert edge.halfwidth == pytest.approx([0.25, 1.0, np.nan], nan_ok=True, rel=1e-15)
    assert np.array_equal(np.isnan(edge.measured), np.isnan(edge.halfwidth))
    assert edge.critical == pytest.approx([np.sqrt(9.81 / 1.5)] * 3, rel=1e-14)


def test_both_edges_of_a_band_through_zero():
    """Along rates of both signs the unstable band has two edges, mirror images in theory."""
    spec = SweepSpec(tilt="0.01,0.02", roll_rate="-4,-3,-1,0,1,3,4")
    found = boundary.edges(spec, verdicts("ssuuuss", "suuuuus"))
    upper, lower = found["roll_rate", "upper"], found["roll_rate", "lower"]
    assert list(upper.measured) == [2.0, 3.5]
    assert list(lower.measured) == [-2.0, -3.5]
    assert np.array_equal(lower.predicted, -upper.predicted)
    assert np.array_equal(lower.critical, -upper.critical)


def test_a_grid_without_a_rate_axis_has_no_boundary():
    """Over tilts alone no boundary along a rate is looked for."""
    spec = SweepSpec(tilt="0.01,0.02", roll_rate=3.0)
    assert boundary.edges(spec, np.array([STABLE, UNSTABLE])) == {}
