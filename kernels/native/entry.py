"""Entry points: kernels that Python calls by their address, with arguments of declared types.

Python code that calls them may run in several threads at once. Numba passes an array as separate numbers: two
references (zero, because nothing counts them), the number of elements, their size, the address of the first one, the
shape and the strides.
"""

import ctypes
import math
import re
import struct
from functools import cached_property, update_wrapper
from inspect import signature
from threading import Lock
from typing import NamedTuple

import numpy as np

from kernels.native import machine_code, workers
from kernels.native.function import PLAIN, LazyFunction, lazy

_CODES = {"int64": "q", "float64": "d"}

_C_TYPES = {
    "float64": ctypes.c_double,
    "int64": ctypes.c_int64,
    "int32": ctypes.c_int32,
    "boolean": ctypes.c_bool,
}
_ADDRESS, _WHOLE = ctypes.c_void_p, ctypes.c_int64


class Argument(NamedTuple):
    """An argument of an entry point: a number, or a contiguous array (C order).

    Attributes
    ----------
    name, element : str
    dimensions : int
        0 for a number.
    written : bool
        Whether the kernel writes to it.
    """

    name: str
    element: str
    dimensions: int
    written: bool = False

    @classmethod
    def of(cls, name, text):
        """Return the argument of a type in Numba's notation: ``float64[:, ::1]``, optionally with ``, written``."""
        pattern = r"(\w+)(\[(?::, )*::1\])?(, written)?"
        element, dimensions, written = re.fullmatch(pattern, text).groups(default="")
        return cls(name, element, dimensions.count(",") + bool(dimensions), bool(written))

    def numba_type(self):
        """Return Numba's type of the argument."""
        from numba import types

        element = getattr(types, self.element)
        return types.Array(element, self.dimensions, "C") if self.dimensions else element

    def c_types(self):
        """Return the C types of the numbers as which a value is passed."""
        if not self.dimensions:
            return [_C_TYPES[self.element]]
        return [_ADDRESS, _ADDRESS, _WHOLE, _WHOLE, _ADDRESS, *2 * self.dimensions * [_WHOLE]]

    def passed(self, value):
        """Return the numbers as which a value is passed.

        Raises
        ------
        TypeError
            If the type of an array differs from its declaration, because compiled code would read other memory. If
            the kernel writes to a read-only array, because compiled code does not check that.
        """
        if not self.dimensions:
            return [value]
        if value.dtype != self.element or value.ndim != self.dimensions or not value.flags.c_contiguous:
            raise TypeError(
                f"{self.name} must be an array of {self.element} with {self.dimensions} dimensions in C order; got "
                f"{value.dtype} of shape {value.shape}, strides {value.strides}."
            )
        if not value.flags.aligned or (self.written and not value.flags.writeable):
            problem = "can be written" if value.flags.aligned else "is aligned in memory"
            raise TypeError(
                f"{self.name} must be an array that {problem}; got another one. Pass a copy of it."
            )
        return [None, None, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides]


class Entry:
    """A kernel that Python calls.

    Parameters
    ----------
    py_func : function
        The kernel in Python.
    types : mapping of str to str
        Argument -> its type in Numba's notation, followed by ``, written`` for an array that the kernel writes to.

    Attributes
    ----------
    source : callable
        Called with the entry point when its machine code is first needed; returns `MachineCode`. The one in
        `kernels.native.cache` caches it on disk.
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
        """Compile the kernel; return `MachineCode`."""
        from kernels.native.compiler import machine_code

        return machine_code(lazy()(self._called()).compiled, self._numba_types())

    def copied(self, py_func):
        """Return an entry point that does the same as `py_func`, with the same arguments."""
        return type(self)(py_func, self.types)

    def __call__(self, *values):
        """Call the kernel with arrays and numbers; return its results, numbers or nothing.

        Raises
        ------
        TypeError
            If the type of an array differs from its declaration, or it is not aligned, or read-only but written to.
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

    def make_ready(self):
        """Load the machine code now instead of at the first call."""
        if not PLAIN:
            self._loaded()

    def _loaded(self):
        """Return the C function and the types of its results; the first thread that calls loads them."""
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


