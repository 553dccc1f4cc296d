"""One classical Runge-Kutta step of a sliding motion with losses, for the loop over lanes, faster than `rk4`.

Without forces, everything except the tilt rate changes only with the tilt: by a slope times the change of the tilt
(`kernels.disk.rk4`). The contribution of friction and drag to a step is a *push*: their force times the time
and 2/alpha. The slopes are not summed directly; their sum follows from the four states that they led to.

Inside a step the tangent T = S K replaces K = 1/cos(tilt), because its slope takes one multiplication less; then
1/C = C + S T. At the end of the step T is S/C: the quotient takes less time than the sums, and on the way to flat an
error of T would grow like 1/C without showing in the energy.

A square root costs as much as thirty multiplications and changes little from stage to stage: see `loss_laws`.
"""

from typing import NamedTuple

from kernels.jit import simd
from kernels.lossy_disk.loss_coefficients import weighted
from kernels.lossy_disk.loss_laws import (
    LAYER,
    PIVOTING,
    ROLLING,
    drag,
    drag_near,
    dry_force,
    horizontal_rate_near,
    normal_force,
    pivoting_force,
    rolling_friction,
    rolling_friction_near,
    rub_force,
)
from kernels.lossy_disk.rk4 import instant


class Pull(NamedTuple):
    """Forces and slopes of one stage.

    Attributes
    ----------
    f : float
        The roll rate.
    slope : float
        do/dtilt without forces.
    torque : float
        Torque over m g R that accelerates the tilt.
    push, held : float
        Force of all laws against the roll rate, and of pivoting friction on the turning rate, both times the weight.
    blow : tuple of 2 floats
        As returned by `loss_laws.drag`.
    near : tuple of 4 floats
        As used by `loss_laws.rolling_friction_near`.
    """

    f: float
    slope: float
    torque: float
    push: float
    held: float
    blow: tuple
    near: tuple


@simd
def _pull(state, now, laws, near, sense, inertia, losses, weight):
    """Return the `Pull` of a stage; `laws` are its rolling friction and drag, and `losses` are `weighted`."""
    S, C, T, w, o, p = state
    (torque, _, _, slid), blow = laws
    push = rub_force(now.f, dry_force(now.f, sense[0], now.load, torque, losses), losses) + blow[0] + slid
    turned = weight * w
    held = pivoting_force(
        (S, C, turned, o, p),
        (turned * now.slope + inertia.inverse_spin * T * push, -turned * o - push),
        normal_force(now.load, torque), sense[1], inertia, losses.pivoting,
    )  # fmt: skip
    return Pull(now.f, now.slope, torque, push, held, blow, near)


@simd
def _pull_behind(state, before, sense, inertia, losses, weight):
    """Return the `Pull` of a stage half a step after the stage of `before`."""
    now = instant(state, inertia)
    motion = state[1], state[3], now.f
    turning = horizontal_rate_near(motion, before.near[1])
    torque, slowed, rolled, slid, reciprocal = rolling_friction(
        motion, turning, now.free, now.load, losses.rolling, weight
    )
    laws = (torque, slowed, rolled, slid), drag(now.f, state[:3], losses)
    near = turning[1], turning[2], slowed, reciprocal
    return _pull(state, now, laws, near, sense, inertia, losses, weight)


@simd
def _pull_near(state, before, sense, inertia, losses, weight):
    """Return the `Pull` of a stage at the same time as the stage of `before`."""
    now = instant(state, inertia)
    rolling = rolling_friction_near(
        (state[1], state[3], now.f), before.near, now.free, now.load, losses.rolling, weight
    )
    laws = rolling, drag_near(now.f, state[:3], losses, before.f, before.blow)
    return _pull(state, now, laws, before.near, sense, inertia, losses, weight)


@simd
def with_pivoting(rates, state, held, i_spin):
    """Return o and p with the push `held` about the vertical."""
    if not PIVOTING:
        return rates
    o, p = rates
    return o + state[1] * held, p + i_spin * (state[0] * held)


