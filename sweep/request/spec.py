"""The request for an atlas: which cells, how they are integrated, and what counts as unstable.

The same words in Python, in TOML and on the command line::

    SweepSpec(roll_rate="0.5:6:400", tilt="0.01deg:20deg:300:log", alpha=1)
    SweepSpec.from_toml("hoop.toml")
    SweepSpec.from_words("rolling", ["alpha=1", "criterion=departure:2deg"])
"""

import hashlib
import json
import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import Any, NoReturn, Self

from sweep.errors import RequestError, as_path, shown
from sweep.model import registry
from sweep.model.description import Model
from sweep.model.quantity import Input, Quantity, Word
from sweep.request.body import check_body_named, of_one_body, thin_model, without_thin_body
from sweep.request.criterion import Criterion
from sweep.request.sources import Distribution, Range, Values
from sweep.request.spec_file import SWEEP_TABLES, find_spec_file, place, read_file
from sweep.request.start_list import START, WORDS, implied, with_list
from sweep.request.start_table import Column, StartTable, table_for
from sweep.request.substitutes import changed, parameter_of, resolved, substitutes_in
from sweep.request.system_model import names_file, with_system
from sweep.request.values import Value, at_word, read_value
from sweep.request.words import (
    GRID,
    check_known,
    check_method,
    check_size,
    check_steps,
    given_in,
    model_for,
    names,
    options,
    pairs,
    read_axes,
    read_word,
    with_table,
)


