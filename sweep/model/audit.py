"""The variables that `verify` stores, and the check of one variable."""

from collections.abc import Mapping
from dataclasses import dataclass

from sweep.model.quantity import Array, Quantity, Truths


@dataclass(frozen=True)
class Audit:
    """The variables that `verify` stores for each cell, and the meaning of its codes.

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
    """One variable of some cells compared with what it has to be.

    Parameters
    ----------
    name : str
        The variable.
    against : str
        What it was compared with, in words.
    difference, allowed : array, shape (n,)
        How far each value is from what it has to be, and how far it may be; NaN where a value is missing that has to be
        there, or the reverse. In the unit of the variable.
    judged : array of bool, shape (n,)
        Which cells were compared with anything.
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
