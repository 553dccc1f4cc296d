"""The stated errors of a motion with losses, from the imbalance of its energy and from its steps.

The imbalance decides whether steps are short enough, but says little about how far a motion is ahead of the true one.
So the stated errors are proportional to the tolerance, which sets the length of the steps. They were checked on 2,010
random mixtures of all laws and motions (`tests/lossy_cells.py`, seed 5) against the same kernels with a tolerance of
1e-11. One extreme tilt was off by ten times its stated error. In all others the largest error, as a share of the
stated one, was a tenth for a time, three quarters for an extreme tilt, a half for a heading and a path, and a third
for the tilt at the end; half of them are below a thousandth. All stated errors except those of the extreme tilts also
contain the lag of a motion that passes a maximum of its potential slowly (`kernels.lossy_disk.lag`). In 2,010 motions
with smaller losses, where such passes are more common, the errors were at most 0.5 of the stated error for the time,
0.6 for heading and path and 0.7 for the tilt at the end, except for one small tilt with an error of 8e-8 rad
where 3.5e-8 was stated. Of 200,000 motions that start near a steady motion (`lossy_cells.near_steady`), one extreme
tilt exceeds its stated error, 2.5 times, by 6e-7 rad.

The time at which a nutating wobble is flat is known better, and so are the sources of its error (`of_wobble`). The
median overestimate in 10,000 wobbles is a factor of 54; with a share of the tolerance only it would be 1,500.
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

#: Relative error of a time over the tolerance, and of an extreme tilt over the tolerance.
_SHARE_OF_TIME, _SHARE_OF_TILT = 64.0, 32.0

#: Error of heading and path (over R), divided by the tolerance and by the sum of both, the time, and their rates at
#: the end.
_SHARE_OF_WAY = 64.0

#: Limits of a nutating wobble: the largest nutation (`nutation`) of its start, the least magnitude of its tilts.
_MOST_NUTATION, _LEAST_TILT = 0.5, 0.5

#: Relative error of the time at which such a wobble is flat: factors of (relative step)^4 nutation^2; of the
#: imbalance as a share of the losses; of the tolerance times the shares of rolling friction, pivoting friction,
#: contour friction, and air. Of 10,000 wobbles, the worst needs 0.6 of this sum, except for one that turned next to
#: the tilt where it is flat.
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
    """Return the amplitude of the tilt about a steady motion, over the inclination, for which cos(tilt) is used.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p (`kernels.lossy_disk.equations`).
    alpha : float

    Returns
    -------
    float
        For small amplitudes, the same at every moment of an oscillation.
    """
    S, C, K, w, o, p = state
    T, of_disk, constants = S * K, inertia(alpha), without_losses(alpha)
    pull, _ = force((S, C, T, w, o, of_disk.i_inverse * p), constants)
    scale = C / math.sqrt(fastest_rate((S, C, T, w, o, p), 0.0, of_disk))
    return math.hypot(w, constants[0] * pull * scale) * scale / C


@kernel
def wobbles(ending, swing, least, greatest):
    """Return whether a motion with these extreme tilts and this nutation at its start is a wobble that ended flat."""
    steep = least * greatest > 0.0 and min(abs(least), abs(greatest)) > _LEAST_TILT
    return ending == FLAT and steep and swing < _MOST_NUTATION


@kernel
def rate_near_flat(C, alpha):
    """Return the precession rate of a steady wobble of a nearly flat disk; C is the cosine of its tilt."""
    return math.sqrt(2.0 / (alpha * C))


@kernel
def stated_errors(ending, motion, alpha, peak, imbalance, tolerance):
    """Return the errors of a motion without its lag.

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
    # near flat, the error of a tilt is inversely proportional to its cosine; a disk that friction stopped has moved
    # by about the square root of the energy that friction took
    size = max(peak, math.sqrt(lost)) if speed == 0.0 and lost > 0.0 else peak
    tilt_error = _SHARE_OF_TILT * tolerance * size + imbalance / math.cos(peak)
    if ending != FLAT:
        tilt_error += _SHARE_OF_TIME * tolerance * time * abs(speed)
    # a disk near flat turns about as fast as a steady wobble there, even if friction has slowed it down since
    fastest = abs(roll_rate) + abs(turning_rate) + rate_near_flat(math.cos(peak), alpha)
    off = _SHARE_OF_WAY * tolerance * (abs(turned) + path + time + fastest)
    return Errors(tilt_error, 0.0 if ending == HORIZON else late, off, off)


@kernel
def of_wobble(errors, motion, swing, imbalance, tolerance, relative_step):
    """Return the `Errors` of a nutating wobble that ended flat (`wobbles`).

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
    A wobble does not amplify the errors of its steps, and without nutation it makes almost none. With nutation, the
    error of the oscillation, of fourth order in the step, changes the mean power. Friction that changes its direction
    does so too.
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
    """Return an error, or the largest possible one if a motion could not be followed."""
    return error if 0.0 <= error < math.inf else all_of_it


@kernel
def late_errors(errors, ending, late, change, swing, time, way):
    """Return the errors of a motion including its lag.

    Parameters
    ----------
    errors : Errors
        Errors without the lag.
    ending : int
    late : kernels.lossy_disk.lag.Lag
    change : kernels.lossy_disk.lag.Change
        Change of the last state within the time of the lag.
    swing : float
        Difference of the extreme tilts [rad].
    time, way : float
        Errors stated for the time, and for heading and path, if the motion cannot be followed.
    """
    return Errors(
        errors.tilt + min(_stated(change.tilt, swing), swing),
        errors.time + (0.0 if ending == HORIZON else _stated(late.time, time)),
        errors.heading + _stated(late.turned, way) + _stated(change.heading, way),
        errors.path + _stated(late.rolled, way) + _stated(change.path, way),
    )
