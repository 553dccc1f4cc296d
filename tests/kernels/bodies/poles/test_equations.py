"""Balls and spheroids in variables that are regular at the poles, compared with a rigid body and ball integrals."""

import math

import body_referee
import numpy as np
import pytest
from body_referee import Body

from kernels.bodies.poles import equations

#: Words, the referee's body and its moments: a ball and two spheroids with offset centers of mass.
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
    """S'', x', s' and the shape agree with the referee's derivatives at tilts up to 0.001 degrees from a pole."""
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
        # a longer way along the motion; n, p and q must remain those of the tilt
        h = 1e-4
        later = equations.lane_step(S, y, x, s, n, p, q, constants, h)
        cosine = math.sqrt(1.0 - later[0] ** 2)
        _, _, n, *_, p, q = equations.begun(later[0], cosine, 0.0, 0.0, 0.0, constants)
        assert later[4:] == pytest.approx([n, p, q], rel=1e-12)


def test_the_integrals_of_the_ball():
    """Jellett's and Routh's integrals are constant to 1e-12 through both poles at 0.01 rad; known values agree."""
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
    """Halving the step divides the error of the state by 16, for a motion that passes a pole."""
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
