"""Criteria of stability: read, written, kept, and the verdict that each gives."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kernels.disk.endings import BOUNDED, FELL, HORIZON, INVALID, NOT_COMPUTED, STEADY, UNRESOLVED
from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import ENDINGS
from sweep.model.quantity import FILL, STABLE, UNDECIDED, UNSTABLE
from sweep.request.criterion import Criterion
from sweep.request.spec import SweepSpec

DEPARTURE = Criterion("departure", 0.1)
AMPLIFICATION = Criterion("amplification", 10.0)
ANGLES = st.floats(0, math.pi, exclude_min=True, exclude_max=True)
CRITERIA = st.one_of(
    st.builds(lambda limit: Criterion("departure", limit), ANGLES),
    st.builds(
        lambda limit: Criterion("amplification", limit), st.floats(0, exclude_min=True, allow_infinity=False)
    ),
)


def verdict(criterion, ending, tilt_min, tilt_max, steady_tilt=0.0, scale=0.01):
    """Verdict on one cell."""
    reach = np.array([max(abs(tilt_max - steady_tilt), abs(tilt_min - steady_tilt))])
    return int(criterion.verdict(ENDINGS, {"ending": np.array([ending])}, reach, np.array([scale]))[0])


def test_a_criterion_is_read_from_text():
    """The two kinds are read with their units: 5 degrees are pi/36 rad."""
    assert Criterion.parse("departure:5deg") == Criterion("departure", math.pi / 36)
    assert Criterion.parse(" departure : 0.1 ") == DEPARTURE
    assert Criterion.parse("amplification:10") == AMPLIFICATION


def test_a_criterion_is_written_as_it_was_read():
    """A criterion in its own spelling comes back letter for letter."""
    for text in ["departure:5deg", "departure:0.1rad", "amplification:10", "amplification:2.5"]:
        assert str(Criterion.parse(text)) == text


@given(CRITERIA)
def test_a_criterion_comes_back_as_itself(criterion):
    """From its text, from pickle and from its own two fields, the same kind with the same limit to the last bit."""
    for same in (
        Criterion.parse(str(criterion)),
        pickle.loads(pickle.dumps(criterion)),
        Criterion(criterion.kind, criterion.limit),
        Criterion(kind=criterion.kind, limit=criterion.limit),
    ):
        assert same == criterion
        assert hash(same) == hash(criterion)
        assert same.limit == criterion.limit


def test_a_criterion_is_one_of_its_kinds():
    """Two kinds with the same limit are not equal, nor are two limits of one kind; none can be changed."""
    assert Criterion("departure", 1.0) != Criterion("amplification", 1.0)
    assert Criterion("departure", 1.0) != Criterion("departure", np.nextafter(1.0, 2.0))
    with pytest.raises(AttributeError):
        DEPARTURE.limit = 0.2


def test_what_is_not_a_criterion_is_refused():
    """The error stands at the criterion, with the rule that was broken and what was given."""
    for text, facts in [
        ("", ["departure:ANGLE", "amplification:NUMBER"]),
        ("departure", ["departure:ANGLE", "amplification:NUMBER"]),
        ("energy:3", ["departure:ANGLE", "amplification:NUMBER", "energy:3"]),
        ("departure:0deg", ["above 0"]),
        ("departure:-5deg", ["above 0", "-5deg"]),
        ("amplification:0", ["above 0"]),
        ("amplification:-10", ["above 0", "-10"]),
        ("departure:5", ["bare number is in rad", "180 deg"]),
        ("departure:180deg", ["below 180 deg"]),
        ("departure:5s", ["does not fit", "deg, rad"]),
        ("amplification:10deg", ["does not fit", "no unit"]),
        ("amplification:inf", ["finite"]),
        ("departure:1deg,2deg", ["one number"]),
        ("departure:", ["a number"]),
    ]:
        with pytest.raises(RequestError) as caught:
            Criterion.parse(text)
        assert caught.value.where.partition("=")[0] == "criterion"
        assert all(fact in str(caught.value) for fact in facts), str(caught.value)
        assert caught.value.hint


def test_criteria_made_in_python_are_checked():
    """A criterion that was not read from text obeys the same rules."""
    for raw in [("energy", 3.0), ("", 1.0), ("departure", 0.0), ("amplification", math.nan)]:
        with pytest.raises(RequestError):
            Criterion(*raw)


def test_the_verdict_of_every_ending():
    """Only a bounded cell is stable; a fall is unstable, and so is what left the limit before time ran out."""
    for ending, within, beyond in [
        (BOUNDED, STABLE, UNSTABLE),
        (HORIZON, UNDECIDED, UNSTABLE),
        (FELL, UNSTABLE, UNSTABLE),
        (STEADY, UNDECIDED, UNDECIDED),
        (UNRESOLVED, UNDECIDED, UNDECIDED),
        (INVALID, UNDECIDED, UNDECIDED),
        (NOT_COMPUTED, UNDECIDED, UNDECIDED),
    ]:
        for criterion in [DEPARTURE, AMPLIFICATION]:
            assert verdict(criterion, ending, -0.05, 0.05) == within
            assert verdict(criterion, ending, -0.05, 0.2) == beyond
            assert verdict(criterion, ending, -0.2, 0.05) == beyond


def test_a_cell_without_numbers_is_never_stable():
    """Where a cell has no extremes, be they NaN or the file's fill, no criterion calls it stable."""
    for missing in [math.nan, FILL]:
        for ending in {each.code for each in ENDINGS} - {FELL}:
            for criterion in (DEPARTURE, AMPLIFICATION):
                assert verdict(criterion, ending, missing, missing) != STABLE
            assert verdict(AMPLIFICATION, BOUNDED, 0.0, 0.0, scale=math.nan) == UNDECIDED


