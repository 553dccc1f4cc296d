"""The laws of friction and drag, each as a generalised force of the scaled form (`kernels.lossy_disk.equations`).

A dry law's torque is its arm times the normal force n = N/mg of the same instant, which follows from the acceleration
of the centre of mass: n = 1 - (w' S + w^2 C). Viscous friction and drag do not depend on it.

Here dry friction slides: it acts against the signs that the motion had when its mode began. What happens where a rate
vanishes is decided in `kernels.lossy_disk.dry_friction`.

What a variant of the integrator has no law for is not computed: its flags are False there
(`kernels.lossy_disk.integrate`), and the compiler leaves out what follows from them.
"""

import math
from typing import NamedTuple

from kernels.jit import kernel, simd
from kernels.lossy_disk.arrays import BILDSTEN, MOFFATT

#: Whether there is dry and viscous contour friction, rolling and pivoting friction, Moffatt's and Bildsten's drag,
#: and a friction coefficient. What follows one motion knows all laws.
DRY, VISCOUS, ROLLING, PIVOTING, FILM, LAYER, SLIPPING = 7 * (True,)

#: Whether what rolls has two edges, of which it rolls on one until its tilt is 0.
EDGED = False

#: A force that is not there: to add it is left out by the compiler, but x + 0.0 is computed, as x may be -0.0.
NOTHING = -0.0

#: Added to the square of the horizontal turning rate that rolling friction opposes: below it friction holds the disk.
_LEAST_SQUARE = 1.0e-200

#: Least value of 1 - (its square) / (that of the stage before) of the horizontal turning rate that a stage follows.
_LARGEST_CHANGE = -0.5


class Losses(NamedTuple):
    """Coefficients of the laws in scaled form.

    Attributes
    ----------
    contour, rolling, pivoting : float
        Lever arms of dry friction over the radius.
    damping : float
        Viscous contour friction: torque over m g R per unit of the scaled roll rate.
    film : float
        Moffatt's drag: torque over m g R per unit of the roll rate over the cosine of the tilt.
    layer : float
        Bildsten's drag: torque over m g R per unit of the roll rate to the power 3/2.
    """

    contour: float
    damping: float
    rolling: float
    pivoting: float
    film: float
    layer: float


@kernel
def scaled_losses(arms, damping, air, disk, law):
    """Return the `Losses` of a cell.

    Parameters
    ----------
    arms : tuple of 3 floats
        Lever arms of rolling, pivoting and contour friction [m].
    damping : float
        Viscous contour friction [N m s].
    air : tuple of 2 floats
        Viscosity [Pa s] and density [kg m^-3] of the air.
    disk : tuple of 3 floats
        mass [kg], radius [m], gravity [m s^-2].
    law : float
        Law of the drag of air (`kernels.lossy_disk.arrays`).

    Notes
    -----
    On the steady wobble of a uniform disk, where the roll rate at the inclination a is f^2 = 4/a, drag takes the powers
    of Moffatt, Nature 404 (2000) 833: pi mu g R^2 / a^2, and of Bildsten, Phys. Rev. E 66 (2002) 056309:
    4 sqrt(mu rho) g^(5/4) R^(11/4) a^(-5/4). The air knows the motion of a disk and not how its mass is distributed.
    """
    rolling, pivoting, contour = arms
    viscosity, density = air
    mass, radius, gravity = disk
    unit = math.sqrt(radius / gravity)
    film = 0.25 * math.pi * viscosity * radius * unit / mass if law == MOFFATT else 0.0
    layer = math.sqrt(0.5 * viscosity * density * unit) * radius * radius / mass if law == BILDSTEN else 0.0
    # without viscous friction the mass may be unknown
    viscous = damping * unit / (mass * radius * radius) if damping > 0.0 else 0.0
    return Losses(contour / radius, viscous, rolling / radius, pivoting / radius, film, layer)


class Load(NamedTuple):
    """What the normal force n = level - i_tilt S torque depends on, with the torque that accelerates the tilt.

    In this form the friction that n causes is one fused operation behind the torque: a step waits for it four times.

    Attributes
    ----------
    level : float
        n without acceleration of the tilt, 1 - w^2 C.
    S, i_tilt : float
        Sine of the tilt; 1/(1 + alpha/2).
    """

    level: float
    S: float
    i_tilt: float


@simd
def normal_force(load, torque):
    """Normal force over m g, with the torque over m g R that accelerates the tilt."""
    return load.level - load.i_tilt * load.S * torque


@simd
def dry_force(f, sense, load, torque, losses):
    """Force that the roll rate f, of the sign `sense`, loses to dry contour friction."""
    if not DRY:
        return 0.0
    most = losses.contour * sense
    return -(most * load.i_tilt * load.S) * torque + most * load.level


