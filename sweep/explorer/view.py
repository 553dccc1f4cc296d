"""The view of the page: a plane of two parameters, a window in it, and the spec of its cells."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from sweep.errors import RequestError, shown
from sweep.explorer.fields import read_choice, read_number, read_object, read_text, refuse
from sweep.explorer.system import is_system
from sweep.model import registry
from sweep.model.bodies.tables import NONE as NO_LENGTH
from sweep.model.description import Model, Starts
from sweep.model.quantity import Array, Truths
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.spec_file import presets

#: Least width of a pixel, in units in the last place.
ULPS = 8

#: Number of places at which the values of a side are checked: the pixels of a large screen.
_PLACES = 4097

#: Largest number of characters of a word from the page, more than any value that a person writes.
_MOST_TEXT = 1000


@dataclass(frozen=True)
class Side:
    """One side of the window: a parameter, and its visible range of values.

    Parameters
    ----------
    name : str
    centre, half : float
        Centre and half the width of the range, in SI; with the scale ``log``, of the natural logarithm of the value.
    scale : {"linear", "log"}
    """

    name: str
    centre: float
    half: float
    scale: str

    @classmethod
    def read(cls, raw: object, where: str) -> "Side":
        """Return the side in a request.

        Raises
        ------
        RequestError
        """
        fields = read_object(raw, where)
        side = cls(
            read_text(fields, "name"),
            read_number(fields, "centre"),
            read_number(fields, "half"),
            read_choice(fields, "scale", ("linear", "log"), "linear"),
        )
        if side.half <= 0.0:
            refuse(f"{where}.half", "above 0", side.half)
        # exp() of a larger one overflows
        if side.scale == "log" and abs(side.centre) + side.half > 700.0:
            refuse(f"{where}.centre", "the logarithm of a number", side.centre)
        return side

    def values(self, count: int) -> Array:
        """Return the values at the centres of `count` pixels, in SI, shape (count,)."""
        return self.at((2.0 * np.arange(count) + 1.0) / count - 1.0)

    def at(self, places: Array) -> Array:
        """Return the values at window coordinates, which are -1 and 1 at the borders, in SI."""
        values = self.centre + self.half * places
        return np.exp(values) if self.scale == "log" else values

    def place(self, values: Array) -> Array:
        """Return the window coordinates of values in SI, -1 and 1 at the borders; NaN where there are none."""
        return np.asarray(((np.log(values) if self.scale == "log" else values) - self.centre) / self.half)

    def ends(self) -> tuple[float, float]:
        """Return the values at both borders of the window, in SI."""
        low, high = self.centre - self.half, self.centre + self.half
        return (math.exp(low), math.exp(high)) if self.scale == "log" else (low, high)

    def within(self, allows: Callable[[Array], Truths]) -> "Side | None":
        """Return the part of the window whose values are allowed, to within a pixel; None if there are none.

        Parameters
        ----------
        allows : callable
            Takes values in SI and returns which are allowed; these must form one interval.
        """
        places = np.linspace(-1.0, 1.0, _PLACES)
        allowed = places[allows(self.at(places))]
        if allowed.size == 0 or allowed[0] == allowed[-1]:
            return None
        if allowed.size == places.size:
            return self
        low, high = self.centre + self.half * allowed[[0, -1]]
        return replace(self, centre=0.5 * float(low + high), half=0.5 * float(high - low))

    def is_too_fine(self, count: int) -> bool:
        """Return whether a pixel is so narrow, below `ULPS` units in the last place, that rounding shows as steps."""
        unit = np.spacing(abs(self.centre) + self.half)
        # the value itself is rounded too
        if self.scale == "log":
            unit = max(unit, np.spacing(1.0))
        return bool(2.0 * self.half / count < ULPS * unit)


@dataclass(frozen=True)
class View:
    """A window in the plane of two parameters, and the spec that all of its cells have in common.

    Parameters
    ----------
    base : str
        A preset, or empty for the explorer's own subject.
    words : mapping of str to number or text
        The other parameters and settings that differ from the base.
    x, y : Side
    given : SweepSpec
        The spec of the base.
    """

    base: str
    words: Mapping[str, float | str]
    x: Side
    y: Side
    given: SweepSpec

    @classmethod
    def read(cls, raw: object, given: SweepSpec | None) -> "View":
        """Return the view in a request; `given` is the spec of the base with the empty name.

        Raises
        ------
        RequestError
            If a field or a value is invalid.
        """
        fields = read_object(raw, "view")
        base = read_text(fields, "base", "")
        spec = _base(base, given)
        x, y = (Side.read(fields.get(name), name) for name in ("x", "y"))
        for side, where in ((x, "x"), (y, "y")):
            if side.name not in spec.model.parameters:
                refuse(f"{where}.name", f"one of {', '.join(spec.model.parameters)}", side.name)
        if x.name == y.name:
            refuse("y.name", "a parameter other than that of x", y.name)
        words = _read_words(read_object(fields.get("words", {}), "words"), spec.model)
        return cls(base, {name: words[name] for name in words if name not in (x.name, y.name)}, x, y, spec)

    @cached_property
    def spec(self) -> SweepSpec:
        """The spec of the cells of this view; its axes are those of the window, with arbitrary values.

        Raises
        ------
        RequestError
            If the words are invalid, or contradict each other.
        """
        return _spec_of(self.given, tuple(self.words.items()), self.x.name, self.y.name)

    @cached_property
    def live(self) -> SweepSpec:
        """The same spec for cells that are computed on demand, by the exact reduction or of a user's system.

        Raises
        ------
        RequestError
            If the model has no reduction, or the reduction does not provide what the criterion needs.
        """
        if is_system(self.spec):
            return self.spec
        if self.spec.model.exact is not None:
            return exact(self.spec)
        raise RequestError(
            f"The model {self.spec.model.name} has no exact reduction: its cells are integrated in time, which takes "
            "too long for an interactive map.",
            hint="Show the cells of the file, or compute an atlas with eulerdisk run.",
            where="cells",
        )

    @property
    def is_live(self) -> bool:
        """Whether cells can be computed on demand."""
        try:
            return self.live is not None
        except RequestError:
            return False

    def spec_along(self, side: Side) -> SweepSpec:
        """Return the spec whose axis on one side has the ends of the window."""
        low, high = side.ends()
        return self.spec.replace(**{side.name: Values((low, high) if low < high else (low,))})

    def starts(self, x: Array, y: Array) -> Starts:
        """Return the starts at some points, in SI.

        Parameters
        ----------
        x, y : array, shape (n,)
            Values of the two parameters of the window.

        Returns
        -------
        mapping of str to array, shape (n,)
            Every parameter of the model. A rate that the cell computes is not finite where no such rate exists.
        """
        held = {name: getattr(self.spec, name) for name in self.spec.model.parameters}
        at = {self.x.name: x, self.y.name: y}
        known = {name: at.get(name, value) for name, value in held.items()}
        numbers = {
            name: np.full(x.shape, self.spec.constants.get(name, value))
            if isinstance(value, float | str)
            else np.asarray(value)
            for name, value in known.items()
            if not isinstance(value, str) or name in self.spec.constants
        }
        found = self.spec.model.complete(self.spec, numbers)
        return {name: found[name] for name in self.spec.model.parameters}


def base_names() -> tuple[str, ...]:
    """Return the presets of the disk without losses, which share the page's built-in module."""
    known = presets(registry.named(registry.DEFAULT))
    # the simplest preset comes first
    return tuple(sorted(known, key=lambda name: (name != "rolling", name)))


