"""Models for the engine: the base class of all models, and its parts.

A model is a mechanical system whose starts are integrated and judged. Every other room of `sweep` takes what it needs
to know about the system from here; docs/architecture.md walks through a complete model.
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

    `summary` has one place ``{}`` for how the cells were computed.
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
        What the file says of both, with one place for the parameter; ASCII.
    limit, told : str
        The same of the value for one cell, as `explain` goes on after the number.
    label : str
        The predicted line in a legend, with one place for the criterion.
    bound : bool
        Whether the boundary may be well below the predicted line, which then says nothing of a range below it.
    """

    critical: str = "analytic critical {}, the limit of a vanishing perturbation"
    predicted: str = "{} at which theory puts the boundary for this criterion and perturbation"
    limit: str = "in the limit of no perturbation"
    told: str = "predicted for this start and this criterion"
    label: str = "predicted, {}"
    bound: bool = False


class Request(Protocol):
    """The part of a spec that a model uses: values of its parameters, settings and options, by their names."""

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
        """Which cells were compared with more than themselves, in words, where these are only a sample; else empty."""

    def needed(self, spec: Request) -> tuple[str, ...]:
        """Return the variables of an atlas that `check` reads."""

    def truth(self, spec: Request, starts: Starts, first: int, stored: Columns) -> Columns:
        """Return what `check` holds cells with these starts, shape (n,), against: this calls kernels.

        `first` is the number of the first of them in the atlas, which holds `stored`.
        """

    def check(
        self, spec: Request, starts: Starts, stored: Columns, truth: Columns
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
        self, spec: Request, starts: Starts, extremes_only: bool = False
    ) -> dict[str, npt.NDArray[Any]]:
        """Return the measures and counts of a model, and `variables`, for starts of shape (n,).

        With `extremes_only` measures may be NaN that no verdict needs.
        """

    def untimed(self, spec: Request) -> str:
        """Return what an atlas of a spec does not know because it was made without time; empty if it knows all."""


