"""The interface of a model: the numbers of its layout and the functions for the stages of a cell.

The functions of this module are placeholders without a body. `kernels.lanes.schedule` and `kernels.lanes.cuda` call
them by these names, and `kernels.lanes.binding` replaces them by the functions of one model. Their docstrings state
what a model has to provide. `kernels.disk.integrate` is a complete example.

The stages of a cell
    `read_start` puts the start of a cell into a lane, `prepare` computes derived quantities, `needs_integration`
    decides whether the cell has to be stepped at all, and `set_off` places it at the beginning of its first *leg*: a
    series of steps that ends with an event. `advance` makes one step. When it reports an event, `land` computes the
    end of the leg and `finish_leg` decides what follows: another leg, or the results of the cell.

Two kinds of functions
    *Vector* functions run over all lanes at once and have to be decorated with `kernels.jit.simd`, like all functions
    that they call. So that the loop over lanes becomes full-width vector code, they have no branch that cannot become
    a selection, and all loads come before all stores. A single call that is not inlined when the loop is first
    compiled keeps it scalar, seven times as slow. They run for idle lanes too, whose numbers have no meaning and are
    not written to results. *Scalar* functions run for one cell at a time (`kernels.jit.kernel` or `simd`). No
    function raises, creates an array or returns a part of one.

Arguments
    cell : int
        Column of the cell in `starts`, `measures` and `counts`.
    lane : int
        Its place among the LANES cells of `lanes`.
    starts : float64[parameters, n]
        The cells, one per column; the model defines the rows.
    run : tuple of floats
        The result of `prepared_settings`.
    lanes : float64[:]
        The numbers of LANES cells, laid out as in `kernels.lanes.layout`: the stepping lanes (STEPPING numbers) for
        `advance`, a block (SIZE numbers) for all other functions.
    measures : float64[measures, n], counts : int32[counts, n]
        The results; the column of each cell is written exactly once, when its ending is known.
"""

from typing import Any, NamedTuple

import numpy as np

from kernels.jit import kernel, simd

#: Numbers of LANES cells that `advance` reads and writes; they come first in the layout.
STEPPING: Any = None

#: Numbers among them that `advance` writes and a block needs back after an event; they come first in STEPPING.
RETURNED: Any = None

#: Offset of the row that receives the number of steps of a leg, before `land`.
STEPS: Any = None

#: Numbers of LANES cells of a block.
SIZE: Any = None

#: One number for each call of `further_step` after a call of `advance`; it is passed to `further_step`.
FURTHER_STEPS: Any = None


def prepared_settings(settings):
    """Return the settings of a run as scalars, with derived quantities that are the same for all cells.

    The result is a tuple of floats, because loading from an array in a loop over lanes could prevent vectorisation.
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
        Whether the cell continues with `prepare`. If not, its results have been written and its lane has been filled
        as by `fill_idle`.
    """


def fill_idle(lane, lanes):
    """Fill an idle lane with numbers for which every operation is defined (scalar)."""


def prepare(lane, run, lanes):
    """Compute the quantities that a cell needs for all of its legs (vector)."""


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

    A lane with an event has to rest from then on: the schedule handles the event only after it has begun the next
    step, so another call must not change the numbers before RETURNED.

    Returns
    -------
    bool
        Whether an event has ended the leg.
    """


@simd
def further_step(lane, number, run, lanes):
    """Make another step of a lane after `advance`, without looking for events (vector); optional.

    `number` is the entry of FURTHER_STEPS. It runs for a lane with an event too, which has to rest.
    """


@kernel
def go_on(lane, place, run, memory):
    """Continue a stepping lane after an event at once, in its place (scalar); optional.

    All other events are handled when all legs of a block have ended.

    Parameters
    ----------
    lane, place : int
        The stepping numbers are `memory[row + lane]`, all others of the cell `memory[row + place]`.
    run : tuple of floats
    memory : float64[:]

    Returns
    -------
    bool
        Whether the lane continues; its next step must not find the same event.
    """
    return False


def land(lane, run, lanes):
    """Compute the end of a leg, as far as the arithmetic is the same for all cells (vector).

    STEPS contains the number of steps of the leg.
    """


def finish_leg(cell, lane, run, lanes, measures, counts):
    """Decide what the end of a leg means for its cell (scalar).

    Returns
    -------
    bool
        Whether the cell begins another leg. If not, its results have been written.
    """


class LaneModel(NamedTuple):
    """The functions of one model, under the names of this module, and the module with its layout.

    Attributes
    ----------
    name : str
        Different for each model, because the machine code of the copied schedule is named after it.
    layout : module
        Has STEPPING, RETURNED, STEPS and SIZE.
    further_steps : float64[:]
        FURTHER_STEPS.
    flags : dict of str to anything, or None
        Values of globals of the model's functions in this variant of the model. Code that ``if FLAG:`` excludes is
        not compiled; a value may also be a function that replaces another one.
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
