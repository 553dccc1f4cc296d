import math

import lagrange
import mpmath
import numpy as np
import pytest
import referee
from thin_disk import contact_forces

import sweep
from kernels.disk import equations as disk

RNG = np.random.default_rng(4)


def random_states(n):
    """Return coordinates, rolling velocities, and (alpha, mass, radius, gravity) for each of n states."""
    for _ in range(n):
        alpha, mass = RNG.uniform(0.02, 1.0), RNG.uniform(0.1, 5.0)
        radius, gravity = RNG.uniform(0.05, 3.0), RNG.uniform(1.0, 20.0)
        q = np.array([*RNG.uniform(-2, 2, 2), RNG.uniform(-3, 3), RNG.uniform(-1.3, 1.3), RNG.uniform(-3, 3)])
        psi, theta, phi = RNG.uniform(-5, 5, 3)
        v = np.array([-radius * phi * math.sin(q[2]), radius * phi * math.cos(q[2]), psi, theta, phi])
        yield q, v, (alpha, mass, radius, gravity)


def lagrangian(q, v, alpha, mass, radius, gravity):
    """Return kinetic minus potential energy of a rigid disk, with the center's velocity by differentiation."""
    psi, theta = q[2], q[3]

    def centre(t):
        lean = radius * mpmath.sin(theta + v[3] * t)
        turned = psi + v[2] * t
        return (
            q[0] + v[0] * t + lean * mpmath.cos(turned),
            q[1] + v[1] * t + lean * mpmath.sin(turned),
            radius * mpmath.cos(theta + v[3] * t),
        )

    speed = sum(mpmath.diff(lambda t, i=i: centre(t)[i], 0) ** 2 for i in range(3))
    axial = alpha * radius**2 * (v[4] + v[2] * mpmath.sin(theta)) ** 2
    diametral = alpha * radius**2 / 2 * (v[3] ** 2 + (v[2] * mpmath.cos(theta)) ** 2)
    return mass * (speed + axial + diametral) / 2 - mass * gravity * radius * mpmath.cos(theta)


def test_matrices_are_those_of_the_lagrangian():
    """d/dt(dL/dv) - dL/dq, differentiated by mpmath, equals M a + B + G for any accelerations a."""
    with mpmath.workdps(60):
        for q, v, masses in random_states(3):
            a = RNG.uniform(-3, 3, 5)
            alpha, mass, radius, gravity = masses
            M = lagrange.mass_matrix(q, alpha, mass, radius)
            B = lagrange.velocity_forces(q, v, alpha, mass, radius)
            G = lagrange.potential_forces(q, mass, radius, gravity)
            exact = [mpmath.mpf(each) for each in (*q, *v)]

            def L(*y, masses=masses):
                return lagrangian(y[:5], y[5:], *masses)

            for k in range(5):
                momentum, place = [0] * 10, [0] * 10
                momentum[5 + k] = place[k] = 1

                def along(t, q=exact[:5], v=exact[5:], a=a, momentum=momentum, L=L):
                    y = [x + u * t + w * t**2 / 2 for x, u, w in zip(q, v, a, strict=True)]
                    return mpmath.diff(
                        L, (*y, *(u + w * t for u, w in zip(v, a, strict=True))), tuple(momentum)
                    )

                expected = mpmath.diff(along, 0, h=mpmath.mpf(10) ** -15) - mpmath.diff(
                    L, tuple(exact), tuple(place)
                )
                assert (M @ a + B + G)[k] == pytest.approx(float(expected), rel=1e-10, abs=1e-10)


