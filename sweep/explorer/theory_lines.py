"""Lines of theory on the map: the edges of the unstable band, followed along the rows and the columns of a window.

Theory gives an edge as a rate for each row. Where the line runs along the rows, as at the top of a band whose two edges
meet, places on it are sought for the columns too, and an edge that ends between two rows is followed to its end.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.explorer.view import Side, View
from sweep.model.quantity import Array

#: Rows and columns of a window in which points of a line are sought, and how far the columns go, in half windows.
_ROWS, _COLUMNS, _BEYOND = 256, 129, 1.25

#: Columns that an edge has to pass between two rows for points to be sought at them.
_STEEP = 4

#: Rows whose edges are computed at once: of a few theory takes a fifth of the time for each.
_AT_ONCE = 128

#: Halvings of the distance of two rows: a column is met to 1e-6 of the window, an edge ends to 1e-9 of it.
_TO_COLUMNS, _TO_END = 13, 23

#: Half windows from the middle beyond which nothing is sent.
_SEEN = 3.0


@dataclass(frozen=True)
class _Run:
    """A stretch of an edge: places of its rows, in order, and its values there in SI, shape (n,) each.

    `low` and `high` are the places at which the edge ends, None where the window does.
    """

    places: Array
    values: Array
    low: float | None
    high: float | None


def theory(view: View) -> list[dict[str, Any]]:
    """Return the lines of theory in a window, as `sweep.explorer.lines.lines` does; none without a control."""
    spec, model = view.spec, view.spec.model
    controls = model.controls([view.x.name, view.y.name])
    if not controls:
        return []
    along = view.x if view.x.name == controls[0] else view.y
    labels = {
        "analytic": "analytic, no perturbation",
        "predicted": model.line_words.label.format(spec.criterion.label(model)),
    }
    names = labels if spec.criterion.predictable else ("analytic",)
    parts = [_Edges(view, part, along) for part in _of_one_sign(along)]
    return [
        {
            "name": name,
            "label": labels[name],
            "points": [
                _pairs(stretch, along is view.x)
                for part in parts
                for curve in part.curves(number)
                for stretch in _seen(curve, along)
            ],
        }
        for number, name in enumerate(names)
    ]


def _of_one_sign(side: Side) -> Iterator[Side]:
    """Yield a side, or its two parts: theory has other edges for rates below zero."""
    low, high = side.ends()
    if not low < 0.0 < high:
        yield side
        return
    for end in (low, high):
        yield replace(side, centre=0.5 * end, half=0.5 * abs(end))


class _Edges:
    """The edges of the band in a window, along a part of one side."""

    def __init__(self, view: View, part: Side, along: Side) -> None:
        self._view, self._along = view, along
        self._across = view.y if along is view.x else view.x
        self._spec = view.spec_along(part)
        self._rows = (2.0 * np.arange(_ROWS) + 1.0) / _ROWS - 1.0
        self._known = self._at(self._rows)

    def curves(self, number: int) -> Iterator[Array]:
        """Yield the lines of one kind, shape (2, n): values along the control, and across it.

        Parameters
        ----------
        number : {0, 1}
            Of the analytic or of the predicted line.
        """
        runs = [list(self._runs(name, number)) for name in self._known]
        for places, values in _joined(*runs) if len(runs) == 2 else _each(runs):
            yield np.stack((values, self._across.at(places)))

    def _at(self, places: Array) -> dict[str, tuple[Array, Array]]:
        """Return the edges at places of the rows."""
        several = [places[first : first + _AT_ONCE] for first in range(0, max(places.size, 1), _AT_ONCE)]
        parts = [self._few(some) for some in several]
        # theory names no edge where none of the rows has it
        names = dict.fromkeys(name for part in parts for name in part)
        without = [(np.full(some.shape, np.nan),) * 2 for some in several]
        found = {
            name: [part.get(name, none) for part, none in zip(parts, without, strict=True)] for name in names
        }
        return {
            name: (np.concatenate([pair[0] for pair in pairs]), np.concatenate([pair[1] for pair in pairs]))
            for name, pairs in found.items()
        }

    def _few(self, places: Array) -> Mapping[str, tuple[Array, Array]]:
        rows = self._across.at(places)
        starts = self._view.starts(
            *(rows if side is self._across else np.ones_like(rows) for side in (self._view.x, self._view.y))
        )
        with np.errstate(all="ignore"):
            return self._view.spec.model.lines(self._spec, self._along.name, starts)

    def _edge(self, name: str, number: int, places: Array) -> Array:
        found = self._at(places).get(name)
        return np.full(places.shape, np.nan) if found is None else found[number]

    def _runs(self, name: str, number: int) -> Iterator[_Run]:
        """Yield the stretches of an edge that exist, from end to end."""
        values = self._known[name][number]
        exists = np.isfinite(values)
        for part in np.split(np.arange(_ROWS), np.flatnonzero(np.diff(exists)) + 1):
            if not exists[part[0]]:
                continue
            places = self._rows[part]
            # an edge that ends out of sight is followed only where it may come back as another one
            seen = np.abs(_places_on(self._along, values[part[[0, -1]]])) <= _SEEN
            wanted = seen if len(self._known) == 1 else (True, True)
            low = self._end(name, number, places[0], part[0] - 1) if part[0] > 0 and wanted[0] else None
            last = part[-1]
            high = self._end(name, number, places[-1], last + 1) if last < _ROWS - 1 and wanted[1] else None
            places = np.array([*([] if low is None else [low]), *places, *([] if high is None else [high])])
            known = self._edge(name, number, places)
            yield _Run(*self._across_columns(name, number, places, known), low, high)

    def _end(self, name: str, number: int, inside: float, beyond: int) -> float:
        """Return the last place at which an edge exists, between one where it does and a row where it does not."""
        outside = float(self._rows[beyond])
        for _ in range(_TO_END):
            middle = 0.5 * (inside + outside)
            if np.isfinite(self._edge(name, number, np.array([middle]))[0]):
                inside = middle
            else:
                outside = middle
        return float(inside)

    def _across_columns(self, name: str, number: int, places: Array, values: Array) -> tuple[Array, Array]:
        """Add the points at which an edge crosses columns where it passes several of them between two rows."""
        at = _places_on(self._along, values)
        segment, wanted = _crossed(at)
        if not segment.size:
            return places, values
        rising = at[segment + 1] > at[segment]
        low, high = places[segment], places[segment + 1]
        for _ in range(_TO_COLUMNS):
            middle = 0.5 * (low + high)
            before = (_places_on(self._along, self._edge(name, number, middle)) < wanted) == rising
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        crossings = 0.5 * (low + high)
        order = np.lexsort((np.where(rising, wanted, -wanted), segment))
        found = self._along.at(wanted[order])
        return _inserted(places, segment[order], crossings[order]), _inserted(values, segment[order], found)


def _places_on(side: Side, values: Array) -> Array:
    """Return the places of values on a side, -1 and 1 at the borders of the window; NaN where it has none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(((np.log(values) if side.scale == "log" else values) - side.centre) / side.half)


