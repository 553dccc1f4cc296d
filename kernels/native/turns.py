"""Chunks of cells, which threads take in turns: the next one goes to whoever is free."""

import math

from kernels.native.function import LazyFunction
from kernels.native.options import INTERNAL


def coprime_stride(n):
    """Stride g, coprime to n, such that (k g) mod n for k = 0 ... n-1 spreads evenly over 0 ... n-1.

    Neighbouring chunks take similar time and distant ones do not. In this order the last chunks, for which some threads
    wait, are a sample of all. A stride of about the golden section of n leaves no large gap.
    """
    step = max(1, int(0.6180339887498949 * n))
    while math.gcd(step, n) != 1:
        step += 1
    return step


def _atomic(function):
    import numba
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic
    def fetch_and_add(typing_context, counter):
        def generate(context, builder, signature, args):
            view = context.make_array(counter)(context, builder, args[0])
            return builder.atomic_rmw("add", view.data, context.get_constant(types.int64, 1), "monotonic")

        return types.int64(counter), generate

    return numba.njit(forceinline=True, **INTERNAL)(lambda counter: fetch_and_add(counter))


def _take(counter):
    taken = int(counter[0])
    counter[0] += 1
    return taken


#: Returns the number in int64[1] and adds one to it: no two threads get the same.
take = LazyFunction(_take, _atomic)


def in_turns(treat):
    """Return a function that treats chunks of cells until none is left, for each thread to call.

    Its arguments: the counter of `take`, how many cells there are, cells of a chunk, `coprime_stride` of the chunks,
    and those of `treat` after the first and last cell.
    """

    def work(counter, cells, chunk, stride, *arguments):
        chunks = (cells + chunk - 1) // chunk
        turn = take(counter)
        while turn < chunks:
            start = turn * stride % chunks * chunk
            treat(start, min(cells, start + chunk), *arguments)
            turn = take(counter)

    return work
