"""The entry point: many cells, each integrated until its ending is known, in SIMD lanes and in parallel.

A worker processes a chunk of cells, LANES cells at a time, side by side in memory. The loop over lanes is innermost,
so that the compiler turns it into full-width vector code. When the cell of a lane has ended, the next cell of the
chunk is loaded into the lane, so no lane waits for a slower neighbour. The stages before and after the steps of a
cell run for a block of LANES consecutive cells at a time, in vector code too. Lanes never exchange numbers, every
loop over them has the same fixed length, and the step depends only on the cell. So the bits of a cell do not depend
on threads, chunks, order or neighbours.

The model's functions are declared in `kernels.lanes.interface`; `kernels.lanes.binding` replaces them.

Words of bits
    Sets of lanes, and of the blocks of a worker, are words (int64): bit n stands for lane or block n. There are as
    many blocks as lanes, because every lane may step a cell of a different block.
"""

import numpy as np

from kernels.jit import kernel, simd
from kernels.lanes.interface import (
    FURTHER_STEPS,
    RETURNED,
    SIZE,
    STEPPING,
    STEPS,
    advance,
    fill_idle,
    finish_leg,
    further_step,
    go_on,
    land,
    needs_integration,
    prepare,
    prepared_settings,
    read_start,
    set_off,
)
from kernels.lanes.intrinsics import count_trailing_zeros
from kernels.lanes.layout import LANES, aligned
from kernels.native.entry import parallel

#: Cells of a chunk, which a thread takes at a time: enough to make the cost of filling and draining the lanes small.
CHUNK = 2048

#: The word of all lanes or blocks; the word of each lane.
_ALL = (1 << LANES) - 1
_WORDS = np.array([1 << lane for lane in range(LANES)])

# Rows of `notes`, int64[_NOTE_ROWS, LANES]. For each block:
#: its first cell,
_FIRST = 0
#: the word of its lanes that have a leg to step or have stepped it,
_LEG = 1
#: the lanes among them whose leg has not ended,
_LEFT = 2
#: the lanes among them that wait for a stepping lane.
_WAITING = 3
# For each stepping lane:
#: the offset of its cell in the memory of the blocks,
_PLACE = 4
#: the number of steps that all lanes had made when the cell was loaded.
_SINCE = 5
_NOTE_ROWS = _SINCE + 1


@simd
def _advance_all(run, lanes):
    """Make one step of every lane, and the further steps without events; return the word of the lanes with an event."""
    going = 0
    for lane in range(LANES):
        # one masked instruction; shifting a bit into its place would take five
        going |= 0 if advance(lane, run, lanes) else _WORDS[lane]
    for n in range(FURTHER_STEPS.size):
        for lane in range(LANES):
            further_step(lane, FURTHER_STEPS[n], run, lanes)
    return _ALL & ~going


@kernel
def _advance_to_event(pending, idle, run, lanes):
    """Step all lanes until one that is not idle has an event.

    Returns the word of the lanes whose event is handled now; the word of the lanes with an event in the last step,
    which is handled next time; the number of steps.
    """
    events, steps = 0, 0
    while events == 0:
        # The events of a step are handled after the next step has begun, in which a lane with an event rests. So the
        # processor need not wait for the end of a step before it begins the next one.
        events = pending
        pending = _advance_all(run, lanes) & ~(events | idle)
        steps += 1
    return events, pending, steps


@kernel
def _prepare_all(run, block):
    for lane in range(LANES):
        prepare(lane, run, block)


@kernel
def _set_off_all(run, block):
    for lane in range(LANES):
        set_off(lane, run, block)


@kernel
def _land_all(run, block):
    for lane in range(LANES):
        land(lane, run, block)


@kernel
def _begin(first, stop, starts, run, block, measures, counts):
    """Put the cells from `first` on into a block; return the word of the lanes that need integration."""
    read = 0
    for lane in range(LANES):
        if first + lane < stop:
            read |= int(read_start(first + lane, lane, starts, run, block, measures, counts)) << lane
        else:
            fill_idle(lane, block)
    _prepare_all(run, block)
    integrated = 0
    while read != 0:
        lane = count_trailing_zeros(read)
        read &= read - 1
        integrated |= int(needs_integration(first + lane, lane, run, block, measures, counts)) << lane
    _set_off_all(run, block)
    return integrated


@kernel
def _end(first, legs, run, block, measures, counts):
    """Finish the legs of the lanes of a block; return the word of the lanes that begin another leg."""
    _land_all(run, block)
    again = 0
    while legs != 0:
        lane = count_trailing_zeros(legs)
        legs &= legs - 1
        again |= int(finish_leg(first + lane, lane, run, block, measures, counts)) << lane
    return again