@simd
def rub_force(f, dry, losses):
    """Force that the roll rate f loses to dry contour friction, `dry`, and viscous."""
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
    # what is added keeps a quotient finite
    square = (w * w + _LEAST_SQUARE) + across * across
    root = math.sqrt(square)
    return square, root, 1.0 / root


@simd
def horizontal_rate_near(motion, inverse):
    """`horizontal_rate` half a step from a motion with the reciprocal `inverse`, without a root.

    Notes
    -----
    The series of the root about the known one: with the relative change e of the square, which a step keeps below a
    tenth where there is rolling friction, it errs by e^5/4. That is of higher order than a step's own error.
    """
    if not ROLLING:
        return 0.0, 0.0, 0.0
    square, near, e = _change_of_square(motion, inverse)
    # the last products, which a step waits for, are as few as can be
    share = (1.0 + 0.5 * e) + (e * e) * ((0.375 + 0.3125 * e) + 0.2734375 * (e * e))
    return square, near * share, inverse * share


@simd
def _change_of_square(motion, inverse):
    """Square of the horizontal turning rate, and two numbers of it.

    With `inverse`, the reciprocal of a rate near it: square times inverse, and 1 - square times inverse squared, the
    relative change of the square.
    """
    C, w, f = motion
    across = C * f
    square = (w * w + _LEAST_SQUARE) + across * across
    near = square * inverse
    e = 1.0 - near * inverse
    # A motion with rolling friction has no larger change. Without it what is cut keeps all numbers finite.
    return square, near, e if e > _LARGEST_CHANGE else _LARGEST_CHANGE


@simd
def rolling_friction(motion, turning, free, load, arm, weight):
    """What rolling friction does to the tilt and to the roll rate.

    Parameters
    ----------
    motion : tuple of 3 floats
        C, w, f.
    turning : tuple of 3 floats
        Of `horizontal_rate`.
    free : float
        Torque over m g R that accelerates the tilt without rolling friction.
    load : Load
    arm : float
        Lever arm over the radius.
    weight : float
        What the force is multiplied by.

    Returns
    -------
    (torque, slowed, power, force, reciprocal)
        The torque with it; its own torque over the horizontal turning rate; the power that is lost; the force that the
        roll rate loses, times `weight`; the reciprocal of what `slowed` was divided by.

    Notes
    -----
    The torque opposes the horizontal turning rate (w, C f). By its part along w it changes the acceleration of the
    tilt, on which the normal force depends: n (1 - i_tilt S arm w/|(w, C f)|) = level - i_tilt S free.
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
    """`rolling_friction` where the motion is that of `before` but for a change of the second order of a step.

    `before` has the horizontal turning rate, its reciprocal, `slowed` and the reciprocal of what that was divided by.

    Notes
    -----
    One of Heron's and one of Newton's corrections: root and quotient err by the square of the change, which is of the
    order of a step's own error.
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
    """Force that the roll rate f loses to the drag of air, by either law, and the root of |f| in Bildsten's.

    `place` is S, C, T of the tilt.
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
    """`drag` next to the roll rate `before` with the drag `blow`, without a root.

    Notes
    -----
    Two stages in the middle of a step differ by its second order. So a force that is linear about the first errs by the
    fourth order of the second, which is of the order of the step's own error. Where `before` is 0 it is 0 as well.
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
    """How the force that viscous friction and drag take from a roll rate f grows with it; `place` as of `drag`."""
    S, C, T = place
    found = losses.damping
    if FILM:
        found = found + losses.film * (C + S * T)
    if LAYER:
        found = found + 1.5 * losses.layer * math.sqrt(abs(f))
    return found


@simd
def pivoting_force(state, changes, normal, sense, inertia, arm):
    """Force of pivoting friction on the turning rate about the vertical v = o C + s S.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, w, o, p.
    changes : tuple of 2 floats
        o' and p' without it.
    normal : float
        Normal force over m g.
    sense : float
        Sign of v, or 0 where friction holds it at zero.
    inertia : kernels.lossy_disk.rk4.Inertia
    arm : float
        Lever arm over the radius.

    Notes
    -----
    Where friction holds, its force is what keeps v' = 0. With w, o', p' and the arm multiplied by a number, so is the
    force.
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
    """Return o', p' and the power that is lost, with the `pivoting_force`; parameters as there."""
    if not PIVOTING:
        return changes[0], changes[1], 0.0
    S, C, _, o, p = state
    do, dp = changes
    v = o * C + inertia.i_inverse * p * S
    return do + inertia.inverse_spin * C * force, dp + S * force, -force * v * abs(sense)
