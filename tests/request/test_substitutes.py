"""Alternative inputs (scaled rates, speed, inclination) in commands, files and Python."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from messages import assert_facts, refused

from sweep.atlas.boundary import theory_lines
from sweep.atlas.outlook import one_sided
from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.substitutes import changed, resolved
from sweep.request.words import names

#: A coin on the moon: sqrt(gravity/radius) = 11.619 rad/s.
COIN = {"radius": "12mm", "gravity": 1.62}
UNIT = math.sqrt(1.62 / 0.012)


def test_a_scaled_rate_is_in_units_of_the_root_of_gravity_over_radius():
    """Numbers, lists and ranges are multiplied; a logarithmic range stays logarithmic."""
    for rate in ["tilt_rate", "precession_rate", "roll_rate"]:
        for raw, expected in [
            (0.5, 0.5 * UNIT),
            ("-0.5", -0.5 * UNIT),
            ("0.5,1", Values((0.5 * UNIT, UNIT))),
            (np.array([0.5, 1.0]), Values((0.5 * UNIT, UNIT))),
            ("0.5:1.5:11", Range(0.5 * UNIT, 1.5 * UNIT, 11)),
            ("0.5:1.5:11:log", Range(0.5 * UNIT, 1.5 * UNIT, 11, "log")),
        ]:
            found = getattr(SweepSpec(**COIN, **{f"scaled_{rate}": raw}), rate)
            assert type(found) is type(expected)
            if isinstance(expected, float):
                assert found == pytest.approx(expected, rel=1e-15)
                return
            assert len(found) == len(expected)
            assert getattr(found, "spacing", "") == getattr(expected, "spacing", "")
            np.testing.assert_allclose(found.array(), expected.array(), rtol=4e-15)


def test_the_speed_is_that_of_the_contact_point():
    """The arc on the plane is as long as the rolled arc of the rim: v = R times the roll rate."""
    assert SweepSpec(speed="15cm/s", radius="12mm").roll_rate == 12.5
    assert SweepSpec(speed=1.5).roll_rate == 3.0
    assert SweepSpec(speed="-3.6km/h").roll_rate == -2.0
    assert SweepSpec(speed="1:2:5").roll_rate == Range(2.0, 4.0, 5)


def test_it_means_the_same_in_words_files_and_python(spec_file):
    """Words, TOML and Python give the same spec, which only stores the rate, as if given in rad/s."""
    python = SweepSpec(scaled_roll_rate="0.5:1:5", tilt="1deg:5deg:3", radius="12mm")
    path = spec_file('scaled_roll_rate = "0.5:1:5"\ntilt = "1deg:5deg:3"\nradius = "12mm"\n')
    words = ["scaled_roll_rate=0.5:1:5", "tilt=1deg:5deg:3", "radius=12mm"]
    assert SweepSpec.from_toml(path) == SweepSpec.from_words(spec_file(""), words) == python
    assert python == SweepSpec(roll_rate=python.roll_rate, tilt="1deg:5deg:3", radius=0.012)
    assert "scaled" not in python.canonical() + repr(python) + python.to_toml()
    assert SweepSpec.from_canonical(python.canonical()) == python
    assert python.axes == ("roll_rate", "tilt")


@given(
    st.sampled_from(sorted(name for name, each in DISK.substitutes.items() if each.needs)),
    st.floats(-1e3, 1e3),
    st.floats(1e-3, 1e3),
    st.floats(1e-3, 1e3),
)
def test_a_substitute_is_its_parameter_times_its_scale(name, value, radius, gravity):
    """The given value is recovered from the spec's rate, up to rounding."""
    spec = SweepSpec(**{name: value}, radius=radius, gravity=gravity)
    substitute = DISK.substitutes[name]
    back = getattr(spec, substitute.parameter) * substitute.scale({"radius": radius, "gravity": gravity})
    assert back == pytest.approx(value, rel=1e-15, abs=1e-300)


def test_a_diameter_is_twice_the_radius():
    """It works for a number, as an axis, and where a scaled rate, a speed or a length needs the radius."""
    for words in ("", "scaled_roll_rate=0.5", "speed=1", "body=torus tube=1mm"):
        given, expected = (
            SweepSpec.from_words("rolling", [size, *words.split()])
            for size in ("diameter=3cm", "radius=1.5cm")
        )
        assert given.canonical() == expected.canonical(), words
    assert SweepSpec(diameter="2cm:4cm:3").radius.array() == pytest.approx([0.01, 0.015, 0.02])
    with refused("radius", "diameter"):
        SweepSpec(diameter=1, radius=2)
    with refused("speed", "radius"):
        SweepSpec(diameter="2cm:4cm:3", speed=1)


