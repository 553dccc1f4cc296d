"""Detection of legs that passed a maximum of the potential by less energy than the integration may have lost.

After such a pass, the true motion may have turned there instead. The disk is slow at such a pass and the leg is long,
so few legs need a check. Legs are checked by increasing cost: by their time, by the tilts that they cover, by their
beginning, by the potential between their ends, and finally by repeating their steps. All of this is scalar code.
"""

import math

from kernels.disk.equations import fall_along, force, per_inertia, potential, slopes_along
from kernels.disk.error_estimate import drift, uncertain_energy
from kernels.disk.rk4 import step, tilt_acceleration
from kernels.jit import kernel, simd

#: A potential has maxima only at smaller tilts [rad]: steady motions are unstable below 18.6 deg (disk) to 20 deg.
_LARGEST_TILT = 0.36

#: Least scaled time over sqrt(1 + alpha/2) of a leg with a doubtful pass. The speed at a distance x from a maximum is
#: at most sqrt((2 K + x^2)/(1 + alpha/2)), with K the energy left at the maximum. A start nearer than 30 sqrt(2 K)
#: has lost almost nothing on its way there; all others need 2 asinh(30).
_SHORTEST = 8.0

#: Steps of the search for a minimum of the kinetic energy between the ends of a leg: up to a length of 0.7 in
#: y (about 40 deg), and beyond it; the largest minimum (of m g R) that is considered, several times the error of the
#: search.
_NODES, _SHORT, _NODES_IF_LONG, _LARGEST_MINIMUM = 8, 0.7, 48, 2.0e-3

#: A pass is doubtful if the kinetic energy left is less than this many times the uncertain energy.
_MARGIN = 4.0

#: Largest distance between the last step but one of a leg and its end, as a share of the leg.
_ELSEWHERE = 0.2


@kernel
def _covers_summits(tilt_start, tilt_end):
    return min(abs(tilt_start), abs(tilt_end)) < _LARGEST_TILT or tilt_start * tilt_end < 0.0


@kernel
def _leaves_summit(state, constants, heading):
    """Return whether a leg begins near a maximum of the potential and leaves it, or passes it without doubt."""
    _, curvature = force(state, constants)
    if not curvature < 0.0:
        return False
    inertia = 1.0 / per_inertia(state[0], state[1], constants)
    downhill = heading * tilt_acceleration(state, constants) * inertia
    if downhill >= 0.0:
        return True
    # the maximum is ahead by downhill/curvature and higher by half of downhill^2/curvature, if it is near enough
    kinetic = 0.5 * state[3] * state[3] * inertia
    return downhill > 0.1 * curvature * -curvature and 0.5 * downhill * downhill < -0.8 * curvature * kinetic


@simd
def _moved(S, C, s, o, h, slope):
    return S + h * slope[0], C + h * slope[1], s + h * slope[2], o + h * slope[3]


@simd
def _step_along(S, C, s, o, h, constants):
    """Make one step of the classical Runge-Kutta method in y."""
    one = slopes_along(S, C, s, o, constants)
    two = slopes_along(*_moved(S, C, s, o, 0.5 * h, one), constants)
    three = slopes_along(*_moved(S, C, s, o, 0.5 * h, two), constants)
    four = slopes_along(*_moved(S, C, s, o, h, three), constants)
    part = h / 6.0
    return (
        S + part * (one[0] + 2.0 * (two[0] + three[0]) + four[0]),
        C + part * (one[1] + 2.0 * (two[1] + three[1]) + four[1]),
        s + part * (one[2] + 2.0 * (two[2] + three[2]) + four[2]),
        o + part * (one[3] + 2.0 * (two[3] + three[3]) + four[3]),
    )


@kernel
def _lies_in_hidden_well(state, constants, h):
    """Return whether a leg ends in a well of the potential that is narrower than the distance of two nodes."""
    pull, curvature = force(state, constants)
    if not curvature > 0.0:
        return False
    kinetic = 0.5 * state[3] * state[3] / per_inertia(state[0], state[1], constants)
    reach = h * state[1]
    return 2.0 * kinetic + pull * pull / curvature < curvature * reach * reach


