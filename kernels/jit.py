"""How kernels are compiled.

Numba compiles each function separately and links them. Functions called in a loop over lanes have to be inlined before
LLVM vectorises the loop: one remaining call keeps the loop scalar. Inlining in LLVM (`forceinline`) takes less time
than inlining in Numba (`inline="always"`).
"""

from kernels.native.function import lazy
from kernels.native.options import ALL, INTERNAL

#: Decorators of functions that Python calls too; of the second kind are those called in loops over lanes.
kernel, simd_kernel = lazy(**ALL), lazy(forceinline=True, **ALL)

#: The same for functions that only kernels call; a call from Python would end the process.
internal, simd = lazy(**INTERNAL), lazy(forceinline=True, **INTERNAL)

#: Decorator of a short function that is called with constants: Numba would compile one specialisation per constant.
inlined = lazy(inline="always", **INTERNAL)
