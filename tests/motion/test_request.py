import json
import math
import pickle
from dataclasses import FrozenInstanceError, asdict, replace

import pytest
from messages import refused

from kernels.bodies import trajectory
from kernels.disk import simd_stages
from sweep import RequestError, TrajectorySpec
from sweep.motion.tables import DISK_MOTION, MOTION_INPUTS, TIME, TRAJECTORY
from sweep.request.words import MOST_STEPS


def test_words_are_read_in_si():
    """Units are understood, bare numbers are SI, and omitted inputs have their defaults."""
    spec = TrajectorySpec.from_words(["tilt=10deg", "mass=20g", "duration=1min", "roll_rate=-4.6851"])
    assert spec.tilt == math.radians(10.0)
    assert spec.mass == pytest.approx(0.02, rel=1e-15)
    assert (spec.duration, spec.roll_rate, spec.radius) == (60.0, -4.6851, 0.5)


def test_a_rate_is_given_scaled_or_as_a_speed():
    """As in a sweep, scaling uses the disk of the same request; the request stores the rate."""
    assert TrajectorySpec.from_words(["radius=12mm", "speed=15cm/s"]).roll_rate == 12.5
    spec = TrajectorySpec.read(scaled_precession_rate=-1.5, scaled_tilt_rate=2, radius=2, gravity=8)
    assert (spec.precession_rate, spec.tilt_rate) == (-3.0, 4.0)


def test_every_word_is_a_field():
    """Tables and fields of a request have the same names, and its text contains them all."""
    spec = TrajectorySpec.read()
    assert set(asdict(spec)) == {*DISK_MOTION.inputs, *DISK_MOTION.words}
    assert json.loads(spec.canonical()) == asdict(spec)


def test_a_request_is_a_value():
    """It is immutable, equals another with the same values, and can be replaced, shown and pickled."""
    spec = TrajectorySpec.read(tilt="1deg", roll_rate=3)
    for name in ("tilt", "wobble"):
        with pytest.raises(FrozenInstanceError):
            setattr(spec, name, 0.5)
    heavier = replace(spec, mass=2.0)
    assert heavier == TrajectorySpec.read(tilt="1deg", roll_rate=3, mass="2kg") != spec
    assert len({spec, heavier, TrajectorySpec.read(tilt="1deg", roll_rate=3)}) == 2
    assert eval(repr(heavier)) == pickle.loads(pickle.dumps(heavier)) == heavier


def test_the_most_steps_are_those_of_the_kernels():
    """A request is refused where the kernels would give up."""
    assert MOST_STEPS == trajectory._MOST_STEPS == simd_stages.MOST_STEPS


def test_every_quantity_is_complete():
    """Each has a long name, units or flags, a label, and only ASCII in its attributes."""
    for quantity in [TIME, *TRAJECTORY.values(), *MOTION_INPUTS.values()]:
        assert quantity.long_name, quantity
        assert quantity.plot_label, quantity
        assert ("units" in quantity.attributes()) != ("flag_values" in quantity.attributes()), quantity
        assert all(str(value).isascii() for value in quantity.attributes().values()), quantity
        assert quantity.tolerance.reason, quantity


def test_a_refusal_says_what_is_allowed_what_was_given_and_what_to_do():
    """An impossible request is refused in one line with the input, the rule, the value and the remedy."""
    for words, facts in [
        (["tilt=90deg"], ["tilt", "90 deg", "|tilt| < 90 deg"]),
        (["tilt=86deg"], ["fallen", "|tilt| must be below fall_tilt", "86deg", "85deg", "larger fall_tilt"]),
        (["duration=-1s"], ["-1 s", "duration > 0"]),
        (["duration=0"], ["duration > 0"]),
        (["mass=0"], ["mass > 0"]),
        (["friction=-0.1"], ["friction > 0"]),
        (["interval=-1"], ["interval > 0"]),
        (["roll_rate=1,2"], ["roll_rate=1,2", "one number", "axis"]),
        (["roll_rate=1:2:3"], ["roll_rate=1:2:3", "one number", "axis"]),
        (["roll_rate=nan"], ["roll_rate=nan", "finite"]),
        (["roll_rate=fast"], ["roll_rate=fast", "a number", "steady"]),
        (["mass=3m"], ["mass=3m", "unit 'm'", "kg, g, pound"]),
        (["rollrate=3"], ["rollrate", "friction, duration, interval", "Did you mean roll_rate?"]),
        (["criterion=departure:5deg"], ["criterion", "word of eulerdisk run"]),
        (["model=bead"], ["model", "eulerdisk simulate mine.py", "Leave it out"]),
        (["roll_rate=3", "roll_rate=4"], ["roll_rate=3", "roll_rate=4"]),
        (["roll_rate"], ["roll_rate", "NAME=VALUE"]),
        (["roll_rate=steady", "tilt=10deg"], ["roll_rate=steady", "other than 0", "precession_rate=0.5"]),
        (
            ["precession_rate=steady"],
            ["steady-slow is the slower one", "=steady-slow or precession_rate=steady-fast"],
        ),
        (["precession_rate=steady-slow", "roll_rate=steady"], ["both rates open"]),
        (["speed=1", "roll_rate=3"], ["roll_rate is given twice", "speed=1 and roll_rate=3"]),
        (["speed=1,2"], ["speed must be one number", "axis"]),
        (["speed=1", "radius=1,2"], ["radius must be one number", "axis"]),
        (["spead=1"], ["Did you mean speed?"]),
        (["method=rk4"], ["method", "eulerdisk run"]),
        (["interval=1e-9"], ["too many samples", "7200000", "interval=1e-9", "longer interval"]),
        (["step=1e-9"], ["too many steps", "100000000", "step=1e-9", "longer step"]),
        (["title=a\nb"], ["title", "one line", r"a\nb"]),
    ]:
        with pytest.raises(RequestError) as refusal:
            TrajectorySpec.from_words(words)
        text = str(refusal.value)
        assert refusal.value.hint, (words, facts)
        assert "\n" not in text, (words, facts)
        for each in facts:
            assert each in text, (words, facts)


def test_a_wobble_needs_both_words():
    """The model's hint is kept where it has no range: a word is missing, not a number."""
    with refused("roll_rate=0.0", "roll_rate=wobble"):
        TrajectorySpec.read(tilt="80deg", precession_rate="wobble")
    with refused("precession_rate=0.5"):
        TrajectorySpec.read(tilt="20deg", roll_rate="steady")
