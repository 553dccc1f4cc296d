"""The stages of a cell in which a ball or a spheroid differs from the disk; see `kernels.disk.simd_stages`."""

import math

from kernels.bodies import arrays as row
from kernels.bodies.equations import fall_along, force, per_inertia
from kernels.bodies.poles import layout as at
from kernels.bodies.poles.equations import Rolling, begun, cosine, lane_step, tilt_acceleration
from kernels.bodies.poles.error_estimate import drift, uncertain_energy
from kernels.bodies.stages import RunSettings, body_of, is_possible
from kernels.bodies.stages import prepared_settings as settings_of_bodies
from kernels.disk.endings import INVALID
from kernels.disk.leg_control import _ACCEPTED_SHARE, _LARGEST_DIVISOR, _write_at_once
from kernels.disk.rk4 import step
from kernels.disk.simd_stages import most_steps, start_of, time_left
from kernels.disk.summit import _ELSEWHERE, _MARGIN, _slow_between, is_long
from kernels.jit import kernel, simd

#: Tilt [rad] up to which a maximum of the potential is sought on the way of a leg: the coarse steps of the search are
#: in the stretched tilt, which is infinite at a pole.
_STEEPEST = 1.55


@kernel
def prepared_settings(settings):
    """Return the `RunSettings` of float64[len(SETTINGS)] settings; no tilt is a fall."""
    run = settings_of_bodies(settings)
    return RunSettings(run.duration, run.step, math.pi, run.tolerance, -1.0, run.relative_step, run.body)


@simd
def _store_start(cell, lane, starts, body, lanes):
    tilt, unit = starts[row.TILT, cell], math.sqrt(starts[row.RADIUS, cell] / starts[row.GRAVITY, cell])
    lanes[at.LEAST + lane], lanes[at.GREATEST + lane], lanes[at.UNIT + lane] = tilt, tilt, unit
    lanes[at.W_0 + lane] = starts[row.TILT_RATE, cell]
    lanes[at.O_RATE_0 + lane] = starts[row.PRECESSION_RATE, cell]
    lanes[at.S_RATE_0 + lane] = starts[row.ROLL_RATE, cell]
    lanes[at.SHIFT + lane], lanes[at.SQUARE + lane] = body.shift, body.square
    lanes[at.ALPHA + lane], lanes[at.TRANSVERSE + lane] = body.axial, body.transverse
    lanes[at.RATIO + lane] = body.ratio


