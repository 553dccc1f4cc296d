import math

import mpmath
import numpy as np
import pytest
import referee
from hypothesis import given
from hypothesis import strategies as st
from kernel_runner import flow
from thin_disk import contact_forces, vertical_momentum

from kernels.disk import equations as disk

TILTS = st.floats(-1.4, 1.4)
RATES = st.floats(-20.0, 20.0)
STATES = st.tuples(TILTS, RATES, RATES, RATES)
MASSES = {"alpha": st.floats(0.01, 1.0), "radius": st.floats(0.01, 10.0), "gravity": st.floats(0.1, 30.0)}


def rigid_body(state, alpha, radius, gravity):
    """Return force over m g and vertical angular momentum about the contact over m, by differentiation.

    The coordinates have given velocities and accelerations; mpmath differentiates the center of mass twice.
    The angular
    momentum is r x v of the moving center plus that of the rotation.
    """
    tilt, rate, turning, rolling = map(mpmath.mpf, state)
    tilting, turn_up, roll_up = referee.accelerations(state, alpha, radius, gravity)

    def centre(t):
        psi, theta = turning * t + turn_up * t**2 / 2, tilt + rate * t + tilting * t**2 / 2
        # contact point: x' = -R phi' sin psi, y' = R phi' cos psi, expanded to second order at psi = 0
        x, y = -radius * rolling * turning * t**2 / 2, radius * (rolling * t + roll_up * t**2 / 2)
        lean = radius * mpmath.sin(theta)
        return x + lean * mpmath.cos(psi), y + lean * mpmath.sin(psi), radius * mpmath.cos(theta)

    with mpmath.workdps(40):
        acceleration = [mpmath.diff(lambda t, i=i: centre(t)[i], 0, 2) for i in range(3)]
        velocity = [mpmath.diff(lambda t, i=i: centre(t)[i], 0) for i in range(3)]
        arm = centre(mpmath.mpf(0))
        orbital = arm[0] * velocity[1] - arm[1] * velocity[0]
        # the axis of the disk is (cos tilt, 0, -sin tilt); the diameter perpendicular to it is (sin tilt, 0,
        # cos tilt)
        axial = alpha * radius**2 * (rolling + turning * mpmath.sin(tilt)) * mpmath.sin(tilt)
        diametral = alpha * radius**2 / 2 * turning * mpmath.cos(tilt) * mpmath.cos(tilt)
    forces = (acceleration[2] + gravity, acceleration[0], acceleration[1])
    return [float(force / gravity) for force in forces], float(orbital + axial + diametral)


@given(STATES, *MASSES.values())
def test_contact_forces_are_newtons(state, alpha, radius, gravity):
    """The three components equal mass times the center's acceleration, minus the weight."""
    scaled = disk.scaled_state(*state, math.sqrt(radius / gravity))
    found = contact_forces(scaled, alpha)
    expected, _ = rigid_body(state, alpha, radius, gravity)
    size = (1.0 + radius / gravity * sum(rate**2 for rate in state[1:])) / math.cos(state[0])
    assert found == pytest.approx(expected, rel=0.0, abs=1e-12 * size)


@given(STATES, *MASSES.values())
def test_vertical_momentum_is_that_of_a_moving_rigid_body(state, alpha, radius, gravity):
    """H.e3 about the contact point equals the center's r x v plus the rotation, computed from velocities."""
    unit = math.sqrt(radius / gravity)
    found, _ = vertical_momentum(disk.scaled_state(*state, unit), alpha)
    _, expected = rigid_body(state, alpha, radius, gravity)
    assert found * radius**2 / unit == pytest.approx(expected, rel=1e-12, abs=1e-12 * radius**2 * 40.0)


@given(STATES, st.floats(0.01, 1.0))
def test_vertical_momentum_obeys_its_balance_law(state, alpha):
    """Along the flow, H.e3 changes at the nonzero rate (roll rate)(tilt rate) cos(tilt)."""
    scaled = np.array(disk.scaled_state(*state, 0.1))
    ahead = flow(scaled, alpha)
    _, rate = vertical_momentum(tuple(scaled), alpha)
    # H.e3 is quadratic in the state, so central differences are exact
    after, _ = vertical_momentum(tuple(scaled + ahead), alpha)
    before, _ = vertical_momentum(tuple(scaled - ahead), alpha)
    assert 0.5 * (after - before) == pytest.approx(
        rate, rel=0.0, abs=1e-13 * (1.0 + scaled @ scaled + ahead @ ahead)
    )


def test_a_standing_disk_presses_with_its_weight():
    """For a disk that stands upright, the normal force is m g and no friction is needed."""
    state = disk.scaled_state(0.0, 0.0, 0.0, 0.0, 1.0)
    normal, across, along = contact_forces(state, 0.5)
    assert (normal, across, along) == (1.0, 0.0, 0.0)
