"""Entry points: kernels that Python calls by their address, with arguments of declared types.

Python code that calls them may run in several threads at once.
"""

import ctypes
import struct
from functools import cached_property, update_wrapper
from inspect import signature
from threading import Lock

import numpy as np

from kernels.native import machine_code, workers
from kernels.native.arguments import Argument
from kernels.native.function import PLAIN, lazy
from kernels.native.options import INTERNAL
from kernels.native.turns import coprime_stride, in_turns

_CODES = {"int64": "q", "float64": "d"}


class Entry:
    """A kernel that Python calls.

    Parameters
    ----------
    py_func : function
        What it does, in Python.
    types : mapping of str to str
        Argument -> its type, as Numba writes it, with ``, written`` behind that of an array which the caller gives to
        be written.

    Attributes
    ----------
    source : callable
        Called with the entry point when its machine code is first needed; returns `MachineCode`. That of
        `sweep.model.kernel_cache` keeps it on disk.
    """

    def __init__(self, py_func, types):
        self.py_func, self.types, self.source = py_func, types, Entry.compiled
        self._lock, self._found = Lock(), None
        update_wrapper(self, py_func)

    @cached_property
    def arguments(self):
        """The arguments of the compiled function, in its order."""
        return tuple(Argument.of(name, self.types[name]) for name in signature(self.py_func).parameters)

    def compiled(self):
        """Compile; returns `MachineCode`."""
        c_types = [each for argument in self.arguments for each in argument.c_types()]
        return machine_code.compiled(self._called(), self._numba_types(), c_types, INTERNAL)

    def copied(self, py_func):
        """Return an entry point that does what `py_func` does, with the same arguments."""
        return type(self)(py_func, self.types)

    def __call__(self, *values):
        """Call with arrays and numbers; returns what the kernel returns, numbers or nothing.

        Raises
        ------
        TypeError
            If an array has another type than declared, is not aligned, or is to be written and must not be.
        """
        if PLAIN:
            return self._called()(*values)
        passed = [
            each
            for argument, value in zip(self.arguments, values, strict=True)
            for each in argument.passed(value)
        ]
        function, results = self._loaded()
        result, failure = ctypes.create_string_buffer(8 * len(results) + 8), ctypes.create_string_buffer(8)
        if function(ctypes.addressof(result), ctypes.addressof(failure), *passed) != 0:
            raise RuntimeError(f"The kernel {self.__qualname__} raised an exception, which no kernel may.")
        found = struct.unpack_from("=" + "".join(map(_CODES.__getitem__, results)), result)
        return found if len(found) > 1 else (found[0] if found else None)

    def address(self):
        """Return the address of the C function, for compiled code (`kernels.native.by_address`)."""
        return ctypes.cast(self._loaded()[0], ctypes.c_void_p).value

    def make_ready(self):
        """Load the machine code now, and not at the first call."""
        if not PLAIN:
            self._loaded()

    def _loaded(self):
        """Return the C function, and the types of its results: loaded by the first thread that calls."""
        if self._found is None:
            with self._lock:
                if self._found is None:
                    self._found = self._load()
        return self._found

    def _load(self):
        kept = self.source(self)
        address = machine_code.load(kept)
        c_types = [each for argument in self.arguments for each in argument.c_types()]
        function = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *c_types)(address)
        return function, kept.results

    def _called(self):
        return self.py_func

    def _numba_types(self):
        return tuple(each.numba_type() for each in self.arguments)


class ParallelEntry(Entry):
    """A kernel that treats cells from `start` to `stop`; called for all cells, it runs in several threads.

    Parameters
    ----------
    py_func : function
        Its first two arguments are `start` and `stop`. The last dimension of the third are the cells; the last
        arguments are the memory of a thread.
    types : mapping of str to str
        Argument -> its type, without those of `start` and `stop`.
    chunk : int
        Cells that a thread takes at a time.
    memory : callable, optional
        Called with all arguments for each thread; returns a tuple of arrays, uninitialised.
    """

    def __init__(self, py_func, types, chunk, memory):
        super().__init__(py_func, types)
        self.chunk, self.memory = chunk, memory

    @cached_property
    def arguments(self):
        """The arguments of the compiled function: what the loop of `in_turns` needs comes first."""
        loop = (
            Argument("counter", "int64", 1),
            *(Argument(name, "int64", 0) for name in ("cells", "chunk", "stride")),
        )
        _, _, *names = signature(self.py_func).parameters
        return (*loop, *(Argument.of(name, self.types[name]) for name in names))

    def copied(self, py_func, memory=None):
        """Return an entry point that does what `py_func` does; its threads have other memory, if that is given."""
        return ParallelEntry(py_func, self.types, self.chunk, memory or self.memory)

    def __call__(self, *values):
        """Treat all cells."""
        cells = values[0].shape[-1]
        chunks = -(-cells // self.chunk)
        counter, stride = np.zeros(1, np.int64), coprime_stride(chunks)

        def work():
            Entry.__call__(self, counter, cells, self.chunk, stride, *values, *self.memory(*values))

        # plain Python takes turns in several steps: two threads could get the same chunk, or none get it
        workers.run(work, 1 if PLAIN else chunks)

    def _called(self):
        return in_turns(self.py_func if PLAIN else lazy(**INTERNAL)(self.py_func))

    def _numba_types(self):
        from numba import types

        (*loop,) = (each.numba_type() for each in self.arguments)
        return (*loop[:4], types.StarArgTuple(tuple(loop[4:])))


def entry(**types):
    """Return a decorator of a kernel that Python calls: argument -> its type, as Numba writes it."""
    return lambda function: Entry(function, types)


def parallel(chunk, memory=lambda *values: (), /, **types):
    """Return a decorator of a kernel that treats some of all cells: see `ParallelEntry`."""
    return lambda function: ParallelEntry(function, types, chunk, memory)
