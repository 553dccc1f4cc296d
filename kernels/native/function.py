"""Functions that Numba compiles when they are first needed: a module of kernels is imported without Numba.

Importing Numba and what its first use loads takes longer than a small run (0.6 s, twice as long as NumPy and netCDF4
together). A process whose entry points are kept on disk (`kernels.native.entry`) needs none of it.
"""

import os
from functools import partial, update_wrapper
from threading import RLock

from kernels.native.options import WITHOUT_WRAPPERS

#: Whether kernels run as plain Python, for measuring coverage: the variable of the environment that Numba obeys too.
PLAIN = os.environ.get("NUMBA_DISABLE_JIT", "").strip() not in ("", "0")

#: Of all functions together: the thread that makes one may need another one, as another thread may the other way round.
_making = RLock()


class LazyFunction:
    """A function for kernels and for Python, compiled for the types that it is called with.

    Parameters
    ----------
    py_func : function
        What it does, in Python.
    make : callable
        Called with `py_func` when the compiled function is first needed; returns it.
    make_part : callable, optional
        The same for the function that kernels call, if it is another one than Python calls: what Python needs for
        its calls takes as long to compile as a dozen lines.
    """

    def __init__(self, py_func, make, make_part=None):
        self.py_func, self._make, self._made = py_func, make, None
        self._part = LazyFunction(py_func, make_part) if make_part else self
        update_wrapper(self, py_func)

    @property
    def compiled(self):
        """Numba's function of the same name, made once; the plain one where NUMBA_DISABLE_JIT is set."""
        if self._made is None:
            with _making:
                if self._made is None:
                    self._made = self.py_func if PLAIN else self._make(self.py_func)
        return self._made

    @property
    def _numba_type_(self):
        # Numba asks a value that it does not know for its type
        return self._part.compiled._numba_type_

    @property
    def targetoptions(self):
        """The options of the function that kernels call, where Numba looks for `inline`."""
        return self._part.compiled.targetoptions

    def __call__(self, *arguments):
        """Call the compiled function."""
        return self.compiled(*arguments)

    def copied(self, py_func):
        """Return a function that does what `py_func` does, compiled in the same way."""
        part = self._part
        return LazyFunction(py_func, self._make, None if part is self else part._make)


def lazy(**options):
    """Return a decorator of functions that Numba compiles with these options."""
    make, make_part = partial(_dispatcher, options), partial(_dispatcher, options | WITHOUT_WRAPPERS)
    called_by_python = not options.items() >= WITHOUT_WRAPPERS.items()
    return lambda function: LazyFunction(function, make, make_part if called_by_python else None)


def _dispatcher(options, function):
    from kernels.native.pipeline import KernelDispatcher

    return KernelDispatcher(function, options)
