"""A refusal quotes a value as given, in its unit, and the allowed range in the same unit."""

import math
import re

import numpy as np
import pytest
from messages import assert_facts, missing, refused

from sweep.atlas.parts import nearest_cell
from sweep.errors import RequestError
from sweep.model import registry
from sweep.model.disk.tables import PARAMETERS, SETTINGS
from sweep.motion.origin import request_of_preset
from sweep.motion.request import TrajectorySpec
from sweep.request.spec import SweepSpec
from sweep.request.units import factor_to_si, number_and_unit
from sweep.request.values import as_given, as_written, both_written, in_unit, rule_in

#: SI units -> other units that a request may use.
UNITS = {
    "rad": ("deg", "°", "arcmin"),
    "rad s-1": ("rpm", "deg/s"),
    "m": ("mm", "inch", "cm"),
    "m s-1": ("cm/s", "km/h"),
    "m s-2": ("cm/s2",),
    "s": ("ms", "min"),
    "kg": ("g",),
    "kg m-3": ("g/cm3",),
    "Pa s": ("uPa s",),
    "N m s": ("mN m s",),
    "1": ("%",),
}

#: Numbers; each rule forbids at least one of them in any unit.
NUMBERS = ("-3.7", "123457", "0")


#: Model, quantity and unit: all parameters and settings of all models, and their substitutes.
CASES = [
    (model, row, unit)
    for model in registry.every()
    for row in {**model.parameters, **model.settings, **model.substitutes}.values()
    for unit in UNITS[row.units]
]


def _impossible(quantity, unit):
    """Return a number that a quantity's rule forbids in a unit, or None."""
    allows = getattr(quantity, "allows", None)
    factor = factor_to_si(unit, quantity)
    if quantity.name == "inclination":
        return "-3.7"
    return next((each for each in NUMBERS if allows and not allows(float(each) * factor)), None)


def test_every_refusal_says_what_was_given():
    """Numbers, lists, ranges and distributions of every quantity and unit are quoted, never in SI digits."""
    for model, quantity, unit in CASES:
        number, factor, name = _impossible(quantity, unit), factor_to_si(unit, quantity), quantity.name
        several = name not in model.settings
        forms = [f"5.3{unit}:4.1{unit}:7"] * several
        if number is not None:
            forms += [f"{number}{unit}"]
            lists = (
                f"{number}{unit},",
                f"{number}{unit}:200000{unit}:5",
                f"uniform:{number}{unit}:200000{unit}",
            )
            forms += lists * several
        for text in forms:
            with pytest.raises(RequestError) as refusal:
                SweepSpec(model=model.name, **{name: text})
            said = str(refusal.value)
            assert f"{name}={text}" in said
            for given in (number, "5.3", "4.1"):
                if given is not None and f"{given}{unit}" in text:
                    in_si = repr(float(given) * factor)
                    same = in_si == given or in_si.removesuffix(".0") in (given, "0", "-0")
                    assert same or in_si not in said, said
            if name == "inclination" and number in text:
                tilts = [math.radians(90.0) / factor - float(each) for each in (number, "200000")]
                assert any(not missing(said, [f"{tilt:.10g} {unit}"]) for tilt in tilts), said
            # of a length without a body the number is not looked at
            elif number is not None and number in text and "names no body" not in said:
                assert_facts(said, f"{number} {unit}")


def test_what_is_allowed_is_said_in_the_unit_of_the_value():
    """The number appears as written, with the limits in its unit; bare numbers are SI."""
    for name, raw, text, rule in [
        ("tilt", "100deg", "100 deg", "|tilt| < 90 deg"),
        ("tilt", "5500arcmin", "5500 arcmin", "|tilt| < 5400 arcmin"),
        ("tilt", "2rad", "2 rad", "|tilt| < 1.570796326 rad"),
        ("tilt", 2.0, "2.0 rad", "|tilt| < 1.570796326 rad"),
        ("alpha", "150%", "150 %", "0 < alpha <= 100 %"),
        ("alpha", "1.5", "1.5", "0 < alpha <= 1"),
        ("radius", "-3mm", "-3 mm", "radius > 0"),
        ("fall_tilt", "0", "0 deg", "0 deg < fall_tilt < 90 deg"),
        ("tolerance", "0", "0 rad", "1e-12 rad <= tolerance <= 0.1 rad"),
        ("fall_tilt", "6000arcmin", "6000 arcmin", "0 arcmin < fall_tilt < 5400 arcmin"),
        ("tilt", "1.5707963268", "1.5707963268 rad", "|tilt| < 1.570796326 rad"),
        ("tolerance", "1e-11deg", "1e-11 deg", "5.729577952e-11 deg <= tolerance <= 5.729577951 deg"),
        ("tolerance", "6deg", "6 deg", "5.729577952e-11 deg <= tolerance <= 5.729577951 deg"),
    ]:
        with pytest.raises(RequestError) as refusal:
            SweepSpec(**{name: raw})
        assert_facts(refusal.value.message, text, rule)