class Model(ABC):
    """A mechanical system that the engine integrates.

    Attributes
    ----------
    name : str
        What ``model=`` says.
    parameters : mapping of str to Input
        The start and the system, in the order of the rows of the kernels' array of starts; each can be an axis.
    settings : mapping of str to Input
        Numbers that are the same for all cells, in the order of the kernels' array of settings; `duration`, `step` (0
        where the request says ``auto``) and `tolerance` among them.
    options : mapping of str to Word
        Settings that are text, beside the engine's own.
    substitutes : mapping of str to Substitute
        What a request may give instead of a parameter.
    methods, devices : tuple of str
        How cells can be computed, the default first; ``exact`` needs `exact`. On what they can be integrated.
    endings : Endings
    variables : mapping of str to Quantity
        What an atlas holds of every cell, in the order of the file: ``ending``, ``stability``, all of `measures` and
        `counts`, and what `derive` adds.
    measures, counts : tuple of str
        Rows of the arrays that the kernel `integrate` writes, float64 and int32.
    coordinate : str
        The parameter whose distance from its undisturbed value a criterion limits; empty if there is none.
    extremes : tuple of two str
        The measures with the smallest and the largest value of that coordinate; none without it.
    default_criterion : str
        The criterion of a request that names none.
    criterion_words : mapping of str to str
        Text of a criterion -> what captions say instead: what makes a cell unstable.
    text : str
        What an atlas carries of the model, if that is more than its name.
    error_name : str
        The measure with the estimated error of the extremes.
    of_criterion : tuple of str
        Measures that depend on the criterion: an atlas that is judged by another one loses them.
    chosen_by : tuple of str
        Words that choose the model in a request which names none, and which the model that it would have does not know.
    does_without : tuple of str
        Words that a request leaves behind when it becomes one of this model: those of a file, or of another spec.
    peak : str
        The variable that reports and, unless `drawn` names another one, maps show.
    drawn : str
        The variable that gives maps their colour; empty for `peak`.
    shown : tuple of str
        Other variables that the explorer offers.
    lost_name : str
        What happens to a motion that is lost, for captions; empty if none can be.
    presets : Path
        Folder of the specs that come with the model, NAME.toml.
    integrate : Kernel
        integrate(starts, settings, measures, counts), which ``kernels.lanes.binding.bind`` has made of the LANE_MODEL
        in the same module.
    words : Words
    line_words : LineWords
    synonyms : mapping of str to str
        Names of the equations and of other books -> names of parameters and substitutes, for suggestions.
    ambiguous : mapping of str to str
        Part of an unknown word -> what to say instead of it.
    exact : ExactReference or None
    additions : mapping of str to mapping of str to Quantity
        Words of a request -> the variables of every cell that they add.
    unknown_to : mapping of str to sequence of str
        Method -> variables of which it knows no value.
    trajectory, regimes : str
        ``module:function`` that draws the motion of an explained cell (``explain --plot``), and the kinds of motion of
        atlases (``plot --regimes``); empty if the model has none.
    losses : str
        ``module:function`` that draws time and largest loss of atlases (``plot --losses``); empty if nothing is lost.
    motion : str
        ``module:object``, the kind of its motions in time (a ``MotionKind``), or a function that makes
        it of the model; empty if ``simulate`` follows none.
    in_time : str
        ``module:function`` that follows one cell in time and returns what that says of its variables, for ``explain``:
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
    def headline(self, spec: Request) -> str:
        """Return what a spec without a title is about, in one line."""

    @abstractmethod
    def undisturbed(self, spec: Request, starts: Starts) -> Array:
        """Return the value of the coordinate in the motion that each start disturbs, in its SI unit."""

    @abstractmethod
    def perturbation(self, spec: Request, starts: Starts) -> Array:
        """Return the size of the perturbation in each start, in the SI unit of the coordinate."""

    def disturbed_motion(self, spec: Request, start: Mapping[str, float]) -> str:
        """Return the name of the motion that a start disturbs, in words."""
        return "the undisturbed motion"

    def methods_for(self, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return those of `methods` that compute the cells of a request with these values, the usual one first."""
        del values
        return self.methods

    def check(self, values: Mapping[str, Any]) -> None:
        """Refuse values of a request that do not go together; by default all do.

        Raises
        ------
        RequestError
        """
        del values

    def complete(self, spec: Request, starts: Starts) -> Starts:
        """Return starts with the parameters for which the request gives a word instead of a number."""
        return starts

    def cell_variables(self, spec: Request) -> Mapping[str, Quantity]:
        """Return the variables of an atlas with one value per cell, for the method and the options of a spec."""
        exact = self.exact.variables if self.exact is not None and spec.method == "exact" else {}
        return {**self.variables, **exact}

    @property
    def measured(self) -> frozenset[str]:
        """The variables that do not follow from others: by default all that the kernel writes."""
        return frozenset({*self.measures, *self.counts})

    @property
    def from_extremes(self) -> frozenset[str]:
        """The extremes, and the variables that follow from them and the start."""
        return frozenset(self.extremes) | (self.variables.keys() - self.measured)

    def reference(self, size: int, seed: int | None = None) -> Reference | None:
        """Return what ``eulerdisk verify`` holds an atlas against; by default the exact reference, if there is one.

        The atlas has `size` cells; `seed` says which of them a sample has, where the reference takes one: fresh ones if
        not given.
        """
        return self.exact

    def integrator(self, spec: Request) -> Kernel:
        """Return the kernel that integrates the cells of a spec: `integrate`, or a variant of it."""
        return self.integrate

    def kernel_settings(self, spec: Request) -> Array:
        """Return the array of settings that it is called with."""
        values = (getattr(spec, name) for name in self.settings)
        return np.array([0.0 if isinstance(value, str) else value for value in values])

    def kernels(self, spec: Request) -> tuple[Kernel, ...]:
        """Return the compiled functions that compute the cells of a spec: their code decides the bits."""
        return (self.integrator(spec),)

    def code(self, spec: Request) -> Sequence[str | Callable[..., Any]]:
        """Return the code outside of the kernels that decides the bits of what is measured: modules and functions.

        By default the module of the model, if it completes starts or measures more; `Model.kernels` are hashed besides.
        """
        own = (type(self).complete, type(self).measure_more) != (Model.complete, Model.measure_more)
        return [type(self).__module__] if own else []

    def measure_more(self, spec: Request, starts: Starts, measured: Columns) -> Columns:
        """Return measures that need a kernel of their own, from those that `integrate` or `exact` has found."""
        return {}

    def derive(self, starts: Starts, measured: Columns) -> Columns:
        """Return the variables that follow from the measures, except for ``stability`` and ``amplification``."""
        return {}

    def lines(self, spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
        """Return where theory puts the edges of the unstable band along an axis.

        Parameters
        ----------
        spec : Request
        axis : str
            A control parameter that is an axis of the spec.
        starts : mapping of str to array, shape (n,)
            The starts of the rows along that axis, or of some of them; what they hold for the axis does not matter.

        Returns
        -------
        dict of str to (critical, predicted)
            ``"upper"`` (stable above) and ``"lower"`` (stable below), where theory has such an edge: two arrays, shape
            (n,), in the SI unit of the axis: the limit of a vanishing perturbation, and the value at which the
            criterion changes its verdict for the perturbation of the spec. NaN where theory has no value.
        """
        return {}

    def line_label(self, spec: Request, axis: str) -> str:
        """Return the formula of the critical line along an axis, in mathtext; empty if there is none.

        An equation, or the right-hand side of one for the square of the parameter.
        """
        return ""

    def joined_edges(self, spec: Request) -> tuple[str, str] | None:
        """Return what the two ends of the analytic line are called, where both edges are one curve over the coordinate.

        In mathtext, the end of the upper edge first; both ends lie at zero of the coordinate. None for separate lines.
        """
        return None

    def unit_of_square(self, spec: Request, axis: str) -> tuple[float, str] | None:
        """Return the unit in which the square of a control parameter is a pure number, and its name in mathtext.

        None where cells differ in that unit, or the model has none.
        """
        return None

    def lost_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return how a motion was lost, for a cell with these stored values."""
        return self.endings.of(stored["ending"]).reason

    def open_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return what ended a motion that may yet go further, for a cell with these stored values."""
        return f"the duration of {spec.duration:g} s {self.endings.of(stored['ending']).reason}"

    def reason_without_verdicts(self, spec: Request) -> str:
        """Return why many cells may have no verdict, and what to ask for instead; empty if nothing is known."""
        return ""

    def linear_prediction(
        self, spec: Request, start: Mapping[str, float], stored: Mapping[str, float]
    ) -> Iterable[str]:
        """Return lines that say what linear theory expects of one cell; none if the model has no such theory."""
        return ()

    def slipping(self, dataset: Any, friction: float) -> Any:
        """Return which cells of an atlas need more than a friction coefficient, as an xarray.DataArray of bool.

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
        """Return how far the coordinate went from its undisturbed value, in its SI unit; NaN without extremes."""
        steady = self.undisturbed(spec, starts)
        if not self.extremes:
            return np.full(steady.shape, np.nan)
        low, high = (measured[name] for name in self.extremes)
        return np.asarray(np.maximum(np.abs(high - steady), np.abs(low - steady)))

    def error(self, measured: Columns) -> Array:
        """Return the estimated error of the extremes, in the unit of the coordinate; NaN where it is not known."""
        return np.asarray(measured[self.error_name], np.float64)

    def may_be_lost(self, spec: Request, measured: Columns, error: Array) -> Truths:
        """Return which cells end otherwise if their extremes are off by `error`: the motion may be lost."""
        return np.zeros(error.shape, bool)

    def drawn_of(self, spec: Request) -> str:
        """Return the variable that maps of the cells of a spec show, unless another one is asked for."""
        return self.drawn or self.peak

    def controls(self, axes: Iterable[str]) -> list[str]:
        """Return the axes along which a boundary of stability is sought."""
        return [name for name in axes if name in self.parameters and self.parameters[name].control]

    def upward(self, axes: Sequence[str]) -> str:
        """Return which axis goes up in a map, in a figure and on the page: the first control, else the first of all."""
        return next(iter(self.controls(axes)), axes[0])
