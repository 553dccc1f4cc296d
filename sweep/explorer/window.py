"""The map of a window: every pixel a cell, computed piece by piece."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.engine.compute import compute
from sweep.explorer.fields import read_choice, read_count, refuse
from sweep.explorer.quantities import Shown, shown_of
from sweep.explorer.stored import Stored
from sweep.explorer.view import View
from sweep.explorer.waiting import KERNELS
from sweep.model.quantity import Truths

#: Pixels of a window at most.
MOST_PIXELS = 4_000_000

#: Pixels that are computed before it is asked whether anybody still waits: about 5 ms of two threads, and whole chunks
#: of the kernel.
_PIECE, _TIMED_PIECE = 32768, 12288

#: Values, verdicts, and which pixels have them.
Held = tuple[npt.NDArray[Any], npt.NDArray[np.uint8], Truths]

#: Where the cell of a pixel comes from, and the code of a quantity where there is no cell.
_COMPUTED, _STORED, _NO_CELL = np.uint8(0), np.uint8(1), np.uint8(2)
_NO_CODE = 255

#: Below this share of its largest value the range of a quantity has too few steps in single precision.
_NARROW = 1e-3


def window(
    view: View, stored: Stored | None, fields: Mapping[str, Any], check: Callable[[], None]
) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    """Compute a window.

    Parameters
    ----------
    view : View
    stored : Stored or None
    fields : mapping
        ``width`` and ``height`` in pixels, the ``quantity``, and whether cells of the file are ``stored`` ones where
        the view shows them.
    check : callable
        Called between pieces of work: raises where the answer is no longer wanted.

    Returns
    -------
    head : dict
        ``low`` and ``high`` of the values, ``least`` of those above zero (None without any), ``end``, whether pixels
        are so small that rounding would be seen, and a ``note``, why there are no values, or nothing.
    arrays : dict of str to array, shape (height, width)
        ``value``: codes as uint8, or numbers as float32; as float64 where the values are too near to one another. From
        the bottom up. NaN (or the code 255) where there is no number. ``verdict``, uint8. If the file has cells there,
        ``stored``, uint8: 1 where a value is one of them, 0 where it was computed, 2 where there is none of either.

    Raises
    ------
    RequestError
        If the window is too large, or cells of the view cannot be computed and are not stored.
    """
    width, height = (read_count(fields, name, MOST_PIXELS) for name in ("width", "height"))
    if width * height > MOST_PIXELS:
        refuse("width * height", f"at most {MOST_PIXELS}", width * height)
    size = width, height
    held, note = None, ""
    if fields.get("stored") is True and stored is not None and stored.place(view) is not None:
        known = stored.quantities() | (shown_of(view.live) if view.is_live else {})
        name = read_choice(fields, "quantity", tuple(known))
        held = stored.pixels(view, known[name], size) if name in stored.quantities() else None
    else:
        live = shown_of(view.live)
        of_file = stored.quantities() if stored is not None and view.given is stored.spec else {}
        name = read_choice(fields, "quantity", (*live, *(each for each in of_file if each not in live)))
        if name not in live:
            # what integration in time alone tells is chosen of a file, whose other words may be changed
            held = _nothing(of_file[name], size)
            label = name.replace("_", " ").capitalize()
            note = f"{label} is known of stored cells alone, and none of them is shown here."
    value, verdict, mask = _joined(view, name, size, held, check)
    low, high = _range(value, value != _NO_CODE if value.dtype == np.uint8 else np.isfinite(value))
    least, _ = _range(value, (value > 0) & (value < np.inf))
    if value.dtype == np.float64 and not _is_narrow(low, high):
        value = value.astype(np.float32)
    head = {
        "width": width,
        "height": height,
        "quantity": name,
        "low": low,
        "high": high,
        "least": least,
        "end": view.x.is_too_fine(width) or view.y.is_too_fine(height),
        "note": note,
    }
    arrays = {"value": value, "verdict": verdict}
    return head, arrays if mask is None else {**arrays, "stored": mask}


def _nothing(shown: Shown, size: tuple[int, int]) -> Held:
    """Return pixels of which none has a cell."""
    width, height = size
    kind, none = (np.uint8, _NO_CODE) if shown.quantity.flags else (np.float64, np.nan)
    where = np.zeros((height, width), bool)
    return np.full((height, width), none, kind), np.zeros((height, width), np.uint8), where


def _joined(
    view: View, name: str, size: tuple[int, int], held: Held | None, check: Callable[[], None]
) -> tuple[npt.NDArray[Any], npt.NDArray[np.uint8], npt.NDArray[np.uint8] | None]:
    """Return values, verdicts and where they are stored: cells of the file, and live ones where it has none."""
    if held is None:
        return *pixels(view, shown_of(view.live)[name], size, check), None
    value, verdict, inside = held
    if not inside.all():
        beyond = None
        if view.is_live and name in shown_of(view.live):
            beyond = pixels(view, shown_of(view.live)[name], size, check)
        missing = _NO_CODE if value.dtype == np.uint8 else np.nan
        value = np.where(inside, value, missing if beyond is None else beyond[0]).astype(value.dtype)
        verdict = np.where(inside, verdict, 0 if beyond is None else beyond[1]).astype(np.uint8)
        return value, verdict, np.where(inside, _STORED, _NO_CELL if beyond is None else _COMPUTED)
    return value, verdict, np.full(inside.shape, _STORED)


def pixels(
    view: View, shown: Shown, size: tuple[int, int], check: Callable[[], None]
) -> tuple[npt.NDArray[Any], npt.NDArray[np.uint8]]:
    """Compute the values of a quantity and the verdicts at all pixels, shape (height, width)."""
    width, height = size
    columns, rows = view.x.values(width), view.y.values(height)
    value = np.empty((height, width), np.uint8 if shown.quantity.flags else np.float64)
    verdict = np.empty((height, width), np.uint8)
    for part in _pieces(size, _TIMED_PIECE if shown.timed else _PIECE, by_columns=view.x.name == "alpha"):
        check()
        y, x = np.meshgrid(rows[part[0]], columns[part[1]], indexing="ij")
        with KERNELS:
            found = compute(view.live, view.starts(x.ravel(), y.ravel()), verdicts_only=not shown.timed)
        value[part] = shown.values(view.live, found).reshape(x.shape)
        verdict[part] = found["stability"].reshape(x.shape)
    check()
    return value, verdict


def _pieces(size: tuple[int, int], cells: int, *, by_columns: bool) -> Iterator[tuple[slice, slice]]:
    """Yield the pieces of a window, whole rows or columns: the reduction has tables for each alpha of a piece."""
    width, height = size
    along, across = (height, width) if by_columns else (width, height)
    step = max(1, cells // along)
    for start in range(0, across, step):
        part = slice(start, min(start + step, across))
        yield (slice(None), part) if by_columns else (part, slice(None))


def _range(value: npt.NDArray[Any], known: Truths) -> tuple[float | None, float | None]:
    """Return the smallest and the largest of the known values; None without any."""
    if not known.any():
        return None, None
    # without a copy of the values
    lowest, highest = (255, 0) if value.dtype == np.uint8 else (np.inf, -np.inf)
    return float(value.min(where=known, initial=lowest)), float(value.max(where=known, initial=highest))


def _is_narrow(low: float | None, high: float | None) -> bool:
    if low is None or high is None:
        return False
    return high - low < _NARROW * max(abs(low), abs(high))
