"""Polynomials in the time of a step, of `ORDER`, in vector code: values, bounds, greatest values of simple ones.

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
def _slope_and_bend(x, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12):
    """Slope at x, and the rate at which it changes there."""
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
    """Greatest value from 0 to h, a bound of it, and whether the greatest value is proved.

    It is where the slope, or else its rate of change, is proved to keep its sign: then it is that of an end or of the
    only summit, which Newton's method finds. The bound is that of a parabola and of the terms that follow.

    Parameters
    ----------
    h, last : float
        The end, and the value there.
    """
    # of the rate at which the slope changes, what follows its first two terms
    rest = h * h * (12.0 * abs(c4) + h * (20.0 * abs(c5) + h * (30.0 * abs(c6) + h * (42.0 * abs(c7) + h * (
        56.0 * abs(c8) + h * (72.0 * abs(c9) + h * (90.0 * abs(c10) + h * (110.0 * abs(c11) + h * (
            132.0 * abs(c12)))))))))
    )  # fmt: skip
    first, second = 2.0 * c2, 2.0 * c2 + 6.0 * h * c3
    bends = (rest <= abs(first)) & (rest <= abs(second)) & (first * second > 0.0)
    # each further term changes the slope by at most h/2 of what it changes the rate by, and the value by h^2/6
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
    # one more step would change the value by less than its last bits
    settled = slope * slope <= 1e-15 * abs(bend) * (abs(c0) + abs(last))
    settled = settled | ((x <= 0.0) & (slope <= 0.0)) | ((x >= h) & (slope >= 0.0))
    best = last if last > c0 else c0
    return there if there > best else best, most, rises | (bends & (settled | (c2 > 0.0)))
