import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from sweep.schema import PARAMETERS, SETTINGS

from sweep.errors import RequestError
from sweep.request.values import Range, Values, read_number, read_value

TILT, RATE, ROLL = PARAMETERS["tilt"], PARAMETERS["precession_rate"], PARAMETERS["roll_rate"]
ALPHA, RADIUS, GRAVITY = PARAMETERS["alpha"], PARAMETERS["radius"], PARAMETERS["gravity"]
DURATION = SETTINGS["duration"]

FINITE = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize(
    ("raw", "quantity", "expected"),
    [
        ("3", TILT, 3.0),
        (" -.5e-1 ", TILT, -0.05),
        ("180deg", TILT, math.pi),
        ("180 °", TILT, math.pi),
        ("60 rpm", RATE, 2 * math.pi),
        ("1turn/s", RATE, 2 * math.pi),
        ("180deg/s", RATE, math.pi),
        ("-2rad/s", RATE, -2.0),
        ("50%", ALPHA, 0.5),
        ("25cm", RADIUS, 0.25),
        ("1 inch", RADIUS, 0.0254),
        ("981 cm/s^2", GRAVITY, 9.81),
        ("9.81 m s-2", GRAVITY, 9.81),
        ("9.81 m/s2", GRAVITY, 9.81),
        ("1g_0", GRAVITY, 9.80665),
        ("2min", DURATION, 120.0),
        ("20s", DURATION, 20.0),
        (3, TILT, 3.0),
        (np.float32(0.5), TILT, 0.5),
        (np.array(0.5), TILT, 0.5),
    ],
)
def test_a_number_is_read_in_si(raw, quantity, expected):
    """A number with any fitting unit, or bare, becomes one float in SI."""
    value = read_value(raw, quantity)
    assert type(value) is float
    assert value == pytest.approx(expected, rel=1e-15)  # the conversion rounds once or twice


@pytest.mark.parametrize(
    ("raw", "expected"),
    [
        ("0.5,1", (0.5, 1.0)),
        ("0.5,", (0.5,)),
        ([0.5, 1], (0.5, 1.0)),
        (("50%", "100%"), (0.5, 1.0)),
        (np.array([0.25, 0.5]), (0.25, 0.5)),
        (Values((0.5, 1.0)), (0.5, 1.0)),
    ],
)
def test_a_list_is_an_axis(raw, expected):
    """Text with commas, sequences and arrays are axes with these values, one element included."""
    value = read_value(raw, ALPHA)
    assert isinstance(value, Values)
    assert value.values == expected
    assert value.array().tolist() == list(expected)
    assert len(value) == len(expected)


def test_a_range_is_an_axis():
    """A range keeps its ends, in SI, its count and its spacing."""
    assert read_value("0.5:6:400", ROLL) == Range(0.5, 6.0, 400)
    assert read_value("0.01deg : 20deg : 300 : log", TILT) == Range(
        math.radians(0.01), math.radians(20), 300, "log"
    )
    assert read_value("1:1:1", ROLL).array().tolist() == [1.0]
    assert len(read_value("1:1:1", ROLL)) == 1


def test_a_linear_range_is_even():
    """Five values from 0 to 1 are the quarters."""
    assert Range(0.0, 1.0, 5).array().tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]


def test_a_logarithmic_range_has_one_ratio():
    """Four values from 1 to 1000 are the powers of ten."""
    np.testing.assert_allclose(
        Range(1.0, 1000.0, 4, "log").array(), [1, 10, 100, 1000], rtol=1e-14
    )  # rounding


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


@given(st.floats(1e-6, 1e6), st.floats(1.1, 1e6), st.integers(2, 10**9), st.sampled_from(["linear", "log"]))
def test_a_range_reads_back_as_itself(start, factor, count, spacing):
    """The text of a range is read as the same range, to the last bit."""
    axis = Range(start, start * factor, count, spacing)
    assert read_value(str(axis), ROLL) == axis


@given(st.lists(FINITE, min_size=1, unique=True).map(sorted))
def test_a_list_reads_back_as_itself(numbers):
    """The text of a list is read as the same list, to the last bit, and stays a list if it has one value."""
    axis = Values(tuple(numbers))
    assert read_value(str(axis), ROLL) == axis


