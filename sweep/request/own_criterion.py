"""Criteria of one's own: an expression over the variables of a cell, or a Python function in memory."""

import re
import textwrap
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NoReturn, Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model.description import Columns, Model, Request, Starts
from sweep.model.quantity import (
    FINAL,
    LOST,
    OPEN,
    STABLE,
    UNDECIDED,
    UNDISTURBED,
    UNSTABLE,
    Array,
    Endings,
    Quantity,
    Truths,
)
from sweep.request import expression
from sweep.request.criterion_base import Criterion, Errors
from sweep.request.expression_text import read_expression

#: What only the text of a comparison holds, also one that is written with the signs of printed pages.
_COMPARING = "<>=!\u2264\u2265\u2260"

#: Characters of a line of a caption, and room for what stands before its first one.
_CAPTION, _BEFORE = 60, " " * 10


def where_true(
    truths: Truths, endings: Endings, ending: npt.NDArray[np.integer[Any]]
) -> npt.NDArray[np.int8]:
    """Return the verdicts of cells that are unstable where something is true.

    Parameters
    ----------
    truths : array of bool, shape (...)
    endings : Endings
        Those of the model.
    ending : array of int, shape (...)
        Codes of `endings`.

    Returns
    -------
    array of int8, shape (...)
        Where it is false, a cell is stable if its ending is final, a fall too, and undecided if time ran out or nothing
        was disturbed. A cell that could not be resolved is undecided.
    """
    final, known = (
        np.isin(ending, endings.codes(*roles)) for roles in ((FINAL, LOST), (FINAL, LOST, OPEN, UNDISTURBED))
    )
    found = np.where(truths, np.where(known, UNSTABLE, UNDECIDED), np.where(final, STABLE, UNDECIDED))
    return found.astype(np.int8)