@kernel
def _let_wait(lanes, number, notes):
    """Queue lanes of a block for stepping; return the word of the block, or 0 without lanes."""
    notes[_LEG, number], notes[_LEFT, number], notes[_WAITING, number] = lanes, lanes, lanes
    return int(lanes != 0) << number


@simd
def _load(lane, number, steps, memory, notes):
    """Load a waiting cell of a block into a stepping lane; return the word of the block, or 0 if more cells wait."""
    place = STEPPING + number * SIZE + count_trailing_zeros(notes[_WAITING, number])
    notes[_WAITING, number] &= notes[_WAITING, number] - 1
    for row in range(0, STEPPING, LANES):
        memory[row + lane] = memory[place + row]
    notes[_PLACE, lane], notes[_SINCE, lane] = place, steps
    return int(notes[_WAITING, number] == 0) << number


@simd
def _store(events, steps, memory, notes):
    """Store lanes with an event back into their blocks; return the word of the blocks whose legs have all ended."""
    ended = 0
    while events != 0:
        lane = count_trailing_zeros(events)
        events &= events - 1
        place = notes[_PLACE, lane]
        for row in range(0, RETURNED, LANES):
            memory[place + row] = memory[row + lane]
        memory[place + STEPS] = steps - notes[_SINCE, lane]
        number = (place - STEPPING) // SIZE
        notes[_LEFT, number] &= ~(1 << (place - STEPPING - number * SIZE))
        ended |= int(notes[_LEFT, number] == 0) << number
    return ended


@simd
def _going_on(events, run, memory, notes):
    """Return the word of the lanes with an event that continue at once."""
    going = 0
    while events != 0:
        lane = count_trailing_zeros(events)
        events &= events - 1
        if go_on(lane, notes[_PLACE, lane], run, memory):
            going |= 1 << lane
            # the lane rested in the step that found the event and in the step begun since
            notes[_SINCE, lane] += 2
    return going


@kernel
def _integrate_all(start, stop, starts, run, memory, notes, measures, counts):
    """Integrate the cells from `start` to `stop`; `memory` contains the stepping lanes, all zero, then the blocks."""
    following, total = start, 0
    # words of stepping lanes: without a cell; with an event that has not been handled yet
    idle, pending = _ALL, 0
    # words of blocks: with cells that wait for a lane; without cells
    waiting, spare = 0, _ALL
    while True:
        while idle != 0 and (waiting != 0 or following < stop):
            if waiting != 0:
                waiting &= ~_load(
                    count_trailing_zeros(idle), count_trailing_zeros(waiting), total, memory, notes
                )
                idle &= idle - 1
            else:
                number = count_trailing_zeros(spare)
                notes[_FIRST, number] = following
                first = STEPPING + number * SIZE
                legs = _begin(following, stop, starts, run, memory[first : first + SIZE], measures, counts)
                waiting = _let_wait(legs, number, notes)
                spare &= ~waiting
                following += LANES
        if idle == _ALL:
            return
        events, pending, steps = _advance_to_event(pending, idle, run, memory)
        total += steps
        events &= ~_going_on(events, run, memory, notes)
        idle |= events
        # the last step was made after these events
        ended = _store(events, total - 1, memory, notes)
        while ended != 0:
            number = count_trailing_zeros(ended)
            ended &= ended - 1
            first, legs = notes[_FIRST, number], notes[_LEG, number]
            place = STEPPING + number * SIZE
            legs = _end(first, legs, run, memory[place : place + SIZE], measures, counts)
            again = _let_wait(legs, number, notes)
            waiting |= again
            spare |= (1 << number) & ~again


def memory_of_thread(*_):
    """Return the memory of a thread: the stepping lanes and all blocks, and notes."""
    return aligned(STEPPING + LANES * SIZE), np.empty((_NOTE_ROWS, LANES), np.int64)


@parallel(
    CHUNK,
    memory_of_thread,
    starts="float64[:, ::1]",
    settings="float64[::1]",
    measures="float64[:, ::1], written",
    counts="int32[:, ::1], written",
    memory="float64[::1]",
    notes="int64[:, ::1]",
)
def integrate(start, stop, starts, settings, measures, counts, memory, notes):
    """Integrate every cell until its ending is known; a template that `kernels.lanes.binding.bind` completes.

    Python calls it without `start`, `stop` and the arguments after `counts`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts : float64[parameters, n]
        One cell per column; the model defines the rows.
    settings : float64[:]
        Settings of the run, as the model's `prepared_settings` reads them.
    measures : float64[measures, n], written
    counts : int32[counts, n], written
    memory, notes : arrays
        From `memory_of_thread`.

    Notes
    -----
    Never raises.
    """
    memory[:STEPPING] = 0.0
    notes[:] = 0
    _integrate_all(start, stop, starts, prepared_settings(settings), memory, notes, measures, counts)
