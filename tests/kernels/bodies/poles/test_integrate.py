"""Balls and spheroids through their poles, against a rigid body in space, closed forms and the integrals of a ball."""

import math

import body_referee
import numpy as np
import pytest
from body_referee import Body, start_of, starts
from body_runner import run
from scipy.integrate import quad

from kernels.bodies.poles import equations
from kernels.bodies.poles.error_estimate import drift
from kernels.bodies.shapes import spheroid_moments
from kernels.disk.endings import BOUNDED, INVALID

#: Words, referee's body and moments: a ball and two spheroids with the centre of mass off the centre.
BODIES = (
    ("ball", {"offset": 0.3}, Body(0.0, 0.3, 1.0, 0.42, 0.38)),
    ("spheroid", {"flattening": 0.4, "offset": -0.2}, Body(0.0, -0.2, 1.0, 0.4, 0.3, 0.36)),
    ("spheroid", {"flattening": -0.6, "offset": 0.1}, Body(0.0, 0.1, 1.0, 0.35, 0.6, 2.56)),
)


def rolling(body, tilt, w, o, s):
    """Return the constants of a motion with its energy, its state and its start, all scaled."""
    energy = body.energy(body.start(tilt, w, o, s))
    ratio = body.axial / body.transverse
    constants = equations.Rolling(
        0.0, body.shift, 1.0, body.square, body.axial, body.transverse, ratio, energy
    )
    start = math.sin(tilt), math.cos(tilt), w, o, s
    return constants, equations.begun(*start, constants), start


def test_the_slopes_are_those_of_newton_and_euler():
    """At tilts up to 0.001 degrees from a pole: S'', x', s' and the shape, from derivatives of the referee."""
    rng = np.random.default_rng(6)
    for number in range(12):
        _, _, body = BODIES[number % 3]
        tilt = (0.5 * math.pi - 10.0 ** rng.uniform(-4.8, 0.0)) * rng.choice([-1.0, 1.0])
        w, o, s = rng.normal(size=3)
        constants, (S, _, n, y, x, s, p, q), _ = rolling(body, tilt, w, o, s)
        found = equations.slopes(S, y, x, s, n, p, q, constants)
        state = body.start(tilt, w, o, s)
        rate = body.right_side(0.0, state)
        axis, turning, axis_rate, turning_rate = state[:3], state[3:], rate[:3], rate[3:]
        rise = body_referee.cross(turning_rate, axis)[2] + body_referee.cross(turning, axis_rate)[2]
        # x = turning . up - S s
        spun = turning_rate @ axis + turning @ axis_rate
        along = turning_rate[2] - axis_rate[2] * s - S * spun
        assert found[0] == pytest.approx(axis_rate[2], abs=1e-13)
        assert found[1] == pytest.approx(rise, rel=1e-10, abs=1e-11)
        assert found[2:4] == pytest.approx([along, spun], rel=1e-10, abs=1e-11)
        # a longer way along the motion: n, p and q stay what they are of the tilt
        h = 1e-4
        later = equations.lane_step(S, y, x, s, n, p, q, constants, h)
        there = (later[0], 0.0, later[4], *later[1:4], *later[5:])
        assert equations.departure(there, constants) < 1e-12


def test_motions_beside_a_pole_and_through_it_are_those_of_a_body_in_space():
    """Extreme tilts within twice their stated error and 1e-8, periods to 1e-7, that pass a pole at 1e-6 to 0.1 rad."""
    for number, along in enumerate((0.0, 1e-6, 1e-4, 3e-3, 0.1)):
        for word, lengths, body in BODIES:
            if along == 0.0:
                tilt, rates = 0.4, (2.5, 0.0, 0.0)
            else:
                tilt, rates = 0.5 * math.pi - along, (1e-3 * (number + 1), 1.3, 0.4 + number)
            given, _ = start_of(word, tilt, *rates, body.axial, body.transverse, **lengths)
            found = run(given, word)
            least, greatest, period = body.extremes(tilt, *rates)
            assert found.ending[0] == BOUNDED, (word, along)
            for value, right in ((found.least[0], least), (found.greatest[0], greatest)):
                assert abs(value - right) < min(1e-8, 2.0 * found.tilt_error[0] + 1e-10), (word, along)
            assert found.period[0] == pytest.approx(period, rel=1e-7), (word, along)


