"""The axes of a grid: evenly spaced values, and values given one by one."""

from unittest import mock

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from sweep.errors import RequestError
from sweep.request import axes
from sweep.request.axes import Range, Values

FINITE = st.floats(allow_nan=False, allow_infinity=False)


def test_a_linear_range_is_even():
    """Five values from 0 to 1 are the quarters."""
    assert Range(0.0, 1.0, 5).array().tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]


def test_a_logarithmic_range_has_one_ratio():
    """Four values from 1 to 1000 are the powers of ten."""
    np.testing.assert_allclose(
        Range(1.0, 1000.0, 4, "log").array(), [1, 10, 100, 1000], rtol=1e-14
    )  # rounding


@example(5e-324, 4.9e-272, 263, "log")
@example(0.0, 5e-323, 300, "linear")
@given(FINITE, FINITE, st.integers(2, 500), st.sampled_from(["linear", "log"]))
def test_every_accepted_range_is_a_coordinate(start, stop, count, spacing):
    """Whatever range is not refused has exact ends, its count, and strictly increasing finite values."""
    # most pairs drawn at random would be refused, for their order or their signs
    start, stop = sorted(map(abs, (start, stop)) if spacing == "log" else (start, stop))
    try:
        axis = Range(start, stop, count, spacing)
    except RequestError:
        assume(False)
    values = axis.array()
    assert values.dtype == np.float64
    assert (values[0], values[-1], len(values)) == (start, stop, count)
    assert (np.diff(values) > 0).all()
    assert np.isfinite(values).all()


NORMAL = st.floats(-1e300, 1e300, allow_subnormal=False)


@given(NORMAL, NORMAL, st.integers(2, 500), st.sampled_from(["linear", "log"]), st.data())
def test_chosen_values_of_a_long_range(start, stop, count, spacing, data):
    """Of a range that is too long to be made whole, each value has the bits that it has among all."""
    start, stop = sorted(map(abs, (start, stop)) if spacing == "log" else (start, stop))
    try:
        axis = Range(start, stop, count, spacing)
    except RequestError:
        assume(False)
    places = data.draw(st.lists(st.integers(0, count - 1)))
    with mock.patch.object(axes, "_MANY", 1):
        assert axis.at(places).tobytes() == axis.array()[np.array(places, int)].tobytes()


@given(st.lists(FINITE, min_size=1, unique=True).map(sorted))
def test_a_list_has_its_values(numbers):
    """Values given one by one are the coordinate, to the last bit; the ends are its first and its last."""
    axis = Values(tuple(numbers))
    assert axis.array().tolist() == numbers
    assert axis.ends().tolist() == [numbers[0], numbers[-1]]
    assert len(axis) == len(numbers)


def test_minus_zero_is_zero():
    """-0 and 0 are one value, so that equal axes also read the same."""
    assert str(Range(-1.0, -0.0, 3)) == "-1.0:0.0:3"
    assert str(Values((-0.0, 1.0))) == "0.0,1.0"


@pytest.mark.parametrize(
    "make",
    [
        lambda: Range("a", 2.0, 3),
        lambda: Range(None, 2.0, 3),
        lambda: Range(1.0, 2.0, 3.0),
        lambda: Range(1.0, 2.0, True),
        lambda: Values(3),
        lambda: Values(("a",)),
    ],
)
def test_axes_made_in_python_are_checked(make):
    """An axis that was not read from text obeys the same rules."""
    with pytest.raises(RequestError):
        make()
