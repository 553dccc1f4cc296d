"""Requests for one motion that start from a preset, a spec file or a cell of an atlas, with changed words."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.dataset import spec_of
from sweep.engine.grid import Span, starts_of
from sweep.errors import RequestError
from sweep.model.disk.tables import WOBBLE
from sweep.motion.request import MotionRequest, check_names, known_names, motions_of, request_class
from sweep.motion.tables import MotionKind
from sweep.request.body import of_one_body
from sweep.request.spec import SweepSpec
from sweep.request.spec_file import find_spec_file, place, read_file
from sweep.request.substitutes import changed, check_once, parameter_of
from sweep.request.values import read_number

if TYPE_CHECKING:
    import xarray as xr


def is_preset(word: str) -> bool:
    """Return whether a word of a command line is a preset or a file: it has no ``=``, and is not a name of a word."""
    return "=" not in word and word.strip() not in ("", *known_names())


def request_of_preset(spec: str | Path, words: Mapping[str, Any]) -> MotionRequest:
    """Return the request for one motion of a preset.

    Parameters
    ----------
    spec : str or Path
        Name of a preset, a TOML file, or a file with a system.
    words : mapping of str to anything
        Words of a request for one motion, which replace the words of the file.

    Raises
    ------
    RequestError
        If there is no such file, an axis of it gets no number, or the words make no request.

    Notes
    -----
    A file has axes, but a motion has one start. If the centre of the disk rests and no word gives the precession rate,
    it is the rate of the wobble, which keeps the tilt constant except for losses. Words about the cells of an atlas,
    such as a criterion, are ignored. The duration is that of the file, but at most the default duration of motions.
    For a system, the default of a state or a parameter replaces an axis of the file.
    """
    path = find_spec_file(spec)
    sweep = SweepSpec.read(path)
    check_names(words, motions_of(sweep.model))
    if sweep.is_list:
        raise RequestError(
            f"A motion has one start, but {place(path)} has a list of starts.",
            hint="Compute its atlas, then simulate one of its cells: eulerdisk simulate --from ATLAS.nc start=0.",
        )
    if sweep.model.text:
        names = [*sweep.fixed, *sweep.model.settings]
        of_file = {name: getattr(sweep, name) for name in names}
        return MotionRequest.read(**{**of_file, **words, "model": sweep.model})
    of_file, words = of_one_body(read_file(path), words)
    merged = changed(of_file, words, sweep.model)
    kind = request_class(merged).kind
    open_axes = {
        name: parameter
        for name in merged
        if name not in words and (parameter := parameter_of(name, sweep.model)) in sweep.axes
    }
    motion_words = {
        name: raw for name, raw in merged.items() if name in {*kind.names, *words} and name not in open_axes
    }
    unknown = [*open_axes.values()]
    if "precession_rate" in unknown and merged.get("roll_rate") == WOBBLE:
        motion_words["precession_rate"] = WOBBLE
        unknown.remove("precession_rate")
    if unknown:
        _refuse_open(sweep, path, unknown)
    if "duration" not in words:
        motion_words["duration"] = min(float(kind.inputs["duration"].default), sweep.duration)
    return MotionRequest.read(**motion_words)


def _refuse_open(sweep: SweepSpec, path: Path, names: Sequence[str]) -> None:
    examples = []
    for name in names:
        values = getattr(sweep, name).array()
        quantity = sweep.model.parameters[name]
        middle = float(values[len(values) // 2])
        examples.append(
            f"{name}={math.degrees(middle):.3g}deg" if quantity.units == "rad" else f"{name}={middle:.3g}"
        )
    raise RequestError(
        f"A motion has one start, but {place(path)} has many values of {' and of '.join(names)}.",
        hint=f"Add one of each, as in {' '.join(examples)}.",
        where=names[0],
    )


#: Default duration of a motion in nutation periods, the same as in `explain --plot`.
_PERIODS = 3.0

#: Duration of a motion that falls, over the fall time of the cell: the steps of both differ, and so do the times.
_LATER = 1.01


def cell_and_changes(spec: SweepSpec, words: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the words for the axes of an atlas, which choose a cell, and the words that change the cell's motion.

    Parameters
    ----------
    spec : SweepSpec
        The request of the atlas.
    words : mapping of str to anything
        Words of a request for one motion. Scaled rates and speeds become rates: for the disk of the atlas if they
        choose a cell, for the disk of the motion if they change the motion.

    Raises
    ------
    RequestError
        If the model of the atlas has no motions, or a word is not known.
    """
    kind = motions_of(spec.model)
    # a cell of a list of starts is chosen by its number, an axis that is not a word of motions
    check_names({name: raw for name, raw in words.items() if name not in spec.axes}, kind)
    check_once(words, spec.model)
    # unchanged, because an error about the cell quotes them
    of_axes = {name: raw for name, raw in words.items() if parameter_of(name, spec.model) in spec.axes}
    cell = spec.resolve(of_axes, read_number)
    others = {name: raw for name, raw in words.items() if name not in of_axes}
    resolved = spec.resolve({**cell, **others}, read_number)
    return of_axes, {name: raw for name, raw in resolved.items() if name not in cell}


