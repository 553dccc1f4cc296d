"""Roots of a short power series on an interval, each found and none missed.

A row of `rows` holds the coefficients of the powers of t; intervals begin at t = 0. An interval without a root is told
by a bound of the second derivative, and so is one on which the series is monotone and has one root at most. What is
neither is halved.
"""

import math

from kernels.jit import kernel

#: Halvings of the interval, and pieces looked at, before a root that cannot be told from two is given up.
_FEWEST_SHARE, _MOST_PIECES = 2.0**-40, 400

#: Safeguarded Newton steps: bisection alone would need 52.
_MOST_STEPS = 100

#: Roots kept; a panel of a motion has two at most, and where rounding makes more the values differ by rounding.
MOST_ROOTS = 12

#: `roots` returns this where it cannot tell how many roots there are.
AMBIGUOUS = -1


@kernel
def value_and_slope(rows, row, t):
    """Value and derivative of a series at t (Horner)."""
    value, slope = 0.0, 0.0
    for k in range(rows.shape[1] - 1, -1, -1):
        slope = slope * t + value
        value = value * t + rows[row, k]
    return value, slope


@kernel
def value_at(rows, row, t):
    """Value of a series at t."""
    return value_and_slope(rows, row, t)[0]


@kernel
def largest_value(rows, row, t):
    """Bound of the magnitude of a series from 0 to t."""
    bound = 0.0
    for k in range(rows.shape[1] - 1, -1, -1):
        bound = bound * t + abs(rows[row, k])
    return bound


@kernel
def _largest_second(rows, row, t):
    """Bound of the magnitude of the second derivative of a series from 0 to t."""
    bound = 0.0
    for k in range(rows.shape[1] - 1, 1, -1):
        bound = bound * t + k * (k - 1) * abs(rows[row, k])
    return bound


@kernel
def _root_between(rows, row, low, high, sign):
    """The root of a monotone series that has the given sign at `low` and the other one, or zero, at `high`."""
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
        A piece over which the integral of the series is smaller is not divided further: its middle counts as a root.
    found : float64[MOST_ROOTS], written

    Returns
    -------
    int
        How many there are; `AMBIGUOUS` where two roots and none cannot be told apart, or there are too many.
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
        # back to the larger pieces, each twice the one before
        width = min(2.0 * width, end - low)
    return AMBIGUOUS


@kernel
def first_root(rows, row, divided, at_rest, end, found):
    """First root of a series from 0 to `end`; NaN if there is none, -1 if that cannot be told.

    Where the motion is `at_rest` at the begin that is a root: the next one is sought of the series divided by t, which
    takes the row `divided`, and 0 is returned if the series falls there. `found` keeps the roots.
    """
    sought = row
    if at_rest:
        sought = divided
        last = rows.shape[1] - 1
        for k in range(last):
            rows[sought, k] = rows[row, k + 1]
        rows[sought, last] = 0.0
        if not rows[sought, 0] > 0.0:
            return 0.0
    count = roots(rows, sought, end, 0.0, found)
    if count == AMBIGUOUS:
        return -1.0
    return found[0] if count > 0 else math.nan


@kernel
def first_length(rows, row, at_rest, end):
    """Length of the first panel: a power of two above twice the way to the first root, where that is near.

    Where it is not, the length is `end`, that of all other panels. A root far below the length of a panel would be hard
    to tell from two.
    """
    first = 1 if at_rest else 0
    value, slope, bend = rows[row, first], rows[row, first + 1], rows[row, first + 2]
    whole = slope * slope - 4.0 * bend * value
    way = end
    if slope < 0.0 and value > 0.0 and whole >= 0.0:
        way = 2.0 * value / (math.sqrt(whole) - slope)
    elif bend < 0.0 and value > 0.0:
        way = 0.5 * (slope + math.sqrt(whole)) / -bend
    if not 0.0 < 2.0 * way < end:
        return end
    return 2.0 ** math.ceil(math.log2(2.0 * way))
