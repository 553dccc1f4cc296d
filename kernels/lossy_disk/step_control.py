"""How the steps of a cell follow the error of its energy: what is left of the tolerance is spent evenly on the way.

How short the steps of a long motion have to be is seen after some nutations: a cell that takes too long ones need not
come to its end before it begins again. Steps change on the way only where the losses are on course to end the motion
before its time is over: they end its errors too. Others may find a fall late in a steady motion, which multiplies an
error ten-thousandfold; their steps stay as they began. All follows from the cell alone.
"""

import math
from typing import NamedTuple

from kernels.disk.equations import energy_change
from kernels.jit import kernel
from kernels.lossy_disk import layout as at
from kernels.lossy_disk.rk4 import rates
from kernels.lossy_disk.simd_stages import (
    ENDS_OF_BOOLE,
    inertia_of,
    ledger_of,
    losses_of,
    sense_of,
    state_of,
)

#: Steps after which a motion is abandoned.
_MOST_STEPS = 1.0e8

#: Part of the tolerance that a motion may have spent at its end; the least that it may spend from any look on.
_SPENT, _LEAST_LEFT = 0.8, 0.1

#: What a motion may have spent on this first part of its way: else it begins again, with shorter steps, as often at
#: most. Near the rounding of the energy shorter steps do not help.
_SPENT_AT_FIRST, _FIRST_PART, _MOST_HASTY = 0.2, 0.05, 2.0

#: Part of its way so far that a motion goes until it is looked at again. Not a number of steps: steps that were made
#: ever shorter because of some noise would gain no way.
_UNTIL_NEXT = 0.5

#: By how much one look may shorten and lengthen the steps; what is kept back, as the error is one of the past.
_MOST_SHORTER, _MOST_LONGER, _CAUTION = 0.25, 2.0, 0.95

#: The shortest steps on the way, of those that a cell may have at most.
_SHORTEST = 1.0 / 8.0

_MOST_REFINEMENTS = 6
_SMALLEST_SHRINK = 1.0 / 8.0

#: Added to what divides.
_LEAST = 1.0e-300


class Look(NamedTuple):
    """What is seen of a motion on its way.

    Attributes
    ----------
    error : float
        Its imbalance (`imbalance_of`).
    spent : float
        The part of it that stays to the end.
    progress : float
        Part of its energy that it has lost.
    scale : float
        Half the relative step from here on.
    steps, until_next : float
        Steps of the cell, and those until it is to be looked at again.
    goes_on : bool
        Whether the cell goes on; else it is to begin again or to be abandoned.
    """

    error: float
    spent: float
    progress: float
    scale: float
    steps: float
    until_next: float
    goes_on: bool


@kernel
def added(ledger, gain, h):
    """`ledger` + h * `gain`."""
    a0, a1, a2, a3, a4, a5, a6 = ledger
    b0, b1, b2, b3, b4, b5, b6 = gain
    return (
        a0 + h * b0, a1 + h * b1, a2 + h * b2, a3 + h * b3, a4 + h * b4, a5 + h * b5, a6 + h * b6,
    )  # fmt: skip


@kernel
def present(lane, lanes):
    """Return state (S, C, K, w, o, p) and ledger of a lane, with what Boole's rule still lacks."""
    S, C, _, w, o, p = state_of(lane, lanes)
    state = S, C, 1.0 / C, w, o, p
    _, gain, _ = rates(state, sense_of(lane, lanes), inertia_of(lane, lanes), losses_of(lane, lanes))
    return state, added(ledger_of(lane, lanes), gain, ENDS_OF_BOOLE * lanes[at.LAST + lane])


@kernel
def lost_energy(ledger):
    """Energy (of m g R) that friction and air have taken."""
    _, _, rolled, pivoted, rubbed, damped, blown = ledger
    return rolled + pivoted + rubbed + damped + blown


@kernel
def _excess(state, ledger, place, memory):
    """Energy (of m g R) that a state has won without reason, and the drift of S^2 + C^2 = 1."""
    S, C, _, w, o, p = state
    S0, C0, w0 = memory[at.S_0 + place], memory[at.C_0 + place], memory[at.W_0 + place]
    o0, p0 = memory[at.O_RATE_0 + place], memory[at.P_0 + place]
    i_inverse, alpha = memory[at.I_INVERSE + place], memory[at.ALPHA + place]
    change = energy_change(S, C, w, o, i_inverse * p, S0, C0, w0, o0, i_inverse * p0, alpha)
    return change + lost_energy(ledger), (S - 1.0) * (S + 1.0) + C * C


@kernel
def imbalance_of(state, ledger, place, memory):
    """Size of the energy (of m g R) that a state has won without reason, and of the drift of S^2 + C^2 = 1."""
    excess, drift = _excess(state, ledger, place, memory)
    return abs(excess) + abs(drift)


