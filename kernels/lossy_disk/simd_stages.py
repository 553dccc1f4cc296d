"""The vector stages of a cell with losses (`kernels.lanes.interface`): scaling its start, setting off, one step.

The functions work on one lane of the flat array of `kernels.lossy_disk.layout` and are inlined into loops over all
lanes. Every leg is a sliding motion: dry friction acts against signs that do not change.

The functions with an alternative that does nothing are parts of a variant (`kernels.lossy_disk.integrate`).
"""

import math

from kernels.disk.equations import energy, scaled
from kernels.jit import simd
from kernels.lossy_disk import layout as at
from kernels.lossy_disk.equations import roll_rate, turning_rate
from kernels.lossy_disk.loss_laws import Losses
from kernels.lossy_disk.rk4 import Inertia, completed_step, inertia, rates_and_forces
from kernels.lossy_disk.step_size import half_step, hurry, hurry_by_rolling_friction
from kernels.simd_math import sine_cosine

#: A turning point belongs to the nearest end of a step: that is this share of the step away at most.
_NEAREST = 0.55

#: Least half step over the duration: a motion that asks for shorter steps is abandoned.
_SHORTEST = 1.0e-10

#: Square of the scaled horizontal turning rate at which a leg with rolling friction ends: the disk is about to be held.
_ALL_BUT_HELD = 1.0e-16


@simd
def inertia_of(lane, lanes):
    """Return the constants of the equations of a lane."""
    return Inertia(
        lanes[at.I_TILT + lane], lanes[at.I_ROLL + lane], lanes[at.I_SPIN + lane],
        lanes[at.I_INVERSE + lane], lanes[at.DRAG + lane], lanes[at.INVERSE_SPIN + lane],
    )  # fmt: skip


@simd
def losses_of(lane, lanes):
    """Return the coefficients of the laws of a lane."""
    return Losses(
        lanes[at.CONTOUR + lane], lanes[at.DAMPING + lane], lanes[at.ROLLING + lane],
        lanes[at.PIVOTING + lane], lanes[at.FILM + lane], lanes[at.LAYER + lane],
    )  # fmt: skip


@simd
def state_of(lane, lanes):
    """Return the state of a lane."""
    return (
        lanes[at.S + lane], lanes[at.C + lane], lanes[at.K + lane],
        lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane],
    )  # fmt: skip


@simd
def sense_of(lane, lanes):
    """Return the signs of the roll rate and of the turning rate about the vertical of a lane's leg."""
    return lanes[at.ROLL_SENSE + lane], lanes[at.TURN_SENSE + lane]


@simd
def prepare(lane, run, lanes):
    """Scale the start, which `read_start` left in SI units and without trigonometry, and begin there."""
    alpha, unit, tilt = lanes[at.ALPHA + lane], lanes[at.UNIT + lane], lanes[at.S_0 + lane]
    tilt_rate, precession_rate = lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane]
    S, C = sine_cosine(tilt)
    _, _, _, w, o, s = scaled(S, C, tilt_rate, precession_rate, lanes[at.P_0 + lane], unit)
    of_disk = inertia(alpha)
    lanes[at.I_TILT + lane], lanes[at.I_ROLL + lane] = of_disk.i_tilt, of_disk.i_roll
    lanes[at.I_SPIN + lane], lanes[at.I_INVERSE + lane] = of_disk.i_spin, of_disk.i_inverse
    lanes[at.DRAG + lane], lanes[at.INVERSE_SPIN + lane] = of_disk.drag, of_disk.inverse_spin
    lanes[at.S_0 + lane], lanes[at.C_0 + lane], lanes[at.W_0 + lane] = S, C, w
    lanes[at.O_RATE_0 + lane], lanes[at.P_0 + lane] = o, of_disk.i_roll * s
    lanes[at.ENERGY_0 + lane] = energy(S, C, w, o, s, alpha)
    longest = 0.5 * run.step / unit if run.step > 0.0 else math.inf
    lanes[at.SCALE + lane], lanes[at.LONGEST + lane] = 0.5 * run.relative_step, longest
    lanes[at.END + lane] = run.duration / unit
    lanes[at.SHORTEST + lane] = _SHORTEST * (run.duration / unit)
    lanes[at.REFINED + lane], lanes[at.FAILED + lane] = 0.0, math.nan
    begin(lane, lanes)