def coprime_stride(n):
    """Return a stride g, coprime to n, such that (k g) mod n for k = 0 ... n-1 spreads evenly over 0 ... n-1.

    Neighbouring chunks take similar times, distant ones do not. In this order the last chunks, for which some threads
    wait, are a sample of all chunks. A stride near the golden section of n leaves no large gap.
    """
    step = max(1, int(0.6180339887498949 * n))
    while math.gcd(step, n) != 1:
        step += 1
    return step


def _atomic(function, options):
    import numba
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic
    def fetch_and_add(typing_context, counter):
        def generate(context, builder, signature, args):
            view = context.make_array(counter)(context, builder, args[0])
            return builder.atomic_rmw("add", view.data, context.get_constant(types.int64, 1), "monotonic")

        return types.int64(counter), generate

    return numba.njit(forceinline=True, **options)(lambda counter: fetch_and_add(counter))


def _take(counter):
    taken = int(counter[0])
    counter[0] += 1
    return taken


#: Returns the number in int64[1] and adds one to it, atomically: no two threads get the same number.
take = LazyFunction(_take, _atomic)


def _in_turns(treat):
    """Return a function that processes chunks of cells until none is left, to be called by each thread.

    Its arguments: the counter of `take`, number of cells, cells of a chunk, `coprime_stride` of the chunks, and the
    arguments of `treat` after the first and last cell.
    """

    def work(counter, cells, chunk, stride, *arguments):
        chunks = (cells + chunk - 1) // chunk
        turn = take(counter)
        while turn < chunks:
            start = turn * stride % chunks * chunk
            treat(start, min(cells, start + chunk), *arguments)
            turn = take(counter)

    return work


class ParallelEntry(Entry):
    """A kernel that processes cells from `start` to `stop`; called for all cells, it runs in several threads.

    Parameters
    ----------
    py_func : function
        Its first two arguments are `start` and `stop`. The last dimension of the third one runs over the cells; the
        last arguments are the memory of a thread.
    types : mapping of str to str
        Argument -> its type, except `start` and `stop`.
    chunk : int
        Number of cells that a thread takes at a time.
    memory : callable, optional
        Called with all arguments for each thread; returns a tuple of uninitialised arrays.
    """

    def __init__(self, py_func, types, chunk, memory):
        super().__init__(py_func, types)
        self.chunk, self.memory = chunk, memory

    @cached_property
    def arguments(self):
        """The arguments of the compiled function, beginning with those of the loop in `_in_turns`."""
        loop = (
            Argument("counter", "int64", 1),
            *(Argument(name, "int64", 0) for name in ("cells", "chunk", "stride")),
        )
        _, _, *names = signature(self.py_func).parameters
        return (*loop, *(Argument.of(name, self.types[name]) for name in names))

    def copied(self, py_func, memory=None):
        """Return an entry point that does the same as `py_func`; `memory` replaces the memory of its threads."""
        return ParallelEntry(py_func, self.types, self.chunk, memory or self.memory)

    def __call__(self, *values):
        """Process all cells."""
        cells = values[0].shape[-1]
        chunks = -(-cells // self.chunk)
        counter, stride = np.zeros(1, np.int64), coprime_stride(chunks)

        def work():
            Entry.__call__(self, counter, cells, self.chunk, stride, *values, *self.memory(*values))

        # `take` is not atomic in plain Python: two threads could get the same chunk, or a chunk could be skipped
        workers.run(work, 1 if PLAIN else chunks)

    def _called(self):
        return _in_turns(self.py_func if PLAIN else lazy()(self.py_func))

    def _numba_types(self):
        from numba import types

        (*loop,) = (each.numba_type() for each in self.arguments)
        return (*loop[:4], types.StarArgTuple(tuple(loop[4:])))


def entry(**types):
    """Return a decorator for a kernel that Python calls; `types` are argument -> its type in Numba's notation."""
    return lambda function: Entry(function, types)


def parallel(chunk, memory=lambda *values: (), /, **types):
    """Return a decorator for a kernel that processes a part of all cells: see `ParallelEntry`."""
    return lambda function: ParallelEntry(function, types, chunk, memory)
