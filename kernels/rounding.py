"""A probe of how a processor rounds: its results differ in their last bits where those of other kernels do.

With fused multiply-add, a*b + c is rounded once and not twice, and the C library computes its functions in other ways.
"""

import math

from kernels.native.entry import entry


@entry(values="float64[:, ::1]", results="float64[:, ::1], written")
def probe(values, results):
    """Compute a product and a sum, and the elementary functions of the C library that kernels call.

    Parameters
    ----------
    values : array, shape (3, n)
        a, b and c, all positive.
    results : array, shape (12, n)
        Receives a*b - c in its first row.
    """
    for i in range(values.shape[1]):
        a, b, c = values[0, i], values[1, i], values[2, i]
        results[0, i] = a * b - c
        results[1, i] = math.sin(a)
        results[2, i] = math.cos(a)
        results[3, i] = math.atan2(a, b)
        results[4, i] = math.sinh(a)
        results[5, i] = math.cosh(a)
        results[6, i] = math.tanh(a)
        results[7, i] = math.asinh(a)
        results[8, i] = math.acosh(1.0 + a)
        results[9, i] = math.log(a)
        results[10, i] = math.log1p(a)
        results[11, i] = math.acos(a / (a + b))
