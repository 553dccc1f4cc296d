"""The settings of a run in the form used by the kernels, and the step length of a motion with losses."""

import math
from typing import NamedTuple

from kernels.jit import kernel, simd
from kernels.lossy_disk import arrays as row
from kernels.lossy_disk.loss_laws import AIR, ROLLING, VISCOUS

#: Step over the shortest time scale of the present state, at a tolerance of 1e-8 of the energy balance.
RELATIVE_STEP = 0.06

#: Weight of the square of the relaxation rate by viscous friction in the square of the fastest rate.
_SHARE_OF_RELAXING = 1.0 / 16.0

#: Added to the square of a rate in a denominator.
_LEAST_SQUARE = 1.0e-200


class RunSettings(NamedTuple):
    """Settings of a run (`kernels.lossy_disk.arrays.SETTINGS`), cos(flat_tilt), and the step over the time scale."""

    duration: float
    step: float
    flat_tilt: float
    tolerance: float
    limited: float
    limit: float
    from_start: float
    air_law: float
    cos_flat_tilt: float
    relative_step: float


@kernel
def prepared_settings(settings):
    """Return the `RunSettings` of float64[len(SETTINGS)] settings.

    The step is proportional to the fourth root of the tolerance, because the global error is of fourth order.
    """
    relative_step = RELATIVE_STEP * math.sqrt(math.sqrt(settings[row.TOLERANCE] * 1.0e8))
    return RunSettings(
        settings[row.DURATION], settings[row.STEP], settings[row.FLAT_TILT], settings[row.TOLERANCE],
        settings[row.LIMITED], settings[row.LIMIT], settings[row.FROM_START], settings[row.AIR_LAW],
        math.cos(settings[row.FLAT_TILT]), relative_step,
    )  # fmt: skip


@simd
def fastest_rate(state, along, inertia):
    """Return the square of the fastest rate of a motion, times cos(tilt)^2, without rolling and viscous friction.

    Parameters
    ----------
    state : tuple of 6 floats
    along : float
        Force of friction and drag against the roll rate.
    inertia : kernels.lossy_disk.rk4.Inertia

    Notes
    -----
    The rates of the linearised motion; near flat the fastest is the precession. If the force along the rim changes o
    faster, it contributes (o'/o)^2, with the o of the steady wobble, o^2 = 2 C/alpha.
    """
    S, C, T, w, o, p = state
    rolling = inertia.i_tilt * inertia.drag
    steep = inertia.inverse_spin * T * S
    slow = C * C * (inertia.i_tilt + rolling * (p * p))
    return slow + (o * o + (w * w + steep * (along * along)))


@simd
def faster_by_viscosity(fastest, state, viscous, inverse_spin):
    """Return `fastest_rate` including a force against the roll rate with the derivative `viscous`.

    The roll rate relaxes at the rate viscous * (2 T^2/alpha + ...). If nothing else is fast, Runge-Kutta can follow
    the relaxation with longer steps.
    """
    if not (VISCOUS or AIR):
        return fastest
    S, C, T, _, _, _ = state
    steep = inverse_spin * T * S
    return fastest + (_SHARE_OF_RELAXING * (viscous * viscous)) * (C * C + steep * steep)


@simd
def faster_by_rolling_friction(fastest, state, change, forces, inertia, arm):
    """Return `fastest_rate` including rolling friction, which opposes the horizontal turning rate (w, C f).

    Parameters
    ----------
    fastest : float
    state, change : tuple of 6 floats
        S, C, T, w, o, p, and their derivatives (`kernels.lossy_disk.rk4.changes`).
    forces : kernels.lossy_disk.rk4.Forces
    inertia : kernels.lossy_disk.rk4.Inertia
    arm : float
        Lever arm of rolling friction over the radius.

    Notes
    -----
    Friction itself can change a slow rate fast. And at a turning point of the tilt, a small C f makes the direction
    of (w, C f) swing round in a very short time. A step that misses this has an error of the force which the energy
    shows only in part, because its loss has the same error. The criterion is the total relative change of (w, C f),
    not only the change of its direction: steps have to be short before the swing, because its middle comes as fast as
    the tilt rate vanishes.
    """
    if not ROLLING:
        return fastest
    S, C, T, w, o, _ = state
    dS, minus_S_w, dT, torque, do, dp = change
    f, fast = forces.f, forces.slowed * C
    across = C * f
    swings, rolls = inertia.i_tilt * torque, inertia.i_inverse * dp - (do * T + o * dT)
    changing = C * rolls + minus_S_w * f
    square = (w * w + _LEAST_SQUARE) + across * across
    swinging = swings * swings + changing * changing
    return fastest + (fast * fast + C * C * (swinging / square) if arm > 0.0 else 0.0)


@simd
def half_step(fastest, C, scale, longest):
    """Return half the next step: `scale` over the fastest rate, at most `longest`."""
    half = scale * C / math.sqrt(fastest)
    return half if half < longest else longest  # min() is a call