def test_a_limit_in_a_message_may_be_copied():
    """An inclusive limit is accepted as printed, even rounded in another unit."""
    for model, quantity, unit in CASES:
        parts = re.split("[<>]=", rule_in(quantity, unit)) if hasattr(quantity, "rule") else []
        for number, found in filter(None, map(number_and_unit, (part for part in parts if "<" not in part))):
            assert quantity.allows(float(number) * factor_to_si(found, quantity)), (model.name, number)


def test_lists_and_distributions_are_said_as_given():
    """Texts in a list of a file or of Python also keep units; an inclination is reported as a tilt."""
    for words, facts, hint in [
        ({"tilt": ["5deg", "1deg"]}, ["['5deg', '1deg']"], []),
        ({"speed": ("2km/h", "1km/h")}, ["('2km/h', '1km/h')"], []),
        ({"tilt": [0.5, 0.1]}, ["(0.5, 0.1)"], []),
        ({"tilt": ["1deg", "100deg"]}, ["100 deg", "|tilt| < 90 deg"], ["|tilt| < 90 deg"]),
        ({"tilt": "95°"}, ["95 °", "|tilt| < 90 °"], ["|tilt| < 90 °"]),
        ({"tilt": ["1", "80"]}, ["80 rad", "|tilt| < 1.570796326 rad"], ["radians"]),
        ({"tilt": "1:80:5:log"}, ["80 rad", "|tilt| < 1.570796326 rad"], ["radians"]),
        (
            {"inclination": "uniform:0deg:10deg", "samples": 10},
            ["inclination=uniform:0deg:10deg", "tilt of 90 deg", "|tilt| < 90 deg"],
            ["|tilt| < 90 deg"],
        ),
    ]:
        with refused(*facts) as refusal:
            SweepSpec(**words)
        assert_facts(refusal.value.hint, *hint)


def test_a_number_without_text_is_said_in_the_unit_of_the_other_word():
    """A preset's duration, and numbers from Python or NumPy, have no unit of their own."""
    with refused("duration=1e+10ns", "interval=1ns", "7200000"):
        request_of_preset("rolling", {"tilt": "1deg", "roll_rate": "3", "interval": "1ns"})
    for step in (1e-9, np.float64(1e-9)):
        with refused("duration=300s", "step=1e-09s", "100000000"):
            SweepSpec(step=step)
        with refused("duration=3min", "step=1.666666667e-11min", "100000000"):
            SweepSpec(step=step, duration="3min")


def test_two_values_that_differ_are_not_said_alike():
    """They appear as people write them, or with all digits in SI if those texts are equal."""
    for name, given, said in [
        ("alpha", (0.4, 0.40000000001), ("0.4", "0.40000000001")),
        ("alpha", (0.4, 0.5), ("0.4", "0.5")),
        ("fall_tilt", ("85deg", 1.4835298642), ("1.4835298641951802", "1.4835298642")),
        (
            "tilt",
            ("1deg:5deg:5", "1deg:5.00000000001deg:5"),
            ("0.017453292519943295:0.08726646259971647:5", "0.017453292519943295:0.08726646259989101:5"),
        ),
        ("roll_rate", ("2,3", "2,3.00000000001"), ("2.0,3.0", "2.0,3.00000000001")),
    ]:
        first, second = (SweepSpec(**{name: value}) for value in given)
        assert both_written((first, second), name) == said
        assert all(
            getattr(SweepSpec(**{name: text}), name) == getattr(each, name)
            for text, each in zip(said, (first, second), strict=True)
        )


def test_each_number_of_a_list_has_its_own_unit():
    """The unit is that of the refused number; a value not in the text gets the first unit."""
    tilt = PARAMETERS["tilt"]
    assert as_given(2.0, tilt, "1deg,2rad") == ("2 rad", "rad")
    assert as_given(math.radians(1.0), tilt, "1deg,2rad") == ("1 deg", "deg")
    assert as_given(math.radians(3.0), tilt, "60arcmin:240arcmin:4") == ("180 arcmin", "arcmin")
    assert as_given(0.25, tilt, 0.25) == ("0.25 rad", "")
    assert in_unit(0.0123, PARAMETERS["radius"], "mm") == "12.3 mm"
    assert rule_in(SETTINGS["duration"], "min") == "duration > 0"


