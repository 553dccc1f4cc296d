"""Roots of polynomials in brackets, side by side, one per lane (`kernels.disk.exact.layout`)."""

import math

from kernels.disk.exact import layout as at
from kernels.disk.exact.layout import LANES
from kernels.disk.exact.polynomial import value_slope
from kernels.jit import kernel

ROUNDING = 2.0**-53
#: Bound on the steps; Newton's method inside a bracket converges long before.
MOST_STEPS = 100


@kernel
def _newton_step(block, scale):
    """One Newton step in every active lane; whether any lane is still active."""
    left = 0
    for lane in range(LANES):
        x, inner, outer = block[at.ROOT + lane], block[at.INNER + lane], block[at.OUTER + lane]
        last, last_slope = block[at.LAST + lane], block[at.SLOPE + lane]
        active = block[at.ACTIVE + lane]
        here, slope = value_slope(block, at.WORK + lane, LANES, x)
        outer = x if here > 0.0 else outer
        inner = inner if here > 0.0 else x
        inverse = 1.0 / slope
        step = here * inverse
        new = x - step
        inside = (new - inner) * (new - outer) <= 0.0
        new = new if inside else 0.5 * (inner + outer)
        step = step if inside else x - new
        # The error after the step is step^2 V''/(2 V'), with V'' from the last two slopes: it saves one evaluation.
        bend = step * (slope - last_slope) / last
        bend = bend if inside & (last != 0.0) else math.nan
        size = abs(step)
        rest = abs(bend) * size * abs(inverse)
        close = (rest if rest < size else size) <= ROUNDING * (2.0 * abs(x) + scale)
        slope = slope + bend if close & (bend == bend) else slope
        on = active > 0.0
        block[at.ROOT + lane] = new if on else x
        block[at.SLOPE + lane] = slope if on else last_slope
        # not read any more in a lane that is done
        block[at.LAST + lane] = step
        block[at.INNER + lane] = inner
        block[at.OUTER + lane] = outer
        block[at.ACTIVE + lane] = 0.0 if close else active
        left |= int(on) & int(not close)
    return left != 0


@kernel
def find_roots(block, scale):
    """Find the roots of the polynomials in WORK, each negative at its INNER and positive at its OUTER end.

    Newton in a bracket from the guesses in ROOT, in the lanes that are ACTIVE; leaves the roots in ROOT and the slopes
    there in SLOPE, exact to the rounding of numbers of size `scale`. Near a nearly double root each Newton step only
    halves the distance, until it is smaller than that of the two roots; the bracket keeps it on the right side.
    """
    for lane in range(LANES):
        block[at.LAST + lane] = 0.0
        block[at.SLOPE + lane] = math.nan
    for _ in range(MOST_STEPS):
        if not _newton_step(block, scale):
            return
