"""The vector stages of a cell with losses (`kernels.lanes.interface`): scaling its start, starting a leg, one step.

The functions work on one lane of the flat array of `kernels.lossy_disk.layout` and are inlined into loops over all
lanes. Every leg is a sliding motion: the signs that dry friction opposes do not change.
"""

import math

import numpy as np

from kernels.disk.equations import energy, scaled
from kernels.jit import simd
from kernels.lossy_disk import layout as at
from kernels.lossy_disk.endings import NOT_COMPUTED
from kernels.lossy_disk.equations import roll_rate, turning_rate
from kernels.lossy_disk.lane_step import lane_step as sliding_step
from kernels.lossy_disk.loss_coefficients import load_losses
from kernels.lossy_disk.loss_laws import (
    AIR,
    DRY,
    EDGED,
    LAYER,
    PIVOTING,
    ROLLING,
    SLIPPING,
    VISCOUS,
    viscosity,
)
from kernels.lossy_disk.rk4 import Inertia, changes, changes_near, entries, inertia
from kernels.lossy_disk.step_size import (
    faster_by_rolling_friction,
    faster_by_viscosity,
    fastest_rate,
    half_step,
)
from kernels.simd_math import sine_cosine_of_tilt

#: Largest distance of a turning point from the end of a step that it is assigned to, over half the step.
_NEAREST = 1.1

#: Number of steps in a call of `advance` and `further_step`.
STEPS_OF_A_CALL = 4.0

#: Weights of Boole's rule over four steps, over half the length of one: of both ends, of the inner nodes.
ENDS_OF_BOOLE = 28.0 / 45.0
BOOLE = np.array([128.0, 48.0, 128.0]) / 45.0

#: Number of steps at which `kernels.lossy_disk.step_control` first checks a cell: a few nutations.
FIRST_CHECK = 512.0

#: Steps of a pass over those of the pass before.
SHORTER = 0.4

#: Limits at which a leg ends: share of the available friction, and normal force over m g. A force that exceeds its
#: limit between two checks of the lane does so by less, and `kernels.lossy_disk.events` checks more precisely.
SURE_GRIP, SURE_CONTACT = 0.96, 0.01

#: Horizontal turning rate at which a leg with rolling friction ends; `kernels.lossy_disk.follow` continues.
SLOW_CONTACT = 1.0e-3


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
    return load_losses(lane, at.CONTOUR, lanes)


@simd
def state_of(lane, lanes):
    """Return the state (S, C, T, w, o, p) of a lane."""
    return (
        lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane],
        lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane],
    )  # fmt: skip


@simd
def ledger_of(lane, lanes):
    """Return the ledger of a lane."""
    return (
        lanes[at.TURNED + lane], lanes[at.PATH + lane], lanes[at.ROLLED + lane], lanes[at.PIVOTED + lane],
        lanes[at.RUBBED + lane], lanes[at.DAMPED + lane], lanes[at.BLOWN + lane],
    )  # fmt: skip


@simd
def sense_of(lane, lanes):
    """Return the signs of the roll rate and of the turning rate about the vertical in the leg of a lane."""
    return lanes[at.ROLL_SENSE + lane], lanes[at.TURN_SENSE + lane]


@simd
def prepare(lane, run, lanes):
    """Scale the start, which `read_start` left in SI units and as an angle, and begin the cell."""
    alpha, unit, tilt = lanes[at.ALPHA + lane], lanes[at.UNIT + lane], lanes[at.S_0 + lane]
    tilt_rate, precession_rate = lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane]
    S, C = sine_cosine_of_tilt(tilt)
    _, _, _, w, o, s = scaled(S, C, tilt_rate, precession_rate, lanes[at.P_0 + lane], unit)
    of_disk = inertia(alpha)
    lanes[at.I_TILT + lane], lanes[at.I_ROLL + lane] = of_disk.i_tilt, of_disk.i_roll
    lanes[at.I_SPIN + lane], lanes[at.I_INVERSE + lane] = of_disk.i_spin, of_disk.i_inverse
    lanes[at.DRAG + lane], lanes[at.INVERSE_SPIN + lane] = of_disk.drag, of_disk.inverse_spin
    lanes[at.S_0 + lane], lanes[at.C_0 + lane], lanes[at.W_0 + lane] = S, C, w
    lanes[at.O_RATE_0 + lane], lanes[at.P_0 + lane] = o, of_disk.i_roll * s
    lanes[at.ENERGY_0 + lane] = energy(S, C, w, o, s, alpha)
    set_steps(lane, run, unit, lanes)
    begin(lane, lanes)


