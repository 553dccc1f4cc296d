"""The step control of a cell by its energy error: the rest of the tolerance is spent evenly on the rest of the motion.

A few nutations show how short the steps of a long motion have to be, so a cell with too long steps restarts before
its end. The steps only change during a motion whose losses are on course to end it before its duration is over,
because then its errors end too. Other motions may fall late from a steady motion, which multiplies an error
ten-thousandfold; their steps keep their initial length. All decisions depend only on the cell.
"""

import math
from typing import NamedTuple

from kernels.disk.equations import energy_change
from kernels.jit import kernel
from kernels.lossy_disk import layout as at
from kernels.lossy_disk.endings import NOT_COMPUTED
from kernels.lossy_disk.error_estimate import Outcome
from kernels.lossy_disk.rk4 import rates
from kernels.lossy_disk.simd_stages import (
    ENDS_OF_BOOLE,
    SHORTER,
    inertia_of,
    ledger_of,
    losses_of,
    sense_of,
    state_of,
)

#: Steps after which a motion is abandoned.
_MOST_STEPS = 1.0e8

#: Share of the tolerance that a motion may have spent at its end; the least share left to it after any check.
_SPENT, _LEAST_LEFT = 0.8, 0.1

#: Share of the tolerance that a motion may spend on a first part of its way, and that part: beyond it, the motion
#: restarts with shorter steps. The largest number of such restarts: near the rounding of the energy, shorter steps do
#: not help.
_SPENT_AT_FIRST, _FIRST_PART, _MOST_HASTY = 0.2, 0.05, 2.0

#: Progress until the next check, as a share of the progress so far. It is not a number of steps: steps shortened
#: again and again because of noise would make no progress.
_UNTIL_NEXT = 0.5

#: Limits of the shortening and lengthening of steps at one check; safety factor, because the error is one of the past.
_MOST_SHORTER, _MOST_LONGER, _CAUTION = 0.25, 2.0, 0.95

#: Shortest steps during a motion, over the longest steps that the cell may have.
_SHORTEST = 1.0 / 8.0

_MOST_REFINEMENTS = 6

#: Least number of steps of the second and later passes.
_LEAST_STEPS = 16.0
_SMALLEST_SHRINK = 1.0 / 8.0

#: Added to a divisor.
_LEAST = 1.0e-300


class Look(NamedTuple):
    """Result of a check of a motion.

    Attributes
    ----------
    error : float
        Its imbalance (`imbalance_of`).
    spent : float
        The part of the error that stays until the end.
    progress : float
        Part of the energy that the motion has lost.
    scale : float
        Half the relative step from now on.
    steps, until_next : float
        Number of steps of the cell, and number of steps until the next check.
    goes_on : bool
        Whether the cell continues; otherwise it restarts or is abandoned.
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
    """Return `ledger` + h * `gain`."""
    a0, a1, a2, a3, a4, a5, a6 = ledger
    b0, b1, b2, b3, b4, b5, b6 = gain
    return (
        a0 + h * b0, a1 + h * b1, a2 + h * b2, a3 + h * b3, a4 + h * b4, a5 + h * b5, a6 + h * b6,
    )  # fmt: skip


@kernel
def present(lane, lanes):
    """Return state (S, C, K, w, o, p) and ledger of a lane, including the last term of Boole's rule."""
    S, C, _, w, o, p = state_of(lane, lanes)
    state = S, C, 1.0 / C, w, o, p
    _, gain, _ = rates(state, sense_of(lane, lanes), inertia_of(lane, lanes), losses_of(lane, lanes))
    return state, added(ledger_of(lane, lanes), gain, ENDS_OF_BOOLE * lanes[at.LAST + lane])


@kernel
def lost_energy(ledger):
    """Return the energy (of m g R) lost to friction and air."""
    _, _, rolled, pivoted, rubbed, damped, blown = ledger
    return rolled + pivoted + rubbed + damped + blown


