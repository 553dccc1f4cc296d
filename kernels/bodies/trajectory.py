"""One motion of a body sampled in time, with the path of the contact point on the plane.

The thin disk is a torus without a tube. Heading, roll angle and path are integrals over the state, computed with fourth
order by Simpson's rule over the three states of two half steps.

This module contains the functions that all bodies share, and the functions for bodies without poles. For balls and
spheroids, `kernels.bodies.poles.trajectory` replaces functions by others of the same names.
"""

import math
from typing import Any, NamedTuple

from kernels.bodies import arrays as row
from kernels.bodies import equations
from kernels.bodies import motion_arrays as motion_row
from kernels.bodies.equations import (
    curvature_radius,
    energy_gained,
    evolute,
    fastest_square,
    height,
    levers,
    tilt_acceleration,
    whole_energy,
)
from kernels.bodies.starts import body_of, side_of
from kernels.disk.arrays import PRECESSION_RATE, ROLL_RATE, TILT, TILT_RATE
from kernels.disk.endings import EDGE_CHANGE, FELL, HORIZON, UNRESOLVED
from kernels.disk.equations import scaled_state
from kernels.disk.rk4 import land_on_tilt, land_on_turning_point, step
from kernels.jit import kernel, simd
from kernels.lanes.binding import variant
from kernels.native.entry import entry

#: Number of steps after which a motion is abandoned.
_MOST_STEPS = 100_000_000


class Flow(NamedTuple):
    """Scaled rates of the path of a motion.

    Attributes
    ----------
    turning, rolling : float
        Rates of heading and roll angle; near a pole, without the part in `lean`.
    ahead, aside : float
        Speed of the contact point along the track, and across it towards a positive tilt.
    gaining : float
        Rate of the vertical momentum about the contact point.
    """

    turning: Any
    rolling: Any
    ahead: Any
    aside: Any
    gaining: Any


class Forces(NamedTuple):
    """Quantities of a sample besides its rates; forces over m g, all others scaled.

    Attributes
    ----------
    height, lever : float
        Position of the centre of mass: above the plane, and from the contact point towards a positive tilt.
    energy, change : float
        Energy, and its change since the start.
    momentum, gaining : float
        Vertical momentum about the contact point, and its rate of change.
    normal, across, along : float
        Force of the plane on the body: vertical; horizontal across the track, towards (cos heading, sin heading), the
        direction in which a positive tilt leans; horizontal along the track, towards (-sin heading, cos heading).
    """

    height: Any
    lever: Any
    energy: Any
    change: Any
    momentum: Any
    gaining: Any
    normal: Any
    across: Any
    along: Any


@simd
def set_out(start, kind):
    """Return (state, constants) of a start, shape (len(PARAMETERS), 1)."""
    unit = math.sqrt(start[row.RADIUS, 0] / start[row.GRAVITY, 0])
    rates = start[row.TILT_RATE, 0], start[row.PRECESSION_RATE, 0], start[row.ROLL_RATE, 0]
    return scaled_state(start[row.TILT, 0], rates[0], rates[1], rates[2], unit), body_of(start, 0, kind)


@simd
def pole_near(state, body):
    """Return 1 or -1 near the pole of positive or negative tilts, otherwise 0; these bodies have no poles."""
    return 0.0


@simd
def lean(state, pole):
    """Return the part of the heading that jumps near a pole."""
    return 0.0


@simd
def rates_of(state):
    """Return (S, C, w, o, s) of a state."""
    S, C, _, w, o, s = state
    return S, C, w, o, s


@simd
def flow(state, body, pole):
    """Return the `Flow` of a state."""
    S, C, T, w, o, s = state
    a, b, _ = levers(S, C, body)
    r, rolling = curvature_radius(S, C, body), s - o * T
    gaining = w * (height(S, C, body) * a * rolling - r * (a * s + b * o))
    return Flow(o / C, rolling, a * rolling, r * w, gaining)


@simd
def forces(state, begun, body):
    """Return the `Forces` of a state of a motion that began with the state `begun`.

    Notes
    -----
    With W the tilt acceleration and the letters of `kernels.bodies.equations`: the normal force is
    1 + (r - h) w^2 - l W, the friction h W - l w^2 - (o/C) v across the track and I A w P/D along it; the momentum is
    A C o + I S s + l v (Newton and Euler).
    """
    S, C, T, w, o, s = state
    S0, C0, _, w0, o0, s0 = begun
    a, b, lever = levers(S, C, body)
    A, I, v, high, r = (
        body.transverse,
        body.axial,
        a * s + b * o,
        height(S, C, body),
        curvature_radius(S, C, body),
    )
    faster = tilt_acceleration(state, body)
    twist = (evolute(S, C, body) * o - (r * S + body.ratio * b) * s) / (I * (A + b * b) + A * a * a)
    return Forces(
        high, lever, whole_energy(state, body, I), energy_gained(state, (S0, C0, w0, o0, s0), body, I),
        A * C * o + I * S * s + lever * v, flow(state, body, 0.0).gaining,
        1.0 + (r - high) * w * w - lever * faster, high * faster - lever * w * w - o / C * v, I * A * w * twist,
    )  # fmt: skip


