"""The order of the chunks of cells, chosen so that all threads get equal work."""

import math

from kernels.jit import internal


@internal
def coprime_stride(n):
    """Stride g, coprime to n, such that (k g) mod n for k = 0 ... n-1 spreads evenly over 0 ... n-1.

    Each thread gets one contiguous range of k. Neighbouring chunks take similar time and distant ones do not (on two
    threads one waited for 72 % of the time of the rolling preset); in this order every range is a representative
    sample. A stride of about the golden section of n leaves no large gap, whatever the number of threads.
    """
    step = max(1, int(0.6180339887498949 * n))
    while math.gcd(step, n) != 1:
        step += 1
    return step
