import itertools
import math

import numpy as np
import pytest
import referee
from hypothesis import assume, given
from hypothesis import strategies as st

from kernels.disk import steady

G = 9.81
R = 0.5
TILTS = st.floats(0.001, 1.4) | st.floats(-1.4, -0.001)
RATES = st.floats(0.05, 20.0) | st.floats(-20.0, -0.05)
MASSES = (st.floats(0.01, 1.0), st.floats(0.01, 10.0), st.floats(0.1, 30.0))


def test_the_circling_disk_of_the_report():
    """At 10 deg and 0.5 rad/s the roll rate is -4.6851 rad/s."""
    assert round(steady.steady_roll_rate(math.radians(10.0), 0.5, 0.5, R, G), 4) == -4.6851


@given(TILTS, RATES, *MASSES)
def test_the_steady_roll_rate_keeps_the_tilt(tilt, precession, alpha, radius, gravity):
    """A disk started at the steady rates has no acceleration."""
    roll = steady.steady_roll_rate(tilt, precession, alpha, radius, gravity)
    found = referee.accelerations((tilt, 0.0, precession, roll), alpha, radius, gravity)
    terms = gravity / radius + precession**2 + abs(precession * roll)
    assert found == pytest.approx((0.0, 0.0, 0.0), abs=1e-14 * terms)


def test_no_roll_rate_holds_a_tilt_without_precession():
    """Without precession the result is not finite, also in an array with valid cells."""
    with np.errstate(divide="ignore"):
        found = steady.steady_roll_rate(np.array([0.1, 0.1]), np.array([0.0, 1.0]), 0.5, R, G)
    assert list(np.isfinite(found)) == [False, True]


@given(TILTS, RATES, *MASSES)
def test_k_is_the_square_of_the_small_oscillations(tilt, precession, alpha, radius, gravity):
    """The eigenvalues of the linearized equations of motion are 0, 0 and the two roots of -k."""
    roll = steady.steady_roll_rate(tilt, precession, alpha, radius, gravity)
    state = np.array([tilt, 0.0, precession, roll])
    assume(abs(roll) < 1e3)

    def flow(state):
        tilting, turning, rolling = referee.accelerations(state, alpha, radius, gravity)
        return np.array([state[1], tilting, turning, rolling])

    step = 1e-5 * np.diag([math.cos(tilt), 1.0, 1.0 + abs(precession), 1.0 + abs(roll)])
    jacobian = np.stack([(flow(state + h) - flow(state - h)) / (2.0 * h.sum()) for h in step], axis=1)
    # the squares of the eigenvalues add up to the trace of the square
    k = steady.stability_coefficient(tilt, precession, roll, alpha, radius, gravity)
    terms = gravity / radius + precession**2 + abs(precession * roll) + roll**2
    assert k == pytest.approx(-0.5 * np.trace(jacobian @ jacobian), abs=1e-8 * terms / math.cos(tilt) ** 2)


def test_k_tells_whether_a_kick_grows():
    """At 10 deg the sign of k decides the stability of circling, and sqrt(k) is the nutation frequency."""
    for case in itertools.product([1.0, -1.0], [(4.0, True), (2.5, False)]):
        sign, (precession, stable) = case
        tilt = math.radians(10.0) * sign
        roll = steady.steady_roll_rate(tilt, precession, 0.5, R, G)
        k = steady.stability_coefficient(tilt, precession, roll, 0.5, R, G)
        kicked = referee.motion((tilt, 1e-6, precession, roll, 0.5, R, G), 5.0)
        reach = np.max(np.abs(kicked.states[0] - tilt))
        assert (k > 0.0) == stable == (reach < 1e-5), case
        if stable:
            assert np.pi / np.diff(kicked.turn_times)[0] == pytest.approx(math.sqrt(k), rel=1e-4), case


def test_the_critical_rates_of_disk_and_hoop():
    """The squared critical rates are g/3R and 4g/5R for the disk, g/4R and 2g/3R for the hoop."""
    for case in [(0.5, 1 / 3, 4 / 5), (1.0, 1 / 4, 2 / 3)]:
        alpha, roll, spin = case
        assert steady.critical_roll_rate_squared(alpha, R, G) == pytest.approx(roll * G / R, rel=1e-15), case
        assert steady.critical_precession_rate_squared(alpha, R, G) == pytest.approx(
            spin * G / R, rel=1e-15
        ), case
        assert steady.fall_rate_squared(alpha, R, G) == pytest.approx(
            2.0 * G / ((2.0 + alpha) * R), rel=1e-15
        ), case


