"""When rolling becomes impossible, compared with the closed form of a disk that falls in place."""

import math

import numpy as np
import pytest
from messages import assert_facts, refused
from scipy.integrate import quad
from scipy.optimize import brentq

import sweep
from sweep.motion.contact import rolling_limit

pytestmark = pytest.mark.compiled

TILT, RADIUS, GRAVITY = math.radians(1.0), 0.012, 9.81


def fallen(tilt, alpha):
    """Return (tilt rate squared, tilt acceleration, normal force, horizontal force) after release at `TILT`.

    The disk turns about its lowest point: Steiner's moment of inertia and Newton's law for the center; forces
    are in units of the weight.
    """
    unit = GRAVITY / RADIUS / (1.0 + 0.5 * alpha)
    squared, acceleration = 2.0 * unit * (math.cos(TILT) - math.cos(tilt)), unit * math.sin(tilt)
    down = acceleration * math.sin(tilt) + squared * math.cos(tilt)
    sideways = acceleration * math.cos(tilt) - squared * math.sin(tilt)
    return squared, acceleration, 1.0 - RADIUS / GRAVITY * down, RADIUS / GRAVITY * sideways


def time_until(tilt, alpha):
    """Return the fall time from `TILT` by quadrature; substituting a square root removes the singularity."""
    return quad(lambda u: 2.0 * u / math.sqrt(fallen(TILT + u * u, alpha)[0]), 0.0, math.sqrt(tilt - TILT))[0]


@pytest.mark.parametrize(("alpha", "friction"), [(0.5, 0.3), (0.5, 0.5), (0.5, 5.0), (1.0, 0.5), (0.1, 0.4)])
@pytest.mark.parametrize("interval", ["auto", 0.07])
def test_a_disk_that_falls_in_its_place(alpha, friction, interval):
    """It slips and lifts off when Newton's law says, to 1e-6 of the time, for any sampling interval."""
    # The grid is fine enough to have the first root of the excess between two points.
    tilts = np.linspace(TILT, math.radians(85.0), 20001)

    def first(excess):
        beyond = int(np.argmax([excess(each) > 0.0 for each in tilts]))
        if beyond == 0:
            return None
        return time_until(brentq(excess, tilts[beyond - 1], tilts[beyond], xtol=1e-14), alpha)

    def over_friction(tilt):
        _, _, normal, horizontal = fallen(tilt, alpha)
        return abs(horizontal) - friction * normal

    motion = sweep.simulate(
        tilt=TILT, radius=RADIUS, alpha=alpha, friction=friction, duration=1.0, interval=interval
    )
    limit = rolling_limit(motion)
    assert limit.slips == pytest.approx(first(over_friction), rel=1e-6)
    # A falling hoop does not lift off.
    lifts_off = first(lambda tilt: -fallen(tilt, alpha)[2])
    assert (lifts_off is None) == (alpha == 1.0)
    assert limit.lifts_off == (lifts_off and pytest.approx(lifts_off, rel=1e-6))
    assert limit.time == limit.slips
    assert (limit.needed == math.inf) == (alpha != 1.0)
    slips = f"slips at {limit.slips:.6g} s (rolling then needs more than friction={friction:g})"
    lifts = f" and lifts off at {limit.lifts_off:.6g} s (the normal force vanishes)" if alpha != 1.0 else ""
    assert limit.words(0.0, friction) == slips + lifts


def test_a_motion_that_rolls_all_the_time():
    """It never slips and reports the friction it needs; slightly less is not enough."""
    words = {"tilt_rate": 0.01, "roll_rate": 2.0}
    limit = rolling_limit(sweep.simulate(**words))
    assert (limit.slips, limit.lifts_off, limit.time, limit.words(0.0, 0.5)) == (None, None, math.inf, "")
    assert rolling_limit(sweep.simulate(**words, friction=0.999 * limit.needed)).slips is not None


def test_a_start_that_slips_and_a_stretch_that_does():
    """A motion that needs too much friction from the first sample slips from the start; so does a part."""
    words = {"radius": 0.04, "tilt": "80deg", "precession_rate": 30.0, "roll_rate": "steady", "duration": 1.0}
    limit = rolling_limit(sweep.simulate(**words))
    assert limit.slips == 0.0
    # For steady circling the horizontal force is m times the center's radius times the squared precession
    # rate.
    motion = sweep.simulate(**words)
    turn = abs(0.04 * float(motion["roll_rate"][0]) / 30.0) - 0.04 * math.sin(math.radians(80.0))
    assert limit.needed == pytest.approx(abs(turn) * 30.0**2 / 9.81, rel=1e-6)
    assert_facts(limit.words(0.0, 0.5), "slips", "start")
    fall = sweep.simulate(tilt="1deg", radius=RADIUS, duration=1.0)
    late = fall.isel(elapsed_time=slice(950, None))
    start = float(late["elapsed_time"][0])
    assert rolling_limit(late).time == start
    assert_facts(rolling_limit(late).words(start, 0.5), "lifts off", "start", "normal force")
    early = fall.isel(elapsed_time=slice(0, 500))
    assert rolling_limit(early).time == math.inf


def test_what_is_no_motion_has_no_limit():
    """Other datasets are refused."""
    with refused("motion"):
        rolling_limit(sweep.run(sweep.SweepSpec(roll_rate="2:4:3")))
