"""What counts as unstable: the criteria of stability.

``departure:5deg``: the tilt leaves its steady value by more than 5 degrees. ``amplification:10``: it leaves it by
more than ten times the scale of the perturbation that was put in. ``aloft:10s``: the disk falls before 10 seconds are
over (`sweep.request.criterion`). ``peak_tilt > 10deg or fall_time < 2s``: a criterion
of one's own (`sweep.request.own_criterion`). A criterion is one class: how it is written, its verdict, the limit that
theory and figures draw, if it has one, and its words.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
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
from sweep.request.criterion_base import Criterion as Criterion
from sweep.request.criterion_base import Errors
from sweep.request.expression import spell_angle
from sweep.request.own_criterion import Expression as Expression
from sweep.request.own_criterion import Function as Function
from sweep.request.own_criterion import where_true as where_true
from sweep.request.values import read_number

_DEPARTURE = Quantity("departure", "", "rad", "largest distance from the steady value", DECISION)
_TIME = Quantity("aloft", "", "s", "time before which the motion must not be lost", DECISION)
_AMPLIFICATION = Quantity("amplification", "", "1", "that distance over the perturbation", DECISION)


@dataclass(frozen=True)
class _Limited(Criterion):
    """A criterion that is written ``KIND:LIMIT``."""

    kind: str
    limit: float

    #: The quantity that the limit is read as, and why it has to be above 0.
    quantity: ClassVar[Quantity]
    positive: ClassVar[str]
    predictable: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Read the limit, and refuse one that is not possible."""
        given = f"{self.kind}:{shown(self.limit)}"
        object.__setattr__(self, "limit", read_number(self.limit, self.quantity))
        if not self.limit > 0.0:
            raise RequestError(
                f"{self.positive}; got {given}.", hint=f"Write {self.example}.", where="criterion"
            )

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what pickle makes the criterion again from."""
        return Criterion, (self.kind, self.limit)

    @classmethod
    def read(cls, text: str, model: Model) -> Self | None:
        """Return the criterion that ``KIND:LIMIT`` spells."""
        word, colon, limit = text.partition(":")
        if word.strip() != cls.word or not colon:
            return None
        return cls(cls.word, limit)  # type: ignore[arg-type]  # it is read when it is made


class Limit(_Limited):
    """A limit for the distance of the coordinate from its undisturbed value; see `Criterion`."""

    positive = "The limit of a criterion must be above 0, or nothing is stable"
    limits_reach: ClassVar[bool] = True

    def limit_text(self, coordinate: Quantity) -> str:
        """Return how far the coordinate must not go, in words: ``5 deg``, ``10 times the perturbation``."""
        raise NotImplementedError

    def limit_label(self, coordinate: Quantity) -> str:
        """Return the limit as a figure writes it: ``5°``."""
        raise NotImplementedError

    def unstable_if(self, model: Model) -> str:
        """Return how far is too far, and what else is lost."""
        lost = f", or {model.lost_name}" if model.lost_name else ""
        limit = self.limit_text(model.parameters[model.coordinate])
        return f"the {_plain(model.coordinate)} leaves its steady value by more than {limit}{lost}"

    def label(self, model: Model) -> str:
        """Return the kind and the limit."""
        return f"{self.kind} {self.limit_label(model.parameters[model.coordinate])}"

    def caption(self, model: Model) -> str:
        """Return the kind and the limit, and what else is lost."""
        lost = f", or {model.lost_name}" if model.lost_name else ""
        return f"{self.kind} above {self.limit_label(model.parameters[model.coordinate])}{lost}"

    def reason(self, spec: Request, cell: Mapping[str, float], reach: float, scale: float) -> str:
        """Return how far the cell went, beside the limit."""
        model, ending = spec.model, spec.model.endings.of(cell["ending"])
        if ending.role == LOST:
            return model.lost_in_words(spec, cell)
        coordinate = model.parameters[model.coordinate]
        far, name = coordinate.spell(reach, 6), _plain(model.coordinate)
        limit = f"the {coordinate.spell(float(self.allowed(np.array(scale))), 6)} of the criterion"
        if self.limit_text(coordinate) != coordinate.spell(self.limit, 6):
            limit += f" ({self.limit_text(coordinate)}, {coordinate.spell(scale, 6)})"
        if cell["stability"] == UNSTABLE:
            return f"the {name} left its steady value by {far}, more than {limit}"
        if cell["stability"] == STABLE:
            return f"the {name} never leaves its steady value by more than {far}, at most {limit}; {ending.reason}"
        return f"the {name} has left its steady value by {far}, at most {limit}, but {model.open_in_words(spec, cell)}"

    def needs(self, model: Model) -> tuple[str, ...]:
        """Return the ending and both extremes."""
        return ("ending", *model.extremes)

    def verdict(
        self, endings: Endings, measured: Columns, reach: Array, scale: Array
    ) -> npt.NDArray[np.int8]:
        """Return the stability of cells; see `Criterion.verdict`.

        Notes
        -----
        A lost motion is unstable (a fall). A departure beyond the limit is unstable, even if time ran out after it.
        Only a cell whose extremes are final and within the limit is stable. All others are undecided, and so is every
        cell that could not be resolved, also where its extremes say something.
        """
        ending, limit = measured["ending"], self.allowed(scale)
        final = endings.have(FINAL, ending)
        # Both comparisons are false for NaN: a cell without numbers is neither stable nor unstable.
        beyond = (final | endings.have(OPEN, ending)) & (reach > limit)
        kept = np.where(final & (reach <= limit), STABLE, UNDECIDED)
        return np.where(beyond | endings.have(LOST, ending), UNSTABLE, kept).astype(np.int8)

    def on_edge(self, spec: Request, starts: Starts, columns: Sequence[Columns], errors: Errors) -> Truths:
        """Return which cells may go exactly as far as the limit; see `Criterion.on_edge`."""
        model = spec.model
        with np.errstate(invalid="ignore"):
            reaches = [model.reach(spec, starts, each) for each in columns]
        limit = np.nan_to_num(self.allowed(model.perturbation(spec, starts)))
        slack = errors(model.extremes[1])
        least, most = np.minimum.reduce(reaches) - slack, np.maximum.reduce(reaches) + slack
        return np.asarray((least <= limit) & (limit <= most))

    def is_open(self, spec: Request, starts: Starts, measured: Columns, error: Array) -> Truths:
        """Return where wider and narrower extremes have another verdict, or the motion may be lost."""
        model = spec.model
        low, high = (np.asarray(measured[name], np.float64) for name in model.extremes)
        scale, codes = model.perturbation(spec, starts), []
        for by in (error, -error):
            moved = {**measured, model.extremes[0]: low - by, model.extremes[1]: high + by}
            with np.errstate(invalid="ignore"):
                codes.append(self.verdict(model.endings, moved, model.reach(spec, starts, moved), scale))
        whole = (measured["stability"] == STABLE) & ~model.endings.have(LOST, measured["ending"])
        return np.asarray((codes[0] != codes[1]) | (whole & model.may_be_lost(spec, measured, error)))


class Departure(Limit):
    """The coordinate leaves its undisturbed value by more than an angle."""

    word = "departure"
    form, example, quantity = "departure:ANGLE", "departure:5deg", _DEPARTURE

    def __post_init__(self) -> None:
        """Refuse an angle that no motion can reach."""
        given = f"{self.kind}:{shown(self.limit)}"
        super().__post_init__()
        # Two tilts inside +-90 deg are never further apart: such a limit is degrees taken for radians.
        if self.limit >= math.pi:
            raise RequestError(
                f"A departure must be below 180 deg; a bare number is in rad. Got {given}.",
                hint=f"Write {self.example}.",
                where="criterion",
            )

    def __str__(self) -> str:
        """Return ``departure:ANGLE``."""
        return f"{self.kind}:{spell_angle(self.limit)}"

    def allowed(self, scale: Array) -> Array:
        """Return the limit."""
        return np.full(np.shape(scale), self.limit)

    def limit_text(self, coordinate: Quantity) -> str:
        """Return the angle."""
        return coordinate.spell(self.limit, 6)

    def limit_label(self, coordinate: Quantity) -> str:
        """Return the angle."""
        return coordinate.spell(self.limit, 4).replace(" deg", "°")


class Amplification(Limit):
    """The coordinate leaves its undisturbed value by more than a multiple of the perturbation."""

    word = "amplification"
    form, example, quantity = "amplification:NUMBER", "amplification:10", _AMPLIFICATION

    def __str__(self) -> str:
        """Return ``amplification:NUMBER``."""
        return f"{self.kind}:{self.limit!r}".removesuffix(".0")

    def allowed(self, scale: Array) -> Array:
        """Return the multiple of the perturbation; NaN without one, for nothing is amplified there."""
        return np.where(np.asarray(scale) > 0.0, self.limit * np.asarray(scale), np.nan)

    def limit_text(self, coordinate: Quantity) -> str:
        """Return the multiple."""
        return f"{self.limit:.6g} times the perturbation"

    def limit_label(self, coordinate: Quantity) -> str:
        """Return the multiple."""
        return f"{self.limit:.4g}"


def _plain(name: str) -> str:
    return name.replace("_", " ")


class Aloft(_Limited):
    """A cell is unstable where the motion is lost before a time; see `Criterion`."""

    word = "aloft"
    form, example, quantity = "aloft:TIME", "aloft:10s", _TIME
    positive = "The time of a criterion must be above 0, or every motion lasts as long"

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
        duration, and undecided if how it went on is not known.
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
