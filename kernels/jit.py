"""How kernels are compiled.

Numba compiles each function separately and links them. Functions called in a loop over lanes have to be inlined before
LLVM vectorises the loop: one remaining call keeps the loop scalar. Inlining in LLVM (`forceinline`) takes less time
than inlining in Numba (`inline="always"`).
"""

from kernels.native.function import lazy

#: Decorators of functions that kernels call, and Python; of the second kind are those called in loops over lanes.
kernel, simd = lazy(), lazy(forceinline=True)

#: Decorator of a short function that is called with constants: Numba would compile one specialisation per constant.
inlined = lazy(inline="always")