def other_names() -> tuple[str, ...]:
    """Return the presets of models without an exact reduction: a map shows only the cells of their atlases."""
    return tuple(sorted(name for model in registry.every() if model.exact is None for name in presets(model)))


def _base(name: str, given: SweepSpec | None) -> SweepSpec:
    # not any text that `SweepSpec.preset` accepts: it also reads files
    if name in base_names():
        return preset(name)
    if name or given is None:
        refuse("base", f"one of {', '.join(base_names())}", name or "no name")
    return given


@lru_cache
def preset(name: str) -> SweepSpec:
    """Return a preset, one of `base_names`."""
    return SweepSpec.preset(name)


def _read_words(raw: Mapping[str, Any], model: Model) -> dict[str, float | str]:
    """Return the words that change a spec; words that name files, lists or other models are not allowed."""
    known = (*model.parameters, *model.substitutes, *model.settings, "criterion")
    words: dict[str, float | str] = {}
    for name, value in raw.items():
        if name not in known:
            refuse("words", f"named {', '.join(known)}", name)
        if isinstance(value, str) and len(value) <= _MOST_TEXT:
            words[name] = value
        else:
            words[name] = read_number(raw, name)
    return words


@lru_cache(maxsize=64)
def _spec_of(given: SweepSpec, words: tuple[tuple[str, float | str], ...], x: str, y: str) -> SweepSpec:
    changes: dict[str, Any] = dict(words)
    others = (name for name in given.axes if name not in (x, y) and name not in changes)
    changes |= {name: middle(getattr(given, name)) for name in others}
    changes |= {name: _any_axis(given, name) for name in (x, y)}
    found = given.replace(**changes, device="cpu", boundary="grid")
    if extra := [name for name in found.axes if name not in (x, y)]:
        raise RequestError(
            f"{extra[0]} must be one number here, because the axes of the window are {x} and {y}; got "
            f"{shown(str(getattr(found, extra[0])))}.",
            hint="Give one number.",
            where=extra[0],
        )
    return found


@lru_cache(maxsize=64)
def exact(spec: SweepSpec) -> SweepSpec:
    """Return a spec whose cells are reduced exactly; raises as `SweepSpec.replace` does."""
    return spec.replace(method="exact")


def _any_axis(given: SweepSpec, name: str) -> Range | Values:
    """Return an axis for a parameter of the window: the base's, or one with a single value that is always valid."""
    held = getattr(given, name)
    if isinstance(held, Range | Values):
        return held
    if held == NO_LENGTH:
        return Values((0.0,))
    # not zero: no steady motion has a rate of zero
    return Values((held if isinstance(held, float) and held else 1.0,))


def middle(axis: Range | Values) -> float:
    """Return the value in the middle of an axis."""
    values = axis.array()
    return float(values[values.size // 2])
