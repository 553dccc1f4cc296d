"""The vector stages of a cell (`kernels.lanes.interface`): scaling its start, starting a leg, one step, landing.

The functions work on one lane of the flat array of `kernels.disk.layout` and are inlined into loops over all lanes.
"""

import math

from kernels.disk import layout as at
from kernels.disk.endings import BOUNDED
from kernels.disk.equations import force, inertia, scaled, whole_energy
from kernels.disk.error_estimate import EPS, drift, estimated_error, uncertain_energy
from kernels.disk.rk4 import approach_turning_point, carried, lane_step, tilt_acceleration
from kernels.disk.step_size import first_step
from kernels.jit import simd
from kernels.simd_math import angle_of, sine_cosine_of_tilt

#: Approximate number of steps after which a leg is abandoned and its cell is unresolved.
MOST_STEPS = 1.0e8

#: Limits of tilts and scaled tilt rates of a tiny start, and the number of steps after which its legs are abandoned.
#: It only needs more if a rate is within 1e-5 of the critical one, to creep away or to return.
TINY, MOST_STEPS_OF_TINY = 1.0e-8, 4.0e4


#: Whether a cell may reach the end of an edge, at a tilt of 0; the disk has only one edge.
EDGED = False


@simd
def new_constants(lane, lanes):
    """Return the constants of a lane, from its start as left by `read_start`."""
    return inertia(lanes[at.ALPHA + lane])


@simd
def keep_constants(lane, constants, lanes):
    """Store the constants that `constants_of` and `advance` read."""
    lanes[at.I_TILT + lane], lanes[at.I_ROLL + lane] = constants[0], constants[1]
    lanes[at.I_SPIN + lane], lanes[at.I_INVERSE + lane] = constants[2], constants[3]
    lanes[at.DRAG + lane] = 2.0 * constants[3]


@simd
def constants_of(lane, lanes):
    """Return the constants of a lane, as from `kernels.disk.equations.inertia`."""
    a, b = lanes[at.I_TILT + lane], lanes[at.I_ROLL + lane]
    return a, b, lanes[at.I_SPIN + lane], lanes[at.I_INVERSE + lane]


@simd
def kept_spin(s, constants):
    """Return the form in which a lane stores the spin s: p = (1+alpha) s."""
    return constants[1] * s


@simd
def start_of(lane, lanes):
    """Return S, C, w, o, s of the start of a lane."""
    S, C, w = lanes[at.S_0 + lane], lanes[at.C_0 + lane], lanes[at.W_0 + lane]
    return S, C, w, lanes[at.O_RATE_0 + lane], lanes[at.S_RATE_0 + lane]


@simd
def state_of(lane, lanes):
    """Return the state of a lane."""
    S, C, T = lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane]
    s = lanes[at.I_INVERSE + lane] * lanes[at.P + lane]
    return S, C, T, lanes[at.W + lane], lanes[at.O_RATE + lane], s


@simd
def time_left(lane, run, lanes):
    """Return the scaled time left for the present leg; a second leg begins when the disk passes its start again."""
    return run.duration / lanes[at.UNIT + lane] - 2.0 * lanes[at.FIRST_TURN + lane]


@simd
def most_steps(S, w, run):
    """Return the number of steps after which a leg from a start with sine S of the tilt and rate w is abandoned."""
    tiny = (abs(S) < TINY) & (abs(w) < TINY) & (run.step == 0.0)
    return MOST_STEPS_OF_TINY if tiny else MOST_STEPS


@simd
def is_steady(state, constants):
    """Return whether a state is a steady motion, to within rounding."""
    S, _, T, w, o, s = state
    acceleration = tilt_acceleration(state, constants)
    terms = constants[0] * (abs(S) + abs(o) * (constants[1] * abs(s) + constants[2] * abs(o * T)))
    return (w == 0.0) & (abs(acceleration) <= 8.0 * EPS * terms)


@simd
def prepare(lane, run, lanes):
    """Scale the start, which `read_start` left in SI units, and choose the step."""
    _, _, tilt_rate, precession_rate, roll_rate = start_of(lane, lanes)
    S, C = sine_cosine_of_tilt(lanes[at.LEAST + lane])
    constants, unit = new_constants(lane, lanes), lanes[at.UNIT + lane]
    state = scaled(S, C, tilt_rate, precession_rate, roll_rate, unit)
    _, _, _, w, o, s = state
    steady = is_steady(state, constants)
    _, curvature = force(state, constants)
    own = first_step(state, constants, run.relative_step)
    lanes[at.S_0 + lane], lanes[at.C_0 + lane], lanes[at.W_0 + lane] = S, C, w
    lanes[at.O_RATE_0 + lane], lanes[at.S_RATE_0 + lane] = o, s
    keep_constants(lane, constants, lanes)
    lanes[at.ENERGY_0 + lane] = whole_energy(state, constants, lanes[at.ALPHA + lane])
    lanes[at.STEADY + lane], lanes[at.CURVATURE + lane] = 1.0 if steady else 0.0, curvature
    lanes[at.STEP + lane] = run.step / unit if run.step > 0.0 else own
    lanes[at.REFINED + lane], lanes[at.FAILED + lane] = 0.0, math.nan
    lanes[at.BACKWARD + lane], lanes[at.FIRST_TURN + lane], lanes[at.STEPS_KEPT + lane] = 0.0, 0.0, 0.0
    lanes[at.ERROR + lane], lanes[at.CHANGE + lane], lanes[at.STEPS + lane] = 0.0, 0.0, 0.0


