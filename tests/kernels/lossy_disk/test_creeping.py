"""A turning disk that rolling friction only just does not hold: it creeps away, and its friction is stiff across."""

import math

import lossy_referee as referee
import lossy_runner
import numpy as np
import pytest
from lossy_follower import followed
from scipy.optimize import brentq

from kernels.lossy_disk.dry_friction import is_held
from kernels.lossy_disk.endings import FLAT
from kernels.lossy_disk.loss_laws import Losses
from kernels.lossy_disk.rk4 import inertia

pytestmark = pytest.mark.compiled


def brink(turning, alpha, rolling, pivoting=0.0, contour=0.0, damping=0.0):
    """Tilt up to which friction holds a disk that turns with a scaled rate, to the last bit."""
    losses, of_disk = Losses(contour, damping, rolling, pivoting, 0.0, 0.0), inertia(alpha)
    pivoted, low, high = -math.copysign(pivoting, turning), 0.0, 0.5
    while low < 0.5 * (low + high) < high:
        tilt = 0.5 * (low + high)
        held = is_held(math.sin(tilt), math.cos(tilt), turning, pivoted, of_disk, losses)
        low, high = (tilt, high) if held else (low, tilt)
    return low


def growth(tilt, turning, alpha, arm):
    """Rate with which the tilt leaves its holding tilt: no roll rate to first order, as if that were held.

    Then the angular momentum about the vertical stays, and (1 + alpha/2) w' = S (1 + (1 + alpha/2) P^2 C) - arm n with
    the normal force n = 1 - S w'.
    """
    S, C, own = math.sin(tilt), math.cos(tilt), 1.0 + 0.5 * alpha
    slowing = (2.0 + alpha) * S * C / ((1.0 + alpha) * S * S + 0.5 * alpha * C * C)
    pull = C + own * turning**2 * (C * C - S * S - 2.0 * S * C * slowing)
    return math.sqrt(pull / (own - arm * S))


@pytest.mark.parametrize(("arm", "turning", "alpha"), [(0.2, 0.7, 0.5), (0.2, -2.5, 0.5), (0.05, 0.7, 1.0)])
def test_a_disk_leaves_the_holding_tilt_exponentially(arm, turning, alpha):
    """A tenth of the excess takes ln(10) of its growth time longer, in no more steps, by ten decades of it."""
    tilt = brink(turning, alpha, arm)
    assert tilt == pytest.approx(
        brentq(lambda x: math.sin(x) * (1 + (1 + alpha / 2) * turning**2 * math.cos(x)) - arm, 0, 0.5),
        rel=1e-9,
    )
    excess = 10.0 ** -np.arange(5, 13)
    given = referee.starts(
        tilt=tilt * (1 + excess), precession_rate=turning, rolling_friction=arm, alpha=alpha
    )
    found = lossy_runner.run(given, duration=100.0)
    assert (found.ending == FLAT).all()
    assert found.steps.max() < 40_000
    later, expected = np.diff(found.end_time), math.log(10.0) / growth(tilt, turning, alpha, arm)
    # the excess is known to the rounding of the tilt
    np.testing.assert_allclose(later[:5], expected, rtol=1e-4)


@pytest.mark.slow_lane
def test_what_creeps_is_where_the_referee_has_it(rng, count):
    """Fresh cells above what friction holds, alone and with other laws, which may hold them again.

    Switches are not counted: the referee counts those of its own noise where a disk hardly creeps, and two that come
    together at a rest as one.
    """
    for _ in range(count(4, 12)):
        alpha, rolling, turning = rng.uniform(0.1, 1), 10.0 ** rng.uniform(-3, -0.7), rng.normal(0, 1.5)
        others = 10.0 ** rng.uniform(-5, -3, 3) * (rng.random(3) < (0.6, 0.3, 0.3)) * (rolling / 0.01, 1, 1)
        pivoting, contour, damping = map(float, others)
        tilt = brink(turning, alpha, rolling, pivoting, contour, damping) * (1 + 10.0 ** rng.uniform(-4, -3))
        given = referee.starts(
            tilt=tilt, precession_rate=turning, rolling_friction=rolling, pivoting_friction=pivoting,
            contour_friction=contour, contour_damping=damping, alpha=alpha,
        )  # fmt: skip
        true = referee.run(given, duration=20.0, rtol=1e-13)
        found = followed(given[:, 0], horizon=20.0, relative_step=0.01)
        start = dict(
            zip(("alpha", "rolling", "turning", "tilt"), (alpha, rolling, turning, tilt), strict=True)
        )
        assert found.ending == true.ending[0], (start, others)
        for name in ("end_time", "end_tilt", "heading_turned", "rolling_loss", "pivoting_loss"):
            off = abs(getattr(found, name) - getattr(true, name)[0])
            assert off <= 1e-6 * max(1.0, true.end_time[0]), (name, off, start, others)


@pytest.mark.slow_lane
def test_a_creeping_disk_that_its_pivoting_friction_stops_is_held_again():
    """It comes to rest within one step of the motion, wherever that step ends; contour friction is there too."""
    words = {"rolling_friction": 0.1, "pivoting_friction": 4.6e-3, "contour_friction": 1.8e-4, "alpha": 0.13}
    tilt = brink(1.0, 0.13, 0.1, 4.6e-3, 1.8e-4) * (1 + 4.8e-5)
    given = referee.starts(tilt=tilt, precession_rate=1.0, **words)
    true = referee.run(given, duration=30.0, rtol=1e-13)
    for relative_step in (0.03, 0.01, 0.003):
        found = followed(given[:, 0], horizon=30.0, relative_step=relative_step)
        assert (found.ending, found.switches) == (true.ending[0], true.switches[0])
        assert found.end_tilt == pytest.approx(true.end_tilt[0], abs=1e-12)
        assert found.end_time == pytest.approx(true.end_time[0], rel=1e-9)
