"""Values and slopes of a polynomial with TERMS ascending coefficients, which stand `stride` apart from `first` on.

Even and odd powers go in two halves: shorter chains. Loops over the coefficients are written out by the compiler.
"""

from kernels.disk.exact.legendre import TERMS
from kernels.jit import simd


@simd
def value(coef, first, stride, x):
    """Value at x."""
    xx = x * x
    even, odd = coef[first + (TERMS - 2) * stride], coef[first + (TERMS - 1) * stride]
    for n in range(TERMS - 4, -1, -2):
        even = even * xx + coef[first + n * stride]
        odd = odd * xx + coef[first + (n + 1) * stride]
    return even + x * odd


@simd
def value_slope(coef, first, stride, x):
    """Value and derivative at x."""
    xx = x * x
    even, odd = coef[first + (TERMS - 2) * stride], coef[first + (TERMS - 1) * stride]
    even_slope, odd_slope = 0.0, 0.0
    for n in range(TERMS - 4, -1, -2):
        even_slope = even_slope * xx + even
        odd_slope = odd_slope * xx + odd
        even = even * xx + coef[first + n * stride]
        odd = odd * xx + coef[first + (n + 1) * stride]
    return even + x * odd, odd + 2.0 * (x * even_slope + xx * odd_slope)


@simd
def slopes(coef, first, stride, x):
    """First and second derivative at x."""
    xx = x * x
    even = (TERMS - 2) * coef[first + (TERMS - 2) * stride]
    odd = (TERMS - 1) * coef[first + (TERMS - 1) * stride]
    even_slope, odd_slope = 0.0, 0.0
    for n in range(TERMS - 4, 0, -2):
        even_slope = even_slope * xx + even
        odd_slope = odd_slope * xx + odd
        even = even * xx + n * coef[first + n * stride]
        odd = odd * xx + (n + 1) * coef[first + (n + 1) * stride]
    odd_slope = odd_slope * xx + odd
    odd = odd * xx + coef[first + stride]
    return odd + x * even, even + 2.0 * (xx * even_slope + x * odd_slope)
