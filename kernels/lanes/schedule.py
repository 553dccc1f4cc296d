"""The entry point: many cells, each integrated until its ending is known, in SIMD lanes and in parallel.

A worker owns a chunk of cells and LANES trajectories at a time, side by side in memory; the loop over lanes is
innermost, so that the compiler turns it into full-width vector code. When the cell of a lane has ended, the next cell
of the chunk takes the lane over: no lane waits for a slower neighbour. What comes before and after the steps of a
cell is done for a block of LANES consecutive cells at a time, in vector code too. Lanes and columns never exchange a
number, every loop over them has the same fixed length, and the step follows from the cell alone, so a cell's bits do
not depend on threads, chunks, order or neighbours.
"""

import numpy as np
from numba import prange

from kernels.disk import layout as at
from kernels.disk.leg_control import goes_on, moves, read, vacate
from kernels.disk.rk4 import lane_step
from kernels.disk.simd_stages import land, prepare, set_off
from kernels.disk.step_size import COS_FALL, DURATION, PACE, STEP, prepared
from kernels.jit import internal, parallel, simd
from kernels.lanes.intrinsics import count_trailing_zeros, without_refcount
from kernels.lanes.stride import coprime_stride

#: Numbers in a cache line.
_LINE = 8

#: Cells that one task of the parallel loop owns: long enough that filling and draining the lanes costs little.
CHUNK = 2048

#: A word with a bit for every lane, or for every block of a worker: there are as many, for every lane may keep one.
_ALL = (1 << at.LANES) - 1

#: What a worker notes of each block: its first cell, the columns of the present leg, those that have not ended, those
#: that wait for a lane. And of each lane: where its column begins in the memory, the step after which it took it over.
_FIRST, _LEG, _LEFT, _WAITING, _PLACE, _SINCE = range(6)


@simd
def _advance(lanes, lowest):
    """One step of every lane; returns a word whose bit n says that something occurred in lane n, which then rests."""
    events = 0
    for lane in range(at.LANES):
        # every load comes before the first store: only so can the compiler prove that the lanes are independent
        half, heading, end = lanes[at.HALF + lane], lanes[at.HEADING + lane], lanes[at.END + lane]
        uniform, graded = lanes[at.HALF_UNIFORM + lane], lanes[at.HALF_GRADED + lane]
        t = lanes[at.TIME + lane] + (half + half)
        S, C, T, w, o, p = lane_step(
            lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane],
            lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.P + lane],
            lanes[at.I_TILT + lane], lanes[at.I_SPIN + lane], lanes[at.DRAG + lane], half,
        )  # fmt: skip
        # "not >=" rather than "<", so that a NaN is an event too
        occurred = (heading * w < 0.0) | (not (C >= lowest)) | (t >= end)
        lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane], lanes[at.W + lane] = S, C, T, w
        lanes[at.O_RATE + lane], lanes[at.P + lane], lanes[at.TIME + lane] = o, p, t
        lanes[at.HALF + lane] = 0.0 if occurred else uniform + graded * C
        events |= int(occurred) << lane
    return events


@internal
def _advance_to_event(occurred, idle, lowest, lanes):
    """Step until something has occurred in a lane that is not idle: (in these lanes, in others since, passes)."""
    events, passes = 0, 0
    while events == 0:
        # What occurred is looked at while the next step is under way, through which such a lane rests: the processor
        # need not wait for the end of the one before it can begin the other.
        events = occurred
        occurred = _advance(lanes, lowest) & ~(events | idle)
        passes += 1
    return events, occurred, passes


@internal
def _prepare_all(given_step, pace, block):
    for lane in range(at.LANES):
        prepare(lane, given_step, pace, block)


@internal
def _set_off_all(given_step, duration, block):
    for lane in range(at.LANES):
        set_off(lane, given_step, duration, block)


@internal
def _land_all(lowest, block):
    for lane in range(at.LANES):
        land(lane, lowest, block)


@internal
def _begin(first, stop, starts, settings, block, measures, counts):
    """Put the cells from `first` on into a block; returns a word of the columns that are to be integrated."""
    word = 0
    for lane in range(at.LANES):
        if first + lane < stop:
            word |= int(read(first + lane, lane, starts, settings, block, measures, counts)) << lane
        else:
            vacate(lane, block)
    _prepare_all(settings[STEP], settings[PACE], block)
    moving = 0
    while word != 0:
        lane = count_trailing_zeros(word)
        word &= word - 1
        moving |= int(moves(first + lane, lane, settings, block, measures, counts)) << lane
    _set_off_all(settings[STEP], settings[DURATION], block)
    return moving


@internal
def _end(first, word, settings, block, measures, counts):
    """Decide on the columns of a word, whose legs have ended; returns a word of those that have set off again."""
    _land_all(settings[COS_FALL], block)
    again = 0
    while word != 0:
        lane = count_trailing_zeros(word)
        word &= word - 1
        again |= int(goes_on(first + lane, lane, settings, block, measures, counts)) << lane
    return again


