"""Which lanes a word of events names."""

from numba.core import types
from numba.extending import intrinsic, overload


def lowest_bit(word):
    """Return the place of the lowest bit that is set in a word (int64, not zero)."""
    return int(word & -word).bit_length() - 1


@intrinsic
def _trailing_zeros(typing_context, word):
    def generate(context, builder, signature, args):
        return builder.cttz(args[0], context.get_constant(types.boolean, False))

    return types.int64(types.int64), generate


@overload(lowest_bit)
def _lowest_bit(word):
    return lambda word: _trailing_zeros(word)