@simd
def set_off(lane, run, lanes):
    """Place a cell at its start, forward or backward in time (BACKWARD), with its stored step scale."""
    S, C, w, o, s = start_of(lane, lanes)
    constants, scale = constants_of(lane, lanes), lanes[at.STEP + lane]
    # the motion backward in time is the motion forward with all rates reversed
    sense = 1.0 - 2.0 * lanes[at.BACKWARD + lane]
    state = S, C, S / C, sense * w, sense * o, sense * s
    acceleration, p = tilt_acceleration(state, constants), kept_spin(state[5], constants)
    left, most = time_left(lane, run, lanes), most_steps(S, w, run) * scale
    end = most if most < left else left  # min() is a call
    uniform = 0.5 * scale if run.step > 0.0 else 0.0
    graded = 0.0 if run.step > 0.0 else 0.5 * scale
    lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane] = S, C, state[2]
    lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane] = state[3], state[4], p
    lanes[at.TIME + lane], lanes[at.HALF + lane] = 0.0, uniform + graded * C
    lanes[at.HALF_UNIFORM + lane], lanes[at.HALF_GRADED + lane] = uniform, graded
    lanes[at.HEADING + lane] = math.copysign(1.0, acceleration if w == 0.0 else state[3])
    lanes[at.END + lane] = end


@simd
def advance(lane, run, lanes):
    """Make one RK4 step; events are a turning point, a tilt of fall_tilt and the end of the time."""
    # all loads come before the first store: otherwise the compiler cannot prove that the lanes are independent
    half, heading, end = lanes[at.HALF + lane], lanes[at.HEADING + lane], lanes[at.END + lane]
    uniform, graded = lanes[at.HALF_UNIFORM + lane], lanes[at.HALF_GRADED + lane]
    t = lanes[at.TIME + lane] + (half + half)
    S, C, T, w, o, p = lane_step(
        lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane],
        lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane],
        lanes[at.I_TILT + lane], lanes[at.I_SPIN + lane], lanes[at.DRAG + lane], half,
    )  # fmt: skip
    # written so that NaN is an event too, and the compiler needs no instruction to join the three conditions
    going = (heading * w >= 0.0) & (C >= run.cos_fall_tilt) & (t < end)
    lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane], lanes[at.W + lane] = S, C, T, w
    lanes[at.O_RATE + lane], lanes[at.P + lane], lanes[at.TIME + lane] = o, p, t
    # with a step of zero the lane rests
    lanes[at.HALF + lane] = uniform + graded * C if going else 0.0
    return not going


@simd
def scale_of(lane, lanes):
    """Return the scaled step over cos(tilt), or the uniform step."""
    return 2.0 * (lanes[at.HALF_UNIFORM + lane] + lanes[at.HALF_GRADED + lane])


@simd
def longest(lane, lanes):
    """Return the longest correction of a landing: two steps."""
    return 4.0 * (lanes[at.HALF_UNIFORM + lane] + lanes[at.HALF_GRADED + lane] * abs(lanes[at.C + lane]))


@simd
def land(lane, run, lanes):
    """Finish on the turning point that a cell has just passed, if the first correction leads there (LANDED)."""
    state, constants, steps = state_of(lane, lanes), constants_of(lane, lanes), lanes[at.STEPS + lane]
    turned = lanes[at.HEADING + lane] * state[3] < 0.0
    start, whole, alpha = start_of(lane, lanes), lanes[at.ENERGY_0 + lane], lanes[at.ALPHA + lane]
    before, end = lanes[at.TIME + lane], lanes[at.END + lane]
    state, elapsed, left, near = approach_turning_point(state, constants, longest(lane, lanes))
    state = carried(state, constants, 0.5 * state[3] * left)
    t = before + (elapsed + left)
    drifts = drift(state, start, whole, alpha, constants, steps)
    uncertain = uncertain_energy(
        drifts, state, start, constants, scale_of(lane, lanes), abs(state[0] - start[0]), steps
    )
    estimate, stated = estimated_error(BOUNDED, state, drifts, uncertain, constants)
    landed = turned & near & (state[1] > run.cos_fall_tilt) & (not (t > end))
    if EDGED:
        landed = landed & (lanes[at.SIDE + lane] * state[0] >= 0.0)
    lanes[at.LANDED + lane], lanes[at.TIME_END + lane] = 1.0 if landed else 0.0, t
    lanes[at.TILT_END + lane] = angle_of(state[0], state[1])
    lanes[at.ESTIMATE_END + lane], lanes[at.ERROR_END + lane], lanes[at.CHANGE_END + lane] = (
        estimate,
        stated,
        drifts[3],
    )
