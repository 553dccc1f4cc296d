"""The lane functions of any system: what is not made from its right-hand side (`kernels.system.source`).

A cell is integrated four times, each time with a hundredth of the tolerance: where the last two motions end in the same
way, at the same time and place, that is what the system does; the differences say how far the last one may be off. One
difference alone is small by chance in one cell of a hundred. The first pass takes a third of the steps of the last one.

The names in capitals, `series` and `constants` stand for those of one system (`kernels.lanes.binding`).
"""

import math
from typing import NamedTuple

from kernels.jit import kernel, simd
from kernels.lanes.layout import LANES
from kernels.system.endings import FIRST_EVENT, RUNS_ON, UNRESOLVED
from kernels.system.polynomials import ORDER, greatest

#: Tolerance of each leg over that of the last one.
LEGS = (1e6, 1e4, 1e2, 1.0)

#: A step ends wrong if the rate there differs from that of its series by so many tolerances, or this, of a state: the
#: series has crossed a place where the right-hand side is not smooth, such as the zero of a root, or all its terms
#: happened to vanish.
JUMP, LEAST_JUMP = 1024.0, 1e-9

#: So far the rates may differ by rounding, over the size of their terms: all that there is where these cancel.
NOISE = 1e-12

#: Steps of a leg at most.
MOST_STEPS = 10_000_000.0

#: Numbers of states, of expressions whose greatest value is sought, of expressions that end a motion, of constants.
STATES: int = 0
EXTREMES: int = 0
EVENTS: int = 0
CONSTANTS: int = 0
#: Number of the ending of each such expression; how many times there are.
EVENT_ENDINGS: tuple = ()

# Rows of lanes, as `kernels.system.source` lays them out.
Y: int = 0
TIME: int = 0
TOP: int = 0
SIZES: int = 0
COUNT: int = 0
UNPROVED: int = 0
STEP: int = 0
CONSTANT: int = 0
END: int = 0
LOG_TOLERANCE: int = 0
LONGEST: int = 0
SLOPE: int = 0
BEFORE: int = 0
START: int = 0
LEG: int = 0
SCRATCH: int = 0
STEPPING: int = 0
SIZE: int = 0

COEFFICIENTS = ORDER + 1

#: Places of a step at which a series is looked at before its greatest value is sought.
_PLACES = 16


class Run(NamedTuple):
    """Settings of a run: the duration, the longest step, the binary logarithm of the tolerance of each leg."""

    duration: float
    longest: float
    tolerances: tuple


@kernel
def prepared_settings(settings):
    """Duration, longest step (0: none), and the tolerance of each leg."""
    longest = settings[1] if settings[1] > 0.0 else math.inf
    fine = math.log2(settings[2])
    first, second, third, fourth = LEGS
    tolerances = (
        fine + math.log2(first),
        fine + math.log2(second),
        fine + math.log2(third),
        fine + math.log2(fourth),
    )
    return Run(settings[0], longest, tolerances)


@kernel
def coefficients(lane, scratch, lanes):
    """Write the series of a lane into a scratch; made from the right-hand side."""


@kernel
def constants(cell, lane, starts, lanes):
    """Write the constants of a cell into its lane; made from the right-hand side."""


