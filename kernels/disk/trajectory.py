"""One motion sampled in time, with the path of the contact point on the plane.

The state advances with the same step as in atlases (`kernels.disk.rk4.step`), by two half steps at a time. Heading,
roll angle and path are integrals over the state, computed with fourth order by Simpson's rule over the three states.
"""

import math

from kernels.disk import motion_arrays as motion_row
from kernels.disk.arrays import ALPHA, GRAVITY, PRECESSION_RATE, RADIUS, ROLL_RATE, TILT, TILT_RATE
from kernels.disk.contact import contact_forces, friction_needed, suitable_step, vertical_momentum
from kernels.disk.endings import FELL, HORIZON, UNRESOLVED
from kernels.disk.equations import energy, energy_change, inertia, scaled_state
from kernels.disk.rk4 import land_on_tilt, land_on_turning_point, step, tilt_acceleration
from kernels.jit import kernel
from kernels.native.entry import entry

#: Number of steps after which a motion is abandoned.
_MOST_STEPS = 100_000_000


@kernel
def _rates(state):
    """Return the scaled rates of heading, roll angle, and vertical momentum about the contact point."""
    _, C, T, w, o, s = state
    rolling = s - o * T
    return o / C, rolling, rolling * w * C


@kernel
def _carry(place, before, middle, after, h):
    """Return heading, roll angle, contact point (over R) and momentum gained after a step of scaled length h."""
    heading, angle, x, y, gained = place
    turn_0, roll_0, gain_0 = _rates(before)
    turn_1, roll_1, gain_1 = _rates(middle)
    turn_2, roll_2, gain_2 = _rates(after)
    sixth = h / 6.0
    # halfway: the integral of the parabola through the three rates, of third order, which enters with another factor h
    heading_1 = heading + h * (5.0 * turn_0 + 8.0 * turn_1 - turn_2) / 24.0
    heading_2 = heading + sixth * (turn_0 + 4.0 * turn_1 + turn_2)
    side = roll_0 * math.sin(heading) + 4.0 * roll_1 * math.sin(heading_1) + roll_2 * math.sin(heading_2)
    ahead = roll_0 * math.cos(heading) + 4.0 * roll_1 * math.cos(heading_1) + roll_2 * math.cos(heading_2)
    return (
        heading_2,
        angle + sixth * (roll_0 + 4.0 * roll_1 + roll_2),
        x - sixth * side,
        y + sixth * ahead,
        gained + sixth * (gain_0 + 4.0 * gain_1 + gain_2),
    )


@kernel
def _fall(before, after, constants, fall_tilt, h):
    """Return whether fall_tilt was reached between two states, and the scaled time from the second one back to it."""
    there, elapsed, fell = after, 0.0, not after[1] >= math.cos(fall_tilt)
    if before[3] * after[3] < 0.0:
        there, elapsed = land_on_turning_point(after, constants, 2.0 * h)
        beyond = abs(math.atan2(there[0], there[1])) - fall_tilt
        fell = not beyond < 0.0
        if fell:
            # it turned back only beyond fall_tilt: go back to the passage
            back = -math.sqrt(2.0 * beyond / abs(tilt_acceleration(there, constants)))
            there, elapsed = step(there, constants, back), elapsed + back
    if not fell:
        return False, 0.0
    _, more = land_on_tilt(there, constants, math.copysign(fall_tilt, there[0]), 2.0 * h)
    return True, elapsed + more


@kernel
def _record(samples, i, state, place, unit, radius):
    S, C, T, w, o, s = state
    heading, angle, x, y, gained = place
    samples[TILT, i] = math.atan2(S, C)
    samples[TILT_RATE, i] = w / unit
    samples[PRECESSION_RATE, i] = o / (C * unit)
    samples[ROLL_RATE, i] = (s - o * T) / unit
    samples[motion_row.HEADING, i] = heading
    samples[motion_row.ROLL_ANGLE, i] = angle
    samples[motion_row.CONTACT_X, i] = radius * x
    samples[motion_row.CONTACT_Y, i] = radius * y
    samples[motion_row.MOMENTUM_GAINED, i] = radius * radius / unit * gained


@kernel
def _scaled_column(states, i, unit):
    return scaled_state(
        states[TILT, i], states[TILT_RATE, i], states[PRECESSION_RATE, i], states[ROLL_RATE, i], unit
    )


