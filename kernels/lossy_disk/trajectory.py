"""One motion with losses sampled in time, with the path of the contact point on the plane.

The motion goes on by the leaps of `kernels.lossy_disk.follow`: what dry friction holds, reverses and lets go comes at
its moment. Roll angle and path are integrals over the state; Simpson's rule over the three states of a step keeps them
of fourth order.
"""

import math

from kernels.disk.equations import scaled_state
from kernels.jit import kernel
from kernels.lossy_disk import arrays as row
from kernels.lossy_disk.contact import all_held, contact_forces
from kernels.lossy_disk.creeping import next_state
from kernels.lossy_disk.endings import FLAT, HORIZON, UNRESOLVED
from kernels.lossy_disk.events import Case
from kernels.lossy_disk.follow import (
    MOVING,
    Record,
    begun,
    ending_of,
    endless,
    leap,
    recorded,
    tilt_of,
)
from kernels.lossy_disk.loss_laws import scaled_losses
from kernels.lossy_disk.rk4 import inertia
from kernels.lossy_disk.step_size import RELATIVE_STEP
from kernels.native.entry import entry

#: Step of a single motion over that of the atlases, which repeat a motion whose energy is not balanced.
_SHARE = 0.5

#: Steps after which a motion is abandoned.
_MOST_STEPS = 1.0e8


@kernel
def scaled_start(start, unit):
    """State (S, C, K, w, o, p) of a start (`kernels.lossy_disk.arrays.PARAMETERS`); `unit` is sqrt(R/g) in s."""
    S, C, _, w, o, s = scaled_state(
        start[row.TILT], start[row.TILT_RATE], start[row.PRECESSION_RATE], start[row.ROLL_RATE], unit
    )
    return S, C, 1.0 / C, w, o, (1.0 + start[row.ALPHA]) * s


@kernel
def case_of(start, settings):
    """`Case` of a start and of the settings of a single motion, without a criterion."""
    losses = scaled_losses(
        (start[row.ROLLING_FRICTION], start[row.PIVOTING_FRICTION], start[row.CONTOUR_FRICTION]),
        start[row.CONTOUR_DAMPING],
        (start[row.AIR_VISCOSITY], start[row.AIR_DENSITY]),
        (start[row.MASS], start[row.RADIUS], start[row.GRAVITY]),
        settings[row.TRAJECTORY_AIR_LAW],
    )
    unit, longest = math.sqrt(start[row.RADIUS] / start[row.GRAVITY]), settings[row.TRAJECTORY_STEP]
    relative = settings[row.TRAJECTORY_RELATIVE_STEP]
    return Case(
        inertia(start[row.ALPHA]),
        losses,
        settings[row.TRAJECTORY_FLAT_TILT],
        math.cos(settings[row.TRAJECTORY_FLAT_TILT]),
        start[row.FRICTION],
        start[row.TILT],
        relative if relative > 0.0 else _SHARE * RELATIVE_STEP,
        longest / unit if longest > 0.0 else math.inf,
    )


@kernel
def _carried(place, before, after, h, case):
    """Roll angle and contact point (over R), one leap later whose step has the scaled length h."""
    if all_held(before.senses):
        return place
    angle, x, y = place
    middle, gain = next_state(before.state, before.senses, case.inertia, case.losses, 0.5 * h)
    end, _ = next_state(before.state, before.senses, case.inertia, case.losses, h)
    heading_0, heading_1, heading_2 = before.ledger[0], before.ledger[0] + gain[0], after.ledger[0]
    roll_0, roll_1, roll_2 = before.state[3], middle[3], end[3]
    side = roll_0 * math.sin(heading_0) + 4.0 * roll_1 * math.sin(heading_1) + roll_2 * math.sin(heading_2)
    ahead = roll_0 * math.cos(heading_0) + 4.0 * roll_1 * math.cos(heading_1) + roll_2 * math.cos(heading_2)
    sixth = h / 6.0
    return angle + sixth * (roll_0 + 4.0 * roll_1 + roll_2), x - sixth * side, y + sixth * ahead


