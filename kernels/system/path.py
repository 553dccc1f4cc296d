"""One motion of a system in time: the legs of a cell, sampled from the series of their steps.

Its entry point takes `(starts, settings, times, measures, counts)`:

Parameters
----------
starts : float64[states + parameters, 1]
settings : float64[3]
    As for `kernels.system.integrate`.
times : float64[n]
    Increasing, from 0 to the duration.
measures : float64[4 rows, n], written
    The results of `kernels.system.integrate` for a cell whose duration is each of the times. A leg that has ended
    keeps its final values. For a failed leg, the time until which it was followed, and NaN.
counts : int32[6, n], written
    Likewise; filled with `kernels.system.endings.UNRESOLVED` by the caller.

Notes
-----
Never raises. The steps are the same as in a sweep, made by the same functions in one lane. A sample takes as many
multiplications as its series have terms.
"""

from kernels.jit import kernel
from kernels.lanes.binding import variant
from kernels.lanes.layout import LANES, aligned
from kernels.native.entry import parallel
from kernels.system import lanes as system_lanes
from kernels.system.endings import FIRST_EVENT, RUNS_ON, UNRESOLVED
from kernels.system.integrate import numbers_of, program_of
from kernels.system.lanes import finish_leg, go_on, prepared_settings, read_start, set_off
from kernels.system.moments import NUMBERS, watch
from kernels.system.roots import greatest_to, value_at

LEGS = system_lanes.LEGS
STATES: int = 0
EXTREMES: int = 0
MOMENTS: int = 0
#: Numbers that `kernels.system.moments` keeps from step to step; results of a leg.
WATCHED: int = 0
ROWS: int = 0

# Rows of the lane; see `kernels.system.lanes`.
TIME: int = 0
TOP: int = 0
SIZES: int = 0
COUNT: int = 0
UNPROVED: int = 0
WATCH: int = 0
BEFORE: int = 0
STEP: int = 0
SCRATCH: int = 0
WORK: int = 0
STEPPING: int = 0
SIZE: int = 0


@kernel
def advance(lane, run, lanes):
    """Make one step; replaced by a function generated from the right-hand side."""


@kernel
def coefficients(lane, scratch, lanes):
    """Write the series of a lane into a scratch; replaced by a function generated from the right-hand side."""


@kernel
def _keep(memory):
    """Save greatest values, magnitudes and moments at the beginning of a step, after the lane's own memory."""
    for j in range(STATES):
        memory[STEPPING + SIZE + j] = memory[SIZES + j * LANES]
    for j in range(EXTREMES):
        memory[STEPPING + SIZE + STATES + j] = memory[TOP + j * LANES]
    for j in range(WATCHED):
        memory[STEPPING + SIZE + STATES + EXTREMES + j] = memory[WATCH + j * LANES]


@kernel
def _sample_moments(lane, row, i, begun, d, memory, measures):
    """Write the moments until a time d after the beginning of a step, from the row `row` on."""
    kept, now = STEPPING + SIZE + STATES + EXTREMES, memory[TIME]
    for j in range(WATCHED):
        memory[kept + WATCHED + j] = memory[WATCH + j * LANES]
        memory[WATCH + j * LANES] = memory[kept + j]
    memory[TIME] = begun
    watch(lane, SCRATCH, d, RUNS_ON, memory)
    memory[TIME] = now
    for j in range(MOMENTS * NUMBERS):
        measures[row + j, i] = memory[WATCH + j * LANES]
    for j in range(WATCHED):
        memory[WATCH + j * LANES] = memory[kept + WATCHED + j]


@kernel
def _sample(lane, i, leg, time, begun, memory, measures, counts):
    """Write a sample in a step that began at `begun`, whose series are in the scratch."""
    first, d = leg * ROWS, time - begun
    measures[first + STATES, i] = time
    for j in range(STATES):
        found = value_at(SCRATCH + j * system_lanes.COEFFICIENTS, d, memory)
        before = memory[STEPPING + SIZE + j]
        measures[first + j, i] = found
        measures[first + STATES + 1 + EXTREMES + j, i] = max(before, abs(found))
    for j in range(EXTREMES):
        top = greatest_to(SCRATCH + (STATES + j) * system_lanes.COEFFICIENTS, d, SCRATCH + WORK, memory)
        measures[first + STATES + 1 + j, i] = max(memory[STEPPING + SIZE + STATES + j], top)
    _sample_moments(lane, first + 2 * STATES + 1 + EXTREMES, i, begun, d, memory, measures)
    counts[leg, i] = RUNS_ON
    _count(i, leg, int(memory[COUNT]), int(memory[UNPROVED]), counts)