def test_a_body_that_rolls_end_over_end_turns_at_both_poles():
    """A ball turns evenly, once in the period; of a spheroid the time is an integral over the angle."""
    given, _ = start_of("ball", 0.3, 0.7, 0.0, 0.0, 0.4, 0.4)
    found = run(given, "ball", fall_tilt=0.1)
    assert found.ending[0] == BOUNDED
    assert [found.least[0], found.greatest[0]] == pytest.approx([-0.5 * math.pi, 0.5 * math.pi], abs=1e-8)
    assert found.period[0] == pytest.approx(2.0 * math.pi / 0.7, rel=1e-9)
    for flattening in (0.5, -0.5):
        q, (axial, transverse) = 1.0 - flattening, spheroid_moments(flattening)
        given, _ = start_of("spheroid", 0.0, 1.5, 0.0, 0.0, axial, transverse, flattening=flattening)

        def slowness(angle, q=q, transverse=transverse):
            square = math.cos(angle) ** 2 + (q * math.sin(angle)) ** 2
            inertia = transverse + (math.cos(angle) ** 2 + (q * q * math.sin(angle)) ** 2) / square
            kinetic = 0.5 * (1.0 + transverse) * 1.5**2 + 1.0 - math.sqrt(square)
            return math.sqrt(0.5 * inertia / kinetic)

        found = run(given, "spheroid")
        assert found.greatest[0] == pytest.approx(0.5 * math.pi, abs=1e-8)
        expected = 4.0 * quad(slowness, 0.0, 0.5 * math.pi, epsabs=1e-12)[0]
        assert found.period[0] == pytest.approx(expected, rel=1e-8)


def test_the_integrals_of_the_ball():
    """Jellett's and Routh's along a motion past both poles at 0.01 rad, to 1e-12; the values of a known start."""
    ball = BODIES[0][2]

    def integrals(S, x, s):
        high, across, axial = S + ball.shift, ball.transverse, ball.axial
        square = axial * across + axial * high**2 + across * (1.0 - S * S)
        return across * x + axial * high * s, s * math.sqrt(square)

    constants, state, _ = rolling(ball, 0.5 * math.pi - 0.01, 3.0, 0.1, 0.2)
    before, passed = integrals(state[0], state[4], state[5]), []
    for _ in range(6000):
        state = equations.inlined_step(state, constants, 1e-3)
        passed.append(state[0])
    assert max(passed) > math.cos(0.05)
    assert min(passed) < -math.cos(0.3)
    assert integrals(state[0], state[4], state[5]) == pytest.approx(before, rel=1e-12, abs=1e-12)
    ball = Body(0.0, 0.2, 1.0, 0.42, 0.38)
    _, state, _ = rolling(ball, 0.2, 0.1, 0.5, 0.6)
    assert integrals(state[0], state[4], state[5]) == pytest.approx((0.2866773212, 0.4613977481), abs=1e-10)


def test_the_method_is_of_fourth_order():
    """Half the step leaves a sixteenth of the error of the state, at a motion that passes a pole."""
    constants, begin, _ = rolling(BODIES[2][2], 1.4, 0.8, 0.2, 1.5)
    ends = []
    for steps in (400, 800, 1600, 12800):
        state = begin
        for _ in range(steps):
            state = equations.inlined_step(state, constants, 4.0 / steps)
        ends.append(np.array(state[3:6]))
    errors = [np.abs(each - ends[-1]).max() for each in ends[:-1]]
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(16.0, rel=0.1)


def test_every_measure_of_the_error_sees_its_number():
    """What is wrong with a state, number by number, is a drift of the size of the fault; at a pole too."""
    for tilt in (0.3, 0.5 * math.pi - 1e-4):
        constants, state, start = rolling(BODIES[1][2], tilt, 0.4, 0.6, 1.1)
        whole = constants.energy
        assert drift(state, start, whole, 0.0, constants, 1.0)[0] < 1e-14
        for place in (2, 3, 4, 6, 7):
            wrong = list(state)
            wrong[place] += 1e-6
            lost = drift(tuple(wrong), start, whole, 0.0, constants, 1.0)[0]
            # at a pole y and x count by their own size
            assert lost > 1e-8 if place in (2, 6, 7) or tilt < 1.0 else lost > 1e-12, (tilt, place)


def test_no_tilt_is_a_fall_and_what_is_no_body_is_none():
    """A start beside the pole is followed whatever fall_tilt says; a flattening of 1 or more is none."""
    given = starts(tilt=1.5, tilt_rate=1.0, axial_moment=0.4, transverse_moment=0.4)
    for word in ("ball", "spheroid"):
        assert run(given, word, fall_tilt=0.5).ending.tolist() == [BOUNDED]
    flat = starts(flattening=1.0, axial_moment=0.4, transverse_moment=0.4)
    assert run(flat, "spheroid").ending.tolist() == [INVALID]


def test_a_cell_has_its_own_bits():
    """Order and neighbours do not change them."""
    rng = np.random.default_rng(4)
    n = 150
    given = starts(
        n, tilt=rng.uniform(-1.5, 1.5, n), tilt_rate=rng.normal(size=n), roll_rate=rng.normal(size=n),
        flattening=rng.uniform(-1.0, 0.6, n), axial_moment=0.4, transverse_moment=0.3,
    )  # fmt: skip
    whole, order = run(given, "spheroid").bits(), rng.permutation(n)
    assert np.array_equal(run(given[:, order], "spheroid").bits(), whole[order])
    assert np.array_equal(run(given[:, 7:8], "spheroid").bits(), whole[7:8])
