"""Functions that Numba compiles on first use, so that modules of kernels can be imported without Numba.

Importing Numba, with everything that its first use loads, takes longer than a small run (0.6 s, twice as long as
NumPy and netCDF4 together). A process whose entry points are cached on disk (`kernels.native.entry`) does not import
it.
"""

import os
from functools import cached_property, update_wrapper
from threading import RLock

#: Whether kernels run as plain Python, to measure coverage; uses Numba's own environment variable.
PLAIN = os.environ.get("NUMBA_DISABLE_JIT", "").strip() not in ("", "0")

#: Numba's options for all functions.
# fastmath may only contract a*b + c into one instruction: any further option would let a NaN pass unnoticed.
# Without Numba's run time (`_nrt`), a kernel cannot allocate memory and does not count references to arrays. That
# took 44 % of the time of small functions called a dozen times per cell, and two threads that counted references to
# the same array ran no faster than one (perf, two cores).
OPTIONS = {"error_model": "numpy", "fastmath": {"contract"}, "_nrt": False}

#: Options for functions called only by kernels: a wrapper for Python takes as long to compile as a dozen lines.
INTERNAL = {**OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}

#: A single lock for all functions: with separate locks, two threads that need each other's functions could deadlock.
_making = RLock()


class LazyFunction:
    """A function for kernels and for Python, compiled for the types of its arguments.

    Parameters
    ----------
    py_func : function
        The function in Python.
    make : callable
        Called with `py_func` and options when the compiled function is first needed; returns Numba's function.
    """

    def __init__(self, py_func, make):
        self.py_func, self._make = py_func, make
        update_wrapper(self, py_func)

    @property
    def compiled(self):
        """The function that kernels call; the plain one if NUMBA_DISABLE_JIT is set."""
        with _making:
            return self._compiled

    @cached_property
    def _compiled(self):
        return self.py_func if PLAIN else self._make(self.py_func, INTERNAL)

    @cached_property
    def _for_python(self):
        return self.py_func if PLAIN else self._make(self.py_func, OPTIONS)

    @property
    def _numba_type_(self):
        # Numba asks values that it does not know for their type
        return self.compiled._numba_type_

    @property
    def targetoptions(self):
        """Options of the function that kernels call; Numba reads `inline` from them."""
        return self.compiled.targetoptions

    def __call__(self, *arguments):
        """Call the function from Python."""
        with _making:
            function = self._for_python
        return function(*arguments)

    def copied(self, py_func):
        """Return a function that does the same as `py_func`, compiled in the same way."""
        return LazyFunction(py_func, self._make)


def lazy(**more):
    """Return a decorator for functions that Numba compiles with these options and `OPTIONS`."""

    def make(function, options):
        from kernels.native.compiler import compiled_function

        return compiled_function(function, {**options, **more})

    return lambda function: LazyFunction(function, make)
