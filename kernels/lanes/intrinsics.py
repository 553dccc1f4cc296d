"""LLVM features that Numba does not offer: arrays without a reference count, and the trailing zero count of a word.

Numba counts the references to an array with atomic instructions at every call that passes one, unless it can prove the
pairs superfluous, which it cannot across loops and early returns. Small functions called a dozen times per cell spent
44 % of their time counting, and two threads counting the same array ran no faster than one (perf, two cores).
"""

from numba.core import types
from numba.extending import intrinsic, overload


def without_refcount(array):
    """Return the same array without a reference count: valid only as long as the caller keeps the array itself.

    Use it on arguments only. For an array that was made in the same function the call may be the last use, after which
    the compiler frees it.
    """
    return array


@intrinsic
def _drop_meminfo(typing_context, array):
    def generate(context, builder, signature, args):
        view = context.make_array(array)(context, builder, args[0])
        view.meminfo = view.meminfo.type(None)
        view.parent = view.parent.type(None)
        return view._getvalue()

    return array(array), generate


@overload(without_refcount)
def _without_refcount(array):
    return lambda array: _drop_meminfo(array)


def count_trailing_zeros(word):
    """Return the number of zero bits below the lowest set bit of a word (int64, not zero)."""
    return int(word & -word).bit_length() - 1


@intrinsic
def _trailing_zeros(typing_context, word):
    def generate(context, builder, signature, args):
        return builder.cttz(args[0], context.get_constant(types.boolean, False))

    return types.int64(types.int64), generate


@overload(count_trailing_zeros)
def _count_trailing_zeros(word):
    return lambda word: _trailing_zeros(word)
