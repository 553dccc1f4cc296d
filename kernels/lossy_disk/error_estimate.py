"""The stated errors of a motion with losses: the difference of its results with two step lengths.

A cell is integrated twice. The steps of the first pass are longer by a factor of 2.5, and its tolerance is larger by
the fourth power of that; the results are those of the second pass. For steps that are short enough for the method of
order 4, the error of the second pass is a fortieth of the difference. Whatever amplifies an error, such as a slow
pass of a maximum of the potential, amplifies the difference as well.

In 20,000 random mixtures of all laws and motions (`tests/lossy_cells.py`), compared with the same kernels and a
tolerance of 1e-11, two cells were wrong by more than their stated errors: an extreme tilt by 1.1 times its error, and a
wobble that turns so close to the tilt at which it counts as flat that both passes are flat a nutation too late. The
median of stated over true times is about 300.
"""

from typing import NamedTuple

from kernels.jit import kernel
from kernels.lossy_disk.endings import HORIZON

#: Least error over the size of a result: this multiple of the tolerance, and this share of the largest relative
#: difference of any result. One result of both passes may agree by accident.
_OF_TOLERANCE, _OF_OTHERS = 2.0, 0.5


class Outcome(NamedTuple):
    """The results of a pass (scaled) that have a stated error.

    Attributes
    ----------
    ending : float
    time : float
        At the ending.
    tilt, least, greatest : float
        Tilt at the ending and extreme tilts [rad].
    turned, path : float
        Heading turned [rad], path over R.
    """

    ending: float
    time: float
    tilt: float
    least: float
    greatest: float
    turned: float
    path: float


class Errors(NamedTuple):
    """Errors of the tilts [rad], of the time until the ending, of the heading [rad] and of the path over R (scaled)."""

    tilt: float
    time: float
    heading: float
    path: float


@kernel
def stated_errors(before, after, tolerance):
    """Return the `Errors` of the second of two passes with the same ending.

    Parameters
    ----------
    before, after : Outcome
    tolerance : float
        Of the energy, over m g R.
    """
    late, apart = abs(after.time - before.time), abs(after.path - before.path)
    turned, way = abs(after.turned - before.turned), abs(after.turned) + after.path + after.time
    tilts = max(
        abs(after.tilt - before.tilt), abs(after.least - before.least), abs(after.greatest - before.greatest)
    )
    least = _OF_TOLERANCE * tolerance
    if way > 0.0:
        least += _OF_OTHERS * max(late, turned, apart) / way
    return Errors(
        tilts + least * max(abs(after.least), abs(after.greatest)),
        0.0 if after.ending == HORIZON else late + least * after.time,
        turned + least * way,
        apart + least * way,
    )