@dataclass(frozen=True)
class Expression(Criterion):
    """A cell is unstable where an expression over its variables and its start is true.

    Parameters
    ----------
    tree : sweep.request.expression.Expression
        As `Criterion.parse` reads it.
    """

    tree: expression.Expression

    word: ClassVar[str] = "expression"
    form: ClassVar[str] = "an expression over the variables of a cell"
    example: ClassVar[str] = "peak_tilt > 10deg"

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what pickle makes the criterion again from."""
        return Expression, (self.tree,)

    @classmethod
    def read(cls, text: str, model: Model) -> Self | None:
        """Return the criterion that a text with a comparison spells; None of a text without one."""
        if not any(sign in text for sign in _COMPARING):
            return None
        return cls(read_expression(text, _quantities(model)))

    def kept(self) -> str:
        """Return the text, which `parse` reads."""
        return str(self)

    def __str__(self) -> str:
        """Return the expression."""
        return str(self.tree)

    def unstable_if(self, model: Model) -> str:
        """Return the expression."""
        return str(self)

    def caption(self, model: Model) -> str:
        """Return the expression, on several lines if it is long."""
        text = re.sub(r"(?<=\d)deg\b", "°", str(self))
        return textwrap.fill(text, _CAPTION, initial_indent=_BEFORE).removeprefix(_BEFORE)

    def comment(self, model: Model) -> str:
        """Return the expression, and what is stable where it is false."""
        final = " or ".join(each.name for each in model.endings if each.role in (FINAL, LOST))
        return (
            f"unstable where {self}, a comparison with a missing value being false; else stable where the ending is "
            f"{final}; an unresolved cell is undecided"
        )

    def reason(self, spec: Request, cell: Mapping[str, float], reach: float, scale: float) -> str:
        """Return which comparisons are true, with the values."""
        told, ending = "; ".join(self._told(spec, cell)), spec.model.endings.of(cell["ending"])
        if ending.role == OPEN and cell["stability"] != UNSTABLE:
            return f"{told}; but {spec.model.open_in_words(spec, cell)}"
        return told if cell["stability"] == UNSTABLE else f"{told}; the ending, {ending.name}, is final"

    def _told(self, spec: Request, cell: Mapping[str, float]) -> list[str]:
        """Return each comparison with whether it is true, and the values of its variables."""
        quantities = {**spec.model.parameters, **spec.model.cell_variables(spec)}
        values, told = self._values(cell), []
        for comparison in self.tree.comparisons():
            holds = "true" if comparison.truth(values, values)[0] else "false"
            said = ", ".join(
                f"{name} is {expression.spelled(quantities[name], float(values[name]))}"
                for name in expression.variables(comparison)
            )
            told.append(f"{comparison} is {holds}: {said}")
        return told

    def needs(self, model: Model) -> tuple[str, ...]:
        """Return the ending and the variables in the expression."""
        named = (name for name in expression.variables(self.tree) if name not in model.parameters)
        return tuple(dict.fromkeys(("ending", *named)))

    def verdict(
        self, endings: Endings, measured: Columns, reach: Array, scale: Array
    ) -> npt.NDArray[np.int8]:
        """Return the stability of cells; see `Criterion.verdict`.

        Notes
        -----
        Unstable where the expression is true, also for what was measured until time ran out. Where it is false a cell
        is stable if its ending is final, a fall too, and undecided if time ran out or nothing was disturbed. Every cell
        that could not be resolved is undecided.
        """
        values = self._values(measured)
        return where_true(self.tree.truth(values, values)[0], endings, measured["ending"])

    def on_edge(self, spec: Request, starts: Starts, columns: Sequence[Columns], errors: Errors) -> Truths:
        """Return where the expression may be true and may be false; see `Criterion.on_edge`."""
        low, model = self._values(starts, starts.keys() & spec.model.parameters.keys()), spec.model
        high = dict(low)
        for name in (each for each in expression.variables(self.tree) if each not in low):
            several = [self._values(each, (name,))[name] for each in columns]
            # a rate that each cell computes is known to rounding, and a flag is what it is
            known = name in model.parameters or model.cell_variables(spec)[name].flags is not None
            error = 0.0 if known else errors(name)
            low[name] = np.minimum.reduce(several) - error
            high[name] = np.maximum.reduce(several) + error
        sure, possible = self.tree.truth(low, high)
        return np.asarray(possible & ~sure)

    def follows_from_loss(self, model: Model) -> bool:
        """Return whether a variable in the expression is known of lost motions alone."""
        return not set(expression.variables(self.tree)) <= {*model.parameters, *model.from_extremes}

    def _values(self, columns: Mapping[str, Any], among: Collection[str] | None = None) -> dict[str, Array]:
        """Return the numbers that the expression names, as float64 and NaN where they are missing."""
        found = {}
        for name in expression.variables(self.tree):
            if among is None or name in among:
                values = np.asarray(columns[name], np.float64)
                found[name] = (
                    values if np.isfinite(values).all() else np.where(np.isfinite(values), values, np.nan)
                )
        return found


@dataclass(frozen=True)
class Function(Criterion):
    """A Python function has judged the cells of an atlas in memory; it can judge no others.

    Parameters
    ----------
    kind : str
        ``function``.
    name : str
        Of the function.
    """

    kind: str
    name: str

    word: ClassVar[str] = "function"
    form: ClassVar[str] = ""
    example: ClassVar[str] = ""

    def __post_init__(self) -> None:
        """Refuse a name that is no text, as in a file that another program has written."""
        if not isinstance(self.name, str) or not self.name.isprintable():
            raise RequestError(f"The name of a function is text; got {shown(self.name)}.", where="criterion")

    @classmethod
    def read(cls, text: str, model: Model) -> Self | None:
        """Return None: no text spells a function."""
        return None

    def __str__(self) -> str:
        """Return what it is called."""
        return f"{self.word} {self.name}"

    @classmethod
    def is_text(cls, text: str) -> bool:
        """Return whether this is what an atlas in memory says of a function."""
        return text.startswith(f"{cls.word} ")

    def unstable_if(self, model: Model) -> str:
        """Return that the function says so."""
        return f"the {self} says so, which judged this atlas in memory"

    def comment(self, model: Model) -> str:
        """Return the name of the function."""
        return f"unstable where the Python {self} says so"

    def needs(self, model: Model) -> tuple[str, ...]:
        """Return the ending."""
        return ("ending",)

    def check_new_cells(self) -> None:
        """Refuse all."""
        self._refuse()

    def verdict(
        self, endings: Endings, measured: Columns, reach: Array, scale: Array
    ) -> npt.NDArray[np.int8]:
        """Refuse."""
        self._refuse()

    def on_edge(self, spec: Request, starts: Starts, columns: Sequence[Columns], errors: Errors) -> Truths:
        """Refuse."""
        self._refuse()

    def _refuse(self) -> NoReturn:
        raise RequestError(
            f"The {self} judged the cells of an atlas in memory, and can judge no other ones; it is in no file.",
            hint='Write the criterion as an expression, as in "peak_tilt > 10deg", or use reclassify with another one.',
            where="criterion",
        )


def _quantities(model: Model) -> dict[str, Quantity]:
    """Return what an expression may name; what a request adds to the variables is refused later, with that request."""
    added = {name: each for table in model.additions.values() for name, each in table.items()}
    named: dict[str, Quantity] = {**model.variables, **added, **model.parameters}
    # it follows from the criterion
    named.pop("stability", None)
    return named
