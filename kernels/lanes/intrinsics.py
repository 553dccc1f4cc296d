"""The trailing zero count of a word, an LLVM intrinsic that Numba does not offer."""

from kernels.native.function import LazyFunction


def _instruction(function, options):
    import numba
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic
    def trailing_zeros(typing_context, word):
        def generate(context, builder, signature, args):
            return builder.cttz(args[0], context.get_constant(types.boolean, False))

        return types.int64(types.int64), generate

    return numba.njit(forceinline=True, **options)(lambda word: trailing_zeros(word))


def _count(word):
    return int(word & -word).bit_length() - 1


#: Number of zero bits below the lowest set bit of a word (int64, not zero).
count_trailing_zeros = LazyFunction(_count, _instruction)
