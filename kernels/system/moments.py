"""Moments of a motion: when a condition became true for the first or the last time, and when a value was greatest.

Between its turning points a polynomial rises or falls, so it crosses zero at most once, and its maxima are turning
points. `watch` visits them all, so no crossing within a step is missed. The side of zero, or the direction, is carried
from step to step: a crossing exactly between two steps counts once.

Each moment has four numbers in the memory of a lane:

- how often the condition became true; for a greatest value, the second-greatest maximum;
- the least distance of the condition from its limit at a turning point or the end of a step, which shows whether
  errors can change the count; for a greatest value, that value;
- the time of the moment, and the value of an expression then; NaN before it.
"""

import math

from kernels.jit import kernel
from kernels.lanes.layout import LANES
from kernels.system.endings import FIRST, GREATEST, RUNS_ON
from kernels.system.polynomials import ORDER
from kernels.system.roots import crossing, next_turn, rounding_to, value_at, write_slope

#: Numbers of a moment.
COUNTED, LEVEL, WHEN, WORTH = (number * LANES for number in range(4))
NUMBERS = 4

#: `watch` within a motion: its step does not end the motion.
GOES_ON = 0

#: Number of moments; their kinds; whether all comparisons of a condition have to be true, or any of them; the series of
#: their values, which the series of their expressions follow; and the numbers of expressions.
MOMENTS: int = 0
MOMENT_KINDS: tuple = ()
MOMENT_EVERY: tuple = ()
MOMENT_SERIES: tuple = ()
MOMENT_SIZES: tuple = ()

# Rows of lanes; see `kernels.system.lanes`.
TIME: int = 0
WATCH: int = 0
SIDE: int = 0
WORK: int = 0

COEFFICIENTS = ORDER + 1


@kernel
def forget_moments(lane, memory):
    """Begin the moments of a lane; the side of a condition is unknown, and a value has risen before its start."""
    for m in range(MOMENTS):
        numbers = WATCH + m * NUMBERS * LANES + lane
        greatest = MOMENT_KINDS[m] == GREATEST
        memory[numbers + COUNTED] = -math.inf if greatest else 0.0
        memory[numbers + LEVEL] = -math.inf if greatest else math.inf
        memory[numbers + WHEN] = memory[numbers + WORTH] = math.nan
        for i in range(MOMENT_SIZES[m]):
            memory[_side_of(m, i) + lane] = 1.0 if greatest else 0.0


@kernel
def watch(lane, scratch, h, ending, memory):
    """Update the moments of a lane by a step of length h, whose series are in the scratch.

    `ending` is the ending of a motion that ends there; otherwise `GOES_ON`. Nothing changes a first moment later.
    """
    slope = scratch + WORK + COEFFICIENTS
    for m in range(MOMENTS):
        when = memory[WATCH + m * NUMBERS * LANES + WHEN + lane]
        known = MOMENT_KINDS[m] == FIRST and when == when
        for i in range(0 if known else MOMENT_SIZES[m]):
            row = scratch + (MOMENT_SERIES[m] + 1 + i) * COEFFICIENTS
            write_slope(row, slope, memory)
            begin = 0.0
            while begin < h:
                end, rises = next_turn(slope, begin, h, scratch + WORK, memory)
                if MOMENT_KINDS[m] == GREATEST:
                    _see_direction(lane, m, i, begin, rises, scratch, memory)
                else:
                    _see_side(lane, m, i, begin, end, h, ending, scratch, memory)
                begin = end
            if MOMENT_KINDS[m] == GREATEST and ending != GOES_ON:
                # after its end a value falls
                _see_direction(lane, m, i, h, False, scratch, memory)


@kernel
def _side_of(m, i):
    """Return the row with the side of zero, or the direction, of an expression of a moment."""
    return SIDE + (MOMENT_SERIES[m] - MOMENT_SERIES[0] + i) * LANES


@kernel
def _see_direction(lane, m, i, x, rises, scratch, memory):
    """Begin to rise or fall at x, which is a maximum if the value has risen before."""
    numbers, side = WATCH + m * NUMBERS * LANES + lane, _side_of(m, i) + lane
    if memory[side] > 0.0 and not rises:
        top = value_at(scratch + (MOMENT_SERIES[m] + 1 + i) * COEFFICIENTS, x, memory)
        if top > memory[numbers + LEVEL]:
            memory[numbers + COUNTED], memory[numbers + LEVEL] = memory[numbers + LEVEL], top
            _write_moment(lane, m, x, scratch, memory)
        else:
            memory[numbers + COUNTED] = max(memory[numbers + COUNTED], top)
    memory[side] = 1.0 if rises else -1.0


@kernel
def _see_side(lane, m, i, begin, end, h, ending, scratch, memory):
    """Go from one turning point of an expression to the next one, or to the end of the step."""
    numbers, side = WATCH + m * NUMBERS * LANES + lane, _side_of(m, i) + lane
    row = scratch + (MOMENT_SERIES[m] + 1 + i) * COEFFICIENTS
    value = value_at(row, end, memory)
    now = 1.0 if value > 0.0 else -1.0
    if memory[side] == 0.0:
        # a motion that starts at the limit of a condition, to rounding, does not cross it there
        first = memory[row]
        memory[side] = now if abs(first) <= rounding_to(row, h, memory) else math.copysign(1.0, first)
    if memory[side] < now:
        _see_crossing(lane, m, i, crossing(row, begin, end, memory), scratch, memory)
    # a condition that ends the motion becomes true at the end, whatever the errors
    if end < h or ending <= RUNS_ON or now < 0.0:
        memory[numbers + LEVEL] = min(memory[numbers + LEVEL], abs(value))
    memory[side] = now


@kernel
def _see_crossing(lane, m, i, x, scratch, memory):
    """Count a comparison that becomes true at x, unless others decide the condition there."""
    numbers = WATCH + m * NUMBERS * LANES + lane
    for other in range(MOMENT_SIZES[m]):
        if other != i:
            value = value_at(scratch + (MOMENT_SERIES[m] + 1 + other) * COEFFICIENTS, x, memory)
            memory[numbers + LEVEL] = min(memory[numbers + LEVEL], abs(value))
            if (value > 0.0) != MOMENT_EVERY[m]:
                return
    memory[numbers + COUNTED] += 1.0
    now, before = memory[TIME + lane] + x, memory[numbers + WHEN]
    # comparisons are not visited in the order of time; NaN before the first one
    if not (before <= now if MOMENT_KINDS[m] == FIRST else before >= now):
        _write_moment(lane, m, x, scratch, memory)


@kernel
def _write_moment(lane, m, x, scratch, memory):
    numbers = WATCH + m * NUMBERS * LANES + lane
    memory[numbers + WHEN] = memory[TIME + lane] + x
    memory[numbers + WORTH] = value_at(scratch + MOMENT_SERIES[m] * COEFFICIENTS, x, memory)
