"""What counts as unstable: the criteria of stability.

``departure:5deg``: the tilt leaves its steady value by more than 5 degrees. ``amplification:10``: it leaves it by
more than ten times the scale of the perturbation that was put in. A criterion is one class of this file: how it is
written, its verdict, the limit that theory and figures draw, and its words.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model.description import FINAL, LOST, OPEN, Columns, Endings, Model, Request
from sweep.model.quantity import DECISION, STABLE, UNDECIDED, UNSTABLE, Array, Quantity
from sweep.request.values import read_number

_DEPARTURE = Quantity("departure", "", "rad", "largest distance from the steady value", DECISION)
_AMPLIFICATION = Quantity("amplification", "", "1", "that distance over the perturbation", DECISION)


@dataclass(frozen=True)
class Criterion:
    """A rule for which cells are unstable; `Criterion(kind, limit)` and `Criterion.parse` return one of its kinds.

    Parameters
    ----------
    kind : {"departure", "amplification"}
        What is limited: the distance from the steady tilt, or that distance over the scale of the perturbation.
    limit : float
        The largest stable value: rad, between 0 and pi (departure), or a positive number (amplification).

    Raises
    ------
    RequestError
        If the kind is not known or the limit out of its range.
    """

    kind: str
    limit: float

    #: How it is written, and an example.
    form: ClassVar[str]
    example: ClassVar[str]

    #: The quantity that the limit is read as.
    quantity: ClassVar[Quantity]

    def __new__(cls, kind: str = "", *_: Any, **__: Any) -> Self:
        """Return a criterion of the class that its kind names."""
        if cls is Criterion and kind not in _KINDS:
            raise _unknown(kind)
        return super().__new__(_KINDS[kind] if cls is Criterion else cls)  # type: ignore[return-value]

    def __post_init__(self) -> None:
        """Read the limit, and refuse one that is not possible."""
        object.__setattr__(self, "limit", read_number(self.limit, self.quantity))
        if not self.limit > 0.0:
            raise RequestError(
                f"The limit of a criterion must be above 0, or nothing is stable; got {self}.",
                hint=f"Write {self.example}.",
                where="criterion",
            )

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what pickle makes the criterion again from."""
        return Criterion, (self.kind, self.limit)

    @staticmethod
    def parse(text: str) -> "Criterion":
        """Return the criterion that a text spells; `str` gives the text back.

        Raises
        ------
        RequestError
            If it is the text of none, for example ``departure:ANGLE`` or ``amplification:NUMBER``.
        """
        for kind, criterion in _KINDS.items():
            try:
                found = criterion.read(kind, text)
            except RequestError as error:
                raise error.at(f"criterion={shown(text)}") from None
            if found is not None:
                return found
        raise _unknown(text)

    @classmethod
    def read(cls, kind: str, text: str) -> Self | None:
        """Return the criterion of this class that a text spells; None if it is not of its form, here ``KIND:LIMIT``.

        Raises
        ------
        RequestError
            If the limit is not possible.
        """
        word, colon, limit = text.partition(":")
        if word.strip() != kind or not colon:
            return None
        return cls(kind, read_number(limit, cls.quantity))

    def __str__(self) -> str:
        """Return the criterion as it is written in a request; `parse` gives exactly this criterion back."""
        raise NotImplementedError

    def allowed(self, scale: Array) -> Array:
        """Return the largest stable distance from the undisturbed value, for perturbations of a given size.

        Parameters
        ----------
        scale : array of float, shape (...)
            Size of the perturbation (`sweep.model.description.Model.perturbation`), in the unit of the coordinate.

        Returns
        -------
        array of float, shape (...)
            In the same unit; NaN where the criterion says nothing.
        """
        raise NotImplementedError

    def limit_text(self, coordinate: Quantity) -> str:
        """Return how far the coordinate must not go, in words: ``5 deg``, ``10 times the perturbation``."""
        raise NotImplementedError

    def limit_label(self, coordinate: Quantity) -> str:
        """Return the limit as a figure writes it: ``5°``."""
        raise NotImplementedError

    def unstable_if(self, model: Model) -> str:
        """Return what makes a cell unstable, in words."""
        lost = f", or {model.lost_name}" if model.lost_name else ""
        limit = self.limit_text(model.parameters[model.coordinate])
        return f"the {_plain(model.coordinate)} leaves its steady value by more than {limit}{lost}"

    def label(self, model: Model) -> str:
        """Return the criterion as a figure names it: ``departure 5°``."""
        return f"{self.kind} {self.limit_label(model.parameters[model.coordinate])}"

    def caption(self, model: Model) -> str:
        """Return what makes a cell unstable, as short as a figure says it."""
        lost = f", or {model.lost_name}" if model.lost_name else ""
        return f"{self.kind} above {self.limit_label(model.parameters[model.coordinate])}{lost}"

    def reason(self, spec: Request, stored: Mapping[str, float], reach: float, scale: float) -> str:
        """Return why a cell that was computed has its verdict.

        Parameters
        ----------
        spec : Request
        stored : mapping of str to float
            The variables of the cell.
        reach, scale : float
            How far it went from its undisturbed value, and the size of its perturbation, in the unit of the coordinate.
        """
        model, ending = spec.model, spec.model.endings.of(stored["ending"])
        if ending.role == LOST:
            return model.lost_in_words(spec, stored)
        coordinate = model.parameters[model.coordinate]
        far, name = coordinate.spell(reach, 6), _plain(model.coordinate)
        limit = f"the {coordinate.spell(float(self.allowed(np.array(scale))), 6)} of the criterion"
        if self.limit_text(coordinate) != coordinate.spell(self.limit, 6):
            limit += f" ({self.limit_text(coordinate)}, {coordinate.spell(scale, 6)})"
        if stored["stability"] == UNSTABLE:
            return f"the {name} left its steady value by {far}, more than {limit}"
        if stored["stability"] == STABLE:
            return f"the {name} never leaves its steady value by more than {far}, at most {limit}; {ending.reason}"
        return (
            f"the {name} has left its steady value by {far}, at most {limit}, but the duration of "
            f"{spec.duration:g} s {ending.reason}"
        )

    def needs(self, model: Model) -> tuple[str, ...]:
        """Return the variables of an atlas from which the verdicts follow."""
        return ("ending", *model.extremes)

    def verdict(
        self, endings: Endings, measured: Columns, reach: Array, scale: Array
    ) -> npt.NDArray[np.int8]:
        """Return the stability of cells: 0 undecided, 1 stable, 2 unstable.

        Parameters
        ----------
        endings : Endings
            Those of the model.
        measured : mapping of str to array, shape (...)
            The variables of the cells that the criterion `needs`; ``ending`` holds codes of `endings`.
        reach : array of float, shape (...)
            How far the coordinate went from its undisturbed value; NaN where a cell has no extremes.
        scale : array of float, broadcastable
            Size of the perturbation, in the same unit.

        Returns
        -------
        array of int8, shape (...)

        Notes
        -----
        A lost motion is unstable (a fall). A departure beyond the limit is unstable, even if time ran out after it.
        Only a cell whose extremes are final and within the limit is stable. All others are undecided, and so is every
        cell that could not be resolved, whatever its extremes say.
        """
        ending, limit = measured["ending"], self.allowed(scale)
        final = endings.have(FINAL, ending)
        # Both comparisons are false for NaN: a cell without numbers is neither stable nor unstable.
        beyond = (final | endings.have(OPEN, ending)) & (reach > limit)
        kept = np.where(final & (reach <= limit), STABLE, UNDECIDED)
        return np.where(beyond | endings.have(LOST, ending), UNSTABLE, kept).astype(np.int8)


