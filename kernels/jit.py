"""How kernels are compiled.

Numba compiles every function apart and links them; wrappers that make it callable from Python too take a fifth of the
time. Functions that stand in a loop over lanes have to become part of it before the compiler makes vectors of it: one
call that is left keeps the loop scalar. Left to the linker (`forceinline`) this costs less time than in Numba.
"""

from numba import njit

# fastmath may only contract a*b + c into one instruction: any further licence would let a NaN pass unnoticed
_ALL = {"error_model": "numpy", "fastmath": {"contract"}}
_FOR_KERNELS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, **_ALL}

#: Decorator of a function that Python calls too, and of one that stands in a loop over lanes besides.
kernel, simd_kernel = njit(**_ALL), njit(forceinline=True, **_ALL)

#: Decorators of functions that only kernels call; called from Python such a one would end the process.
internal, simd = njit(**_FOR_KERNELS), njit(forceinline=True, **_FOR_KERNELS)

#: Decorator of a short function that is called with constants: each of them would be compiled apart.
inlined = njit(inline="always", **_FOR_KERNELS)

#: Decorator of a function whose loop over cells runs in parallel.
parallel = njit(parallel=True, nogil=True, **_ALL)
