"""The request for an atlas: which cells, how they are integrated, and what counts as unstable.

The same words in Python, in TOML and on the command line::

    SweepSpec(roll_rate="0.5:6:400", tilt="0.01deg:20deg:300:log", alpha=1)
    SweepSpec.from_toml("hoop.toml")
    SweepSpec.from_words("rolling", ["alpha=1", "criterion=departure:2deg"])
"""

import hashlib
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NoReturn, Self

from pydantic import BaseModel, ConfigDict, model_validator

from sweep.errors import RequestError, shown
from sweep.request.criterion import Criterion
from sweep.request.quantities import Range, Value, Values
from sweep.request.rules import check_circling, check_size, check_steps
from sweep.request.unknown import unknown_word
from sweep.request.words import find_spec_file, place, read_file, read_word, split_words
from sweep.schema import GRID, PARAMETERS, SETTINGS, STEADY_PRECESSION, STEADY_ROLL, WORDS

#: Words that came after the first files.
_YOUNGER = ("contact", "boundary", "device")

#: (whether the disk rolls, whether it precesses) -> what it does.
_MOTIONS = {
    (True, False): "Rolling along a line",
    (False, True): "Spinning about the vertical",
    (True, True): "Rolling and precessing",
    (False, False): "Neither rolling nor spinning",
}

_NAMES = (*PARAMETERS, *SETTINGS, *WORDS)


