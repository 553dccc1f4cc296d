"""Nutation periods of bounded motions: a double exponential sum between the turning points.

The period is 2 int dtilt/v with v^2 = -4 excess/(2 + alpha), where the excess V - h vanishes like a distance at the
turning points. A motion near a separatrix is slow at the saddle, which it passes or next to which it turns. With the
substitution distance = length/(1 + exp(pi sinh t)) from each end of a piece, both a root and a peak at an end take a
sum over equal steps of t whose number of digits about doubles with each halving of the step (Takahasi, Mori, Publ. RIMS
9 (1974) 721). The pieces are from turning point to turning point, or from each to the saddle between them.

Next to an end the excess is a difference of potentials that hardly differ. There it is expanded about that end, where
its value and its slope are known to full relative precision; farther on it is that of the panels of the table
(`kernels.disk.exact.legendre`).
"""

import math

import numpy as np

from kernels.disk.endings import BOUNDED
from kernels.disk.exact import motion as of
from kernels.disk.exact.arrays import EXACT_ENDING, EXACT_NUTATION_PERIOD
from kernels.disk.exact.legendre import (
    DP1,
    DP2,
    DS1,
    DS2,
    NODES,
    ONE,
    PANEL,
    PANELS,
    PP,
    REACH,
    SP,
    SS,
    TERMS,
)
from kernels.disk.exact.near_turning_points import TERM_ERROR
from kernels.disk.exact.polynomial import value
from kernels.disk.exact.potential import NEAR, rise, rise_at
from kernels.jit import kernel

#: Steps of the sums, each half of the one before, and the last t, where a distance is 1e-303 of the length.
_STEPS, _LAST = (1 / 4, 1 / 8, 1 / 16, 1 / 32, 1 / 64, 1 / 128), 6.1
#: Distance that is left out at an end, over that up to which h - V grows as it begins to: the sum lacks its root.
_LEAST = 1e-26
#: Two successive sums may differ by this share: the error of the second one is about its square.
_AGREEMENT = 1e-8
#: Share of a period that rounding may change, as estimated: a period is promised to 1e-9.
_PROMISE = 7e-10


def _places():
    """Distances from an end over the length and weights of one half of the sums, and where the new ones of each begin.

    Each half has the place in the middle with half its weight. The places of a step are in the order of distances.
    """
    shares, weights, begins = [], [], [0]
    for i, step in enumerate(_STEPS):
        numbers = np.arange(int(_LAST / step), -1, -1)
        t = numbers[numbers % 2 == 1] * step if i > 0 else numbers * step
        share = 1.0 / (1.0 + np.exp(math.pi * np.sinh(t)))
        shares.append(share)
        weights.append(np.where(t == 0.0, 0.5, 1.0) * math.pi * np.cosh(t) * share * (1.0 - share))
        begins.append(begins[-1] + t.size)
    return np.concatenate(shares), np.concatenate(weights), np.array(begins)


_SHARES, _WEIGHTS, _BEGINS = _places()

#: Where in the memory of a block stand the coefficients of both ends, what is summed, and the coefficients of panels.
_END, _OTHER_END, _PARTS = 0, TERMS, 2 * TERMS
_ERRORS = _PARTS + _SHARES.size
_ON_PANELS = _ERRORS + _SHARES.size


@kernel
def _expand(motion, alpha, tables, k, block, first):
    """Write the coefficients of h - V about the centre of a panel of this number."""
    table, c1, c2 = int(motion[of.TABLE]), motion[of.C_1], motion[of.C_2]
    panel, node = table * PANELS + REACH + k, table * NODES + 2 * (REACH + k)
    s = c1 + (tables.nodes[node, DS1] * c1 + tables.nodes[node, DS2] * c2)
    p = c2 + (tables.nodes[node, DP1] * c1 + tables.nodes[node, DP2] * c2)
    ss, sp, pp = s * s, s * p, p * p
    for n in range(TERMS):
        rolling = ss * tables.panels[panel, SS, n] + sp * tables.panels[panel, SP, n]
        block[first + n] = -(rolling + pp * tables.panels[panel, PP, n] + tables.panels[panel, ONE, n])
    block[first] = motion[of.BASE] - rise(alpha, rise_at(tables.nodes, node), c1, c2)


