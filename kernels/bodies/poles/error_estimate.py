"""How far the invariants of a ball or a spheroid have drifted, and the error of its tilt that follows from that.

As `kernels.disk.error_estimate`, in the sine of the tilt in place of the tilt, and with energies times C^2: at a pole
these are regular.
"""

import math

from kernels.bodies.ellipse import energy_gained
from kernels.bodies.equations import force, height, per_inertia
from kernels.bodies.poles.equations import (
    begun,
    departure,
    fastest_square,
    is_beside_pole,
    lost_energy,
    sine_pull,
    turning_square,
)
from kernels.disk.endings import BOUNDED
from kernels.disk.error_estimate import _METHOD_SHARE, _RELATIVE_ROUNDING, _ROUNDING_SHARE, EPS, MOST_LOSS
from kernels.jit import simd

#: C^2 above which the gain of the energy is formed from differences.
_FAR = 0.25

#: As of `kernels.disk.error_estimate`, of these bodies: of 12,000 at random the true error was beyond twice the stated
#: one 1 in 1000 times with 2.5; and how much more is uncertain of x, from which the cosine follows beside a pole.
_UNSEEN, _BESIDE_POLE = 5.0, 4.0

#: Share of what is uncertain that counts as error where the drift is less: of 240,000 spheroids at random the extremes
#: were then off by 3e-9 rad at most, by 1e-8 without, for a fifth more steps.
_HIDDEN = 0.6

#: Cosine of the tilt below which the potential has no maximum: x^2/C^2 of it outweighs all else, or a motion without x
#: passes through the pole.
_NO_MAXIMUM = 1e-3


@simd
def _scaled(state):
    """The state as (S, C, T, w, o, s); finite at a pole."""
    S, C, _, y, x, s, _, _ = state
    C = C if C > 1e-12 else 1e-12
    return S, C, S / C, y / C, x / C, s


@simd
def drift(state, start, whole, alpha, constants, steps):
    """See `kernels.disk.error_estimate.drift`; the measures are the energy, times C^2, and n, p and q."""
    S, _, _, y, x, s, _, _ = state
    square = (1.0 - S) * (1.0 + S)
    gained = square * energy_gained(_scaled(state), start, constants, alpha)
    change = abs(gained if square > _FAR else lost_energy(state, constants))
    shape = departure(state, constants)
    doubt = change + shape * (square * (1.0 + s * s) + x * x + y * y)
    rounding = EPS * math.sqrt(steps + 4.0) * (6.0 + 4.0 * (whole - height(start[0], start[1], constants)))
    return change + shape, doubt, rounding, change


@simd
def uncertain_energy(drifts, state, start, constants, h, rise, steps):
    """See `kernels.disk.error_estimate.uncertain_energy`; energies times C^2, `rise` is of the sine of the tilt."""
    _, doubt, rounding, _ = drifts
    S, C, _, y, _, _, _, _ = state
    S0, C0, w0, o0, s0 = start
    pull, terms = sine_pull(state, constants)
    pull0, terms0 = sine_pull(begun(*start, constants), constants)
    reach = rise + h * h * per_inertia(S, C, constants) * (pull + pull0)
    fastest = fastest_square(_scaled(state), constants) + w0 * w0
    share = h * h * fastest
    share *= share * (_METHOD_SHARE + reach)
    rounded = _RELATIVE_ROUNDING * math.sqrt(steps + 4.0)
    work = (share + rounded) * (y * y + C0 * C0 * w0 * w0)
    work += (share * (pull + pull0) + rounded * (terms + terms0) + 2.0 * doubt) * reach
    whole = _UNSEEN * doubt + _ROUNDING_SHARE * rounding
    return work if work < whole else whole  # min() is a call


@simd
def estimated_error(ending, state, drifts, uncertain, constants):
    """See `kernels.disk.error_estimate.estimated_error`; a pole is no place where a motion ends."""
    lost, _, rounding, _ = drifts
    if not lost <= MOST_LOSS:
        return math.inf, math.inf
    S, C, n, y, x, s, _, _ = state
    pull, _ = sine_pull(state, constants)
    turning = turning_square(S, x, s, n, constants)
    # the angle per change of the sine: beside a pole the cosine follows from x, not from the sine
    least = turning if turning < 1.0 else 1.0
    divisor = math.sqrt(least) / _BESIDE_POLE if is_beside_pole(S, turning) else C
    beyond = 0.0 if lost <= rounding else lost - rounding
    left = 0.5 * y * y / per_inertia(S, C, constants)
    if ending != BOUNDED:
        speed = abs(y)
        divisor *= pull if pull > speed else speed
        return beyond / divisor, uncertain / divisor
    slope, stiffness = force(_scaled(state), constants)
    # below a maximum of the potential by less than the drift: the body may have passed it
    beside = slope * slope * C * C <= -8.0 * stiffness * uncertain
    if C > _NO_MAXIMUM and stiffness < 0.0 and beside:
        return math.inf, math.inf
    divisor *= pull
    # between turning points that mirror one another the energy drifts to and fro, the tilts do not; shorter steps
    # leave what is rounding
    hidden = _HIDDEN * (uncertain - _ROUNDING_SHARE * rounding)
    beyond = beyond if beyond > hidden else hidden
    return (beyond + left) / divisor, (uncertain + left) / divisor
