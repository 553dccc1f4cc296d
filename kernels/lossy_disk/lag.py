"""How far a motion may be ahead of the true one, or behind it, where it all but stops near a maximum of its potential.

Such a motion takes the longer to pass the maximum the less energy it has there, and an error of the energy, however
small, is much of that: each pass adds to how late it is. The extreme tilts know nothing of it. An ending that is an
event, as that of a disk that falls flat, comes that much later, and as long as the disk lingers near the maximum it
turns and rolls. At the end of a duration the tilt is off by what the disk tilts in that time, heading and path by what
it turns and rolls then too.
"""

import math
from typing import NamedTuple

from kernels.disk.equations import force
from kernels.disk.equations import inertia as without_losses
from kernels.disk.rk4 import step as free_step
from kernels.jit import kernel

#: A nutation, from wherever it is looked at, lies between three turning points. Steps after which it is long enough.
_TURNS, _MOST_STEPS = 3, 20000

_NOTHING = 0.0, 0.0, 0.0


class Lag(NamedTuple):
    """What a motion may be off because it passed maxima of its potential slowly (scaled).

    Attributes
    ----------
    time : float
        By which it is ahead or behind.
    turned, rolled : float
        Angle by which its heading turned, and length of the path over R, that it did near the maxima in that time.

    None of them is a number where the motion cannot be followed.
    """

    time: float
    turned: float
    rolled: float


class Change(NamedTuple):
    """How far a motion goes within a time, before and after a state: the larger magnitudes.

    Attributes
    ----------
    tilt, heading : float
        Angles [rad], NaN if the motion cannot be followed so far.
    path : float
        Over R, NaN likewise.
    """

    tilt: float
    heading: float
    path: float


@kernel
def state_without_losses(state, constants):
    """Return S, C, T, w, o, s of a state that holds K and p: the state of the disk without losses."""
    S, C, _, w, o, p = state
    return S, C, S / C, w, o, constants[3] * p


@kernel
def _rates(state):
    """Return the precession rate and the magnitude of the roll rate of a state of `state_without_losses`."""
    _, C, T, _, o, s = state
    return o / C, abs(s - o * T)


@kernel
def _sum(total, more, share):
    """`total` + `share` * `more`, of three numbers each."""
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
    """Return w^2 + w'^2, and for a step near a maximum its length over that: time, heading and path."""
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
    """What a motion from its start until its first turning point is late: times, heading, path over the energy.

    It errs by a share of how fast it has been, which near the maximum is nothing for a disk that sets off there.
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
    """How late a motion may be, or early, and what it turned and rolled in that time near the maxima.

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
    flat : float
        Cosine of the tilt at which the disk counts as flat: without its losses the motion may have come from beyond.

    Returns
    -------
    Lag

    Notes
    -----
    Near the maximum, where the tilt obeys w' = k^2 x, an energy that is wrong by e delays the pass by about e times the
    integral of dt / (w^2 + w'^2). The last nutation, followed back without losses, stands for all: a motion that loses
    energy passes such a maximum once or twice. If that was long before the end, nothing is seen of it: of 77 motions
    that pass upright, or turn short of it, by a share of 1e-10 to 1e-3 of a rate, three were up to five times further
    off. Following it back takes steps of its own size or shorter: with longer
    ones it passes faster than it did.
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
        # a start at rest is no turning point
        if w * present[3] < 0.0 and time - gone > h:
            slowness, latest, since, turns = _sum(slowness, latest, 1.0), _NOTHING, 0.0, turns + 1
    if not gone < time and turns < _TURNS and present[1] > flat:
        slowness = _sum(slowness, _begun(present, constants, since, relative_step, fastest, flat), 1.0)
    late, turned, rolled = slowness
    share = imbalance * (time / gone)
    return Lag(share * late, share * turned, share * rolled)


@kernel
def _larger(most, change):
    """Larger of each of two `Change`; a NaN of either stays."""
    return Change(
        most.tilt if change.tilt <= most.tilt or most.tilt != most.tilt else change.tilt,
        most.heading if change.heading <= most.heading or most.heading != most.heading else change.heading,
        most.path if change.path <= most.path or most.path != most.path else change.path,
    )


@kernel
def drift_off_path(state, alpha, late, relative_step, flat):
    """How much tilt, heading and path change within a time, before and after a state.

    Parameters
    ----------
    state : tuple of 6 floats
        As of `lag`.
    alpha : float
    late : float
        Scaled time.
    relative_step : float
        Step over the time scale of the motion.
    flat : float
        Cosine of the tilt at which the disk counts as flat, where the motion ends.

    Returns
    -------
    Change

    Notes
    -----
    At a turning point the rate of the tilt says nothing of it: a little later the disk turns fast. So near flat, where
    it precesses fast, do heading and path.
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
