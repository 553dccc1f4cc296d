"""From text to values: numbers, lists and ranges with units, read in SI or refused."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from messages import refused

from sweep.errors import RequestError, shown
from sweep.model.disk.tables import PARAMETERS, SETTINGS
from sweep.model.quantity import DECISION, Quantity
from sweep.request.sources import Range, Values
from sweep.request.units import factor_to_si, plain_number, read_unit
from sweep.request.values import read_number, read_value

TILT, RATE, ROLL = PARAMETERS["tilt"], PARAMETERS["precession_rate"], PARAMETERS["roll_rate"]
ALPHA, RADIUS, GRAVITY = PARAMETERS["alpha"], PARAMETERS["radius"], PARAMETERS["gravity"]
DURATION = SETTINGS["duration"]

#: What a message says about text that is no value: the three allowed forms.
NO_VALUE = ["a number", "a,b,c", "start:stop:count"]

FINITE = st.floats(allow_nan=False, allow_infinity=False)


def test_a_number_is_read_in_si():
    """A number with a fitting unit, or without one, becomes one float in SI."""
    for raw, quantity, expected in [
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
    ]:
        value = read_value(raw, quantity)
        assert type(value) is float
        assert value == pytest.approx(expected, rel=1e-15)  # The conversion rounds once or twice.


def test_a_list_is_an_axis():
    """Text with commas, sequences and arrays become axes, even with one element."""
    for raw, expected in [
        ("0.5,1", (0.5, 1.0)),
        ("0.5,", (0.5,)),
        ([0.5, 1], (0.5, 1.0)),
        (("50%", "100%"), (0.5, 1.0)),
        (np.array([0.25, 0.5]), (0.25, 0.5)),
        (Values((0.5, 1.0)), (0.5, 1.0)),
    ]:
        value = read_value(raw, ALPHA)
        assert isinstance(value, Values)
        assert value.values == expected
        assert value.array().tolist() == list(expected)
        assert len(value) == len(expected)


def test_a_range_is_an_axis():
    """A range keeps its ends (in SI), its count and its spacing."""
    assert read_value("0.5:6:400", ROLL) == Range(0.5, 6.0, 400)
    assert read_value("0.01deg : 20deg : 300 : log", TILT) == Range(
        math.radians(0.01), math.radians(20), 300, "log"
    )
    assert read_value("1:1:1", ROLL).array().tolist() == [1.0]
    assert len(read_value("1:1:1", ROLL)) == 1


@given(st.floats(1e-6, 1e6), st.floats(1.1, 1e6), st.integers(2, 10**9), st.sampled_from(["linear", "log"]))
def test_a_range_reads_back_as_itself(start, factor, count, spacing):
    """The text of a range reads back bit for bit."""
    axis = Range(start, start * factor, count, spacing)
    assert read_value(str(axis), ROLL) == axis


@given(st.lists(FINITE, min_size=1, unique=True).map(sorted))
def test_a_list_reads_back_as_itself(numbers):
    """The text of a list reads back bit for bit, and stays a list if it has one value."""
    axis = Values(tuple(numbers))
    assert read_value(str(axis), ROLL) == axis


def test_what_is_not_a_value_is_refused():
    """The error names the input and its value, the broken rule, and the remedy."""
    for raw, quantity, facts in [
        ("6:0.5:400", ROLL, ["start < stop", "got 6:0.5:400"]),
        ("1:1:2", ROLL, ["1e-12"]),
        ("1:2:1", ROLL, ["both ends", "equal"]),
        ("0.5:6:0", ROLL, ["count >= 1"]),
        ("0.5:6:-3", ROLL, ["count >= 1", "-3"]),
        ("0.5:6:4.5", ROLL, ["count", "whole number", "4.5"]),
        ("0.5:6:many", ROLL, ["count", "whole number", "many"]),
        ("0.5:6:400m", ROLL, ["count", "whole number", "400m"]),
        ("0.5:6:400:cubic", ROLL, ["linear or log", "cubic"]),
        ("0:6:400:log", ROLL, ["logarithmic", "above 0"]),
        ("-6:-1:400:log", ROLL, ["logarithmic", "above 0"]),
        ("-1:6:400:log", ROLL, ["logarithmic", "above 0"]),
        ("1:1.000000000000001:400", ROLL, ["1e-12"]),
        ("-1e308:1e308:3", ROLL, ["finite", "1e300"]),
        ("nan", ROLL, ["finite", "nan"]),
        ("-inf", ROLL, ["finite", "-inf"]),
        ("1e999", ROLL, ["finite", "1e999"]),
        ("0:inf:5", ROLL, ["finite", "inf"]),
        ("1,nan", ROLL, ["finite", "nan"]),
        (math.inf, ROLL, ["finite", "inf"]),
        (10**400, ROLL, ["finite"]),
        ([1.0, math.nan], ROLL, ["finite", "nan"]),
        ("2,1", ROLL, ["strictly increasing", "Sort"]),
        ("1,1", ROLL, ["strictly increasing", "repetitions"]),
        ([], ROLL, ["at least one value"]),
        (np.zeros((2, 2)), ROLL, ["one dimension", "(2, 2)"]),
        ("", ROLL, NO_VALUE),
        (",", ROLL, NO_VALUE),
        ("fast", ROLL, [*NO_VALUE, "fast"]),
        ("0.5:6", ROLL, ["start:stop:count", "got 0.5:6", "Write 0.5:6:100"]),
        ("0.5:6:4:log:9", ROLL, NO_VALUE),
        ("1,2:3:4", ROLL, NO_VALUE),
        ("\u22121deg", TILT, [*NO_VALUE, "hyphen"]),
        (None, ROLL, NO_VALUE),
        (True, ROLL, NO_VALUE),
        (1j, ROLL, NO_VALUE),
        ({"start": 1}, ROLL, NO_VALUE),
        (b"3", ROLL, NO_VALUE),
        ("3s", TILT, ["does not fit", "'s'", "deg, rad"]),
        ("2..4", TILT, ["start:stop:count"]),
        ("1.2.3deg", TILT, ["one decimal point"]),
        ("3deg", ALPHA, ["does not fit", "no unit"]),
        ("5Hz", RATE, ["does not fit", "rad/s, deg/s, rpm"]),
        ("5/s", RATE, ["not known", "/s"]),
        ("5rad", RATE, ["does not fit", "rad/s, deg/s, rpm"]),
        ("5kg", GRAVITY, ["does not fit", "m/s2"]),
        ("5degC", DURATION, ["does not fit", "s, ms, min"]),
        ("5 parsnips", RADIUS, ["not known", "parsnips"]),
        ("5 m(", RADIUS, ["not known"]),
        ("5 m/", RADIUS, ["not known"]),
        ("0.1:20deg:300", TILT, ["own unit"]),
        ("1,20deg", TILT, ["own unit"]),
    ]:
        with pytest.raises(RequestError) as caught:
            read_value(raw, quantity)
        assert caught.value.where == f"{quantity.name}={shown(raw)}"
        assert all(fact in str(caught.value) for fact in facts), str(caught.value)
        assert caught.value.hint


def test_zero_needs_no_unit():
    """Zero is the same in radians and degrees, so it needs no unit."""
    assert read_value("0:20deg:30", TILT) == Range(0.0, math.radians(20), 30)


def test_minus_zero_is_zero():
    """-0 and 0 read as the same value, so they give the same spec."""
    assert str(read_value("-0", TILT)) == "0.0"
    assert str(read_value("-0,1", TILT)) == "0.0,1.0"


def test_a_setting_is_not_an_axis():
    """If one number is required, a list or a range is refused by name."""
    for raw in ["1,2", "1:2:3", [1.0]]:
        with refused("duration", "one number") as caught:
            read_number(raw, DURATION)
        assert caught.value.where.startswith("duration=")


@settings(max_examples=300)
@given(st.text(alphabet="0123456789.,:-+e degradmsHzlogµ°%/*^()[]_\"'\\\n\t", max_size=20))
def test_any_text_is_read_or_refused(text):
    """Any text gives either a value or a RequestError."""
    try:
        value = read_value(text, TILT)
    except RequestError:
        return
    assert isinstance(value, float | Range | Values)


SPELLINGS = {
    GRAVITY: "m·s⁻² m·s^-2 m/s² m/(s*s) m/(s·s) m/(s^2) m/(s**2) (m/s)/s ((m)/s)/s m.s-2 m/s^2.0 m/s**2.0 1/s2*m",
    RATE: "rad·s⁻¹ rad⋅s⁻¹ (rad)/(s) (rad)/((s)) 1/(s/(1*(rad))) rad.s-1 rad/s*1",
    RADIUS: "(m) ((m)) m/1 m*1 m·1 1/m-1 m²/m",
    DURATION: "s*1 s¹",
}


def test_a_unit_is_spelled_as_people_spell_it():
    """Dots, superscripts, parentheses and the factor 1 are accepted in SI units."""
    for quantity, unit in [(quantity, unit) for quantity, line in SPELLINGS.items() for unit in line.split()]:
        assert read_number(f"1.5 {unit}", quantity) == 1.5


def test_units_have_their_defined_sizes():
    """Units have their standard sizes in SI; no other everyday name is known."""
    for units, sizes in {
        "m": "m 1 mm 1e-3 um 1e-6 µm 1e-6 cm 0.01 km 1000 inch 0.0254 in 0.0254 foot 0.3048 ft 0.3048 yd 0.9144 "
        "mile 1609.344 nautical_mile 1852 micron 1e-6 angstrom 1e-10 millimeters 1e-3 metre 1",
        "kg": "kg 1 g 1e-3 mg 1e-6 pound 0.45359237 lb 0.45359237 ounce 0.028349523125 tonne 1000 grams 1e-3",
        "s": "s 1 ms 1e-3 us 1e-6 minute 60 min 60 h 3600 hours 3600 day 86400 week 604800 seconds 1",
        "rad": f"rad 1 deg {math.pi / 180} ° {math.pi / 180} arcmin {math.pi / 10800} arcsec {math.pi / 648000} "
        f"turn {2 * math.pi} grad {math.pi / 200} mrad 1e-3 degrees {math.pi / 180}",
        "rad s-1": f"rpm {math.pi / 30} rps {2 * math.pi} turn/min {math.pi / 30} rad*Hz 1 krpm {math.pi / 0.03}",
        "m s-2": "g_0 9.80665 gravity 9.80665 N/kg 1 dyn/g 0.01 lbf/lb 9.80665 cm/s2 0.01 kph/s 0.2777777777777778 "
        "mph/s 0.44704 knot/s 0.5144444444444445",
        "1": "% 0.01 percent 0.01 m/cm 100",
        "Pa s": "Pa*s 1 uPa*s 1e-6 poise 0.1 cP 1e-3 hPa*s 100 hectopascal*s 100 "
        "kPa*s 1e3 MPa*s 1e6 GPa*s 1e9 dPa*s 0.1 daPa*s 10 nPa*s 1e-9 pPa*s 1e-12 bar*s 1e5 "
        "picopascal*s 1e-12 nanopascal*s 1e-9 micropascal*s 1e-6 millipascal*s 1e-3 centipascal*s 0.01 "
        "decipascal*s 0.1 decapascal*s 10 kilopascal*s 1e3 megapascal*s 1e6 gigapascal*s 1e9 cPa*s 0.01 mPa*s 1e-3",
        "kg m-3": "kg/m3 1 g/cm3 1000 kg/l 1000 kg/L 1000",
        "N m s": "N*m*s 1 J*s 1 W*s2 1",
        "kg m2 s-3 A-1": "V 1 mV 1e-3 volts 1 kilovolt 1e3 J/C 1 W/A 1 Wb/s 1 A*ohm 1 A/S 1",
        "A": "A 1 uA 1e-6 amps 1 C/s 1 V/ohm 1 V/kΩ 1e-3 V*s/H 1 F*V/s 1 T*m/H*m 1",
        "kg m2 s-2 K-1": "J/K 1 kJ/K 1e3 cal/K 4.184 W*s/K 1",
    }.items():
        words, quantity = sizes.split(), Quantity("size", "", units, "", DECISION)
        for unit, size in zip(words[::2], words[1::2], strict=True):
            assert factor_to_si(unit, quantity) == pytest.approx(float(size), rel=1e-14), unit


def test_the_units_of_the_page_are_read():
    """docs/words.md lists them, and spells one unit in several ways."""
    page = (Path(__file__).parents[2] / "docs" / "words.md").read_text(encoding="utf-8")
    section = page.partition("## Units")[2].partition("\n## ")[0]
    names = re.findall("`([^`]+)`", section)
    assert len(names) > 40
    assert [name for name in names if read_unit(name) is None] == []
    assert {read_unit(name) for name in names[:5]} == {read_unit("m/s2")}


def test_what_is_no_unit_is_refused_at_once():
    """Numbers, calls, unclosed parentheses and impossible powers are refused in a short sentence."""
    for unit in [
        "m*(9**9**9)",
        "m**9**9**9", "m**999999999", "m^-100", "m999999999", "m[0]", "m.0", "m+m", "m//m", "m%m",
        "'m'", "lambda:m", "m*9", "9", "m**m", "m" * 10**6, "*m" * 100, "m\n*m" * 50, "\uff4d**\uff19\uff19\uff19",
        "(m", "m)", "()", "m(m)", "m**(2)", "m*2", "1", "1*1", "m*1e9", "m*10", "1 m", "m^2.5",
        "m\u00b2\u00b3\u2074", "(m)**99", "m..m", "m\u00b7" * 41, "m**1**1",
    ]:  # fmt: skip
        with pytest.raises(RequestError) as caught:
            read_value(f"1 {unit}", RADIUS)
        # The message quotes the unit, or both ends of a long one.
        told = "".join(str(caught.value).split())
        assert any("".join(shown(each).split()) in told for each in (unit, f"1 {unit}")), told
        assert len(str(caught.value)) < 500, unit


def test_products_are_not_read_as_plurals():
    """Volt-seconds and pascal-seconds need a sign or a blank between their factors."""
    assert [read_unit(name) for name in ("Vs", "As", "Ns", "Ks", "Pas")] == [None] * 5


def test_a_plain_number_is_ascii():
    """Digits of other scripts, underscores and units are not plain numbers."""
    for text in ["\uff11e-6", "1_0", "1 m", "0x1", "", "1e", "nan"]:
        assert math.isnan(plain_number(text))
        assert plain_number(" 1e-6 ") == 1e-6


@pytest.mark.parametrize("unit", ["t66", "Mt99", "um99", "Gt30 Gt30", "t51/um99", "pm30 pm30"])
def test_a_unit_beyond_all_floats_is_no_unit(unit):
    """It is refused like an unknown unit."""
    quantity = Quantity("mass", "", "kg", "", DECISION)
    with refused("mass=1"):
        read_number(f"1 {unit}", quantity)
