"""The request for one motion that begins with a preset, a spec file or a cell of an atlas, changed by other words."""

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
    """Return whether a word of a command line names a preset or a file: it has no value, and is no name of one."""
    return "=" not in word and word.strip() not in ("", *known_names())


def request_of_preset(spec: str | Path, words: Mapping[str, Any]) -> MotionRequest:
    """Return the request for one motion of a preset.

    Parameters
    ----------
    spec : str or Path
        Name of a preset, a TOML file, or a file with a system.
    words : mapping of str to anything
        Words of a request for one motion, which replace those of the file.

    Raises
    ------
    RequestError
        If there is no such file, an axis of it is left without a number, or the result is no request.

    Notes
    -----
    A file has axes, and a motion has one start. If the centre of the disk rests and no word gives the precession rate,
    it is that of the wobble, which keeps the tilt except for losses. Words about cells of an atlas, such as a
    criterion, are left out. The duration is that of the file, but at most that of any other motion. A system has a
    value for each of its words, which replaces an axis of its file that is not given.
    """
    path = find_spec_file(spec)
    sweep = SweepSpec.read(path)
    check_names(words, motions_of(sweep.model))
    if sweep.is_list:
        raise RequestError(
            f"A motion has one start, and {place(path)} has a list of them.",
            hint="Compute its atlas, and follow one of its cells: eulerdisk simulate --from ATLAS.nc start=0.",
        )
    if sweep.model.text:
        names = [*sweep.fixed, *sweep.model.settings]
        held = {name: getattr(sweep, name) for name in names}
        return MotionRequest.read(**{**held, **words, "model": sweep.model})
    held, words = of_one_body(read_file(path), words)
    merged = changed(held, words, sweep.model)
    kind = request_class(merged).kind
    open_axes = {
        name: parameter
        for name in merged
        if name not in words and (parameter := parameter_of(name, sweep.model)) in sweep.axes
    }
    found = {
        name: raw for name, raw in merged.items() if name in {*kind.names, *words} and name not in open_axes
    }
    unknown = [*open_axes.values()]
    if "precession_rate" in unknown and merged.get("roll_rate") == WOBBLE:
        found["precession_rate"] = WOBBLE
        unknown.remove("precession_rate")
    if unknown:
        _refuse_open(sweep, path, unknown)
    if "duration" not in words:
        found["duration"] = min(float(kind.inputs["duration"].default), sweep.duration)
    return MotionRequest.read(**found)


