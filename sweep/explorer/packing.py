"""Arrays on their way to the page: a JSON head that names them, and their bytes."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

#: Type of an array -> what the head calls it; all little-endian.
_TYPES = {"f8": "<f8", "f4": "<f4", "u1": "u1", "i4": "<i4"}


def packed(head: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> list[bytes | memoryview]:
    """Return the parts of a binary answer.

    Parameters
    ----------
    head : mapping
        What JSON can hold; ``arrays`` is added to it.
    arrays : mapping of str to array
        float64, float32, int32 or uint8, any shape; sent in this order, in C order. The widest types come first, so
        that every array begins at a multiple of its own width.

    Returns
    -------
    list of bytes or memoryview
        Four bytes with the length of the head (little-endian), the head with spaces after it such that the arrays begin
        at a multiple of 8 bytes, and the arrays.
    """
    kinds = {name: f"{array.dtype.kind}{array.dtype.itemsize}" for name, array in arrays.items()}
    named = [{"name": name, "type": kind, "count": arrays[name].size} for name, kind in kinds.items()]
    text = json.dumps({**head, "arrays": named}, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-(4 + len(text)) % 8)
    parts: list[bytes | memoryview] = [len(text).to_bytes(4, "little"), text]
    return parts + [
        _bytes_of(np.ascontiguousarray(arrays[name], _TYPES[kind])) for name, kind in kinds.items()
    ]


def _bytes_of(array: npt.NDArray[Any]) -> memoryview:
    """Return the bytes of an array in C order, which are not copied."""
    return array.reshape(-1).view(np.uint8).data
