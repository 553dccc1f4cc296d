import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kernels.disk.endings import BOUNDED, ENDINGS, FELL, HORIZON, INVALID, NOT_COMPUTED, STEADY, UNRESOLVED
from sweep.errors import RequestError
from sweep.request.criterion import Criterion, perturbation_scale
from sweep.schema import FILL, STABLE, UNDECIDED, UNSTABLE

DEPARTURE = Criterion("departure", 0.1)
AMPLIFICATION = Criterion("amplification", 10.0)


def verdict(criterion, ending, tilt_min, tilt_max, steady_tilt=0.0, scale=0.01):
    """Verdict on one cell."""
    return int(
        criterion.verdict(np.array([ending]), np.array([tilt_min]), np.array([tilt_max]), steady_tilt, scale)[
            0
        ]
    )


def test_a_criterion_is_read_from_text():
    """The two kinds are read with their units: 5 degrees are pi/36 rad."""
    assert Criterion.parse("departure:5deg") == Criterion("departure", math.pi / 36)
    assert Criterion.parse(" departure : 0.1 ") == DEPARTURE
    assert Criterion.parse("amplification:10") == AMPLIFICATION


@pytest.mark.parametrize(
    "text", ["departure:5deg", "departure:0.1rad", "amplification:10", "amplification:2.5"]
)
def test_a_criterion_is_written_as_it_was_read(text):
    """A criterion in its own spelling comes back letter for letter."""
    assert str(Criterion.parse(text)) == text


@given(st.floats(0, math.pi, exclude_min=True, exclude_max=True))
def test_a_departure_reads_back_as_itself(limit):
    """The text of any departure is read as the same limit, to the last bit."""
    criterion = Criterion("departure", limit)
    assert Criterion.parse(str(criterion)) == criterion


@given(st.floats(0, exclude_min=True, allow_infinity=False))
def test_an_amplification_reads_back_as_itself(limit):
    """The text of any amplification is read as the same limit, to the last bit."""
    criterion = Criterion("amplification", limit)
    assert Criterion.parse(str(criterion)) == criterion


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "criterion is departure:ANGLE or amplification:NUMBER"),
        ("departure", "criterion is departure:ANGLE or amplification:NUMBER"),
        ("energy:3", "criterion is departure:ANGLE or amplification:NUMBER"),
        ("departure:0deg", "above 0"),
        ("departure:-5deg", "above 0"),
        ("amplification:0", "above 0"),
        ("amplification:-10", "above 0"),
        ("departure:5", "bare number is in rad"),
        ("departure:5s", "departure takes deg, rad"),
        ("amplification:10deg", "amplification takes no unit"),
        ("amplification:inf", "finite"),
        ("departure:1deg,2deg", "one number"),
        ("departure:", "not a value"),
    ],
)
def test_what_is_not_a_criterion_is_refused(text, message):
    """The message names the criterion, its rule and what was given."""
    with pytest.raises(RequestError, match=message) as caught:
        Criterion.parse(text)
    assert str(caught.value).startswith("criterion: ")


@pytest.mark.parametrize("criterion", [DEPARTURE, AMPLIFICATION])
@pytest.mark.parametrize(
    ("ending", "within", "beyond"),
    [
        (BOUNDED, STABLE, UNSTABLE),
        (HORIZON, UNDECIDED, UNSTABLE),
        (FELL, UNSTABLE, UNSTABLE),
        (STEADY, UNDECIDED, UNDECIDED),
        (UNRESOLVED, UNDECIDED, UNDECIDED),
        (INVALID, UNDECIDED, UNDECIDED),
        (NOT_COMPUTED, UNDECIDED, UNDECIDED),
    ],
)
def test_the_verdict_of_every_ending(criterion, ending, within, beyond):
    """Only a bounded cell is stable; a fall is unstable, and so is what left the limit before time ran out."""
    assert verdict(criterion, ending, -0.05, 0.05) == within
    assert verdict(criterion, ending, -0.05, 0.2) == beyond
    assert verdict(criterion, ending, -0.2, 0.05) == beyond


@pytest.mark.parametrize("ending", set(ENDINGS) - {FELL})
@pytest.mark.parametrize("missing", [math.nan, FILL])
def test_a_cell_without_numbers_is_never_stable(ending, missing):
    """Where a cell has no extremes, be they NaN or the file's fill, no criterion calls it stable."""
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
    ending = np.full((2, 3), BOUNDED, dtype=np.int8)
    tilts = np.zeros((2, 3))
    result = DEPARTURE.verdict(ending, tilts, tilts, np.zeros(3), 1.0)
    assert (result.shape, result.dtype) == ((2, 3), np.int8)
    assert DEPARTURE.verdict(np.int8(BOUNDED), np.float64(0.0), np.float64(0.0), 0.0, 1.0).shape == ()


def test_the_scale_of_a_release_is_its_tilt():
    """Released at rest, the scale is the distance from the steady tilt, whatever the disk."""
    scale = perturbation_scale(np.array([-0.25, 0.25, 0.75]), 0.0, 0.25, 0.5, 0.5, 9.81)
    assert scale.tolist() == [0.5, 0.0, 0.5]


@pytest.mark.parametrize(("alpha", "squared"), [(0.5, 0.8), (1.0, 2 / 3)])
def test_the_scale_of_a_kick(alpha, squared):
    """A kick is worth kick / W, with W^2 = 4g/5R for the uniform disk and 2g/3R for the hoop."""
    radius, gravity, kick = 0.5, 9.81, 0.01
    expected = kick / math.sqrt(squared * gravity / radius)
    # a few roundings on either side
    assert perturbation_scale(0.0, kick, 0.0, alpha, radius, gravity) == pytest.approx(expected, rel=1e-14)


def test_a_kick_and_a_release_add_as_squares():
    """3 and 4 give 5: with W = 1 the scale is the hypotenuse of tilt and kick."""
    assert perturbation_scale(0.3, 0.4, 0.0, 1.0, 2.0, 3.0) == pytest.approx(0.5, rel=1e-15)  # rounding
