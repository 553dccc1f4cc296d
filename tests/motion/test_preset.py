"""A motion of a preset: one number for each axis, and a wobble if no rate is given."""

import math

import pytest
from messages import refused

import sweep
from sweep.errors import RequestError
from sweep.motion.origin import is_preset, request_of_preset
from sweep.motion.request import LossyTrajectorySpec, TrajectorySpec


def test_the_toy_wobbles_unless_a_rate_is_given():
    """Both rates default to `wobble`; if one is given, the center still rests."""
    spec = request_of_preset("toy", {"tilt": "80deg"})
    assert isinstance(spec, LossyTrajectorySpec)
    assert (spec.precession_rate, spec.roll_rate, spec.tilt) == ("wobble", "wobble", math.radians(80.0))
    preset = sweep.SweepSpec.preset("toy")
    for name in ("radius", "mass", "contour_friction", "air_viscosity", "air_density", "air_law", "duration"):
        assert getattr(spec, name) == getattr(preset, name)
    spec = request_of_preset("toy", {"inclination": "10deg", "scaled_precession_rate": 3})
    assert spec.precession_rate == pytest.approx(3.0 * math.sqrt(9.81 / 0.03755))
    assert spec.roll_rate == "wobble"


def test_a_preset_without_losses_is_as_any_other_motion():
    """It has the duration of a motion, not of an atlas; inputs only for atlases are dropped."""
    spec = request_of_preset("rolling", {"tilt": "1deg", "roll_rate": 2.3, "mass": "20g"})
    assert spec == TrajectorySpec.read(tilt="1deg", roll_rate=2.3, mass="20g")
    assert request_of_preset("rolling", {"tilt": "1deg", "roll_rate": 2.3, "duration": "1s"}).duration == 1.0


def test_scaled_rates_of_a_preset_are_those_of_another_disk():
    """The kick of a preset is scaled: as in a sweep, another radius changes the rate."""
    words = {"tilt": "10deg", "precession_rate": 20.0, "radius": "12mm"}
    expected = sweep.SweepSpec.preset("circling", radius="12mm").tilt_rate
    assert request_of_preset("circling", words).tilt_rate == expected


def test_losses_turn_a_preset_of_the_disk_into_one_that_stops():
    """The settings of the disk's preset apply to the lossy disk."""
    spec = request_of_preset("rolling", {"tilt": "1deg", "roll_rate": 3, "rolling_friction": "1mm"})
    assert isinstance(spec, LossyTrajectorySpec)
    assert (spec.roll_rate, spec.rolling_friction, spec.duration) == (3.0, 1e-3, 300.0)


def test_a_file_is_taken_like_a_preset(spec_file):
    """A TOML file works too, and its title is kept."""
    path = spec_file('title = "My disk"\nroll_rate = "1:3:5"\ntilt = "2deg"\ncriterion = "departure:2deg"\n')
    spec = request_of_preset(path, {"roll_rate": 2})
    assert (spec.title, spec.roll_rate) == ("My disk", 2.0)


def test_what_is_no_motion_is_refused():
    """An axis without a number, an unknown preset, and inputs of atlases are refused."""
    for name, words, facts in [
        ("toy", {}, ["preset toy has many values of tilt.", "Add one of each, as in tilt="]),
        ("rolling", {"tilt": "1deg"}, ["many values of roll_rate", "roll_rate="]),
        ("coin", {"roll_rate": 40}, ["many values of rolling_friction"]),
        ("toi", {"tilt": "1deg"}, ["There is no preset toi"]),
        ("toy", {"tilt": "80deg", "criterion": "aloft:2s"}, ["criterion", "word of eulerdisk run"]),
        ("toy", {"tilt": "80deg", "fall_tilt": "85deg"}, ["Write flat_tilt"]),
        ("toy", {"tilt": "1deg,2deg"}, ["one number"]),
    ]:
        with pytest.raises(RequestError) as caught:
            request_of_preset(name, words)
        assert all(fact in str(caught.value) for fact in facts), str(caught.value)
        assert caught.value.hint, (name, words, facts)


def test_a_list_of_starts_has_no_one_motion(spec_file):
    """Random starts are followed one by one from their atlas."""
    path = spec_file('roll_rate = "uniform:1:3"\nsamples = 5\ntilt = "2deg"\n')
    with refused("list"):
        request_of_preset(path, {"roll_rate": 2})


def test_a_word_with_a_value_or_a_name_of_one_is_no_preset():
    """So a forgotten value is not mistaken for a preset."""
    assert [is_preset(word) for word in ("toy", "my.toml", "roll_rate=3", "roll_rate", "")] == [
        True, True, False, False, False,
    ]  # fmt: skip
