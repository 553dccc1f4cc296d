"""What a model gives to the machinery: the numbers of its layout and the functions for the stages of a cell.

The functions of this module are stand-ins without a body. The machinery (`kernels.lanes.schedule`,
`kernels.lanes.cuda`) calls them by these names; `kernels.lanes.binding` puts the functions of one model in their place.
Their docstrings say what a model has to provide. `kernels.disk.integrate` is the worked example.

The stages of a cell
    `read_start` puts the start of a cell into a lane, `prepare` computes what follows from it, `needs_integration`
    decides whether it has to be stepped at all, and `set_off` places it at the beginning of its first *leg*: a series
    of steps that ends with an event. `advance` makes one step. When it reports an event, `land` computes where the leg
    ended and `finish_leg` decides what that means: another leg, or the results of the cell.

Two kinds of functions
    Those marked *vector* run over all lanes at once and have to be decorated with `kernels.jit.simd`, as has all that
    they call. So that the loop over lanes becomes full-width vector code they have no branch that cannot become a
    selection and load before they store: one call that is left when the loop is first compiled keeps it scalar, seven
    times as slow. They run for an idle lane too: its numbers have no meaning, and no result is written.
    Those marked *scalar* run for one cell at a time (`kernels.jit.kernel` or `simd`). No function raises, makes an
    array or returns a part of one.

Arguments
    cell : int
        Column of the cell in `starts`, `measures` and `counts`.
    lane : int
        Its place among the LANES cells of `lanes`.
    starts : float64[parameters, n]
        The cells, one per column; the model defines the rows.
    run : tuple of floats
        What `prepared_settings` returned.
    lanes : float64[:]
        The numbers of LANES cells, laid out as in `kernels.lanes.layout`: those of the stepping lanes (STEPPING
        numbers) for `advance`, of a block (SIZE numbers) for all other functions.
    measures : float64[measures, n], counts : int32[counts, n]
        The results; each cell's column is written exactly once, when its ending is known.
"""

from typing import Any, NamedTuple

import numpy as np

from kernels.jit import kernel, simd

#: Numbers of LANES cells that `advance` reads and writes: they come first in the layout.
STEPPING: Any = None

#: Of these, the numbers that `advance` writes and a block needs back after an event: they come first among STEPPING.
RETURNED: Any = None

#: Offset of the row that receives the number of steps of a leg, before `land`.
STEPS: Any = None

#: Numbers of LANES cells of a block.
SIZE: Any = None

#: One number for each call of `further_step` after one of `advance`, which is told it.
FURTHER_STEPS: Any = None


def prepared_settings(settings):
    """Settings of a run as scalars, with what follows from them for all cells.

    A tuple of floats, because a load from an array in a loop over lanes could keep it from becoming vector code.
    Called from kernels and from Python: `kernels.jit.kernel`.

    Parameters
    ----------
    settings : float64[:]

    Returns
    -------
    tuple of floats
        Preferably a NamedTuple.
    """


def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Put the start of a cell into a lane of a block (scalar).

    Returns
    -------
    bool
        Whether the cell goes on to `prepare`. If not, its results have been written and its lane has been filled as by
        `fill_idle`.
    """


def fill_idle(lane, lanes):
    """Fill an idle lane with numbers for which every operation is defined (scalar)."""


def prepare(lane, run, lanes):
    """Compute what a cell needs for all of its legs (vector)."""


def needs_integration(cell, lane, run, lanes, measures, counts):
    """Decide whether a prepared cell has to be stepped (scalar).

    Returns
    -------
    bool
        If False, the results of the cell have been written.
    """


def set_off(lane, run, lanes):
    """Place a cell at the beginning of its first leg (vector)."""


def advance(lane, run, lanes):
    """Make one step of one lane and store its state (vector).

    A lane with an event has to rest from then on: the machinery handles the event only after it has begun the next
    step, so one more call must not change the numbers before RETURNED.

    Returns
    -------
    bool
        Whether an event has ended the leg.
    """


@simd
def further_step(lane, number, run, lanes):
    """Make another step of a lane after `advance`, without looking for events (vector); a model may have none.

    `number` is that of FURTHER_STEPS.

    It runs for a lane with an event too, which has to rest.
    """


@kernel
def go_on(lane, place, run, memory):
    """Let a stepping lane with an event go on at once, in its place (scalar); a model may have no such event.

    What else an event means is decided when all legs of a block have ended.

    Parameters
    ----------
    lane, place : int
        The numbers that step are `memory[row + lane]`, all others of the cell `memory[row + place]`.
    run : tuple of floats
    memory : float64[:]

    Returns
    -------
    bool
        Whether the lane goes on: its next step is to find no such event.
    """
    return False


def land(lane, run, lanes):
    """Compute where a leg ended, as far as that is the same arithmetic for all cells (vector).

    STEPS holds the number of steps that the leg took.
    """


def finish_leg(cell, lane, run, lanes, measures, counts):
    """Decide what the end of a leg means for its cell (scalar).

    Returns
    -------
    bool
        Whether the cell has been set off on another leg. If not, its results have been written.
    """


class LaneModel(NamedTuple):
    """The functions of one model, under the names of this module, and the module that holds its layout.

    Attributes
    ----------
    name : str
        Unlike that of any other model: the machine code of the copies of the machinery is named after it.
    layout : module
        Has STEPPING, RETURNED, STEPS and SIZE.
    further_steps : float64[:]
        FURTHER_STEPS.
    flags : dict of str to anything, or None
        Values that globals of the model's functions have in this variant of the model: what ``if FLAG:`` leaves out is
        not compiled, and a function takes the place of another one.
    """

    name: str
    layout: Any
    prepared_settings: Any
    read_start: Any
    fill_idle: Any
    prepare: Any
    needs_integration: Any
    set_off: Any
    advance: Any
    land: Any
    finish_leg: Any
    further_step: Any = further_step
    further_steps: Any = np.zeros(0)
    go_on: Any = go_on
    flags: Any = None
