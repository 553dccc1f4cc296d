"""The stages of a cell in which a body differs from the disk: starts, constants, one step, endings on an edge.

See `kernels.disk.simd_stages` and `kernels.disk.leg_control`.
"""

import math
from typing import NamedTuple

from kernels.bodies import arrays as row
from kernels.bodies import layout as at
from kernels.bodies.equations import lane_step
from kernels.bodies.shapes import RIM, Body
from kernels.bodies.starts import body_of, is_possible, side_of
from kernels.disk.endings import EDGE_CHANGE, FELL, INVALID
from kernels.disk.leg_control import _write_at_once
from kernels.disk.step_size import prepared_settings as settings_of_disk
from kernels.jit import kernel, simd


class RunSettings(NamedTuple):
    """`kernels.disk.step_size.RunSettings`, and the number of the body (`kernels.bodies.shapes`)."""

    duration: float
    step: float
    fall_tilt: float
    tolerance: float
    cos_fall_tilt: float
    relative_step: float
    body: float


@kernel
def prepared_settings(settings):
    """Return the `RunSettings` of float64[len(SETTINGS)] settings."""
    run = settings_of_disk(settings)
    return RunSettings(
        run.duration, run.step, run.fall_tilt, run.tolerance, run.cos_fall_tilt, run.relative_step,
        settings[row.BODY],
    )  # fmt: skip


@simd
def _store_start(cell, lane, starts, body, side, lanes):
    tilt, unit = starts[row.TILT, cell], math.sqrt(starts[row.RADIUS, cell] / starts[row.GRAVITY, cell])
    lanes[at.LEAST + lane], lanes[at.GREATEST + lane], lanes[at.UNIT + lane] = tilt, tilt, unit
    lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane] = (
        starts[row.TILT_RATE, cell],
        starts[row.PRECESSION_RATE, cell],
    )
    lanes[at.S_RATE_0 + lane], lanes[at.SIDE + lane] = starts[row.ROLL_RATE, cell], side
    lanes[at.CORE + lane], lanes[at.SHIFT + lane], lanes[at.EDGE + lane] = body.core, body.shift, body.edge
    lanes[at.ALPHA + lane], lanes[at.TRANSVERSE + lane] = body.axial, body.transverse
    lanes[at.RATIO + lane] = body.ratio


@simd
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Put a start into a lane, in SI units; write starts that are impossible or already at an ending at once."""
    body, tilt = body_of(starts, cell, run.body), starts[row.TILT, cell]
    if not is_possible(starts, cell, run.body, body):
        _write_at_once(cell, INVALID, math.nan, math.nan, math.nan, measures, counts)
        fill_idle(lane, lanes)
        return False
    if abs(tilt) >= run.fall_tilt:
        _write_at_once(cell, FELL, tilt, tilt, 0.0, measures, counts)
        fill_idle(lane, lanes)
        return False
    if run.body == RIM and tilt == 0.0:
        _write_at_once(cell, EDGE_CHANGE, tilt, tilt, math.nan, measures, counts)
        fill_idle(lane, lanes)
        return False
    _store_start(cell, lane, starts, body, side_of(run.body, tilt), lanes)
    return True


@kernel
def fill_idle(lane, lanes):
    """Put an upright thin disk at rest into a lane without a cell."""
    for place in (at.LEAST, at.GREATEST, at.W_0, at.O_RATE_0, at.S_RATE_0, at.SIDE, at.SHIFT, at.EDGE):
        lanes[place + lane] = 0.0
    for place in (at.UNIT, at.CORE, at.ALPHA, at.TRANSVERSE, at.RATIO):
        lanes[place + lane] = 1.0


@simd
def constants_of(lane, lanes):
    """Return the `Body` of a lane."""
    core, shift, edge = lanes[at.CORE + lane], lanes[at.SHIFT + lane], lanes[at.EDGE + lane]
    return Body(
        core, shift, edge, 1.0, lanes[at.ALPHA + lane], lanes[at.TRANSVERSE + lane], lanes[at.RATIO + lane]
    )


@simd
def keep_constants(lane, constants, lanes):
    """Do nothing: `read_start` has stored the constants."""


@simd
def kept_spin(s, constants):
    """Return the form in which a lane stores the spin s: s itself."""
    return s


@simd
def state_of(lane, lanes):
    """Return the state of a lane."""
    S, C, T = lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane]
    return S, C, T, lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane]


@simd
def advance(lane, run, lanes):
    """Make one RK4 step; events are a turning point, a tilt of fall_tilt, or of 0 on an edge, and the end of time."""
    # all loads come before the first store: otherwise the compiler cannot prove that the lanes are independent
    half, heading, end = lanes[at.HALF + lane], lanes[at.HEADING + lane], lanes[at.END + lane]
    uniform, graded = lanes[at.HALF_UNIFORM + lane], lanes[at.HALF_GRADED + lane]
    t, side, body = lanes[at.TIME + lane] + (half + half), lanes[at.SIDE + lane], constants_of(lane, lanes)
    S, C, T, w, o, s = lane_step(
        lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane],
        lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane], body, half,
    )  # fmt: skip
    # written so that NaN is an event too
    going = (heading * w >= 0.0) & (C >= run.cos_fall_tilt) & (t < end) & (side * S >= 0.0)
    lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane], lanes[at.W + lane] = S, C, T, w
    lanes[at.O_RATE + lane], lanes[at.P + lane], lanes[at.TIME + lane] = o, s, t
    # with a step of zero the lane rests
    lanes[at.HALF + lane] = uniform + graded * C if going else 0.0
    return not going