def test_the_inclination_is_what_the_tilt_lacks_to_a_right_angle():
    """Values are reversed so that the tilt increases; ranges stay ranges, logarithmic ones become lists."""
    for raw, expected in [
        ("30deg", math.radians(60.0)),
        ("100deg", math.radians(-10.0)),
        ("1deg,4deg,10deg", [80.0, 86.0, 89.0]),
        ("1deg:10deg:4", [80.0, 83.0, 86.0, 89.0]),
        ("0.1deg:10deg:3:log", [80.0, 89.0, 89.9]),
    ]:
        found = SweepSpec(inclination=raw).tilt
        if isinstance(expected, float):
            assert found == pytest.approx(expected, rel=1e-15)
            return
        assert isinstance(found, Range if raw.count(":") == 2 else Values)
        np.testing.assert_allclose(np.degrees(found.array()), expected, rtol=1e-14)


def test_the_inclination_of_random_starts():
    """A uniform distribution is reversed, a normal one keeps its deviation; a logarithmic one is refused."""
    random = {"samples": 3, "roll_rate": 3.0}
    uniform = SweepSpec(inclination="uniform:1deg:10deg", **random).tilt
    assert np.degrees([uniform.first, uniform.second]) == pytest.approx([80.0, 89.0], rel=1e-14)
    normal = SweepSpec(inclination="normal:10deg:2deg", **random).tilt
    assert np.degrees([normal.first, normal.second]) == pytest.approx([80.0, 2.0], rel=1e-14)
    with refused("inclination=loguniform:1deg:10deg", "tilt", "uniform"):
        SweepSpec(inclination="loguniform:1deg:10deg", **random)


def test_an_inclination_of_no_tilt_is_refused_by_its_name():
    """For flat, negative or degree-like values the message names the input and the rule of the tilt."""
    for raw in ["0", "-3deg", "180deg", 10, "1deg:200deg:5", "uniform:-1deg:3deg"]:
        random = {"samples": 3} if "uniform" in str(raw) else {}
        with refused("|tilt| < 1.570796326 rad" if raw == 10 else "|tilt| < 90 deg") as caught:
            SweepSpec(inclination=raw, **random)
        assert str(caught.value.where).startswith("inclination=")


def test_a_logarithmic_range_of_the_inclination_is_no_longer_than_a_list():
    """It is expanded into a list; more than ten thousand values are refused before they are created."""
    with refused("10000", "1000000000000") as caught:
        SweepSpec(inclination="0.1deg:1deg:1000000000000:log")
    assert caught.value.where.startswith("inclination=")


def test_tilt_and_inclination_are_one_word():
    """Giving both is refused; a change of one replaces the other in its place."""
    with refused("tilt=0.1", "inclination=0.2"):
        SweepSpec(tilt=0.1, inclination=0.2)
    spec = SweepSpec.preset("rolling", inclination="1deg:10deg:4")
    assert spec.axes == ("roll_rate", "tilt")
    assert SweepSpec.from_canonical(spec.canonical()) == spec


@pytest.mark.parametrize(
    ("changes", "axes", "rates"),
    [
        (["roll_rate=1:2:7"], ("roll_rate", "tilt"), (1.0, 2.0)),
        (["alpha=0.5,1", "roll_rate=1:2:7"], ("roll_rate", "tilt", "alpha"), (1.0, 2.0)),
        (["speed=1:2:7"], ("roll_rate", "tilt"), (2.0, 4.0)),
        (["radius=2", "speed=1:2:7"], ("roll_rate", "tilt"), (0.5, 1.0)),
        (["roll_rate=3"], ("tilt",), None),
    ],
)
def test_a_change_replaces_whichever_way_a_rate_was_given(spec_file, changes, axes, rates):
    """A new rate replaces the file's scaled rate in its place among the axes, and vice versa."""
    made = [
        SweepSpec.from_words(spec_file(f'{rate}\ntilt = "1deg:5deg:3"\n'), changes)
        for rate in ('scaled_roll_rate = "0.5:1:5"', 'roll_rate = "0.5:1:5"', 'speed = "0.5:1:5"')
    ]
    assert {spec.axes for spec in made} == {axes}
    assert {spec.canonical() for spec in made} == {made[0].canonical()}
    if rates:
        assert made[0].roll_rate == Range(*rates, 7)