@kernel
def _count(i, leg, steps, unproved, counts):
    """Add the steps of a leg to the steps of the earlier legs."""
    counts[len(LEGS), i] = steps + (counts[len(LEGS), i] if leg > 0 else 0)
    counts[len(LEGS) + 1, i] = unproved + (counts[len(LEGS) + 1, i] if leg > 0 else 0)


@kernel
def _stay(first, leg, steps, unproved, measures, counts):
    """Copy the final results of a leg, which are in the last column, into all columns from `first` on."""
    last, rows = measures.shape[1] - 1, ROWS
    for i in range(first, last):
        for row in range(leg * rows, (leg + 1) * rows):
            measures[row, i] = measures[row, last]
        counts[leg, i] = counts[leg, last]
        _count(i, leg, steps, unproved, counts)


@kernel
def _follow_pass(lane, leg, run, times, memory, measures, counts):
    """Follow one leg; return whether another one follows."""
    i, last = lane, len(times) - 1
    while True:
        _keep(memory)
        coefficients(lane, SCRATCH, memory)
        begun, ended = memory[TIME], False
        if advance(lane, run, memory):
            # its series are in another scratch then
            ended = not go_on(lane, lane + STEPPING, run, memory)
        h = memory[STEP] if ended else memory[BEFORE]
        first = i
        while i < last and (times[i] - begun < h or (ended and times[i] - begun <= h)):
            _sample(lane, i, leg, times[i], begun, memory, measures, counts)
            i += 1
        if ended:
            break
    steps, unproved = int(memory[COUNT]), int(memory[UNPROVED])
    again = finish_leg(lane, lane, run, memory, measures[:, last:], counts[:, last:])
    end = measures[leg * ROWS + STATES, last]
    # a leg that fails in a step is known up to the beginning of the step
    failed = UNRESOLVED <= counts[leg, last] < FIRST_EVENT
    while first < last and not failed and times[first] < end:
        first += 1
    _stay(first, leg, steps, unproved, measures, counts)
    return again


@parallel(
    1,
    starts="float64[:, ::1]",
    settings="float64[::1]",
    times="float64[::1]",
    measures="float64[:, ::1], written",
    counts="int32[:, ::1], written",
    memory="float64[::1]",
)
def follow(start, stop, starts, settings, times, measures, counts, memory):
    """Follow one start; a template that `entry_point` completes."""
    # with a literal 0 as the lane, Numba would compile all lane functions a second time
    lane = start
    run = prepared_settings(settings)
    memory[:] = 0.0
    read_start(lane, lane, starts, run, memory, measures, counts)
    set_off(lane, run, memory)
    for leg in range(len(LEGS)):
        if not _follow_pass(lane, leg, run, times, memory, measures, counts):
            break


def entry_point(*given):
    """Return the entry point of a system; the arguments are the same as in `kernels.system.integrate.entry_point`."""
    layout, made, numbers, name, copies = numbers_of(*given, LEGS)
    # the rows of moments end where the length of the step is kept
    watched = (layout.STEP - layout.WATCH) // LANES
    flags = {**numbers, "WATCHED": watched, "advance": made["advance"]}
    found = variant(follow, f"path_{name}", flags, copies)
    size = layout.STEPPING + layout.SIZE + numbers["STATES"] + numbers["EXTREMES"] + 2 * watched
    # the lane, two scratches, the values saved at the beginning of a step, and moments at its end
    return found.copied(found.py_func, lambda *_: (aligned(size),))


def __getattr__(name):
    """Make the entry point whose name is a program in JSON, as in `kernels.system.integrate`."""
    if not name.startswith("["):
        return getattr(None, name)
    made = globals()[name] = entry_point(*program_of(name))
    return made
