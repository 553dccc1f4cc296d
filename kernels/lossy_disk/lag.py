"""Lag of a motion relative to the true one, after it has almost stopped near a maximum of its potential.

The less energy such a motion has at the maximum, the longer the pass takes, and even a tiny error of the energy is a
large part of that little energy. Each pass adds to the lag. The extreme tilts do not depend on it. An ending that is
an event, such as a disk falling flat, is late by the lag, and the disk turns and rolls as long as it lingers near the
maximum. At the end of a fixed duration, tilt, heading and path also have the errors that they accumulate during the
lag.
"""

import math
from typing import NamedTuple

from kernels.disk.equations import force
from kernels.disk.equations import inertia as without_losses
from kernels.disk.rk4 import step as free_step
from kernels.jit import kernel

#: Turning points that certainly enclose a full nutation, and the largest number of steps to search for them.
_TURNS, _MOST_STEPS = 3, 20000

_NOTHING = 0.0, 0.0, 0.0


class Lag(NamedTuple):
    """Lag from slow passes of maxima of the potential (scaled).

    Attributes
    ----------
    time : float
        Magnitude of the lag.
    turned, rolled : float
        Angle by which the heading turned, and length of the path over R, near the maxima during the lag.

    All are NaN if the motion cannot be followed.
    """

    time: float
    turned: float
    rolled: float


class Change(NamedTuple):
    """Largest changes of a motion within a time before or after a state.

    Attributes
    ----------
    tilt, heading : float
        Angles [rad], NaN if the motion cannot be followed that far.
    path : float
        Over R, NaN likewise.
    """

    tilt: float
    heading: float
    path: float


@kernel
def state_without_losses(state, constants):
    """Return S, C, T, w, o, s, the state of a disk without losses, from a state that contains K and p."""
    S, C, _, w, o, p = state
    return S, C, S / C, w, o, constants[3] * p


@kernel
def _rates(state):
    """Return the precession rate and the magnitude of the roll rate of a state as from `state_without_losses`."""
    _, C, T, _, o, s = state
    return o / C, abs(s - o * T)


@kernel
def _sum(total, more, share):
    """Return `total` + `share` * `more`, of three numbers each."""
    a, b, c = total
    d, e, f = more
    return a + share * d, b + share * e, c + share * f


@kernel
def length_of_step(state, constants, relative_step):
    """Return the length of a step of the disk without losses, in scaled time."""
    _, C, _, w, o, s = state
    fastest = C * C * constants[0] * (1.0 + 2.0 * constants[1] * s * s) + o * o + w * w
    return relative_step * C / math.sqrt(fastest)


@kernel
def pull_and_stiffness(state, constants):
    """Return the acceleration of the tilt and the second derivative of the potential."""
    pull, stiffness = force(state, constants)
    return constants[0] * pull, stiffness


@kernel
def _passing(state, constants, h):
    """Return w^2 + w'^2, and near a maximum the contributions of a step to the integrals of time, heading and path."""
    w = state[3]
    acceleration, stiffness = pull_and_stiffness(state, constants)
    square = w * w + acceleration * acceleration
    if stiffness >= 0.0:
        return square, _NOTHING
    slow = h / square
    turning, rolling = _rates(state)
    return square, (slow, slow * abs(turning), slow * rolling)


@kernel
def _begun(start, constants, time, relative_step, fastest, flat):
    """Return the lag of a motion up to its first turning point: times, heading and path, per energy.

    It is weighted by how fast the motion has been so far: no lag for a disk that starts slowly near the maximum.
    """
    present, total, gone, steps, before = start, _NOTHING, 0.0, 0, 0.0
    while gone < time and steps < _MOST_STEPS and present[1] > flat:
        h = min(length_of_step(present, constants, relative_step), time - gone)
        square, slow = _passing(present, constants, h)
        before = max(before, square)
        total = _sum(total, slow, before / fastest)
        present = free_step(present, constants, h)
        gone, steps = gone + h, steps + 1
    return total