@kernel
def looked_at(lane, place, run, memory):
    """Look at the cell of a lane whose steps until then are made; `place` is that of its numbers in its block.

    Notes
    -----
    A motion keeps the drift of S^2 + C^2, and the energy with C as its height. By that of S, which `energy_change` has,
    it varies by the drift over C + C_0 along each nutation: that says nothing about the steps.
    """
    state, ledger = present(lane, memory)
    excess, drift = _excess(state, ledger, place, memory)
    error, C, C0 = abs(excess) + abs(drift), state[1], memory[at.C_0 + place]
    spent = abs(excess + drift / (C + C0)) + abs(drift) * (1.0 + 1.0 / C0)
    progress = lost_energy(ledger) / memory[at.ENERGY_0 + place]
    gained, before = progress - memory[at.PROGRESS + place], memory[at.SCALE + lane]
    steps = memory[at.CHECK + place] - memory[at.STEPS_LEFT + lane]
    scale, until_next, goes_on = before, _UNTIL_NEXT * steps, steps < _MOST_STEPS
    if gained > 0.0 and progress > memory[at.TIME + lane] / memory[at.END + lane]:
        rate = max(spent - memory[at.SPENT + place], 0.0) / gained
        allowed = max(_SPENT * run.tolerance - spent, _LEAST_LEFT * run.tolerance)
        coarsest = memory[at.COARSEST + place]
        wanted = before * _factor(allowed, rate * max(1.0 - progress, 0.0))
        scale = min(max(wanted, _SHORTEST * coarsest), coarsest)
        pace = (steps - memory[at.LOOKED + place]) / gained
        until_next = _UNTIL_NEXT * progress * pace * (before / scale)
        goes_on &= error <= run.tolerance
        if _hasty(spent, progress, run) and scale < memory[at.FIRST_SCALE + place]:
            goes_on &= memory[at.REFINED + place] >= _MOST_HASTY
    return Look(error, spent, progress, scale, steps, until_next, goes_on)


@kernel
def _factor(allowed, expected):
    """By how much steps are to be longer which let one expect such a part of the tolerance: of fourth order."""
    factor = _CAUTION * math.sqrt(math.sqrt(allowed / (expected + _LEAST)))
    return min(max(factor, _MOST_SHORTER), _MOST_LONGER)


@kernel
def _hasty(spent, progress, run):
    """Whether too much was spent on the first part of the way: to begin again costs little there."""
    return progress < _FIRST_PART and spent > _SPENT_AT_FIRST * run.tolerance


@kernel
def go_on(lane, place, run, memory):
    """Let a lane that is only to be looked at go on, if the steps so far were short enough."""
    if memory[at.STEPS_LEFT + lane] > 0.0:
        return False
    look = looked_at(lane, place, run, memory)
    if look.goes_on:
        memory[at.SCALE + lane], memory[at.SCALE + place] = look.scale, look.scale
        memory[at.SPENT + place], memory[at.PROGRESS + place] = look.spent, look.progress
        following = min(look.steps + look.until_next, _MOST_STEPS)
        memory[at.LOOKED + place], memory[at.CHECK + place] = look.steps, following
        memory[at.STEPS_LEFT + lane] = following - look.steps
    return look.goes_on


@kernel
def slowed_down(lane, run, lanes):
    """Let the steps of a cell be shorter from its start on, where `go_on` did not let it go on; returns whether."""
    look = looked_at(lane, lane, run, lanes)
    if look.steps >= _MOST_STEPS:
        return False
    if look.error > run.tolerance:
        return refined(lane, look.error, run, lanes)
    return _counted(lane, lanes[at.COARSEST + lane], look.scale, lanes)


@kernel
def refined(lane, error, run, lanes):
    """Let no step of a cell be as long as before, nor its first ones, if there are shorter ones left to try."""
    shrink = 0.8 * math.sqrt(math.sqrt(run.tolerance / error))
    if not shrink >= _SMALLEST_SHRINK:
        shrink = _SMALLEST_SHRINK
    share = min(0.7, shrink)
    coarsest = share * lanes[at.COARSEST + lane]
    return _counted(lane, coarsest, min(coarsest, share * lanes[at.FIRST_SCALE + lane]), lanes)


@kernel
def _counted(lane, coarsest, first, lanes):
    """Set how long steps may be, and how long they are at first, unless a cell has begun too often."""
    if lanes[at.REFINED + lane] >= _MOST_REFINEMENTS:
        return False
    lanes[at.COARSEST + lane], lanes[at.FIRST_SCALE + lane] = coarsest, first
    lanes[at.REFINED + lane] += 1.0
    return True