@simd
def set_steps(lane, run, unit, lanes):
    """Set the duration of a cell, and the step lengths and the tolerance of its first pass."""
    coarsest = run.relative_step / (2.0 * SHORTER)
    lanes[at.COARSEST + lane], lanes[at.FIRST_SCALE + lane] = coarsest, coarsest
    lanes[at.LONGEST + lane] = run.step / (2.0 * SHORTER * unit) if run.step > 0.0 else math.inf
    lanes[at.ALLOWED + lane] = run.tolerance / (SHORTER * SHORTER * SHORTER * SHORTER)
    lanes[at.END + lane] = run.duration / unit
    lanes[at.REFINED + lane], lanes[at.PASS_ENDING + lane] = 0.0, NOT_COMPUTED


@simd
def begin(lane, lanes):
    """Make the start the beginning of the next leg."""
    S, C, w = lanes[at.S_0 + lane], lanes[at.C_0 + lane], lanes[at.W_0 + lane]
    o, p = lanes[at.O_RATE_0 + lane], lanes[at.P_0 + lane]
    i_inverse = inertia_of(lane, lanes).i_inverse
    low, high = lanes[at.LOW_0 + lane], lanes[at.HIGH_0 + lane]
    state = S, C, 1.0 / C, w, o, p
    lanes[at.LEG_S + lane], lanes[at.LEG_C + lane], lanes[at.LEG_T + lane] = S, C, S / C
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
    lanes[at.SCALE + lane], lanes[at.CHECK + lane] = lanes[at.FIRST_SCALE + lane], FIRST_CHECK
    lanes[at.SPENT + lane], lanes[at.PROGRESS + lane], lanes[at.LOOKED + lane] = 0.0, 0.0, 0.0


@simd
def set_off(lane, run, lanes):
    """Place a cell at the beginning of a leg."""
    state = (
        lanes[at.LEG_S + lane], lanes[at.LEG_C + lane], lanes[at.LEG_T + lane],
        lanes[at.LEG_W + lane], lanes[at.LEG_O_RATE + lane], lanes[at.LEG_P + lane],
    )  # fmt: skip
    S, C, T, w, o, p = state
    sense = lanes[at.LEG_ROLL_SENSE + lane], lanes[at.LEG_TURN_SENSE + lane]
    t, least, greatest = lanes[at.LEG_TIME + lane], lanes[at.LEG_LEAST + lane], lanes[at.LEG_GREATEST + lane]
    turned, path = lanes[at.LEG_TURNED + lane], lanes[at.LEG_PATH + lane]
    rolled, pivoted = lanes[at.LEG_ROLLED + lane], lanes[at.LEG_PIVOTED + lane]
    rubbed, damped = lanes[at.LEG_RUBBED + lane], lanes[at.LEG_DAMPED + lane]
    blown = lanes[at.LEG_BLOWN + lane]
    left = lanes[at.CHECK + lane] - lanes[at.STEPS_KEPT + lane]
    change, forces = changes(state, sense, inertia_of(lane, lanes), losses_of(lane, lanes))
    half = next_half(state, change, forces, lane, lanes)
    lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane] = S, C, T
    lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane] = w, o, p
    lanes[at.ROLL_SENSE + lane], lanes[at.TURN_SENSE + lane] = sense
    lanes[at.TIME + lane], lanes[at.HALF + lane], lanes[at.LAST + lane] = t, half, 0.0
    lanes[at.STEPS_LEFT + lane], lanes[at.ASKED + lane], lanes[at.SLIDES + lane] = left, half, 1.0
    lanes[at.LEAST + lane], lanes[at.GREATEST + lane] = least, greatest
    # a turning point before the first step of a leg does not belong to the leg
    store_near(lane, lanes, (S, C, 0.0, 1.0, 0.0))
    lanes[at.TURNED + lane], lanes[at.PATH + lane] = turned, path
    lanes[at.ROLLED + lane], lanes[at.PIVOTED + lane] = rolled, pivoted
    lanes[at.RUBBED + lane], lanes[at.DAMPED + lane], lanes[at.BLOWN + lane] = rubbed, damped, blown


