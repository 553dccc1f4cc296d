"""How far the invariants of a motion have drifted, and the error of its tilt that follows from that."""

import math

from kernels.disk.endings import BOUNDED, EDGE_CHANGE, FELL
from kernels.disk.equations import (
    energy_gained,
    fastest_square,
    force,
    height,
    per_inertia,
    pull_and_terms,
)
from kernels.jit import simd

#: Distance from 1 to the next double.
EPS = 2.0**-52

#: The estimate is of first order: a state that has lost more than this (of m g R) has no error estimate.
MOST_LOSS = 1.0e-3

#: Share of the bound on the rounding that is stated as an error: of a million random cells the true error of fewer
#: than one in a thousand is beyond twice the stated one.
_ROUNDING_SHARE = 0.25

#: The energy that is uncertain over that by which the measures have drifted; of other bodies it is more, whose linear
#: system drifts more than the energy shows (`kernels.bodies.integrate`).
_UNSEEN = 1.0

#: Error of the work of a motion of small amplitude over (step times fastest rate)^4. Runge-Kutta's amplitude of an
#: oscillation changes by 1/144 of the fifth power in a step, its exponential growth by 1/120.
_METHOD_SHARE = 1.0 / 64.0

#: Rounding of a sum or a product along a motion, over its terms and the root of the number of steps.
_RELATIVE_ROUNDING = 8.0 * EPS


@simd
def drift(state, start, whole, alpha, constants, steps):
    """How far the invariants of a state have drifted since its start.

    Parameters
    ----------
    state : tuple of 6 floats
    start : tuple of 5 floats
        S, C, w, o, s of the motion's start.
    whole, alpha : float
        Energy of the start over m g R; mass distribution.
    constants : tuple of floats
    steps : float
        Steps since the start.

    Returns
    -------
    (lost, doubt, rounding, change)
        Unit m g R. The sum of the drifts, which decides whether a step is short enough; how far the energy of the true
        motion at this tilt may differ from the energy of the state; the part of `lost` that rounding explains; the
        energy change alone.

    Notes
    -----
    Energy, S^2 + C^2 = 1 and T = S/C are independent measures: where the energy error happens to pass through zero the
    others do not. The latter two are errors of an angle. The rates o and s follow the tilt by Chaplygin's linear
    system, so that they are wrong by as much of themselves, and the energy that they hold by the angle times their
    squares; their own two constants of the motion need the solutions of that system. Rounding alone moves each measure
    by about eps*sqrt(steps) of its terms, and the part of the energy that the rates hold by up to three times that
    (fast disks at 1e-6 rad).
    """
    S, C, T, _, o, s = state
    change = abs(energy_gained(state, start, constants, alpha))
    circle, tangent = abs((S - 1.0) * (S + 1.0) + C * C), abs(T * C - S)
    doubt = change + (circle + tangent) * (1.0 + o * o + s * s)
    rounding = EPS * math.sqrt(steps + 4.0) * (2.0 + 4.0 * (whole - height(start[0], start[1], constants)))
    return change + circle + tangent, doubt, rounding, change


@simd
def uncertain_energy(drifts, state, start, constants, h, tilt_change, steps):
    """Energy (of m g R) by which the true motion may differ from a state at the same tilt.

    Parameters
    ----------
    drifts : tuple of 4 floats
        What `drift` returns.
    state : tuple of 6 floats
    start : tuple of 5 floats
        S, C, w, o, s of the motion's start.
    constants : tuple of floats
    h : float
        Scaled step over cos(tilt).
    tilt_change : float
        Magnitude of the tilt's change since the start, or of its sine.
    steps : float

    Returns
    -------
    float

    Notes
    -----
    The drift counts the rounding of the rates, which is of the order of eps however little the tilt changes. But an
    error of the rates that does not change shifts the potential as a whole. What counts is the error of the work: of
    the method, h^4 of the energies that the motion exchanges; of rounding and of wrong rates, the error of the force
    times the change of the tilt. Where that is less than the drift (motions of a small amplitude) it is returned
    instead.
    """
    _, doubt, rounding, _ = drifts
    S, C, T, w, _, _ = state
    S0, C0, w0, o0, s0 = start
    pull, terms = pull_and_terms(state, constants)
    pull0, terms0 = pull_and_terms((S0, C0, S0 / C0, w0, o0, s0), constants)
    # the last step passes the turning point
    reach = tilt_change + h * h * per_inertia(S, C, constants) * (pull + pull0)
    fastest = fastest_square(state, constants) + w0 * w0
    share = h * h * fastest
    share *= share * (_METHOD_SHARE + reach * (1.0 + abs(T) + abs(S0 / C0)))
    rounded = _RELATIVE_ROUNDING * math.sqrt(steps + 4.0)
    work = (share + rounded) * (w * w + w0 * w0)
    work += (share * (pull + pull0) + rounded * (terms + terms0) + 2.0 * doubt) * reach
    whole = _UNSEEN * doubt + _ROUNDING_SHARE * rounding
    return work if work < whole else whole  # min() is a call


@simd
def estimated_error(ending, state, drifts, uncertain, constants):
    """Errors [rad] of the tilt reached that follow from the drift of the invariants; infinite where none does.

    Parameters
    ----------
    ending : int
        BOUNDED stands for a turning point.
    state : tuple of 6 floats
    drifts : tuple of 4 floats
        What `drift` returns.
    uncertain : float
        What `uncertain_energy` returns.
    constants : tuple of floats

    Returns
    -------
    (estimate, stated)
        What decides whether the step is short enough, and what is stated as the error of the result.

    Notes
    -----
    At a turning point an energy over the force of the potential is an angle. The estimate leaves out what rounding
    explains, since a shorter step does not help against it. Elsewhere the larger of force and speed is the divisor.
    """
    lost, _, rounding, _ = drifts
    if not lost <= MOST_LOSS:
        return math.inf, math.inf
    pull, stiffness = force(state, constants)
    speed = abs(state[3])
    # not max(0, ...), which would turn a NaN into zero
    beyond = 0.0 if lost <= rounding else lost - rounding
    left = 0.5 * speed * speed / per_inertia(state[0], state[1], constants)
    if ending != BOUNDED:
        # at this tilt with less energy than is uncertain: the disk may have turned before
        if ending in (FELL, EDGE_CHANGE) and left <= 2.0 * uncertain:
            return math.inf, math.inf
        divisor = max(pull, speed)
        return beyond / divisor, uncertain / divisor
    # below a maximum of the potential by less than the drift: the disk may have passed it
    if stiffness < 0.0 and pull * pull <= -8.0 * stiffness * uncertain:
        return math.inf, math.inf
    return (beyond + left) / pull, (uncertain + left) / pull
