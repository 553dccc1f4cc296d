"""How far the invariants of a motion have drifted, and the error of its tilt that follows from that."""

import math

from kernels.disk.endings import BOUNDED
from kernels.disk.equations import energy_change, force
from kernels.jit import simd

#: Distance from 1 to the next double.
EPS = 2.0**-52

#: The estimate is of first order: a state that has lost more than this (of m g R) has no error estimate.
MOST_LOSS = 1.0e-3


@simd
def loss(state, start, whole, alpha, steps):
    """Drift of the invariants of a state (unit m g R); the part of it that rounding explains; the energy change alone.

    `start` is (S, C, w, o, s) of the motion's start, `whole` its energy.
    Energy, S^2 + C^2 = 1 and T = S/C are independent measures: where the energy error happens to pass through zero the
    others do not. Rounding alone moves each of them by about eps*sqrt(steps) of its terms, and the part of the energy
    that the rates hold by up to three times that (fast disks at 1e-6 rad).
    """
    S, C, T, w, o, s = state
    S0, C0, w0, o0, s0 = start
    change = abs(energy_change(S, C, w, o, s, S0, C0, w0, o0, s0, alpha))
    lost = change + abs((S - 1.0) * (S + 1.0) + C * C) + abs(T * C - S)
    return lost, EPS * math.sqrt(steps + 4.0) * (2.0 + 4.0 * (whole - C0)), change


@simd
def estimated_error(ending, state, lost, rounding, constants):
    """Error [rad] of the tilt reached, estimated from the drift of the invariants; infinite where that is not possible.

    At a turning point: the drift beyond rounding, and the kinetic energy that is left there, over the force of the
    potential. Against exact turning points the ratio of true to estimated error stays below 1.1 in the presets and
    below 10 over random starts but for fast disks (see `kernels.disk.leg_control`). Elsewhere the larger of force and
    speed is the divisor.
    """
    if not lost <= MOST_LOSS:
        return math.inf
    pull, stiffness = force(state, constants)
    speed = abs(state[3])
    # not max(0, ...), which would turn a NaN into zero
    beyond = 0.0 if lost <= rounding else lost - rounding
    if ending != BOUNDED:
        return beyond / max(pull, speed)
    # below a maximum of the potential by less than the drift: the disk may have passed it
    if stiffness < 0.0 and pull * pull <= -8.0 * stiffness * (lost + rounding):
        return math.inf
    return (beyond + 0.5 * speed * speed / constants[0]) / pull
