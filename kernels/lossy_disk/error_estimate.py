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

The time at which a nutating wobble is flat is better known than that, and what makes its error is too (`of_wobble`). Of
10,000 it is stated 54 times too large in the median, where a share of the tolerance alone is 1,500 times.
"""

import math
from typing import NamedTuple

from kernels.disk.equations import force
from kernels.disk.equations import inertia as without_losses
from kernels.jit import kernel
from kernels.lossy_disk.endings import FLAT, HORIZON
from kernels.lossy_disk.rk4 import inertia
from kernels.lossy_disk.step_control import lost_energy
from kernels.lossy_disk.step_size import fastest_rate

#: Relative error of a time over the tolerance, and the same of an extreme tilt.
_SHARE_OF_TIME, _SHARE_OF_TILT = 64.0, 32.0

#: Error of heading and of path (over R) over the tolerance and the sum of both, the time, and their rates at the end.
_SHARE_OF_WAY = 64.0

#: What counts as a nutating wobble: the largest nutation (`nutation`) of its start, the least magnitude of its tilts.
_MOST_NUTATION, _LEAST_TILT = 0.5, 0.5

#: Relative error of the time at which such a wobble is flat: over the fourth power of the relative step and the square
#: of the nutation; over the imbalance as a share of the losses; over the tolerance and the share of what rolling
#: friction, pivoting friction, the contour, and air took. Of 10,000 wobbles the worst needs 0.6 of all that, but for
#: one that turned next to the tilt where it is flat.
_OF_NUTATION, _OF_IMBALANCE = 0.3, 1.4
_OF_ROLLING, _OF_PIVOTING, _OF_RUBBING, _OF_AIR = 8.0, 300.0, 0.4, 1.0


class Errors(NamedTuple):
    """Errors of the tilts [rad], of the time until the ending, of the heading [rad] and of the path over R (scaled)."""

    tilt: float
    time: float
    heading: float
    path: float


@kernel
def nutation(state, alpha):
    """Size of the swing of the tilt about a steady motion, over the inclination: cos(tilt) stands for that.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p (`kernels.lossy_disk.equations`).
    alpha : float

    Returns
    -------
    float
        Of small swings it is the same at each moment of one.
    """
    S, C, K, w, o, p = state
    T, of_disk, constants = S * K, inertia(alpha), without_losses(alpha)
    pull, _ = force((S, C, T, w, o, of_disk.i_inverse * p), constants)
    scale = C / math.sqrt(fastest_rate((S, C, T, w, o, p), 0.0, of_disk))
    return math.hypot(w, constants[0] * pull * scale) * scale / C


@kernel
def wobbles(ending, swing, least, greatest):
    """Whether a motion with these extreme tilts and this nutation at its start is a wobble that ended flat."""
    steep = least * greatest > 0.0 and min(abs(least), abs(greatest)) > _LEAST_TILT
    return ending == FLAT and steep and swing < _MOST_NUTATION


@kernel
def rate_near_flat(C, alpha):
    """Precession rate of a steady wobble of a disk that is nearly flat; C is the cosine of its tilt."""
    return math.sqrt(2.0 / (alpha * C))


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
    fastest = abs(roll_rate) + abs(turning_rate) + rate_near_flat(math.cos(peak), alpha)
    off = _SHARE_OF_WAY * tolerance * (abs(turned) + path + time + fastest)
    return Errors(tilt_error, 0.0 if ending == HORIZON else late, off, off)


@kernel
def of_wobble(errors, motion, swing, imbalance, tolerance, relative_step):
    """`Errors` of a nutating wobble that ended flat (`wobbles`).

    Parameters
    ----------
    errors : Errors
        Of `stated_errors`.
    motion : kernels.lossy_disk.follow.Motion
        At the ending.
    swing : float
        `nutation` of its start.
    imbalance, tolerance : float
        Of the energy, over m g R.
    relative_step : float
        The longest step of this cell over the time scale of its motion.

    Notes
    -----
    A wobble does not multiply the errors of its steps, and one that does not nutate hardly makes any: the error of the
    swing, of fourth order in the step, changes the mean power. So does friction whose direction changes.
    """
    lost = lost_energy(motion.ledger)
    if not lost > 0.0:
        return errors
    _, _, rolled, pivoted, rubbed, damped, blown = motion.ledger
    laws = _OF_ROLLING * rolled + _OF_PIVOTING * pivoted + _OF_RUBBING * (rubbed + damped) + _OF_AIR * blown
    off = relative_step * relative_step * swing
    share = _OF_NUTATION * (off * off) + (_OF_IMBALANCE * imbalance + tolerance * laws) / lost
    return Errors(errors.tilt, min(errors.time, motion.time * share), errors.heading, errors.path)


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
