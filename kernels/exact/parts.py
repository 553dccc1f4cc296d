"""How the functions inside the exact reduction are compiled: for other kernels alone, which takes a fifth less time."""

from numba import njit

from kernels.disk import CONTRACT

_FOR_KERNELS = {
    "error_model": "numpy",
    "fastmath": CONTRACT,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}

#: Decorator of a function that only kernels call.
part = njit(**_FOR_KERNELS)

#: The same, of one that must become part of the loop over lanes in which it stands.
lane_part = njit(forceinline=True, **_FOR_KERNELS)