@simd
def suitable_step(state, body, relative_step):
    """Return the scaled step: `relative_step` over the fastest frequency of the linearised motion, times cos(tilt)."""
    return relative_step * state[1] / math.sqrt(fastest_square(state, body))


@kernel
def _turned(before, after):
    """Return the angle from one direction to another one, at most half a turn."""
    turn = after - before
    return turn - 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)


@kernel
def _carry(place, before, middle, after, h, body):
    """Return heading, roll angle, contact point (over R) and momentum gained after a step of scaled length h.

    Near a pole, the rates are of the heading minus its `lean`, and of the roll angle plus (near the other pole minus)
    the heading; both are regular there.
    """
    heading, angle, x, y, gained = place
    pole, sixth = pole_near(middle, body), h / 6.0
    one, two, three = flow(before, body, pole), flow(middle, body, pole), flow(after, body, pole)
    first, second, third = lean(before, pole), lean(middle, pole), lean(after, pole)
    half_way = _turned(first, second)
    # halfway: the integral of the parabola through the three rates, of third order, which enters with another factor h
    heading_1 = heading + h * (5.0 * one.turning + 8.0 * two.turning - three.turning) / 24.0 + half_way
    turned = sixth * (one.turning + 4.0 * two.turning + three.turning) + half_way + _turned(second, third)
    sin_0, sin_1, sin_2 = math.sin(heading), math.sin(heading_1), math.sin(heading + turned)
    cos_0, cos_1, cos_2 = math.cos(heading), math.cos(heading_1), math.cos(heading + turned)
    return (
        heading + turned,
        angle + sixth * (one.rolling + 4.0 * two.rolling + three.rolling) - pole * turned,
        x + sixth * (
            (one.aside * cos_0 - one.ahead * sin_0) + 4.0 * (two.aside * cos_1 - two.ahead * sin_1)
            + (three.aside * cos_2 - three.ahead * sin_2)
        ),
        y + sixth * (
            (one.ahead * cos_0 + one.aside * sin_0) + 4.0 * (two.ahead * cos_1 + two.aside * sin_1)
            + (three.ahead * cos_2 + three.aside * sin_2)
        ),
        gained + sixth * (one.gaining + 4.0 * two.gaining + three.gaining),
    )  # fmt: skip


@kernel
def _fall(before, after, body, fall_tilt, h):
    """Return whether fall_tilt was reached between two states, and the scaled time from the second one back to it."""
    there, elapsed, fell = after, 0.0, not after[1] >= math.cos(fall_tilt)
    if before[3] * after[3] < 0.0:
        there, elapsed = land_on_turning_point(after, body, 2.0 * h)
        beyond = abs(math.atan2(there[0], there[1])) - fall_tilt
        fell = not beyond < 0.0
        if fell:
            # it turned back only beyond fall_tilt: go back to the passage
            back = -math.sqrt(2.0 * beyond / abs(tilt_acceleration(there, body)))
            there, elapsed = step(there, body, back), elapsed + back
    if not fell:
        return False, 0.0
    _, more = land_on_tilt(there, body, math.copysign(fall_tilt, there[0]), 2.0 * h)
    return True, elapsed + more


@kernel
def ended(before, after, body, fall_tilt, side, h):
    """Return (ending, scaled time from the second of two states back to it); HORIZON if the motion continues."""
    fell, back = _fall(before, after, body, fall_tilt, h)
    if fell:
        return FELL, back
    lowest = after[0] * side
    if side != 0.0 and before[3] * after[3] < 0.0:
        there, _ = land_on_turning_point(after, body, 2.0 * h)
        lowest = min(lowest, there[0] * side)
    if side != 0.0 and not lowest >= 0.0:
        _, elapsed = land_on_tilt(before, body, 0.0, 2.0 * h)
        return EDGE_CHANGE, elapsed - h
    return HORIZON, 0.0


