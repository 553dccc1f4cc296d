"""One motion with losses sampled in time, with the path of the contact point on the plane.

The motion goes on by the leaps of `kernels.lossy_disk.follow`: what dry friction holds, reverses and lets go comes at
its moment. Roll angle and path are integrals over the state; Simpson's rule over the three states of a step keeps them
of fourth order.
"""

import math

from kernels.disk.equations import scaled_state
from kernels.jit import kernel
from kernels.lossy_disk.arrays import (
    AIR_DENSITY,
    AIR_VISCOSITY,
    ALPHA,
    CONTOUR_DAMPING,
    CONTOUR_FRICTION,
    FRICTION,
    GRAVITY,
    MASS,
    PIVOTING_FRICTION,
    PRECESSION_RATE,
    RADIUS,
    ROLL_RATE,
    ROLLING_FRICTION,
    SAMPLE_AIR_LOSS,
    SAMPLE_CONTACT_X,
    SAMPLE_CONTACT_Y,
    SAMPLE_CONTOUR_LOSS,
    SAMPLE_DAMPING_LOSS,
    SAMPLE_FRICTION_ACROSS,
    SAMPLE_FRICTION_ALONG,
    SAMPLE_HEADING,
    SAMPLE_HELD,
    SAMPLE_NORMAL_FORCE,
    SAMPLE_PIVOTING_LOSS,
    SAMPLE_ROLL_ANGLE,
    SAMPLE_ROLLING_LOSS,
    TILT,
    TILT_RATE,
    TRAJECTORY_AIR_LAW,
    TRAJECTORY_FLAT_TILT,
    TRAJECTORY_RELATIVE_STEP,
    TRAJECTORY_STEP,
)
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
        start[TILT], start[TILT_RATE], start[PRECESSION_RATE], start[ROLL_RATE], unit
    )
    return S, C, 1.0 / C, w, o, (1.0 + start[ALPHA]) * s


@kernel
def case_of(start, settings):
    """`Case` of a start and of the settings of a single motion, without a criterion."""
    losses = scaled_losses(
        (start[ROLLING_FRICTION], start[PIVOTING_FRICTION], start[CONTOUR_FRICTION]),
        start[CONTOUR_DAMPING],
        (start[AIR_VISCOSITY], start[AIR_DENSITY]),
        (start[MASS], start[RADIUS], start[GRAVITY]),
        settings[TRAJECTORY_AIR_LAW],
    )
    unit, longest = math.sqrt(start[RADIUS] / start[GRAVITY]), settings[TRAJECTORY_STEP]
    relative = settings[TRAJECTORY_RELATIVE_STEP]
    return Case(
        inertia(start[ALPHA]),
        losses,
        settings[TRAJECTORY_FLAT_TILT],
        math.cos(settings[TRAJECTORY_FLAT_TILT]),
        start[FRICTION],
        start[TILT],
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
    samples[TILT, i] = tilt_of(motion.state)
    samples[TILT_RATE, i] = w / unit
    samples[PRECESSION_RATE, i] = (v - f * S) / unit
    samples[ROLL_RATE, i] = f / unit
    samples[SAMPLE_HEADING, i] = motion.ledger[0]
    samples[SAMPLE_ROLL_ANGLE, i] = angle
    samples[SAMPLE_CONTACT_X, i] = radius * x
    samples[SAMPLE_CONTACT_Y, i] = radius * y
    samples[SAMPLE_ROLLING_LOSS, i] = motion.ledger[2]
    samples[SAMPLE_PIVOTING_LOSS, i] = motion.ledger[3]
    samples[SAMPLE_CONTOUR_LOSS, i] = motion.ledger[4]
    samples[SAMPLE_DAMPING_LOSS, i] = motion.ledger[5]
    samples[SAMPLE_AIR_LOSS, i] = motion.ledger[6]
    across, along, forces = contact_forces(motion.state, motion.senses, case.inertia, case.losses)
    samples[SAMPLE_NORMAL_FORCE, i] = forces.normal
    samples[SAMPLE_FRICTION_ACROSS, i], samples[SAMPLE_FRICTION_ALONG, i] = across, along
    samples[SAMPLE_HELD, i] = _held(motion.senses)


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
    unit, radius = math.sqrt(start[RADIUS] / start[GRAVITY]), start[RADIUS]
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
                    samples[TILT, i] = math.copysign(settings[TRAJECTORY_FLAT_TILT], samples[TILT, i])
                return ending, i + 1, unit * motion.time, int(record.steps)
        _record(samples, i, motion, place, case, unit, radius)
    return HORIZON, len(times), times[-1], int(record.steps)
