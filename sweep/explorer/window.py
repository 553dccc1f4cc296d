"""The cells in a window: stored cells, each drawn as a rectangle of pixels, and computed cells.

The page computes a window itself where it is about as fast as the program, and otherwise asks for it.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.engine.compute import compute, use_threads
from sweep.explorer.fields import read_choice, read_count, refuse
from sweep.explorer.quantities import shown_of
from sweep.explorer.stored import Stored
from sweep.explorer.system import is_system
from sweep.explorer.view import View
from sweep.explorer.waiting import KERNELS
from sweep.model.quantity import Truths

#: Largest number of pixels in a window.
MOST_PIXELS = 4_000_000

#: Number of cells that are computed at a time, or at least one row of the window, in general and for a system: some
#: tens of milliseconds of work.
_PIECE, _OF_A_SYSTEM = 65_536, 256

#: Codes for a pixel whose cell is stored, and for one without a cell; code of a quantity where there is no cell.
_STORED, _NO_CELL = np.uint8(1), np.uint8(2)
_NO_CODE = 255

#: Least relative range of a quantity at which single precision has enough steps.
_NARROW = 1e-3


def stored_window(
    view: View, stored: Stored | None, fields: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]] | None:
    """Return the stored cells in a window; None if the view shows no cells of the file.

    Parameters
    ----------
    view : View
    stored : Stored or None
    fields : mapping
        ``width`` and ``height`` in pixels, and the ``quantity``.

    Returns
    -------
    head : dict
        ``low`` and ``high`` of the values, ``least`` of the positive ones (None if there are none), ``end``: whether
        pixels are so small that rounding would be visible, and a ``note``.
    arrays : dict of str to array, shape (height, width)
        ``value``: codes as uint8, or numbers as float32, or as float64 if they differ too little. Rows start at the
        bottom; NaN (or the code 255) where there is no number. ``verdict``, uint8. ``stored``, uint8: 1 for pixels with
        a stored cell, 2 for pixels without one.

    Raises
    ------
    RequestError
        If the window is too large.
    """
    width, height = _size(fields)
    if stored is None or stored.place(view) is None:
        return None
    known = stored.quantities()
    live = shown_of(view.live) if view.is_live else {}
    name = read_choice(fields, "quantity", tuple(known | live))
    found = stored.pixels(view, known[name], (width, height)) if name in known else None
    if found is None:
        return None
    value, verdict, inside = found
    value = np.where(inside, value, _NO_CODE if value.dtype == np.uint8 else np.nan).astype(value.dtype)
    head = _head(view, value)
    if value.dtype == np.float64 and not _is_narrow(head["low"], head["high"]):
        value = value.astype(np.float32)
    arrays = {
        "value": value,
        "verdict": np.where(inside, verdict, 0).astype(np.uint8),
        "stored": np.where(inside, _STORED, _NO_CELL),
    }
    return head, arrays


def computed_window(
    view: View, fields: Mapping[str, Any], check: Callable[[], None]
) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    """Return the cells at the pixels of a window, computed on all processors.

    Parameters
    ----------
    view : View
    fields : mapping
        ``width`` and ``height`` in pixels, and the ``quantity``.
    check : callable
        Called between pieces of work; raises an error if the window is no longer wanted.

    Returns
    -------
    head, arrays
        Like those of `stored_window`, without ``stored``; numbers are float64.

    Raises
    ------
    RequestError
        If the window is too large, or its cells cannot be computed.
    """
    width, height = _size(fields)
    spec, known = view.live, shown_of(view.live)
    shown = known[read_choice(fields, "quantity", tuple(known))]
    use_threads(None)
    x, y = view.x.values(width), view.y.values(height)
    verdict = np.empty((height, width), np.uint8)
    value = np.empty((height, width), np.float64 if shown.quantity.flags is None else np.uint8)
    rows = max(1, (_OF_A_SYSTEM if is_system(spec) else _PIECE) // width)
    for first in range(0, height, rows):
        check()
        here = y[first : first + rows]
        with KERNELS:
            starts = view.starts(np.tile(x, here.size), np.repeat(here, width))
            columns = compute(spec, starts)
        shape = here.size, width
        value[first : first + rows] = shown.values(spec, columns).reshape(shape)
        verdict[first : first + rows] = columns["stability"].reshape(shape)
    return _head(view, value), {"value": value, "verdict": verdict}


def _size(fields: Mapping[str, Any]) -> tuple[int, int]:
    width, height = (read_count(fields, name, MOST_PIXELS) for name in ("width", "height"))
    if width * height > MOST_PIXELS:
        refuse("width * height", f"at most {MOST_PIXELS}", width * height)
    return width, height


def _head(view: View, value: npt.NDArray[Any]) -> dict[str, Any]:
    """Return the head of a window, from its values."""
    height, width = value.shape
    low, high = _range(value, value != _NO_CODE if value.dtype == np.uint8 else np.isfinite(value))
    least, _ = _range(value, (value > 0) & (value < np.inf))
    is_too_fine = view.x.is_too_fine(width) or view.y.is_too_fine(height)
    return {"low": low, "high": high, "least": least, "end": is_too_fine, "note": ""}


def _range(value: npt.NDArray[Any], known: Truths) -> tuple[float | None, float | None]:
    """Return the smallest and the largest of the known values; None if there are none."""
    if not known.any():
        return None, None
    # avoids a copy of the values
    lowest, highest = (255, 0) if value.dtype == np.uint8 else (np.inf, -np.inf)
    return float(value.min(where=known, initial=lowest)), float(value.max(where=known, initial=highest))


def _is_narrow(low: float | None, high: float | None) -> bool:
    if low is None or high is None:
        return False
    return high - low < _NARROW * max(abs(low), abs(high))
