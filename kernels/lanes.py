"""The entry point: many cells, each integrated until its ending is known, in SIMD lanes and in parallel.

A worker owns a chunk of cells and LANES trajectories at a time, side by side in memory; the loop over lanes is
innermost, so that the compiler turns it into full-width vector code. When the cell of a lane has ended, the next cell
of the chunk takes the lane over: no lane waits for a slower neighbour. Lanes never exchange a number, every lane
loop has the same fixed length, and the step follows from the cell alone, so a cell's bits do not depend on threads,
chunks, order or neighbours.
"""

import math

import numpy as np
from numba import njit, prange

from kernels import rows as at
from kernels.bits import lowest_bit
from kernels.borrow import borrowed
from kernels.cell import AFRESH, BEGUN, DONE, begin, examine
from kernels.disk import CONTRACT
from kernels.pace import prepared
from kernels.rk4 import lane_step
from kernels.shares import scattered

#: Numbers in a cache line.
_LINE = 8

#: Cells that one task of the parallel loop owns: long enough that filling and draining the lanes costs little.
CHUNK = 2048


@njit(error_model="numpy", fastmath=CONTRACT)
def _advance(lanes):
    """One step of every lane; returns a word whose bit n says that something occurred in lane n."""
    events = 0
    for lane in range(at.LANES):
        # every load comes before the first store: only so can the compiler prove that the lanes are independent
        C = lanes[at.C + lane]
        h = lanes[at.STEP_UNIFORM + lane] + lanes[at.STEP_GRADED + lane] * C
        heading, lowest, end = lanes[at.HEADING + lane], lanes[at.LEAST_C + lane], lanes[at.END + lane]
        t = lanes[at.TIME + lane] + h
        S, C, T, w, o, s = lane_step(
            lanes[at.S + lane], C, lanes[at.T + lane],
            lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.S_RATE + lane],
            lanes[at.I_TILT + lane], lanes[at.I_ROLL + lane], lanes[at.I_SPIN + lane], lanes[at.I_INVERSE + lane],
            h,
        )  # fmt: skip
        lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane], lanes[at.W + lane] = S, C, T, w
        lanes[at.O_RATE + lane], lanes[at.S_RATE + lane], lanes[at.TIME + lane] = o, s, t
        # "not >=" rather than "<", so that a NaN is an event too
        events |= (int(heading * w < 0.0) | int(not (C >= lowest)) | int(t >= end)) << lane
    return events


@njit(error_model="numpy", fastmath=CONTRACT)
def _rest(lanes, lane):
    """Park a lane that has no cell: its step is zero and nothing can occur in it."""
    for row in range(0, at.SIZE, at.LANES):
        lanes[row + lane] = 0.0
    lanes[at.C + lane] = 1.0
    lanes[at.END + lane] = math.inf


@njit(error_model="numpy", fastmath=CONTRACT)
def _fill(lane, following, stop, starts, settings, lanes, measures, counts):
    """Give the lane the next cell that needs integration; returns (its cell or -1, the cell that follows)."""
    while following < stop:
        cell = following
        following += 1
        if begin(cell, lane, starts, settings, lanes, measures, counts) == BEGUN:
            return cell, following
    _rest(lanes, lane)
    return -1, following


@njit(error_model="numpy", fastmath=CONTRACT)
def _integrate_chunk(start, stop, starts, settings, lanes, measures, counts):
    cells = np.full(at.LANES, -1)
    begun = np.zeros(at.LANES, np.int64)
    following = start
    live = 0
    for lane in range(at.LANES):
        cells[lane], following = _fill(lane, following, stop, starts, settings, lanes, measures, counts)
        live += int(cells[lane] >= 0)
    passed = 0
    while live > 0:
        passed += 1
        events = _advance(lanes)
        if events == 0:
            continue
        while events != 0:
            lane = lowest_bit(events)
            events &= events - 1
            outcome = examine(
                cells[lane], lane, passed - begun[lane], starts, settings, lanes, measures, counts
            )
            if outcome == AFRESH:
                begun[lane] = passed
            elif outcome == DONE:
                begun[lane] = passed
                cells[lane], following = _fill(
                    lane, following, stop, starts, settings, lanes, measures, counts
                )
                live -= int(cells[lane] < 0)


@njit(error_model="numpy", fastmath=CONTRACT, parallel=True, nogil=True)
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
        Rows: ending (`kernels.endings`), steps of the accepted integration, refinements of the step.

    Notes
    -----
    Never raises.
    """
    n = starts.shape[1]
    chunks = (n + CHUNK - 1) // CHUNK
    # full vectors that cross a cache line cost a quarter of the speed
    memory = np.zeros(chunks * at.SIZE + _LINE)
    aligned = -(memory.ctypes.data // 8) % _LINE
    lanes = memory[aligned : aligned + chunks * at.SIZE].reshape(chunks, at.SIZE)
    run = prepared(settings)
    step = scattered(chunks)
    for place in prange(chunks):
        chunk = place * step % chunks
        start, stop = chunk * CHUNK, min(n, (chunk + 1) * CHUNK)
        _integrate_chunk(
            start, stop, borrowed(starts), borrowed(run), borrowed(lanes[chunk]),
            borrowed(measures), borrowed(counts),
        )  # fmt: skip