@kernel
def _expand_about(motion, alpha, tables, y, level, slope, block, first):
    """Write the coefficients about y, where h - V is `level` and has this slope; returns the slope of the table."""
    k = int(round(y / PANEL))
    x = y - k * PANEL
    _expand(motion, alpha, tables, k, block, first)
    for i in range(TERMS - 1):
        for n in range(first + TERMS - 2, first + i - 1, -1):
            block[n] += x * block[n + 1]
    rough = block[first + 1]
    block[first], block[first + 1] = level, slope
    return rough


@kernel
def _add(coefficients, cosine, shares, weights, way, x, about, errors, parts, wrong):
    """Write the parts of places that lie x + way * share from the centre of a panel, and those of their errors.

    `coefficients` are those of h - V about a place that lies x - `about` from there, `cosine` those of cos(tilt).
    """
    level_error, slope_error, bend_error, most = errors
    for i in range(shares.size):
        along = way * shares[i]
        distance = abs(along)
        kinetic = value(coefficients, 0, 1, about + along)
        part = weights[i] * value(cosine, 0, 1, x + along) / math.sqrt(kinetic)
        terms = (slope_error + bend_error * distance) * distance
        parts[i] = part
        wrong[i] = part * (level_error + (terms if terms < most else most)) / kinetic


@kernel
def _half(motion, tables, y, way, step, block, first, lowest, errors):
    """Sum the new places of a step that are nearer to y than to the other end, `way` from there."""
    begin, stop = _BEGINS[step], _BEGINS[step + 1]
    bend = abs(block[first + 2])
    reach, limit = max(abs(block[first + 1]), math.sqrt(block[first] * bend)), abs(way) * bend
    least = _LEAST * (reach / limit if reach < limit else 1.0)
    while _SHARES[begin] < least:
        begin += 1
    k, i = int(round(y / PANEL)), begin
    x = y - k * PANEL
    while i < stop and abs(x + way * _SHARES[i]) <= NEAR:
        i += 1
    table = int(motion[of.TABLE]) * PANELS + REACH
    _add(
        block[first : first + TERMS], tables.panels[table + k, ONE], _SHARES[begin:i], _WEIGHTS[begin:i], way, x, 0.0,
        errors, block[_PARTS + begin : _PARTS + i], block[_ERRORS + begin : _ERRORS + i],
    )  # fmt: skip
    while i < stop:
        near, k = i, int(round((y + way * _SHARES[i]) / PANEL))
        x = y - k * PANEL
        while i < stop and abs(x + way * _SHARES[i]) <= 0.5 * PANEL:
            i += 1
        i = max(i, near + 1)
        panel = _ON_PANELS + (k - lowest) * TERMS
        _add(
            block[panel : panel + TERMS], tables.panels[table + k, ONE], _SHARES[near:i], _WEIGHTS[near:i], way, x, x,
            errors, block[_PARTS + near : _PARTS + i], block[_ERRORS + near : _ERRORS + i],
        )  # fmt: skip
    total = error = 0.0
    for i in range(begin, stop):
        total += block[_PARTS + i]
        error += block[_ERRORS + i]
    return total, error


@kernel
def _rounding(motion, distance, pull):
    """Rounding error of the excess over TERM_ERROR, as in `kernels.disk.exact.near_turning_points.rounding_error`."""
    distance = abs(distance)
    terms = (pull + motion[of.CURVATURE] * distance) * distance
    return motion[of.KINETIC] + min(terms, motion[of.LEVEL])