@kernel
def _excess(state, ledger, place, memory):
    """Return the energy (of m g R) that a state has gained by errors, and the drift of S^2 + C^2 = 1."""
    S, C, _, w, o, p = state
    S0, C0, w0 = memory[at.S_0 + place], memory[at.C_0 + place], memory[at.W_0 + place]
    o0, p0 = memory[at.O_RATE_0 + place], memory[at.P_0 + place]
    i_inverse, alpha = memory[at.I_INVERSE + place], memory[at.ALPHA + place]
    change = energy_change(S, C, w, o, i_inverse * p, S0, C0, w0, o0, i_inverse * p0, alpha)
    return change + lost_energy(ledger), (S - 1.0) * (S + 1.0) + C * C


@kernel
def imbalance_of(state, ledger, place, memory):
    """Return the magnitude of the energy (of m g R) gained by errors, plus that of the drift of S^2 + C^2 = 1."""
    excess, drift = _excess(state, ledger, place, memory)
    return abs(excess) + abs(drift)


@kernel
def looked_at(lane, place, memory):
    """Check the cell of a lane that has made its steps; `place` is the place of its numbers in its block.

    Notes
    -----
    A motion conserves the drift of S^2 + C^2, and the energy with C as the height. The energy of `energy_change`,
    with S as the height, varies by the drift over C + C_0 along each nutation, which says nothing about the steps.
    """
    state, ledger = present(lane, memory)
    excess, drift = _excess(state, ledger, place, memory)
    error, C, C0 = abs(excess) + abs(drift), state[1], memory[at.C_0 + place]
    spent = abs(excess + drift / (C + C0)) + abs(drift) * (1.0 + 1.0 / C0)
    progress = lost_energy(ledger) / memory[at.ENERGY_0 + place]
    tolerance = memory[at.ALLOWED + place]
    gained, before = progress - memory[at.PROGRESS + place], memory[at.SCALE + lane]
    steps = memory[at.CHECK + place] - memory[at.STEPS_LEFT + lane]
    scale, until_next, goes_on = before, _UNTIL_NEXT * steps, steps < _MOST_STEPS
    if gained > 0.0 and progress > memory[at.TIME + lane] / memory[at.END + lane]:
        rate = max(spent - memory[at.SPENT + place], 0.0) / gained
        allowed = max(_SPENT * tolerance - spent, _LEAST_LEFT * tolerance)
        coarsest = memory[at.COARSEST + place]
        wanted = before * _factor(allowed, rate * max(1.0 - progress, 0.0))
        scale = min(max(wanted, _SHORTEST * coarsest), coarsest)
        pace = (steps - memory[at.LOOKED + place]) / gained
        until_next = _UNTIL_NEXT * progress * pace * (before / scale)
        goes_on &= error <= tolerance
        if _hasty(spent, progress, tolerance) and scale < memory[at.FIRST_SCALE + place]:
            goes_on &= memory[at.REFINED + place] >= _MOST_HASTY
    return Look(error, spent, progress, scale, steps, until_next, goes_on)


@kernel
def _factor(allowed, expected):
    """Return the factor of the step for which a motion spends its allowed, not its expected, error (fourth order)."""
    factor = _CAUTION * math.sqrt(math.sqrt(allowed / (expected + _LEAST)))
    return min(max(factor, _MOST_SHORTER), _MOST_LONGER)


@kernel
def _hasty(spent, progress, tolerance):
    """Return whether too much was spent on the first part of the way, where a restart costs little."""
    return progress < _FIRST_PART and spent > _SPENT_AT_FIRST * tolerance


@kernel
def go_on(lane, place, run, memory):
    """Continue a lane that only stopped for a check, if its steps so far were short enough; return whether it does."""
    if memory[at.STEPS_LEFT + lane] > 0.0:
        return False
    look = looked_at(lane, place, memory)
    if look.goes_on:
        memory[at.SCALE + lane], memory[at.SCALE + place] = look.scale, look.scale
        memory[at.SPENT + place], memory[at.PROGRESS + place] = look.spent, look.progress
        following = min(look.steps + look.until_next, _MOST_STEPS)
        memory[at.LOOKED + place], memory[at.CHECK + place] = look.steps, following
        memory[at.STEPS_LEFT + lane] = following - look.steps
    return look.goes_on


