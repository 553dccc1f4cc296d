import json
import math
from dataclasses import asdict

import pytest

from sweep import RequestError, TrajectorySpec
from sweep.motion.quantities import MOTION_INPUTS, MOTION_WORDS, TIME, TRAJECTORY


def test_words_are_read_in_si():
    """Units are understood, bare numbers are SI, and what is not given has its default."""
    spec = TrajectorySpec.from_words(["tilt=10deg", "mass=20g", "duration=1min", "roll_rate=-4.6851"])
    assert spec.tilt == math.radians(10.0)
    assert spec.mass == pytest.approx(0.02, rel=1e-15)
    assert (spec.duration, spec.roll_rate, spec.radius, spec.method) == (60.0, -4.6851, 0.5, "rk4")


def test_every_word_is_a_field():
    """The tables and the fields of a request name the same words, and its text holds them all."""
    spec = TrajectorySpec.read()
    assert set(asdict(spec)) == {*MOTION_INPUTS, *MOTION_WORDS}
    assert json.loads(spec.canonical()) == asdict(spec)


@pytest.mark.parametrize(
    "quantity", [TIME, *TRAJECTORY.values(), *MOTION_INPUTS.values()], ids=lambda each: each.name
)
def test_every_quantity_is_complete(quantity):
    """Long name, units or flags, a label, and nothing outside ASCII in its attributes."""
    assert quantity.long_name
    assert quantity.plot_label
    assert ("units" in quantity.attributes()) != ("flag_values" in quantity.attributes())
    assert all(str(value).isascii() for value in quantity.attributes().values())
    assert quantity.tolerance.reason


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["tilt=90deg"], r"90 deg is not possible.*\|tilt\| < 90 deg"),
        (["tilt=86deg"], r"fallen before it starts.*larger fall_tilt"),
        (["duration=-1s"], r"-1 s is not possible.*duration > 0"),
        (["duration=0"], r"duration > 0"),
        (["mass=0"], r"mass > 0"),
        (["friction=-0.1"], r"friction > 0"),
        (["interval=-1"], r"interval > 0"),
        (["roll_rate=1,2"], r"this cannot be an axis.*one number"),
        (["roll_rate=1:2:3"], r"this cannot be an axis"),
        (["roll_rate=nan"], r"not a finite number"),
        (["roll_rate=fast"], r"not a value"),
        (["mass=3m"], r"the unit 'm' does not fit.*kg, g, pound"),
        (["rollrate=3"], r"unknown word.*did you mean roll_rate\?"),
        (["criterion=departure:5deg"], r"unknown word"),
        (["roll_rate=3", "roll_rate=4"], r"given twice"),
        (["roll_rate"], r"not a NAME=VALUE word"),
        (["roll_rate=steady", "tilt=10deg"], r"no roll rate keeps.*precession_rate=0\.5"),
        (["method=euler"], r"unknown method.*rk4 or dop853"),
        (["interval=1e-9"], r"too many samples"),
        (["step=1e-9"], r"too many steps"),
        (["title=a\nb"], r"not a title"),
    ],
)
def test_refusals_say_what_to_do(words, message):
    """What cannot be carried out is refused with the rule, what was given, and what to do."""
    with pytest.raises(RequestError, match=message):
        TrajectorySpec.from_words(words)