class Departure(Criterion):
    """The coordinate leaves its undisturbed value by more than an angle."""

    form, example, quantity = "departure:ANGLE", "departure:5deg", _DEPARTURE

    def __post_init__(self) -> None:
        """Refuse an angle that no motion can reach."""
        super().__post_init__()
        # Two tilts inside +-90 deg are never further apart: such a limit is degrees taken for radians.
        if self.limit >= math.pi:
            raise RequestError(
                f"A departure must be below 180 deg; a bare number is in rad. Got {self}.",
                hint=f"Write {self.example}.",
                where="criterion",
            )

    def __str__(self) -> str:
        """Return ``departure:ANGLE``."""
        # Degrees where they say exactly the same angle, because 5deg can be read and 0.08726646259971647rad cannot.
        degrees = f"{round(math.degrees(self.limit), 9):.15g}"
        exact = math.radians(float(degrees)) == self.limit
        return f"{self.kind}:{degrees}deg" if exact else f"{self.kind}:{self.limit!r}rad"

    def allowed(self, scale: Array) -> Array:
        """Return the limit."""
        return np.full(np.shape(scale), self.limit)

    def limit_text(self, coordinate: Quantity) -> str:
        """Return the angle."""
        return coordinate.spell(self.limit, 6)

    def limit_label(self, coordinate: Quantity) -> str:
        """Return the angle."""
        return coordinate.spell(self.limit, 4).replace(" deg", "°")


class Amplification(Criterion):
    """The coordinate leaves its undisturbed value by more than a multiple of the perturbation."""

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


_KINDS: dict[str, type[Criterion]] = {"departure": Departure, "amplification": Amplification}


def _unknown(text: str) -> RequestError:
    return RequestError(
        f"{shown(text)} is no criterion. A criterion is {' or '.join(each.form for each in _KINDS.values())}.",
        hint=f"Write {' or '.join(each.example for each in _KINDS.values())}.",
        where="criterion",
    )


def _plain(name: str) -> str:
    return name.replace("_", " ")
