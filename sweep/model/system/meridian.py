"""Conditions on a body of revolution for all values of a request: convex, with possible moments."""

import math
from collections.abc import Iterator, Mapping
from itertools import islice, product
from typing import Any

import numpy as np

from sweep.errors import RequestError
from sweep.model.quantity import Array, Truths
from sweep.model.rows import ends_of, is_column
from sweep.model.system.cell_values import evaluated
from sweep.model.system.definition import Declared, Definition, Event, Meridian, Node, symbols

#: The state for the angle of the axis with the horizontal.
TILT = "tilt"

#: The parameter for the tilt at which a body with a flat side has fallen.
FALL_TILT = "fall_tilt"

#: Parameters that every body has, which scale its lengths and times.
_POSITIVE = ("radius", "gravity")

#: Tilts [rad] at which a meridian is checked: every half degree between its poles.
_TILTS = np.radians(np.arange(-89.5, 90.0, 0.5))

#: Number of nodes of the quadrature over a body.
_NODES = 400

#: Rounding error of a radius of curvature over the largest height: it may be negative by this much.
_ROUNDING = 1e-9

#: Most combinations of parameter values that are checked, and most values of one parameter.
_MOST_COMBINATIONS, _MOST_VALUES = 256, 17


def check_body(definition: Definition, values: Mapping[str, Any]) -> None:
    """Refuse values of which some make no body that rolls; checks the smallest, the largest, and values between.

    Parameters
    ----------
    definition : Definition
        It has a `meridian`.
    values : mapping of str to anything
        The value of each state and parameter: a number in SI, or an object with ``ends()``.

    Raises
    ------
    RequestError
    """
    meridian = definition.meridian
    assert meridian is not None
    _check_tilts(values)
    _check_units(values)
    ends = ends_of_tilts(definition.ends, definition.parameters)
    shape = (meridian.height, meridian.curvature, meridian.axial, meridian.transverse)
    of_shape, of_ends = ({name for node in nodes for name in symbols(node)} for nodes in (shape, ends))
    for numbers in _combinations({name: values[name] for name in sorted((of_shape | of_ends) - {TILT})}):
        given = ", ".join(f"{name}={numbers[name]:.6g}" for name in numbers if name in of_shape)
        _check_moments(meridian, numbers, given)
        _check_meridian(meridian, ends, numbers, given)


