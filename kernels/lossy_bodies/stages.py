"""The stages of a cell in which a body differs from the disk: its start, its constants, the settings of a run.

See `kernels.lossy_disk.leg_control` and `simd_stages`.
"""

import math
from typing import NamedTuple

from kernels.bodies import arrays as body_row
from kernels.bodies.equations import energy_gained, whole_energy
from kernels.bodies.shapes import RIM, TORUS, thin_disk
from kernels.bodies.starts import body_of, is_possible, side_of
from kernels.disk.equations import scaled
from kernels.jit import kernel, simd
from kernels.lossy_bodies import arrays as row
from kernels.lossy_bodies import layout as at
from kernels.lossy_bodies.equations import Rolling
from kernels.lossy_disk.arrays import NONE
from kernels.lossy_disk.endings import EDGE_CHANGE, FLAT, INVALID, UNDISTURBED
from kernels.lossy_disk.follow import MOVING
from kernels.lossy_disk.leg_control import _NO_SINE, _criterion, _write_at_once
from kernels.lossy_disk.loss_coefficients import NOTHING_LOST, are_possible, scaled_losses, store_losses
from kernels.lossy_disk.simd_stages import begin, set_steps
from kernels.lossy_disk.step_control import lost_energy
from kernels.lossy_disk.step_size import prepared_settings as settings_of_disk
from kernels.simd_math import sine_cosine_of_tilt

#: What rolls in a lane without a cell.
_HOOP = thin_disk(1.0)


class RunSettings(NamedTuple):
    """`kernels.lossy_disk.step_size.RunSettings`, and the number of the body (`kernels.bodies.shapes`)."""

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
    body: float


@kernel
def prepared_settings(settings):
    """Return the `RunSettings` of float64[len(SETTINGS)] settings."""
    run = settings_of_disk(settings)
    return RunSettings(
        run.duration, run.step, run.flat_tilt, run.tolerance, run.limited, run.limit, run.from_start, run.air_law,
        run.cos_flat_tilt, run.relative_step, settings[row.BODY],
    )  # fmt: skip


@simd
def inertia_of(lane, lanes):
    """Return the `Rolling` of a lane."""
    return Rolling(
        lanes[at.CORE + lane], lanes[at.SHIFT + lane], lanes[at.EDGE + lane], 1.0, lanes[at.AXIAL + lane],
        lanes[at.TRANSVERSE + lane], lanes[at.RATIO + lane], lanes[at.INVERSE_SPIN + lane],
        lanes[at.SIDE + lane], 1.0, 1.0, 1.0,
    )  # fmt: skip


@kernel
def _possible(cell, starts, run, body):
    """Return whether the numbers of a start are possible for a body with losses."""
    # no law for a film of air under a ring is known
    faced = run.air_law == NONE or run.body != TORUS
    possible = is_possible(starts, cell, run.body, body) and are_possible(cell, starts, run.air_law)
    return possible and faced and body.core > 0.0


@kernel
def undisturbed(cell, starts, body):
    """Return whether a start is upright without any tilting torque: the gyroscopic torque vanishes with a rate."""
    still = starts[body_row.TILT, cell] == 0.0 and starts[body_row.TILT_RATE, cell] == 0.0
    return (
        still
        and body.shift == 0.0
        and (starts[body_row.PRECESSION_RATE, cell] == 0.0 or starts[body_row.ROLL_RATE, cell] == 0.0)
    )


@kernel
def _ending_at_once(cell, starts, run, body):
    """Return the ending of a start without a motion, or MOVING."""
    tilt = starts[body_row.TILT, cell]
    if not _possible(cell, starts, run, body):
        return INVALID
    if abs(tilt) >= run.flat_tilt:
        return FLAT
    if run.body == RIM and tilt == 0.0:
        return EDGE_CHANGE
    return UNDISTURBED if undisturbed(cell, starts, body) else MOVING


