"""The last pass over a chunk: nutation periods of bounded motions, by quadrature (`kernels.disk.exact.period`)."""

import math

from kernels.disk.endings import BOUNDED
from kernels.disk.exact import motion as of
from kernels.disk.exact import period_layout as at
from kernels.disk.exact.arrays import EXACT_ENDING, EXACT_NUTATION_PERIOD
from kernels.disk.exact.counting_sort import FIRST, KEY, STOP, blocks_of
from kernels.disk.exact.near_turning_points import TERM_ERROR
from kernels.disk.exact.period import ALONE, LONG, LONG_REACH, PIECE, SHORT, SHORT_REACH, integrate
from kernels.disk.exact.period_layout import CLASSES, LANES
from kernels.disk.exact.root import ROUNDING
from kernels.disk.exact.wide_panels import CENTRES, SIDE, SPACING
from kernels.jit import kernel

#: Intervals of the first sums of the classes: of motions far from a separatrix, and of those near one; how often they
#: are doubled.
_INTERVALS, _DOUBLINGS = (8, 16, 24, 32, 40, 48, 64, 96), 11
#: Two successive sums may differ by this share of the sum, the second number near a separatrix, and their estimated
#: error may be this large. Of 10,000 periods next to steady motions 1e-7 let pass two that were wrong by up to 3e-9.
_AGREEMENT, _AGREEMENT_AT_SADDLE, _ERROR = 1e-6, 5e-8, 2e-11
#: The error that is allowed of a first sum near a separatrix; intervals over the square root of the range of u
#: (measured).
_ALLOWED, _AT_ENDS = 2e-10, 11.5
#: Share of a period that rounding may change, as estimated: a period is promised to 1e-9, and of 10,000 cells beside
#: separatrices the worst error was 0.36 of the estimate.
_PROMISE = 7e-10
#: A start at least this far in y from the end of a wide panel is expanded about with nearly all that is near it.
_MARGIN = 0.25


@kernel
def _turns(motion):
    """Distances in y from the start to the two turning points, ahead and behind, and the slopes of V there."""
    # released at rest, the disk starts at its other turning point
    kicked = motion[of.W] != 0.0
    behind = motion[of.DISTANCE + of.BEHIND] if kicked else 0.0
    slope = motion[of.SLOPE + of.BEHIND] if kicked else motion[of.FORCE]
    return motion[of.DISTANCE], behind, motion[of.SLOPE], slope


@kernel
def _class(motion):
    """Class of a motion: the number of the first sum's intervals in _INTERVALS; 0 far from a separatrix.

    A motion is near one if it is slow at its saddle: if that is nearer to a turning point, or to the energy, than a
    swing is wide. With h half of the range of u, what the roots at the saddle are wrong by makes the sum of N intervals
    wrong by exp(-N pi/h) times it, and what lies beyond the turning points by about exp(-2 N sqrt(1.8/h)) (measured).
    """
    if math.isnan(motion[of.TOP]):
        return 0
    ahead, behind, _, _ = _turns(motion)
    width, swing = _width(motion, ahead, behind), abs(ahead - behind)
    if not width < swing:
        return 0
    reach = math.log(2.0 * swing / width)
    amplitude = min(1.0, width / abs(motion[of.BEND])) ** 3 + _rounding_of_height(motion) / abs(
        motion[of.HEIGHT]
    )
    middle = reach * math.log(max(1.0, min(1.0, amplitude) / _ALLOWED)) / math.pi
    intervals = max(middle, _AT_ENDS * math.sqrt(reach))
    # one half of the range is enough if the motion turns before its saddle
    intervals = intervals if motion[of.HEIGHT] < 0.0 else 0.5 * intervals
    class_ = 1
    while class_ < CLASSES - 1 and _INTERVALS[class_] < intervals:
        class_ += 1
    return class_