@kernel
def slowed_down(lane, lanes):
    """Set shorter steps for a cell that `go_on` did not continue; return whether that is possible."""
    look = looked_at(lane, lane, lanes)
    if look.steps >= _MOST_STEPS:
        return False
    if look.error > lanes[at.ALLOWED + lane]:
        return refined(lane, look.error, lanes)
    return _counted(lane, lanes[at.COARSEST + lane], look.scale, lanes)


@kernel
def refined(lane, error, lanes):
    """Shorten the longest and the first steps of a cell; return whether shorter ones are left to try."""
    shrink = 0.8 * math.sqrt(math.sqrt(lanes[at.ALLOWED + lane] / error))
    if not shrink >= _SMALLEST_SHRINK:
        shrink = _SMALLEST_SHRINK
    share = min(0.7, shrink)
    coarsest = share * lanes[at.COARSEST + lane]
    return _counted(lane, coarsest, min(coarsest, share * lanes[at.FIRST_SCALE + lane]), lanes)


@kernel
def _counted(lane, coarsest, first, lanes):
    """Set the longest and the first step of a cell, and count its restarts; return False after too many."""
    if lanes[at.REFINED + lane] >= _MOST_REFINEMENTS:
        return False
    lanes[at.COARSEST + lane], lanes[at.FIRST_SCALE + lane] = coarsest, first
    lanes[at.REFINED + lane] += 1.0
    return True


@kernel
def outcome_before(lane, lanes):
    """Return the `Outcome` of the pass before."""
    return Outcome(
        lanes[at.PASS_ENDING + lane], lanes[at.PASS_TIME + lane], lanes[at.PASS_TILT + lane],
        lanes[at.PASS_LEAST + lane], lanes[at.PASS_GREATEST + lane],
        lanes[at.PASS_TURNED + lane], lanes[at.PASS_PATH + lane],
    )  # fmt: skip


@kernel
def store_outcome(lane, outcome, lanes):
    """Store the outcome of a pass for `outcome_before`."""
    lanes[at.PASS_ENDING + lane], lanes[at.PASS_TIME + lane] = outcome.ending, outcome.time
    lanes[at.PASS_TILT + lane] = outcome.tilt
    lanes[at.PASS_LEAST + lane], lanes[at.PASS_GREATEST + lane] = outcome.least, outcome.greatest
    lanes[at.PASS_TURNED + lane], lanes[at.PASS_PATH + lane] = outcome.turned, outcome.path


@kernel
def next_pass(lane, outcome, lanes):
    """Store the outcome of a pass, and shorten all steps of the cell for another; return False after too many passes.

    Parameters
    ----------
    lane : int
    outcome : kernels.lossy_disk.error_estimate.Outcome
    lanes : float64[:]
    """
    is_second = lanes[at.PASS_ENDING + lane] == NOT_COMPUTED
    if not is_second and lanes[at.REFINED + lane] >= _MOST_REFINEMENTS:
        return False
    store_outcome(lane, outcome, lanes)
    lanes[at.COARSEST + lane] *= SHORTER
    lanes[at.FIRST_SCALE + lane] *= SHORTER
    # both passes of a motion that ends within a few steps would make the same steps
    brief = lanes[at.PASS_TIME + lane] / _LEAST_STEPS
    lanes[at.LONGEST + lane] = min(SHORTER * lanes[at.LONGEST + lane], brief if brief > 0.0 else math.inf)
    lanes[at.ALLOWED + lane] *= SHORTER * SHORTER * SHORTER * SHORTER
    lanes[at.REFINED + lane] += 0.0 if is_second else 1.0
    return True