@internal
def _block(number, memory):
    return memory[at.MOVING + number * at.SIZE : at.MOVING + (number + 1) * at.SIZE]


@internal
def _note(word, number, notes):
    """Let the columns of a word wait for lanes; returns a word of blocks, empty if there are none."""
    notes[_LEG, number], notes[_LEFT, number], notes[_WAITING, number] = word, word, word
    return int(word != 0) << number


@simd
def _take_over(lane, number, passed, memory, notes):
    """Put a waiting column of a block into a lane; returns a word of blocks, empty if more columns of it wait."""
    column = count_trailing_zeros(notes[_WAITING, number])
    notes[_WAITING, number] &= notes[_WAITING, number] - 1
    place = at.MOVING + number * at.SIZE + column
    for row in range(0, at.MOVING, at.LANES):
        memory[row + lane] = memory[place + row]
    notes[_PLACE, lane], notes[_SINCE, lane] = place, passed
    return int(notes[_WAITING, number] == 0) << number


@simd
def _give_back(events, passed, memory, notes):
    """Put lanes that have ended back into their columns; returns a word of the blocks that have ended by this."""
    ended = 0
    while events != 0:
        lane = count_trailing_zeros(events)
        events &= events - 1
        place = notes[_PLACE, lane]
        for row in range(0, at.HALF, at.LANES):
            memory[place + row] = memory[row + lane]
        memory[place + at.STEPS] = passed - notes[_SINCE, lane]
        number = (place - at.MOVING) // at.SIZE
        notes[_LEFT, number] &= ~(1 << (place - at.MOVING - number * at.SIZE))
        ended |= int(notes[_LEFT, number] == 0) << number
    return ended


@internal
def _integrate_all(start, stop, starts, settings, memory, notes, measures, counts):
    """Integrate the cells from `start` to `stop`; the lanes lie in memory first, all zero, then the blocks."""
    # the caller's own are freed after this call; without_refcount there, they would be freed before it
    memory, notes = without_refcount(memory), without_refcount(notes)
    following, passed = start, 0
    # words of lanes: without a cell, with an event; words of blocks: with columns that wait, without cells
    idle, occurred, waiting, spare = _ALL, 0, 0, _ALL
    while True:
        while idle != 0 and (waiting != 0 or following < stop):
            if waiting != 0:
                waiting &= ~_take_over(
                    count_trailing_zeros(idle), count_trailing_zeros(waiting), passed, memory, notes
                )
                idle &= idle - 1
            else:
                number = count_trailing_zeros(spare)
                notes[_FIRST, number] = following
                word = _begin(following, stop, starts, settings, _block(number, memory), measures, counts)
                waiting = _note(word, number, notes)
                spare &= ~waiting
                following += at.LANES
        if idle == _ALL:
            return
        events, occurred, passes = _advance_to_event(occurred, idle, settings[COS_FALL], memory)
        passed += passes
        idle |= events
        ended = _give_back(events, passed - 1, memory, notes)
        while ended != 0:
            number = count_trailing_zeros(ended)
            ended &= ended - 1
            first, leg = notes[_FIRST, number], notes[_LEG, number]
            again = _note(_end(first, leg, settings, _block(number, memory), measures, counts), number, notes)
            waiting |= again
            spare |= (1 << number) & ~again


@internal
def _integrate_chunk(start, stop, starts, settings, measures, counts):
    memory = np.empty(at.MOVING + at.LANES * at.SIZE + _LINE)
    # full vectors that cross a cache line cost a quarter of the speed
    aligned = memory[-(memory.ctypes.data // 8) % _LINE :]
    aligned[: at.MOVING] = 0.0
    notes = np.zeros((6, at.LANES), np.int64)
    _integrate_all(start, stop, starts, settings, aligned, notes, measures, counts)


@parallel
def integrate(starts, settings, measures, counts):
    """Integrate every cell until its ending is known.

    Parameters
    ----------
    starts : float64[7, n]
        Rows: tilt [rad], tilt rate, precession rate, roll rate [rad/s], alpha [1], radius [m], gravity [m/s^2].
    settings : float64[4]
        duration [s]; step [s], 0 for the engine's own choice; fall_tilt [rad]; tolerance on extreme tilts [rad].
    measures : float64[6, n], written
        Rows: least and greatest tilt [rad], fall time [s], nutation period [s], relative energy drift [1], estimated
        error of the extreme tilts [rad]. NaN where a measure does not exist.
    counts : int32[3, n], written
        Rows: ending (`kernels.disk.endings`), steps of the accepted integration, refinements of the step.

    Notes
    -----
    Never raises.
    """
    n = starts.shape[1]
    chunks = (n + CHUNK - 1) // CHUNK
    run = prepared(settings)
    step = coprime_stride(chunks)
    for place in prange(chunks):
        chunk = place * step % chunks
        start, stop = chunk * CHUNK, min(n, (chunk + 1) * CHUNK)
        _integrate_chunk(
            start,
            stop,
            without_refcount(starts),
            without_refcount(run),
            without_refcount(measures),
            without_refcount(counts),
        )
