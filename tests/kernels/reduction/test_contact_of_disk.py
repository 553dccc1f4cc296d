"""Extremes of the contact forces of the thin disk, compared with dense integrations in time with Lagrange's forces."""

import math

import numpy as np
import pytest
import referee
from thin_disk import contact_forces

from kernels.bodies.arrays import (
    CONTACT,
    LIFTS_OFF,
    NO_MOTION,
    PRESSES,
    UNRESOLVED_FORCES,
)
from kernels.disk import endings
from kernels.disk import equations as disk
from kernels.disk.steady import steady_roll_rate
from sweep.engine.compute import compute
from sweep.request.spec import SweepSpec

pytestmark = pytest.mark.compiled

SPEC = SweepSpec().replace(contact="yes", duration=3600.0)
NAMES = ("tilt", "tilt_rate", "precession_rate", "roll_rate", "alpha", "radius", "gravity")
RATES = NAMES[1:4]


def random_starts(count, rng):
    """Return starts with rates over six decades, a tenth of them zero."""
    radius, gravity = 10.0 ** rng.uniform(-3.0, 2.0, count), 10.0 ** rng.uniform(-1.0, 1.5, count)
    scale = np.sqrt(gravity / radius)

    def rate():
        found = rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-3.0, 3.0, count) * scale
        return np.where(rng.random(count) < 0.1, 0.0, found)

    tilt = np.where(
        rng.random(count) < 0.2, 10.0 ** rng.uniform(-8.0, -1.0, count), rng.uniform(-1.45, 1.45, count)
    )
    values = (tilt, rate(), rate(), rate(), rng.uniform(0.02, 1.0, count), radius, gravity)
    return dict(zip(NAMES, values, strict=True))


def start(**changed):
    """Return the columns of one start."""
    disk_of_the_report = {
        "tilt": 0.0,
        **dict.fromkeys(RATES, 0.0),
        "alpha": 0.5,
        "radius": 0.5,
        "gravity": 9.81,
    }
    return {name: np.array([value]) for name, value in {**disk_of_the_report, **changed}.items()}


def off(found, true):
    """Return the error of a value over 1 + |true value|."""
    return abs(found - true) / (1.0 + abs(true))


def check(found, given, duration=3600.0):
    """Check the forces of a cell against the referee and return its state."""
    normal, needed = referee.contact([float(given[name]) for name in NAMES], duration)
    state = int(found["contact_state"])
    if state == UNRESOLVED_FORCES:
        return state
    assert off(float(found["least_normal_force"]), normal) < 1e-6, given
    if state == PRESSES:
        assert off(float(found["friction_needed"]), needed) < 1e-6, given
    else:
        assert (state, normal > 0.0) == (LIFTS_OFF, False), given
        assert np.isnan(found["friction_needed"]), given
    return state


def test_random_motions_have_the_forces_of_a_dense_integration():
    """Over six decades of rates, the extremes agree with the integration within 1e-6 (1 + x), and all are known."""
    given = random_starts(40, np.random.default_rng(14))
    found = compute(SPEC, given)
    states = []
    for cell in np.flatnonzero(np.isin(found["ending"], (endings.BOUNDED, endings.FELL))):
        one = {name: values[cell] for name, values in found.items()}
        states.append(check(one, {name: values[cell] for name, values in given.items()}))
    assert states.count(PRESSES) > 5
    assert states.count(LIFTS_OFF) > 5
    assert UNRESOLVED_FORCES not in states


def test_no_extreme_is_missed():
    """A last step of the size of rounding and a peak near a vanishing normal force do not hide an extreme."""
    for case in [
        # the way to the far turning point is a whole number of equal steps except for 1e-17 rad
        ({"roll_rate": 3.2875, "tilt": 0.06196480112802008}, 300.0),
        ({"roll_rate": 3.1875, "tilt": 0.07675099334714733}, 300.0),
        # the normal force almost vanishes: a narrow peak of the coefficient
        (
            {
                "tilt": 0.316184,
                "precession_rate": -0.10242634871029623,
                "roll_rate": -0.2045392655064548,
                "alpha": 0.03,
                "radius": 150.0,
                "gravity": 1.62,
            },
            2886.0,
        ),
        # a fall that starts in the other direction, and a kick into either well
        ({"tilt": 0.8, "tilt_rate": -1.5, "precession_rate": 0.3}, 300.0),
        ({"tilt_rate": 0.01, "roll_rate": 2.0}, 300.0),
    ]:
        changed, duration = case
        given = start(**changed)
        found = {name: values[0] for name, values in compute(SPEC.replace(duration=duration), given).items()}
        assert check(found, {name: values[0] for name, values in given.items()}, duration) == PRESSES, case