@simd
def next_half(state, change, forces, lane, lanes):
    """Return half the step that the motion asks for."""
    S, C, T, _, _, _ = state
    of_disk, losses = inertia_of(lane, lanes), losses_of(lane, lanes)
    viscous = viscosity(forces.f, (S, C, T), losses)
    fastest = fastest_rate(state, forces.along, of_disk)
    fastest = faster_by_viscosity(fastest, state, viscous, of_disk.inverse_spin)
    fastest = faster_by_rolling_friction(fastest, state, change, forces, of_disk, losses.rolling)
    return half_step(fastest, C, lanes[at.SCALE + lane], lanes[at.LONGEST + lane])


@simd
def near_of(lane, lanes):
    """Return S, C, |w|, tilt acceleration and longest time to the turning point of the state nearest to one."""
    return (
        lanes[at.NEAR_S + lane], lanes[at.NEAR_C + lane], lanes[at.NEAR_W + lane],
        lanes[at.NEAR_ACCELERATION + lane], lanes[at.NEAR_REACH + lane],
    )  # fmt: skip


@simd
def store_near(lane, lanes, near):
    """Store the tuple that `near_of` returns."""
    S, C, speed, acceleration, reach = near
    lanes[at.NEAR_S + lane], lanes[at.NEAR_C + lane], lanes[at.NEAR_W + lane] = S, C, speed
    lanes[at.NEAR_ACCELERATION + lane], lanes[at.NEAR_REACH + lane] = acceleration, reach


@simd
def nearer(condition, near, other):
    """Return `near` if a condition holds, otherwise `other`."""
    S, C, speed, acceleration, reach = near
    S0, C0, speed0, acceleration0, reach0 = other
    return (
        S if condition else S0, C if condition else C0, speed if condition else speed0,
        acceleration if condition else acceleration0, reach if condition else reach0,
    )  # fmt: skip


@simd
def turning_sine(near):
    """Return the sine of the tilt at a nearby turning point, or of the state's own tilt; argument as from `near_of`.

    Notes
    -----
    Near its turning point a motion is almost even in time: there tilt + w^2 / (-2 w') has an error below h^4 / 100.
    """
    S, C, speed, acceleration, reach = near
    time = speed / acceleration
    angle = -0.5 * (speed * time)
    return S + (angle * (C - 0.5 * angle * S) if abs(time) < reach else 0.0)


@simd
def goes_on_rolling(state, f, arm):
    """Return whether rolling friction does not hold a disk yet."""
    if not ROLLING:
        return True
    _, C, _, w, _, _ = state
    across = C * f
    return (arm == 0.0) | (w * w + across * across > SLOW_CONTACT * SLOW_CONTACT)


@simd
def least_between(value, slope, length):
    """Return a number that is positive if a value, positive a time `length` ago, has stayed positive.

    Notes
    -----
    A parabola that is positive at both ends and negative in between has, at its end, a value below half the slope
    times the length.
    """
    return value - (0.5 * length * slope if slope > 0.0 else 0.0)


@simd
def goes_on_sliding(state, change, rolled, sense, i_inverse, length):
    """Return whether dry contour friction acts as before; `rolled` is the roll rate times its previous sign."""
    if not DRY:
        # without dry friction, the sign only matters for the path
        return rolled >= 0.0
    _, _, T, _, o, _ = state
    _, _, dT, _, do, dp = change
    return least_between(rolled, sense * (i_inverse * dp - (do * T + o * dT)), length) >= 0.0


@simd
def goes_on_turning(state, change, forces, sense, i_inverse, arm, length):
    """Return whether pivoting friction acts as before: against the same sign of the turning rate, or holding it."""
    if not PIVOTING:
        return True
    S, C, _, _, o, p = state
    dS, dC, _, _, do, dp = change
    v = o * C + i_inverse * p * S
    slope = do * C + o * dC + i_inverse * (dp * S + p * dS)
    turns = least_between(sense * v, sense * slope, length)
    left = arm * forces.normal - abs(forces.held) if sense == 0.0 else turns
    return (arm == 0.0) | (left >= 0.0)


@simd
def stays_on_edge(state, inertia, length):
    """Return whether a body with two edges is still on the same edge."""
    if not EDGED:
        return True
    S, C, _, w, _, _ = state
    return least_between(inertia.side * S, inertia.side * (C * w), length) >= 0.0


@simd
def grips(state, change, normal, inertia, friction):
    """Return whether the contact certainly grips: horizontal force well below `friction` times the normal force.

    Newton's law for the centre of mass, whose horizontal velocity is (C w, s) across and along the track.
    """
    if not SLIPPING:
        return True
    S, C, T, w, o, p = state
    _, _, _, torque, _, dp = change
    i_inverse = inertia.i_inverse
    across = C * inertia.i_tilt * torque - S * (w * w) - i_inverse * p * (o * (C + S * T))
    along = i_inverse * dp + w * o
    most = SURE_GRIP * friction * normal
    return across * across + along * along <= most * most


