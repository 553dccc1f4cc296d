"""The lane functions that all systems share; `kernels.system.source` generates the others from the right-hand side.

A cell is integrated four times, each time with a hundredth of the previous tolerance. If the last two motions end in
the same way, at the same time and place, the result is accepted; the differences estimate the error of the last
motion. A single difference would be small by chance in one cell of a hundred. The first leg takes a third of the
steps of the last one.

`kernels.lanes.binding` replaces the names in capitals, `series` and `constants` by the values of one system.
"""

import math
from typing import NamedTuple

from kernels.jit import kernel, simd
from kernels.lanes.layout import LANES
from kernels.system.endings import ENDLESS, FIRST_EVENT, GROWS, JUMPS, RUNS_ON, UNRESOLVED
from kernels.system.moments import GOES_ON, NUMBERS, forget_moments, watch
from kernels.system.polynomials import ORDER
from kernels.system.roots import first_above, greatest_to, slope_at, value_at

#: Tolerance of each leg over the tolerance of the last one.
LEGS = (1e6, 1e4, 1e2, 1.0)

#: A step has failed if the rate at its end differs from its series by this many tolerances, or by this share of a
#: state. Then the series has crossed a point where the right-hand side is not smooth, such as the zero of a root, or
#: all its terms happened to vanish.
JUMP, LEAST_JUMP = 1024.0, 1e-9

#: Allowed difference of the rates by rounding, over the magnitude of their terms, which may cancel.
NOISE = 1e-12

#: A change of a state by this much is negligible, however small the state is.
LEAST_CHANGE = 1e-190

#: Largest number of steps of a leg.
MOST_STEPS = 10_000_000.0

#: Numbers of states, of those among them that are integrals and begin at 0, of expressions whose greatest value is
#: computed, of expressions that end a motion, of moments (`kernels.system.moments`), of constants, of all series.
STATES: int = 0
INTEGRALS: int = 0
EXTREMES: int = 0
EVENTS: int = 0
MOMENTS: int = 0
CONSTANTS: int = 0
SERIES: int = 0
#: Number of results of a leg.
ROWS: int = 0
#: Number of the ending of each expression that ends a motion.
EVENT_ENDINGS: tuple = ()

# Rows of lanes; `kernels.system.source` defines their order.
Y: int = 0
TIME: int = 0
TOP: int = 0
SIZES: int = 0
COUNT: int = 0
UNPROVED: int = 0
WATCH: int = 0
SIDE: int = 0
STEP: int = 0
END: int = 0
LOG_TOLERANCE: int = 0
LONGEST: int = 0
SLOPE: int = 0
BEFORE: int = 0
START: int = 0
LEG: int = 0
SCRATCH: int = 0
WORK: int = 0
STEPPING: int = 0
SIZE: int = 0

COEFFICIENTS = ORDER + 1


class Run(NamedTuple):
    """Settings of a run: the duration, the longest step, the binary logarithm of the tolerance of each leg."""

    duration: float
    longest: float
    tolerances: tuple


@kernel
def prepared_settings(settings):
    """Return the `Run` of settings: duration, longest step (0: no limit), tolerance."""
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
    """Write the series of a lane into a scratch; replaced by a function generated from the right-hand side."""


@kernel
def safe_step(lane, h, lanes):
    """Return the largest step of a lane, up to h, in which nothing can hide; replaced by a generated function."""


@kernel
def constants(cell, lane, starts, lanes):
    """Write the constants of a cell into its lane; replaced by a function generated from the right-hand side."""


