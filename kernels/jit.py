"""Decorators that compile kernels.

Numba compiles each function separately and links them. Functions called in a loop over lanes have to be inlined before
LLVM vectorises the loop: one remaining call keeps the loop scalar. Inlining in LLVM (`forceinline`) takes less time
than inlining in Numba (`inline="always"`).
"""

from kernels.native.function import lazy

#: Decorators for functions called from kernels and from Python; `simd` is for functions called in loops over lanes.
kernel, simd = lazy(), lazy(forceinline=True)

#: Decorator for short functions called with constants: Numba would compile one specialisation per constant.
inlined = lazy(inline="always")
