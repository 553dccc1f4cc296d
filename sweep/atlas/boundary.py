"""The boundary of stability as the cells show it: between which cells along a control parameter the verdict changes."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sweep.atlas.bisection import Brackets, bisected
from sweep.engine.grid import whole
from sweep.model.quantity import STABLE, UNSTABLE, Array
from sweep.request.spec import SweepSpec


@dataclass(frozen=True)
class Edge:
    """One edge of the unstable band along an axis, over the remaining axes; NaN where there is none.

    `measured` lies in the middle of the bracket between the last unstable and the first stable cell, `halfwidth` is
    half that bracket; undecided cells between the two widen it. Where the spec says ``boundary = "refined"`` the
    bracket was bisected. `critical` and `predicted` are those of `sweep.model.description.Model.lines`.
    """

    measured: Array
    halfwidth: Array
    critical: Array
    predicted: Array


def edges(spec: SweepSpec, stability: npt.NDArray[np.integer]) -> dict[tuple[str, str], Edge]:
    """Find the edges of the unstable band along every control parameter among the axes of a grid.

    Parameters
    ----------
    spec : SweepSpec
    stability : array of int, shape spec.shape
        Verdicts (`sweep.model.quantity`).

    Returns
    -------
    dict of (axis, "upper" or "lower") to Edge
        The upper edge (stable above) of every such axis, and the lower edge (stable below) where theory or the
        cells have one.
    """
    found: dict[tuple[str, str], Edge] = {}
    for axis in spec.model.controls(spec.axes):
        values = getattr(spec, axis).array()
        rows = np.moveaxis(stability, spec.axes.index(axis), -1)
        lines = theory_lines(spec, axis)
        for name, bracket in (("upper", upper_bracket(rows)), ("lower", lower_bracket(rows))):
            inside, outside = _values(values, bracket[0]), _values(values, bracket[1])
            if spec.boundary_width is not None:
                inside, outside = _narrowed(spec, axis, inside, outside, spec.boundary_width)
            measured = 0.5 * (inside + outside)
            if name == "upper" or name in lines or np.isfinite(measured).any():
                nothing = np.full(measured.shape, np.nan)
                critical, predicted = lines.get(name, (nothing, nothing))
                found[axis, name] = Edge(measured, 0.5 * np.abs(outside - inside), critical, predicted)
    return found


def theory_lines(spec: SweepSpec, axis: str) -> dict[str, tuple[Array, Array]]:
    """Return the edges of theory along an axis over the remaining axes; see `sweep.model.description.Model.lines`."""
    rows = _rows(spec, axis)
    lines = spec.model.lines(spec, axis, whole(rows))
    return {name: (line[0].reshape(rows.shape), line[1].reshape(rows.shape)) for name, line in lines.items()}


def _rows(spec: SweepSpec, axis: str) -> SweepSpec:
    """Return the spec of the rows along an axis: it has one value there, not zero if that can be."""
    return spec.replace(**{axis: next((float(end) for end in getattr(spec, axis).ends() if end), 1.0)})


def _narrowed(spec: SweepSpec, axis: str, inside: Array, outside: Array, width: float) -> tuple[Array, Array]:
    """Bisect the brackets of all rows at once."""
    found = np.flatnonzero(np.isfinite(inside.reshape(-1)))
    starts = {name: each[found] for name, each in whole(_rows(spec, axis)).items()}
    number = list(spec.model.parameters).index(axis)
    codes = [np.full(found.size, code, np.int8) for code in (UNSTABLE, STABLE)]
    ends = inside.reshape(-1)[found], outside.reshape(-1)[found]
    fine = bisected(spec, Brackets(starts, np.full(found.size, number), *ends, *codes), width)
    narrow = [np.full(inside.size, np.nan) for _ in ends]
    narrow[0][found], narrow[1][found] = fine.near, fine.far
    return narrow[0].reshape(inside.shape), narrow[1].reshape(inside.shape)


def upper_bracket(rows: npt.NDArray[np.integer]) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the last unstable cell of each row and the first stable one after it.

    Parameters
    ----------
    rows : array of int, shape (..., n)

    Returns
    -------
    (last_unstable, first_stable) : arrays of int, shape (...)
        Indices along the last axis; -1 in both where a row has no such pair.
    """
    n = rows.shape[-1]
    unstable = rows == UNSTABLE
    last = np.where(unstable.any(-1), n - 1 - np.argmax(unstable[..., ::-1], axis=-1), n)
    beyond = (rows == STABLE) & (np.arange(n) > last[..., None])
    some = beyond.any(-1)
    return np.where(some, last, -1), np.where(some, np.argmax(beyond, axis=-1), -1)


def lower_bracket(rows: npt.NDArray[np.integer]) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the first unstable cell of each row and the last stable one before it; as `upper_bracket`."""
    n = rows.shape[-1]
    first, last = upper_bracket(rows[..., ::-1])
    return np.where(first < 0, -1, n - 1 - first), np.where(last < 0, -1, n - 1 - last)


def _values(values: Array, places: npt.NDArray[np.intp]) -> Array:
    return np.where(places < 0, np.nan, values[places])