@kernel
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Read states and constants."""
    for i in range(STATES):
        lanes[START + i * LANES + lane] = starts[i, cell] if i < STATES - INTEGRALS else 0.0
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
    """Do nothing: there is nothing to compute from a start."""


@simd
def needs_integration(cell, lane, run, lanes, measures, counts):
    """Return True: every cell needs steps."""
    return True


@simd
def set_off(lane, run, lanes):
    """Begin a leg at the start."""
    for i in range(STATES):
        lanes[Y + i * LANES + lane] = lanes[START + i * LANES + lane]
        lanes[SIZES + i * LANES + lane] = abs(lanes[START + i * LANES + lane])
    for i in range(EXTREMES):
        lanes[TOP + i * LANES + lane] = -math.inf
    forget_moments(lane, lanes)
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
    """Do nothing: `finish_leg` finds the end of a leg for each cell."""


@kernel
def _jumps(lane, h, lanes):
    """Return whether the rates in the scratch differ from the series of the step of length h that has just ended."""
    room = JUMP * 2.0 ** lanes[LOG_TOLERANCE + lane] + LEAST_JUMP
    for i in range(STATES):
        size = max(lanes[SIZES + i * LANES + lane], abs(lanes[Y + i * LANES + lane]))
        apart = abs(lanes[SCRATCH + i * COEFFICIENTS + 1] - lanes[SLOPE + i * LANES + lane])
        noise = NOISE * lanes[SCRATCH + SERIES * COEFFICIENTS + i]
        # written so that a rate that is NaN counts as a jump
        if not (apart * h <= room * size + LEAST_CHANGE or apart <= noise):
            return True
    return False


@kernel
def _ends_wrong(lane, h, lanes):
    """Move a lane to the end of its last step; return whether the rate there differs from its series."""
    for i in range(STATES):
        lanes[SLOPE + i * LANES + lane] = slope_at(SCRATCH + i * COEFFICIENTS, h, lanes)
        lanes[Y + i * LANES + lane] = value_at(SCRATCH + i * COEFFICIENTS, h, lanes)
    lanes[TIME + lane] += h
    coefficients(lane, SCRATCH, lanes)
    return _jumps(lane, h, lanes)


@kernel
def _failure(lane, lanes):
    """Return why a lane cannot continue from its state, whose series are in the scratch."""
    if not lanes[COUNT + lane] < MOST_STEPS:
        return ENDLESS
    for i in range(SERIES):
        # later terms may overflow if a motion grows
        row = SCRATCH + i * COEFFICIENTS
        if not math.isfinite(lanes[row] + lanes[row + 1] + lanes[row + 2]):
            return UNRESOLVED
    if lanes[BEFORE + lane] > 0.0 and _jumps(lane, lanes[BEFORE + lane], lanes):
        return JUMPS
    return GROWS


@kernel
def go_on(lane, place, run, memory):
    """Continue a lane whose step has no event although a simple bound does not prove it, or has several maxima.

    A step in which something may hide is shortened first.
    """
    memory[STEP + lane] = h = safe_step(lane, memory[STEP + lane], memory)
    if not h < memory[END + lane] - memory[TIME + lane]:
        return False
    scratch = place - (place - STEPPING) % SIZE + SCRATCH
    coefficients(lane, scratch, memory)
    work, proved = scratch + WORK, True
    for j in range(EVENTS):
        row = scratch + (STATES + EXTREMES + j) * COEFFICIENTS
        crossing, known = first_above(row, h, work, memory)
        proved = proved and known
        if crossing <= h:
            return False
    for i in range(STATES):
        row = scratch + i * COEFFICIENTS
        memory[SLOPE + i * LANES + lane] = slope_at(row, h, memory)
        memory[Y + i * LANES + lane] = state = value_at(row, h, memory)
        memory[SIZES + i * LANES + lane] = max(memory[SIZES + i * LANES + lane], abs(state))
    for i in range(EXTREMES):
        top = greatest_to(scratch + (STATES + i) * COEFFICIENTS, h, work, memory)
        memory[TOP + i * LANES + lane] = max(memory[TOP + i * LANES + lane], top)
    watch(lane, scratch, h, GOES_ON, memory)
    memory[TIME + lane] += h
    memory[BEFORE + lane] = h
    memory[COUNT + lane] += 1.0
    memory[UNPROVED + lane] += 0.0 if proved else 1.0
    return True


@kernel
def finish_leg(cell, lane, run, lanes, measures, counts):
    """Go to the end of a leg and write its results; then begin the next leg."""
    coefficients(lane, SCRATCH, lanes)
    h = lanes[STEP + lane]
    followed = h > 0.0 and lanes[COUNT + lane] < MOST_STEPS
    ending, after = RUNS_ON, h
    if not followed:
        ending, after = _failure(lane, lanes), 0.0
    for j in range(EVENTS if followed else 0):
        row = SCRATCH + (STATES + EXTREMES + j) * COEFFICIENTS
        crossing, _ = first_above(row, h, SCRATCH + WORK, lanes)
        if crossing < after or (crossing <= after and ending == RUNS_ON):
            ending, after = FIRST_EVENT + EVENT_ENDINGS[j], crossing
    leg = int(lanes[LEG + lane])
    first = leg * ROWS
    for i in range(STATES):
        last = value_at(SCRATCH + i * COEFFICIENTS, after, lanes)
        size = max(lanes[SIZES + i * LANES + lane], abs(last))
        measures[first + i, cell] = last if followed else math.nan
        measures[first + STATES + 1 + EXTREMES + i, cell] = size if followed else math.nan
    time = run.duration if ending == RUNS_ON else lanes[TIME + lane] + after
    measures[first + STATES, cell] = time
    for i in range(EXTREMES):
        row = SCRATCH + (STATES + i) * COEFFICIENTS
        top = max(lanes[TOP + i * LANES + lane], greatest_to(row, after, SCRATCH + WORK, lanes))
        measures[first + STATES + 1 + i, cell] = top if followed else math.nan
    watch(lane, SCRATCH, after, ending, lanes)
    for i in range(MOMENTS * NUMBERS):
        number = lanes[WATCH + i * LANES + lane]
        measures[first + 2 * STATES + 1 + EXTREMES + i, cell] = number if followed else math.nan
    if followed and after > 0.0 and _ends_wrong(lane, after, lanes):
        ending = JUMPS
        for row in range(first, first + ROWS):
            measures[row, cell] = math.nan
        measures[first + STATES, cell] = lanes[TIME + lane] - after
    counts[leg, cell] = ending
    last = len(LEGS) - 1
    before_steps, before_unproved = (counts[last + 1, cell], counts[last + 2, cell]) if leg > 0 else (0, 0)
    counts[last + 1, cell] = before_steps + int(lanes[COUNT + lane])
    counts[last + 2, cell] = before_unproved + int(lanes[UNPROVED + lane])
    if not lanes[COUNT + lane] < MOST_STEPS:
        # a smaller tolerance needs more steps
        for later in range(leg + 1, len(LEGS)):
            counts[later, cell] = ENDLESS
            for row in range(later * ROWS, (later + 1) * ROWS):
                measures[row, cell] = math.nan
            measures[later * ROWS + STATES, cell] = time
        return False
    if leg < last:
        lanes[LEG + lane] = leg + 1.0
        set_off(lane, run, lanes)
    return leg < last
