"""Extremes of the contact forces of bodies, compared with a rigid body in space and with the thin disk."""

import math

import numpy as np
import pytest
import referee
from body_referee import LENGTHS, REFERENCE, Body, start_of, starts
from body_runner import FALL_TILT, drawn
from scipy.optimize import minimize_scalar

from kernels.bodies.shapes import NAMES
from kernels.disk import contact_extremes as of_disk
from kernels.disk.arrays import TILT
from kernels.disk.endings import BOUNDED, FELL
from kernels.disk.motion_arrays import EXTENT, LIFTS_OFF, PRESSES
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


@pytest.mark.slow_lane
def test_the_thin_disk_has_the_forces_of_its_own_kernel():
    """Motions that nutate, fall or rest have the forces of the thin disk's own kernel."""
    rng, n = np.random.default_rng(5), 300
    rates = {
        "tilt_rate": rng.normal(size=n),
        "precession_rate": rng.normal(size=n),
        "roll_rate": rng.normal(size=n),
    }
    rates = {name: each * (rng.random(n) < 0.8) for name, each in rates.items()}
    tilt = rng.uniform(-1.3, 1.3, n)
    own = referee.starts(tilt=tilt, **rates, alpha=0.5, radius=1.0, gravity=1.0)
    given = starts(n, tilt=tilt, **rates, axial_moment=0.5, transverse_moment=0.25)
    measures, counts = np.empty((5, n)), np.empty((1, n), np.int32)
    kernel_of("torus", "reduce").load()(given, 0.0, FALL_TILT, 0, measures, counts)
    extents = np.stack([measures[0], measures[1], np.full(n, 1e-12)])
    assert EXTENT == ("tilt_min", "tilt_max", "tilt_error")
    expected, known = np.empty((2, n)), np.empty(n, np.int64)
    of_disk.contact_extremes(own, extents, counts[0].astype(np.int64), FALL_TILT, expected, known)
    extremes, states = forces_of(given, "torus")
    assert {BOUNDED, FELL} <= set(counts[0].tolist())
    assert np.array_equal(own[TILT], given[0])
    assert np.array_equal(states, known)
    np.testing.assert_allclose(extremes, expected, rtol=1e-6, atol=1e-6)