@given(*MASSES)
def test_upright_k_vanishes_at_the_critical_rates(alpha, radius, gravity):
    """Upright, k vanishes at the critical rates, and at rest it is -(fall rate)^2."""
    scale = gravity / radius
    roll = math.sqrt(steady.critical_roll_rate_squared(alpha, radius, gravity))
    spin = math.sqrt(steady.critical_precession_rate_squared(alpha, radius, gravity))
    for precession_rate, roll_rate in ((0.0, roll), (spin, 0.0)):
        k = steady.stability_coefficient(0.0, precession_rate, roll_rate, alpha, radius, gravity)
        assert abs(k) <= 1e-14 * scale
    falling = steady.stability_coefficient(0.0, 0.0, 0.0, alpha, radius, gravity)
    assert falling == pytest.approx(-steady.fall_rate_squared(alpha, radius, gravity), rel=1e-14)


@given(TILTS, st.floats(-1.0, 3.0), *MASSES)
def test_marginal_rates_have_the_wanted_coefficient(tilt, share, alpha, radius, gravity):
    """Each of the two rates belongs to a steady motion with the requested k, and slow < fast."""
    wanted = share * gravity / radius
    slow, fast = steady.marginal_precession_rates(tilt, wanted, alpha, radius, gravity)
    assume(np.isfinite(slow))
    # if the two coincide (the dome's top), k is flat in the rate and the rate has half the digits
    assert slow <= fast
    for precession in (slow, fast):
        roll = steady.steady_roll_rate(tilt, precession, alpha, radius, gravity)
        k = steady.stability_coefficient(tilt, precession, roll, alpha, radius, gravity)
        terms = gravity / radius + precession**2 + roll**2
        assert abs(k - wanted) <= 1e-11 * terms


@given(TILTS, *MASSES)
def test_outside_the_marginal_rates_circling_is_stable(tilt, alpha, radius, gravity):
    """The coefficient k is negative exactly between the two marginal rates, or nowhere if there are none."""
    slow, fast = steady.marginal_precession_rates(tilt, 0.0, alpha, radius, gravity)
    rates = math.sqrt(gravity / radius) * np.geomspace(1e-3, 1e2, 301)
    roll = steady.steady_roll_rate(tilt, rates, alpha, radius, gravity)
    k = steady.stability_coefficient(tilt, rates, roll, alpha, radius, gravity)
    inside = (rates > slow) & (rates < fast)
    edge = (np.abs(rates / slow - 1.0) < 1e-6) | (np.abs(rates / fast - 1.0) < 1e-6)
    assert ((k < 0.0) == inside)[~edge].all()


def test_the_top_of_the_unstable_dome():
    """No circling is unstable above 18.62 deg (disk) or 19.20 deg (hoop), as printed in the physics notes."""
    for case in [(0.5, 18.62), (1.0, 19.20)]:
        alpha, top = case
        tilts = np.arange(1.0, 40.0, 0.001)
        slow, fast = steady.marginal_precession_rates(np.radians(tilts), 0.0, alpha, R, G)
        assert abs(tilts[np.isfinite(slow)].max() - top) <= 0.005 + 0.001, case
        assert np.isnan(fast[tilts > top + 0.006]).all(), case
        assert np.isfinite(fast[tilts < top - 0.006]).all(), case


def test_the_dome_stands_on_the_rolling_and_the_spinning_limit():
    """For tilts near zero, the slow branch is critical rolling and the fast one critical spinning."""
    for case in [(0.5, 1 / 3, 4 / 5), (1.0, 1 / 4, 2 / 3)]:
        alpha, roll, spin = case
        tilt = 1e-6
        slow, fast = steady.marginal_precession_rates(tilt, 0.0, alpha, R, G)
        assert steady.steady_roll_rate(tilt, slow, alpha, R, G) ** 2 == pytest.approx(
            roll * G / R, rel=1e-9
        ), case
        assert fast**2 == pytest.approx(spin * G / R, rel=1e-9), case
        assert slow < 1e-5, case
