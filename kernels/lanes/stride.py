"""In which order chunks of cells are worked through, so that every thread gets a fair share."""

import math

from kernels.jit import internal


@internal
def coprime_stride(n):
    """Step g, coprime to n, such that (k g) mod n for k = 0 ... n-1 jumps evenly through 0 ... n-1.

    OpenMP gives each thread one stretch of k. Neighbouring chunks cost alike and distant ones do not (on two threads
    the rolling preset kept one of them waiting for 72 % of the time); in this order every stretch is a fair sample.
    The golden section leaves no large gap, whatever the number of threads.
    """
    step = max(1, int(0.6180339887498949 * n))
    while math.gcd(step, n) != 1:
        step += 1
    return step