def test_a_spec_is_changed_in_the_same_way():
    """`replace` accepts substitutes; a new disk keeps the spec's rates in rad/s, but rescales a preset's."""
    spec = SweepSpec.preset("rolling")
    assert spec.replace(speed="1:2:7") == spec.replace(roll_rate="2:4:7")
    assert spec.replace(speed="1:2:7", radius=1.0) == spec.replace(roll_rate="1:2:7", radius=1.0)
    assert spec.replace(speed=1.5).axes == ("tilt",)
    assert SweepSpec(tilt="1deg,2deg").replace(alpha="0.5,1", speed="1,2").axes == (
        "tilt",
        "alpha",
        "roll_rate",
    )
    assert spec.replace(radius="12mm").roll_rate == spec.roll_rate
    ends = SweepSpec.preset("rolling", radius="12mm").roll_rate.ends()
    np.testing.assert_allclose(ends, spec.roll_rate.ends() * math.sqrt(0.5 / 0.012), rtol=1e-15)


def test_a_preset_covers_the_boundary_of_every_disk():
    """The critical line lies in the range in as many rows as for the default disk, without a warning."""
    for disk in [{"radius": "12mm"}, {"gravity": 1.62}, {"radius": 40.0, "gravity": 274.0}]:
        for name in ("rolling", "spinning", "circling"):
            inside = []
            for spec in (SweepSpec.preset(name), SweepSpec.preset(name, **disk)):
                (axis,) = spec.model.controls(spec.axes)
                low, high = getattr(spec, axis).ends()
                lines = theory_lines(spec, axis)
                inside.append(
                    {edge: int(np.sum((low < line[0]) & (line[0] < high))) for edge, line in lines.items()}
                )
                assert one_sided(spec) == []
            assert inside[0] == inside[1]
            assert inside[0]["upper"] == 200 if name != "circling" else max(inside[0].values()) > 100


def test_what_cannot_be_resolved_is_refused():
    """Conflicting inputs, wrong units, overflowing numbers and misspelled names are refused."""
    for words, facts in [
        ("roll_rate=3 scaled_roll_rate=0.5", ["roll_rate=3", "scaled_roll_rate=0.5"]),
        ("speed=3 scaled_roll_rate=0.5", ["roll_rate", "speed=3", "scaled_roll_rate=0.5"]),
        ("scaled_roll_rate=3rad/s", ["scaled_roll_rate=3rad/s", "pure number"]),
        ("speed=3rad/s", ["speed=3rad/s", "m/s", "cm/s", "km/h"]),
        ("speed=fast", ["speed=fast", "a,b,c", "start:stop:count[:log]"]),
        ("speed=nan", ["speed=nan", "finite"]),
        ("speed=1e300 radius=1e-100", ["speed=1e300", "inf rad s-1", "finite"]),
        ("speed=1:1e300:4 radius=1e-100", ["speed=1:1e300:4", "finite", "1e300"]),
        ("speed=2:1:4", ["speed=2:1:4", "start < stop"]),
        ("speed=2 radius=-1", ["radius=-1", "radius > 0"]),
        ("spede=2", ["spede", "speed?"]),
        ("scaled_rol_rate=2", ["scaled_rol_rate", "scaled_roll_rate?"]),
        ("velocity=2", ["velocity", "speed?"]),
    ]:
        with refused(*facts) as caught:
            SweepSpec.from_words("rolling", words.split())
        assert caught.value.hint
        with pytest.raises(RequestError):
            SweepSpec.preset("rolling").replace(**dict(word.split("=") for word in words.split()))


def _instead(caught):
    """Return the words that a refusal suggests instead."""
    return re.findall(r"\w+=\S+", caught.value.hint.removesuffix("."))


