"""What every criterion of stability does: the base class, which knows its kinds by their words."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model import registry
from sweep.model.cells import stated_error
from sweep.model.description import Columns, Model, Request, Starts
from sweep.model.quantity import LOST, UNDECIDED, Array, Endings, Truths

#: Variable -> how far its values may be off, in its unit.
Errors = Callable[[str], Array | float]

#: The word of each kind -> its class.
_KINDS: dict[str, type["Criterion"]] = {}


class Criterion:
    """A rule for which cells are unstable, made by ``Criterion(kind, limit)`` or `sweep.Criterion.parse`.

    Parameters
    ----------
    kind : {"departure", "amplification", "aloft"}
        What is limited: the distance from the steady tilt, that distance over the scale of the perturbation, or the
        time before which the motion must not be lost.
    limit : float
        The largest stable value: rad, between 0 and pi (departure), or a positive number (amplification); the time, s.

    Raises
    ------
    RequestError
        If the kind is not known or the limit out of its range.
    """

    #: How it is written, and an example.
    form: ClassVar[str]
    example: ClassVar[str]

    #: Whether it limits how far the coordinate goes: then a lost motion is unstable, and what was unstable when time
    #: ran out stays so.
    limits_reach: ClassVar[bool] = False

    #: Whether theory may predict its boundary.
    predictable: ClassVar[bool] = False

    #: The word that names the kind.
    word: ClassVar[str]

    def __init_subclass__(cls) -> None:
        """Make a kind known by its word."""
        if "word" in vars(cls):
            _KINDS[cls.word] = cls

    def __new__(cls, kind: Any = "", *_: Any, **__: Any) -> Self:
        """Return a criterion of the class that its kind names."""
        if cls is Criterion and kind not in _KINDS:
            raise _unknown(kind)
        return super().__new__(_KINDS[kind] if cls is Criterion else cls)  # type: ignore[return-value]

    @staticmethod
    def parse(text: str, model: Model | None = None) -> "Criterion":
        """Return the criterion that a text spells; `str` gives the text back.

        Parameters
        ----------
        text : str
            ``departure:ANGLE``, ``amplification:NUMBER``, ``aloft:TIME``, or an expression (docs/atlas.md).
        model : Model, optional
            Whose variables and parameters an expression may name; the default one, the disk, if not given.

        Raises
        ------
        RequestError
            If it is the text of none.
        """
        of = model or registry.named(registry.DEFAULT)
        for kind in _KINDS.values():
            try:
                found = kind.read(text, of)
            except RequestError as error:
                raise error.at(f"criterion={shown(text)}") from None
            if found is not None:
                return found
        raise _unknown(text)

    @classmethod
    def read(cls, text: str, model: Model) -> Self | None:
        """Return the criterion of this class that a text spells; None if it is not of its form.

        Raises
        ------
        RequestError
            If it is of its form, and not possible.
        """
        raise NotImplementedError

    def kept(self) -> Any:
        """Return what the canonical text of a spec holds of it: plain types."""
        return asdict(self)  # type: ignore[call-overload]  # every kind is a dataclass

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
        return np.full(np.shape(scale), np.nan)

    def unstable_if(self, model: Model) -> str:
        """Return what makes a cell unstable, in words."""
        raise NotImplementedError

    def label(self, model: Model) -> str:
        """Return the criterion as a figure names it: ``departure 5°``."""
        return str(self)

    def caption(self, model: Model) -> str:
        """Return what makes a cell unstable, as short as a figure says it."""
        return self.label(model)

    def comment(self, model: Model) -> str:
        """Return what the file says of the verdicts, if it is not what it says of them by a limit; ASCII."""
        return ""

    def reason(self, spec: Request, cell: Mapping[str, float], reach: float, scale: float) -> str:
        """Return why a cell that was computed has its verdict.

        Parameters
        ----------
        spec : Request
        cell : mapping of str to float
            The start and the variables of the cell.
        reach, scale : float
            How far it went from its undisturbed value, and the size of its perturbation, in the unit of the coordinate.
        """
        raise NotImplementedError

    def needs(self, model: Model) -> tuple[str, ...]:
        """Return the variables of an atlas from which the verdicts follow."""
        raise NotImplementedError

    def check(self, spec: Request) -> None:
        """Refuse a spec that the criterion cannot judge; most criteria judge any.

        Raises
        ------
        RequestError
        """

    def check_new_cells(self) -> None:
        """Refuse to judge cells that have not been computed yet; most criteria can.

        Raises
        ------
        RequestError
        """

    def verdict(
        self, endings: Endings, measured: Columns, reach: Array, scale: Array
    ) -> npt.NDArray[np.int8]:
        """Return the stability of cells: 0 undecided, 1 stable, 2 unstable.

        Parameters
        ----------
        endings : Endings
            Those of the model.
        measured : mapping of str to array, shape (...)
            The variables of the cells that the criterion `needs`, and their starts; ``ending`` holds codes of
            `endings`.
        reach : array of float, shape (...)
            How far the coordinate went from its undisturbed value; NaN where a cell has no extremes.
        scale : array of float, broadcastable
            Size of the perturbation, in the same unit.

        Returns
        -------
        array of int8, shape (...)
        """
        raise NotImplementedError

    def on_edge(self, spec: Request, starts: Starts, columns: Sequence[Columns], errors: Errors) -> Truths:
        """Return which cells have the edge of the criterion within the span of their variables.

        Parameters
        ----------
        spec : Request
        starts : mapping of str to array, shape (n,)
        columns : sequence of mapping of str to array, shape (n,)
            One or more sets of the variables that the criterion `needs`, and of the extremes, of the same cells.
        errors : Errors
            By how much each of them may be off.

        Returns
        -------
        array of bool, shape (n,)
            False where a value is missing.
        """
        raise NotImplementedError

    def is_open(self, spec: Request, starts: Starts, measured: Columns, error: Array) -> Truths:
        """Return which cells may have another verdict because their extremes are off by `error`.

        Parameters
        ----------
        spec : Request
        starts : mapping of str to array, shape (n,)
        measured : mapping of str to array, shape (n,)
            All variables of the cells.
        error : array of float, shape (n,)
            In the unit of the coordinate.

        Returns
        -------
        array of bool, shape (n,)
            Where the errors of the variables leave the verdict open, or a loss may add what it follows from.
        """
        model, quantities = spec.model, spec.model.cell_variables(spec)
        found = self.on_edge(
            spec,
            starts,
            [measured],
            lambda name: stated_error(quantities[name], spec, starts, measured, error),
        )
        if self.follows_from_loss(model):
            found |= ~model.endings.have(LOST, measured["ending"]) & model.may_be_lost(spec, measured, error)
        return np.asarray(found & (measured["stability"] != UNDECIDED))

    def follows_from_loss(self, model: Model) -> bool:
        """Return whether the verdict may be another one where a motion is lost that seemed not to be."""
        return True


def _unknown(text: str) -> RequestError:
    # a kind without a form is not written in words
    kinds = [_KINDS[word] for word in sorted(_KINDS) if _KINDS[word].form]
    forms = [each.form for each in kinds]
    return RequestError(
        f"{shown(text)} is no criterion. A criterion is {', '.join(forms[:-1])} or {forms[-1]}.",
        hint=f"Write {' or '.join(each.example for each in kinds)}.",
        where="criterion",
    )