@simd
def slides_on(state, change, forces, sense, inertia, losses, friction, length):
    """Return whether friction acts as before, with the same signs, and the disk certainly neither slips nor lifts off.

    It covers the scaled time `length` up to now, provided that it held at the beginning. NaN gives False.
    """
    i_inverse = inertia.i_inverse
    going = goes_on_sliding(state, change, sense[0] * forces.f, sense[0], i_inverse, length)
    going &= forces.normal > SURE_CONTACT
    going &= goes_on_rolling(state, forces.f, losses.rolling)
    going &= goes_on_turning(state, change, forces, sense[1], i_inverse, losses.pivoting, length)
    going &= stays_on_edge(state, inertia, length)
    return going & grips(state, change, forces.normal, inertia, friction)


@simd
def store_state(lane, lanes, state):
    """Store a state (S, C, T, w, o, p)."""
    S, C, T, w, o, p = state
    lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane] = S, C, T
    lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane] = w, o, p


@simd
def chosen(condition, state, other):
    """Return `state` if a condition holds, otherwise `other`."""
    S, C, T, w, o, p = state
    S0, C0, T0, w0, o0, p0 = other
    return (
        S if condition else S0, C if condition else C0, T if condition else T0,
        w if condition else w0, o if condition else o0, p if condition else p0,
    )  # fmt: skip


@simd
def store_ledger(lane, lanes, ledger, weight, rates):
    """Store the ledger plus `weight` times its rates."""
    turned, path, rolled, pivoted, rubbed, damped, blown = ledger
    lanes[at.TURNED + lane], lanes[at.PATH + lane] = turned + weight * rates[0], path + weight * rates[1]
    if ROLLING:
        lanes[at.ROLLED + lane] = rolled + weight * rates[2]
    if PIVOTING:
        lanes[at.PIVOTED + lane] = pivoted + weight * rates[3]
    if DRY:
        lanes[at.RUBBED + lane] = rubbed + weight * rates[4]
    if VISCOUS:
        lanes[at.DAMPED + lane] = damped + weight * rates[5]
    if AIR:
        lanes[at.BLOWN + lane] = blown + weight * rates[6]


@simd
def last_stage_of(lane, lanes):
    """Return the values of a lane's last stage from which `kernels.lossy_disk.rk4.changes_near` starts."""
    rate, inverse = lanes[at.RATE + lane], lanes[at.INVERSE + lane]
    near = rate, inverse, lanes[at.SLOWED + lane], lanes[at.RECIPROCAL + lane]
    return near, lanes[at.ROLL + lane], (0.0, lanes[at.ROOT + lane])


@simd
def store_stage(lane, lanes, last):
    """Store the values of the last stage that rolling friction and Bildsten's drag need."""
    rate, inverse, slowed, reciprocal = last[0]
    if ROLLING:
        lanes[at.RATE + lane], lanes[at.INVERSE + lane] = rate, inverse
        lanes[at.SLOWED + lane], lanes[at.RECIPROCAL + lane] = slowed, reciprocal
    if LAYER:
        lanes[at.ROLL + lane], lanes[at.ROOT + lane] = last[1], last[2][1]


@simd
def chosen_stage(condition, last, other):
    """Return `last` if a condition holds, otherwise `other`, both as from `last_stage_of`."""
    (rate, inverse, slowed, reciprocal), roll, (_, root) = last
    (rate0, inverse0, slowed0, reciprocal0), roll0, (_, root0) = other
    near = (
        rate if condition else rate0, inverse if condition else inverse0,
        slowed if condition else slowed0, reciprocal if condition else reciprocal0,
    )  # fmt: skip
    return near, roll if condition else roll0, (0.0, root if condition else root0)