@simd
def begin(lane, lanes):
    """Let the next leg be the first one."""
    S, C, w = lanes[at.S_0 + lane], lanes[at.C_0 + lane], lanes[at.W_0 + lane]
    o, p = lanes[at.O_RATE_0 + lane], lanes[at.P_0 + lane]
    i_inverse, K = lanes[at.I_INVERSE + lane], 1.0 / C
    low, high = lanes[at.LOW_0 + lane], lanes[at.HIGH_0 + lane]
    state = S, C, K, w, o, p
    lanes[at.LEG_S + lane], lanes[at.LEG_C + lane], lanes[at.LEG_K + lane] = S, C, K
    lanes[at.LEG_W + lane], lanes[at.LEG_O_RATE + lane], lanes[at.LEG_P + lane] = w, o, p
    lanes[at.LEG_ROLL_SENSE + lane] = math.copysign(1.0, roll_rate(state, i_inverse))
    lanes[at.LEG_TURN_SENSE + lane] = math.copysign(1.0, turning_rate(state, i_inverse))
    lanes[at.LEG_TIME + lane], lanes[at.LEG_LEAST + lane], lanes[at.LEG_GREATEST + lane] = 0.0, S, S
    lanes[at.LEG_TURNED + lane], lanes[at.LEG_PATH + lane], lanes[at.LEG_ROLLED + lane] = 0.0, 0.0, 0.0
    lanes[at.LEG_PIVOTED + lane], lanes[at.LEG_RUBBED + lane] = 0.0, 0.0
    lanes[at.LEG_DAMPED + lane], lanes[at.LEG_BLOWN + lane] = 0.0, 0.0
    lanes[at.LOW + lane], lanes[at.HIGH + lane] = low, high
    lanes[at.BREACH + lane], lanes[at.IMBALANCE + lane] = math.nan, 0.0
    lanes[at.STEPS_KEPT + lane], lanes[at.SWITCHES + lane] = 0.0, 0.0


@simd
def set_off(lane, run, lanes):
    """Place a cell at the beginning of a leg."""
    state = (
        lanes[at.LEG_S + lane], lanes[at.LEG_C + lane], lanes[at.LEG_K + lane],
        lanes[at.LEG_W + lane], lanes[at.LEG_O_RATE + lane], lanes[at.LEG_P + lane],
    )  # fmt: skip
    S, C, K, w, o, p = state
    sense = lanes[at.LEG_ROLL_SENSE + lane], lanes[at.LEG_TURN_SENSE + lane]
    t, least, greatest = lanes[at.LEG_TIME + lane], lanes[at.LEG_LEAST + lane], lanes[at.LEG_GREATEST + lane]
    turned, path = lanes[at.LEG_TURNED + lane], lanes[at.LEG_PATH + lane]
    rolled, pivoted = lanes[at.LEG_ROLLED + lane], lanes[at.LEG_PIVOTED + lane]
    rubbed, damped = lanes[at.LEG_RUBBED + lane], lanes[at.LEG_DAMPED + lane]
    blown = lanes[at.LEG_BLOWN + lane]
    _, ledger, forces = rates_and_forces(state, sense, inertia_of(lane, lanes), losses_of(lane, lanes))
    half = next_half(state, ledger[1], forces, lane, lanes)
    lanes[at.S + lane], lanes[at.C + lane], lanes[at.K + lane] = S, C, K
    lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane] = w, o, p
    lanes[at.ROLL_SENSE + lane], lanes[at.TURN_SENSE + lane] = sense
    lanes[at.TIME + lane], lanes[at.HALF + lane], lanes[at.LAST + lane] = t, half, 0.0
    lanes[at.LEAST + lane], lanes[at.GREATEST + lane], lanes[at.RECENT + lane] = least, greatest, S
    lanes[at.TURNED + lane], lanes[at.PATH + lane] = turned, path
    lanes[at.ROLLED + lane], lanes[at.PIVOTED + lane] = rolled, pivoted
    lanes[at.RUBBED + lane], lanes[at.DAMPED + lane], lanes[at.BLOWN + lane] = rubbed, damped, blown


@simd
def next_half(state, roll, forces, lane, lanes):
    """Half the step that the motion asks for."""
    hurried = hurry(state, roll, forces.along, inertia_of(lane, lanes), losses_of(lane, lanes))
    hurried = hurry_by_rolling_friction(hurried, state[1], forces.slowed)
    return half_step(hurried, state[1], lanes[at.SCALE + lane], lanes[at.LONGEST + lane])


@simd
def turning_sine(state, dw, last, half):
    """Sine of the tilt of the turning point to which a state is nearer than its neighbours are, else of its own tilt.

    Parameters
    ----------
    state : tuple of 6 floats
    dw : float
        Derivative of the tilt rate.
    last, half : float
        Half the step before and half the next step.

    Notes
    -----
    About its turning point a motion is nearly even in time: tilt + w^2 / (-2 w') errs by less than h^4 / 100 there.
    """
    S, C, _, w, _, _ = state
    angle = -0.5 * (w * w) / dw
    reach = (2.0 * _NEAREST) * (half if w * dw < 0.0 else last)
    near = abs(w) < reach * abs(dw)
    return S + angle * (C - 0.5 * angle * S) if near else S


@simd
def goes_on_rolling(state, f):
    """Whether rolling friction does not hold a disk yet."""
    _, C, _, w, _, _ = state
    across = C * f
    return w * w + across * across > _ALL_BUT_HELD


@simd
def always_goes_on_rolling(state, f):
    """`goes_on_rolling` without rolling friction."""
    return True


