"""The cells of the explorer's atlas, for the views that show them."""

import math
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import EDGES, edge_names
from sweep.atlas.parts import is_inside, nearest
from sweep.engine.grid import Span, starts_of
from sweep.errors import RequestError
from sweep.explorer.quantities import Shown, shown_of
from sweep.explorer.view import View
from sweep.explorer.waiting import ClientGoneError
from sweep.model.description import Columns
from sweep.model.quantity import Array, Truths
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Largest number of cells that are read of a plane; of a larger plane only every second cell, or fewer.
_MOST_CELLS = 2**22

#: Number of planes in the cache, 8 bytes for each cell.
_KEPT = 6

#: A side, and the start, end and step of the part that is read along it.
_Part = tuple[str, int, int | None, int]

#: Settings that change the numbers of a cell only within their errors.
_OF_NO_MATTER = ("duration", "step", "tolerance")


class Stored:
    """An atlas whose cells the map shows; thread-safe.

    Parameters
    ----------
    dataset : xarray.Dataset
        Must stay open as long as it is used.
    spec : SweepSpec
        The request from which the atlas was made.
    label : str
        Its name for messages.

    Raises
    ------
    RequestError
        If its cells do not span a plane.
    """

    def __init__(self, dataset: "xr.Dataset", spec: SweepSpec, label: str) -> None:
        self.spec, self.label = spec, label
        self._dataset = dataset
        self._kept = lru_cache(_KEPT)(self._read_part)
        # netCDF can read in only one thread at a time
        self._lock = threading.Lock()
        self._is_closed = False
        if spec.is_list or sum(len(getattr(spec, name)) > 1 for name in spec.axes) < 2:
            raise RequestError(
                f"A map needs cells along two parameters; this atlas has {' x '.join(map(str, spec.shape)) or 'one'} "
                f"cells{f' along {spec.axes[0]}' if len(spec.axes) == 1 else ''}.",
                hint="Give an atlas of two axes, or a preset, whose cells are computed on demand.",
                where=label,
            )

    def close(self) -> None:
        """Stop reading: the file is about to be closed."""
        with self._lock:
            self._is_closed = True

    @contextmanager
    def _reading(self) -> Iterator[None]:
        """Lock the file; end the request if the file is closed."""
        with self._lock:
            if self._is_closed:
                raise ClientGoneError
            yield

    def quantities(self) -> dict[str, Shown]:
        """Return the quantities of the atlas that the map can show."""
        known = shown_of(self.spec)
        return {
            name: each for name, each in known.items() if all(need in self._dataset for need in each.needs)
        }

    def place(self, view: View) -> dict[str, int] | None:
        """Return where a view cuts the other axes of the atlas; None if it shows cells other than the stored ones."""
        if view.given is not self.spec:
            return None
        sides, found = (view.x.name, view.y.name), dict[str, int]()
        if any(name not in self.spec.axes or len(getattr(self.spec, name)) < 2 for name in sides):
            return None
        for name in self.spec.model.parameters:
            held, wanted = getattr(self.spec, name), getattr(view.spec, name)
            if name in sides:
                continue
            if isinstance(held, Range | Values) and is_inside(held, wanted):
                found[name] = nearest(held, wanted, self.spec.quantities[name])
            elif held != wanted:
                return None
        settings = (name for name in self.spec.model.settings if name not in _OF_NO_MATTER)
        same = all(getattr(self.spec, name) == getattr(view.spec, name) for name in (*settings, "criterion"))
        return found if same else None

    def pixels(
        self, view: View, shown: Shown, size: tuple[int, int]
    ) -> tuple[npt.NDArray[Any], npt.NDArray[np.uint8], Truths] | None:
        """Return the quantity and the verdicts of the nearest cells of all pixels, and which pixels have a cell.

        The arrays have the shape (height, width). Returns None if the view shows cells other than the stored ones.
        """
        place = self.place(view)
        if place is None:
            return None
        (columns, inside_x), (rows, inside_y) = (
            self._cells(side.name, side.values(count))
            for side, count in zip((view.x, view.y), size, strict=True)
        )
        needed = {name: self._plane(name, place, view, rows, columns) for name in (*shown.needs, "stability")}
        value = shown.values(self.spec, needed)
        return value, needed["stability"].astype(np.uint8), inside_y[:, None] & inside_x

    def cell(self, view: View, x: float, y: float) -> tuple[dict[str, float], Columns] | None:
        """Return the start and the columns, shape (1,), of the nearest cell; None if the point is outside."""
        place = self.place(view)
        if place is None:
            return None
        for name, at in ((view.x.name, x), (view.y.name, y)):
            cells, inside = self._cells(name, np.array([at]))
            if not inside[0]:
                return None
            place[name] = int(cells[0])
        number = int(np.ravel_multi_index([place[name] for name in self.spec.axes], self.spec.shape))
        starts = starts_of(self.spec, Span(number, number + 1))
        with self._reading():
            held = {
                name: np.atleast_1d(self._read(name, place))
                for name in self.spec.model.cell_variables(self.spec)
                if name in self._dataset
            }
        return {name: float(values[0]) for name, values in starts.items()}, held

    def explained(self, view: View, at: Mapping[str, float]) -> str:
        """Return the text of `eulerdisk explain` for the nearest cell; raises as `explain` does."""
        from sweep.checks.explain import explain

        place = self.place(view)
        if place is None:
            view.live  # noqa: B018 - raises an error that says what is missing
        others = {name: float(getattr(self.spec, name).at([i])[0]) for name, i in (place or {}).items()}
        # computes single cells on one thread, like motions, in parallel with maps
        return explain(self._dataset, {**others, **at}).text

    def boundary(self, view: View) -> list[list[list[float]]]:
        """Return the boundary in the file as polylines of pairs (x, y) in SI."""
        place, found = self.place(view), []
        for along, across in ((view.x, view.y), (view.y, view.x)):
            for edge in EDGES:
                name = edge_names(along.name, edge)[0]
                if place is None or name not in self._dataset:
                    continue
                with self._reading():
                    values = np.asarray(self._read(name, place), np.float64)
                pairs = np.stack((values, getattr(self.spec, across.name).array()))
                known = np.flatnonzero(np.isfinite(values))
                for part in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1):
                    points = pairs[:, part] if along is view.x else pairs[::-1, part]
                    found.append(points.T.tolist())
        return [points for points in found if points]

    def plane(self, name: str, view: View) -> npt.NDArray[Any]:
        """Return all cells of the plane of a view, shape (cells along y, cells along x); `place` must not be None."""
        place = self.place(view)
        assert place is not None
        rows, columns = (np.arange(len(getattr(self.spec, side.name))) for side in (view.y, view.x))
        return self._plane(name, place, view, rows, columns)

    def _cells(self, name: str, values: Array) -> tuple[npt.NDArray[np.intp], Truths]:
        """Return the nearest cell of each value along an axis, and whether the value is inside the cell; shape (n,).

        The border between two cells is in the middle on the axis's own scale, independent of the scale of the map.
        """
        axis = getattr(self.spec, name)
        held = axis.array()
        if isinstance(axis, Range) and axis.spacing == "log":
            # values that are not positive are below all cells
            held, values = np.log(held), np.log(np.maximum(values, np.finfo(float).tiny))
        borders = borders_of(held)
        places = np.searchsorted(borders, values, side="right") - 1
        inside = (values >= borders[0]) & (values <= borders[-1])
        return np.clip(places, 0, held.size - 1), inside

    def _plane(
        self,
        name: str,
        place: Mapping[str, int],
        view: View,
        rows: npt.NDArray[np.intp],
        columns: npt.NDArray[np.intp],
    ) -> npt.NDArray[Any]:
        """Return the values of a variable in some rows and columns of a plane."""
        sides = (view.y.name, rows), (view.x.name, columns)
        size = math.prod(len(getattr(self.spec, side)) for side, _ in sides)
        parts = [
            (side, *((0, None, 1) if size <= _MOST_CELLS else _choose_slice(places)))
            for side, places in sides
        ]
        held = self._kept(name, tuple(place.items()), *parts)
        indices = (
            np.minimum((places - start) // step, count - 1)
            for (_, places), (_, start, _, step), count in zip(sides, parts, held.shape, strict=True)
        )
        found: npt.NDArray[Any] = held[np.ix_(*indices)]
        return found

    def _read_part(self, name: str, place: tuple[tuple[str, int], ...], *parts: _Part) -> npt.NDArray[Any]:
        """Read a part of a plane, with rows along the first of the two sides."""
        with self._reading():
            found = self._read(name, {**dict(place), **{side: slice(*span) for side, *span in parts}})
        (rows, *_), (columns, *_) = parts
        is_transposed = self.spec.axes.index(rows) > self.spec.axes.index(columns)
        return np.ascontiguousarray(found.T) if is_transposed else found

    def _read(self, name: str, place: Mapping[str, int | slice]) -> npt.NDArray[Any]:
        """Read a variable at an index or slice for each dimension in `place`, and everything along the others."""
        variable = self._dataset.variables[name]
        return np.asarray(variable[tuple(place.get(str(dim), slice(None)) for dim in variable.dims)])


def borders_of(values: Array) -> Array:
    """Return the borders of cells at increasing values, shape (n + 1,), in the middle between neighbours."""
    middles = 0.5 * (values[1:] + values[:-1])
    first, last = values[0] - (middles[0] - values[0]), values[-1] + (values[-1] - middles[-1])
    return np.concatenate(([first], middles, [last]))


def _choose_slice(places: npt.NDArray[np.intp]) -> tuple[int, int, int]:
    """Return the start, end and step of a slice that covers the places, with only every k-th if they are many."""
    first, last = int(places[0]), int(places[-1])
    return first, last + 1, max(1, (last - first + 1) // int(np.sqrt(_MOST_CELLS)))