@kernel
def _record(samples, i, state, place, begun, body, unit, radius):
    heading, angle, x, y, gained = place
    S, C, w, o, s = rates_of(state)
    found, turning = forces(state, begun, body), o / C if C > 0.0 else 0.0
    per_time = radius * radius / unit
    samples[TILT, i], samples[TILT_RATE, i] = math.atan2(S, C), w / unit
    samples[PRECESSION_RATE, i], samples[ROLL_RATE, i] = turning / unit, (s - turning * S) / unit
    samples[motion_row.HEADING, i], samples[motion_row.ROLL_ANGLE, i] = heading, angle
    samples[motion_row.CONTACT_X, i], samples[motion_row.CONTACT_Y, i] = radius * x, radius * y
    samples[motion_row.CENTRE_X, i] = radius * (x + found.lever * math.cos(heading))
    samples[motion_row.CENTRE_Y, i] = radius * (y + found.lever * math.sin(heading))
    samples[motion_row.CENTRE_Z, i] = radius * found.height
    samples[motion_row.ENERGY, i] = found.energy
    samples[motion_row.ENERGY_DRIFT, i] = found.change / (found.energy - found.change)
    samples[motion_row.MOMENTUM, i], samples[motion_row.GAINED, i] = (
        per_time * found.momentum,
        per_time * gained,
    )
    samples[motion_row.MOMENTUM_RATE, i] = per_time / unit * found.gaining
    samples[motion_row.NORMAL, i] = found.normal
    samples[motion_row.ACROSS, i], samples[motion_row.ALONG, i] = found.across, found.along


@entry(
    start="float64[:, ::1]", settings="float64[::1]", times="float64[::1]", samples="float64[:, ::1], written"
)
def _trajectory(start, settings, times, samples):
    """Integrate one start and record it at the given times.

    Parameters
    ----------
    start : float64[len(PARAMETERS), 1]
        |tilt| below fall_tilt; for a rim not 0.
    settings : float64[len(SETTINGS)]
        `kernels.bodies.motion_arrays.SETTINGS`; for the relative step see `suitable_step`.
    times : float64[n]
        Increasing, from 0 [s].
    samples : float64[len(SAMPLES), n], written

    Returns
    -------
    (ending, filled, last, steps)
        A code of `kernels.disk.endings`: HORIZON, FELL, EDGE_CHANGE or UNRESOLVED (not finite, or too many steps); the
        number of columns written; the time [s] of the last column, which after a fall is the moment when fall_tilt
        was reached; the number of steps.
    """
    kind, radius = settings[motion_row.BODY], start[row.RADIUS, 0]
    unit = math.sqrt(radius / start[row.GRAVITY, 0])
    state, body = set_out(start, kind)
    side, begun = side_of(kind, start[row.TILT, 0]), state
    given_step, relative_step = settings[motion_row.STEP], settings[motion_row.RELATIVE_STEP]
    fall_tilt, place, steps = settings[motion_row.FALL_TILT], (0.0, 0.0, 0.0, 0.0, 0.0), 0
    _record(samples, 0, state, place, begun, body, unit, radius)
    for i in range(1, len(times)):
        left = (times[i] - times[i - 1]) / unit
        parts = 2.0
        while parts > 1.0:
            longest = given_step / unit if given_step > 0.0 else suitable_step(state, body, relative_step)
            parts = max(1.0, math.ceil(left / longest * (1.0 - 1e-12)))
            if not parts + steps <= _MOST_STEPS:
                return UNRESOLVED, i, times[i - 1], steps
            h = left / parts
            middle = step(state, body, 0.5 * h)
            after = step(middle, body, 0.5 * h)
            steps += 1
            ending, back = ended(state, after, body, fall_tilt, side, h)
            if ending != HORIZON:
                h += back
                middle = step(state, body, 0.5 * h)
                after = step(middle, body, 0.5 * h)
                _record(
                    samples, i, after, _carry(place, state, middle, after, h, body), begun, body, unit, radius
                )
                known = math.isfinite(samples[TILT, i] + samples[motion_row.GAINED, i])
                return ending if known else UNRESOLVED, i + 1, times[i] - unit * (left - h), steps
            place = _carry(place, state, middle, after, h, body)
            state = after
            left -= h
        _record(samples, i, state, place, begun, body, unit, radius)
    return HORIZON, len(times), times[-1], steps


_FUNCTIONS = ("carried", "inlined_step", "tilt_acceleration")

#: For bodies whose meridian is an arc of a circle, and that lie flat if the axis is vertical.
trajectory = variant(_trajectory, "bodies", {name: getattr(equations, name) for name in _FUNCTIONS})
