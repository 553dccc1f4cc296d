"""First root, turning points and greatest value of a polynomial in the time of a step, by Bernstein coefficients.

On an interval, the values of a polynomial lie between the least and the greatest Bernstein coefficient. The number of
its roots is at most the number of sign changes of the coefficients, and exactly one for one sign change (Descartes'
rule of signs): Farouki, "The Bernstein polynomial basis", Computer Aided Geometric Design 29 (2012) 379, sections 3
and 4. Intervals are bisected until these facts suffice.

A polynomial is a row of ``ORDER + 1`` coefficients in the memory of a lane; `work` is memory for as many numbers.
"""

import math

import numpy as np

from kernels.jit import kernel
from kernels.system.polynomials import ORDER

#: Relative rounding error of a value of a polynomial, over the sum of the magnitudes of its terms.
_ROUNDING = 8.0 * np.finfo(np.float64).eps

#: Smallest interval, over the step: changes of a function within it are far below `_ROUNDING`.
_LEAST_SHARE = 2.0**-30

#: 1/C(ORDER, k)
_SHARES = tuple(1.0 / math.comb(ORDER, k) for k in range(ORDER + 1))


@kernel
def value_at(row, h, memory):
    """Return the value of the polynomial at h."""
    value = memory[row + ORDER]
    for k in range(ORDER - 1, -1, -1):
        value = memory[row + k] + h * value
    return value


@kernel
def slope_at(row, h, memory):
    """Return the slope of the polynomial at h."""
    slope = ORDER * memory[row + ORDER]
    for k in range(ORDER - 1, 0, -1):
        slope = k * memory[row + k] + h * slope
    return slope


@kernel
def _write_bernstein(row, begin, width, work, memory):
    """Write the Bernstein coefficients from `begin` to `begin` + `width` into `work`; return the greatest of them."""
    for k in range(ORDER + 1):
        memory[work + k] = memory[row + k]
    # Taylor series about the beginning of the interval
    for done in range(ORDER):
        for k in range(ORDER - 1, done - 1, -1):
            memory[work + k] += begin * memory[work + k + 1]
    power = 1.0
    for k in range(ORDER + 1):
        memory[work + k] *= power * _SHARES[k]
        power *= width
    for done in range(ORDER):
        for k in range(ORDER, done, -1):
            memory[work + k] += memory[work + k - 1]
    top = -math.inf
    for k in range(ORDER + 1):
        top = max(top, memory[work + k])
    return top


@kernel
def rounding_to(row, h, memory):
    """Return the largest rounding error of a value from 0 to h."""
    total, power = 0.0, 1.0
    for k in range(ORDER + 1):
        total += abs(memory[row + k]) * power
        power *= h
    return _ROUNDING * total


@kernel
def _signs(first, count, memory):
    """Return the sign of the first nonzero coefficient (0 if all are zero), and the number of sign changes."""
    sign, last, changes = 0, 0, 0
    for k in range(first, first + count):
        here = int(memory[k] > 0.0) - int(memory[k] < 0.0)
        if here != 0:
            sign = here if sign == 0 else sign
            changes += int(last * here < 0)
            last = here
    return sign, changes


@kernel
def crossing(row, low, high, memory):
    """Return where the polynomial, which is positive at `high`, becomes positive, by bisection down to rounding."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = value_at(row, middle, memory) > 0.0
        low, high = low if above else middle, middle if above else high
    return high


@kernel
def first_above(row, h, work, memory):
    """Return the time in [0, h] from which on the polynomial is positive, or infinity, and whether that is proved.

    It is not proved if the polynomial touches zero to within rounding.
    """
    rounding, proved = rounding_to(row, h, memory), True
    begin, width = 0.0, h
    while begin < h:
        width = min(width, h - begin)
        top = _write_bernstein(row, begin, width, work, memory)
        sign, changes = _signs(work, ORDER + 1, memory)
        # after the first interval, the coefficient at its beginning may be positive because of rounding
        if sign > 0 and (begin == 0.0 or top > rounding):
            return begin, proved
        if changes == 1 and value_at(row, begin + width, memory) > 0.0:
            return crossing(row, begin, begin + width, memory), proved
        touches = top <= rounding or width <= _LEAST_SHARE * h
        if changes == 0 or touches:
            proved = proved and changes == 0
            begin, width = begin + width, 2.0 * width
        else:
            width = 0.5 * width
    # the end of the step
    return (h if value_at(row, h, memory) > 0.0 else math.inf), proved


@kernel
def write_slope(row, slope, memory):
    """Write the derivative of the polynomial into the row `slope`."""
    for k in range(ORDER):
        memory[slope + k] = (k + 1.0) * memory[row + k + 1]
    memory[slope + ORDER] = 0.0


@kernel
def next_turn(slope, begin, h, work, memory):
    """Return the first turning point after `begin`, or h; and whether the polynomial rises until then.

    Parameters
    ----------
    slope : int
        The row of its derivative, from `write_slope`.
    begin : float
        The beginning of the step, or the last turning point.
    """
    # a turning point is not found again
    place = begin + _LEAST_SHARE * h if begin > 0.0 else begin
    width, direction = h - place, 0
    while place < h:
        width = min(width, h - place)
        _write_bernstein(slope, place, width, work, memory)
        sign, changes = _signs(work, ORDER + 1, memory)
        narrow = width <= _LEAST_SHARE * h
        if changes > 1 and not narrow:
            width = 0.5 * width
            continue
        direction = sign if direction == 0 else direction
        if changes % 2 == 1:
            low, high = place, place + width
            for _ in range(60):
                middle = 0.5 * (low + high)
                same = value_at(slope, middle, memory) * sign > 0.0
                low, high = middle if same else low, high if same else middle
            return high, sign > 0
        place, width = place + width, 2.0 * width
    return h, direction > 0


@kernel
def _summit(row, low, high, memory):
    """Return the greatest value between two points where the polynomial first rises and then falls."""
    for _ in range(50):
        middle = 0.5 * (low + high)
        rising = slope_at(row, middle, memory) > 0.0
        low, high = middle if rising else low, high if rising else middle
    return value_at(row, 0.5 * (low + high), memory)


@kernel
def greatest_to(row, h, work, memory):
    """Return the greatest value of the polynomial from 0 to h."""
    rounding = rounding_to(row, h, memory)
    best = max(memory[row], value_at(row, h, memory))
    begin, width = 0.0, h
    while begin < h:
        width = min(width, h - begin)
        known = not _write_bernstein(row, begin, width, work, memory) > best + rounding
        end = memory[work + ORDER]
        if not known:
            for k in range(ORDER):
                memory[work + k] = memory[work + k + 1] - memory[work + k]
            sign, changes = _signs(work, ORDER, memory)
            known = changes <= 1 or width <= _LEAST_SHARE * h
            if changes == 1 and sign > 0:
                best = max(best, _summit(row, begin, begin + width, memory))
            elif known:
                best = max(best, end)
        if known:
            begin, width = begin + width, 2.0 * width
        else:
            width = 0.5 * width
    return best
