"""Criteria of instability: a condition on the variables of a cell, and its verdict.

A condition is an expression, such as ``peak_tilt > 10deg or fall_time < 2s``, or a short form such as
``departure:5deg`` (`sweep.request.criterion_kinds`).
"""

import math
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model import registry
from sweep.model.cells import stated_error
from sweep.model.description import Columns, Model, Request, Starts
from sweep.model.quantity import (
    FINAL,
    LOST,
    PROMISED,
    SENSITIVE,
    STABLE,
    UNDECIDED,
    Array,
    Endings,
    Quantity,
    Truths,
)
from sweep.request.criterion_kinds import BY_REACH, KINDS, LOST_TIME, REACH, SCALE, Kind
from sweep.request.expression import Comparison, Expression, Number, variables
from sweep.request.expression_text import read_expression
from sweep.request.values import read_number

#: Variable -> largest error of its values, in its unit.
Errors = Callable[[str], Array | float]

#: Largest effect of rounding on an extreme [SI unit]; stated errors do not include it.
ROUNDING = 2e-14

#: Characters that only comparisons contain, also the typographic ones.
_COMPARING = "<>=!\u2264\u2265\u2260"

#: Width of a caption's lines, and the indent that its first line leaves for the text before it.
_CAPTION, _BEFORE = 60, " " * 10


