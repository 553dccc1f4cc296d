"""How far a motion may be ahead of the true one, or behind it, where it all but stops near a maximum of its potential.

Such a motion takes the longer to pass the maximum the less energy it has there, and an error of the energy, however
small, is much of that: each pass adds to how late it is. The extreme tilts know nothing of it, the tilt at the end of a
duration is off by what the disk tilts in that time.
"""

import math

from kernels.disk.equations import force, inertia
from kernels.disk.rk4 import step
from kernels.jit import internal

#: A nutation, from wherever it is looked at, lies between three turning points. Steps after which it is long enough.
_TURNS, _MOST_STEPS = 3, 20000


@internal
def lag(state, alpha, time, imbalance, relative_step):
    """Scaled time by which a motion may be ahead of the true one or behind it.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p (`kernels.lossy_disk.equations`) at the end of the motion.
    alpha : float
    time : float
        Scaled time of the end.
    imbalance : float
        Error of the energy, over m g R.
    relative_step : float
        Step over the time scale of the motion.

    Returns
    -------
    float

    Notes
    -----
    Near the maximum, where the tilt obeys w' = k^2 x, an energy that is wrong by e delays the pass by about e times the
    integral of dt / (w^2 + w'^2). The last nutation, followed back without losses, stands for all: a motion that loses
    energy passes such a maximum once or twice. From the start until its first turning point a motion is not late: its
    error is made where it is fast, later.
    """
    constants = inertia(alpha)
    S, C, _, w, o, p = state
    present = S, C, S / C, w, o, constants[3] * p
    slowness, latest, gone, turns, steps = 0.0, 0.0, 0.0, 0, 0
    while turns < _TURNS and gone < time and steps < _MOST_STEPS:
        _, C, _, w, o, s = present
        pull, stiffness = force(present, constants)
        fastest = C * C * constants[0] * (1.0 + 2.0 * constants[1] * s * s) + o * o + w * w
        h = min(relative_step * C / math.sqrt(fastest), time - gone)
        if stiffness < 0.0:
            acceleration = constants[0] * pull
            latest += h / (w * w + acceleration * acceleration)
        present = step(present, constants, -h)
        gone += h
        steps += 1
        # a start at rest is no turning point
        if w * present[3] < 0.0 and time - gone > h:
            slowness, latest, turns = slowness + latest, 0.0, turns + 1
    return imbalance * slowness * (time / gone)
