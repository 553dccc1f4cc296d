"""Steady motions of bodies and their stability, compared with the linearized motion of a rigid body in space."""

import math

import numpy as np
import pytest
from body_referee import REFERENCE, Body
from body_runner import NAMES, drawn
from scipy.optimize import brentq

from kernels.bodies import steady
from kernels.bodies.shapes import Body as Constants

#: Critical spin of upright rolling and critical rate of upright spinning, by another form of the equations.
CRITICAL = {
    "disk": (0.5773502692, 0.8944271910),
    "torus": (0.4949332526, 0.7536891516),
    "hollow": (0.4963869458, 0.7180903671),
    "edge": (0.5550782230, 0.8508470785),
    "oblate": (0.5786375624, 0.7745966692),
}


def coefficient(body, tilt, o, s):
    """Return the coefficient of small oscillations, from derivatives of Newton and Euler's equations.

    In the frame that turns with the motion, the motion is an equilibrium. Four of its six eigenvalues vanish
    because of
    the symmetry and the family of steady motions; the others are +-sqrt(-k), so the trace of the squared
    matrix is -2k.
    """
    y = body.start(tilt, 0.0, o, s)
    turn = o / math.cos(tilt)
    whirl = np.array([[0.0, -turn, 0.0], [turn, 0.0, 0.0], [0.0, 0.0, 0.0]])
    frame = np.block([[whirl, np.zeros((3, 3))], [np.zeros((3, 3)), whirl]])
    slopes = []
    for each in np.eye(6):
        near, far = (
            (body.right_side(0.0, y + h * each) - body.right_side(0.0, y - h * each)) / (2.0 * h)
            for h in (1e-3, 2e-3)
        )
        nearest = (body.right_side(0.0, y + 5e-4 * each) - body.right_side(0.0, y - 5e-4 * each)) / 1e-3
        # Richardson extrapolation, twice
        first, second = (4.0 * nearest - near) / 3.0, (4.0 * near - far) / 3.0
        slopes.append((16.0 * first - second) / 15.0)
    matrix = np.array(slopes).T - frame
    return -0.5 * np.trace(matrix @ matrix)


def constants(body):
    """Return the `kernels.bodies.shapes.Body` of a referee's body."""
    return Constants(
        body.core,
        body.shift,
        body.edge,
        body.square,
        body.axial,
        body.transverse,
        body.axial / body.transverse,
    )


def test_critical_rates_by_bisection():
    """Both critical rates of upright bodies agree to 1e-9 with the linearized referee and with the table's digits."""
    for name, rates in CRITICAL.items():
        body = REFERENCE[name][0]
        for rate, square, axis in zip(
            rates,
            (steady.critical_spin_square, steady.critical_precession_square),
            ((0.0, 1.0), (1.0, 0.0)),
            strict=True,
        ):
            found = math.sqrt(square(constants(body)))
            assert found == pytest.approx(rate, abs=3e-10), name
            root = brentq(_upright, 0.5 * rate, 1.5 * rate, (body, *axis), xtol=1e-12)
            assert found == pytest.approx(root, abs=1e-9), name


def _upright(rate, body, along, spin):
    return coefficient(body, 0.0, rate * along, rate * spin)


def test_circling_keeps_its_tilt_and_oscillates_as_told():
    """For random bodies, tilts and rates, the referee has no tilt acceleration and the same k."""
    rng = np.random.default_rng(8)
    for number in range(15):
        _, (axial, transverse), (core, shift, edge, square) = drawn(NAMES[number % len(NAMES)], rng)
        body, tilt, o = (
            Body(core, shift, edge, axial, transverse, square),
            rng.uniform(0.1, 1.0),
            rng.uniform(0.3, 2.0),
        )
        s = steady.steady_spin(tilt, o, constants(body))
        y = body.start(tilt, 0.0, o, s)
        rate = body.right_side(0.0, y)
        # n_z'' vanishes
        second = np.cross(rate[3:], y[:3]) + np.cross(y[3:], rate[:3])
        assert second[2] == pytest.approx(0.0, abs=1e-12)
        found = steady.stability_coefficient(tilt, o, s, constants(body))
        assert found == pytest.approx(coefficient(body, tilt, o, s), rel=1e-8, abs=1e-8)
    for name, spin, k in (
        ("torus", -0.1211040952, 0.1178428088),
        ("oblate", -0.1461717820, 0.1109432113),
    ):
        body = constants(REFERENCE[name][0])
        s = steady.steady_spin(0.3, 0.7, body)
        assert s == pytest.approx(spin, abs=1e-10), name
        assert steady.stability_coefficient(0.3, 0.7, s, body) == pytest.approx(k, abs=1e-10), name


def test_marginal_rates_have_the_coefficient_asked_for():
    """At the marginal rates k has the requested value, and at no other rate between them or far away."""
    torus = constants(REFERENCE["torus"][0])
    for body in (torus, constants(REFERENCE["oblate"][0])):
        for asked in (0.0, 0.05):
            for rate in steady.marginal_precession_rates(np.float64(0.25), asked, body):
                o = rate * math.cos(0.25)
                s = steady.steady_spin(0.25, o, body)
                assert steady.stability_coefficient(0.25, o, s, body) == pytest.approx(asked, abs=1e-12)
    assert np.isnan(steady.marginal_precession_rates(np.float64(0.5), 0.0, torus)).all()


def test_the_wobble_has_its_centre_at_rest():
    """The center of mass has zero velocity, and the tilt has zero acceleration."""
    for name in ("disk", "torus", "edge"):
        body, tilt = REFERENCE[name][0], 1.2
        o = math.sqrt(steady.wobble_square(tilt, constants(body))) * math.cos(tilt)
        s = steady.centred_spin(tilt, o, constants(body))
        y = body.start(tilt, 0.0, o, s)
        assert np.abs(np.cross(y[3:], body.contact(y[:3], np.zeros(3))[0])).max() < 1e-14
        assert s == pytest.approx(steady.steady_spin(tilt, o, constants(body)), abs=1e-13)


def test_a_prolate_spheroid_is_stable_upright_at_every_rate():
    """The squares of its critical rates are negative, and the referee swings about upright even at rest."""
    prolate = REFERENCE["prolate"][0]
    assert steady.critical_spin_square(constants(prolate)) < 0.0
    assert steady.critical_precession_square(constants(prolate)) < 0.0
    for rate in (0.0, 0.7):
        assert _upright(rate, prolate, 0.0, 1.0) > 0.0
        assert _upright(rate, prolate, 1.0, 0.0) > 0.0


def test_spinning_on_the_end_of_a_ball_and_of_a_spheroid():
    """The spins agree with bisection on another form of the equations; a low center of mass needs no spin."""
    tip = steady.critical_pole_spin_square(constants(REFERENCE["prolate"][0]), 1.0)
    assert math.sqrt(tip) == pytest.approx(2.2208045364, abs=1e-10)
    assert steady.critical_pole_spin_square(constants(REFERENCE["oblate"][0]), 1.0) < 0.0
    ball = constants(REFERENCE["ball"][0])
    assert math.sqrt(steady.critical_pole_spin_square(ball, 1.0)) == pytest.approx(0.7448445990, abs=1e-10)
    assert steady.critical_pole_spin_square(ball, -1.0) < 0.0
    other = Constants(0.0, 0.6, 1.0, 1.0, 0.2, 0.3, 2.0 / 3.0)
    assert math.sqrt(steady.critical_pole_spin_square(other, 1.0)) == pytest.approx(1.4555131461, abs=1e-10)
