"""The time until a disk falls: a quadrature over the tilt, from the start or its turning point to the fall.

The kinetic energy of the tilt is a function of the tilt alone (`kernels.disk.exact.potential`), so that the time is the
integral of dtilt/w. The integrand has a root in its denominator at a turning point, which the substitution
y = turn + (end - turn) v^2 removes, and peaks where the motion is slow: intervals are halved until both halves agree
with the whole.
"""

import math

import numpy as np

from kernels.disk.arrays import ALPHA, GRAVITY, PRECESSION_RATE, RADIUS, ROLL_RATE, TILT, TILT_RATE
from kernels.disk.exact.legendre import (
    DP1,
    DP2,
    DS1,
    DS2,
    ONE,
    P_P,
    P_S,
    PANEL,
    PP,
    REACH,
    S_P,
    S_S,
    SP,
    SS,
    row_value,
    stretched,
    tables,
)
from kernels.jit import kernel
from kernels.native.entry import parallel

#: Nodes and weights of Gauss and Legendre on [-1, 1].
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
#: An interval agrees with its halves to this share of the whole time; so many intervals at most, half of them waiting.
_AGREEMENT, _MOST, _WAITING = 1e-8, 2000, 60
#: Cells that a thread takes at a time.
_CHUNK = 64
#: Share of the way to the fall over which the force at the start is measured.
_NEAR = 1e-3


@kernel
def _upright_rates(panels, nodes, y, s, p):
    """(s, p) at upright of a motion that has s and p at y: the transfer matrices have determinant one."""
    k = int(round(y / PANEL))
    x, panel, node = y - k * PANEL, REACH + k, 2 * (REACH + k)
    ss, sp = row_value(panels, panel, S_S, x), row_value(panels, panel, S_P, x)
    ps, pp = row_value(panels, panel, P_S, x), row_value(panels, panel, P_P, x)
    s, p = pp * s - sp * p, ss * p - ps * s
    return (
        (1.0 + nodes[node, DP2]) * s - nodes[node, DS2] * p,
        (1.0 + nodes[node, DS1]) * p - nodes[node, DP1] * s,
    )


@kernel
def _potential_and_cos(panels, nodes, y, c1, c2):
    """V and cos(tilt) at y."""
    k = int(round(y / PANEL))
    x, panel, node = y - k * PANEL, REACH + k, 2 * (REACH + k)
    s = c1 + (nodes[node, DS1] * c1 + nodes[node, DS2] * c2)
    p = c2 + (nodes[node, DP1] * c1 + nodes[node, DP2] * c2)
    cos = row_value(panels, panel, ONE, x)
    rolling = s * s * row_value(panels, panel, SS, x) + s * p * row_value(panels, panel, SP, x)
    return rolling + p * p * row_value(panels, panel, PP, x) + cos, cos


@kernel
def _sum(panels, nodes, motion, turn, end, low, high):
    """Gauss sum over v from `low` to `high` of dtilt/sqrt(h - V)."""
    c1, c2, h = motion
    total = 0.0
    for i in range(_NODES.size):
        v = 0.5 * (low + high) + 0.5 * (high - low) * _NODES[i]
        level, cos = _potential_and_cos(panels, nodes, turn + (end - turn) * v * v, c1, c2)
        total += _WEIGHTS[i] * v * cos / math.sqrt(abs(h - level))
    return abs(end - turn) * (high - low) * total


@kernel
def _turn_behind(panels, nodes, motion, begin, end):
    """Where a motion that is at `begin` would have turned back, had the force always been the one at `begin`.

    A slow kick leaves the start near a turning point that the motion never sees, but that the quadrature does.
    """
    ahead = _NEAR * (end - begin)
    kinetic = motion[2] - _potential_and_cos(panels, nodes, begin, motion[0], motion[1])[0]
    gained = motion[2] - _potential_and_cos(panels, nodes, begin + ahead, motion[0], motion[1])[0] - kinetic
    return begin - ahead * max(0.0, kinetic) / gained if gained > 0.0 else begin


