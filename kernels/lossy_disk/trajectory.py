"""One motion with losses sampled in time, with the path of the contact point on the plane.

The motion advances by the leaps of `kernels.lossy_disk.follow`, so dry friction seizes, reverses and lets go at the
exact times. Roll angle and path are integrals over the state, computed with fourth order by Simpson's rule over three
states of each step.
"""

import math
from typing import NamedTuple

from kernels.disk.equations import scaled_state
from kernels.jit import kernel
from kernels.lossy_disk import arrays as row
from kernels.lossy_disk.contact import all_held, contact_forces
from kernels.lossy_disk.contact_motion import contact_step, lever
from kernels.lossy_disk.endings import FLAT, HORIZON, UNRESOLVED
from kernels.lossy_disk.events import Case
from kernels.lossy_disk.follow import (
    MOVING,
    Record,
    ending_of,
    endless,
    energy_of,
    leap,
    recorded,
    tilt_of,
)
from kernels.lossy_disk.follow import begun as set_going
from kernels.lossy_disk.loss_coefficients import Losses, scaled_losses
from kernels.lossy_disk.rk4 import Inertia, inertia
from kernels.lossy_disk.step_size import RELATIVE_STEP
from kernels.native.entry import entry

#: Step of a single motion over the step of atlases, which repeat a motion if its energy balance fails.
_SHARE = 0.5

#: Steps after which a motion is abandoned.
_MOST_STEPS = 1.0e8


class Beginning(NamedTuple):
    """Quantities that follow from a start.

    Attributes
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p.
    inertia : kernels.lossy_disk.rk4.Inertia
    losses : kernels.lossy_disk.loss_coefficients.Losses
    friction : float
        Coefficient of friction; infinite where the disk cannot slip.
    radius, unit : float
        R [m] and sqrt(R/g) [s].
    """

    state: tuple
    inertia: Inertia
    losses: Losses
    friction: float
    radius: float
    unit: float


# Other bodies replace the following functions by functions of the same names (`kernels.lossy_bodies.trajectory`).


@kernel
def beginning(start, settings):
    """Return the `Beginning` of a start, shape (len(PARAMETERS), 1)."""
    radius, gravity, alpha = start[row.RADIUS, 0], start[row.GRAVITY, 0], start[row.ALPHA, 0]
    losses = scaled_losses(0, start, settings[row.TRAJECTORY_AIR_LAW], 1.0)
    unit = math.sqrt(radius / gravity)
    S, C, _, w, o, s = scaled_state(
        start[row.TILT, 0], start[row.TILT_RATE, 0], start[row.PRECESSION_RATE, 0], start[row.ROLL_RATE, 0],
        unit,
    )  # fmt: skip
    state = S, C, 1.0 / C, w, o, (1.0 + alpha) * s
    return Beginning(state, inertia(alpha), losses, start[row.FRICTION, 0], radius, unit)


@kernel
def contact_speed(state, inertia):
    """Return the speed of the contact point along its track, and across it towards a positive tilt, over sqrt(g R)."""
    return state[3], 0.0


@kernel
def height(S, C, inertia):
    """Return the height of the centre of mass, over R."""
    return C


@kernel
def contact_velocity(state, heading, inertia):
    """Return the velocity (x, y) of the contact point over the plane, over sqrt(g R)."""
    ahead, aside = contact_speed(state, inertia)
    sine, cosine = math.sin(heading), math.cos(heading)
    return aside * cosine - ahead * sine, ahead * cosine + aside * sine


@kernel
def case_of(begun, tilt, settings):
    """Return the `Case` of a single motion that begins at a tilt, without a criterion."""
    relative, longest = settings[row.TRAJECTORY_RELATIVE_STEP], settings[row.TRAJECTORY_STEP]
    return Case(
        begun.inertia,
        begun.losses,
        settings[row.TRAJECTORY_FLAT_TILT],
        math.cos(settings[row.TRAJECTORY_FLAT_TILT]),
        begun.friction,
        tilt,
        relative if relative > 0.0 else _SHARE * RELATIVE_STEP,
        longest / begun.unit if longest > 0.0 else math.inf,
    )