@simd
def _pulled(base, state, pull, times, inertia):
    """Return `base` changed by the slopes of a stage at `state`.

    `times` are the time, the time times i_tilt, and the time over the time of the pushes.
    """
    S0, C0, T0, w0, o0, p0 = base
    S, C, T, w, o, _ = state
    h, turn, share = times
    angle, push = h * w, share * pull.push
    rates = with_pivoting(
        ((o0 + angle * pull.slope) + push * T, (p0 - angle * o) - inertia.i_spin * push),
        state, share * pull.held, inertia.i_spin,
    )  # fmt: skip
    return (
        S0 + angle * C, C0 - angle * S, T0 + angle * (1.0 + T * T), w0 + turn * pull.torque, *rates
    )  # fmt: skip


@simd
def _summed(first, second, third, start):
    """Return the sum of the three states, the second counted twice, minus four times the start, for one component."""
    return ((first + 2.0 * second) + third) - 4.0 * start


@simd
def tangent(S, C, T, half):
    """Return the tangent of the tilt at the end of a step, from T, which still has the error of the step.

    In variants that already compute many roots and quotients, one Newton correction is faster than a quotient. With a
    step of zero the lane keeps its bits.
    """
    if ROLLING or LAYER:
        return T + ((C + S * T) * (S - T * C) if half != 0.0 else 0.0)
    return S / C


@simd
def lane_step(state, forces, sense, inertia, losses, half):
    """Return the state after one RK4 step of scaled length 2 `half`; to be inlined into a vectorised loop over lanes.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, T, w, o, p.
    forces : kernels.lossy_disk.rk4.Forces
        Forces at the state.
    sense, inertia, losses
        As for `kernels.lossy_disk.rk4.changes`.
    half : float
        Half the step in scaled time; may be negative.

    Returns
    -------
    state, last
        The new state, and the values of the last stage from which `changes_near` starts.

    Notes
    -----
    The classical method of order 4 (Kutta 1901); local error O(h^5). With slopes multiplied by half the step, it goes
    from y to y + (k1 + 2 k2 + 2 k3 + k4)/3. With the states y2 = y + k1, y3 = y + k2, y4 = y + 2 k3, this is
    y + (y2 + 2 y3 + y4 - 4 y + k4)/3.
    """
    weight, turn = half * inertia.inverse_spin, half * inertia.i_tilt
    now, later = (half, turn, 1.0), (half + half, turn + turn, 2.0)
    pushing = weighted(losses, weight)
    pull = Pull(
        forces.f, forces.slope, forces.torque, weight * forces.along, weight * forces.held,
        forces.drag, forces.near,
    )  # fmt: skip
    second = _pulled(state, state, pull, now, inertia)
    pull = _pull_behind(second, pull, sense, inertia, pushing, weight)
    third = _pulled(state, second, pull, now, inertia)
    pull = _pull_near(third, pull, sense, inertia, pushing, weight)
    fourth = _pulled(state, third, pull, later, inertia)
    pull = _pull_behind(fourth, pull, sense, inertia, pushing, weight)
    S, C, T, w, o, p = state
    base = (
        _summed(second[0], third[0], fourth[0], S), _summed(second[1], third[1], fourth[1], C),
        _summed(second[2], third[2], fourth[2], T), _summed(second[3], third[3], fourth[3], w),
        _summed(second[4], third[4], fourth[4], o), _summed(second[5], third[5], fourth[5], p),
    )  # fmt: skip
    dS, dC, dT, dw, do, dp = _pulled(base, fourth, pull, now, inertia)
    part = 1.0 / 3.0  # a division would cost a tenth of the step
    S, C = S + part * dS, C + part * dC
    return (
        S, C, tangent(S, C, T + part * dT, half), w + part * dw, o + part * do, p + part * dp
    ), (pull.near, pull.f, pull.blow)  # fmt: skip