@kernel
def _piece(motion, alpha, tables, begin, end, pull, block):
    """Integral of dtilt/sqrt(h - V) from one end to another, and of its error by rounding; NaN if sums do not agree.

    An end is its distance from the start, h - V there and the magnitude of its slope, 0 at the saddle. `pull` is the
    size of the terms of the force, of which only rounding matters.
    """
    way = end[0] - begin[0]
    errors_1, errors_2 = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    for side in range(2):
        distance, level, slope = begin if side == 0 else end
        first = _END if side == 0 else _OTHER_END
        inward = math.copysign(slope, way if side == 0 else -way)
        _expand_about(motion, alpha, tables, motion[of.Y_0] + distance, level, inward, block, first)
        error = _rounding(motion, distance, pull)
        # a turning point is wrong by the error over the slope, and its slope by V'' times that
        of_slope = 2.0 * abs(block[first + 2]) * error / slope if slope > 0.0 else pull
        of_level = 0.0 if slope > 0.0 else error
        found = of_level, of_slope, motion[of.CURVATURE], motion[of.LEVEL]
        errors_1, errors_2 = (found, errors_2) if side == 0 else (errors_1, found)
    y, total, wrong = motion[of.Y_0], 0.0, 0.0
    ends = int(round((y + begin[0]) / PANEL)), int(round((y + end[0]) / PANEL))
    lowest = min(ends)
    for k in range(lowest, max(ends) + 1):
        _expand(motion, alpha, tables, k, block, _ON_PANELS + (k - lowest) * TERMS)
    for step in range(_BEGINS.size - 1):
        one, error_1 = _half(motion, tables, y + begin[0], way, step, block, _END, lowest, errors_1)
        other, error_2 = _half(motion, tables, y + end[0], -way, step, block, _OTHER_END, lowest, errors_2)
        before, length = total, abs(way) * _STEPS[step]
        total = (0.5 * before if step > 0 else 0.0) + length * (one + other)
        wrong = (0.5 * wrong if step > 0 else 0.0) + length * (error_1 + error_2)
        if step > 0 and abs(total - before) <= _AGREEMENT * total:
            return total, wrong
    return math.nan, wrong


@kernel
def _period(motion, alpha, tables, block):
    """Period [s] of a motion, NaN where it is not known to 1e-9."""
    # released at rest, the disk starts at its other turning point
    kicked = motion[of.W] != 0.0
    ahead = motion[of.DISTANCE], 0.0, abs(motion[of.SLOPE])
    behind = 0.0, 0.0, abs(motion[of.FORCE])
    if kicked:
        behind = motion[of.DISTANCE + of.BEHIND], 0.0, abs(motion[of.SLOPE + of.BEHIND])
    away = motion[of.TOP] - motion[of.Y_0]
    passes = motion[of.HEIGHT] < 0.0 and (away - ahead[0]) * (away - behind[0]) < 0.0
    beside = min(abs(away - ahead[0]), abs(away - behind[0])) < abs(ahead[0] - behind[0])
    # elsewhere an error of the force shifts the swing as a whole
    pull = motion[of.PULL] if passes or beside else 0.0
    if passes:
        level = -motion[of.HEIGHT]
        # the saddle is known to few digits more than its height needs
        slope = _expand_about(motion, alpha, tables, motion[of.TOP], level, 0.0, block, _END)
        saddle = away - 0.5 * slope / block[_END + 2], level, 0.0
        total, error = _piece(motion, alpha, tables, behind, saddle, pull, block)
        more, more_error = _piece(motion, alpha, tables, saddle, ahead, pull, block)
        total, error = total + more, error + more_error
    else:
        total, error = _piece(motion, alpha, tables, behind, ahead, pull, block)
    right = 0.5 * TERM_ERROR * error <= _PROMISE * total and total < math.inf
    return math.sqrt(2.0 + alpha) * motion[of.UNIT] * total if right else math.nan


@kernel
def find_periods(n, tables, chunk, measures, counts):
    """Write the periods of the bounded ones of n motions."""
    for i in range(n):
        cell, motion = chunk.cells[i], chunk.motions[i]
        if counts[EXACT_ENDING, cell] == BOUNDED:
            alpha = tables.alphas[int(motion[of.TABLE])]
            measures[EXACT_NUTATION_PERIOD, cell] = _period(motion, alpha, tables, chunk.block)