def _refuse_open(sweep: SweepSpec, path: Path, names: Sequence[str]) -> None:
    examples = []
    for name in names:
        values = getattr(sweep, name).array()
        quantity = sweep.model.parameters[name]
        text = quantity.spell(float(values[len(values) // 2]), 3).replace(" ", "")
        examples.append(f"{name}={text if quantity.units == 'rad' else text.partition('rad')[0]}")
    raise RequestError(
        f"A motion has one start, and {place(path)} has many values of {' and of '.join(names)}.",
        hint=f"Add one of each, as in {' '.join(examples)}.",
        where=names[0],
    )


#: Nutation periods that a motion lasts if no duration is given: as many as `explain --plot` draws.
_PERIODS = 3.0

#: Time until a fall that is followed, over that which the cell states: both are found with steps of their own.
_LATER = 1.01


def cell_and_changes(spec: SweepSpec, words: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the words that name a cell of an atlas, which are those of its axes, and the words that change its motion.

    Parameters
    ----------
    spec : SweepSpec
        The request of the atlas.
    words : mapping of str to anything
        Words of a request for one motion. Scaled rates and speeds become rates: those that name a cell for the disk
        of the atlas, those that change the motion for the disk that moves.

    Raises
    ------
    RequestError
        If the model of the atlas has no motions, or a word is not known.
    """
    kind = motions_of(spec.model)
    # of a list of starts a cell is named by its number
    check_names({name: raw for name, raw in words.items() if name not in spec.axes}, kind)
    check_once(words, spec.model)
    named = {name: raw for name, raw in words.items() if parameter_of(name, spec.model) in spec.axes}
    # as given: a refusal of the cell says its words
    cell = spec.resolve(named, read_number)
    others = {name: raw for name, raw in words.items() if name not in named}
    found = spec.resolve({**cell, **others}, read_number)
    return named, {name: raw for name, raw in found.items() if name not in cell}


def request_of_cell(
    atlas: "xr.Dataset", place: Mapping[str, int], changes: Mapping[str, Any]
) -> MotionRequest:
    """Return the request for the motion of a cell: its start, its disk, and the settings of the atlas.

    The duration of an atlas is the longest time that a cell may take: 300 s are a thousand periods of a coin. Instead
    a motion lasts three nutation periods of its cell, or until it ends as its cell does; where the atlas knows nothing
    of this start, 10 s as any other one.
    One with losses may take the duration of the atlas, to its end; one of a system takes it.

    Parameters
    ----------
    atlas : xarray.Dataset
        A whole one.
    place : mapping of str to int
        Axis -> index, in the order of the axes, as from `sweep.atlas.parts.nearest_cell`.
    changes : mapping of str to anything
        Words that replace those of the cell, or that an atlas does not have: ``duration``, ``mass``, ``interval``.

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
    none = [
        name
        for name, value in start.items()
        if not isinstance(value, str) and name not in changes and not np.isfinite(value)
    ]
    if none:
        raise RequestError(
            f"This cell has no motion: no {none[0]} keeps its tilt constant.",
            hint=f"Name another cell, or give a rate, as in {none[0]}=2.",
            where=none[0],
        )
    # a cell without losses may be followed with losses
    model = {"model": spec.model} if spec.model.text else {}
    start, changes = of_one_body(start, changes)
    kind = request_class({**start, **changes, **model}).kind
    start = {name: value for name, value in start.items() if name in kind.names}
    settings = {name: getattr(spec, name) for name in spec.model.settings if name in kind.names}
    # another start or another disk has another period, and a motion with losses is followed to its end
    same = spec.model.parameters.keys().isdisjoint(changes) and not kind.stops
    shown = _PERIODS * _period(atlas, place) if same else np.nan
    if not model and same and _comes_to_an_end(atlas, place, kind):
        # the motion ends by itself
        settings["duration"] = max(spec.duration, _LATER * _fall_time(atlas, place))
    elif not model:
        settings["duration"] = min(
            shown if np.isfinite(shown) else float(kind.inputs["duration"].default), spec.duration
        )
    return MotionRequest.read(**{**start, **settings, **changes, **model})


def words_of_start(spec: SweepSpec, start: Mapping[str, float]) -> dict[str, Any]:
    """Return the words of a motion that say what moves and how it starts, of a cell with all parameters in SI."""
    # a friction coefficient without a limit, or a length that a body does not have, is no number that one can say
    said = {name: getattr(spec, name) for name in (*spec.constants, *spec.model.options)}
    kind = motions_of(spec.model)
    return {name: value for name, value in {**start, **said}.items() if name in kind.names}


def _comes_to_an_end(atlas: "xr.Dataset", place: Mapping[str, int], kind: MotionKind) -> bool:
    """Return whether a cell has an ending that ends its motion: a fall, or a change of edges."""
    ending = spec_of(atlas).model.variables["ending"].flag(_value(atlas, "ending", place))
    return ending in kind.endings


def _fall_time(atlas: "xr.Dataset", place: Mapping[str, int]) -> float:
    """Return when a cell falls [s], by the exact reduction also later than the duration; 0 if it does not."""
    return float(np.nan_to_num(_value(atlas, "fall_time", place)))


def _period(atlas: "xr.Dataset", place: Mapping[str, int]) -> float:
    """Return the nutation period [s] of a cell; NaN if the atlas has none: of a fall, or where time ended it."""
    return _value(atlas, "nutation_period", place)


def _value(atlas: "xr.Dataset", name: str, place: Mapping[str, int]) -> float:
    """Return what a cell has of a variable; NaN if the atlas has none."""
    if name not in atlas:
        return np.nan
    values = atlas[name]
    return float(np.asarray(values[tuple(place[str(dim)] for dim in values.dims)]))