@kernel
def _integral(panels, nodes, motion, turn, begin, end, waiting):
    """Integral of dtilt/sqrt(h - V) from `begin` to `end`; NaN if 2000 intervals do not do.

    `turn` is the turning point at `begin`, or a place behind it; `waiting`, float64[_WAITING, 3], holds intervals with
    their sums.
    """
    waiting[0, 0], waiting[0, 1] = math.sqrt((begin - turn) / (end - turn)), 1.0
    waiting[0, 2] = math.inf
    held, total, whole = 1, 0.0, 0.0
    for _ in range(_MOST):
        if held == 0:
            return total
        held -= 1
        low, high, rough = waiting[held, 0], waiting[held, 1], waiting[held, 2]
        width, fine = 0.5 * (high - low), 0.0
        for half in range(2):
            start = low + half * width
            waiting[held + half, 0], waiting[held + half, 1] = start, start + width
            waiting[held + half, 2] = _sum(panels, nodes, motion, turn, end, start, start + width)
            fine += waiting[held + half, 2]
        whole = fine if rough == math.inf else whole + (fine - rough)
        if abs(fine - rough) <= _AGREEMENT * whole or held + 2 >= _WAITING:
            total += fine
        else:
            held += 2
    return math.nan


@kernel
def _fall_time(panels, nodes, tilt, w, s, o, alpha, least, greatest, fall_tilt, waiting):
    """Scaled time from a scaled start to the fall, at one of the extreme tilts; NaN if neither is one."""
    falls_up = greatest >= fall_tilt
    end, turn = (greatest, least) if falls_up else (least, greatest)
    if not abs(end) >= fall_tilt:
        return math.nan
    y0, y_end = stretched(math.sin(tilt), math.cos(tilt)), stretched(math.sin(end), math.cos(end))
    if max(abs(y0), abs(y_end)) > (REACH - 1) * PANEL:
        return math.nan
    c1, c2 = _upright_rates(panels, nodes, y0, s, o * math.cos(tilt))
    h = _potential_and_cos(panels, nodes, y0, c1, c2)[0] + 0.25 * (2.0 + alpha) * w * w
    motion, factor = (c1, c2, h), 0.5 * math.sqrt(2.0 + alpha)
    inward = w != 0.0 and (w > 0.0) != falls_up
    if inward:
        # there and back to the turning point on the other side
        back = stretched(math.sin(turn), math.cos(turn))
    else:
        back = y0 if w == 0.0 else _turn_behind(panels, nodes, motion, y0, y_end)
    time = 0.0
    for part in range(2 if inward else 1):
        begin, target = (back, y0) if part == 1 else (back if inward else y0, y_end)
        time += _integral(panels, nodes, motion, back, begin, target, waiting)
    return factor * time


@parallel(
    _CHUNK,
    lambda *_: (np.empty((_WAITING, 3)),),
    starts="float64[:, ::1]",
    tilts="float64[:, ::1]",
    fall_tilt="float64",
    panels="float64[:, :, ::1]",
    nodes="float64[:, ::1]",
    times="float64[::1], written",
    waiting="float64[:, ::1]",
)
def integrate_falls(start, stop, starts, tilts, fall_tilt, panels, nodes, times, waiting):
    """Find the fall times of cells of one alpha.

    Python calls it without `start`, `stop` and `waiting`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts : float64[len(PARAMETERS), n]
        Rows as in `kernels.disk.arrays`.
    tilts : float64[2, n]
        Least and greatest tilt [rad] until the fall, as `kernels.disk.exact.extremes` has them.
    fall_tilt : float
        Magnitude of the tilt [rad] that counts as a fall.
    panels, nodes : arrays
        `kernels.disk.exact.legendre.tables` of the alpha.
    times : float64[n], written
        Fall times [s]; NaN for a cell that does not fall, and where the quadrature does not converge.
    waiting : float64[_WAITING, 3]
        Memory for `_integral`.

    Notes
    -----
    Never raises.
    """
    for cell in range(start, stop):
        unit = math.sqrt(starts[RADIUS, cell] / starts[GRAVITY, cell])
        tilt = starts[TILT, cell]
        turning = starts[PRECESSION_RATE, cell] * unit
        s = starts[ROLL_RATE, cell] * unit + turning * math.sin(tilt)
        times[cell] = unit * _fall_time(
            panels, nodes, tilt, starts[TILT_RATE, cell] * unit, s, turning * math.cos(tilt), starts[ALPHA, cell],
            tilts[0, cell], tilts[1, cell], fall_tilt, waiting,
        )  # fmt: skip


def fall_times(starts, tilts, fall_tilt):
    """Fall times [s] of `integrate_falls`, as a new array, of cells of any alpha in (0, 1]."""
    times = np.empty(starts.shape[1])
    for alpha in np.unique(starts[ALPHA]):
        cells = np.flatnonzero(starts[ALPHA] == alpha)
        found = np.empty(cells.size)
        integrate_falls(
            np.ascontiguousarray(starts[:, cells]), np.ascontiguousarray(tilts[:, cells]), fall_tilt,
            *tables(np.array([alpha])), found,
        )  # fmt: skip
        times[cells] = found
    return times
