"""Polynomials of order `ORDER` in the time of a step, for vector code: values, bounds, and maxima of simple ones.

The coefficients are separate arguments, because an array or a loop would prevent the vectorisation over lanes.
"""

from kernels.jit import simd

#: Order of the Taylor series. Between 10 and 16 the time for an error of 1e-8 differs little; 12 compiles fastest.
ORDER = 12


@simd
def value(h, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12):
    """Return the value at h."""
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
    """Return an upper bound of the values from 0 to h; it is at least the value at 0.

    The polynomial without its negative terms of order 2 and higher is convex, so its maximum is at one of the ends.
    """
    return value(
        h, c0, c1, _above(c2), _above(c3), _above(c4), _above(c5), _above(c6), _above(c7), _above(c8), _above(c9),
        _above(c10), _above(c11), _above(c12),
    )  # fmt: skip


@simd
def _slope_and_bend(x, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12):
    """Return the slope at x, and its derivative there."""
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
    return c1 + x * slope, bend


@simd
def _kept(x, h):
    return 0.0 if x < 0.0 else (h if x > h else x)


@simd
def greatest(h, last, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12):
    """Return the greatest value from 0 to h, an upper bound of it, and whether the greatest value is proved.

    It is proved if the slope or its derivative is proved to keep its sign. Then the maximum is at an end or at the
    only stationary point, which Newton's method finds. The bound is the maximum of a parabola plus the remaining
    terms.

    Parameters
    ----------
    h, last : float
        The end, and the value at the end.
    """
    # bound of the second derivative without its first two terms
    rest = h * h * (12.0 * abs(c4) + h * (20.0 * abs(c5) + h * (30.0 * abs(c6) + h * (42.0 * abs(c7) + h * (
        56.0 * abs(c8) + h * (72.0 * abs(c9) + h * (90.0 * abs(c10) + h * (110.0 * abs(c11) + h * (
            132.0 * abs(c12)))))))))
    )  # fmt: skip
    first, second = 2.0 * c2, 2.0 * c2 + 6.0 * h * c3
    bends = (rest <= abs(first)) & (rest <= abs(second)) & (first * second > 0.0)
    # each further term changes the slope by at most h/2, and the value by h^2/6, times its part of the second
    # derivative
    off = 0.5 * h * (rest + 6.0 * h * abs(c3))
    there = c1 + h * first
    rises = (off <= abs(c1)) & (off <= abs(there)) & (c1 * there > 0.0)
    slope = h * (c1 + h * _above(c2))
    most = c0 + _above(slope) + h * off * (1.0 / 3.0)
    x = _kept(-c1 / first if c2 < 0.0 else 0.0, h)
    slope, bend = _slope_and_bend(x, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    x = _kept(x - slope / bend if bend < 0.0 else x, h)
    slope, bend = _slope_and_bend(x, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    x = _kept(x - slope / bend if bend < 0.0 else x, h)
    slope, bend = _slope_and_bend(x, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    there = value(x, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12)
    # another Newton step would change the value by less than its last bits
    settled = slope * slope <= 1e-15 * abs(bend) * (abs(c0) + abs(last))
    settled = settled | ((x <= 0.0) & (slope <= 0.0)) | ((x >= h) & (slope >= 0.0))
    best = last if last > c0 else c0
    return there if there > best else best, most, rises | (bends & (settled | (c2 > 0.0)))