@simd
def advance(lane, run, lanes):
    """Make one RK4 step, unless the state ends the leg: then the lane stays in this state.

    `further_step` makes the other three steps of a call. The ledger is integrated by Boole's rule over all four
    steps, which needs only the rates at their beginnings; `kernels.lossy_disk.leg_control` adds the missing term at
    the end of a leg.
    """
    # all loads come before the first store: otherwise the compiler cannot prove that the lanes are independent
    state, sense = state_of(lane, lanes), sense_of(lane, lanes)
    of_disk, losses, ledger = inertia_of(lane, lanes), losses_of(lane, lanes), ledger_of(lane, lanes)
    t, half, last = lanes[at.TIME + lane], lanes[at.HALF + lane], lanes[at.LAST + lane]
    least, greatest, near = lanes[at.LEAST + lane], lanes[at.GREATEST + lane], near_of(lane, lanes)
    low, high, friction = lanes[at.LOW + lane], lanes[at.HIGH + lane], lanes[at.FRICTION + lane]
    end, left, slid = lanes[at.END + lane], lanes[at.STEPS_LEFT + lane], lanes[at.SLIDES + lane]
    change, forces = changes(state, sense, of_disk, losses)
    rates = entries(state, sense, forces)
    asked, before = next_half(state, change, forces, lane, lanes), lanes[at.ASKED + lane]
    extreme = turning_sine(near)
    # written so that NaN is an event too
    going = (left > 0.0) & (t < end) & (extreme >= low) & (extreme <= high) & (state[1] >= run.cos_flat_tilt)
    going &= (state[0] >= low) & (state[0] <= high) & (slid > 0.0)
    # zero at the beginning of a leg
    since = 2.0 * last
    going &= slides_on(state, change, forces, sense, of_disk, losses, friction, since)
    taken = half if going else 0.0
    weight = ENDS_OF_BOOLE * ((half + last) if going else 0.0)
    # selecting after the step is faster than making the step wait for the event checks
    stepped, last_stage = sliding_step(state, forces, sense, of_disk, losses, half)
    store_state(lane, lanes, chosen(going, stepped, state))
    store_ledger(lane, lanes, ledger, weight, rates)
    lanes[at.TIME + lane], lanes[at.TAKEN + lane] = t + (2.0 * STEPS_OF_A_CALL) * taken, taken
    # the next call comes later than the state that sets its step: extrapolate steps that get shorter
    following = asked * (asked / before) if asked < before else asked
    lanes[at.HALF + lane] = following if going else half
    lanes[at.ASKED + lane], lanes[at.SLIDES + lane] = asked if going else before, 1.0 if going else slid
    lanes[at.LAST + lane] = half if going else last
    lanes[at.STEPS_LEFT + lane] = left - (STEPS_OF_A_CALL if going else 0.0)
    # only now is it certain that the turning point of the previous call has been passed
    lanes[at.LEAST + lane] = extreme if going & (extreme < least) else least
    lanes[at.GREATEST + lane] = extreme if going & (extreme > greatest) else greatest
    reach = _NEAREST * (half if state[3] * change[3] < 0.0 else last)
    here = state[0], state[1], abs(state[3]), of_disk.i_tilt * change[3], reach
    store_near(lane, lanes, nearer(going, here, near))
    # an ended lane keeps its own values, because a step from there may lead anywhere
    stage = chosen_stage(going, last_stage, (forces.near, forces.f, forces.drag))
    store_stage(lane, lanes, stage)
    return not going


@simd
def further_step(lane, weight, run, lanes):
    """Make another RK4 step of the same length, checking only that the disk slides as before.

    `weight` is the Boole weight of its beginning, over half its length.
    """
    state, sense = state_of(lane, lanes), sense_of(lane, lanes)
    of_disk, losses, ledger = inertia_of(lane, lanes), losses_of(lane, lanes), ledger_of(lane, lanes)
    taken, near, before = lanes[at.TAKEN + lane], near_of(lane, lanes), last_stage_of(lane, lanes)
    friction, slid = lanes[at.FRICTION + lane], lanes[at.SLIDES + lane]
    change, forces = changes_near(state, sense, of_disk, losses, before)
    speed = abs(state[3])
    here = state[0], state[1], speed, of_disk.i_tilt * change[3], _NEAREST * taken
    stepped, last_stage = sliding_step(state, forces, sense, of_disk, losses, taken)
    # an ended lane may be in a state from which no step is possible
    store_state(lane, lanes, chosen(taken > 0.0, stepped, state))
    store_ledger(lane, lanes, ledger, weight * taken, entries(state, sense, forces))
    slides = slides_on(state, change, forces, sense, of_disk, losses, friction, 2.0 * taken)
    lanes[at.SLIDES + lane] = slid if slides | (taken == 0.0) else 0.0
    # a call has at most one state near a turning point
    store_near(lane, lanes, nearer((speed < near[2]) & (taken > 0.0), here, near))
    store_stage(lane, lanes, last_stage)


@simd
def land(lane, run, lanes):
    """Do nothing: `kernels.lossy_disk.leg_control.finish_leg` handles all events, which differ from lane to lane."""