@kernel
def lag(state, alpha, time, imbalance, relative_step, flat):
    """Return the magnitude of the lag, and the heading and path of that time near the maxima.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p (`kernels.lossy_disk.equations`) at the end of the motion.
    alpha : float
    time : float
        Scaled time of the end of the motion.
    imbalance : float
        Error of the energy, over m g R.
    relative_step : float
        Step over the time scale of the motion, at most the relative step of the motion itself.
    flat : float
        Cosine of the tilt at which the disk counts as flat; without its losses, the motion may have come from beyond
        it.

    Returns
    -------
    Lag

    Notes
    -----
    Near the maximum the tilt obeys w' = k^2 x. An error e of the energy delays the pass by about e times the integral
    of dt / (w^2 + w'^2). The last nutation, followed back without losses, represents all passes: a motion that loses
    energy passes such a maximum once or twice. If that was long before the end, this misses it: among 77 motions that
    pass upright, or turn short of it, by a share of 1e-10 to 1e-3 of a rate, the errors of three were up to five
    times larger than stated. The steps back have to be as short as the motion's own steps: with longer steps the
    motion would pass faster than it did.
    """
    constants = without_losses(alpha)
    present = state_without_losses(state, constants)
    slowness, latest, fastest = _NOTHING, _NOTHING, 0.0
    gone, since, turns, steps = 0.0, 0.0, 0, 0
    while turns < _TURNS and gone < time and steps < _MOST_STEPS:
        w, h = present[3], min(length_of_step(present, constants, relative_step), time - gone)
        square, slow = _passing(present, constants, h)
        fastest, latest = max(fastest, square), _sum(latest, slow, 1.0)
        present = free_step(present, constants, -h)
        gone, since, steps = gone + h, since + h, steps + 1
        if not present[1] > flat:
            slowness = _sum(slowness, latest, 1.0)
            break
        # a start at rest is not a turning point
        if w * present[3] < 0.0 and time - gone > h:
            slowness, latest, since, turns = _sum(slowness, latest, 1.0), _NOTHING, 0.0, turns + 1
    if not gone < time and turns < _TURNS and present[1] > flat:
        slowness = _sum(slowness, _begun(present, constants, since, relative_step, fastest, flat), 1.0)
    late, turned, rolled = slowness
    share = imbalance * (time / gone)
    return Lag(share * late, share * turned, share * rolled)


@kernel
def _larger(most, change):
    """Return the larger of two `Change`, component by component; NaN wins."""
    return Change(
        most.tilt if change.tilt <= most.tilt or most.tilt != most.tilt else change.tilt,
        most.heading if change.heading <= most.heading or most.heading != most.heading else change.heading,
        most.path if change.path <= most.path or most.path != most.path else change.path,
    )


@kernel
def drift_off_path(state, alpha, late, relative_step, flat):
    """Return the largest changes of tilt, heading and path within a time before and after a state.

    Parameters
    ----------
    state : tuple of 6 floats
        As for `lag`.
    alpha : float
    late : float
        Scaled time of the lag.
    relative_step : float
        Step over the time scale of the motion.
    flat : float
        Cosine of the tilt at which the disk counts as flat, which ends the motion.

    Returns
    -------
    Change

    Notes
    -----
    At a turning point the tilt rate is zero, but a little later the disk tilts fast. Likewise heading and path change
    fast near flat, where the disk precesses fast.
    """
    constants = without_losses(alpha)
    begun = state_without_losses(state, constants)
    tilt, most = math.asin(begun[0]), Change(0.0, 0.0, 0.0)
    for sense in (-1.0, 1.0):
        present, gone, steps = begun, 0.0, 0
        heading, path = 0.0, 0.0
        turning, rolling = _rates(begun)
        while gone < late and steps < _MOST_STEPS:
            h = min(length_of_step(present, constants, relative_step), late - gone)
            present = free_step(present, constants, sense * h)
            before, slower = turning, rolling
            turning, rolling = _rates(present)
            heading += 0.5 * h * (before + turning)
            path += 0.5 * h * (slower + rolling)
            apart = Change(abs(math.asin(present[0]) - tilt), abs(heading), path)
            most = _larger(most, apart)
            gone += h
            steps += 1
            if present[1] < flat:
                break
    return most
