"""The options that all kernels are compiled with."""

# fastmath may only contract a*b + c into one instruction: any further option would let a NaN pass unnoticed.
# Without Numba's run time (`_nrt`) a kernel cannot allocate memory, and does not count the references to arrays: that
# took 44 % of the time of small functions called a dozen times per cell, and two threads counting the references to the
# same array ran no faster than one (perf, two cores).
ALL = {"error_model": "numpy", "fastmath": {"contract"}, "_nrt": False}

#: Without what Python needs to call a function.
WITHOUT_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

#: Of functions that only kernels call.
INTERNAL = {**WITHOUT_WRAPPERS, **ALL}