def test_images_have_the_same_bits():
    """Both mirror images of a motion and its reversal in time have the same forces to the bit."""
    given = random_starts(1500, np.random.default_rng(3))
    found = compute(SPEC, given)
    images = [
        ("tilt", "tilt_rate", "roll_rate"),
        ("tilt", "tilt_rate", "precession_rate"),
        ("precession_rate", "roll_rate"),
        # a fall reversed in time is another motion
        ("tilt_rate",),
    ]
    for turned in images:
        other = compute(SPEC, {name: -values if name in turned else values for name, values in given.items()})
        alike = np.ones(1500, bool)
        if turned == ("tilt_rate",):
            alike = (found["ending"] == endings.BOUNDED) & (other["ending"] == endings.BOUNDED)
            assert alike.sum() > 500
        for name in (*CONTACT, "contact_state"):
            assert found[name][alike].tobytes() == other[name][alike].tobytes(), (turned, name)


def test_a_steady_motion_has_the_forces_of_its_start():
    """A disk that circles steadily keeps its tilt, and its forces."""
    for tilt, rate in ((0.3, 1.5), (-0.7, 4.0), (1.2, -3.0)):
        roll = float(steady_roll_rate(tilt, rate, 0.5, 0.5, 9.81))
        found = compute(SPEC, start(tilt=tilt, precession_rate=rate, roll_rate=roll))
        state = disk.scaled_state(tilt, 0.0, rate, roll, math.sqrt(0.5 / 9.81))
        force, across, along = contact_forces(state, 0.5)
        assert found["contact_state"] == PRESSES
        assert found["least_normal_force"] == pytest.approx(force, rel=1e-9)
        assert found["friction_needed"] == pytest.approx(math.hypot(across, along) / force, rel=1e-9)


def test_the_forces_are_those_of_the_whole_motion():
    """They do not depend on the duration, even if the time is over before the disk turns."""
    given = start(tilt=0.1, roll_rate=3.0)
    short, long = (compute(SPEC.replace(duration=duration), given) for duration in (0.05, 300.0))
    assert (short["ending"], long["ending"]) == (endings.HORIZON, endings.BOUNDED)
    check(
        {name: values[0] for name, values in long.items()},
        {name: values[0] for name, values in given.items()},
    )
    for name in (*CONTACT, "contact_state"):
        assert short[name].tobytes() == long[name].tobytes()


def test_an_impossible_start_has_no_forces():
    """Without a motion the forces are missing."""
    found = compute(SPEC, start(tilt=np.nan))
    assert (found["ending"], found["contact_state"]) == (endings.INVALID, NO_MOTION)
    assert np.isnan([found[name] for name in CONTACT]).all()


def test_a_normal_force_of_rounding_gives_no_coefficient():
    """Towards lift-off the coefficient grows as the force falls; if rounding decides, it is missing."""
    low, high, seen = 0.0, 10.0, set()
    for _ in range(6):
        rates = np.linspace(low, high, 1000)
        given = {name: np.full(1000, values[0]) for name, values in start(tilt=0.7).items()}
        found = compute(SPEC, {**given, "tilt_rate": rates})
        normal, needed, state = (found[name] for name in (*CONTACT, "contact_state"))
        seen |= set(state)
        assert (np.isfinite(needed) == (state == PRESSES)).all()
        lifts = int(np.argmax(normal <= 0.0))
        low, high = rates[lifts - 1], rates[lifts]
    assert seen == {PRESSES, LIFTS_OFF, UNRESOLVED_FORCES}
    assert abs(normal[lifts]) < 1e-12
    assert state[lifts] == UNRESOLVED_FORCES