class SweepSpec(BaseModel):
    """A grid of starts, how each is integrated, and the criterion of stability. It cannot be changed.

    Parameters
    ----------
    tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity
        A number, or a list or a range (an axis), in SI or as text with units. Axes are the dimensions of the atlas in
        the order given. `roll_rate` may be ``"steady"``: the rate that keeps the tilt constant, computed per cell.
        Instead `precession_rate` may be ``"steady-slow"`` or ``"steady-fast"``: the smaller or the larger of the two
        rates that keep the tilt constant at a given `roll_rate`.
    criterion : Criterion or str
        What counts as unstable, e.g. ``departure:5deg``.
    duration, step : float or str
        Longest time simulated for a cell, and time step, s; a step of ``"auto"`` is the engine's own.
    fall_tilt, tolerance : float or str
        Tilt at which the disk counts as fallen, and error that the gauges of a cell may show before its step is
        reduced, rad.
    method, device, title : str
        ``rk4`` or ``exact``; ``cpu`` or ``cuda``; what the atlas is about, in one line.
    contact : str
        ``yes`` also records the least normal force and the largest friction coefficient needed.
    boundary : str
        ``grid``: the boundary lies between neighbouring cells; ``refined`` or ``refined:WIDTH``: it is bisected
        until its bracket is no wider than WIDTH in the SI unit of the axis, and stored as curves too.
    axes : sequence of str, optional
        The order of the axes, if it is not the order given.

    Raises
    ------
    RequestError
        If a word is not known, a value is not possible, or values do not go together.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    axes: tuple[str, ...]
    tilt: Value
    tilt_rate: Value
    precession_rate: Value | Literal["steady-slow", "steady-fast"]
    roll_rate: Value | Literal["steady"]
    alpha: Value
    radius: Value
    gravity: Value
    criterion: Criterion
    duration: float
    step: float | Literal["auto"]
    fall_tilt: float
    tolerance: float
    method: str
    contact: str
    boundary: str
    device: str
    title: str

    def __init__(self, **words: Any) -> None:
        super().__init__(**words)

    @model_validator(mode="before")
    @classmethod
    def _read(cls, words: Any) -> dict[str, object]:
        # All reading is done here, ahead of pydantic, whose own messages do not say what to do.
        for name in words:
            if name not in _NAMES and name != "axes":
                unknown_word(name, _NAMES)
        values = _defaults() | {name: read_word(name, raw) for name, raw in words.items() if name != "axes"}
        given = tuple(name for name in words if isinstance(values.get(name), Range | Values))
        values["axes"] = _read_axes(words.get("axes", given), given)
        check_circling(values)
        check_steps(values)
        check_size([len(values[name]) for name in given])
        return values

    def __setattr__(self, name: str, value: object) -> NoReturn:
        """Refuse a change."""
        raise RequestError(
            "a spec cannot be changed",
            "one spec stands for one atlas",
            f"{name}={shown(value)}",
            f"make another one with spec.replace({name}=...)",
            name,
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each of `axes`; () for a single cell."""
        return tuple(len(getattr(self, name)) for name in self.axes)

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @property
    def circling(self) -> bool:
        """Whether each cell has the rates that keep its tilt: its steady tilt is its tilt, otherwise 0."""
        return self.computed_rate is not None

    @property
    def computed_rate(self) -> str | None:
        """Name of the rate that is computed per cell so that its tilt stays constant; None if all are given."""
        if self.roll_rate == STEADY_ROLL:
            return "roll_rate"
        return "precession_rate" if self.precession_rate in STEADY_PRECESSION else None

    @property
    def headline(self) -> str:
        """The title; where none was given, what is looked at, which follows from the rates."""
        if self.title:
            return self.title
        if self.circling:
            return "Circling at constant tilt: stability of the steady motion"
        rolls, turns = (getattr(self, name) != 0.0 for name in ("roll_rate", "precession_rate"))
        return f"{_MOTIONS[rolls, turns]}: stability of the upright disk"

    @property
    def boundary_width(self) -> float | None:
        """Width [SI unit of the axis] to which the boundary is bisected; None where the grid's own will do."""
        return None if self.boundary == GRID else float(self.boundary.partition(":")[2])

    @classmethod
    def preset(cls, name: str) -> Self:
        """Return one of the specs that come with the package: rolling, spinning, circling.

        Raises
        ------
        RequestError
            If there is no such preset.
        """
        return cls.from_words(name, ())

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Return the spec in a TOML file.

        Raises
        ------
        RequestError
            If the file cannot be read, is not TOML, or is not a request.
        """
        return cls.from_words(Path(path), ())

    @classmethod
    def from_words(cls, spec: str | Path, words: Sequence[str]) -> Self:
        """Return the spec of a preset or a TOML file, with changes.

        Parameters
        ----------
        spec : str or Path
            Name of a preset, or a file.
        words : sequence of str
            ``NAME=VALUE``, each name once. A name that the file has keeps its place there (and so among the axes);
            new ones follow in the order given.

        Raises
        ------
        RequestError
            If the file or a word cannot be read, or the result is not a request.
        """
        path = find_spec_file(spec)
        changes = split_words(words, _NAMES)
        try:
            return cls(**{**read_file(path), **changes})
        except RequestError as error:
            if error.where in changes or error.where is None or error.where == str(path):
                raise
            raise error.at(f"{place(path)}: {error.where}") from None

    def replace(self, **changes: Any) -> Self:
        """Return this spec with other values; its axes keep their places, new ones follow in the order given.

        Raises
        ------
        RequestError
            If the result is not a request.
        """
        words = self._words()
        kept = {name: words[name] for name in words if name in self.axes or name not in changes}
        return type(self)(**{**kept, **changes})

    def to_toml(self) -> str:
        """Return the text of a TOML file from which `from_toml` makes the same spec."""
        units = {name: quantity.units for name, quantity in {**PARAMETERS, **SETTINGS}.items()}
        return "".join(
            f"{name} = {_toml(value)}" + (f"  # {units[name]}\n" if units.get(name, "1") != "1" else "\n")
            for name, value in self._words().items()
        )

    def canonical(self) -> str:
        """Return the spec as ASCII JSON with sorted keys, numbers in SI, the same text for equal specs."""
        # younger than the first files: left out where it says nothing, so that their texts and fingerprints stay
        silent = {name for name in _YOUNGER if getattr(self, name) == WORDS[name].default}
        words = self.model_dump(mode="json", exclude=silent)
        return json.dumps(words, sort_keys=True, separators=(",", ":"), allow_nan=False)

    def fingerprint(self) -> str:
        """Return the SHA-256 of `canonical`, in hexadecimal."""
        return hashlib.sha256(self.canonical().encode("ascii")).hexdigest()

    @classmethod
    def from_canonical(cls, text: str) -> Self:
        """Return the spec that `canonical` wrote.

        Raises
        ------
        RequestError
            If the text is not that of a spec.
        """
        try:
            words = {name: _from_json(value) for name, value in json.loads(text).items()}
            # a word that a later version brought is not in an older atlas: it has its default there
            if {"axes", "criterion", *PARAMETERS} <= words.keys() <= cls.model_fields.keys():
                return cls(**words)
            raise ValueError("words are missing or unknown")
        except (ValueError, TypeError, AttributeError) as problem:
            raise RequestError(
                "not the canonical text of a spec",
                "it is what SweepSpec.canonical() wrote",
                shown(text),
                "take the text unchanged from the atlas",
            ) from problem

    def _words(self) -> dict[str, object]:
        # Axes first: their order is the order of the words.
        return {name: getattr(self, name) for name in dict.fromkeys(("title", *self.axes, *_NAMES))}


def _defaults() -> dict[str, Any]:
    numbers = {name: read_word(name, row.default) for name, row in {**PARAMETERS, **SETTINGS}.items()}
    return numbers | {name: read_word(name, row.default) for name, row in WORDS.items()}


def _read_axes(order: object, given: tuple[str, ...]) -> tuple[str, ...]:
    names = order.split(",") if isinstance(order, str) else order
    if isinstance(names, Sequence) and sorted(map(str, names)) == sorted(given):
        return tuple(map(str, names))
    raise RequestError(
        "not an order of the axes",
        "axes holds the names given as a list or a range, each once",
        f"axes={shown(order)} with {', '.join(given) or 'no axis'}",
        "leave it out: the order given is the order of the axes",
        "axes",
    )


def _toml(value: object) -> str:
    if isinstance(value, Values):
        return "[" + ", ".join(map(repr, value.values)) + "]"
    # JSON's strings are TOML's, as long as nothing outside ASCII is escaped in pairs.
    return repr(value) if isinstance(value, float) else json.dumps(str(value), ensure_ascii=False)


def _from_json(value: Any) -> object:
    if not isinstance(value, dict):
        return value
    if "kind" in value:
        return Criterion(**value)
    return Range(**value) if "count" in value else Values(**value)