@kernel
def _held(senses):
    """What friction holds, as bits (`kernels.lossy_disk.arrays.SAMPLES`)."""
    roll = 1.0 if senses.roll == 0.0 else 0.0
    turn = 2.0 if senses.turn == 0.0 else 0.0
    return roll + turn + (4.0 if all_held(senses) else 0.0)


@kernel
def _record(samples, i, motion, place, case, unit, radius):
    S, _, w, f, v = motion.state
    angle, x, y = place
    samples[row.TILT, i] = tilt_of(motion.state)
    samples[row.TILT_RATE, i] = w / unit
    samples[row.PRECESSION_RATE, i] = (v - f * S) / unit
    samples[row.ROLL_RATE, i] = f / unit
    samples[row.SAMPLE_HEADING, i] = motion.ledger[0]
    samples[row.SAMPLE_ROLL_ANGLE, i] = angle
    samples[row.SAMPLE_CONTACT_X, i] = radius * x
    samples[row.SAMPLE_CONTACT_Y, i] = radius * y
    samples[row.SAMPLE_ROLLING_LOSS, i] = motion.ledger[2]
    samples[row.SAMPLE_PIVOTING_LOSS, i] = motion.ledger[3]
    samples[row.SAMPLE_CONTOUR_LOSS, i] = motion.ledger[4]
    samples[row.SAMPLE_DAMPING_LOSS, i] = motion.ledger[5]
    samples[row.SAMPLE_AIR_LOSS, i] = motion.ledger[6]
    across, along, forces = contact_forces(motion.state, motion.senses, case.inertia, case.losses)
    samples[row.SAMPLE_NORMAL_FORCE, i] = forces.normal
    samples[row.SAMPLE_FRICTION_ACROSS, i], samples[row.SAMPLE_FRICTION_ALONG, i] = across, along
    samples[row.SAMPLE_HELD, i] = _held(motion.senses)


@entry(
    start="float64[::1]", settings="float64[::1]", times="float64[::1]", samples="float64[:, ::1], written"
)
def trajectory(start, settings, times, samples):
    """Integrate one start and record it at the given times.

    Parameters
    ----------
    start : float64[len(PARAMETERS)]
        |tilt| below flat_tilt.
    settings : float64[len(TRAJECTORY_SETTINGS)]
    times : float64[n]
        Increasing, from 0 [s].
    samples : float64[len(SAMPLES), n], written

    Returns
    -------
    (ending, filled, last, steps)
        A code of `kernels.lossy_disk.endings`; how many columns were written; the time [s] of the last one, which is
        that of the ending; the steps made. A disk that has come to rest or that friction holds for ever fills no more.
    """
    unit, radius = math.sqrt(start[row.RADIUS] / start[row.GRAVITY]), start[row.RADIUS]
    case, state = case_of(start, settings), scaled_start(start, unit)
    motion, event = begun(state, case, math.inf)
    tilt, place, ending = tilt_of(state), (0.0, 0.0, 0.0), ending_of(event)
    record = Record(tilt, tilt, math.nan, 0.0, 0.0)
    _record(samples, 0, motion, place, case, unit, radius)
    if ending != MOVING:
        return ending, 1, 0.0, 0
    for i in range(1, len(times)):
        until = times[i] / unit
        while motion.time < until:
            before = motion
            motion, h, event = leap(before, case, until, math.inf)
            record = recorded(record, motion, event, case)
            place = _carried(place, before, motion, h, case)
            ending = UNRESOLVED if endless(record) or record.steps > _MOST_STEPS else ending_of(event)
            if ending != MOVING:
                _record(samples, i, motion, place, case, unit, radius)
                if ending == FLAT:
                    samples[row.TILT, i] = math.copysign(
                        settings[row.TRAJECTORY_FLAT_TILT], samples[row.TILT, i]
                    )
                return ending, i + 1, unit * motion.time, int(record.steps)
        _record(samples, i, motion, place, case, unit, radius)
    return HORIZON, len(times), times[-1], int(record.steps)
