"""The types of the arguments of entry points, and how a value is passed to compiled code.

Numba passes an array as single numbers: two references (zero, as nothing counts them), the number of elements, their
size, the address of the first, the shape and the strides.
"""

import ctypes
import re
from typing import NamedTuple

_C_TYPES = {
    "float64": ctypes.c_double,
    "int64": ctypes.c_int64,
    "int32": ctypes.c_int32,
    "boolean": ctypes.c_bool,
}
_ADDRESS, _WHOLE = ctypes.c_void_p, ctypes.c_int64


class Argument(NamedTuple):
    """An argument of an entry point: a number, or an array whose elements lie one after the other (C order).

    Attributes
    ----------
    name, element : str
    dimensions : int
        0 for a number.
    written : bool
        Whether the kernel writes into it.
    """

    name: str
    element: str
    dimensions: int
    written: bool = False

    @classmethod
    def of(cls, name, text):
        """Return the argument whose type is written as Numba writes it: ``float64[:, ::1]``, and ``, written``."""
        pattern = r"(\w+)(\[(?::, )*::1\])?(, written)?"
        element, dimensions, written = re.fullmatch(pattern, text).groups(default="")
        return cls(name, element, dimensions.count(",") + bool(dimensions), bool(written))

    def numba_type(self):
        """Return the type of Numba."""
        from numba import types

        element = getattr(types, self.element)
        return types.Array(element, self.dimensions, "C") if self.dimensions else element

    def c_types(self):
        """Return the C types of the numbers that a value is passed as."""
        if not self.dimensions:
            return [_C_TYPES[self.element]]
        return [_ADDRESS, _ADDRESS, _WHOLE, _WHOLE, _ADDRESS, *2 * self.dimensions * [_WHOLE]]

    def passed(self, value):
        """Return the numbers that a value is passed as.

        Raises
        ------
        TypeError
            If it is an array of another type than declared: compiled code would read other memory. If it must not be
            written, and the kernel would: compiled code does not ask.
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
