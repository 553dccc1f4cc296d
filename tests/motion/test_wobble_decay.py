"""Power laws of a wobble near flat: exponents, powers, and the remaining time."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

import sweep
from sweep.model.lossy_disk import theory
from sweep.motion.theory import flat_time, wobble_losses, wobbles

pytestmark = pytest.mark.compiled

AIR = {"mass": 0.4, "air_viscosity": 1.8e-5, "air_density": 1.2}

#: Law -> its inputs, and the exponent of the inclination from the literature.
LAWS = {
    "contour": ({"contour_friction": "1um"}, Fraction(2, 3)),
    "viscous": ({"contour_damping": 1e-9, "mass": 0.4}, Fraction(1, 2)),
    "moffatt": ({"air_law": "moffatt", **AIR, "air_density": 0.0}, Fraction(1, 3)),
    "bildsten": ({"air_law": "bildsten", **AIR}, Fraction(4, 9)),
    "rolling": ({"rolling_friction": "20um"}, Fraction(2)),
}


def motion_of(law, **words):
    """Return the wobble of a toy with one law, from a small inclination."""
    start = {"inclination": 0.03, "precession_rate": "wobble", "roll_rate": "wobble", "radius": 0.0375}
    return sweep.simulate(**start, **LAWS[law][0], **words)


def test_the_power_is_that_of_the_motion():
    """The integrated loss of each law matches its closed form at the inclination, to leading order."""
    for law, alpha in itertools.product(LAWS, [0.5, 0.9]):
        motion = motion_of(law, alpha=alpha, duration=0.5)
        (loss,) = wobble_losses(motion)
        assert loss.exponent == LAWS[law][1], (law, alpha)
        weight, unit = float(motion["mass"]) * 9.81 * 0.0375, math.sqrt(0.0375 / 9.81)
        taken = np.diff(motion[loss.name].values[[0, -1]])[0] / weight
        powers = loss.coefficient * motion["inclination"].values ** -float(loss.power)
        expected = np.trapezoid(powers, motion["elapsed_time"].values) / unit
        assert taken == pytest.approx(expected, rel=2e-3), (law, alpha)


def test_the_exponent_is_that_of_the_motion():
    """The exponent is the slope of log a over log(t_f - t) between two inclinations of the motion."""
    for law in LAWS:
        motion = motion_of(law, duration=3000.0)
        left = flat_time(motion) - motion["elapsed_time"].values
        inclination = motion["inclination"].values
        first, last = (int(np.argmax(inclination < each)) for each in (0.02, 0.006))
        slope = np.log(inclination[first] / inclination[last]) / np.log(left[first] / left[last])
        assert slope == pytest.approx(float(LAWS[law][1]), abs=0.01), law


def test_the_time_that_is_left_is_that_until_a_smaller_inclination():
    """A disk followed to 0.001 deg is flat when the motion to 0.1 deg predicts it."""
    words = {
        "inclination": 0.05,
        "precession_rate": "wobble",
        "roll_rate": "wobble",
        "radius": 0.0375,
        "mass": 0.4,
    }
    losses = {"contour_friction": "0.5um", "rolling_friction": "1um"}
    short, long = (sweep.simulate(**words, **losses, flat_tilt=f"{tilt}deg") for tilt in (89.9, 89.99))
    end = float(short["end_time"])
    assert flat_time(short) - end == pytest.approx(flat_time(long) - end, rel=0.02)
    assert end < float(long["end_time"]) < flat_time(short)


def test_the_model_says_the_same():
    """The theory of atlases gives the same time between two tilts."""
    for law in LAWS:
        motion = motion_of(law, duration=0.1)
        (loss,) = wobble_losses(motion)
        spec = sweep.SweepSpec(
            inclination=0.03, precession_rate="wobble", roll_rate="wobble", radius=0.0375, **LAWS[law][0]
        )
        start = {name: float(motion[name]) for name in ("alpha", "radius", "gravity", "mass", *spec.model.parameters)
                 if name in motion.coords} | {"tilt": math.pi / 2 - 0.03}  # fmt: skip
        whole = 1.5 / loss.coefficient / (1.0 + float(loss.power))
        ends = [each ** (1.0 + float(loss.power)) for each in (0.03, math.pi / 2 - spec.flat_tilt)]
        expected = math.sqrt(0.0375 / 9.81) * whole * (ends[0] - ends[1])
        assert theory.wobble_time(spec, start) == pytest.approx(expected, rel=1e-9), law


def test_what_falls_over_is_no_wobble():
    """A disk without spin falls flat; it has no power law, and its flat time is its end time."""
    motion = sweep.simulate(tilt="60deg", contour_friction="10um", radius=0.0375)
    assert not wobbles(motion)
    assert flat_time(motion) == float(motion["end_time"])
    assert wobbles(motion_of("contour"))