class SweepSpec:
    """A grid or a list of starts, how each is integrated, and the criterion of stability. It cannot be changed.

    Parameters
    ----------
    tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity
        A number, or a list or a range (an axis), in SI or as text with units. Axes are the dimensions of the atlas in
        the order given. `roll_rate` may be ``"steady"``: the rate that keeps the tilt constant, computed per cell.
        Instead `precession_rate` may be ``"steady-slow"`` or ``"steady-fast"``: the smaller or the larger of the two
        rates that keep the tilt constant at a given `roll_rate`. Another model has parameters of its own.
        With ``samples`` a distribution too: ``uniform:LOW:HIGH``, ``loguniform:LOW:HIGH``, ``normal:MEAN:DEVIATION``.
    samples, seed : int or str
        How many random starts are drawn, and which ones: then the only dimension of the atlas is `start`.
    starts : str, Path or mapping of str to array
        Starts that are given one by one, in place of random ones: a CSV file, or columns called like the parameters,
        in SI or with a unit as in ``tilt [deg]``; a pandas.DataFrame too. The others have one number each.
    start : str or sequence of int, optional
        The numbers of the starts that are meant, if not all of them.
    scaled_tilt_rate, scaled_precession_rate, scaled_roll_rate, speed
        Instead of a rate: the rate in units of sqrt(gravity/radius), a pure number; instead of `roll_rate`: the speed
        of the contact point along its path, roll_rate * radius, m/s. The spec holds the rate, in rad/s. Not where
        gravity or radius varies.
    criterion : Criterion or str
        What counts as unstable: ``departure:5deg``, ``amplification:10``, ``aloft:10s``, or an expression over the
        variables of a cell such as ``peak_tilt > 10deg or fall_time < 2s`` (docs/atlas.md).
    duration, step : float or str
        Longest time simulated for a cell, and time step, s; a step of ``"auto"`` is the engine's own.
    fall_tilt, tolerance : float or str
        Tilt at which the disk counts as fallen, and largest estimated error of a cell before its step is
        reduced, rad.
    method, device, title : str
        ``rk4`` or ``exact``, of a system ``taylor``; ``cpu`` or ``cuda``; what the atlas is about, in one line.
    contact : str
        ``yes`` also records the least normal force and the largest friction coefficient needed.
    path : str
        ``yes`` also records where the contact point goes (docs/bodies.md).
    boundary : str
        ``grid``: the boundary lies between neighbouring cells; ``refined`` or ``refined:WIDTH``: it is bisected
        until its bracket is no wider than WIDTH in the SI unit of the axis, and stored as curves too.
    body : str
        What rolls, if not the thin disk: ``torus``, ``rounded``, ``rim``, ``arc``, ``ball`` or ``spheroid``, with
        ``tube``, ``filling``, ``thickness``, ``fillet``, ``offset``, ``flattening``, ``axial_moment`` and
        ``transverse_moment`` (docs/bodies.md).
    model : str
        The model that is integrated; if not given the one that a word chooses, the disk with losses by any
        of its own (docs/losses.md), another body by any of its own, a body with losses by words of both, else the disk.
    axes : sequence of str, optional
        The order of the axes, if it is not the order given.

    Attributes
    ----------
    model : Model
    axes : tuple of str
    criterion : Criterion
    substitutes : mapping of str to str
        The words given that stand for a parameter, such as `speed`, as they were given: reports use them.

    Raises
    ------
    RequestError
        If a word is not known, a value is not possible, or values do not go together.
    """

    model: Model
    axes: tuple[str, ...]
    criterion: Criterion
    duration: float
    tolerance: float
    title: str
    method: str
    boundary: str
    device: str
    substitutes: Mapping[str, str]
    _values: Mapping[str, Any]

    # the names of words are the user's, and "self" may be one of them
    def __init__(self, /, **words: Any) -> None:
        words = without_thin_body(with_table(with_system(words)))
        model = model_for(words.pop("model", None), given_in(words))
        check_body_named(model, words)
        order = words.pop("axes", None)
        check_known(words, model)
        substitutes, words = substitutes_in(words, model), resolved(words, model)
        values = {**_defaults(model), **{name: read_word(name, raw, model) for name, raw in words.items()}}
        if "method" not in words:
            values["method"] = model.methods_for(values)[0]
        given = tuple(name for name in words if isinstance(values[name], Range | Values))
        values, given = with_list(model, values, given, words)
        try:
            model.check(values)
        except RequestError as error:
            raise at_word(error, words, values) from None
        check_method(values, model)
        check_steps(values, words)
        # a list of starts has no boundary
        check_size([len(values[name]) for name in given if name != START.name])
        for name, value in (
            ("model", model),
            ("axes", given if order is None else read_axes(order, given)),
            ("_values", MappingProxyType(values)),
            ("substitutes", MappingProxyType(substitutes)),
        ):
            object.__setattr__(self, name, value)
        self.criterion.check(self)

    def __getattr__(self, name: str) -> Any:
        """Return the value of a parameter, a setting or an option."""
        if name.startswith("_") or name not in self._values:
            raise AttributeError(f"a spec of the model {self.model.name} has no {name}")
        return self._values[name]

    def __setattr__(self, name: str, value: object) -> NoReturn:
        """Refuse a change."""
        raise RequestError(
            f"A spec cannot be changed: one spec stands for one atlas; got {name}={shown(value)}.",
            hint=f"Make another one with spec.replace({name}=...).",
            where=name,
        )

    def __eq__(self, other: object) -> bool:
        """Return whether two specs ask for the same atlas."""
        return isinstance(other, SweepSpec) and self._key() == other._key()

    def __hash__(self) -> int:
        """Return the hash of `canonical`."""
        return hash(self.canonical())

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what pickle makes the spec again from: models have names, or are systems."""
        return _unpickled, (self.canonical(), self._values["starts"])

    def __repr__(self) -> str:
        """Return the words that make this spec; a table, which no word makes, stands in angle brackets."""
        model = {} if self.model.name == registry.DEFAULT else {"model": self.model.name}
        model = {"system": self.model.text} if self.model.text else model
        words = {name: value for name, value in self.words().items() if not isinstance(value, Column)}
        texts = {
            name: f"<{value}>" if isinstance(value, StartTable) else repr(str(value))
            for name, value in (model | words).items()
        }
        return f"SweepSpec({', '.join(f'{name}={text}' for name, text in texts.items())})"

    def _key(self) -> tuple[Any, ...]:
        return self.model, self.axes, dict(self._values)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each of `axes`; () for a single cell."""
        return tuple(len(self._values[name]) for name in self.axes)

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    @property
    def computed(self) -> tuple[str, ...]:
        """Parameters that each cell computes for itself, because the request gives a word instead of a number."""
        return tuple(
            name
            for name, row in self.model.parameters.items()
            if isinstance(self._values[name], str) and self._values[name] not in row.constants
        )

    @property
    def constants(self) -> Mapping[str, float]:
        """Parameters with a word that stands for a number which no request can write, and that number."""
        words = ((name, row.constants, self._values[name]) for name, row in self.model.parameters.items())
        return {name: known[word] for name, known, word in words if isinstance(word, str) and word in known}

    @property
    def fixed(self) -> tuple[str, ...]:
        """Parameters with the same number in all cells."""
        return tuple(name for name in self.model.parameters if isinstance(self._values[name], float))

    @property
    def is_list(self) -> bool:
        """Whether the cells are a list of starts (docs/starts.md), not a grid."""
        return self.axes == (START.name,)

    @property
    def listed(self) -> tuple[str, ...]:
        """Parameters of which every start of a list has its own value."""
        kinds = Distribution | Column
        return tuple(name for name in self.model.parameters if isinstance(self._values[name], kinds))

    @property
    def quantities(self) -> Mapping[str, Input]:
        """The parameters of the model, and the number of the start of a list: all that an axis can be."""
        return {**self.model.parameters, **({START.name: START} if self.is_list else {})}

    @property
    def headline(self) -> str:
        """The title; where none was given, what is looked at."""
        return str(self.title) or self.model.headline(self)

    @property
    def boundary_width(self) -> float | None:
        """Width [SI unit of the axis] to which the boundary is bisected; None where the grid's own will do."""
        return None if self.boundary == GRID else float(self.boundary.partition(":")[2])

    @classmethod
    def preset(cls, name: str, /, **changes: Any) -> Self:
        """Return one of the specs that come with a model, such as rolling, toy, egg or kapitza, with changes.

        Their rates are scaled: ``preset("rolling", radius="12mm")`` covers the boundary of that disk.

        Raises
        ------
        RequestError
            If there is no such preset, or the result is not a request.
        """
        return cls._of_file(find_spec_file(name), changes)

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Return the spec in a TOML file.

        Raises
        ------
        RequestError
            If the file cannot be read, is not TOML, or is not a request.
        """
        return cls._of_file(as_path(path, "my-sweep.toml"), {})

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
        changes = pairs(words)
        return cls._of_file(find_spec_file(spec), changes, ())

    @classmethod
    def read(cls, spec: "SweepSpec | str | Path", /, **changes: Any) -> "SweepSpec":
        """Return a spec with changes, as `replace` makes them in a spec, and `from_words` in a preset or a file.

        Parameters
        ----------
        spec : SweepSpec, str or Path
            A spec, the name of a preset, or the path of a TOML file.
        **changes
            Words with their values, text or numbers in SI.

        Raises
        ------
        RequestError
            If the file or a word cannot be read, or the result is not a request.
        """
        if isinstance(spec, SweepSpec):
            return spec.replace(**changes) if changes else spec
        if hasattr(spec, "definition"):
            return cls(model=spec, **changes)
        if not isinstance(spec, str | Path):
            raise RequestError(
                f"A spec is a SweepSpec, the name of a preset or the path of a .toml file; got "
                f"{'a dataset' if hasattr(spec, 'data_vars') else shown(spec)}.",
                hint='Write "rolling", for instance; the spec of an atlas is atlas.eulerdisk.spec.',
            )
        return cls._of_file(find_spec_file(spec), changes)

    @classmethod
    def _of_file(cls, path: Path, changes: Mapping[str, Any], others: Sequence[str] = ("axes",)) -> Self:
        """Return the spec in a file with changes of its words, or of `others`."""
        held, changes = of_one_body(with_system(read_file(path), path.parent), with_table(changes))
        if any(isinstance(held.get(name), list) for name in SWEEP_TABLES):
            raise RequestError(
                f"This file has tables [[{SWEEP_TABLES[0]}]]: it holds several sweeps, and one is asked for here.",
                hint=f"Compute them with eulerdisk batch {shlex.quote(str(path))} -o DIR, or write one into a file of "
                "its own.",
                where=place(path),
            )
        try:
            held = held if "starts" in changes else with_table(held, path.parent)
            model = model_for(held.get("model"), (*given_in(held), *given_in(changes)))
            if model is not model_for(held.get("model"), given_in(held)):
                held = {name: raw for name, raw in held.items() if name not in model.does_without}
        except RequestError as error:
            raise error.at(f"{place(path)}: {error.where}") from None
        check_known(changes, model, others)
        changes = table_for(changes, model)
        theirs = {*changes, *(parameter_of(name, model) for name in changes)}
        try:
            return cls(**changed(held, changes, model))
        except RequestError as error:
            if error.where is None or error.where == str(path) or error.where.partition("=")[0] in theirs:
                raise
            raise error.at(f"{place(path)}: {error.where}") from None

    def replace(self, /, **changes: Any) -> Self:
        """Return this spec with other values; its axes keep their places, new ones follow in the order given.

        A word that chooses another model, such as one of losses, makes a spec of that model. With another `radius` or
        `gravity` the rates stay as they are, in rad/s: a spec does not know whether they were
        scaled when they were given.

        Raises
        ------
        RequestError
            If the result is not a request.
        """
        held, changes = of_one_body(self.words(), with_table(with_system(changes)))
        other = self.model if len(held) == len(self.words()) else thin_model(self.model)
        model = model_for(changes.get("model"), given_in(changes), other)
        given = {parameter_of(name, model) for name in changes}
        kept = {
            name: value
            for name, value in self._words_for(model).items()
            if name in held and (name in self.axes or name not in given)
        }
        return type(self)(**{"model": model, **changed(kept, changes, model)})

    def _words_for(self, model: Model) -> dict[str, Any]:
        """Return every word with its value; for another model those that say what its defaults do not.

        The usual method is left out: another body or model may have another one.
        """
        words = self.words()
        if self.method == self.model.methods_for(self._values)[0]:
            del words["method"]
        if model is self.model:
            return words
        own, others = _defaults(self.model), _defaults(model)
        return {
            name: value
            for name, value in words.items()
            if (value != own[name] or others.get(name, value) != value) and name not in model.does_without
        }

    def resolve(
        self, words: Mapping[str, Any], read: Callable[[object, Quantity], Value] = read_value
    ) -> dict[str, Any]:
        """Return words in which scaled rates and speeds have become rates, for the disk of this spec.

        Parameters
        ----------
        words : mapping of str to anything
            Words that name cells of the spec, or that change it. A radius or gravity among them counts instead.
        read : callable, optional
            What reads a word: as a value of a spec if not given.

        Raises
        ------
        RequestError
            If a parameter is given in two ways, a value cannot be read, or a parameter varies that a word needs.
        """
        return resolved(words, self.model, {name: self._values[name] for name in self.model.parameters}, read)

    def words(self) -> dict[str, Any]:
        """Return every word with its value; axes first, for their order is the order of the words."""
        order = dict.fromkeys(("title", *self.axes, *names(self.model)))
        return {name: self._values[name] for name in order if not implied(name, self._values)}

    def to_toml(self) -> str:
        """Return the text of a TOML file from which `from_toml` makes the same spec.

        Raises
        ------
        RequestError
            If the spec has a table of starts, whose values no such text holds.
        """
        if self.starts:
            raise RequestError(
                f"A TOML file has no room for the values of a table of starts; got {self.starts}.",
                hint='Write the spec without it, and name the table in the file, as in starts = "pushes.csv".',
                where="starts",
            )
        quantities = {**self.model.parameters, **self.model.settings}
        lines = [] if self.model.name == registry.DEFAULT else [f"model = {_toml_value(self.model.name)}"]
        lines += [f"system = {_toml_value(self.model.text)}"] if self.model.text else []
        for name, value in self.words().items():
            units = quantities[name].units if name in quantities else "1"
            lines.append(f"{name} = {_toml_value(value)}" + (f"  # {units}" if units != "1" else ""))
        return "\n".join(lines) + "\n"

    def canonical(self) -> str:
        """Return the spec as ASCII JSON with sorted keys, numbers in SI, the same text for equal specs."""
        words = {name: _to_json(value) for name, value in self.words().items()}
        if self.model.name != registry.DEFAULT:
            words["model"] = self.model.name
        if self.model.text:
            words["system"] = self.model.text
        return json.dumps(
            {**words, "axes": self.axes}, sort_keys=True, separators=(",", ":"), allow_nan=False
        )

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
            held = {name: _from_json(value) for name, value in json.loads(text).items()}
            # the text may come from a file of anybody's: it never opens another one
            if isinstance(held.get("starts"), str) and held["starts"]:
                raise ValueError("its starts are no table")
            if names_file(held.get("model")):
                raise ValueError("its model is a file")
            words = with_system(held)
            given = {**dict.fromkeys(WORDS, ""), **words}
            needed = ("axes", *names(model_for(words.get("model"), ())))
            missing = [name for name in needed if name not in words and not implied(name, given)]
            if missing:
                raise ValueError(f"it lacks {', '.join(missing)}")
            return cls(**words)
        except (ValueError, TypeError, AttributeError, RecursionError) as problem:
            raise RequestError(
                f"{shown(text)} is not what SweepSpec.canonical() wrote: {problem}.",
                hint="Take the text unchanged from the atlas.",
            ) from problem


def _unpickled(text: str, starts: StartTable | str) -> SweepSpec:
    spec = SweepSpec.from_canonical(text)
    # the text has not the values of a table
    return spec.replace(starts=starts) if starts else spec


def _defaults(model: Model) -> dict[str, Any]:
    rows: dict[str, Input | Word] = {**model.parameters, **model.settings, **options(model), **WORDS}
    return {name: read_word(name, row.default, model) for name, row in rows.items()}


def _toml_value(value: object) -> str:
    """Return the value of a word as TOML."""
    if isinstance(value, Values):
        return "[" + ", ".join(map(repr, value.values)) + "]"
    # JSON's strings are TOML's, as long as nothing outside ASCII is escaped in pairs.
    return repr(value) if isinstance(value, float | int) else json.dumps(str(value), ensure_ascii=False)


def _to_json(value: Any) -> Any:
    """Return the value of a word as plain types, which `_from_json` reads."""
    if isinstance(value, Criterion):
        return value.kept()
    if isinstance(value, Distribution):
        return str(value)
    if isinstance(value, StartTable):
        return value.to_json()
    if isinstance(value, Column):
        return {"column": value.name}
    return asdict(value) if isinstance(value, Range | Values) else value


def _from_json(value: Any) -> object:
    """Return what `_to_json` made plain types of."""
    if not isinstance(value, dict):
        return value
    if "sha256" in value:
        return StartTable.from_json(value)
    if "column" in value:
        return Column(str(value["column"]))
    if "kind" in value:
        return Criterion(**value)
    return Range(**value) if "count" in value else Values(**value)
