"""The laws of friction and drag, each as a generalised force in the scaled form (`kernels.lossy_disk.equations`).

Their coefficients are in `kernels.lossy_disk.loss_coefficients`.

The torque of a dry law is its arm times the instantaneous normal force n = N/mg, which follows from the acceleration
of the centre of mass: n = 1 - (w' S + w^2 C). Viscous friction and drag do not depend on it.

Here dry friction slides: it opposes the signs that the rates had at the beginning of the leg.
`kernels.lossy_disk.dry_friction` decides what happens when a rate vanishes.

A variant of the integrator does not compute laws that it does not have: their flags are False
(`kernels.lossy_disk.integrate`), and the compiler removes the code that depends on them.
"""

import math
from typing import NamedTuple

from kernels.jit import simd
from kernels.lossy_disk.arrays import BILDSTEN, MOFFATT, NONE

#: Flags of dry and viscous contour friction, rolling and pivoting friction, Moffatt's and Bildsten's drag, drag by any
#: law, and a finite friction coefficient. Kernels that follow a single motion have all laws.
DRY, VISCOUS, ROLLING, PIVOTING, FILM, LAYER, AIR, SLIPPING = 8 * (True,)

#: Law of the drag of air -> the flag of its force.
FLAG_OF_LAW = {NONE: "", MOFFATT: "FILM", BILDSTEN: "LAYER"}

#: Whether the body has two edges, and rolls on one of them until its tilt is 0.
EDGED = False

#: A missing force. The compiler removes the addition of -0.0, but not x + 0.0, which changes x = -0.0.
NOTHING = -0.0

#: Added to the square of the horizontal turning rate; below its root, rolling friction holds the disk.
_LEAST_SQUARE = 1.0e-200

#: Lower limit of the relative change of the squared horizontal turning rate between stages that the series allows for.
_LARGEST_CHANGE = -0.5


class Load(NamedTuple):
    """The dependence of the normal force on the torque that accelerates the tilt: n = level - i_tilt S torque.

    In this form the friction caused by n is one fused operation after the torque; a step waits for it four times.

    Attributes
    ----------
    level : float
        n without tilt acceleration, 1 - w^2 C.
    S, i_tilt : float
        Sine of the tilt; 1/(1 + alpha/2).
    """

    level: float
    S: float
    i_tilt: float


@simd
def normal_force(load, torque):
    """Return the normal force over m g, from the torque over m g R that accelerates the tilt."""
    return load.level - load.i_tilt * load.S * torque


@simd
def dry_force(f, sense, load, torque, losses):
    """Return the force of dry contour friction against the roll rate f, which has the sign `sense`."""
    if not DRY:
        return 0.0
    most = losses.contour * sense
    return -(most * load.i_tilt * load.S) * torque + most * load.level


@simd
def rub_force(f, dry, losses):
    """Return the force of dry contour friction, `dry`, and viscous contour friction against the roll rate f."""
    if DRY and VISCOUS:
        return dry + losses.damping * f
    if VISCOUS:
        return losses.damping * f
    return dry if DRY else NOTHING


@simd
def horizontal_rate(motion):
    """Return the square of the horizontal turning rate (w, C f) of a motion (C, w, f), the rate and its reciprocal."""
    if not ROLLING:
        return 0.0, 0.0, 0.0
    C, w, f = motion
    across = C * f
    # the small constant keeps a quotient finite
    square = (w * w + _LEAST_SQUARE) + across * across
    root = math.sqrt(square)
    return square, root, 1.0 / root


@simd
def horizontal_rate_near(motion, inverse):
    """Return `horizontal_rate` half a step from a motion with the reciprocal `inverse`, without a square root.

    Notes
    -----
    The series of the root about the known value. The relative change e of the square is below a tenth in a step with
    rolling friction, and the error is e^5/4, of higher order than the step's own error.
    """
    if not ROLLING:
        return 0.0, 0.0, 0.0
    square, near, e = _change_of_square(motion, inverse)
    # as few operations as possible after e, because the step waits for them
    share = (1.0 + 0.5 * e) + (e * e) * ((0.375 + 0.3125 * e) + 0.2734375 * (e * e))
    return square, near * share, inverse * share


@simd
def _change_of_square(motion, inverse):
    """Return the square of the horizontal turning rate, the square times `inverse`, and its relative change.

    `inverse` is the reciprocal of a nearby rate, and the relative change is 1 - square * inverse^2.
    """
    C, w, f = motion
    across = C * f
    square = (w * w + _LEAST_SQUARE) + across * across
    near = square * inverse
    e = 1.0 - near * inverse
    # With rolling friction, no change is larger. Without it, the limit keeps all numbers finite.
    return square, near, e if e > _LARGEST_CHANGE else _LARGEST_CHANGE


