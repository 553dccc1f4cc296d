"""The drift of the invariants of a motion, and the error of its tilt that follows from it."""

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

#: The estimate is of first order: a state that has lost more energy (of m g R) than this has no error estimate.
MOST_LOSS = 1.0e-3

#: Share of the rounding bound in the stated error: with it, the true error exceeds twice the stated error in fewer
#: than one in a thousand of a million random cells.
_ROUNDING_SHARE = 0.25

#: Uncertainty of the energy over the drift of the invariants. It is larger for other bodies, whose linear system
#: drifts more than the energy shows (`kernels.bodies.integrate`).
_UNSEEN = 1.0

#: Error of the work of a motion of small amplitude, over (step times fastest rate)^4. In one step, Runge-Kutta
#: changes the amplitude of an oscillation by 1/144 of the fifth power, and an exponential growth by 1/120.
_METHOD_SHARE = 1.0 / 64.0

#: Rounding error of a sum or a product along a motion, over its terms and the root of the number of steps.
_RELATIVE_ROUNDING = 8.0 * EPS


@simd
def drift(state, start, whole, alpha, constants, steps):
    """Return the drift of the invariants of a state since its start.

    Parameters
    ----------
    state : tuple of 6 floats
    start : tuple of 5 floats
        S, C, w, o, s of the start.
    whole, alpha : float
        Energy of the start over m g R; mass distribution.
    constants : tuple of floats
    steps : float
        Number of steps since the start.

    Returns
    -------
    (lost, doubt, rounding, change)
        In units of m g R: the sum of the drifts, which decides whether a step is short enough; the largest difference
        between the energy of the true motion at this tilt and the energy of the state; the part of `lost` that
        rounding explains; the energy change.

    Notes
    -----
    Energy, S^2 + C^2 = 1 and T = S/C are independent measures: the energy error may pass through zero, but not all
    three at once. The latter two are errors of an angle. The rates o and s follow the tilt by Chaplygin's linear
    system, so that their relative errors are equal to that angle, and the error of their energy is the angle times
    their squares. (The two constants of motion of that system would need its solutions.) Rounding alone changes each
    measure by about eps*sqrt(steps) of its terms, and the energy of the rates by up to three times that (fast disks
    at 1e-6 rad).
    """
    S, C, T, _, o, s = state
    change = abs(energy_gained(state, start, constants, alpha))
    circle, tangent = abs((S - 1.0) * (S + 1.0) + C * C), abs(T * C - S)
    doubt = change + (circle + tangent) * (1.0 + o * o + s * s)
    rounding = EPS * math.sqrt(steps + 4.0) * (2.0 + 4.0 * (whole - height(start[0], start[1], constants)))
    return change + circle + tangent, doubt, rounding, change


@simd
def uncertain_energy(drifts, state, start, constants, h, tilt_change, steps):
    """Return the largest difference between the energies (of m g R) of the true motion and a state at the same tilt.

    Parameters
    ----------
    drifts : tuple of 4 floats
        As returned by `drift`.
    state : tuple of 6 floats
    start : tuple of 5 floats
        S, C, w, o, s of the start.
    constants : tuple of floats
    h : float
        Scaled step over cos(tilt).
    tilt_change : float
        Magnitude of the change of the tilt, or of its sine, since the start.
    steps : float

    Returns
    -------
    float

    Notes
    -----
    The drift includes the rounding of the rates, which is of the order of eps even if the tilt hardly changes. But a
    constant error of the rates shifts the potential as a whole. What matters is the error of the work: h^4 of the
    exchanged energies for the method; the error of the force times the change of the tilt for rounding and for wrong
    rates. If this is less than the drift (motions of small amplitude), it is returned instead.
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
    """Return the errors [rad] of the final tilt that follow from the drift of the invariants, or infinity.

    Parameters
    ----------
    ending : int
        BOUNDED for a turning point.
    state : tuple of 6 floats
    drifts : tuple of 4 floats
        As returned by `drift`.
    uncertain : float
        As returned by `uncertain_energy`.
    constants : tuple of floats

    Returns
    -------
    (estimate, stated)
        The error that decides whether the step is short enough, and the error that is stated for the result.

    Notes
    -----
    At a turning point, an energy over the force of the potential is an angle. The estimate excludes the part
    explained by rounding, because a shorter step does not reduce it. Elsewhere the divisor is the larger one of force
    and speed.
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
        # the energy left is less than its uncertainty: the disk may have turned before
        if ending in (FELL, EDGE_CHANGE) and left <= 2.0 * uncertain:
            return math.inf, math.inf
        divisor = max(pull, speed)
        return beyond / divisor, uncertain / divisor
    # below a maximum of the potential by less than the drift: the disk may have passed it
    if stiffness < 0.0 and pull * pull <= -8.0 * stiffness * uncertain:
        return math.inf, math.inf
    return (beyond + left) / pull, (uncertain + left) / pull
