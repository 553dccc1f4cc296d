"""Results from a cell's known passes: error bounds that chance cannot shrink, and when a cell is decided."""

import numpy as np
import pytest

from kernels.system.endings import DIFFERENT, FIRST_EVENT, GROWS, RUNS_ON, UNRESOLVED
from sweep.model.system.model import model_of
from sweep.model.system.passes import PASSES, Passes, conserved_change
from sweep.request.system_file import read_system

MODEL = model_of(
    read_system("""
@system(duration="10", measures={"top": "max x"}, label={"right": "x > 0", "left": "x < 0"})
def spring(x=1.0, v=0.0):
    return v, -x
""")
)
TOLERANCE = 1e-10


def columns(x, v, endings=(RUNS_ON,) * 4, times=(10.0,) * 4, steps=400, tolerance=TOLERANCE):
    """Return the result columns of one cell with the given x and v, endings and times of its passes."""
    measured = {"steps": np.array([steps]), "unproved": np.array([0])}
    for name, *each in zip(PASSES, x, v, endings, times, strict=True):
        values = dict(zip(("x", "v", "ending", "end_time"), each, strict=True))
        values |= {"largest x": 1.0, "largest v": 1.0, "top 0": values["x"]}
        measured |= {f"{name}: {row}": np.array([value]) for row, value in values.items()}
    starts = {"x": np.array([1.0]), "v": np.array([0.0])}
    return Passes(MODEL.definition, MODEL.endings, starts, measured, 10.0, tolerance).columns()


def test_one_difference_that_is_small_by_chance():
    """If errors fall 150-fold per pass to 1e-12, at least 1e-12 is stated even if a difference vanishes."""
    off = 1e-12 * 150.0 ** np.arange(3, -1, -1)
    for vanished in (None, 0, 1, 2):
        x = off.copy()
        if vanished is not None:
            x[vanished] = x[vanished + 1]
        found = columns(x, off * 0.0)
        assert 1e-12 <= found["x_end_error"][0] <= 1e-10, vanished
        assert 1e-12 <= found["top_error"][0] <= 1e-10, vanished


def test_the_other_states_count():
    """If all differences of one state vanish, the differences of the others still show an error."""
    off = 1e-9 * 150.0 ** np.arange(3, -1, -1)
    found = columns(np.zeros(4), off)
    assert found["x_end_error"][0] >= 0.3 * 1e-9
    assert found["v_end_error"][0] > found["x_end_error"][0]


def test_a_motion_of_few_steps():
    """Agreeing passes state a share of the tolerance, larger for few steps, and the duration's rounding."""
    still = np.full(4, 0.5)
    many, few = columns(still, still), columns(still, still, steps=8)
    for found in (many, few):
        assert found["end_time_error"][0] > 16.0 * 10.0 * np.finfo(float).eps
    assert 0.01 * TOLERANCE < many["x_end_error"][0] < 0.1 * TOLERANCE
    assert 2.0 * many["x_end_error"][0] < few["x_end_error"][0] < TOLERANCE


def test_rounding_grows_as_errors_do():
    """If errors grow a thousandfold, so does the stated rounding error of the steps."""
    off = 1e3 * 1e-14 * 0.01 * 100.0 ** np.arange(3, -1, -1)
    found = columns(off, np.zeros(4), steps=10_000, tolerance=1e-14)
    assert found["x_end_error"][0] > 0.2 * 1e3 * 100.0 * np.finfo(float).eps


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, RUNS_ON),
        ({"endings": (RUNS_ON, RUNS_ON, FIRST_EVENT, RUNS_ON)}, DIFFERENT),
        ({"endings": (FIRST_EVENT, UNRESOLVED, RUNS_ON, RUNS_ON)}, RUNS_ON),
        ({"endings": (RUNS_ON, RUNS_ON, UNRESOLVED, RUNS_ON)}, UNRESOLVED),
        ({"endings": (RUNS_ON, RUNS_ON, UNRESOLVED, GROWS)}, GROWS),
        ({"times": (10.0, 10.0, 9.99, 10.0)}, DIFFERENT),
        ({"x": (0.5, 0.5, 0.52, 0.5)}, DIFFERENT),
        ({"x": (0.2, 0.4, 0.5005, 0.5)}, RUNS_ON),
    ],
)
def test_when_a_cell_is_decided(given, expected):
    """A cell is decided if the last two passes end in the same way, time and place."""
    still = (0.5,) * 4
    assert columns(**{"x": still, "v": still, **given})["ending"] == [expected]


def test_the_label_is_that_of_both_last_passes():
    """It is the first label that fits at the end; undecided cells and differing passes have none."""
    still = (0.0,) * 4
    for x, label in (
        ((0.5,) * 4, 1),
        ((-0.5,) * 4, 2),
        (still, 0),
        ((0.5, 0.5, -1e-9, 1e-9), 0),
        ((0, 0, 0.3, 0.5), 0),
    ):
        assert columns(x, still)["label"] == [label], x


def test_what_is_conserved_changes_by_a_share_of_its_terms():
    """The change of an energy with large canceling terms is relative to those terms."""
    definition = read_system(
        '@system(duration="1", conserved="x**2 - v**2")\ndef d(x=1.0, v=1.0):\n    return v, x\n'
    )
    one, more = np.ones(1), np.array([1.0 + 1e-6])
    found = conserved_change(definition, {"x": one, "v": one}, {"x": more, "v": one, "t": one})
    assert found[0] == pytest.approx(1e-6, rel=1e-3)
