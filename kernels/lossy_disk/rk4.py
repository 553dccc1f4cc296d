"""One classical Runge-Kutta step of a disk with losses, with the integrals of the ledger by the same weights."""

from typing import NamedTuple

from kernels.jit import kernel, simd, simd_kernel
from kernels.lossy_disk.loss_laws import contour_friction, drag, pivoting_friction, rolling_friction


class Inertia(NamedTuple):
    """Constants of the equations for one mass distribution: see `inertia`."""

    i_tilt: float
    i_roll: float
    i_spin: float
    i_inverse: float
    drag: float
    inverse_spin: float


@simd_kernel
def inertia(alpha):
    """Return 1/(1 + alpha/2), 1 + alpha, alpha/2, 1/(1 + alpha), 2/(1 + alpha), 2/alpha as `Inertia`."""
    i_inverse = 1.0 / (1.0 + alpha)
    return Inertia(
        1.0 / (1.0 + 0.5 * alpha), 1.0 + alpha, 0.5 * alpha, i_inverse, 2.0 * i_inverse, 2.0 / alpha
    )


class Forces(NamedTuple):
    """What acts at one instant of a sliding motion.

    Attributes
    ----------
    normal : float
        Normal force over m g.
    held : float
        Force of pivoting friction on the turning rate.
    along : float
        Force that the roll rate loses.
    slowed : float
        Torque of rolling friction over the horizontal turning rate.
    """

    normal: float
    held: float
    along: float
    slowed: float


@simd
def rates_and_forces(state, sense, inertia, losses):
    """`rates`, with all `Forces` in the third place."""
    S, C, K, w, o, p = state
    T, turn = S * K, o * K
    oT = turn * S
    f = inertia.i_inverse * p - oT
    pull = S + o * (p - inertia.i_spin * oT)
    dS, minus_dC = C * w, S * w
    weight = 1.0 - (inertia.i_tilt * pull * S + w * dS)
    normal, pull, taken, slowed, rolled = rolling_friction(
        (S, C, w, f), pull, weight, inertia.i_tilt, losses.rolling
    )
    blown = drag(f, K, losses)
    # differences: adding the nothing of a law that a variant lacks would be computed
    along = contour_friction(f, sense[0], normal, losses) - blown - taken
    do = w * (oT - inertia.drag * p) + inertia.inverse_spin * along * T
    do, dp, held, pivoted = pivoting_friction(
        state, (do, -w * o - along), normal, sense[1], inertia, losses.pivoting
    )
    roll = sense[0] * f
    changes = dS, -minus_dC, K * K * minus_dC, inertia.i_tilt * pull, do, dp
    ledger = turn, roll, rolled, pivoted, losses.contour * normal * roll, losses.damping * f * f, -blown * f
    return changes, ledger, Forces(normal, held, along, slowed)


@simd
def rates(state, sense, inertia, losses):
    """How a sliding motion and its ledger change in scaled time.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p (`kernels.lossy_disk.equations`).
    sense : tuple of 2 floats
        Signs of the roll rate and of the turning rate about the vertical; the second is 0 where friction holds that.
    inertia : Inertia
    losses : kernels.lossy_disk.loss_laws.Losses

    Returns
    -------
    (dS, dC, dK, dw, do, dp), (turn, roll, rolling, pivoting, contour, damping, air), (normal, held)
        Derivatives of the state; of heading, path (over R) and of the losses (over m g R); the normal force over m g
        and the force of pivoting friction on the turning rate.
    """
    changes, ledger, forces = rates_and_forces(state, sense, inertia, losses)
    return changes, ledger, (forces.normal, forces.held)


@simd
def _moved(state, h, change):
    """`state` + h * `change`, of six numbers each."""
    S, C, K, w, o, p = state
    dS, dC, dK, dw, do, dp = change
    return S + h * dS, C + h * dC, K + h * dK, w + h * dw, o + h * do, p + h * dp


@simd
def _entered(ledger, h, change):
    """`ledger` + h * `change`, of seven numbers each."""
    a0, a1, a2, a3, a4, a5, a6 = ledger
    b0, b1, b2, b3, b4, b5, b6 = change
    return (
        a0 + h * b0, a1 + h * b1, a2 + h * b2, a3 + h * b3, a4 + h * b4, a5 + h * b5, a6 + h * b6,
    )  # fmt: skip


@simd
def lane_step(state, sense, inertia, losses, half):
    """State after one RK4 step of scaled length 2 `half`, and what its ledger gained; arguments as of `rates`.

    Returns
    -------
    (S, C, K, w, o, p), (turn, roll, rolling, pivoting, contour, damping, air)

    Notes
    -----
    The classical method of order 4 (Kutta 1901); local error O(h^5).
    """
    total, gained, _ = rates(state, sense, inertia, losses)
    return completed_step(state, (total, gained), sense, inertia, losses, half)


@simd
def completed_step(state, first, sense, inertia, losses, half):
    """`lane_step` from `first`, the rates of the state and of its ledger."""
    total, gained = first
    middle, more, _ = rates(_moved(state, half, total), sense, inertia, losses)
    total, gained = _moved(total, 2.0, middle), _entered(gained, 2.0, more)
    middle, more, _ = rates(_moved(state, half, middle), sense, inertia, losses)
    total, gained = _moved(total, 2.0, middle), _entered(gained, 2.0, more)
    last, more, _ = rates(_moved(state, half + half, middle), sense, inertia, losses)
    part = (1.0 / 3.0) * half
    turn, roll, rolling, pivoting, contour, damping, air = _entered(gained, 1.0, more)
    return _moved(state, part, _moved(total, 1.0, last)), (
        part * turn, part * roll, part * rolling, part * pivoting, part * contour, part * damping, part * air,
    )  # fmt: skip


@kernel
def step(state, sense, inertia, losses, h):
    """`lane_step` of length h (scaled; may be negative) for one trajectory."""
    return lane_step(state, sense, inertia, losses, 0.5 * h)
