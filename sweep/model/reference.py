"""What `verify` holds cells of an atlas against: the reference of a model, its checks, and what is stored of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy.typing as npt

from sweep.model.quantity import Array, Quantity, Truths

if TYPE_CHECKING:
    from sweep.model.description import Columns, Request, Starts


@dataclass(frozen=True)
class Audit:
    """What `verify` stores of each cell, and which of its codes mean what.

    `variables` is the table; its first enumerated quantity named ``audit`` has the codes. `other` is the code, one of
    `disagreeing`, of a cell in which a variable is wrong that the model itself did not check; `ended_by_time`, if
    there is one, that of a cell whose difference says nothing. `difference` names the variable whose distribution is
    shown, in `units`, after the words `told`; `period` those with the error of the period, the exact period, and the
    error over what is allowed, if there is a period. `summary` says what was done, for the file.
    """

    variables: Mapping[str, Quantity]
    agreeing: tuple[int, ...]
    disagreeing: tuple[int, ...]
    missing: int
    other: int
    difference: str
    units: str
    told: str
    summary: str
    ended_by_time: int | None = None
    period: tuple[str, str, str] | None = None


@dataclass(frozen=True)
class CellCheck:
    """One variable of some cells held against what it has to be.

    Parameters
    ----------
    name : str
        The variable.
    against : str
        What it was held against, in words.
    difference, allowed : array, shape (n,)
        How far each value is from what it has to be, and how far it may be; NaN where a value is missing that has to be
        there, or the reverse. In the unit of the variable.
    judged : array of bool, shape (n,)
        Which cells were held against anything.
    promise : bool
        Whether only this version of the code promises it: files made by other code are not judged by it.
    share : float
        Share of the judged cells that may be further off than is allowed.
    unknown : array of bool, shape (n,), optional
        Of which values it is not known what they have to be, only whether they are missing, or their range.
    """

    name: str
    against: str
    difference: Array
    allowed: Array
    judged: Truths
    promise: bool = False
    share: float = 0.0
    unknown: Truths | None = None

    @property
    def wrong(self) -> Truths:
        """Which of the judged cells are further off than is allowed."""
        # written so that NaN is wrong
        found: Truths = self.judged & ~(self.difference <= self.allowed)
        return found


class Reference(Protocol):
    """What `verify` holds the cells of an atlas against."""

    @property
    def audit(self) -> Audit:
        """What `verify` stores."""

    @property
    def sampled(self) -> str:
        """Which cells were held against more than themselves, in words, where these are only a sample; else empty."""

    def needed(self, spec: "Request") -> tuple[str, ...]:
        """Return the variables of an atlas that `check` reads."""

    def truth(self, spec: "Request", starts: "Starts", first: int, stored: "Columns") -> "Columns":
        """Return what `check` holds cells with these starts, shape (n,), against: this calls kernels.

        `first` is the number of the first of them in the atlas, which holds `stored`.
        """

    def check(
        self, spec: "Request", starts: "Starts", stored: "Columns", truth: "Columns"
    ) -> tuple[dict[str, npt.NDArray[Any]], Sequence[CellCheck]]:
        """Hold cells with these starts and stored values, shape (n,), against their `truth`; this calls no kernel.

        `stored` has the variables `needed`, and others that the atlas holds of its cells. Returns the variables of
        `audit`, and the check of each variable.
        """


class ExactReference(Reference, Protocol):
    """A way to the extremes of a motion without time stepping; a model may lack it."""

    @property
    def variables(self) -> Mapping[str, Quantity]:
        """The table of what an atlas of ``method=exact`` holds besides."""

    @property
    def compared(self) -> tuple[str, ...]:
        """Measures that have an exact value, in the order in which `explain` shows them."""

    def measures(
        self, spec: "Request", starts: "Starts", extremes_only: bool = False
    ) -> dict[str, npt.NDArray[Any]]:
        """Return the measures and counts of a model, and `variables`, for starts of shape (n,).

        With `extremes_only` measures may be NaN that no verdict needs.
        """

    def untimed(self, spec: "Request") -> str:
        """Return what an atlas of a spec does not know because it was made without time; empty if it knows all."""
