"""What dry friction holds and how it releases, at one instant, compared with the laws themselves."""

import itertools
import math

import lossy_referee as referee
import numpy as np
import pytest
from lossy_follower import energy, energy_of, followed
from scipy.optimize import brentq

from kernels.jit import kernel
from kernels.lossy_disk import dry_friction, endings
from kernels.lossy_disk.loss_coefficients import Losses
from kernels.lossy_disk.rk4 import inertia


@kernel
def _breaking_away(S, C, v, turn, alpha, losses):
    return dry_friction.breaking_away(S, C, v, turn, inertia(alpha), losses)


@kernel
def _is_held(S, C, v, pivoted, alpha, losses):
    return dry_friction.is_held(S, C, v, pivoted, inertia(alpha), losses)


def losses(rolling=0.0, pivoting=0.0, contour=0.0):
    """Return the losses with these friction arms over the radius."""
    return Losses(contour, 0.0, rolling, pivoting, 0.0, 0.0)


def compliance(S, C, alpha):
    """Return the inverse inertia of roll and turning rate, with s = f C^2 + v S and o = C (v - f S)."""
    change = np.array([[C * C, S], [-C * S, C]])
    return np.linalg.inv(change.T @ np.diag([1.0 + alpha, 0.5 * alpha]) @ change)


def holding_tilt(arm, turning, alpha):
    """Return the tilt up to which rolling friction holds: S [1 + (1 + alpha/2) psidot^2 C] = arm."""
    return brentq(
        lambda tilt: math.sin(tilt) * (1 + (1 + alpha / 2) * turning**2 * math.cos(tilt)) - arm,
        0.0, 0.5, xtol=1e-16, rtol=1e-15,
    )  # fmt: skip


def test_rolling_friction_holds_up_to_the_holding_tilt():
    """Just below the closed form, the disk stands with constant bits; just above (1e-12) it is released."""
    for case in itertools.product([0.0, 0.7, -2.5], [0.5, 0.62, 1.0], [1e-6, 1e-3, 0.2]):
        turning, alpha, arm = case
        tilt = holding_tilt(arm, turning, alpha)
        for side in (-1.0, 1.0):
            start = referee.starts(
                tilt=side * tilt * (1 - 1e-12), precession_rate=turning, alpha=alpha, rolling_friction=arm
            )
            stood = followed(start[:, 0], horizon=1e4)
            assert stood.ending == (endings.HORIZON if turning else endings.REST), case
            assert stood.state[0] == math.sin(start[0, 0]), case
            assert stood.tilt_min == stood.tilt_max == stood.end_tilt, case
            assert stood.heading_turned == pytest.approx(turning * stood.end_time, rel=1e-15), case
            start[0] = side * tilt * (1 + 1e-12)
            assert followed(start[:, 0], horizon=1e-9).state[2] * side > 0.0, case


@pytest.mark.compiled
def test_a_disk_above_its_holding_tilt_falls():
    """However slowly it starts, the disk falls or, if it turns, nutates."""
    for case in itertools.product([(0.0, 1e-12), (0.7, 1e-3)], [1e-6, 1e-3, 0.2]):
        (turning, excess), arm = case
        tilt = holding_tilt(arm, turning, 0.5)
        start = referee.starts(tilt=tilt * (1 + excess), precession_rate=turning, rolling_friction=arm)
        fell = followed(start[:, 0], horizon=100.0)
        assert fell.ending in (endings.FLAT, endings.HORIZON, endings.LIFT_OFF), case
        assert fell.tilt_max > 1.5 * tilt, case
        assert energy(fell.state, 0.5) + fell.lost == pytest.approx(energy_of(start[:, 0]), abs=1e-7), case


def test_a_disk_that_stands_does_not_creep():
    """Pivoting friction stops a held disk's turning linearly, and then all is at rest in the bits of its tilt."""
    start = referee.starts(
        tilt=0.01, precession_rate=0.5, rolling_friction=0.02, pivoting_friction=1e-3, contour_friction=1e-3
    )
    found = followed(start[:, 0], horizon=1e5)
    S, C, alpha = math.sin(0.01), math.cos(0.01), 0.5
    stop = 0.5 * ((1 + alpha) * S * S + alpha / 2 * C * C) / 1e-3
    assert found.ending == endings.REST
    assert found.state[0] == S
    assert found.state[2:] == (0.0, 0.0, 0.0)
    assert found.end_time == pytest.approx(stop, rel=1e-14)
    assert found.pivoting_loss == pytest.approx(1e-3 * 0.5 * 0.5 * stop, rel=1e-14)
    assert found.heading_turned == pytest.approx(0.5 * 0.5 * stop, rel=1e-14)


def test_a_disk_breaks_away_along_its_own_acceleration(rng):
    """On release, the torque of rolling friction opposes the acceleration with its full arm, to 1e-12."""
    seen = 0
    for _ in range(2000):
        alpha, tilt, v = rng.uniform(0.3, 1.0), rng.uniform(-1.4, 1.4), rng.normal(0, 2)
        arms = losses(*(10 ** rng.uniform(-3, -0.3, 3)))
        S, C, turn = math.sin(tilt), math.cos(tilt), math.copysign(1.0, v)
        if _is_held(S, C, v, -arms.pivoting * turn, alpha, arms):
            continue
        tilting, rolling, normal = _breaking_away(S, C, v, turn, alpha, arms)
        if normal <= 0.0:
            # lifts off at once
            continue
        seen += 1
        assert normal == pytest.approx(1 - S * tilting, abs=1e-12)
        # the torques for these accelerations
        across = (1 + alpha / 2) * tilting - S * (1 + (1 + alpha / 2) * v * v * C)
        G = compliance(S, C, alpha)
        along = (rolling + G[0, 1] * arms.pivoting * normal * turn) / G[0, 0]
        speed = math.hypot(tilting, C * rolling)
        assert across == pytest.approx(-arms.rolling * normal * tilting / speed, abs=1e-12)
        rest = along + arms.rolling * normal * C * C * rolling / speed
        if rolling != 0.0:
            assert rest == pytest.approx(-arms.contour * normal * math.copysign(1.0, rolling), abs=1e-11)
        else:
            assert abs(rest) <= arms.contour * abs(normal) * (1 + 1e-12)
    assert seen > 300


def test_what_is_held_is_where_forces_suffice():
    """Friction holds exactly if torques within the disk-shaped limit and the arm can balance the pull."""
    rng = np.random.default_rng(1)
    shares = np.linspace(-1.0, 1.0, 20001)
    held = helped = 0
    for _ in range(1000):
        alpha, v = rng.uniform(0.3, 1.0), rng.normal(0, 0.5)
        tilt, arms = rng.uniform(-0.3, 0.3), losses(*(10 ** rng.uniform(-2, -0.3, 3)))
        S, C, turn = math.sin(tilt), math.cos(tilt), math.copysign(1.0, v)
        G = compliance(S, C, alpha)
        pull, push = S * (1 + (1 + alpha / 2) * v * v * C), G[0, 1] * arms.pivoting * turn / G[0, 0]
        torques = arms.rolling * shares
        within = np.hypot(torques, pull) <= arms.rolling
        found = (within & (abs(C * torques - push) <= arms.contour)).any()
        assert _is_held(S, C, v, -arms.pivoting * turn, alpha, arms) == found
        held += found
        helped += found and abs(push) > arms.contour
    assert 200 < held < 800
    assert helped > 20