@kernel
def _rounding_of_height(motion):
    """Error of the saddle's height over the energy: as in `kernels.disk.exact.near_turning_points.rounding_error`."""
    away = abs(motion[of.TOP] - motion[of.Y_0])
    terms = (motion[of.PULL] + motion[of.CURVATURE] * away) * away
    return ROUNDING * (motion[of.KINETIC] + min(terms, motion[of.LEVEL]))


@kernel
def _width(motion, ahead, behind):
    if motion[of.HEIGHT] < 0.0:
        return math.sqrt(abs(2.0 * motion[of.HEIGHT] / motion[of.BEND]))
    away = motion[of.TOP] - motion[of.Y_0]
    return min(abs(ahead - away), abs(behind - away))


@kernel
def _centre(motion):
    """Number of the wide panel in which a motion is described: the one nearest to the middle of its swing.

    Where it needs several ones, the next one if the start would lie next to the end of one.
    """
    ahead, behind, _, _ = _turns(motion)
    y0 = motion[of.Y_0]
    number = round((y0 + 0.5 * (ahead + behind)) / SPACING)
    number = max(-SIDE, min(SIDE, number))
    centre = number * SPACING
    if max(abs(y0 + ahead - centre), abs(y0 + behind - centre)) > ALONE:
        place = (y0 - centre) / PIECE + 0.5
        if abs(place - round(place)) * PIECE < _MARGIN:
            number += 1 if number <= 0 else -1
    return int(number)


@kernel
def _groups(motion, number):
    """How many groups of coefficients of Q are enough for a swing that lies this far from its wide panel's centre."""
    ahead, behind, _, _ = _turns(motion)
    away = motion[of.Y_0] - number * SPACING
    reach = max(abs(away + ahead), abs(away + behind))
    return SHORT if reach <= SHORT_REACH else (LONG if reach <= LONG_REACH else at.GROUPS)


@kernel
def _collect(n, chunk, measures, counts):
    """List the bounded motions, with their tables, classes, sizes and wide panels; returns their number."""
    count = 0
    for i in range(n):
        motion = chunk.motions[i]
        if counts[EXACT_ENDING, chunk.cells[i]] == BOUNDED:
            chunk.sought[count] = i
            number = _centre(motion)
            key = int(motion[of.TABLE]) * CLASSES + _class(motion)
            key = key * (at.GROUPS + 1) + _groups(motion, number)
            chunk.keys[count] = key * CENTRES + SIDE + number
            motion[of.ROUNDING] = 0.0
            count += 1
    return count


@kernel
def _load(chunk, at_saddle, first, last):
    block = chunk.block
    for lane in range(LANES):
        motion = chunk.motions[chunk.sought[chunk.order[min(first + lane, last - 1)]]]
        y0, away = motion[of.Y_0], motion[of.TOP] - motion[of.Y_0]
        ahead, behind, slope, slope_behind = _turns(motion)
        passes = motion[of.HEIGHT] < 0.0
        # the second one is the upper one, or the one next to the saddle that the motion turns before
        swap = abs(ahead - away) < abs(behind - away) if motion[of.HEIGHT] > 0.0 else ahead < behind
        block[at.FIRST + lane], block[at.SECOND + lane] = (behind, ahead) if swap else (ahead, behind)
        block[at.FIRST_SLOPE + lane] = slope_behind if swap else slope
        block[at.SECOND_SLOPE + lane] = slope if swap else slope_behind
        block[at.W_0 + lane], block[at.AWAY + lane] = y0, away
        block[at.PASSES + lane] = 1.0 if passes else 0.0
        block[at.PLACE_OF_SADDLE + lane] = motion[of.TOP]
        block[at.SQUARE + lane] = -2.0 * motion[of.HEIGHT] / motion[of.BEND]
        block[at.FORCE + lane], block[at.KINETIC + lane] = motion[of.FORCE], motion[of.KINETIC]
        # elsewhere an error of the force shifts the swing as a whole
        block[at.PULL + lane] = motion[of.PULL] if at_saddle else 0.0
        block[at.CURVATURE + lane] = motion[of.CURVATURE]
        block[at.LEVEL + lane], block[at.BASE + lane] = motion[of.LEVEL], motion[of.BASE]
        block[at.C_1 + lane], block[at.C_2 + lane] = motion[of.C_1], motion[of.C_2]
        block[at.ERROR + lane] = motion[of.ROUNDING]