@entry(
    start="float64[::1]", settings="float64[::1]", times="float64[::1]", samples="float64[:, ::1], written"
)
def trajectory(start, settings, times, samples):
    """Integrate one start and record it at the given times.

    Parameters
    ----------
    start : float64[len(PARAMETERS)]
        |tilt| below fall_tilt.
    settings : float64[len(TRAJECTORY_SETTINGS)]
        For the relative step see `kernels.disk.contact.suitable_step`.
    times : float64[n]
        Increasing, from 0 [s].
    samples : float64[len(SAMPLES), n], written

    Returns
    -------
    (ending, filled, last, steps)
        A code of `kernels.disk.endings`: HORIZON, FELL or UNRESOLVED (not finite, or too many steps); the number of
        columns written; the time [s] of the last column, which after a fall is the moment when fall_tilt was reached;
        the number of steps.
    """
    unit, radius = math.sqrt(start[RADIUS] / start[GRAVITY]), start[RADIUS]
    constants = inertia(start[ALPHA])
    state = scaled_state(start[TILT], start[TILT_RATE], start[PRECESSION_RATE], start[ROLL_RATE], unit)
    given_step, relative_step = (
        settings[motion_row.TRAJECTORY_STEP],
        settings[motion_row.TRAJECTORY_RELATIVE_STEP],
    )
    fall_tilt = settings[motion_row.TRAJECTORY_FALL_TILT]
    place = (0.0, 0.0, 0.0, 0.0, 0.0)
    _record(samples, 0, state, place, unit, radius)
    steps = 0
    for i in range(1, len(times)):
        left = (times[i] - times[i - 1]) / unit
        parts = 2.0
        while parts > 1.0:
            longest = (
                given_step / unit if given_step > 0.0 else suitable_step(state, constants, relative_step)
            )
            parts = max(1.0, math.ceil(left / longest * (1.0 - 1e-12)))
            if not parts + steps <= _MOST_STEPS:
                return UNRESOLVED, i, times[i - 1], steps
            h = left / parts
            middle = step(state, constants, 0.5 * h)
            after = step(middle, constants, 0.5 * h)
            steps += 1
            fell, back = _fall(state, after, constants, fall_tilt, h)
            if fell:
                h += back
                middle = step(state, constants, 0.5 * h)
                after = step(middle, constants, 0.5 * h)
                _record(samples, i, after, _carry(place, state, middle, after, h), unit, radius)
                ending = (
                    FELL
                    if math.isfinite(samples[TILT, i] + samples[motion_row.MOMENTUM_GAINED, i])
                    else UNRESOLVED
                )
                return ending, i + 1, times[i] - unit * (left - h), steps
            place = _carry(place, state, middle, after, h)
            state = after
            left -= h
        _record(samples, i, state, place, unit, radius)
    return HORIZON, len(times), times[-1], steps


@entry(start="float64[::1]", states="float64[:, ::1]", results="float64[:, ::1], written")
def derived(start, states, results):
    """Compute derived quantities of sampled states, integrated by any method.

    Parameters
    ----------
    start : float64[len(PARAMETERS)]
        Tilt and rates are not read.
    states : float64[len(STATE), n]
    results : float64[len(DERIVED), n], written
    """
    alpha, radius, unit = start[ALPHA], start[RADIUS], math.sqrt(start[RADIUS] / start[GRAVITY])
    constants = inertia(alpha)
    S0, C0, _, w0, o0, s0 = _scaled_column(states, 0, unit)
    whole = energy(S0, C0, w0, o0, s0, alpha)
    for i in range(states.shape[1]):
        state = _scaled_column(states, i, unit)
        S, C, _, w, o, s = state
        results[motion_row.DERIVED_ENERGY, i] = energy(S, C, w, o, s, alpha)
        change = energy_change(S, C, w, o, s, S0, C0, w0, o0, s0, alpha)
        results[motion_row.DERIVED_ENERGY_DRIFT, i] = change / whole
        momentum, rate = vertical_momentum(state, alpha)
        results[motion_row.DERIVED_VERTICAL_MOMENTUM, i] = radius * radius / unit * momentum
        results[motion_row.DERIVED_VERTICAL_MOMENTUM_RATE, i] = radius * radius / (unit * unit) * rate
        normal, across, along = contact_forces(state, constants, alpha)
        results[motion_row.DERIVED_NORMAL_FORCE, i] = normal
        results[motion_row.DERIVED_FRICTION_ACROSS, i], results[motion_row.DERIVED_FRICTION_ALONG, i] = (
            across,
            along,
        )
        results[motion_row.DERIVED_FRICTION_NEEDED, i] = friction_needed(normal, across, along)