def test_a_value_of_a_spec_is_written_as_a_person_would():
    """Angles are in degrees, in any form of the value; other numbers are in SI."""
    spec = SweepSpec(tilt="1deg:5deg:20:log", roll_rate="2,3", alpha=1, fall_tilt="80deg")
    written = [as_written(getattr(spec, name), PARAMETERS[name]) for name in ("tilt", "roll_rate", "alpha")]
    assert written == ["1deg:5deg:20:log", "2,3", "1"]
    assert as_written(spec.fall_tilt, SETTINGS["fall_tilt"]) == "80deg"
    assert as_written("steady", PARAMETERS["roll_rate"]) == "steady"


def test_words_that_do_not_go_together_are_said_as_given():
    """Checks of several inputs quote the given ones, and write the others readably."""
    for words, facts in [
        (["step=1ns", "duration=3min"], ["got duration=3min step=1ns"]),
        (["step=1ns"], ["got duration=300s step=1ns"]),
        (
            ["rolling_friction=50mm", "radius=4cm"],
            ["rolling_friction=50mm: ", "got rolling_friction=50mm radius=4cm."],
        ),
        (["rolling_friction=50mm", "radius=0.04"], ["got rolling_friction=50mm radius=0.04."]),
        (["roll_rate=30rpm", "precession_rate=wobble"], ["got roll_rate=30rpm."]),
        (
            ["roll_rate=steady", "precession_rate=0rpm"],
            ["needs a precession_rate other than 0; got precession_rate=0rpm."],
        ),
        (["air_viscosity=18uPa s", "rolling_friction=1um"], ["air_viscosity=18uPa s: "]),
        (["criterion=aloft:-3min"], ["got aloft:-3min"]),
        (["criterion=departure:12000arcmin"], ["Got departure:12000arcmin"]),
        (["tilt=normal:1deg:0.2deg"], ["tilt=normal:1deg:0.2deg is a distribution"]),
        (["samples=9", "roll_rate=9rpm:20rpm:4", "tilt=uniform:1deg:2deg"], ["and roll_rate=9rpm:20rpm:4"]),
        (["samples=9", "tilt=normal:1deg:-0.2deg", "roll_rate=3"], ["got normal:1deg:-0.2deg"]),
    ]:
        with pytest.raises(RequestError) as refusal:
            SweepSpec.from_words("rolling", words)
        for each in facts:
            assert each in str(refusal.value)


def test_a_motion_is_refused_in_the_units_of_its_words():
    """Inputs are quoted as given, defaults in the unit of the others."""
    for words, fact in [
        (["tilt=5300arcmin", "fall_tilt=80deg"], "got tilt=5300arcmin fall_tilt=80deg"),
        (["tilt=5340arcmin"], "got tilt=5340arcmin fall_tilt=5100arcmin"),
        (["inclination=12arcmin"], "got tilt=89.8deg fall_tilt=85deg"),
        (["duration=1min", "step=1ns"], "got duration=1min step=1ns"),
        (["roll_rate=30rpm", "precession_rate=wobble"], "got roll_rate=30rpm."),
        (["speed=1m/s", "precession_rate=wobble"], "got roll_rate=2.0."),
        (["interval=1ns"], "got duration=1e+10ns interval=1ns"),
    ]:
        with pytest.raises(RequestError) as refusal:
            TrajectorySpec.from_words(words)
        assert fact in str(refusal.value)


def test_a_cell_outside_an_atlas_is_said_as_given():
    """The message has the value, and the axis in its unit; for a speed it has the rate."""
    for given, facts in [
        ({"tilt": "600arcmin"}, ["tilt=600arcmin", "600 arcmin", "60 arcmin", "300 arcmin"]),
        ({"tilt": "0.5 rad"}, ["0.5 rad", "0.01745329252 rad", "0.0872664626 rad"]),
        ({"tilt": 0.5}, ["tilt=0.5", "0.5 rad", "0.01745329252 rad", "0.0872664626 rad"]),
        ({"inclination": "60deg"}, ["inclination=60deg", "tilt", "30 deg", "1 deg", "5 deg"]),
        ({"inclination": 1.0}, ["inclination=1.0", "tilt"]),
        ({"tilt": 4.0}, ["tilt=4.0deg"]),
        ({"tilt": "1deg", "speed": "9m/s"}, ["speed=9m/s", "18 rad s-1", "1 rad s-1", "4 rad s-1"]),
    ]:
        spec = SweepSpec(roll_rate="1:4:4", tilt="1deg:5deg:5", radius=0.5)
        with refused(*facts):
            nearest_cell(spec, {"roll_rate": 2.0, **given} if "speed" not in given else given)
