"""One motion sampled in time, with the path of the contact point on the plane.

The state advances with the very step of the atlases (`kernels.disk.rk4.step`), two half steps at a time. Heading, roll
angle and path are integrals over the state; Simpson's rule over the three states keeps them of fourth order.
"""

import math

from kernels.disk.contact import contact_forces, friction_needed, suitable_step, vertical_momentum
from kernels.disk.endings import FELL, HORIZON, UNRESOLVED
from kernels.disk.equations import energy, energy_change, inertia, scaled_state
from kernels.disk.rk4 import land_on_tilt, land_on_turning_point, step, tilt_acceleration
from kernels.jit import internal, kernel

#: A motion may not hold its caller for ever.
_MOST_STEPS = 100_000_000


@internal
def _rates(state):
    """Scaled rates of the heading, of the roll angle, and of the vertical momentum about the contact point."""
    _, C, T, w, o, s = state
    rolling = s - o * T
    return o / C, rolling, rolling * w * C


@internal
def _carry(place, before, middle, after, h):
    """Heading, roll angle, contact point (over R) and momentum gained, one step of scaled length h later."""
    heading, angle, x, y, gained = place
    turn_0, roll_0, gain_0 = _rates(before)
    turn_1, roll_1, gain_1 = _rates(middle)
    turn_2, roll_2, gain_2 = _rates(after)
    sixth = h / 6.0
    # half-way: the integral of the parabola through the three rates, third order, which is weighted by another h
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


@internal
def _fall(before, after, constants, fall_tilt, h):
    """(whether fall_tilt was reached between two states, scaled time from the second back to that moment)."""
    there, elapsed, fell = after, 0.0, not after[1] >= math.cos(fall_tilt)
    if before[3] * after[3] < 0.0:
        there, elapsed = land_on_turning_point(after, constants, 2.0 * h)
        beyond = abs(math.atan2(there[0], there[1])) - fall_tilt
        fell = not beyond < 0.0
        if fell:
            # it turned back only beyond fall_tilt: go back to where it passed that
            back = -math.sqrt(2.0 * beyond / abs(tilt_acceleration(there, constants)))
            there, elapsed = step(there, constants, back), elapsed + back
    if not fell:
        return False, 0.0
    _, more = land_on_tilt(there, constants, math.copysign(fall_tilt, there[0]), 2.0 * h)
    return True, elapsed + more


@internal
def _record(samples, i, state, place, unit, radius):
    S, C, T, w, o, s = state
    heading, angle, x, y, gained = place
    samples[0, i] = math.atan2(S, C)
    samples[1, i] = w / unit
    samples[2, i] = o / (C * unit)
    samples[3, i] = (s - o * T) / unit
    samples[4, i] = heading
    samples[5, i] = angle
    samples[6, i] = radius * x
    samples[7, i] = radius * y
    samples[8, i] = radius * radius / unit * gained


@kernel
def trajectory(start, settings, times, samples):
    """Integrate one start and record it at the given times.

    Parameters
    ----------
    start : float64[7]
        Tilt [rad], tilt rate, precession rate, roll rate [rad/s], alpha [1], radius [m], gravity [m/s^2];
        |tilt| below fall_tilt.
    settings : float64[3]
        Longest step [s], 0 for one that follows the state; what that is relative to the fastest frequency of the
        state (`kernels.disk.contact.suitable_step`); fall_tilt [rad].
    times : float64[n]
        Increasing, from 0 [s].
    samples : float64[9, n], written
        Rows: tilt [rad], tilt rate, precession rate, roll rate [rad/s], heading, roll angle [rad], contact point x
        and y [m], vertical momentum gained [m^2/s, per mass]; the last four and the heading from 0.

    Returns
    -------
    (ending, filled, last, steps)
        A code of `kernels.disk.endings`: HORIZON, FELL or UNRESOLVED (not finite, or too many steps); how many columns
        were written; the time [s] of the last one, which after a fall is the moment when fall_tilt was reached; the
        steps made.
    """
    unit, radius = math.sqrt(start[5] / start[6]), start[5]
    constants = inertia(start[4])
    state = scaled_state(start[0], start[1], start[2], start[3], unit)
    place = (0.0, 0.0, 0.0, 0.0, 0.0)
    _record(samples, 0, state, place, unit, radius)
    steps = 0
    for i in range(1, len(times)):
        left = (times[i] - times[i - 1]) / unit
        parts = 2.0
        while parts > 1.0:
            longest = (
                settings[0] / unit if settings[0] > 0.0 else suitable_step(state, constants, settings[1])
            )
            parts = max(1.0, math.ceil(left / longest * (1.0 - 1e-12)))
            if not parts + steps <= _MOST_STEPS:
                return UNRESOLVED, i, times[i - 1], steps
            h = left / parts
            middle = step(state, constants, 0.5 * h)
            after = step(middle, constants, 0.5 * h)
            steps += 1
            fell, back = _fall(state, after, constants, settings[2], h)
            if fell:
                h += back
                middle = step(state, constants, 0.5 * h)
                after = step(middle, constants, 0.5 * h)
                _record(samples, i, after, _carry(place, state, middle, after, h), unit, radius)
                ending = FELL if math.isfinite(samples[0, i] + samples[8, i]) else UNRESOLVED
                return ending, i + 1, times[i] - unit * (left - h), steps
            place = _carry(place, state, middle, after, h)
            state = after
            left -= h
        _record(samples, i, state, place, unit, radius)
    return HORIZON, len(times), times[-1], steps


@kernel
def derived(start, states, results):
    """Compute what follows from sampled states, by whatever method they were integrated.

    Parameters
    ----------
    start : float64[7]
        As in `trajectory`.
    states : float64[4, n]
        Rows: tilt [rad], tilt rate, precession rate, roll rate [rad/s].
    results : float64[8, n], written
        Rows: energy over m g R; its relative change since the first column; vertical angular momentum about the
        contact point over m [m^2/s], and its rate of change over m [m^2/s^2]; normal force, horizontal force across
        and along the track, over m g; friction coefficient needed, NaN where the normal force is not positive.
    """
    alpha, radius, unit = start[4], start[5], math.sqrt(start[5] / start[6])
    constants = inertia(alpha)
    first = scaled_state(states[0, 0], states[1, 0], states[2, 0], states[3, 0], unit)
    S0, C0, _, w0, o0, s0 = first
    whole = energy(S0, C0, w0, o0, s0, alpha)
    for i in range(states.shape[1]):
        state = scaled_state(states[0, i], states[1, i], states[2, i], states[3, i], unit)
        S, C, _, w, o, s = state
        results[0, i] = energy(S, C, w, o, s, alpha)
        results[1, i] = energy_change(S, C, w, o, s, S0, C0, w0, o0, s0, alpha) / whole
        momentum, rate = vertical_momentum(state, alpha)
        results[2, i] = radius * radius / unit * momentum
        results[3, i] = radius * radius / (unit * unit) * rate
        normal, across, along = contact_forces(state, constants, alpha)
        results[4, i], results[5, i], results[6, i] = normal, across, along
        results[7, i] = friction_needed(normal, across, along)
