"""The derivatives of a sliding body and one step, for the loop over lanes; see `kernels.lossy_disk.rk4`.

The state of a lane is S, C, T, w, o, s. Each stage of a step computes its forces from scratch, with a square root and
a quotient for rolling friction, while a stage of the disk corrects those of the previous stage
(`kernels.lossy_disk.lane_step`).
"""

from typing import NamedTuple

from kernels.jit import simd
from kernels.lossy_bodies.equations import (
    _free_torque,
    _load_of,
    _pushes,
    _twist,
    losses_at,
    own_rate_squared,
    place_at,
)
from kernels.lossy_disk.loss_laws import (
    PIVOTING,
    SLIPPING,
    drag,
    dry_force,
    horizontal_rate,
    normal_force,
    rolling_friction,
    rub_force,
)
from kernels.lossy_disk.rk4 import _moved
from kernels.lossy_disk.simd_stages import SURE_GRIP


class Forces(NamedTuple):
    """`kernels.lossy_disk.rk4.Forces` without fields that only its step uses; `way` is along the circle on the body."""

    f: float
    normal: float
    dry: float
    rub: float
    blow: float
    along: float
    slowed: float
    rolled: float
    held: float
    pivoted: float
    drag: tuple
    near: tuple
    way: float


@simd
def changes(state, sense, body, losses):
    """See `kernels.lossy_disk.rk4.changes`; here the derivative of the tilt rate itself is returned."""
    S, C, T, w, o, s = state
    here = place_at(S, C, T, body)
    laws, twist, oT = losses_at(here.a, losses), _twist(w, o, s, S, here, body), o * T
    f, load = s - oT, _load_of(S, C, w, here, body)
    free = _free_torque((S, C, w, o, s, oT, T), here, body)
    turning = horizontal_rate((C, w, f))
    torque, slowed, rolled, slid, reciprocal = rolling_friction(
        (C, w, f), turning, free, load, laws.rolling, 1.0
    )
    dry = dry_force(f, sense[0], load, torque, laws)
    rub, blow, normal = rub_force(f, dry, laws), drag(f, (S, C, T), laws), normal_force(load, torque)
    along = rub + blow[0] + slid
    do = w * (oT - body.ratio * s) - body.axial * here.b * twist - here.o_roll * along
    ds = -body.transverse * here.a * twist - here.s_roll * along
    held, pivoted = 0.0, 0.0
    if PIVOTING:
        unheld = C * do + S * ds + w * (s * C - o * S)
        most = -laws.pivoting * normal * sense[1]
        held = -unheld / (C * here.o_turn + S * here.s_turn) if sense[1] == 0.0 else most
        do, ds = do + here.o_turn * held, ds + here.s_turn * held
        pivoted = -held * (o * C + s * S) * abs(sense[1])
    near = turning[1], turning[2], slowed, reciprocal
    return (C * w, -(S * w), w + (w * T) * T, here.per * torque, do, ds), Forces(
        f, normal, dry, rub, blow[0], along, slowed, rolled, held, pivoted, blow, near, here.a * f
    )


@simd
def changes_near(state, sense, body, losses, last):
    """See `kernels.lossy_disk.rk4.changes_near`; here the same as `changes`."""
    return changes(state, sense, body, losses)


@simd
def lane_step(state, forces, sense, body, losses, half):
    """See `kernels.lossy_disk.lane_step.lane_step`.

    Notes
    -----
    The caller has already computed the first stage at the same state; the compiler eliminates the repetition.
    """
    total, _ = changes(state, sense, body, losses)
    change, _ = changes(_moved(state, half, total), sense, body, losses)
    total = _moved(total, 2.0, change)
    change, _ = changes(_moved(state, half, change), sense, body, losses)
    total = _moved(total, 2.0, change)
    change, _ = changes(_moved(state, half + half, change), sense, body, losses)
    S, C, T, w, o, s = _moved(state, half * (1.0 / 3.0), _moved(total, 1.0, change))
    return (S, C, S / C if half != 0.0 else T, w, o, s), (forces.near, forces.f, forces.drag)


@simd
def fastest_rate(state, along, body):
    """See `kernels.lossy_disk.step_size.fastest_rate`."""
    S, C, T, w, o, s = state
    steep = body.inverse_spin * T * S
    return C * C * own_rate_squared(S, C, s, body) + (o * o + (w * w + steep * (along * along)))


@simd
def grips(state, change, normal, body, friction):
    """See `kernels.lossy_disk.simd_stages.grips`."""
    if not SLIPPING:
        return True
    S, C, T, w, o, s = state
    _, _, _, tilting, do, ds = change
    here, heading = place_at(S, C, T, body), o * (C + S * T)
    across, along = _pushes((S, C, w, o, s), (tilting, do, ds), heading, here, body)
    most = SURE_GRIP * friction * normal
    return across * across + along * along <= most * most
