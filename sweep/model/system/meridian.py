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

#: The state that says how the body leans: the angle of its axis with the horizontal.
TILT = "tilt"

#: The parameter with the tilt from which on a body with a flat side has fallen.
FALL_TILT = "fall_tilt"

#: Parameters that every body has, the units of its lengths and times.
_POSITIVE = ("radius", "gravity")

#: Tilts [rad] at which a meridian is looked at, each half of a degree between its poles.
_TILTS = np.radians(np.arange(-89.5, 90.0, 0.5))

#: Nodes of the quadrature over a body.
_NODES = 400

#: Share of the largest height by which a radius of curvature may be below 0, by rounding.
_ROUNDING = 1e-9

#: Mixtures of the values of parameters that are looked at, and values of one parameter.
_MOST_MIXTURES, _MOST_VALUES = 256, 17


def check_body(definition: Definition, values: Mapping[str, Any]) -> None:
    """Refuse values of which no body rolls: at their smallest, their largest, and values between them.

    Parameters
    ----------
    definition : Definition
        With a `meridian`.
    values : mapping of str to anything
        Of each state and parameter: a number in SI, or what has ``ends()``.

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
    for mixture in _mixtures({name: values[name] for name in sorted((of_shape | of_ends) - {TILT})}):
        given = ", ".join(f"{name}={mixture[name]:.6g}" for name in mixture if name in of_shape)
        _check_moments(meridian, mixture, given)
        _check_meridian(meridian, ends, mixture, given)


def solid(
    height: Node, slope: Node, curvature: Node, values: Mapping[str, float]
) -> tuple[float, float, float]:
    """Return the moments of inertia of a homogeneous body, and where its centre of mass is.

    Parameters
    ----------
    height, slope, curvature : Node
        The height of a point of the axis over the plane, its derivative by the tilt, and the radius of curvature.
    values : mapping of str to float
        Of all parameters.

    Returns
    -------
    axial, transverse : float
        About its centre of mass, over m radius^2; NaN without a volume.
    centre : float
        The distance of that along the axis from the point with the height, over the radius.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    tilts = 0.5 * math.pi * nodes
    h, h_rate, bent = (
        each + np.zeros(_NODES) for each in evaluated([height, slope, curvature], {**values, TILT: tilts})
    )
    sine, cosine = np.sin(tilts), np.cos(tilts)
    # of the contact: its distance from the axis, and where it is along it
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
    """Return the expressions of endings that depend on the tilt and on parameters alone."""
    fixed = {TILT, *(each.name for each in parameters)}
    nodes = (node for each in ends for node in each.any_positive)
    return tuple(node for node in nodes if {*symbols(node)} <= fixed)


def ended(ends: tuple[Node, ...], values: Mapping[str, Any]) -> Truths:
    """Return at which tilts of `values`, an array, one of some expressions is positive: a motion is over."""
    over: Array = np.full(values[TILT].shape, -1.0)
    for each in evaluated(ends, values):
        over = np.maximum(over, each)
    return np.asarray(over > 0.0)


def _check_tilts(values: Mapping[str, Any]) -> None:
    low, high = ends_of(values[TILT])
    if max(-low, high) >= 0.5 * math.pi:
        degrees = math.degrees(high if high > -low else low)
        raise RequestError(
            f"The axis of a body is not vertical at its start: -90 deg < tilt < 90 deg; got tilt={degrees:.6g}deg.",
            hint="Give a tilt below 90deg, as 89.9deg of a body that spins on its end.",
            where=TILT,
        )
    low, high = ends_of(values.get(FALL_TILT, 1.0))
    if low <= 0.0 or high >= 0.5 * math.pi:
        degrees = math.degrees(low if low <= 0.0 else high)
        raise RequestError(
            f"A body has fallen before it lies flat: 0 deg < fall_tilt < 90 deg; got fall_tilt={degrees:.6g}deg.",
            hint="Give fall_tilt=85deg.",
            where=FALL_TILT,
        )


def _check_units(values: Mapping[str, Any]) -> None:
    for name in _POSITIVE:
        low, _ = ends_of(values[name])
        if low <= 0.0:
            raise RequestError(
                f"The {name} of a body is above 0; got {name}={low:.6g}.",
                hint=f"Give {name} > 0.",
                where=name,
            )