def test_entries_that_the_report_misprints():
    """For the uniform disk, M44 = 5mR2/4, and B3 and B4 are twice the printed ones (errata of the report)."""
    mass, radius = 3.0, 0.7
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    v = np.array([0.0, 0.0, 1.1, 1.2, 1.3])
    sin, cos = math.sin(0.4), math.cos(0.4)
    M = lagrange.mass_matrix(q, 0.5, mass, radius)
    B = lagrange.velocity_forces(q, v, 0.5, mass, radius)
    assert M[3, 3] == pytest.approx(5.0 * mass * radius**2 / 4.0, rel=1e-15)
    assert B[2] == pytest.approx(mass * radius**2 * 1.2 * cos * (1.3 + 5.0 * 1.1 * sin) / 2.0, rel=1e-15)
    assert B[3] == pytest.approx(
        -mass * radius**2 * 1.1 * cos * (2.0 * 1.3 + 5.0 * 1.1 * sin) / 4.0, rel=1e-15
    )


def test_constraints_are_rolling_without_slip():
    """W q' vanishes if the contact point moves at R phi' along the track; W' is the time derivative of W."""
    for q, v, (_, _, radius, _) in random_states(20):
        assert np.abs(lagrange.constraint_matrix(q, radius) @ v).max() <= 1e-14 * (1.0 + np.abs(v).max())
        h = 1e-6
        ahead = lagrange.constraint_matrix(q + h * v, radius) - lagrange.constraint_matrix(q - h * v, radius)
        assert lagrange.constraint_matrix_rate(q, v) == pytest.approx(ahead / (2.0 * h), abs=1e-8)


@pytest.mark.slow_lane
def test_both_derivations_agree():
    """Accelerations equal Newton's, and multipliers equal the horizontal contact forces, to 1e-12."""
    for q, v, (alpha, mass, radius, gravity) in random_states(300):
        found, multipliers = lagrange.accelerations(q, v, alpha, mass, radius, gravity)
        state = (q[3], v[3], v[2], v[4])
        tilting, turning, rolling = referee.accelerations(state, alpha, radius, gravity)
        size = 1.0 + max(map(abs, (tilting, turning, rolling)))
        assert found[[3, 2, 4]] == pytest.approx([tilting, turning, rolling], rel=0.0, abs=1e-12 * size)
        scaled = disk.scaled_state(*state, math.sqrt(radius / gravity))
        forces = contact_forces(scaled, alpha)
        weight = mass * gravity
        assert multipliers / weight == pytest.approx(
            forces[1:], rel=0.0, abs=1e-12 * (1.0 + np.abs(forces).max())
        )


def test_many_states_at_once():
    """Stacks of states give the same numbers as single states."""
    states = [(q, v) for q, v, _ in random_states(5)]
    q, v = (np.stack(each) for each in zip(*states, strict=True))
    together, forces = lagrange.accelerations(q, v, 0.5, 1.0, 0.5, 9.81)
    for i in range(5):
        alone, force = lagrange.accelerations(q[i], v[i], 0.5, 1.0, 0.5, 9.81)
        assert together[i] == pytest.approx(alone, rel=1e-12)
        assert forces[i] == pytest.approx(force, rel=1e-12, abs=1e-12)


@pytest.mark.compiled
def test_five_coordinates_stay_on_the_constraints_and_follow_the_reduced_motion():
    """In ten seconds of unstable spinning, slip stays below 1e-10 m/s and positions within 1e-6 of the reduced run."""
    steps, radius = 3000, 0.5
    q, v = np.zeros(5), np.array([0.0, 0.0, 3.5, 0.1, 0.0])
    qs, vs, slip = lagrange.run(q, v, 10.0, steps, 0.5, 1.0, radius, 9.81)
    # each step leaves little slip, and the projection reduces it to rounding
    assert slip.max() <= 1e-10
    assert np.abs(lagrange.constraint_matrix(qs, radius) @ vs[..., None]).max() <= 1e-14
    reduced = sweep.simulate(tilt_rate=0.1, precession_rate=3.5, duration=10.0, interval=10.0 / steps)
    for column, name in enumerate(("contact_x", "contact_y", "heading", "tilt", "roll_angle")):
        assert np.abs(qs[:, column] - reduced[name].values).max() <= 1e-6
