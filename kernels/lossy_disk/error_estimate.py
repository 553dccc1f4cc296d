"""What is stated as the errors of a motion with losses, from the imbalance of its energy and from its steps.

The imbalance decides whether a step is short enough, and says little about how far a motion is ahead of the true one.
So the stated errors are shares of the tolerance, which the length of the steps goes with. Of 2,010 random mixtures of
all laws and motions (`tests/lossy_cells.py`, seed 5), against the same kernels with a tolerance of 1e-11, one extreme
tilt was ten times as far off. Of the others the largest error of a time was a tenth of the stated one, of an extreme
tilt three quarters, of a heading and a path half, of the tilt at the end a third, and half of them are below a
thousandth. All but the extreme tilts also have what a motion that passes a maximum of its potential slowly is late
(`kernels.lossy_disk.lag`). Of 2,010 motions with less losses, of which more pass so, the errors were at most half of
the stated time, 0.6 of the stated heading and path and 0.7 of the stated tilt at the end, but for one small tilt that
was off by 8e-8 rad in place of 3.5e-8. Of 200,000 motions that start near a steady one (`lossy_cells.near_steady`) one
has an extreme tilt that is further off than stated, 2.5 times, 6e-7 rad.
"""

import math
from typing import NamedTuple

from kernels.jit import kernel
from kernels.lossy_disk.endings import FLAT, HORIZON
from kernels.lossy_disk.step_control import lost_energy

#: Relative error of a time over the tolerance, and the same of an extreme tilt.
_SHARE_OF_TIME, _SHARE_OF_TILT = 64.0, 32.0

#: Error of heading and of path (over R) over the tolerance and the sum of both, the time, and their rates at the end.
_SHARE_OF_WAY = 64.0


class Errors(NamedTuple):
    """Errors of the tilts [rad], of the time until the ending, of the heading [rad] and of the path over R (scaled)."""

    tilt: float
    time: float
    heading: float
    path: float


@kernel
def stated_errors(ending, motion, alpha, peak, imbalance, tolerance):
    """Errors of a motion that is not late.

    Parameters
    ----------
    ending : int
    motion : kernels.lossy_disk.follow.Motion
        At the ending.
    alpha : float
    peak : float
        Largest magnitude of the tilt [rad].
    imbalance, tolerance : float
        Of the energy, over m g R.

    Returns
    -------
    Errors
    """
    _, _, speed, roll_rate, turning_rate = motion.state
    turned, path, _, _, _, _, _ = motion.ledger
    # coarse steps may err by more than a loss
    time, lost = motion.time, max(lost_energy(motion.ledger), 0.0)
    late = _SHARE_OF_TIME * time * (tolerance + imbalance / (lost + imbalance + tolerance))
    # near flat a tilt is the more uncertain the smaller its cosine
    # what friction stopped is left of a motion as large as the root of the energy that it took
    size = max(peak, math.sqrt(lost)) if speed == 0.0 and lost > 0.0 else peak
    tilt_error = _SHARE_OF_TILT * tolerance * size + imbalance / math.cos(peak)
    if ending != FLAT:
        tilt_error += _SHARE_OF_TIME * tolerance * time * abs(speed)
    # a disk near flat turns about as fast as a steady wobble there, whether or not friction has slowed it down since
    fastest = abs(roll_rate) + abs(turning_rate) + math.sqrt(2.0 / (alpha * math.cos(peak)))
    off = _SHARE_OF_WAY * tolerance * (abs(turned) + path + time + fastest)
    return Errors(tilt_error, 0.0 if ending == HORIZON else late, off, off)


@kernel
def _stated(error, all_of_it):
    """Return an error, or all of what it is one of where a motion could not be followed."""
    return error if 0.0 <= error < math.inf else all_of_it


@kernel
def late_errors(errors, ending, late, change, swing, time, way):
    """Errors of a motion that may be late, or early.

    Parameters
    ----------
    errors : Errors
        Of one that is not.
    ending : int
    late : kernels.lossy_disk.lag.Lag
    change : kernels.lossy_disk.lag.Change
        Of its last state within the time by which it is late.
    swing : float
        Difference of the extreme tilts [rad].
    time, way : float
        What is stated of the time, and of heading and path, of a motion that cannot be followed.
    """
    return Errors(
        errors.tilt + min(_stated(change.tilt, swing), swing),
        errors.time + (0.0 if ending == HORIZON else _stated(late.time, time)),
        errors.heading + _stated(late.turned, way) + _stated(change.heading, way),
        errors.path + _stated(late.rolled, way) + _stated(change.path, way),
    )