def solid(
    height: Node, slope: Node, curvature: Node, values: Mapping[str, float]
) -> tuple[float, float, float]:
    """Return the moments of inertia and the centre of mass of a homogeneous body.

    Parameters
    ----------
    height, slope, curvature : Node
        The height of a point of the axis over the plane, its derivative with respect to the tilt, and the radius of
        curvature.
    values : mapping of str to float
        The values of all parameters.

    Returns
    -------
    axial, transverse : float
        Moments about the centre of mass, over m radius^2; NaN without a volume.
    centre : float
        Distance of the centre of mass along the axis from the point with the height, over the radius.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    tilts = 0.5 * math.pi * nodes
    h, h_rate, bent = (
        result + np.zeros(_NODES) for result in evaluated([height, slope, curvature], {**values, TILT: tilts})
    )
    sine, cosine = np.sin(tilts), np.cos(tilts)
    # the distance of the contact from the axis, and its position along the axis
    far, along = cosine * h - sine * h_rate, -sine * h - cosine * h_rate
    # slices across the axis
    slices = weights * bent * cosine * far**2
    if not slices.sum() > _ROUNDING:
        return math.nan, math.nan, math.nan
    share = slices / slices.sum()
    centre = float(share @ along)
    axial = float(0.5 * share @ far**2)
    return axial, float(0.5 * axial + share @ (along - centre) ** 2), centre


def ends_of_tilts(ends: tuple[Event, ...], parameters: tuple[Declared, ...]) -> tuple[Node, ...]:
    """Return the expressions of endings that depend only on the tilt and on parameters."""
    fixed = {TILT, *(parameter.name for parameter in parameters)}
    nodes = (node for event in ends for node in event.any_positive)
    return tuple(node for node in nodes if {*symbols(node)} <= fixed)


def ended(ends: tuple[Node, ...], values: Mapping[str, Any]) -> Truths:
    """Return at which tilts in `values`, an array, a motion is over: one of the expressions is positive."""
    greatest: Array = np.full(values[TILT].shape, -1.0)
    for result in evaluated(ends, values):
        greatest = np.maximum(greatest, result)
    return np.asarray(greatest > 0.0)


def _check_tilts(values: Mapping[str, Any]) -> None:
    low, high = ends_of(values[TILT])
    if max(-low, high) >= 0.5 * math.pi:
        degrees = math.degrees(high if high > -low else low)
        raise RequestError(
            f"The axis of a body cannot be vertical at the start: -90 deg < tilt < 90 deg; got tilt={degrees:.6g}deg.",
            hint="Give a tilt below 90deg, such as 89.9deg for a body that spins on its end.",
            where=TILT,
        )
    low, high = ends_of(values.get(FALL_TILT, 1.0))
    if low <= 0.0 or high >= 0.5 * math.pi:
        degrees = math.degrees(low if low <= 0.0 else high)
        raise RequestError(
            f"The tilt at which a body has fallen must satisfy 0 deg < fall_tilt < 90 deg; got "
            f"fall_tilt={degrees:.6g}deg.",
            hint="Give fall_tilt=85deg.",
            where=FALL_TILT,
        )


def _check_units(values: Mapping[str, Any]) -> None:
    for name in _POSITIVE:
        low, _ = ends_of(values[name])
        if low <= 0.0:
            raise RequestError(
                f"The {name} of a body must be above 0; got {name}={low:.6g}.",
                hint=f"Give {name} > 0.",
                where=name,
            )


def _check_moments(meridian: Meridian, values: Mapping[str, float], given: str) -> None:
    axial, transverse = (float(moment) for moment in evaluated([meridian.axial, meridian.transverse], values))
    if not 0.0 < axial <= 2.0 * transverse * (1.0 + _ROUNDING):
        raise RequestError(
            f"The moments of a body must satisfy 0 < axial moment <= 2 transverse moment, with equality for a plane "
            f"body; got {axial:.6g} and {transverse:.6g}" + (f", for {given}." if given else "."),
            hint="A body returns its height, its axial moment and its transverse moment, in this order; moments are "
            "over mass times radius squared.",
        )


def _check_meridian(
    meridian: Meridian, ends: tuple[Node, ...], values: Mapping[str, float], given: str
) -> None:
    rolling = _TILTS[~ended(ends, {**values, TILT: _TILTS})]
    if not rolling.size:
        raise RequestError(
            f"Every motion of this body ends before it begins{f', for {given}' if given else ''}.",
            hint="Write ends that leave some tilts at which the body rolls.",
        )
    height, curvature = (
        result + np.zeros(rolling.shape)
        for result in evaluated([meridian.height, meridian.curvature], {**values, TILT: rolling})
    )
    for_these = f", for {given}" if given else ""
    # written so that NaN is wrong
    if (wrong := ~(height > 0.0)).any():
        at = np.flatnonzero(wrong)[0]
        raise RequestError(
            f"The centre of mass must lie inside the body: its height over the plane is above 0 at every tilt; got "
            f"{height[at]:.6g} at {math.degrees(rolling[at]):g} deg{for_these}.",
            hint="Correct the height, or end motions before such a tilt: ends={'edge': 'tilt < 0'}.",
        )
    if (wrong := ~(curvature >= -_ROUNDING * height.max())).any():
        at = np.flatnonzero(wrong)[np.argmin(curvature[wrong])]
        raise RequestError(
            "A body must be convex: the radius of curvature of its meridian, which is its height plus the second "
            f"derivative of the height, is 0 or more at every tilt; got {curvature[at]:.6g} at "
            f"{math.degrees(rolling[at]):g} deg{for_these}.",
            hint="Correct the height, or end motions before such a tilt: ends={'hollow': 'tilt > 60deg'}.",
        )


def _combinations(values: Mapping[str, Any]) -> Iterator[dict[str, float]]:
    """Yield combinations of values of parameters: of all ends and, if these are few, of values between them."""
    columns = {name: value for name, value in values.items() if is_column(value)}
    rows = _rows(columns)
    others = {name: value for name, value in values.items() if name not in columns}
    varied = sum(low != high for low, high in map(ends_of, others.values()))
    most = _MOST_COMBINATIONS // max(1, len(rows))
    count = max(2, min(_MOST_VALUES, int(most ** (1.0 / max(1, varied)))))
    combinations = product(rows, product(*(_some(value, count) for value in others.values())))
    for row, numbers in islice(combinations, _MOST_COMBINATIONS):
        yield row | dict(zip(others, numbers, strict=True))


def _rows(columns: Mapping[str, Any]) -> list[dict[str, float]]:
    """Return different rows of a table, including the ends of its columns; one empty row without a table."""
    if not columns:
        return [{}]
    if any(column.table is None or column.table.columns is None for column in columns.values()):
        # the values of a table may not be loaded: they were checked when the request was made
        return []
    rows = np.unique(np.column_stack([column.table.values(name) for name, column in columns.items()]), axis=0)
    ends = np.concatenate([rows.argmin(axis=0), rows.argmax(axis=0)])
    between = np.linspace(0, len(rows) - 1, min(len(rows), _MOST_COMBINATIONS // 2)).round().astype(np.intp)
    places = dict.fromkeys([*ends.tolist(), *between.tolist()])
    return [dict(zip(columns, rows[place].tolist(), strict=True)) for place in places]


def _some(value: Any, count: int) -> list[float]:
    """Return some values of a word, including its smallest and its largest."""
    if hasattr(value, "array"):
        places = np.linspace(0, len(value) - 1, min(count, len(value))).round().astype(np.intp)
        numbers: list[float] = value.at(places).tolist()
        return numbers
    return sorted({*np.linspace(*ends_of(value), count).tolist()})
