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
def _unforced(state, constants):
    """Return S, C, T, w, o, s of a state that holds K and p: the state of the disk without losses."""
    S, C, _, w, o, p = state
    return S, C, S / C, w, o, constants[3] * p


@internal
def _length(state, constants, relative_step):
    """Return the length of a step of the disk without losses, in scaled time."""
    _, C, _, w, o, s = state
    fastest = C * C * constants[0] * (1.0 + 2.0 * constants[1] * s * s) + o * o + w * w
    return relative_step * C / math.sqrt(fastest)


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
        Step over the time scale of the motion, no longer than the motion's own steps.

    Returns
    -------
    float

    Notes
    -----
    Near the maximum, where the tilt obeys w' = k^2 x, an energy that is wrong by e delays the pass by about e times the
    integral of dt / (w^2 + w'^2). The last nutation, followed back without losses, stands for all: a motion that loses
    energy passes such a maximum once or twice. Following it back takes steps of its own size or shorter: with longer
    ones it passes faster than it did. From the start until its first turning point a motion is not late: its
    error is made where it is fast, later.
    """
    constants = inertia(alpha)
    present = _unforced(state, constants)
    slowness, latest, gone, turns, steps = 0.0, 0.0, 0.0, 0, 0
    while turns < _TURNS and gone < time and steps < _MOST_STEPS:
        w = present[3]
        pull, stiffness = force(present, constants)
        h = min(_length(present, constants, relative_step), time - gone)
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


@internal
def astray(state, alpha, late, relative_step):
    """Angle [rad] by which the tilt changes within a time, before and after a state.

    Parameters
    ----------
    state : tuple of 6 floats
        As of `lag`.
    alpha : float
    late : float
        Scaled time.
    relative_step : float
        Step over the time scale of the motion.

    Returns
    -------
    float
        NaN if the motion cannot be followed so far.

    Notes
    -----
    At a turning point the rate of the tilt says nothing of it: a little later the disk turns fast.
    """
    constants = inertia(alpha)
    begun = _unforced(state, constants)
    tilt, most = math.asin(begun[0]), 0.0
    for sense in (-1.0, 1.0):
        present, gone, steps = begun, 0.0, 0
        while gone < late and steps < _MOST_STEPS:
            h = min(_length(present, constants, relative_step), late - gone)
            present = step(present, constants, sense * h)
            apart = abs(math.asin(present[0]) - tilt)
            # so written, a NaN stays
            most = most if apart <= most else apart
            gone += h
            steps += 1
    return most