@kernel
def _slow_between(state, tilt_end, constants):
    """Return whether a coarse integration allows a small minimum of the kinetic energy between a start and a tilt."""
    S, C, _, w, o, s = state
    length = math.asinh(math.tan(tilt_end)) - math.asinh(S / C)
    nodes = _NODES if abs(length) <= _SHORT else _NODES_IF_LONG
    h = length / nodes
    if _lies_in_hidden_well(state, constants, h):
        return True
    kinetic = 0.5 * w * w / per_inertia(S, C, constants)
    whole = kinetic + potential(S, C, o, s, constants)
    slope = -h * fall_along(S, C, s, o, constants)
    for _ in range(nodes):
        S, C, s, o = _step_along(S, C, s, o, h, constants)
        before, slope_before = kinetic, slope
        kinetic = whole - potential(S, C, o, s, constants)
        slope = -h * fall_along(S, C, s, o, constants)
        if slope_before < 0.0 < slope:
            # the parabolas from both nodes, with the curvature given by their slopes
            bend = slope - slope_before
            lowest = min(
                before - 0.5 * slope_before * slope_before / bend, kinetic - 0.5 * slope * slope / bend
            )
            if lowest < _LARGEST_MINIMUM:
                return True
    return _lies_in_hidden_well((S, C, S / C, 0.0, o, s), constants, h)


@kernel
def _doubtful_on_the_way(state, constants, leg, whole, alpha):
    """Repeat the steps of a leg; return whether the energy at a minimum of its speed was within its uncertainty.

    Also return True if the leg ends elsewhere this time, because these steps round differently from `lane_step` in
    lanes.
    """
    _, tilt_end, steps, heading, uniform, graded = leg
    start = state[0], state[1], state[3], state[4], state[5]
    slowing = heading * tilt_acceleration(state, constants) < 0.0
    for n in range(1, int(steps)):
        h = uniform + graded * state[1]
        state = step(state, constants, h)
        slower = heading * tilt_acceleration(state, constants) < 0.0
        if slowing and not slower:
            drifts = drift(state, start, whole, alpha, constants, n)
            scale, change = uniform + graded, abs(state[0] - start[0])
            uncertain = uncertain_energy(drifts, state, start, constants, scale, change, n)
            kinetic = 0.5 * state[3] * state[3] / per_inertia(state[0], state[1], constants)
            if not kinetic > _MARGIN * uncertain:
                return True
        slowing = slower
    # one step and the landing are left
    way = math.sin(tilt_end) - start[0]
    return not abs(math.sin(tilt_end) - state[0]) <= _ELSEWHERE * abs(way)


@simd
def is_long(time, constants):
    """Return whether a leg with a scaled time is long enough for a doubtful pass; most legs are not."""
    return not time * math.sqrt(per_inertia(0.0, 1.0, constants)) < _SHORTEST


@kernel
def doubtful_pass(state, constants, leg, whole, alpha):
    """Return whether a long leg passed a maximum of the potential by less energy than is uncertain there.

    Parameters
    ----------
    state : tuple of 6 floats
        State at the beginning of the leg, with the rates of its direction of time.
    constants : tuple of floats
    leg : tuple of 6 floats
        Tilts [rad] at its beginning and end, number of steps, sign of the tilt rate, and the scaled steps: the
        constant part and the part that is multiplied by cos(tilt).
    whole, alpha : float
        Energy of the start over m g R; mass distribution.

    Returns
    -------
    bool
    """
    tilt_start, tilt_end, _, heading, _, _ = leg
    if not _covers_summits(tilt_start, tilt_end):
        return False
    if abs(tilt_start) < _LARGEST_TILT and _leaves_summit(state, constants, heading):
        return False
    if not _slow_between(state, tilt_end, constants):
        return False
    return _doubtful_on_the_way(state, constants, leg, whole, alpha)