@simd
def rolling_friction(motion, turning, free, load, arm, weight):
    """Return the effect of rolling friction on the tilt and on the roll rate.

    Parameters
    ----------
    motion : tuple of 3 floats
        C, w, f.
    turning : tuple of 3 floats
        As returned by `horizontal_rate`.
    free : float
        Torque over m g R that accelerates the tilt without rolling friction.
    load : Load
    arm : float
        Lever arm over the radius.
    weight : float
        Factor of the returned force.

    Returns
    -------
    (torque, slowed, power, force, reciprocal)
        The torque on the tilt including rolling friction; its own torque over the horizontal turning rate; the power
        lost; the force against the roll rate, times `weight`; the reciprocal of the divisor of `slowed`.

    Notes
    -----
    The torque opposes the horizontal turning rate (w, C f). Its component along w changes the acceleration of the
    tilt, which in turn changes the normal force: n (1 - i_tilt S arm w/|(w, C f)|) = level - i_tilt S free.
    """
    if not ROLLING:
        return free, 0.0, 0.0, NOTHING, 0.0
    C, w, f = motion
    square, root, _ = turning
    lean = arm * load.i_tilt * load.S
    reciprocal = 1.0 / (root - lean * w)
    slowed = (-lean * free + arm * load.level) * reciprocal
    return free - slowed * w, slowed, slowed * square, slowed * (weight * C * (C * f)), reciprocal


@simd
def rolling_friction_near(motion, before, free, load, arm, weight):
    """Return `rolling_friction` if the motion differs from that of `before` only by second order in the step.

    `before` contains the horizontal turning rate, its reciprocal, `slowed` and the reciprocal of the divisor of
    `slowed`.

    Notes
    -----
    One correction of Heron's method and one of Newton's: root and quotient have errors of the square of the change,
    which is of the order of the step's own error.
    """
    if not ROLLING:
        return free, 0.0, 0.0, NOTHING
    C, w, f = motion
    root, inverse, slowed, reciprocal = before
    across = C * f
    square = w * w + across * across
    lean = arm * load.i_tilt * load.S
    wanting = (-lean * free + arm * load.level) - slowed * (
        (0.5 * root + 0.5 * (square * inverse)) - lean * w
    )
    slowed = slowed + wanting * reciprocal
    return free - slowed * w, slowed, slowed * square, slowed * (weight * C * across)


@simd
def drag(f, place, losses):
    """Return the force of air drag against the roll rate f, by either law, and for Bildsten's law the root of |f|.

    `place` is S, C, T.
    """
    S, C, T = place
    root = math.sqrt(abs(f)) if LAYER else 0.0
    if FILM and LAYER:
        return (losses.film * f) * (C + S * T) + (losses.layer * f) * root, root
    if FILM:
        return (losses.film * f) * (C + S * T), 0.0
    return (losses.layer * f) * root if LAYER else NOTHING, root


@simd
def drag_near(f, place, losses, before, blow):
    """Return `drag` near the roll rate `before` with the drag `blow`, without a square root.

    Notes
    -----
    Two stages in the middle of a step differ by second order in the step. So a force linearised about the first stage
    has an error of fourth order at the second stage, which is of the order of the step's own error. If `before` is 0,
    so is the result.
    """
    S, C, T = place
    if FILM and LAYER:
        return (losses.film * f) * (C + S * T) + (losses.layer * blow[1]) * (1.5 * f - 0.5 * before), blow[1]
    if FILM:
        return (losses.film * f) * (C + S * T), 0.0
    if LAYER:
        return (losses.layer * blow[1]) * (1.5 * f - 0.5 * before), blow[1]
    return NOTHING, 0.0


@simd
def viscosity(f, place, losses):
    """Return d/df of the force of viscous friction and drag against the roll rate f; `place` as for `drag`."""
    S, C, T = place
    found = losses.damping
    if FILM:
        found = found + losses.film * (C + S * T)
    if LAYER:
        found = found + 1.5 * losses.layer * math.sqrt(abs(f))
    return found


@simd
def pivoting_force(state, changes, normal, sense, inertia, arm):
    """Return the force of pivoting friction on the turning rate about the vertical v = o C + s S.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, w, o, p.
    changes : tuple of 2 floats
        o' and p' without this force.
    normal : float
        Normal force over m g.
    sense : float
        Sign of v, or 0 if friction holds it at zero.
    inertia : kernels.lossy_disk.rk4.Inertia
    arm : float
        Lever arm over the radius.

    Notes
    -----
    If friction holds, its force keeps v' = 0. Multiplying w, o', p' and the arm by the same number multiplies the
    force by it.
    """
    if not PIVOTING:
        return 0.0
    S, C, w, o, p = state
    do, dp = changes
    s, inverse = inertia.i_inverse * p, inertia.i_inverse * S
    free = do * C + dp * inverse + w * (s * C - o * S)
    held = -free / ((inertia.inverse_spin * C) * C + inverse * S)
    return held if sense == 0.0 else -arm * normal * sense


@simd
def pivoting_friction(state, changes, force, sense, inertia):
    """Return o', p' and the power lost, including `pivoting_force`; parameters as there."""
    if not PIVOTING:
        return changes[0], changes[1], 0.0
    S, C, _, o, p = state
    do, dp = changes
    v = o * C + inertia.i_inverse * p * S
    return do + inertia.inverse_spin * C * force, dp + S * force, -force * v * abs(sense)