@kernel
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Read states and constants."""
    for i in range(STATES):
        lanes[START + i * LANES + lane] = starts[i, cell]
    constants(cell, lane, starts, lanes)
    lanes[END + lane], lanes[LONGEST + lane] = run.duration, run.longest
    lanes[LEG + lane] = 0.0
    return True


@kernel
def fill_idle(lane, lanes):
    """Fill an idle lane with ones."""
    for row in range(0, SCRATCH, LANES):
        lanes[row + lane] = 1.0
    lanes[LEG + lane] = 0.0


@simd
def prepare(lane, run, lanes):
    """Nothing follows from a start alone."""


@simd
def needs_integration(cell, lane, run, lanes, measures, counts):
    """Every cell is stepped."""
    return True


@simd
def set_off(lane, run, lanes):
    """Begin a leg at the start."""
    for i in range(STATES):
        lanes[Y + i * LANES + lane] = lanes[START + i * LANES + lane]
        lanes[SIZES + i * LANES + lane] = abs(lanes[START + i * LANES + lane])
    for i in range(EXTREMES):
        lanes[TOP + i * LANES + lane] = -math.inf
    lanes[TIME + lane], lanes[COUNT + lane], lanes[UNPROVED + lane] = 0.0, 0.0, 0.0
    lanes[STEP + lane], lanes[BEFORE + lane] = 0.0, 0.0
    for i in range(STATES):
        lanes[SLOPE + i * LANES + lane] = math.nan
    leg = lanes[LEG + lane]
    early = run.tolerances[0] if leg == 0.0 else run.tolerances[1]
    late = run.tolerances[2] if leg == 2.0 else run.tolerances[3]
    lanes[LOG_TOLERANCE + lane] = early if leg < 2.0 else late


@simd
def land(lane, run, lanes):
    """The end of a leg is found for each cell alone: `finish_leg`."""


@kernel
def value_after(row, h, scratch, lanes):
    """Value of a series in the scratch."""
    first = scratch + row * COEFFICIENTS
    found = lanes[first + ORDER]
    for k in range(ORDER - 1, -1, -1):
        found = lanes[first + k] + h * found
    return found


@kernel
def _highest(row, h, scratch, lanes):
    """Time in a step at which a series is greatest: the best of some places, and what lies beside it."""
    best, at = -math.inf, 0.0
    for place in range(_PLACES + 1):
        here = value_after(row, place * h / _PLACES, scratch, lanes)
        best, at = here if here > best else best, place * h / _PLACES if here > best else at
    low, high = max(0.0, at - h / _PLACES), min(h, at + h / _PLACES)
    for _ in range(50):
        one, other = low + (high - low) / 3.0, high - (high - low) / 3.0
        rising = value_after(row, one, scratch, lanes) < value_after(row, other, scratch, lanes)
        low, high = one if rising else low, high if rising else other
    middle = 0.5 * (low + high)
    return middle if value_after(row, middle, scratch, lanes) > best else at


@kernel
def _first_above(row, h, scratch, lanes):
    """Time in a step from which on a series is positive, by bisection to rounding; infinite if it nowhere is."""
    if value_after(row, 0.0, scratch, lanes) > 0.0:
        return 0.0
    low, high = 0.0, h
    # not the other way round: what is not a number is not above
    if not value_after(row, h, scratch, lanes) > 0.0:
        high = _highest(row, h, scratch, lanes)
        if not value_after(row, high, scratch, lanes) > 0.0:
            return math.inf
    for _ in range(60):
        middle = 0.5 * (low + high)
        if value_after(row, middle, scratch, lanes) > 0.0:
            high = middle
        else:
            low = middle
    return high


@kernel
def greatest_until(row, h, scratch, lanes):
    """Greatest value of a series in the scratch from its beginning until h."""
    at = scratch + row * COEFFICIENTS
    return greatest(
        h, lanes[at], lanes[at + 1], lanes[at + 2], lanes[at + 3], lanes[at + 4], lanes[at + 5], lanes[at + 6],
        lanes[at + 7], lanes[at + 8], lanes[at + 9], lanes[at + 10], lanes[at + 11], lanes[at + 12],
    )  # fmt: skip


@kernel
def _slope(row, h, scratch, lanes):
    """Rate of change of a series in the scratch."""
    first = scratch + row * COEFFICIENTS
    found = ORDER * lanes[first + ORDER]
    for k in range(ORDER - 1, 0, -1):
        found = k * lanes[first + k] + h * found
    return found


@kernel
def _ends_wrong(lane, h, lanes):
    """Whether the rate at the end of the last step is not that of its series; the lane is moved there."""
    for i in range(STATES):
        lanes[SLOPE + i * LANES + lane] = _slope(i, h, SCRATCH, lanes)
        lanes[Y + i * LANES + lane] = value_after(i, h, SCRATCH, lanes)
    lanes[TIME + lane] += h
    coefficients(lane, SCRATCH, lanes)
    room = JUMP * 2.0 ** lanes[LOG_TOLERANCE + lane] + LEAST_JUMP
    for i in range(STATES):
        size = max(lanes[SIZES + i * LANES + lane], abs(lanes[Y + i * LANES + lane]))
        apart = abs(lanes[SCRATCH + i * COEFFICIENTS + 1] - lanes[SLOPE + i * LANES + lane])
        noise = NOISE * lanes[SCRATCH + (STATES + EXTREMES + EVENTS) * COEFFICIENTS + i]
        if not (apart * h <= room * size or apart <= noise):
            return True
    return False


@kernel
def go_on(lane, place, run, memory):
    """Let a lane go on whose step was not proved free of events, and has none: its series are looked at closely."""
    h = memory[STEP + lane]
    if not h < memory[END + lane] - memory[TIME + lane]:
        return False
    scratch = place - (place - STEPPING) % SIZE + SCRATCH
    coefficients(lane, scratch, memory)
    for j in range(EVENTS):
        if _first_above(STATES + EXTREMES + j, h, scratch, memory) <= h:
            return False
    for i in range(STATES):
        memory[SLOPE + i * LANES + lane] = _slope(i, h, scratch, memory)
        memory[Y + i * LANES + lane] = found = value_after(i, h, scratch, memory)
        memory[SIZES + i * LANES + lane] = max(memory[SIZES + i * LANES + lane], abs(found))
    for i in range(EXTREMES):
        row = TOP + i * LANES + lane
        memory[row] = max(memory[row], greatest_until(STATES + i, h, scratch, memory))
    memory[TIME + lane] += h
    memory[BEFORE + lane] = h
    memory[COUNT + lane] += 1.0
    memory[UNPROVED + lane] += 1.0
    return True


@kernel
def finish_leg(cell, lane, run, lanes, measures, counts):
    """Land where the leg ended, and write its results; then the next leg begins."""
    coefficients(lane, SCRATCH, lanes)
    h = lanes[STEP + lane]
    ending, after = UNRESOLVED, 0.0
    if h > 0.0 and lanes[COUNT + lane] < MOST_STEPS:
        ending, after = RUNS_ON, h
        for j in range(EVENTS):
            found = _first_above(STATES + EXTREMES + j, h, SCRATCH, lanes)
            if found < after or (found <= after and ending == RUNS_ON):
                ending, after = FIRST_EVENT + EVENT_ENDINGS[j], found
    leg = int(lanes[LEG + lane])
    first = leg * (2 * STATES + 1 + EXTREMES)
    for i in range(STATES):
        last = value_after(i, after, SCRATCH, lanes)
        size = max(lanes[SIZES + i * LANES + lane], abs(last))
        measures[first + i, cell] = last if ending != UNRESOLVED else math.nan
        measures[first + STATES + 1 + EXTREMES + i, cell] = size if ending != UNRESOLVED else math.nan
    time = run.duration if ending == RUNS_ON else lanes[TIME + lane] + after
    measures[first + STATES, cell] = time if ending != UNRESOLVED else math.nan
    for i in range(EXTREMES):
        top, last = lanes[TOP + i * LANES + lane], greatest_until(STATES + i, after, SCRATCH, lanes)
        found = last if last > top else top
        measures[first + STATES + 1 + i, cell] = found if ending != UNRESOLVED else math.nan
    if ending != UNRESOLVED and after > 0.0 and _ends_wrong(lane, after, lanes):
        ending = UNRESOLVED
        for row in range(first, first + 2 * STATES + 1 + EXTREMES):
            measures[row, cell] = math.nan
    counts[leg, cell] = ending
    last = len(LEGS) - 1
    before_steps, before_unproved = (counts[last + 1, cell], counts[last + 2, cell]) if leg > 0 else (0, 0)
    counts[last + 1, cell] = before_steps + int(lanes[COUNT + lane])
    counts[last + 2, cell] = before_unproved + int(lanes[UNPROVED + lane])
    if not lanes[COUNT + lane] < MOST_STEPS:
        # a smaller tolerance takes more steps
        for later in range(leg + 1, len(LEGS)):
            counts[later, cell] = UNRESOLVED
        for row in range(first, measures.shape[0]):
            measures[row, cell] = math.nan
        return False
    if leg < last:
        lanes[LEG + lane] = leg + 1.0
        set_off(lane, run, lanes)
    return leg < last
