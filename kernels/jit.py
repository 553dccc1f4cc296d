"""How kernels are compiled.

Numba compiles each function separately and links them; the wrapper that makes a function callable from Python takes a
fifth of the time. Functions called in a loop over lanes have to be inlined before LLVM vectorises the loop: one
remaining call keeps the loop scalar. Inlining in LLVM (`forceinline`) takes less time than inlining in Numba
(`inline="always"`).
"""

from numba import njit

from kernels.vector_width import PreferredWidth

# fastmath may only contract a*b + c into one instruction: any further option would let a NaN pass unnoticed
_ALL = {"error_model": "numpy", "fastmath": {"contract"}, "pipeline_class": PreferredWidth}
_FOR_KERNELS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, **_ALL}

#: Decorators of functions that Python calls too; of the second kind are those called in loops over lanes.
kernel, simd_kernel = njit(**_ALL), njit(forceinline=True, **_ALL)

#: The same for functions that only kernels call; a call from Python would end the process.
internal, simd = njit(**_FOR_KERNELS), njit(forceinline=True, **_FOR_KERNELS)

#: Decorator of a short function that is called with constants: Numba would compile one specialisation per constant.
inlined = njit(inline="always", **_FOR_KERNELS)

#: Decorator of a function whose loop over cells runs in parallel.
parallel = njit(parallel=True, nogil=True, **_ALL)
