"""What of a block's columns has to be stored: not what follows from the others, and what repeats only once.

A journal lives until the file is there, and costs time for every byte: 63 bytes of a cell become 17 to 46.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.engine.blocks import Span
from sweep.engine.runner import Columns, completed
from sweep.request.spec import SweepSpec
from sweep.schema.exact import DERIVED

Stored = Mapping[str, npt.NDArray[Any]]


def packed(spec: SweepSpec, columns: Columns) -> Stored:
    """Return what has to be stored of the columns of a block.

    Parameters
    ----------
    spec : SweepSpec
    columns : mapping of str to array, shape (n,)
        As from `runner.compute`.

    Returns
    -------
    mapping of str to array, shape (m,), 1 <= m <= n
        Columns that follow from others are left out. A column that repeats itself bit by bit from its m-th value on is
        cut there; integers have the smallest type that holds them.
    """
    # a column is often the same in all cells; or in all rows, as the extreme tilt is that a motion at rest starts from
    periods = sorted({1, spec.shape[-1] if spec.axes else 1})
    return {name: _narrow(_once(column, periods)) for name, column in columns.items() if name not in DERIVED}


def unpacked(spec: SweepSpec, span: Span, stored: Stored) -> Columns:
    """Return the columns of a block, bit by bit as they were computed, from what is stored of them."""
    return completed(spec, span, {name: _whole(column, len(span)) for name, column in stored.items()})


def _once(column: npt.NDArray[Any], periods: Iterable[int]) -> npt.NDArray[Any]:
    # bits, not values: NaN is not equal to itself, and 0 is equal to -0
    bits = column.view(f"u{column.itemsize}")
    for period in periods:
        if period >= bits.size:
            break
        # one look at the ends tells of nearly every column that it does not repeat
        if (
            bits[period] == bits[0]
            and bits[-1] == bits[-1 - period]
            and np.array_equal(bits[period:], bits[:-period])
        ):
            return column[:period]
    return column


def _whole(column: npt.NDArray[Any], cells: int) -> npt.NDArray[Any]:
    # not np.resize: it would join as many arrays as there are cells
    return column if column.size == cells else np.tile(column, -(-cells // column.size))[:cells]


def _narrow(column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if column.dtype.kind != "i" or column.itemsize == 1:
        return column
    ends = (np.min_scalar_type(column.min()), np.min_scalar_type(column.max()))
    return column.astype(np.result_type(*ends), copy=False)