def test_where_the_disk_varies_the_words_to_add_are_told():
    """Scaled rates are undefined if radius or gravity is an axis; the advice gives a valid request."""
    for preset, words, where, instead in [
        ("rolling", "radius=5mm,12mm", "radius", ["roll_rate=12.91:40:801"]),
        ("spinning", "gravity=9.81,39.24", "gravity", ["precession_rate=3:12:801"]),
        ("circling", "gravity=9.81,39.24", "gravity", ["precession_rate=0.01:10:800", "tilt_rate=0.0001414"]),
        ("rolling", "scaled_roll_rate=0.5:1:9:log gravity=2,8", "gravity", ["roll_rate=1:4:9:log"]),
        ("rolling", "speed=-2 radius=0.5,2", "radius", ["roll_rate=-2"]),
        ("rolling", "speed=-2:-1:3 radius=0.5,2", "radius", ["roll_rate=-4:-0.5:3"]),
    ]:
        with pytest.raises(RequestError) as caught:
            SweepSpec.from_words(preset, words.split())
        assert (caught.value.where, _instead(caught)) == (where, instead)
        kept = [word for word in words.split() if word.partition("=")[0] not in DISK.substitutes]
        assert where in SweepSpec.from_words(preset, [*kept, *instead]).axes


def test_where_the_disk_of_starts_varies_the_words_to_add_are_told():
    """sqrt(gravity/radius) is 2 and 4: the advice has no ranges, and uses the geometric mean for a number."""
    drawn = {"gravity": "uniform:2:8", "samples": 5, "tilt": "1deg"}
    for rate, words, instead in [
        ("0.5", drawn, "1.414"),
        ("0.5:1:9:log", drawn, "uniform:1:4"),
        ("uniform:0.5:1", drawn, "uniform:1:4"),
        ("0.5,1", {"starts": {"gravity": [2.0, 8.0], "tilt": [0.1, 0.1]}}, "2"),
    ]:
        with pytest.raises(RequestError) as caught:
            SweepSpec(**words, scaled_roll_rate=rate)
        assert _instead(caught) == [f"roll_rate={instead}"]
        assert SweepSpec(**words, roll_rate=instead).is_list


def test_a_column_is_not_given_in_another_way():
    """The refusal names the given word."""
    with refused("roll_rate", "speed=20cm/s", "column") as caught:
        SweepSpec.preset("rolling", speed="20cm/s", starts={"tilt": [0.1], "roll_rate": [2.0]})
    assert caught.value.where == "speed"
    assert_facts(caught.value.hint, "speed")


def test_an_axis_of_one_value_is_one_disk():
    """A list with only one radius does not count as varying."""
    spec = SweepSpec.preset("rolling", radius="12mm,")
    assert spec.roll_rate == SweepSpec.preset("rolling", radius="12mm").roll_rate
    assert spec.axes == ("roll_rate", "tilt", "radius")


def test_a_fault_is_placed_where_it_stands(spec_file):
    """A fault in the file is reported with the file, one in the change with the change."""
    path = spec_file('speed = "1:2:3"\nscaled_roll_rate = 0.5\n')
    with refused("roll_rate", "speed=1:2:3", "scaled_roll_rate=0.5") as caught:
        SweepSpec.from_toml(path)
    assert caught.value.where == f"{path}: scaled_roll_rate"
    assert SweepSpec.from_words(path, ["roll_rate=3"]).roll_rate == 3.0
    with refused("roll_rate=steady", "precession_rate=0.0") as caught:
        SweepSpec.from_words("circling", ["scaled_precession_rate=0"])
    assert caught.value.where == "precession_rate"


def test_words_that_stand_for_nothing_are_as_they_were():
    """Inputs without a substitute are not parsed; missing ones come from known values or defaults."""
    assert resolved({"tilt": "2deg", "wobble": None}, DISK) == {"tilt": "2deg", "wobble": None}
    assert resolved({"speed": 3.0}, DISK, {"radius": 2.0}) == {"roll_rate": 1.5}
    assert resolved({"speed": 3.0, "radius": 1.5}, DISK, {"radius": 2.0})["roll_rate"] == 2.0
    assert list(changed({"a": 1, "speed": 2, "b": 3}, {"c": 4, "roll_rate": 5}, DISK)) == [
        "a",
        "roll_rate",
        "b",
        "c",
    ]


def test_every_substitute_has_a_name_of_its_own():
    """No word has two meanings; a substitute replaces a parameter and only needs numeric parameters."""
    for name, substitute in DISK.substitutes.items():
        assert name == substitute.name not in names(DISK)
        assert substitute.parameter in DISK.parameters
        assert not any(DISK.parameters[each].words for each in substitute.needs)
        assert substitute.parameter not in substitute.needs