def _check_moments(meridian: Meridian, values: Mapping[str, float], given: str) -> None:
    axial, transverse = (float(each) for each in evaluated([meridian.axial, meridian.transverse], values))
    if not 0.0 < axial <= 2.0 * transverse * (1.0 + _ROUNDING):
        raise RequestError(
            f"The moments of a body are 0 < axial moment <= 2 transverse moment, with equality for a plane one; got "
            f"{axial:.6g} and {transverse:.6g}" + (f", for {given}." if given else "."),
            hint="A body returns its height, its axial moment and its transverse moment, in this order, over mass "
            "times radius squared.",
        )


def _check_meridian(
    meridian: Meridian, ends: tuple[Node, ...], values: Mapping[str, float], given: str
) -> None:
    rolling = _TILTS[~ended(ends, {**values, TILT: _TILTS})]
    if not rolling.size:
        raise RequestError(
            f"Every motion of this body has ended before it begins{f', for {given}' if given else ''}.",
            hint="Let an ending leave some tilts at which the body rolls.",
        )
    height, curvature = (
        each + np.zeros(rolling.shape)
        for each in evaluated([meridian.height, meridian.curvature], {**values, TILT: rolling})
    )
    for_these = f", for {given}" if given else ""
    # written so that NaN is wrong
    if (wrong := ~(height > 0.0)).any():
        at = np.flatnonzero(wrong)[0]
        raise RequestError(
            f"The centre of mass lies inside a body: its height over the plane is above 0 at every tilt; got "
            f"{height[at]:.6g} at {math.degrees(rolling[at]):g} deg{for_these}.",
            hint="Correct the height, or end motions before such a tilt: ends={'edge': 'tilt < 0'}.",
        )
    if (wrong := ~(curvature >= -_ROUNDING * height.max())).any():
        at = np.flatnonzero(wrong)[np.argmin(curvature[wrong])]
        raise RequestError(
            "A body rolls on what is convex: the radius of curvature of its meridian, its height and the second "
            f"derivative of that by the tilt, is 0 or more at every tilt; got {curvature[at]:.6g} at "
            f"{math.degrees(rolling[at]):g} deg{for_these}.",
            hint="Correct the height, or end motions before such a tilt: ends={'hollow': 'tilt > 60deg'}.",
        )


def _mixtures(values: Mapping[str, Any]) -> Iterator[dict[str, float]]:
    """Yield values of parameters together: all ends with all ends, and if these are few what lies between them."""
    columns = {name: value for name, value in values.items() if is_column(value)}
    rows = _rows(columns)
    others = {name: value for name, value in values.items() if name not in columns}
    varied = sum(low != high for low, high in map(ends_of, others.values()))
    most = _MOST_MIXTURES // max(1, len(rows))
    count = max(2, min(_MOST_VALUES, int(most ** (1.0 / max(1, varied)))))
    mixtures = product(rows, product(*(_some(each, count) for each in others.values())))
    for row, mixture in islice(mixtures, _MOST_MIXTURES):
        yield row | dict(zip(others, mixture, strict=True))


def _rows(columns: Mapping[str, Any]) -> list[dict[str, float]]:
    """Return unlike rows of a table, those with the ends of its columns among them; one of none without a table."""
    if not columns:
        return [{}]
    if any(each.table is None or each.table.columns is None for each in columns.values()):
        # the values of a table may not be here: they were checked when it was given
        return []
    rows = np.unique(np.column_stack([each.table.values(name) for name, each in columns.items()]), axis=0)
    ends = np.concatenate([rows.argmin(axis=0), rows.argmax(axis=0)])
    between = np.linspace(0, len(rows) - 1, min(len(rows), _MOST_MIXTURES // 2)).round().astype(np.intp)
    places = dict.fromkeys([*ends.tolist(), *between.tolist()])
    return [dict(zip(columns, rows[place].tolist(), strict=True)) for place in places]


def _some(value: Any, count: int) -> list[float]:
    """Return some values of a word, its smallest and its largest among them."""
    if hasattr(value, "array"):
        places = np.linspace(0, len(value) - 1, min(count, len(value))).round().astype(np.intp)
        found: list[float] = value.at(places).tolist()
        return found
    return sorted({*np.linspace(*ends_of(value), count).tolist()})
