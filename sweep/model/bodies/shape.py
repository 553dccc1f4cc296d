"""The bodies of a request: the checks of its words, and the body and the rates of each start."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kernels.bodies import arrays, shapes, steady
from kernels.bodies.shapes import Body
from sweep.errors import RequestError
from sweep.model.bodies.tables import CALLED, LENGTHS, NONE, OF_THE_BODY, OPTIONAL, PARAMETERS
from sweep.model.description import Request, Starts
from sweep.model.disk.initial_conditions import circling
from sweep.model.disk.tables import WOBBLE
from sweep.model.quantity import Array, Input, Truths
from sweep.model.rows import LARGEST, LEAST, SIZE, ends_of, spell_values, worst_cases

#: Thickest disk with a semicircular edge: two radii, a ball.
_THICKEST_ROUNDED = 2.0

#: Tilt [rad] beyond which a spheroid counts as standing on its end.
_ON_END = 0.25 * np.pi


def check_shape(
    values: Mapping[str, Any], optional: tuple[str, ...] = OPTIONAL, known: tuple[str, ...] = tuple(LENGTHS)
) -> None:
    """Refuse lengths and moments that do not describe one body.

    Parameters
    ----------
    values : mapping of str to value
        The value of every word of a request.
    optional : tuple of str
        Lengths that default to 0.
    known : tuple of str
        Bodies that hints may name.

    Raises
    ------
    RequestError
    """
    body = str(values["body"])
    _check_lengths(values, body, optional, known)
    if body == "rounded":
        wrong = worst_cases(values, {"thickness": LARGEST})["thickness"] > _THICKEST_ROUNDED
        if wrong.any():
            _refuse(
                f"A disk with a semicircular edge is at most two radii thick (a ball); got "
                f"{spell_values(values, wrong, 'thickness')}.",
                "Give 0 <= thickness <= 2, in radii, or body=rim.",
                "thickness",
            )
    if body == "rim":
        _check_rim(values)
    if body == "arc":
        _check_arc(values)
    if has_poles(body):
        _check_round(values, body)
    _check_moments(values)


def _refuse(message: str, hint: str, where: str) -> None:
    raise RequestError(message, hint=hint, where=where)


def _check_lengths(
    values: Mapping[str, Any], body: str, optional: tuple[str, ...], known: tuple[str, ...]
) -> None:
    for name in dict.fromkeys(name for lengths in LENGTHS.values() for name in lengths):
        if name in LENGTHS[body] and name not in optional and values[name] == NONE:
            _refuse(
                f"A {CALLED[body]} needs its {name}, over the outer radius or with a unit of length; got body={body} "
                "without it.",
                f"Give {name}=0.2, for instance.",
                name,
            )
        if name not in LENGTHS[body] and values[name] != NONE:
            having = " or ".join(f"body={other}" for other in known if name in LENGTHS[other])
            _refuse(
                f"A {CALLED[body]} has no {name}; it has {' and '.join(LENGTHS[body])}. Got body={body} "
                f"{name}={values[name]}.",
                f"Leave {name} out, or write {having}." if having else f"Leave {name} out.",
                name,
            )
    if values["filling"] != "solid" and body != "torus":
        _refuse(
            f"Only a torus is solid or hollow; got body={body} filling={values['filling']}.",
            "Leave filling out, and give axial_moment and transverse_moment.",
            "filling",
        )


def _check_rim(values: Mapping[str, Any]) -> None:
    worst = worst_cases(values, {"thickness": LEAST, "fillet": LARGEST})
    if (wrong := worst["thickness"] == 0.0).any():
        _refuse(
            f"A disk with a rim is thicker than 0; got {spell_values(values, wrong, 'thickness')}.",
            "Give thickness > 0, or leave body out for the thin disk.",
            "thickness",
        )
    if (wrong := worst["fillet"] > 0.5 * worst["thickness"]).any():
        _refuse(
            "The fillet of a rim is at most half its thickness: 0 <= fillet <= thickness/2; got "
            f"{spell_values(values, wrong, 'fillet', 'thickness')}.",
            "Give a smaller fillet, or leave it out and say body=rounded, whose edge is a semicircle.",
            "fillet",
        )


def _check_arc(values: Mapping[str, Any]) -> None:
    if OF_THE_BODY in (values["axial_moment"], values["transverse_moment"]):
        _refuse(
            "An arc is only the edge of a body, so the moments of the body do not follow from it; got body=arc without "
            "both moments.",
            "Give axial_moment and transverse_moment, about the centre of mass and over mass times radius squared.",
            "axial_moment",
        )


def _check_round(values: Mapping[str, Any], body: str) -> None:
    given = [name for name in ("axial_moment", "transverse_moment") if values[name] != OF_THE_BODY]
    offset = values["offset"]
    if off_centre(offset) and len(given) < 2:
        _refuse(
            f"The moments of a {body} do not follow from its shape if its centre of mass is not at its centre; got "
            f"offset={offset}.",
            "Give axial_moment and transverse_moment, about the centre of mass and over mass times radius squared.",
            "offset",
        )
    of_ball = body == "ball"
    names = ("offset",) if of_ball else ("offset", "flattening")
    inside = np.asarray(1.0) if of_ball else 1.0 - worst_cases(values, {"flattening": LARGEST})["flattening"]
    wrong = np.abs(worst_cases(values, {"offset": SIZE})["offset"]) >= inside
    if wrong.any():
        pole = np.broadcast_to(inside, wrong.shape)[wrong][0]
        _refuse(
            f"The centre of mass of a {body} lies inside: -{pole:.6g} < offset < {pole:.6g}, between the poles; got "
            f"{spell_values(values, wrong, *names)}.",
            f"Give a smaller {' or '.join(names)}, over the outer radius.",
            "offset",
        )


def check_no_fall(values: Mapping[str, Any], setting: Input) -> None:
    """Refuse a fall tilt and a time of fall for a ball or a spheroid, which cannot fall.

    Parameters
    ----------
    values : mapping of str to value
        The value of every word of a request.
    setting : Input
        The row of the fall tilt.

    Raises
    ------
    RequestError
    """
    body, name = str(values["body"]), setting.name
    if has_poles(body) and values[name] != setting.default:
        got, default = (setting.spell(float(tilt), 6) for tilt in (values[name], setting.default))
        _refuse(
            f"A {body} does not fall: it rolls on through its poles, so {name} does not apply; got {name}={got}.",
            f"Leave {name} out, or at its default, {default}.",
            name,
        )
    # a motion has no criterion
    criterion = values.get("criterion")
    if has_poles(body) and getattr(criterion, "kind", "") == "aloft":
        _refuse(
            f"A {body} does not fall: by the criterion {criterion} all its motions are stable.",
            "Write another criterion, such as departure:5deg.",
            "criterion",
        )


def _check_moments(values: Mapping[str, Any]) -> None:
    axial, transverse = values["axial_moment"], values["transverse_moment"]
    if OF_THE_BODY in (axial, transverse):
        return
    worst = worst_cases(values, {"axial_moment": LARGEST, "transverse_moment": LEAST})
    wrong = worst["axial_moment"] > 2.0 * worst["transverse_moment"]
    if wrong.any():
        _refuse(
            "The axial moment of a body is at most twice the transverse one: 0 < axial_moment <= 2 "
            "transverse_moment, with equality for a plane body; got "
            f"{spell_values(values, wrong, 'axial_moment', 'transverse_moment')}.",
            "Give a smaller axial_moment or a larger transverse_moment.",
            "axial_moment",
        )


def has_poles(body: str) -> bool:
    """Return whether a body rolls on through its poles: a ball or a spheroid."""
    return shapes.NAMES.index(body) >= shapes.FIRST_WITH_POLES


def off_centre(offset: Any) -> bool:
    """Return whether the value of the offset puts the centre of mass off the centre."""
    return ends_of(offset) != (0.0, 0.0)


def on_end(spec: Request, starts: Mapping[str, Any]) -> Truths:
    """Return which starts disturb a body that spins on its end, with its axis vertical.

    These are all starts of a ball that does not circle, and the starts of a spheroid whose axis is nearer to the
    vertical than to the horizontal, or which is not in balance upright.
    """
    tilt = np.asarray(starts["tilt"])
    if circling(spec) or not has_poles(spec.body):
        return np.zeros(tilt.shape, bool)
    if spec.body == "ball":
        return np.ones(tilt.shape, bool)
    offset = 0.0 if spec.offset == NONE else np.asarray(starts["offset"])
    return np.asarray((np.abs(tilt) > _ON_END) | (offset != 0.0))


def all_on_end(spec: Request) -> bool:
    """Return whether all starts of a spec are `on_end`, by their tilts and offsets."""
    return any(cells.all() for cells in _on_end_by(spec))


def may_be_on_end(spec: Request) -> bool:
    """Return whether some starts of a spec may be `on_end`, by their tilts and offsets."""
    return any(cells.any() for cells in _on_end_by(spec))


def _on_end_by(spec: Request) -> tuple[Truths, Truths]:
    """Return which tilts are `on_end` without an offset, and which offsets are `on_end` upright: either is enough."""
    tilts, offsets = _some(spec.tilt), _some(spec.offset)
    of_tilts = on_end(spec, {"tilt": tilts, "offset": np.zeros_like(tilts)})
    return of_tilts, on_end(spec, {"tilt": np.zeros_like(offsets), "offset": offsets})


def _some(value: Any) -> Array:
    """Return the values of a word; for random values or a column of a table, some values between its ends."""
    return np.asarray(value.array() if hasattr(value, "array") else np.linspace(*ends_of(value), 101))


def moments(body: str, filling: str, starts: Starts) -> tuple[Array, Array]:
    """Return the axial and the transverse moment over m R^2 of homogeneous bodies with the lengths of starts."""
    if body == "torus":
        axial, transverse = shapes.torus_moments(starts["tube"], filling == "hollow")
        return axial, transverse
    if body == "ball":
        return np.full_like(starts["offset"], 0.4), np.full_like(starts["offset"], 0.4)
    if body == "spheroid":
        axial, transverse = shapes.spheroid_moments(starts["flattening"])
        return axial, transverse
    thickness = starts["thickness"]
    axial, transverse = shapes.solid_moments(
        thickness, 0.5 * thickness if body == "rounded" else starts["fillet"]
    )
    return axial, transverse


def body_of(spec: Request, starts: Starts) -> Body:
    """Return the constants of the bodies of starts: arrays, shape (n,) each."""
    number = shapes.NAMES.index(spec.body)
    core, shift, edge, square = shapes.arc_of(
        number, *(starts[name] for name in ("tube", "thickness", "fillet", "offset", "flattening"))
    )
    if spec.body == "rim":
        shift = np.where(starts["tilt"] < 0.0, -shift, shift)
    axial, transverse = (starts[name] for name in ("axial_moment", "transverse_moment"))
    with np.errstate(divide="ignore", invalid="ignore"):
        return Body(core, shift, edge, square, axial, transverse, axial / transverse)


def with_body(spec: Request, starts: Starts) -> dict[str, Array]:
    """Return starts with 0 for lengths that their bodies do not have, and with the moments of homogeneous bodies."""
    completed = dict(starts)
    for name in {name for lengths in LENGTHS.values() for name in lengths}:
        if getattr(spec, name) == NONE:
            completed[name] = np.zeros_like(starts["radius"])
    if OF_THE_BODY in (spec.axial_moment, spec.transverse_moment):
        both = zip(
            ("axial_moment", "transverse_moment"), moments(spec.body, spec.filling, completed), strict=True
        )
        completed |= {name: value for name, value in both if getattr(spec, name) == OF_THE_BODY}
    return completed


def complete(spec: Request, starts: Starts) -> Starts:
    """Return starts with the moments of their bodies, and the rates that keep the tilt of each cell constant.

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array, shape (n,)
        Every parameter except those that the request leaves to the cell, in SI.
    """
    completed, tilt = with_body(spec, starts), starts["tilt"]
    if not (isinstance(spec.precession_rate, str) or isinstance(spec.roll_rate, str)):
        return completed
    body, unit = body_of(spec, completed), np.sqrt(starts["radius"] / starts["gravity"])
    with np.errstate(divide="ignore", invalid="ignore"):
        if spec.precession_rate == WOBBLE:
            completed["precession_rate"] = np.sqrt(steady.wobble_square(tilt, body)) / unit
        if isinstance(spec.roll_rate, str):
            precession = unit * completed["precession_rate"]
            along = precession * np.cos(tilt)
            if spec.roll_rate == WOBBLE:
                spin = steady.centred_spin(tilt, along, body)
            else:
                spin = steady.steady_spin(tilt, along, body)
            completed["roll_rate"] = (spin - precession * np.sin(tilt)) / unit
    return completed


def scaled_rates(spec: Request, start: Starts) -> tuple[Any, Any]:
    """Return the scaled rates (o, s) of the undisturbed motion of starts: upright, or circling at their tilt."""
    tilt = start["tilt"] if circling(spec) else 0.0 * start["tilt"]
    unit = np.sqrt(start["radius"] / start["gravity"])
    o = unit * start["precession_rate"] * np.cos(tilt)
    return o, unit * (start["roll_rate"] + start["precession_rate"] * np.sin(tilt))


assert tuple(PARAMETERS) == arrays.PARAMETERS
