"""The base class of all models, and its parts.

A model is a mechanical system whose starts are integrated and judged. The other rooms of `sweep` know the system only
through this class; docs/architecture.md walks through a complete model.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError
from sweep.model.audit import Audit, CellCheck
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array, Endings, Input, Quantity, Substitute, Truths, Word

#: Values of named quantities, one per cell, shape (n,) each.
Columns = Mapping[str, npt.NDArray[Any]]
Starts = Mapping[str, Array]


@dataclass(frozen=True)
class Words:
    """CF and ACDD attributes that describe a model in the file of an atlas; ASCII.

    `summary` has one placeholder ``{}`` for how the cells were computed.
    """

    summary: str
    keywords: str
    references: str


@dataclass(frozen=True)
class LineWords:
    """The names of the lines of theory along a control.

    Parameters
    ----------
    critical, predicted : str
        Descriptions of the two lines in the file, with one placeholder for the parameter; ASCII.
    limit, told : str
        The words after the critical and the predicted value of one cell in `explain`.
    label : str
        The predicted line in a legend, with one placeholder for the criterion.
    bound : bool
        Whether the predicted line is only an upper bound: the boundary may be well below it.
    """

    critical: str = "analytic critical {}, the limit of a vanishing perturbation"
    predicted: str = "{} at which theory puts the boundary for this criterion and perturbation"
    limit: str = "in the limit of no perturbation"
    told: str = "predicted for this start and this criterion"
    label: str = "predicted, {}"
    bound: bool = False


class Request(Protocol):
    """The part of a spec that a model uses: its parameters, settings and options, by their names."""

    @property
    def model(self) -> "Model":
        """The model that the spec names."""

    @property
    def axes(self) -> tuple[str, ...]:
        """Parameters that are axes of the grid."""

    @property
    def criterion(self) -> Any:
        """The criterion of instability (`sweep.request.criterion.Criterion`)."""

    def __getattr__(self, name: str) -> Any:
        """Return the value of a word."""


class Reference(Protocol):
    """The reference that `verify` compares cells with."""

    @property
    def audit(self) -> Audit:
        """The variables that `verify` stores."""

    @property
    def sampled(self) -> str:
        """A description of the sample, if only a sample of cells is compared with another method; else empty."""

    def needed(self, spec: Request) -> tuple[str, ...]:
        """Return the variables of an atlas that `check` reads."""

    def truth(self, spec: Request, starts: Starts, first: int, stored: Columns) -> Columns:
        """Return the expected values of cells with these starts, shape (n,); this calls kernels.

        `first` is the index of the first of these cells in the atlas; `stored` has their variables in the atlas.
        """

    def check(
        self, spec: Request, starts: Starts, stored: Columns, truth: Columns
    ) -> tuple[dict[str, npt.NDArray[Any]], Sequence[CellCheck]]:
        """Compare cells with these starts and stored values, shape (n,), with their `truth`; this calls no kernel.

        `stored` has the variables `needed`, and other variables of the cells. Returns the variables of `audit`, and
        the check of each variable.
        """


class ExactReference(Reference, Protocol):
    """A method that finds the extremes of a motion without time stepping; not all models have one."""

    @property
    def variables(self) -> Mapping[str, Quantity]:
        """The table of the variables that only an atlas of ``method=exact`` has."""

    @property
    def compared(self) -> tuple[str, ...]:
        """Measures that have an exact value, in the order in which `explain` shows them."""

    def measures(
        self, spec: Request, starts: Starts, extremes_only: bool = False
    ) -> dict[str, npt.NDArray[Any]]:
        """Return the measures and counts of a model, and `variables`, for starts of shape (n,).

        With `extremes_only`, measures that no verdict needs may be NaN.
        """

    def untimed(self, spec: Request) -> str:
        """Return which variables an atlas of a spec lacks because it was made without time; empty if none."""


class Model(ABC):
    """A mechanical system that the engine integrates.

    Attributes
    ----------
    name : str
        The value of ``model=``.
    parameters : mapping of str to Input
        The start and the system, in the order of the rows of the kernels' array of starts; each can be an axis.
    settings : mapping of str to Input
        Numbers that are the same for all cells, in the order of the kernels' array of settings. They include
        `duration`, `step` (0 for ``auto``) and `tolerance`.
    options : mapping of str to Word
        Settings that are text, in addition to the engine's own.
    substitutes : mapping of str to Substitute
        Quantities that a request may give instead of a parameter.
    methods, devices : tuple of str
        The methods that compute cells (``exact`` needs `exact`), and the devices that integrate them, the default
        first.
    endings : Endings
    variables : mapping of str to Quantity
        The variables of every cell, in the order of the file: ``ending``, ``stability``, all of `measures` and
        `counts`, and the variables that `derive` adds.
    measures, counts : tuple of str
        Rows of the arrays that the kernel `integrate` writes, float64 and int32.
    coordinate : str
        The parameter whose distance from its undisturbed value a criterion limits; empty if there is none.
    extremes : tuple of two str
        The measures with the smallest and the largest value of the coordinate; empty without a coordinate.
    default_criterion : str
        The criterion of a request that names none.
    criterion_words : mapping of str to str
        Text of a criterion -> what makes a cell unstable, in the words of captions.
    text : str
        The definition of the model that an atlas carries, if the name is not enough.
    error_name : str
        The measure with the estimated error of the extremes.
    of_criterion : tuple of str
        Measures that depend on the criterion: they are dropped when an atlas is judged by another criterion.
    chosen_by : tuple of str
        Words that choose this model in a request that names none, if the default model does not know them.
    does_without : tuple of str
        Words of a file or of another spec that are dropped when a request changes to this model.
    peak : str
        The variable that reports show; maps show it too, unless `drawn` names another one.
    drawn : str
        The variable that gives maps their colour; empty for `peak`.
    shown : tuple of str
        Other variables that the explorer offers.
    lost_name : str
        What happens to a lost motion, for captions; empty if no motion can be lost.
    presets : Path
        Folder of the specs that come with the model, NAME.toml.
    integrate : Kernel
        integrate(starts, settings, measures, counts), which ``kernels.lanes.binding.bind`` makes from the LANE_MODEL
        in the same module.
    words : Words
    line_words : LineWords
    synonyms : mapping of str to str
        Letters of the equations and names in textbooks -> names of parameters and substitutes, for suggestions.
    ambiguous : mapping of str to str
        Part of an unknown word -> what to write instead.
    exact : ExactReference or None
    additions : mapping of str to mapping of str to Quantity
        Words of a request -> the variables of every cell that they add.
    unknown_to : mapping of str to sequence of str
        Method -> variables whose values it does not find.
    trajectory, regimes : str
        ``module:function`` that draws the motion of an explained cell (``explain --plot``), and the kinds of motion of
        atlases (``plot --regimes``); empty if the model has none.
    losses : str
        ``module:function`` that draws time and largest loss of atlases (``plot --losses``); empty if nothing is lost.
    motion : str
        ``module:object``, the kind of its motions in time (a ``MotionKind``), or a function that makes it from the
        model; empty if ``simulate`` does not know the model.
    in_time : str
        ``module:function`` that follows one cell in time for ``explain`` and returns the variables that this gives:
        (spec, start, stored) -> mapping of str to (value, error); empty if the model has none.
    """

    name: str
    parameters: Mapping[str, Input]
    settings: Mapping[str, Input]
    options: Mapping[str, Word] = MappingProxyType({})
    substitutes: Mapping[str, Substitute] = MappingProxyType({})
    methods: tuple[str, ...] = ("rk4",)
    devices: tuple[str, ...] = ("cpu", "cuda")
    endings: Endings
    variables: Mapping[str, Quantity]
    measures: tuple[str, ...]
    counts: tuple[str, ...]
    coordinate: str
    extremes: tuple[str, ...]
    default_criterion: str = "departure:5deg"
    criterion_words: Mapping[str, str] = MappingProxyType({})
    text: str = ""
    error_name: str
    of_criterion: tuple[str, ...] = ()
    peak: str
    drawn: str = ""
    shown: tuple[str, ...] = ()
    lost_name: str = ""
    chosen_by: tuple[str, ...] = ()
    does_without: tuple[str, ...] = ()
    presets: Path
    integrate: Kernel
    words: Words
    line_words: LineWords = LineWords()
    synonyms: Mapping[str, str] = MappingProxyType({})
    ambiguous: Mapping[str, str] = MappingProxyType({})
    exact: "ExactReference | None" = None
    additions: Mapping[str, Mapping[str, Quantity]] = MappingProxyType({})
    unknown_to: Mapping[str, Sequence[str]] = MappingProxyType({})
    trajectory: str = ""
    regimes: str = ""
    losses: str = ""
    in_time: str = ""
    motion: str = ""

    @abstractmethod
    def subject(self, spec: Request) -> tuple[str, str]:
        """Return what moves in the cells of a spec, and what is asked of it; the second may be empty."""

    def headline(self, spec: Request) -> str:
        """Return the title of a spec that has none, in one line."""
        motion, question = self.subject(spec)
        return f"{motion}: {question}" if question else motion

    @abstractmethod
    def undisturbed(self, spec: Request, starts: Starts) -> Array:
        """Return the coordinate of the undisturbed motion of each start, in its SI unit."""

    @abstractmethod
    def perturbation(self, spec: Request, starts: Starts) -> Array:
        """Return the size of the perturbation of each start, in the SI unit of the coordinate."""

    def disturbed_motion(self, spec: Request, start: Mapping[str, float]) -> str:
        """Return the name of the undisturbed motion of a start, in words."""
        return "the undisturbed motion"

    def methods_for(self, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return the `methods` that can compute the cells of a request with these values, the default first."""
        del values
        return self.methods

    def check(self, values: Mapping[str, Any]) -> None:
        """Refuse values of a request that do not fit together; by default all do.

        Raises
        ------
        RequestError
        """
        del values

    def complete(self, spec: Request, starts: Starts) -> Starts:
        """Return starts completed by the parameters for which the request has a word instead of a number."""
        return starts

    def cell_variables(self, spec: Request) -> Mapping[str, Quantity]:
        """Return the variables of a cell for the method and the options of a spec."""
        exact = self.exact.variables if self.exact is not None and spec.method == "exact" else {}
        return {**self.variables, **exact}

    @property
    def measured(self) -> frozenset[str]:
        """The variables that cannot be derived from others: by default all that the kernel writes."""
        return frozenset({*self.measures, *self.counts})

    @property
    def from_extremes(self) -> frozenset[str]:
        """The extremes, and the variables derived from them and the start."""
        return frozenset(self.extremes) | (self.variables.keys() - self.measured)

    def reference(self, size: int, seed: int | None = None) -> Reference | None:
        """Return the reference of ``eulerdisk verify``: by default the exact reference, or None.

        The atlas has `size` cells. If the reference draws a sample of them, `seed` determines it; without a seed every
        sample differs.
        """
        return self.exact

    def integrator(self, spec: Request) -> Kernel:
        """Return the kernel that integrates the cells of a spec: `integrate`, or a variant of it."""
        return self.integrate

    def kernel_settings(self, spec: Request) -> Array:
        """Return the array of settings with which `integrator` is called."""
        values = (getattr(spec, name) for name in self.settings)
        return np.array([0.0 if isinstance(value, str) else value for value in values])

    def kernels(self, spec: Request) -> tuple[Kernel, ...]:
        """Return the compiled functions that compute the cells of a spec: their code determines the bits."""
        return (self.integrator(spec),)

    def code(self, spec: Request) -> Sequence[str | Callable[..., Any]]:
        """Return the modules and functions, except the kernels, that determine the bits of the measures.

        By default the module of the model, if it overrides `complete` or `measure_more`. `Model.kernels` are hashed
        in addition.
        """
        own = (type(self).complete, type(self).measure_more) != (Model.complete, Model.measure_more)
        return [type(self).__module__] if own else []

    def measure_more(self, spec: Request, starts: Starts, measured: Columns) -> Columns:
        """Return measures that need another kernel, from the measures of `integrate` or `exact`."""
        return {}

    def derive(self, starts: Starts, measured: Columns) -> Columns:
        """Return the variables derived from the measures, except ``stability`` and ``amplification``."""
        return {}

    def lines(self, spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
        """Return the edges of the unstable band along an axis, from theory.

        Parameters
        ----------
        spec : Request
        axis : str
            A control parameter that is an axis of the spec.
        starts : mapping of str to array, shape (n,)
            The starts of rows along that axis; their values of the axis itself do not matter.

        Returns
        -------
        dict of str to (critical, predicted)
            ``"upper"`` (stable above) and ``"lower"`` (stable below), if theory has such an edge. Two arrays of shape
            (n,) in the SI unit of the axis: the limit of a vanishing perturbation, and the value at which the
            criterion changes its verdict for the perturbation of the spec. NaN where theory has no value.
        """
        return {}

    def line_label(self, spec: Request, axis: str) -> str:
        """Return the formula of the critical line along an axis, in mathtext; empty if there is none.

        An equation, or the right-hand side of one for the square of the parameter.
        """
        return ""

    def joined_edges(self, spec: Request) -> tuple[str, str] | None:
        """Return the names of the two ends of the analytic line, if both edges form one curve over the coordinate.

        In mathtext, the end of the upper edge first; both ends lie at zero of the coordinate. None for separate lines.
        """
        return None

    def unit_of_square(self, spec: Request, axis: str) -> tuple[float, str] | None:
        """Return the unit in which the square of a control parameter is a pure number, and its name in mathtext.

        None if that unit differs between cells, or the model has none.
        """
        return None

    def lost_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return how a motion was lost, for a cell with these stored values."""
        return self.endings.of(stored["ending"]).reason

    def open_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return what ended a motion too early for a verdict, for a cell with these stored values."""
        return f"the duration of {spec.duration:g} s {self.endings.of(stored['ending']).reason}"

    def reason_without_verdicts(self, spec: Request) -> str:
        """Return why many cells may have no verdict, and what to request instead; empty if nothing is known."""
        return ""

    def linear_prediction(
        self, spec: Request, start: Mapping[str, float], stored: Mapping[str, float]
    ) -> Iterable[str]:
        """Return lines with the prediction of linear theory for one cell; none if the model has no such theory."""
        return ()

    def slipping(self, dataset: Any, friction: float) -> Any:
        """Return which cells of an atlas need more friction than a coefficient, as an xarray.DataArray of bool.

        Raises
        ------
        RequestError
            If the model or the atlas has no contact forces.
        """
        raise RequestError(
            f"The model {self.name} has no contact forces to compare with friction={friction:g}.",
            hint="Leave the friction out.",
        )

    def reach(self, spec: Request, starts: Starts, measured: Columns) -> Array:
        """Return the largest distance of the coordinate from its undisturbed value [SI]; NaN without extremes."""
        steady = self.undisturbed(spec, starts)
        if not self.extremes:
            return np.full(steady.shape, np.nan)
        low, high = (measured[name] for name in self.extremes)
        return np.asarray(np.maximum(np.abs(high - steady), np.abs(low - steady)))

    def error(self, measured: Columns) -> Array:
        """Return the estimated error of the extremes, in the unit of the coordinate; NaN where it is not known."""
        return np.asarray(measured[self.error_name], np.float64)

    def may_be_lost(self, spec: Request, measured: Columns, error: Array) -> Truths:
        """Return which cells may be lost if their extremes are wrong by `error`."""
        return np.zeros(error.shape, bool)

    def drawn_of(self, spec: Request) -> str:
        """Return the variable that maps of a spec show by default."""
        return self.drawn or self.peak

    def controls(self, axes: Iterable[str]) -> list[str]:
        """Return the axes along which the boundary of stability is searched."""
        return [name for name in axes if name in self.parameters and self.parameters[name].control]

    def upward(self, axes: Sequence[str]) -> str:
        """Return the vertical axis of a map, in a figure and on the page: the first control, or else the first axis."""
        return next(iter(self.controls(axes)), axes[0])