def _crossed(at: Array) -> tuple[npt.NDArray[np.intp], Array]:
    """Return the numbers of the segments between some places that pass several columns, and those columns."""
    columns = np.linspace(-_BEYOND, _BEYOND, _COLUMNS)
    low, high = np.fmin(at[1:], at[:-1]), np.fmax(at[1:], at[:-1])
    first, last = np.searchsorted(columns, low, "right"), np.searchsorted(columns, high, "left")
    count = np.where(last - first >= _STEEP, last - first, 0)
    segment = np.repeat(np.arange(count.size), count)
    nth = np.arange(segment.size) - np.repeat(np.cumsum(count) - count, count)
    return segment, columns[first[segment] + nth]


def _each(runs: list[list[_Run]]) -> Iterator[tuple[Array, Array]]:
    for run in (run for of_edge in runs for run in of_edge):
        yield run.places, run.values


def _joined(one: list[_Run], other: list[_Run]) -> Iterator[tuple[Array, Array]]:
    """Yield the stretches of two edges; those that end at the same place are one line, round that end."""
    left = list(other)
    for run in one:
        tops = [each for each in left if run.high is not None and each.high == run.high]
        bottoms = [each for each in left if run.low is not None and each.low == run.low]
        partner = next(iter(tops or bottoms), None)
        if partner is None:
            yield run.places, run.values
            continue
        left.remove(partner)
        forward = slice(None) if tops else slice(None, None, -1)
        backward = slice(None, None, -1) if tops else slice(None)
        places = [run.places[forward], partner.places[backward]]
        values = [run.values[forward], partner.values[backward]]
        if partner in tops and partner in bottoms:
            places.append(places[0][:1])
            values.append(values[0][:1])
        yield np.concatenate(places), np.concatenate(values)
    yield from _each([left])


def _seen(curve: Array, along: Side) -> Iterator[Array]:
    """Yield the stretches of a line, shape (2, n), that lie in the window or not far from it."""
    curve = _filled(curve, along)
    inside = np.abs(_places_on(along, curve[0])) <= _SEEN
    for part in np.split(np.arange(inside.size), np.flatnonzero(np.diff(inside)) + 1):
        if inside[part[0]] and part.size > 1:
            yield curve[:, part]


def _filled(curve: Array, along: Side) -> Array:
    """Return a line with points at the columns that it passes within one row, as where two edges meet."""
    segment, wanted = _crossed(_places_on(along, curve[0]))
    flat = curve[1, segment] == curve[1, segment + 1]
    segment, values = segment[flat], along.at(wanted[flat])
    rising = curve[0, segment + 1] > curve[0, segment]
    order = np.lexsort((np.where(rising, values, -values), segment))
    segment, values = segment[order], values[order]
    return np.stack((_inserted(curve[0], segment, values), _inserted(curve[1], segment, curve[1, segment])))


def _inserted(array: Array, segment: npt.NDArray[np.intp], values: Array) -> Array:
    """Return an array with values after the first elements of some segments."""
    return np.asarray(np.insert(array, (segment + 1).tolist(), values), np.float64)


def _pairs(points: Array, along_x: bool) -> list[list[float]]:
    pairs: list[list[float]] = (points if along_x else points[::-1]).T.tolist()
    return pairs