@simd
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Put a start into a lane, in SI units; one that is impossible is written at once."""
    body = body_of(starts, cell, run.body)
    if not is_possible(starts, cell, run.body, body):
        _write_at_once(cell, INVALID, math.nan, math.nan, math.nan, measures, counts)
        fill_idle(lane, lanes)
        return False
    _store_start(cell, lane, starts, body, lanes)
    return True


@kernel
def fill_idle(lane, lanes):
    """Put an upright ball at rest into a lane without a cell."""
    for place in (at.LEAST, at.GREATEST, at.W_0, at.O_RATE_0, at.S_RATE_0, at.SHIFT):
        lanes[place + lane] = 0.0
    for place in (at.UNIT, at.SQUARE, at.ALPHA, at.TRANSVERSE, at.RATIO):
        lanes[place + lane] = 1.0


@simd
def constants_of(lane, lanes):
    """The `Rolling` of a lane; its energy is known after `kernels.disk.simd_stages.prepare`."""
    shift, square, energy = lanes[at.SHIFT + lane], lanes[at.SQUARE + lane], lanes[at.ENERGY_0 + lane]
    axial, transverse = lanes[at.ALPHA + lane], lanes[at.TRANSVERSE + lane]
    return Rolling(0.0, shift, 1.0, square, axial, transverse, lanes[at.RATIO + lane], energy)


@simd
def state_of(lane, lanes):
    """Return the state of a lane, as of `kernels.bodies.poles.equations`."""
    S, y, x, s, n = (
        lanes[at.S + lane], lanes[at.Y + lane], lanes[at.X + lane], lanes[at.SPIN + lane], lanes[at.N + lane],
    )  # fmt: skip
    p, q = lanes[at.P + lane], lanes[at.Q + lane]
    return S, cosine(S, y, x, s, n, constants_of(lane, lanes)), n, y, x, s, p, q


@simd
def scale_of(lane, lanes):
    """Scaled step."""
    return 2.0 * lanes[at.HALF_UNIFORM + lane]


@simd
def longest(lane, lanes):
    """Longest correction of a landing: two steps."""
    return 4.0 * lanes[at.HALF_UNIFORM + lane]


@simd
def set_off(lane, run, lanes):
    """Place a cell at its start, forward or backward in time (BACKWARD), with the step that it holds."""
    S, C, w, o, s = start_of(lane, lanes)
    constants, scale = constants_of(lane, lanes), lanes[at.STEP + lane]
    # the motion backward in time is the motion forward with all rates reversed
    sense = 1.0 - 2.0 * lanes[at.BACKWARD + lane]
    state = begun(S, C, sense * w, sense * o, sense * s, constants)
    acceleration = tilt_acceleration(state, constants)
    _, _, n, y, x, s, p, q = state
    left, most = time_left(lane, run, lanes), most_steps(S, w, run) * scale
    end = most if most < left else left  # min() is a call
    lanes[at.S + lane], lanes[at.Y + lane], lanes[at.X + lane], lanes[at.SPIN + lane] = S, y, x, s
    lanes[at.N + lane], lanes[at.P + lane], lanes[at.Q + lane] = n, p, q
    lanes[at.TIME + lane], lanes[at.END + lane] = 0.0, end
    lanes[at.HALF + lane], lanes[at.HALF_UNIFORM + lane] = 0.5 * scale, 0.5 * scale
    lanes[at.HEADING + lane] = math.copysign(1.0, acceleration if w == 0.0 else y)


@simd
def advance(lane, run, lanes):
    """One RK4 step; an event is a turning point or the end of the time."""
    # every load comes before the first store: only so can the compiler prove that the lanes are independent
    half, heading, end = lanes[at.HALF + lane], lanes[at.HEADING + lane], lanes[at.END + lane]
    uniform, t, constants = lanes[at.HALF_UNIFORM + lane], lanes[at.TIME + lane], constants_of(lane, lanes)
    S, y, x, s, n, p, q = lane_step(
        lanes[at.S + lane], lanes[at.Y + lane], lanes[at.X + lane], lanes[at.SPIN + lane], lanes[at.N + lane],
        lanes[at.P + lane], lanes[at.Q + lane], constants, half,
    )  # fmt: skip
    t += half + half
    # so written, a NaN is an event too
    going = (heading * y >= 0.0) & (t < end)
    lanes[at.S + lane], lanes[at.Y + lane], lanes[at.X + lane], lanes[at.SPIN + lane] = S, y, x, s
    lanes[at.N + lane], lanes[at.P + lane], lanes[at.Q + lane], lanes[at.TIME + lane] = n, p, q, t
    # with a step of zero the lane rests
    lanes[at.HALF + lane] = uniform if going else 0.0
    return not going


@kernel
def allowed_error(lane, run, lanes):
    """Estimated error [rad] with which a result is accepted; see `kernels.disk.leg_control._allowed`.

    The errors of spheroids at random grow with how far they are from a ball.
    """
    w, o, s = lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane], lanes[at.S_RATE_0 + lane]
    pole = math.sqrt(lanes[at.SQUARE + lane])
    divisor = (1.0 + w * w + (o * o + s * s) / 24.0) * max(pole, 1.0 / pole)
    return _ACCEPTED_SHARE * run.tolerance / min(_LARGEST_DIVISOR, divisor)


@kernel
def _leaves_summit(state, constants, heading):
    """See `kernels.disk.summit`."""
    S, C, _, w, o, s = state
    _, curvature = force(state, constants)
    if not curvature < 0.0:
        return False
    downhill = -heading * fall_along(S, C, s, o, constants) / C
    if downhill >= 0.0:
        return True
    kinetic = 0.5 * w * w / per_inertia(S, C, constants)
    return downhill > 0.1 * curvature * -curvature and 0.5 * downhill * downhill < -0.8 * curvature * kinetic


@kernel
def _doubtful_on_the_way(lane, lanes):
    """Take the steps of a leg again; see `kernels.disk.summit`."""
    constants, whole = constants_of(lane, lanes), lanes[at.ENERGY_0 + lane]
    S, C, w, o, s = start_of(lane, lanes)
    sense, heading, h = 1.0 - 2.0 * lanes[at.BACKWARD + lane], lanes[at.HEADING + lane], scale_of(lane, lanes)
    start = S, C, sense * w, sense * o, sense * s
    state = begun(*start, constants)
    slowing = heading * tilt_acceleration(state, constants) < 0.0
    for number in range(1, int(lanes[at.STEPS + lane])):
        state = step(state, constants, h)
        slower = heading * tilt_acceleration(state, constants) < 0.0
        if slowing and not slower:
            drifts = drift(state, start, whole, 0.0, constants, number)
            rise = abs(state[0] - S)
            uncertain = uncertain_energy(drifts, state, start, constants, h, rise, number)
            kinetic = 0.5 * state[3] * state[3] / per_inertia(state[0], state[1], constants)
            if not kinetic > _MARGIN * uncertain:
                return True
        slowing = slower
    # one step is left, and the landing
    way = math.sin(lanes[at.TILT_END + lane]) - S
    return not abs(math.sin(lanes[at.TILT_END + lane]) - state[0]) <= _ELSEWHERE * abs(way)


@kernel
def passed_in_doubt(lane, lanes):
    """Whether the leg of a lane passed a maximum of the potential without enough energy (`kernels.disk.summit`)."""
    constants = constants_of(lane, lanes)
    if not is_long(lanes[at.TIME_END + lane], constants):
        return False
    S, C, w, o, s = start_of(lane, lanes)
    sense = 1.0 - 2.0 * lanes[at.BACKWARD + lane]
    state = S, C, S / C, sense * w, sense * o, sense * s
    if _leaves_summit(state, constants, lanes[at.HEADING + lane]):
        return False
    end = max(-_STEEPEST, min(_STEEPEST, lanes[at.TILT_END + lane]))
    return _slow_between(state, end, constants) and _doubtful_on_the_way(lane, lanes)
