"""The criterion of a motion that has to last: unstable where it is lost before a time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model.cells import stated_error
from sweep.model.description import Columns, Model, Request, Starts
from sweep.model.quantity import (
    DECISION,
    FINAL,
    LOST,
    OPEN,
    STABLE,
    UNDECIDED,
    UNSTABLE,
    Array,
    Endings,
    Quantity,
    Truths,
)
from sweep.request.criterion_base import Criterion, Errors
from sweep.request.values import read_number

_TIME = Quantity("aloft", "", "s", "time before which the motion must not be lost", DECISION)


@dataclass(frozen=True)
class Aloft(Criterion):
    """A cell is unstable where the motion is lost before a time; see `Criterion`.

    Parameters
    ----------
    kind : str
        ``aloft``.
    limit : float
        The time [s].
    """

    kind: str
    limit: float

    word: ClassVar[str] = "aloft"
    form: ClassVar[str] = "aloft:TIME"
    example: ClassVar[str] = "aloft:10s"
    predictable: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Read the time, and refuse one before the start."""
        given = f"{self.kind}:{shown(self.limit)}"
        object.__setattr__(self, "limit", read_number(self.limit, _TIME))
        if not self.limit > 0.0:
            raise RequestError(
                f"The time of a criterion must be above 0, or every motion lasts as long; got {given}.",
                hint=f"Write {self.example}.",
                where="criterion",
            )

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what pickle makes the criterion again from."""
        return Criterion, (self.kind, self.limit)

    @classmethod
    def read(cls, text: str, model: Model) -> Self | None:
        """Return the criterion that ``aloft:TIME`` spells."""
        word, colon, limit = text.partition(":")
        if word.strip() != cls.word or not colon:
            return None
        return cls(cls.word, limit)  # type: ignore[arg-type]  # it is read when it is made

    def __str__(self) -> str:
        """Return ``aloft:TIME``."""
        return f"{self.word}:{self.limit!r}".removesuffix(".0") + "s"

    def check(self, spec: Request) -> None:
        """Refuse a model that loses no motion, and a duration in which the time cannot come."""
        if not spec.model.endings.lost_time:
            raise RequestError(
                f"The model {spec.model.name} states of no motion when it is lost: {self} judges by that.",
                hint="Use another criterion.",
                where="criterion",
            )
        if spec.duration < self.limit:
            raise RequestError(
                f"{self} asks for more time than the motions are followed; got duration={spec.duration:g}s.",
                hint=f"Give a duration of {self.limit:g}s or more.",
                where="criterion",
            )

    def unstable_if(self, model: Model) -> str:
        """Return what must not happen, and by when."""
        return f"{model.lost_name} in less than {self.limit:.6g} s"

    def label(self, model: Model) -> str:
        """Return the kind and the time."""
        return f"{self.word} {self.limit:.4g} s"

    def caption(self, model: Model) -> str:
        """Return what is unstable."""
        return f"{self.word} for less than {self.limit:.4g} s"

    def comment(self, model: Model) -> str:
        """Return what the file says of the verdicts."""
        return (
            f"unstable where {model.endings.lost_time} of a lost motion is below {self.limit:g} s; stable where the "
            "motion lasts as long; an unresolved cell is undecided"
        )

    def reason(self, spec: Request, cell: Mapping[str, float], reach: float, scale: float) -> str:
        """Return how long the motion lasted, beside the time."""
        model, ending = spec.model, spec.model.endings.of(cell["ending"])
        time, limit = cell[model.endings.lost_time], f"the {self.limit:.6g} s of the criterion"
        if ending.role == LOST:
            order = "less than" if cell["stability"] == UNSTABLE else "not before"
            return f"{model.lost_name} after {time:.6g} s, {order} {limit}"
        if ending.role == OPEN and cell["stability"] == UNDECIDED:
            return f"before {limit} {model.open_in_words(spec, cell)}"
        lasts = ending.reason if ending.role == FINAL else model.open_in_words(spec, cell)
        return f"the motion was not lost in {limit}; {lasts}"

    def needs(self, model: Model) -> tuple[str, ...]:
        """Return the ending and its time."""
        return ("ending", model.endings.lost_time)

    def verdict(
        self, endings: Endings, measured: Columns, reach: Array, scale: Array
    ) -> npt.NDArray[np.int8]:
        """Return the stability of cells; see `Criterion.verdict`.

        Notes
        -----
        A motion that ended otherwise than by a loss before the time is stable if it goes on for all time or for the
        duration, and undecided if nobody knows how it went on.
        """
        ending = measured["ending"]
        # no comparison with a missing time holds: such a motion ended with the duration
        early = np.asarray(measured[endings.lost_time]) < self.limit
        lost, open_ = endings.have(LOST, ending), endings.have(OPEN, ending)
        lasts = endings.have(FINAL, ending) | ((lost | open_) & ~early)
        return np.where(lost & early, UNSTABLE, np.where(lasts, STABLE, UNDECIDED)).astype(np.int8)

    def on_edge(self, spec: Request, starts: Starts, columns: Sequence[Columns], errors: Errors) -> Truths:
        """Return which motions may be lost exactly at the time; see `Criterion.on_edge`."""
        name = spec.model.endings.lost_time
        times, slack = [each[name] for each in columns], errors(name)
        lost = np.any([spec.model.endings.have(LOST, each["ending"]) for each in columns], axis=0)
        least, most = np.fmin.reduce(times) - slack, np.fmax.reduce(times) + slack
        return np.asarray(lost & (least <= self.limit) & (self.limit <= most))

    def is_open(self, spec: Request, starts: Starts, measured: Columns, error: Array) -> Truths:
        """Return where the error of the time leaves the verdict open, or the motion may be lost."""
        model = spec.model
        quantity = model.variables[model.endings.lost_time]
        slack = stated_error(quantity, spec, starts, measured, error)
        found = self.on_edge(spec, starts, [measured], lambda _: slack)
        found |= ~model.endings.have(LOST, measured["ending"]) & model.may_be_lost(spec, measured, error)
        return np.asarray(found & (measured["stability"] != UNDECIDED))
