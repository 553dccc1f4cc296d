"""Extremes of the contact forces of bodies, compared with a rigid body in space."""

import math

import numpy as np
import pytest
from body_referee import LENGTHS, REFERENCE, Body, start_of
from body_runner import FALL_TILT, drawn
from scipy.optimize import minimize_scalar

from kernels.bodies.arrays import LIFTS_OFF, PRESSES
from kernels.bodies.shapes import NAMES
from sweep.model.bodies.exact import kernel_of

#: Accuracy of the time of an extreme.
CLOSE = {"xatol": 1e-9}


def forces_of(given, body):
    """Return the extremes of the cells and their states."""
    n = given.shape[1]
    extremes, states = np.full((2, n), -7.0), np.full(n, -7)
    kernel_of(body, "contact").load()(
        np.ascontiguousarray(given), float(NAMES.index(body)), FALL_TILT, extremes, states
    )
    return extremes, states


def followed(body, tilt, w, o, s):
    """Return the least normal force and the largest needed friction of a nutation followed in space."""
    period = body.extremes(tilt, w, o, s)[2]
    motion = body.motion(tilt, w, o, s, 1.01 * period, dense_output=True).sol

    def normal(t):
        return body.force(motion(t))[2]

    def held(t):
        force = body.force(motion(t))
        return -math.hypot(force[0], force[1]) / force[2]

    found = []
    for value in (normal, held):
        times = np.linspace(0.0, 1.01 * period, 300)
        values = [value(t) for t in times]
        at = int(np.argmin(values))
        bounds = times[max(at - 1, 0)], times[min(at + 1, times.size - 1)]
        near = minimize_scalar(value, bounds=bounds, method="bounded", options=CLOSE).fun
        found.append(min(near, values[at]))
    return found[0], -found[1]


@pytest.mark.slow_lane
def test_the_extremes_are_those_of_a_body_in_space(pick):
    """Normal force and friction agree for all bodies of the table; the disk needs 1.17 and the ball 0.12."""
    for name, (body, *_) in pick(REFERENCE.items(), 3):
        word, lengths = LENGTHS[name]
        start = (0.2, 0.1, 0.5, 0.6)
        extremes, states = forces_of(
            start_of(word, *start, body.axial, body.transverse, **lengths(body))[0], word
        )
        assert states.tolist() == [PRESSES], name
        assert extremes[:, 0] == pytest.approx(followed(body, *start), rel=1e-7), name


@pytest.mark.slow_lane
def test_random_motions(count):
    """Bodies with an offset center of mass agree, also past poles and where a body would lift off."""
    rng, seen = np.random.default_rng(4), set()
    for number in range(count(13, 20)):
        name = NAMES[number % len(NAMES)]
        lengths, (axial, transverse), (core, shift, edge, square) = drawn(name, rng)
        tilt, rates = rng.uniform(-1.2, 1.2), rng.normal(size=3)
        if name in ("ball", "spheroid") and number > 9:
            tilt, rates[1] = 1.5, 0.02
        extremes, states = forces_of(start_of(name, tilt, *rates, axial, transverse, **lengths)[0], name)
        body = Body(core, -shift if name == "rim" and tilt < 0.0 else shift, edge, axial, transverse, square)
        # a body that falls flat cannot be followed to an end
        with np.errstate(all="ignore"):
            if body.motion(tilt, *rates, 300.0, accuracy=1e-6, most=3).status != 1 or name == "rim":
                continue
        normal, friction = followed(body, tilt, *rates)
        assert extremes[0, 0] == pytest.approx(normal, rel=1e-6, abs=1e-6), number
        assert states[0] == (PRESSES if normal > 0.0 else LIFTS_OFF)
        if states[0] == PRESSES:
            assert extremes[1, 0] == pytest.approx(friction, rel=1e-6), number
        else:
            assert np.isnan(extremes[1, 0])
        seen.add(int(states[0]))
    assert seen == {PRESSES, LIFTS_OFF}