@kernel
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Put a start into a lane, in SI units; write impossible starts and starts without a motion at once."""
    tilt, body = starts[body_row.TILT, cell], body_of(starts, cell, run.body)
    ending = _ending_at_once(cell, starts, run, body)
    if ending != MOVING:
        known = ending == FLAT or ending == EDGE_CHANGE
        _write_at_once(
            cell, ending, tilt if known else math.nan, 0.0 if known else math.nan, measures, counts
        )
        fill_idle(lane, lanes)
        return False
    radius = starts[body_row.RADIUS, cell]
    unit = math.sqrt(radius / starts[body_row.GRAVITY, cell])
    rates = (
        tilt,
        starts[body_row.TILT_RATE, cell],
        starts[body_row.PRECESSION_RATE, cell],
        starts[body_row.ROLL_RATE, cell],
    )
    criterion = _criterion(tilt, unit * rates[1], 2.0 * body.transverse, run)
    losses = scaled_losses(cell, starts, run.air_law, body.core)
    _store_start(
        lane, rates, (radius, unit), body, side_of(run.body, tilt), losses, starts[row.FRICTION, cell],
        criterion, lanes,
    )  # fmt: skip
    return True


@simd
def _store_start(lane, rates, size, body, side, losses, friction, criterion, lanes):
    tilt, tilt_rate, precession_rate, roll_rate = rates
    reference, reach, low, high = criterion
    lanes[at.S_0 + lane], lanes[at.W_0 + lane] = tilt, tilt_rate
    lanes[at.O_RATE_0 + lane], lanes[at.P_0 + lane] = precession_rate, roll_rate
    lanes[at.RADIUS + lane], lanes[at.UNIT + lane] = size
    lanes[at.CORE + lane], lanes[at.SHIFT + lane], lanes[at.EDGE + lane] = body.core, body.shift, body.edge
    lanes[at.AXIAL + lane], lanes[at.TRANSVERSE + lane] = body.axial, body.transverse
    lanes[at.RATIO + lane], lanes[at.INVERSE_SPIN + lane] = body.ratio, 1.0 / body.transverse
    lanes[at.SIDE + lane], lanes[at.FRICTION + lane] = side, friction
    store_losses(lane, at.CONTOUR, losses, lanes)
    lanes[at.REFERENCE + lane], lanes[at.REACH + lane] = reference, reach
    lanes[at.LOW_0 + lane], lanes[at.HIGH_0 + lane] = low, high


@kernel
def fill_idle(lane, lanes):
    """Put an upright hoop at rest into a lane without a cell."""
    never = 0.0, math.inf, -_NO_SINE, _NO_SINE
    _store_start(lane, (0.0, 0.0, 0.0, 0.0), (1.0, 1.0), _HOOP, 0.0, NOTHING_LOST, math.inf, never, lanes)


@simd
def prepare(lane, run, lanes):
    """See `kernels.lossy_disk.simd_stages.prepare`."""
    unit, tilt, body = lanes[at.UNIT + lane], lanes[at.S_0 + lane], inertia_of(lane, lanes)
    tilt_rate, precession_rate = lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane]
    S, C = sine_cosine_of_tilt(tilt)
    state = scaled(S, C, tilt_rate, precession_rate, lanes[at.P_0 + lane], unit)
    _, _, _, w, o, s = state
    lanes[at.S_0 + lane], lanes[at.C_0 + lane], lanes[at.W_0 + lane] = S, C, w
    lanes[at.O_RATE_0 + lane], lanes[at.P_0 + lane] = o, s
    lanes[at.ENERGY_0 + lane] = whole_energy(state, body, body.axial)
    set_steps(lane, run, unit, lanes)
    begin(lane, lanes)


@kernel
def energy_won(state, ledger, place, memory):
    """See `kernels.lossy_disk.step_control._excess`."""
    body, (S, C, _, _, _, _) = inertia_of(place, memory), state
    start = (
        memory[at.S_0 + place], memory[at.C_0 + place], memory[at.W_0 + place], memory[at.O_RATE_0 + place],
        memory[at.P_0 + place],
    )  # fmt: skip
    change = energy_gained(state, start, body, body.axial)
    return change + lost_energy(ledger), (S - 1.0) * (S + 1.0) + C * C