@dataclass(frozen=True)
class Criterion:
    """A rule for which cells are unstable, made by ``Criterion(kind, limit)`` or `sweep.Criterion.parse`.

    Parameters
    ----------
    kind : {"departure", "amplification", "aloft"}
        The limited quantity: the distance from the steady tilt, this distance divided by the size of the perturbation,
        or the time before which the motion must not be lost.
    limit : float
        The largest stable value: rad, between 0 and pi (departure), or a positive number (amplification); the time, s.

    Raises
    ------
    RequestError
        If the kind is unknown or the limit is out of its range.

    Notes
    -----
    An expression has the kind ``expression``, and its `limit` is the expression's tree. A Python function that has
    judged the cells of an atlas in memory has the kind ``function``, and its `limit` is the function's name.
    """

    kind: str
    limit: Any

    def __post_init__(self) -> None:
        """Read the limit, and refuse an impossible one."""
        if self.kind == "function" and not (isinstance(self.limit, str) and self.limit.isprintable()):
            raise RequestError(f"The name of a function is text; got {shown(self.limit)}.", where="criterion")
        if self.kind not in KINDS or (self.kind == "expression" and not isinstance(self.limit, Expression)):
            raise _unknown_criterion(self.kind)
        quantity, given = self.row.quantity, f"{self.kind}:{shown(self.limit)}"
        if quantity is None:
            return
        object.__setattr__(self, "limit", read_number(self.limit, quantity))
        if not self.limit > 0.0:
            problem = f"{self.row.positive}; got {given}."
        # two tilts inside +-90 deg are never 180 deg apart: the user meant degrees, not radians
        elif quantity.units == "rad" and self.limit >= math.pi:
            problem = f"A {self.kind} must be below 180 deg; a bare number is in rad. Got {given}."
        else:
            return
        raise RequestError(problem, hint=f"Write {self.row.example}.", where="criterion")

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the class and arguments from which pickle rebuilds the criterion."""
        return Criterion, (self.kind, self.limit)

    @staticmethod
    def parse(text: str, model: Model | None = None) -> "Criterion":
        """Return the criterion that a text describes; `str` is the inverse.

        Parameters
        ----------
        text : str
            ``departure:ANGLE``, ``amplification:NUMBER``, ``aloft:TIME``, or an expression (docs/atlas.md).
        model : Model, optional
            The model whose variables and parameters an expression may name; by default the disk.

        Raises
        ------
        RequestError
            If the text is not a criterion.
        """
        word, colon, limit = text.partition(":")
        try:
            if colon and word.strip() in KINDS and KINDS[word.strip()].quantity is not None:
                return Criterion(word.strip(), limit)
            if any(sign in text for sign in _COMPARING):
                named = _quantities(model or registry.named(registry.DEFAULT))
                return Criterion("expression", read_expression(text, named))
        except RequestError as error:
            raise error.at(f"criterion={shown(text)}") from None
        raise _unknown_criterion(text)

    @staticmethod
    def named_function(text: str) -> bool:
        """Return whether a text is an atlas's description of the function that has judged it in memory."""
        return text.startswith("function ")

    @property
    def row(self) -> Kind:
        """The entry of `KINDS` for this kind."""
        return KINDS[self.kind]

    @cached_property
    def condition(self) -> Expression | None:
        """The condition that makes a cell unstable; None for a function."""
        if self.kind == "expression":
            return self.limit  # type: ignore[no-any-return]
        return None if self.row.condition is None else self.row.condition(self.limit)

    @property
    def limits_reach(self) -> bool:
        """Whether the criterion limits how far the coordinate goes.

        Then a lost motion is unstable, and a cell that was unstable when time ran out stays unstable.
        """
        return self.row.outcomes is BY_REACH

    @property
    def predictable(self) -> bool:
        """Whether theory can predict the criterion's boundary."""
        return self.row.quantity is not None

    def kept(self) -> Any:
        """Return the criterion in plain types, for the canonical text of a spec."""
        return str(self) if self.kind == "expression" else asdict(self)

    def __str__(self) -> str:
        """Return the criterion as a request writes it; `parse` is the exact inverse."""
        if self.row.quantity is not None:
            return f"{self.kind}:{Number(self.limit, self.row.quantity.units)}"
        return str(self.limit) if self.kind == "expression" else f"{self.kind} {self.limit}"

    # -- in words

    def limit_text(self, digits: int = 6) -> str:
        """Return the limit in words: ``5 deg``, ``10 times the perturbation``; empty without a limit."""
        quantity = self.row.quantity
        return "" if quantity is None else self.row.limit.format(quantity.spell(self.limit, digits))

    def words(self, model: Model) -> dict[str, str]:
        """Return the values of the placeholders in a kind's sentences, for a model."""
        lost, quantity = model.lost_name, self.row.quantity
        short = "" if quantity is None else quantity.spell(self.limit, 4)
        if quantity is not None and quantity.units == "rad":
            short = f"{math.degrees(self.limit):.4g}°"
        return {
            "kind": self.kind,
            "text": str(self),
            "limit": self.limit_text(),
            "short": short,
            "coordinate": model.coordinate.replace("_", " "),
            "lost": lost,
            "or_lost": f", or {lost}" if lost else "",
            "lost_time": model.endings.lost_time,
            "final": " or ".join(each.name for each in model.endings if each.role in (FINAL, LOST)),
        }

    def unstable_if(self, model: Model) -> str:
        """Return what makes a cell unstable, in words."""
        return self.row.unstable.format(**self.words(model))

    def label(self, model: Model) -> str:
        """Return the criterion as a figure names it: ``departure 5°``."""
        return self.row.label.format(**self.words(model))

    def caption(self, model: Model) -> str:
        """Return what makes a cell unstable, in the short form for figures; wrapped if it is long."""
        words = model.criterion_words.get(str(self)) or self.row.caption.format(**self.words(model))
        text = re.sub(r"(?<=\d)deg\b", "°", words)
        return textwrap.fill(text, _CAPTION, initial_indent=_BEFORE).removeprefix(_BEFORE)

    def comment(self, model: Model) -> str:
        """Return the file's ASCII comment on the verdicts; empty where the usual comment on a limit is right."""
        return self.row.comment.format(**self.words(model))

    # -- the variables it needs

    def needs(self, model: Model) -> tuple[str, ...]:
        """Return the variables of an atlas that the condition depends on."""
        stands_for = {REACH: model.extremes, SCALE: (), LOST_TIME: (model.endings.lost_time,)}
        found = ["ending"]
        for name in self._named:
            found += [] if name in model.parameters else stands_for.get(name, (name,))
        return tuple(dict.fromkeys(found))

    def reads(self, model: Model) -> tuple[str, ...]:
        """Return the variables of an atlas that `decide` reads: those it `needs`, and those that state their errors."""
        quantities = _quantities(model)
        found = [*self.needs(model), *((*model.extremes, model.error_name) if model.extremes else ())]
        found += [stated for name in found if (stated := quantities[name].tolerance.stated) in quantities]
        return tuple(dict.fromkeys(found))

    @property
    def _named(self) -> tuple[str, ...]:
        return () if self.condition is None else variables(self.condition)

    def check(self, spec: Request) -> None:
        """Refuse a spec whose atlas lacks a variable that the criterion needs, or whose duration is too short.

        Raises
        ------
        RequestError
        """
        model, method = spec.model, spec.method
        if REACH in self._named and not model.coordinate:
            raise RequestError(
                f"{self} limits how far a coordinate leaves its steady value, and the model {model.name} has no such "
                "coordinate.",
                hint=f"Write an expression over its variables, as in {model.default_criterion!r}.",
                where="criterion",
            )
        if LOST_TIME in self._named and not model.endings.lost_time:
            raise RequestError(
                f"{self} needs the time at which a motion is lost, and the model {model.name} does not compute it.",
                hint="Use another criterion.",
                where="criterion",
            )
        if LOST_TIME in self._named and spec.duration < self.limit:
            raise RequestError(
                f"{self} needs a longer time than the motions are followed; got duration={spec.duration:g}s.",
                hint=f"Give a duration of {self.limit:g}s or more.",
                where="criterion",
            )
        needed, unknown = self.needs(model), model.unknown_to.get(method, ())
        if without := [name for name in needed if name in unknown]:
            usual = model.methods_for(spec.words())[0]
            raise RequestError(
                f"The criterion {self} needs {' and '.join(without)}, which method={method} does not compute.",
                hint="Use another criterion."
                if usual == method
                else f"Use another criterion, or method={usual}.",
                where="criterion",
            )
        if missing := [name for name in needed if name not in model.cell_variables(spec)]:
            words = [word for word, table in model.additions.items() if not table.keys().isdisjoint(missing)]
            raise RequestError(
                f"The criterion {self} needs {' and '.join(missing)}, which the model {model.name} does not "
                f"compute{' for this request' if words else ''}.",
                hint=f"Add {' and '.join(words)} to the request of the atlas."
                if words
                else "Use another criterion.",
                where="criterion",
            )

    def check_new_cells(self) -> None:
        """Refuse to judge new cells if the criterion is a function.

        Raises
        ------
        RequestError
        """
        if self.condition is None:
            raise RequestError(
                f"The {self} judged the cells of an atlas in memory. It is not stored, so it cannot judge other cells.",
                hint='Write the criterion as an expression, as in "peak_tilt > 10deg", or use reclassify with another '
                "criterion.",
                where="criterion",
            )

    # -- verdicts

    def allowed(self, scale: Array) -> Array:
        """Return the largest stable distance from the undisturbed value, for perturbations of given sizes.

        Parameters
        ----------
        scale : array of float, shape (...)
            Size of the perturbation (`sweep.model.description.Model.perturbation`), in the unit of the coordinate.

        Returns
        -------
        array of float, shape (...)
            In the same unit; NaN where the criterion sets no such limit.
        """
        if not self.limits_reach or not isinstance(self.condition, Comparison):
            return np.full(np.shape(scale), np.nan)
        known = {SCALE: _perturbation_size(scale)}
        return np.broadcast_to(self.condition.terms[1].between(known, known)[0], np.shape(scale)).copy()

    def outcome(
        self, endings: Endings, ending: npt.NDArray[Any], true: Truths, missing: Truths | bool = False
    ) -> npt.NDArray[np.int8]:
        """Return the stability of cells from their endings and the truth of the condition.

        Parameters
        ----------
        endings : Endings
            The endings of the model.
        ending : array of int, shape (...)
            Codes of `endings`.
        true, missing : array of bool, shape (...)
            Where the condition is true, and where a value that it needs is missing.

        Returns
        -------
        array of int8, shape (...)
        """
        # the last row is for codes that the model does not have, as in a damaged file
        rows = np.full((max(each.code for each in endings) + 2, 3), UNDECIDED, np.int8)
        for each in endings:
            rows[each.code] = self.row.outcomes.get(each.role, (UNDECIDED,) * 3)
        codes = np.minimum(np.asarray(ending).astype(np.uint8), len(rows) - 1)
        return np.asarray(rows[codes, np.where(true, 0, np.where(missing, 2, 1))])

    def verdict(
        self, endings: Endings, measured: Columns, reach: Array, scale: Array
    ) -> npt.NDArray[np.int8]:
        """Return the stability of cells: 0 undecided, 1 stable, 2 unstable.

        Parameters
        ----------
        endings : Endings
            The endings of the model.
        measured : mapping of str to array, shape (...)
            The variables that the criterion `needs`, and the starts of the cells; ``ending`` holds codes of `endings`.
        reach : array of float, shape (...)
            How far the coordinate went from its undisturbed value; NaN where a cell has no extremes.
        scale : array of float, broadcastable
            Size of the perturbation, in the same unit.

        Returns
        -------
        array of int8, shape (...)
        """
        self.check_new_cells()
        assert self.condition is not None
        known: Mapping[str, Any] = {**measured, REACH: reach, SCALE: _perturbation_size(scale)}
        if LOST_TIME in self._named:
            known = {**known, LOST_TIME: measured[endings.lost_time]}
        values = {name: finite_numbers(known[name]) for name in self._named}
        true = self.condition.truth(values, values)[0]
        missing = np.logical_or.reduce(np.broadcast_arrays(*(np.isnan(each) for each in values.values())))
        return self.outcome(endings, measured["ending"], true, missing)

    def decide(
        self, spec: Request, starts: Starts, measured: Columns, reach: Array, scale: Array, share: float = 1.0
    ) -> npt.NDArray[np.int8]:
        """Return the stability of cells; undecided where the stated errors leave it open.

        Parameters
        ----------
        spec : Request
        starts : mapping of str to array, shape (n,)
        measured : mapping of str to array, shape (n,)
            The variables of the cells that the criterion `reads`.
        reach, scale : array of float, shape (n,)
            As in `verdict`.
        share : float
            Factor on the errors: `verify` tests whether another rounding of the errors changes the verdict.

        Returns
        -------
        array of int8, shape (n,)
        """
        model = spec.model
        stability = self.verdict(model.endings, {**starts, **measured}, reach, scale)
        near: slice | npt.NDArray[np.intp] = slice(None)
        if self.limits_reach:
            # fast path: most cells are further from the limit than the largest error of any cell
            stated = measured[model.error_name]
            most = np.fmax.reduce(stated, initial=0.0, where=np.isfinite(stated))
            largest = share * (PROMISED * most + ROUNDING)
            near = np.flatnonzero(
                (np.abs(reach - self.allowed(scale)) <= largest)
                | (model.may_be_lost(spec, measured, np.array(largest)) & (stability == STABLE))
            )
        cells = {name: values[near] for name, values in measured.items()} | {"stability": stability[near]}
        begun = {name: values[near] for name, values in starts.items()}
        error = np.zeros(cells["stability"].shape)
        if model.extremes:
            error = share * np.nan_to_num(PROMISED * model.error(cells) + ROUNDING)
            # if a motion goes no further than its start, the reach is the start's, which is exact
            error[reach[near] <= np.abs(begun[model.coordinate] - model.undisturbed(spec, begun))] = 0.0
        stability[near] = np.where(
            self.is_open(spec, begun, cells, error), np.int8(UNDECIDED), cells["stability"]
        )
        return stability

    def on_edge(self, spec: Request, starts: Starts, columns: Sequence[Columns], errors: Errors) -> Truths:
        """Return which cells have the criterion's limit within the span of their variables.

        Parameters
        ----------
        spec : Request
        starts : mapping of str to array, shape (n,)
        columns : sequence of mapping of str to array, shape (n,)
            One or more sets of the variables that the criterion `needs`, and of the extremes, of the same cells.
        errors : Errors
            The largest error of each variable.

        Returns
        -------
        array of bool, shape (n,)
            False where a value is missing.
        """
        self.check_new_cells()
        assert self.condition is not None
        spans = {name: self._span(name, spec, starts, columns, errors) for name in self._named}
        low, high = ({name: ends[i] for name, ends in spans.items()} for i in (0, 1))
        sure, possible = self.condition.truth(low, high)
        found = possible & ~sure
        if LOST_TIME in spans:
            found &= np.any([spec.model.endings.have(LOST, each["ending"]) for each in columns], axis=0)
        return np.asarray(found)

    @staticmethod
    def _span(
        name: str, spec: Request, starts: Starts, columns: Sequence[Columns], errors: Errors
    ) -> tuple[Array, Array]:
        """Return the least and the largest value that a variable of the condition may have."""
        model = spec.model
        if name == SCALE:
            scale = _perturbation_size(model.perturbation(spec, starts))
            return scale, scale
        if name in starts and name in model.parameters:
            start = finite_numbers(starts[name])
            return start, start
        if name == LOST_TIME:
            # a motion that was not lost may have no time
            times, error = (
                [each[model.endings.lost_time] for each in columns],
                errors(model.endings.lost_time),
            )
            return np.fmin.reduce(times) - error, np.fmax.reduce(times) + error
        if name == REACH:
            with np.errstate(invalid="ignore"):
                several = [model.reach(spec, starts, each) for each in columns]
            error = errors(model.extremes[1])
        else:
            several = [finite_numbers(each[name]) for each in columns]
            # a computed rate, such as the steady one, has only rounding errors
            error = 0.0 if name in model.parameters else errors(name)
            if name not in model.parameters and model.cell_variables(spec)[name].flags is not None:
                # a flag is exact, except in cells that are too sensitive to their start: there it is unknown
                unknown = [model.endings.have(SENSITIVE, each["ending"]) for each in columns]
                error = np.where(np.any(unknown, axis=0), np.inf, 0.0)
        return np.minimum.reduce(several) - error, np.maximum.reduce(several) + error

    def is_open(self, spec: Request, starts: Starts, measured: Columns, error: Array) -> Truths:
        """Return which cells may have another verdict because of an error of their extremes.

        Parameters
        ----------
        spec : Request
        starts : mapping of str to array, shape (n,)
        measured : mapping of str to array, shape (n,)
            All variables of the cells.
        error : array of float, shape (n,)
            Largest error of the extremes, in the unit of the coordinate.

        Returns
        -------
        array of bool, shape (n,)
            True where the errors of the variables leave the verdict open, or where the motion may be lost within
            `error` and a loss can change the verdict.
        """
        model, stability = spec.model, measured["stability"]
        quantities, lost = model.cell_variables(spec), model.endings.have(LOST, measured["ending"])

        def error_of(name: str) -> Array:
            if self.limits_reach:
                return error
            return stated_error(quantities[name], spec, starts, measured, error)

        found = self.on_edge(spec, starts, [measured], error_of)
        may_change = ~lost
        if self.limits_reach:
            # a lost motion is unstable in any case
            found, may_change = found & ~lost, may_change & (stability == STABLE)
        if not set(self._named) <= {*model.parameters, *model.from_extremes}:
            found = found | (may_change & model.may_be_lost(spec, measured, error))
        return np.asarray(found & (stability != UNDECIDED))


def _perturbation_size(scale: Array) -> Array:
    """Return the size of perturbations; NaN for an undisturbed start, where nothing is amplified."""
    return np.where(np.asarray(scale) > 0.0, scale, np.nan)


def finite_numbers(values: Any) -> Array:
    """Return values as float64, with NaN for missing ones."""
    found = np.asarray(values, np.float64)
    return found if np.isfinite(found).all() else np.where(np.isfinite(found), found, np.nan)


def _quantities(model: Model) -> dict[str, Quantity]:
    """Return what an expression may name, with the variables that only some requests add (`check` refuses them)."""
    added = {name: each for table in model.additions.values() for name, each in table.items()}
    named: dict[str, Quantity] = {**model.variables, **added, **model.parameters}
    # stability follows from the criterion itself
    named.pop("stability", None)
    return named


def _unknown_criterion(text: str) -> RequestError:
    written = [each for each in KINDS.values() if each.form]
    forms = [each.form for each in written]
    return RequestError(
        f"{shown(text)} is not a criterion. A criterion is {', '.join(forms[:-1])} or {forms[-1]}.",
        hint=f"Write {' or '.join(each.example for each in written)}.",
        where="criterion",
    )
