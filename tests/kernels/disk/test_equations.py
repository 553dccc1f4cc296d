import math

import mpmath
import numpy as np
import pytest
import referee
from hypothesis import given
from hypothesis import strategies as st
from kernel_runner import flow

from kernels.disk import equations as disk

TILTS = st.floats(-1.4, 1.4)
RATES = st.floats(-20.0, 20.0)
MASSES = {"alpha": st.floats(0.01, 1.0), "radius": st.floats(0.01, 10.0), "gravity": st.floats(0.1, 30.0)}
STATES = st.tuples(TILTS, RATES, RATES, RATES)


def size(state, unit):
    """Return the size of the largest terms in the equations, the unit for the rounding of results."""
    return (1.0 + sum((unit * rate) ** 2 for rate in state[1:])) / math.cos(state[0]) ** 2


@given(STATES, *MASSES.values())
def test_the_scaled_derivatives_are_those_of_the_equations_of_motion(state, alpha, radius, gravity):
    """The polynomial right-hand sides equal the textbook ones with sines and cosines, by the product rule."""
    unit = math.sqrt(radius / gravity)
    tilt, rate, precession, roll = state
    tilting, turning, rolling = referee.accelerations(state, alpha, radius, gravity)
    sin, cos = math.sin(tilt), math.cos(tilt)
    expected = (
        unit * cos * rate,
        -unit * sin * rate,
        unit * rate / cos**2,
        unit**2 * tilting,
        unit**2 * (turning * cos - precession * sin * rate),
        unit**2 * (rolling + turning * sin + precession * cos * rate),
    )
    scaled = disk.scaled_state(tilt, rate, precession, roll, unit)
    found = flow(scaled, alpha)
    assert found == pytest.approx(expected, rel=0.0, abs=1e-13 * size(state, unit))


@given(STATES, *MASSES.values())
def test_the_energy_is_that_of_a_moving_rigid_body(state, alpha, radius, gravity):
    """Energy over m g R equals translation plus rotation plus height, computed from velocities."""
    unit = math.sqrt(radius / gravity)
    S, C, _, w, o, s = disk.scaled_state(*state, unit)
    expected = referee.energy(state, alpha, radius, gravity) / (gravity * radius)
    assert disk.energy(S, C, w, o, s, alpha) == pytest.approx(expected, rel=1e-13)


@given(STATES, st.floats(0.01, 1.0))
def test_the_energy_is_conserved(state, alpha):
    """The energy is constant along the flow; it is quadratic in the state, so central differences are exact."""
    scaled = np.array(disk.scaled_state(*state, 0.1))
    ahead = flow(scaled, alpha)

    def energy(state):
        S, C, _, w, o, s = state
        return disk.energy(S, C, w, o, s, alpha)

    change = energy(scaled + ahead) - energy(scaled - ahead)
    # the canceling terms are of the size of the flow squared
    assert abs(change) <= 1e-13 * (1.0 + scaled @ scaled + ahead @ ahead)


@given(STATES, STATES, st.floats(0.01, 1.0))
def test_energy_change_is_the_difference_of_two_energies(state, start, alpha):
    """The form with differences equals the subtraction wherever that is accurate enough."""
    S, C, _, w, o, s = disk.scaled_state(*state, 0.1)
    S0, C0, _, w0, o0, s0 = disk.scaled_state(*start, 0.1)
    new, old = disk.energy(S, C, w, o, s, alpha), disk.energy(S0, C0, w0, o0, s0, alpha)
    change = disk.energy_change(S, C, w, o, s, S0, C0, w0, o0, s0, alpha)
    assert change == pytest.approx(new - old, rel=0.0, abs=1e-14 * (new + old))


@given(st.floats(1e-7, 1e-4), st.floats(1e-7, 1e-4))
def test_energy_change_is_exact_near_upright(tilt, start):
    """For two tilts of 1e-7 rad, whose cosines differ by less than the last bit, the difference has 12 digits."""
    with mpmath.workdps(40):
        S, S0 = mpmath.sin(tilt), mpmath.sin(start)
        # the kernel's sines and cosines are rounded to double, and only those digits count
        exact = -(mpmath.mpf(float(S)) - float(S0)) * (mpmath.mpf(float(S)) + float(S0))
        exact /= mpmath.cos(tilt) + mpmath.cos(start)
    found = disk.energy_change(
        math.sin(tilt), math.cos(tilt), 0.0, 0.0, 1.0, math.sin(start), math.cos(start), 0.0, 0.0, 1.0, 0.5
    )
    assert found == pytest.approx(float(exact), rel=1e-12, abs=1e-35)


def test_inertia_of_disk_and_hoop():
    """The inertias are 1/(1 + alpha/2), 1 + alpha, alpha/2 and 1/(1 + alpha), by hand."""
    for case in [(0.5, (0.8, 1.5, 0.25, 2 / 3)), (1.0, (2 / 3, 2.0, 0.5, 0.5))]:
        alpha, constants = case
        assert disk.inertia(alpha) == pytest.approx(constants, rel=1e-15), case


@given(STATES, st.floats(1e-3, 1e3))
def test_a_start_is_read_back_from_its_scaled_state(state, unit):
    """Tilt and rates are recovered from the scaled state, and the three forms of the tilt agree."""
    S, C, tan, w, o, s = disk.scaled_state(*state, unit)
    precession = o / (unit * C)
    back = (math.atan2(S, C), w / unit, precession, s / unit - precession * S)
    assert back == pytest.approx(state, rel=1e-14, abs=1e-13)
    assert tan == pytest.approx(math.tan(state[0]), rel=1e-14)
