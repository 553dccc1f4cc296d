"""Polynomials in the time of a step, of `ORDER`: values, a bound that proves that there is no root, greatest values.

Their coefficients are arguments, because an array or a loop would keep the loop over lanes scalar.
"""

from kernels.jit import simd

#: Order of the Taylor series. From 10 to 16 the time for an error of 1e-8 differs little; 12 compiles fastest of those.
ORDER = 12


@simd
def value(h, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12):
    """Value at h."""
    return c0 + h * (
        c1 + h * (c2 + h * (c3 + h * (c4 + h * (c5 + h * (c6 + h * (c7 + h * (c8 + h * (
            c9 + h * (c10 + h * (c11 + h * c12)))))))))
        )
    )  # fmt: skip


@simd
def _above(c):
    return c if c > 0.0 else 0.0


@simd
def upper_bound(h, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12):
    """Bound that no value from 0 to h exceeds which is not below the value at 0.

    The polynomial without its negative terms of order 2 and higher is convex, so it is greatest at one of the ends.
    """
    return value(
        h, c0, c1, _above(c2), _above(c3), _above(c4), _above(c5), _above(c6), _above(c7), _above(c8), _above(c9),
        _above(c10), _above(c11), _above(c12),
    )  # fmt: skip


@simd
def _summit(x, low, high, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12):
    """One step of Newton's method for a root of the slope, kept between two places."""
    slope = bend = 12.0 * c12
    slope = 11.0 * c11 + x * slope
    bend = slope + x * bend
    slope = 10.0 * c10 + x * slope
    bend = slope + x * bend
    slope = 9.0 * c9 + x * slope
    bend = slope + x * bend
    slope = 8.0 * c8 + x * slope
    bend = slope + x * bend
    slope = 7.0 * c7 + x * slope
    bend = slope + x * bend
    slope = 6.0 * c6 + x * slope
    bend = slope + x * bend
    slope = 5.0 * c5 + x * slope
    bend = slope + x * bend
    slope = 4.0 * c4 + x * slope
    bend = slope + x * bend
    slope = 3.0 * c3 + x * slope
    bend = slope + x * bend
    slope = 2.0 * c2 + x * slope
    bend = slope + x * bend
    slope = c1 + x * slope
    moved = x - slope / bend if bend < 0.0 else x
    moved = low if moved < low else moved
    return high if moved > high else moved


@simd
def greatest(h, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12):
    """Greatest value from 0 to h: the best of five places, and of the summit beside it.

    A step is short enough that a function along it has few summits: what is left out is a second one that is higher
    than the first by less than they differ at these places.
    """
    quarter = 0.25 * h
    best, at = c0, 0.0 * h
    here = value(quarter, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    best, at = here if here > best else best, quarter if here > best else at
    here = value(2.0 * quarter, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    best, at = here if here > best else best, 2.0 * quarter if here > best else at
    here = value(3.0 * quarter, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    best, at = here if here > best else best, 3.0 * quarter if here > best else at
    here = value(h, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    best, at = here if here > best else best, h if here > best else at
    low, high = at - quarter, at + quarter
    low, high = 0.0 if low < 0.0 else low, h if high > h else high
    x = _summit(at, low, high, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    x = _summit(x, low, high, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    x = _summit(x, low, high, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    here = value(x, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    return here if here > best else best