@kernel
def _update(motion, block, lane, at_saddle, fresh, intervals):
    """Take the new sums of a motion into account; whether they agree.

    Each doubling about squares the error. Near a separatrix its first part, which the class keeps small, falls more
    slowly, so that the last two differences do not tell how fast the rest does.
    """
    if fresh:
        coarse = (block[at.ENDS + lane] + block[at.SUM_4 + lane]) * (4.0 / intervals)
        middle = 0.5 * coarse + block[at.SUM_2 + lane] * (2.0 / intervals)
        before = abs(middle - coarse)
    else:
        middle, before = motion[of.SUM], motion[of.CHANGE]
    motion[of.SUM] = 0.5 * middle + block[at.SUM_1 + lane] / intervals
    motion[of.CHANGE] = abs(motion[of.SUM] - middle)
    motion[of.ROUNDING] = block[at.ERROR + lane]
    change, before = motion[of.CHANGE] / motion[of.SUM], before / motion[of.SUM]
    # sums can agree by chance: their difference is taken for no less than the square of the one before
    likely = max(change, before * before)
    rest = likely * likely if at_saddle else likely * (likely / before) ** 2
    # a sum that is no number stays none, and rounding may not let sums agree any better
    agreement = _AGREEMENT_AT_SADDLE if at_saddle else _AGREEMENT
    return not (change > agreement or (rest > _ERROR and likely > 10.0 * _ERROR))


@kernel
def _store(chunk, alpha, at_saddle, fresh, intervals, first, last, measures):
    """Write the periods whose sums agree; the others stay to be summed again."""
    for lane in range(last - first):
        j = chunk.order[first + lane]
        motion = chunk.motions[chunk.sought[j]]
        if _update(motion, chunk.block, lane, at_saddle, fresh, intervals):
            chunk.keys[j] = -1
            period = 2.0 * math.pi * math.sqrt(2.0 + alpha) * motion[of.UNIT] * motion[of.SUM]
            turns = chunk.block[at.PASSES + lane] == 0.0
            period = 0.5 * period if at_saddle and turns else period
            right = 0.5 * TERM_ERROR * motion[of.ROUNDING] <= _PROMISE * motion[of.SUM] * intervals
            right &= motion[of.SUM] < math.inf
            measures[EXACT_NUTATION_PERIOD, chunk.cells[chunk.sought[j]]] = period if right else math.nan


@kernel
def _drop_ended(n, chunk):
    count = 0
    for j in range(n):
        if chunk.keys[j] >= 0:
            chunk.keys[count], chunk.sought[count] = chunk.keys[j], chunk.sought[j]
            count += 1
    return count


@kernel
def find_periods(n, tables, chunk, measures, counts):
    """Write the periods of the bounded ones of n motions."""
    count, times = _collect(n, chunk, measures, counts), 1
    while count > 0 and times <= 1 << _DOUBLINGS:
        for b in range(blocks_of(chunk.keys, count, LANES, chunk.order, chunk.ends, chunk.blocks)):
            key, first, last = chunk.blocks[KEY, b], chunk.blocks[FIRST, b], chunk.blocks[STOP, b]
            number, groups = key % CENTRES - SIDE, key // CENTRES % (at.GROUPS + 1)
            key //= CENTRES * (at.GROUPS + 1)
            class_, table = key % CLASSES, key // CLASSES
            alpha, at_saddle = tables.alphas[table], class_ > 0
            intervals = times * _INTERVALS[class_]
            _load(chunk, at_saddle, first, last)
            integrate(
                chunk.block,
                alpha,
                table,
                tables.nodes,
                tables.wide,
                number,
                groups,
                at_saddle,
                times == 1,
                intervals,
            )
            _store(chunk, alpha, at_saddle, times == 1, intervals, first, last, measures)
        count = _drop_ended(count, chunk)
        times *= 2
