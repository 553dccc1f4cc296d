"""What is stated as the errors of a motion with losses, from the imbalance of its energy and from its steps.

The imbalance decides whether a step is short enough, and says little about how far a motion is ahead of the true one.
So the stated errors are shares of the tolerance, which the length of the steps goes with. Of 2,010 random mixtures of
all laws and motions (`tests/lossy_cells.py`, seed 5), against the same kernels with a tolerance of 1e-11, two were
beyond: one that friction stops or lets go on by less than any error, which ended 2.6 % later, and one extreme tilt ten
times as far off. Of the others the largest error of a time was a tenth of the stated one, of an extreme tilt three
quarters, and half of them are below a thousandth. The tilt at the end of a duration is no extreme: what a motion that
passes a maximum of its potential slowly is late (`kernels.lossy_disk.lag`) is stated with it.
"""

import math

from kernels.jit import internal
from kernels.lossy_disk.endings import FLAT, HORIZON

#: Relative error of a time over the tolerance, and the same of an extreme tilt.
_SHARE_OF_TIME, _SHARE_OF_TILT = 64.0, 32.0


@internal
def stated_errors(ending, time, speed, peak, lost, imbalance, tolerance):
    """Errors of the extreme tilts [rad] and of the time until the ending (scaled).

    Parameters
    ----------
    ending : int
    time, speed : float
        Scaled time and rate of the tilt at the ending.
    peak : float
        Largest magnitude of the tilt [rad].
    lost : float
        Energy that friction and air took, over m g R.
    imbalance, tolerance : float
        Of the energy, over m g R.

    Returns
    -------
    (tilt_error, time_error)
    """
    late = _SHARE_OF_TIME * time * (tolerance + imbalance / (lost + imbalance + tolerance))
    # near flat a tilt is the more uncertain the smaller its cosine
    # what friction stopped is left of a motion as large as the root of the energy that it took
    size = max(peak, math.sqrt(lost)) if speed == 0.0 and lost > 0.0 else peak
    tilt_error = _SHARE_OF_TILT * tolerance * size + imbalance / math.cos(peak)
    if ending != FLAT:
        tilt_error += _SHARE_OF_TIME * tolerance * time * abs(speed)
    return tilt_error, 0.0 if ending == HORIZON else late
