"""The variables that `verify` stores, and the check of one variable."""

from collections.abc import Mapping
from dataclasses import dataclass

from sweep.model.quantity import Array, Quantity, Truths


@dataclass(frozen=True)
class Audit:
    """The variables that `verify` stores for each cell, and the meaning of its codes.

    `variables` is the table; its enumerated quantity ``audit`` has the codes. `other`, one of `disagreeing`, is the
    code of a cell with a wrong variable that the model itself did not check. `ended_by_time` is the code of a cell that
    ran out of time, so that its difference means nothing. The report shows the distribution of the variable
    `difference`, in `units`, after the words `told`. `period` names the variables with the error of the period, the
    exact period, and the error over the allowed error. `summary` describes the audit in its file.
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
    """One variable of some cells, compared with its expected values.

    Parameters
    ----------
    name : str
        The variable.
    against : str
        What it was compared with, in words.
    difference, allowed : array, shape (n,)
        Difference from the expected value, and the allowed difference, in the unit of the variable. NaN where a value
        is missing and should not be, or the reverse.
    judged : array of bool, shape (n,)
        Which cells were compared.
    promise : bool
        Whether only this version of the code promises it: files made by other code are not judged by it.
    share : float
        Share of the judged cells that may exceed the allowed difference.
    unknown : array of bool, shape (n,), optional
        Which values have no expected value: only their range, or whether they are missing, was checked.
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
        """Which of the judged cells exceed the allowed difference."""
        # written so that NaN is wrong
        wrong: Truths = self.judged & ~(self.difference <= self.allowed)
        return wrong
