"""The request for an atlas: its cells, their integration, and the criterion of stability.

Python, TOML and the command line use the same words::

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
from sweep.request.substitutes import changed, parameter_of, requested_in, resolved
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
    """A grid or a list of starts, the settings of the integration, and the criterion of stability; immutable.

    Parameters
    ----------
    tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity
        A number, or a list or a range (an axis), in SI or as text with units. Axes are the dimensions of the atlas, in
        the order given. `roll_rate` may be ``"steady"``: the rate that keeps the tilt constant, computed per cell.
        Instead `precession_rate` may be ``"steady-slow"`` or ``"steady-fast"``: the smaller or the larger of the two
        rates that keep the tilt constant at a given `roll_rate`. Other models have other parameters. With ``samples``
        also a distribution: ``uniform:LOW:HIGH``, ``loguniform:LOW:HIGH``, ``normal:MEAN:DEVIATION``.
    samples, seed : int or str
        The number of random starts, and their seed. The only dimension of the atlas is then `start`.
    starts : str, Path or mapping of str to array
        A table of starts, instead of random ones: a CSV file, a mapping or a pandas.DataFrame. Its columns have the
        names of parameters, and are in SI or have a unit as in ``tilt [deg]``. All other parameters have one number.
    start : str or sequence of int, optional
        The numbers of the selected starts; by default all of them.
    scaled_tilt_rate, scaled_precession_rate, scaled_roll_rate, speed
        Scaled rates, which replace a rate: the rate in units of sqrt(gravity/radius), a pure number. `speed` replaces
        `roll_rate`: the speed of the contact point along its path, roll_rate * radius, m/s. The spec stores the rate,
        in rad/s. Not allowed if gravity or radius varies.
    criterion : Criterion or str
        The condition for unstable cells: ``departure:5deg``, ``amplification:10``, ``aloft:10s``, or an expression
        over the variables of a cell such as ``peak_tilt > 10deg or fall_time < 2s`` (docs/atlas.md).
    duration, step : float or str
        Longest simulated time of a cell, and time step, s; with ``"auto"`` the engine chooses the step.
    fall_tilt, tolerance : float or str
        Tilt at which the disk counts as fallen, and largest estimated error of a cell before its step is reduced, rad.
    method, device, title : str
        ``rk4`` or ``exact``, for a system ``taylor``; ``cpu`` or ``cuda``; a title of one line.
    contact : str
        ``yes`` also records the least normal force and the largest friction coefficient needed.
    path : str
        ``yes`` also records the path of the contact point (docs/bodies.md).
    boundary : str
        ``grid``: the boundary lies between neighboring cells. ``refined`` or ``refined:WIDTH``: it is bisected until
        its bracket is at most WIDTH wide, in the SI unit of the axis, and also stored as curves.
    body : str
        The rolling body, by default the thin disk: ``torus``, ``rounded``, ``rim``, ``arc``, ``ball`` or
        ``spheroid``, with ``tube``, ``filling``, ``thickness``, ``fillet``, ``offset``, ``flattening``,
        ``axial_moment`` and ``transverse_moment`` (docs/bodies.md).
    model : str
        The model to integrate. By default the words choose it: a loss chooses the disk with losses (docs/losses.md),
        a word of another body chooses bodies, both choose bodies with losses, and anything else the disk.
    axes : sequence of str, optional
        The order of the axes; by default the order given.

    Attributes
    ----------
    model : Model
    axes : tuple of str
    criterion : Criterion
    requested : mapping of str to str
        The text of given words that replace a parameter, such as `speed`, or have a unit; reports use these words.

    Raises
    ------
    RequestError
        If a word is unknown, a value is impossible, or values contradict each other.
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
    requested: Mapping[str, str]
    _values: Mapping[str, Any]

    # positional-only: a user may give a word with the name "self"
    def __init__(self, /, **words: Any) -> None:
        words = without_thin_body(with_table(with_system(words)))
        model = model_for(words.pop("model", None), given_in(words))
        check_body_named(model, words)
        order = words.pop("axes", None)
        check_known(words, model)
        requested, words = requested_in(words, model), resolved(words, model)
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
            ("requested", MappingProxyType(requested)),
        ):
            object.__setattr__(self, name, value)
        self.criterion.check(self)

    def __getattr__(self, name: str) -> Any:
        """Return the value of a parameter, a setting or an option."""
        if name.startswith("_") or name not in self._values:
            raise AttributeError(f"a spec of the model {self.model.name} has no attribute {name}")
        return self._values[name]

    def __setattr__(self, name: str, value: object) -> NoReturn:
        """Refuse a change."""
        raise RequestError(
            f"A spec cannot be changed, because it identifies an atlas; got {name}={shown(value)}.",
            hint=f"Make another spec with spec.replace({name}=...).",
            where=name,
        )

    def __eq__(self, other: object) -> bool:
        """Return whether two specs ask for the same atlas."""
        return isinstance(other, SweepSpec) and self._key() == other._key()

    def __hash__(self) -> int:
        """Return the hash of `canonical`."""
        return hash(self.canonical())

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the function and arguments from which pickle rebuilds the spec."""
        return type(self).from_canonical, (
            self.canonical(),
            dict(self.requested),
            self._values["starts"] or None,
        )

    def __repr__(self) -> str:
        """Return the words that make this spec; a table is shown in angle brackets, because no text makes it."""
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
        """Parameters that are computed for each cell, because the request gives a word instead of a number."""
        return tuple(
            name
            for name, row in self.model.parameters.items()
            if isinstance(self._values[name], str) and self._values[name] not in row.constants
        )

    @property
    def constants(self) -> Mapping[str, float]:
        """Parameters given by a word for a number that has no notation in a request, with this number."""
        words = ((name, row.constants, self._values[name]) for name, row in self.model.parameters.items())
        return {name: known[word] for name, known, word in words if isinstance(word, str) and word in known}

    @property
    def fixed(self) -> tuple[str, ...]:
        """Parameters with the same number in all cells."""
        return tuple(name for name in self.model.parameters if isinstance(self._values[name], float))

    @property
    def is_list(self) -> bool:
        """Whether the cells are a list of starts (docs/starts.md) instead of a grid."""
        return self.axes == (START.name,)

    @property
    def listed(self) -> tuple[str, ...]:
        """Parameters that have a value for each start of a list."""
        kinds = Distribution | Column
        return tuple(name for name in self.model.parameters if isinstance(self._values[name], kinds))

    @property
    def quantities(self) -> Mapping[str, Input]:
        """The quantities that an axis can have: the parameters of the model, and for a list the start number."""
        return {**self.model.parameters, **({START.name: START} if self.is_list else {})}

    @property
    def headline(self) -> str:
        """The title, by default the model's description of the request."""
        return str(self.title) or self.model.headline(self)

    @property
    def short_title(self) -> str:
        """The title, by default what moves."""
        return str(self.title) or self.model.subject(self)[0]

    @property
    def boundary_width(self) -> float | None:
        """Width [SI unit of the axis] to which the boundary is bisected; None for ``boundary=grid``."""
        return None if self.boundary == GRID else float(self.boundary.partition(":")[2])

    @classmethod
    def preset(cls, name: str, /, **changes: Any) -> Self:
        """Return a preset of a model, such as rolling, toy, egg or kapitza, with changes.

        The rates of presets are scaled: ``preset("rolling", radius="12mm")`` covers the boundary of a 12 mm disk.

        Raises
        ------
        RequestError
            If there is no such preset, or the result is not a valid request.
        """
        return cls._of_file(find_spec_file(name), changes)

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Return the spec in a TOML file.

        Raises
        ------
        RequestError
            If the file cannot be read, is not TOML, or is not a valid request.
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
            ``NAME=VALUE``, each name once. Names in the file keep their places there (and so the order of the axes);
            new names follow in the order given.

        Raises
        ------
        RequestError
            If the file or a word cannot be read, or the result is not a valid request.
        """
        changes = pairs(words)
        return cls._of_file(find_spec_file(spec), changes, ())

    @classmethod
    def read(cls, spec: "SweepSpec | str | Path", /, **changes: Any) -> "SweepSpec":
        """Return a spec with changes; see `replace` for a spec, and `from_words` for a preset or a file.

        Parameters
        ----------
        spec : SweepSpec, str or Path
            A spec, the name of a preset, or the path of a TOML file.
        **changes
            Words with their values, text or numbers in SI.

        Raises
        ------
        RequestError
            If the file or a word cannot be read, or the result is not a valid request.
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
        """Return the spec in a file with changes to its words, or to `others`."""
        held, changes = of_one_body(with_system(read_file(path), path.parent), with_table(changes))
        if any(isinstance(held.get(name), list) for name in SWEEP_TABLES):
            raise RequestError(
                f"This file has tables [[{SWEEP_TABLES[0]}]]: it contains several sweeps, and only one is allowed "
                "here.",
                hint=f"Compute them with eulerdisk batch {shlex.quote(str(path))} -o DIR, or write one sweep into a "
                "separate file.",
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
        """Return this spec with other values; its axes keep their places, new axes follow in the order given.

        A word that chooses another model, such as a loss, gives a spec of that model. If `radius` or `gravity` changes,
        the rates stay the same in rad/s, because a spec does not store whether they were given as scaled rates.

        Raises
        ------
        RequestError
            If the result is not a valid request.
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
        """Return every word with its value; for another model only those that its defaults do not imply.

        The default method is omitted, because another body or model may have another default.
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
        """Return words with scaled rates and speeds converted to rates, for the disk of this spec.

        Parameters
        ----------
        words : mapping of str to anything
            Words that name cells of the spec, or that change it. A radius or gravity among them replaces the spec's.
        read : callable, optional
            The reader of a word's value; by default the reader for specs.

        Raises
        ------
        RequestError
            If a parameter is given twice, a value cannot be read, or a word needs a parameter that varies.
        """
        return resolved(words, self.model, {name: self._values[name] for name in self.model.parameters}, read)

    def words(self) -> dict[str, Any]:
        """Return every word with its value; axes come first, because the order of the words is their order."""
        order = dict.fromkeys(("title", *self.axes, *names(self.model)))
        return {name: self._values[name] for name in order if not implied(name, self._values)}

    def to_toml(self) -> str:
        """Return the text of a TOML file from which `from_toml` makes the same spec.

        Raises
        ------
        RequestError
            If the spec has a table of starts, whose values cannot be in the text.
        """
        if self.starts:
            raise RequestError(
                f"A TOML file cannot contain the values of a table of starts; got {self.starts}.",
                hint='Write the spec without the table, and name its file, as in starts = "pushes.csv".',
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
        """Return the spec as ASCII JSON with sorted keys and numbers in SI; equal specs give the same text."""
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
    def from_canonical(
        cls, text: str, requested: Mapping[str, str] | None = None, starts: StartTable | None = None
    ) -> Self:
        """Return the spec that `canonical` wrote, with its `requested`, and with its table, whose values no text has.

        Raises
        ------
        RequestError
            If the text is not the canonical text of a spec.
        """
        try:
            held = {name: _from_json(value) for name, value in json.loads(text).items()}
            # the text may come from an untrusted file: it must not open other files
            if isinstance(held.get("starts"), str) and held["starts"]:
                raise ValueError("its starts are not a table")
            if names_file(held.get("model")):
                raise ValueError("its model is a file")
            words = with_system(held)
            given = {**dict.fromkeys(WORDS, ""), **words}
            needed = ("axes", *names(model_for(words.get("model"), ())))
            missing = [name for name in needed if name not in words and not implied(name, given)]
            if missing:
                raise ValueError(f"it lacks {', '.join(missing)}")
            spec = cls(**words)
        except (ValueError, TypeError, AttributeError, RecursionError) as problem:
            raise RequestError(
                f"{shown(text)} was not written by SweepSpec.canonical(): {problem}.",
                hint="Take the text unchanged from the atlas.",
            ) from problem
        spec = spec if starts is None else spec.replace(starts=starts)
        object.__setattr__(spec, "requested", MappingProxyType(dict(requested or {})))
        return spec


def _defaults(model: Model) -> dict[str, Any]:
    rows: dict[str, Input | Word] = {**model.parameters, **model.settings, **options(model), **WORDS}
    return {name: read_word(name, row.default, model) for name, row in rows.items()}


def _toml_value(value: object) -> str:
    """Return the value of a word as TOML."""
    if isinstance(value, Values):
        return "[" + ", ".join(map(repr, value.values)) + "]"
    # JSON strings are TOML strings if no character is escaped as a surrogate pair
    return repr(value) if isinstance(value, float | int) else json.dumps(str(value), ensure_ascii=False)


def _to_json(value: Any) -> Any:
    """Return the value of a word in plain types; `_from_json` is the inverse."""
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
    """Return the value of a word from the plain types of `_to_json`."""
    if not isinstance(value, dict):
        return value
    if "sha256" in value:
        return StartTable.from_json(value)
    if "column" in value:
        return Column(str(value["column"]))
    if "kind" in value:
        return Criterion(**value)
    return Range(**value) if "count" in value else Values(**value)