def test_the_limit_itself_is_stable():
    """A departure of exactly the limit has not exceeded it."""
    assert verdict(DEPARTURE, BOUNDED, -0.1, 0.1) == STABLE
    assert verdict(DEPARTURE, BOUNDED, -0.1, np.nextafter(0.1, 1.0)) == UNSTABLE


def test_departure_is_counted_from_the_steady_tilt():
    """A disk that circles at 0.5 rad and keeps within 0.1 rad of that is stable; upright it would not be."""
    assert verdict(DEPARTURE, BOUNDED, 0.45, 0.55, steady_tilt=0.5) == STABLE
    assert verdict(DEPARTURE, BOUNDED, 0.45, 0.55) == UNSTABLE
    assert verdict(DEPARTURE, BOUNDED, 0.35, 0.55, steady_tilt=0.5) == UNSTABLE


def test_amplification_is_counted_in_scales():
    """The same motion is stable for a large perturbation and unstable for a small one."""
    assert verdict(AMPLIFICATION, BOUNDED, 0.0, 0.05, scale=0.006) == STABLE
    assert verdict(AMPLIFICATION, BOUNDED, 0.0, 0.05, scale=0.004) == UNSTABLE


def test_verdicts_keep_the_shape_of_the_grid():
    """Verdicts come as int8 in the shape of the cells, a single cell without any dimension included."""
    ending = {"ending": np.full((2, 3), BOUNDED, dtype=np.int8)}
    result = DEPARTURE.verdict(ENDINGS, ending, np.zeros((2, 3)), np.ones(3))
    assert (result.shape, result.dtype) == ((2, 3), np.int8)
    one = DEPARTURE.verdict(ENDINGS, {"ending": np.int8(BOUNDED)}, np.float64(0.0), np.float64(1.0))
    assert one.shape == ()


def test_the_limit_of_a_criterion():
    """A departure limits every cell alike, an amplification in proportion to its perturbation, if there is one."""
    scales = np.array([0.0, 0.01, 0.03])
    assert Criterion("departure", 0.2).allowed(scales).tolist() == [0.2, 0.2, 0.2]
    # relative tolerance: one rounding
    assert AMPLIFICATION.allowed(scales) == pytest.approx([math.nan, 0.1, 0.3], rel=1e-15, nan_ok=True)


def test_a_criterion_says_how_far_is_too_far():
    """Everywhere the limit is said in degrees or as a multiple; figures name the kind, and say what else is lost."""
    for criterion, facts in [
        ("departure:5deg", ["5 deg"]),
        ("amplification:10", ["10 times", "perturbation"]),
    ]:
        made = Criterion.parse(criterion)
        assert all(fact in made.limit_text() for fact in facts)
        assert all(
            fact in made.unstable_if(DISK) for fact in ["tilt", "steady value", *facts, "the disk falls"]
        )
        assert made.kind in made.label(DISK)
        assert all(part in made.caption(DISK) for part in (made.label(DISK).split()[-1], "the disk falls"))


def test_a_criterion_gives_the_reason_of_a_verdict():
    """How far the cell went, beside its limit, and what a multiple of the perturbation is a multiple of."""
    for ending, reach, stability, facts in [
        (BOUNDED, 6.0, UNSTABLE, ["6 deg", "more than the 5 deg"]),
        (BOUNDED, 4.0, STABLE, ["4 deg", "at most the 5 deg", "turning points"]),
        (HORIZON, 4.0, UNDECIDED, ["4 deg", "at most the 5 deg", "300 s"]),
        (FELL, 85.0, UNSTABLE, ["fall_tilt", "85 deg", "7 s"]),
    ]:
        for criterion in ["departure:5deg", "amplification:10"]:
            stored = {"ending": ending, "stability": stability, "fall_time": 7.0}
            # ten times half a degree are 5 deg
            reason = Criterion.parse(criterion).reason(
                SweepSpec(), stored, math.radians(reach), math.radians(0.5)
            )
            assert all(fact in reason for fact in facts), reason
            assert ("0.5 deg" in reason) == (criterion.startswith("amplification") and ending != FELL)


def test_verdicts_follow_from_what_a_criterion_needs():
    """The ending and both extremes are enough: another criterion on an atlas needs no other variable."""
    for criterion in [DEPARTURE, AMPLIFICATION]:
        assert criterion.needs(DISK) == ("ending", "tilt_min", "tilt_max")


def test_a_criterion_that_the_model_cannot_serve_is_refused(monkeypatch):
    """A criterion that judges by what the model does not compute is refused; the message names all three."""
    monkeypatch.setattr(Criterion, "needs", lambda self, model: ("ending", "time_aloft"))
    with pytest.raises(
        RequestError, match=r"departure:5deg judges by time_aloft, which the model disk"
    ) as caught:
        SweepSpec(criterion="departure:5deg")
    assert caught.value.where == "criterion"