def request_of_cell(
    atlas: "xr.Dataset", place: Mapping[str, int], changes: Mapping[str, Any]
) -> MotionRequest:
    """Return the request for the motion of a cell: its start, its disk, and the settings of the atlas.

    The duration of an atlas is only an upper limit: 300 s are a thousand periods of a coin. So a motion lasts three
    nutation periods of its cell, or until it ends as its cell does; if the atlas has no values for this start, 10 s
    like other motions. A motion with losses may last for the duration of the atlas, a motion of a system does.

    Parameters
    ----------
    atlas : xarray.Dataset
        A whole atlas.
    place : mapping of str to int
        Axis -> index, in the order of the axes, as from `sweep.atlas.parts.nearest_cell`.
    changes : mapping of str to anything
        Words that replace words of the cell, or that an atlas does not have: ``duration``, ``mass``, ``interval``.

    Raises
    ------
    RequestError
        If a value is not possible, or the cell has no motion.
    """
    spec = spec_of(atlas)
    number = int(np.ravel_multi_index(tuple(place.values()), spec.shape)) if place else 0
    start = words_of_start(
        spec, {name: float(values[0]) for name, values in starts_of(spec, Span(number, number + 1)).items()}
    )
    impossible = [
        name
        for name, value in start.items()
        if not isinstance(value, str) and name not in changes and not np.isfinite(value)
    ]
    if impossible:
        raise RequestError(
            f"This cell has no motion: no {impossible[0]} keeps its tilt constant.",
            hint=f"Choose another cell, or give a rate, such as {impossible[0]}=2.",
            where=impossible[0],
        )
    # the changes may add losses to a cell without losses
    model = {"model": spec.model} if spec.model.text else {}
    start, changes = of_one_body(start, changes)
    kind = request_class({**start, **changes, **model}).kind
    start = {name: value for name, value in start.items() if name in kind.names}
    settings = {name: getattr(spec, name) for name in spec.model.settings if name in kind.names}
    # another start or disk has another period, and a motion with losses continues to its end
    same = spec.model.parameters.keys().isdisjoint(changes) and not kind.stops
    shown = _PERIODS * _period(atlas, place) if same else np.nan
    if not model and same and _ends_by_itself(atlas, place, kind):
        # the motion ends by itself
        settings["duration"] = max(spec.duration, _LATER * _fall_time(atlas, place))
    elif not model:
        settings["duration"] = min(
            shown if np.isfinite(shown) else float(kind.inputs["duration"].default), spec.duration
        )
    return MotionRequest.read(**{**start, **settings, **changes, **model})


def words_of_start(spec: SweepSpec, start: Mapping[str, float]) -> dict[str, Any]:
    """Return the words of a motion for the body and the start of a cell, from all its parameters in SI."""
    # an unlimited friction coefficient, or a length that a body does not have, has a word but no number
    words = {name: getattr(spec, name) for name in (*spec.constants, *spec.model.options)}
    kind = motions_of(spec.model)
    return {name: value for name, value in {**start, **words}.items() if name in kind.names}


def _ends_by_itself(atlas: "xr.Dataset", place: Mapping[str, int], kind: MotionKind) -> bool:
    """Return whether a cell has an ending that ends its motion: a fall, or a change of edges."""
    ending = spec_of(atlas).model.variables["ending"].flag(_value(atlas, "ending", place))
    return ending in kind.endings


def _fall_time(atlas: "xr.Dataset", place: Mapping[str, int]) -> float:
    """Return the fall time of a cell [s]; 0 if it does not fall."""
    return float(np.nan_to_num(_value(atlas, "fall_time", place)))


def _period(atlas: "xr.Dataset", place: Mapping[str, int]) -> float:
    """Return the nutation period [s] of a cell; NaN if it has none, because it fell or ran out of time."""
    return _value(atlas, "nutation_period", place)


def _value(atlas: "xr.Dataset", name: str, place: Mapping[str, int]) -> float:
    """Return the value of a variable in a cell; NaN if the atlas lacks the variable."""
    if name not in atlas:
        return np.nan
    values = atlas[name]
    return float(np.asarray(values[tuple(place[str(dim)] for dim in values.dims)]))