@pytest.mark.parametrize(
    ("raw", "quantity", "message"),
    [
        ("6:0.5:400", ROLL, "start < stop"),
        ("1:1:2", ROLL, "neighbouring values"),
        ("1:2:1", ROLL, "one value is both ends"),
        ("0.5:6:0", ROLL, "count >= 1"),
        ("0.5:6:-3", ROLL, "count >= 1"),
        ("0.5:6:4.5", ROLL, "count of a range is a whole number"),
        ("0.5:6:many", ROLL, "count of a range is a whole number"),
        ("0.5:6:400m", ROLL, "count of a range is a whole number"),
        ("0.5:6:400:cubic", ROLL, "linear or log"),
        ("0:6:400:log", ROLL, "starts above 0"),
        ("-6:-1:400:log", ROLL, "starts above 0"),
        ("-1:6:400:log", ROLL, "starts above 0"),
        ("1:1.000000000000001:400", ROLL, "neighbouring values"),
        ("-1e308:1e308:3", ROLL, "finite"),
        ("nan", ROLL, "finite"),
        ("-inf", ROLL, "finite"),
        ("1e999", ROLL, "finite"),
        ("0:inf:5", ROLL, "finite"),
        ("1,nan", ROLL, "finite"),
        (math.inf, ROLL, "finite"),
        (10**400, ROLL, "finite"),
        ([1.0, math.nan], ROLL, "finite"),
        ("2,1", ROLL, "strictly increasing"),
        ("1,1", ROLL, "strictly increasing"),
        ([], ROLL, "at least one value"),
        (np.zeros((2, 2)), ROLL, "one dimension"),
        ("", ROLL, "not a value"),
        (",", ROLL, "not a value"),
        ("fast", ROLL, "not a value"),
        ("0.5:6", ROLL, "not a value"),
        ("0.5:6:4:log:9", ROLL, "not a value"),
        ("1,2:3:4", ROLL, "not a value"),
        (None, ROLL, "not a value"),
        (True, ROLL, "not a value"),
        (1j, ROLL, "not a value"),
        ({"start": 1}, ROLL, "not a value"),
        (b"3", ROLL, "not a value"),
        ("3s", TILT, "tilt takes deg, rad"),
        ("3deg", ALPHA, "alpha takes no unit"),
        ("5Hz", RATE, "precession_rate takes rad/s, deg/s, rpm"),
        ("5/s", RATE, "not known"),
        ("5rad", RATE, "does not fit"),
        ("5kg", GRAVITY, "gravity takes m/s2"),
        ("5degC", DURATION, "duration takes s"),
        ("5 parsnips", RADIUS, "not known"),
        ("5 m(", RADIUS, "not known"),
        ("5 m/", RADIUS, "not known"),
        ("0.1:20deg:300", TILT, "each number takes its own unit"),
        ("1,20deg", TILT, "each number takes its own unit"),
    ],
)
def test_what_is_not_a_value_is_refused(raw, quantity, message):
    """The message names the quantity, the rule that was broken and what was given."""
    with pytest.raises(RequestError, match=message) as caught:
        read_value(raw, quantity)
    assert str(caught.value).startswith(f"{quantity.name}: ")
    assert f"got {quantity.name}=" in str(caught.value)


def test_zero_needs_no_unit():
    """Zero is the same in radians and degrees, so it may stand bare beside a unit."""
    assert read_value("0:20deg:30", TILT) == Range(0.0, math.radians(20), 30)


def test_minus_zero_is_zero():
    """-0 and 0 are one value and read the same, so that they are one spec."""
    assert str(read_value("-0", TILT)) == "0.0"
    assert str(Range(-1.0, -0.0, 3)) == "-1.0:0.0:3"
    assert str(Values((-0.0, 1.0))) == "0.0,1.0"


@pytest.mark.parametrize("raw", ["1,2", "1:2:3", [1.0]])
def test_a_setting_is_not_an_axis(raw):
    """Where one number is wanted, a list or a range is refused."""
    with pytest.raises(RequestError, match=r"duration: .* one number for all cells"):
        read_number(raw, DURATION)


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


@settings(max_examples=300)
@given(st.text(alphabet="0123456789.,:-+e degradmsHzlogµ°%/*^()[]_\"'\\\n\t", max_size=20))
def test_any_text_is_read_or_refused(text):
    """No text ends in anything but a value or a RequestError."""
    try:
        value = read_value(text, TILT)
    except RequestError:
        return
    assert isinstance(value, float | Range | Values)
