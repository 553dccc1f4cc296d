"""All roots of a short power series on an interval.

A row of `rows` contains the coefficients of the powers of t; intervals begin at t = 0. A bound of the second
derivative proves that an interval has no root, or that the series is monotone and has at most one root. All other
intervals are bisected.
"""

import math

from kernels.jit import kernel

#: Smallest interval over the whole one, and number of intervals, at which the search gives up telling one root from
#: two.
_FEWEST_SHARE, _MOST_PIECES = 2.0**-40, 400

#: Safeguarded Newton steps; bisection would need 52.
_MOST_STEPS = 100

#: Maximum number of roots. A panel of a motion has at most two; if rounding makes more, the values differ by rounding.
MOST_ROOTS = 12

#: Returned by `roots` if the number of roots is unknown.
AMBIGUOUS = -1


@kernel
def value_and_slope(rows, row, t):
    """Return value and derivative of a series at t (Horner)."""
    value, slope = 0.0, 0.0
    for k in range(rows.shape[1] - 1, -1, -1):
        slope = slope * t + value
        value = value * t + rows[row, k]
    return value, slope


@kernel
def value_at(rows, row, t):
    """Return the value of a series at t."""
    return value_and_slope(rows, row, t)[0]


@kernel
def largest_value(rows, row, t):
    """Return a bound of the magnitude of a series from 0 to t."""
    bound = 0.0
    for k in range(rows.shape[1] - 1, -1, -1):
        bound = bound * t + abs(rows[row, k])
    return bound


@kernel
def _largest_second(rows, row, t):
    """Return a bound of the magnitude of the second derivative of a series from 0 to t."""
    bound = 0.0
    for k in range(rows.shape[1] - 1, 1, -1):
        bound = bound * t + k * (k - 1) * abs(rows[row, k])
    return bound


@kernel
def _root_between(rows, row, low, high, sign):
    """Return the root of a monotone series that has the given sign at `low` and the other sign, or zero, at `high`."""
    t = 0.5 * (low + high)
    for _ in range(_MOST_STEPS):
        value, slope = value_and_slope(rows, row, t)
        if value * sign > 0.0:
            low = t
        else:
            high = t
        new = t - value / slope
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - t) <= 2.0**-52 * abs(new):
            return new
        t = new
    return t


@kernel
def roots(rows, row, end, negligible, found):
    """Find the roots of a series in (0, end], from the first to the last.

    Parameters
    ----------
    rows : float64[:, TERMS]
    row : int
    end : float
        Greater than 0.
    negligible : float
        An interval over which the integral of the series is smaller is not bisected further; its middle counts as a
        root.
    found : float64[MOST_ROOTS], written

    Returns
    -------
    int
        The number of roots; `AMBIGUOUS` if two roots cannot be distinguished from none, or there are too many.
    """
    curved = _largest_second(rows, row, end)
    count, low, width = 0, 0.0, end
    for _ in range(_MOST_PIECES):
        half = 0.5 * width
        value, slope = value_and_slope(rows, row, low + half)
        rest = 0.5 * curved * half * half
        high = end if low + width >= end else low + width
        if not abs(value) > abs(slope) * half + rest:
            vague = width * (abs(value) + abs(slope) * half + rest) <= negligible
            if not vague and not abs(slope) > curved * half:
                if width < _FEWEST_SHARE * end:
                    return AMBIGUOUS
                width = half
                continue
            sign = -math.copysign(1.0, slope)
            crosses = value_at(rows, row, low) * sign > 0.0 and not value_at(rows, row, high) * sign > 0.0
            if vague or crosses:
                if count == MOST_ROOTS:
                    return AMBIGUOUS
                found[count] = low + half if vague else _root_between(rows, row, low, high, sign)
                count += 1
        low = high
        if low >= end:
            return count
        # back to larger intervals, each twice the previous one
        width = min(2.0 * width, end - low)
    return AMBIGUOUS
