"""Functions that Numba compiles when they are first needed: a module of kernels is imported without Numba.

Importing Numba and what its first use loads takes longer than a small run (0.6 s, twice as long as NumPy and netCDF4
together). A process whose entry points are kept on disk (`kernels.native.entry`) needs none of it.
"""

import os
from functools import cached_property, update_wrapper
from threading import RLock

#: Whether kernels run as plain Python, for measuring coverage: the variable of the environment that Numba obeys too.
PLAIN = os.environ.get("NUMBA_DISABLE_JIT", "").strip() not in ("", "0")

#: The options of Numba that all functions are compiled with.
# fastmath may only contract a*b + c into one instruction: any further option would let a NaN pass unnoticed.
# Without Numba's run time (`_nrt`) a kernel cannot allocate memory, and does not count the references to arrays: that
# took 44 % of the time of small functions called a dozen times per cell, and two threads counting the references to the
# same array ran no faster than one (perf, two cores).
OPTIONS = {"error_model": "numpy", "fastmath": {"contract"}, "_nrt": False}

#: Those of functions that kernels call: what Python needs for a call takes as long to compile as a dozen lines.
INTERNAL = {**OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}

#: Of all functions together: the thread that makes one may need another one, as another thread may the other way round.
_making = RLock()


class LazyFunction:
    """A function for kernels and for Python, compiled for the types that it is called with.

    Parameters
    ----------
    py_func : function
        What it does, in Python.
    make : callable
        Called with `py_func` and options when the compiled function is first needed; returns Numba's function.
    """

    def __init__(self, py_func, make):
        self.py_func, self._make = py_func, make
        update_wrapper(self, py_func)

    @property
    def compiled(self):
        """The function that kernels call; the plain one where NUMBA_DISABLE_JIT is set."""
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
        # Numba asks a value that it does not know for its type
        return self.compiled._numba_type_

    @property
    def targetoptions(self):
        """The options of the function that kernels call, where Numba looks for `inline`."""
        return self.compiled.targetoptions

    def __call__(self, *arguments):
        """Call from Python."""
        with _making:
            function = self._for_python
        return function(*arguments)

    def copied(self, py_func):
        """Return a function that does what `py_func` does, compiled in the same way."""
        return LazyFunction(py_func, self._make)


def lazy(**more):
    """Return a decorator of functions that Numba compiles with these options and `OPTIONS`."""

    def make(function, options):
        from kernels.native.compiler import compiled_function

        return compiled_function(function, {**options, **more})

    return lambda function: LazyFunction(function, make)