@simd
def goes_on_turning(state, forces, sense, i_inverse, arm):
    """Whether pivoting friction acts as before: against the same sign of the turning rate, or holding it."""
    S, C, _, _, o, p = state
    v = o * C + i_inverse * p * S
    left = arm * forces.normal - abs(forces.held) if sense == 0.0 else sense * v
    return left >= 0.0


@simd
def always_goes_on_turning(state, forces, sense, i_inverse, arm):
    """`goes_on_turning` without pivoting friction."""
    return True


@simd
def grips(state, changes, turn, normal, i_inverse, friction):
    """Whether the contact does not slip: the horizontal force is within `friction` times the normal force.

    Newton on the centre of mass, whose horizontal velocity is (C w, s) across and along the track.
    """
    S, C, _, w, o, p = state
    _, _, _, dw, _, dp = changes
    across = C * dw - S * (w * w) - i_inverse * p * turn
    along = i_inverse * dp + w * o
    most = friction * normal
    return across * across + along * along <= most * most


@simd
def always_grips(state, changes, turn, normal, i_inverse, friction):
    """`grips` where the disk cannot slip."""
    return True


@simd
def keep_rolled(lane, lanes, total):
    """Store what rolling friction took."""
    lanes[at.ROLLED + lane] = total


@simd
def keep_pivoted(lane, lanes, total):
    """Store what pivoting friction took."""
    lanes[at.PIVOTED + lane] = total


@simd
def keep_blown(lane, lanes, total):
    """Store what the drag of air took."""
    lanes[at.BLOWN + lane] = total


@simd
def keep_nothing(lane, lanes, total):
    """Store nothing: the variant lacks the law."""


@simd
def advance(lane, run, lanes):
    """One RK4 step, unless the state ends the leg: then the lane rests in it."""
    # every load comes before the first store: only so can the compiler prove that the lanes are independent
    state, sense = state_of(lane, lanes), sense_of(lane, lanes)
    of_disk, losses = inertia_of(lane, lanes), losses_of(lane, lanes)
    t, half, last = lanes[at.TIME + lane], lanes[at.HALF + lane], lanes[at.LAST + lane]
    least, greatest, recent = lanes[at.LEAST + lane], lanes[at.GREATEST + lane], lanes[at.RECENT + lane]
    turned, path, rubbed = lanes[at.TURNED + lane], lanes[at.PATH + lane], lanes[at.RUBBED + lane]
    damped, rolled, pivoted = lanes[at.DAMPED + lane], lanes[at.ROLLED + lane], lanes[at.PIVOTED + lane]
    blown, friction = lanes[at.BLOWN + lane], lanes[at.FRICTION + lane]
    low, high = lanes[at.LOW + lane], lanes[at.HIGH + lane]
    end, shortest = lanes[at.END + lane], lanes[at.SHORTEST + lane]
    changes, ledger, forces = rates_and_forces(state, sense, of_disk, losses)
    following = next_half(state, ledger[1], forces, lane, lanes)
    extreme = turning_sine(state, changes[3], last, half)
    # so written, a NaN is an event too
    going = (ledger[1] >= 0.0) & (forces.normal > 0.0) & (state[1] >= run.cos_flat_tilt) & (t < end)
    going &= (extreme >= low) & (extreme <= high) & (half >= shortest)
    going &= goes_on_rolling(state, ledger[1])
    going &= goes_on_turning(state, forces, sense[1], of_disk.i_inverse, losses.pivoting)
    going &= grips(state, changes, ledger[0], forces.normal, of_disk.i_inverse, friction)
    # with a step of zero the lane rests
    taken = half if going else 0.0
    # the extreme of the step before is certain only now: its turning point may lie behind the state
    smaller, larger = (recent if recent < least else least), (recent if recent > greatest else greatest)
    (S, C, K, w, o, p), gained = completed_step(state, (changes, ledger), sense, of_disk, losses, taken)
    lanes[at.S + lane], lanes[at.C + lane], lanes[at.K + lane] = S, C, K
    lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane] = w, o, p
    lanes[at.TIME + lane], lanes[at.HALF + lane] = t + (taken + taken), following
    lanes[at.LAST + lane] = half if going else last
    lanes[at.LEAST + lane] = smaller if going else least
    lanes[at.GREATEST + lane] = larger if going else greatest
    lanes[at.RECENT + lane] = extreme if going else recent
    lanes[at.TURNED + lane], lanes[at.PATH + lane] = turned + gained[0], path + gained[1]
    lanes[at.RUBBED + lane], lanes[at.DAMPED + lane] = rubbed + gained[4], damped + gained[5]
    keep_rolled(lane, lanes, rolled + gained[2])
    keep_pivoted(lane, lanes, pivoted + gained[3])
    keep_blown(lane, lanes, blown + gained[6])
    return not going


@simd
def land(lane, run, lanes):
    """Leave all of it to `kernels.lossy_disk.leg_control.finish_leg`: what an event means differs from lane to lane."""