@kernel
def _carried(place, before, after, h, case):
    """Return roll angle and contact point (over R) after a leap whose step has the scaled length h."""
    if all_held(before.senses):
        return place
    angle, x, y = place
    middle, gain = contact_step(before.state, before.senses, case.inertia, case.losses, 0.5 * h)
    end, _ = contact_step(before.state, before.senses, case.inertia, case.losses, h)
    heading, sixth = before.ledger[0], h / 6.0
    x_0, y_0 = contact_velocity(before.state, heading, case.inertia)
    x_1, y_1 = contact_velocity(middle, heading + gain[0], case.inertia)
    x_2, y_2 = contact_velocity(end, after.ledger[0], case.inertia)
    return (
        angle + sixth * (before.state[3] + 4.0 * middle[3] + end[3]),
        x + sixth * (x_0 + 4.0 * x_1 + x_2),
        y + sixth * (y_0 + 4.0 * y_1 + y_2),
    )


@kernel
def _held(senses):
    """Return the rates that friction holds, as bits (`kernels.lossy_disk.arrays.SAMPLES`)."""
    roll = 1.0 if senses.roll == 0.0 else 0.0
    turn = 2.0 if senses.turn == 0.0 else 0.0
    return roll + turn + (4.0 if all_held(senses) else 0.0)


@kernel
def _record(samples, i, tilt, motion, place, case, unit, radius):
    angle, x, y = place
    _, _, w, f, v = motion.state
    # the steps do not conserve S^2 + C^2 = 1 exactly
    S, C = math.sin(tilt), math.cos(tilt)
    state = S, C, w, f, v
    samples[row.TILT, i] = tilt
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
    across, along, forces = contact_forces(state, motion.senses, case.inertia, case.losses)
    samples[row.SAMPLE_NORMAL_FORCE, i] = forces.normal
    samples[row.SAMPLE_FRICTION_ACROSS, i], samples[row.SAMPLE_FRICTION_ALONG, i] = across, along
    samples[row.SAMPLE_HELD, i] = _held(motion.senses)
    arm = radius * lever(S, C, case.inertia)
    samples[row.SAMPLE_CENTRE_X, i] = radius * x + arm * math.cos(motion.ledger[0])
    samples[row.SAMPLE_CENTRE_Y, i] = radius * y + arm * math.sin(motion.ledger[0])
    samples[row.SAMPLE_CENTRE_Z, i] = radius * height(S, C, case.inertia)
    samples[row.SAMPLE_ENERGY, i] = energy_of(state, case.inertia)


@entry(
    start="float64[:, ::1]", settings="float64[::1]", times="float64[::1]", samples="float64[:, ::1], written"
)
def trajectory(start, settings, times, samples):
    """Integrate one start and record it at the given times.

    Parameters
    ----------
    start : float64[len(PARAMETERS), 1]
        |tilt| below flat_tilt.
    settings : float64[len(TRAJECTORY_SETTINGS)]
    times : float64[n]
        Increasing, from 0 [s].
    samples : float64[len(SAMPLES), n], written

    Returns
    -------
    (ending, filled, last, steps)
        A code of `kernels.lossy_disk.endings`; the number of columns written; the time [s] of the last column, which
        is the ending; the number of steps. Once a disk rests or friction holds it forever, no more columns are
        filled.
    """
    begun = beginning(start, settings)
    radius, unit = begun.radius, begun.unit
    case = case_of(begun, start[row.TILT, 0], settings)
    motion, event = set_going(begun.state, case, math.inf)
    tilt, place, ending = tilt_of(motion.state), (0.0, 0.0, 0.0), ending_of(event)
    record = Record(tilt, tilt, math.nan, 0.0, 0.0)
    _record(samples, 0, tilt, motion, place, case, unit, radius)
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
                tilt = tilt_of(motion.state)
                if ending == FLAT:
                    tilt = math.copysign(case.flat_tilt, tilt)
                _record(samples, i, tilt, motion, place, case, unit, radius)
                return ending, i + 1, unit * motion.time, int(record.steps)
        _record(samples, i, tilt_of(motion.state), motion, place, case, unit, radius)
    return HORIZON, len(times), times[-1], int(record.steps)
