"""Quantities: everything that has a name, with its units, type, flags, labels and tolerance; and the endings of cells.

A model lists its parameters, settings and variables in tables of quantities: no other place names a unit.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError

#: Value of a missing float in a file: netCDF's default fill value, because some readers mishandle NaN.
FILL = 9.969209968386869e36

#: Of a million random extremes, all but one in a thousand were within this many times their stated error.
PROMISED = 2.0

#: Stated error of a value that is not decided; it leaves every comparison open.
UNKNOWN_ERROR = 1e30

#: Verdicts of a criterion.
UNDECIDED, STABLE, UNSTABLE = 0, 1, 2

Array = npt.NDArray[np.float64]
Truths = npt.NDArray[np.bool_]

#: Units of files -> units of messages and figures, where they differ.
_SHOWN: Mapping[str, str] = {"1": "", "rad": "deg"}

#: Angles of at least this many turns are shown in turns.
_MANY_TURNS = 10.0

#: A unit of a CF units string, and its power.
_POWER = re.compile(r"([A-Za-z]+)(-?\d+)")


# Further differences that two atlases may have, because the atlases state them (`sweep.checks.variables`).
#: The errors of two extremes: the tolerance of each atlas, or the stated error of the cell where that is larger.
EXTREME = "extreme"
#: The errors of two extremes over the size of the perturbation.
AMPLIFIED = "amplified"
#: The errors of two extremes over the size of the swing: a relative error of a time.
TIMED = "timed"
#: The half-widths of two brackets around the same place.
BRACKET = "bracket"
#: The difference of two half-widths, because cells without a verdict can end a bisection early.
HALFWIDTH = "halfwidth"


@dataclass(frozen=True)
class Tolerance:
    """Largest difference of a quantity between two atlases, |new - old| <= absolute + relative * |old| + stated.

    `stated` is one of the words above, or the variable with the error of each cell; empty if the atlases state no
    error. `reason` completes "this difference is allowed because".
    """

    absolute: float
    relative: float
    reason: str
    stated: str = ""


DECISION = Tolerance(0.0, 0.0, "a decision is equal or different")
GRID = Tolerance(0.0, 1e-12, "the logarithm in a range differs in its last bits between processors")
MEASURED_EDGE = Tolerance(
    0.0,
    1e-12,
    "both brackets contain the boundary; if both are cells of the grid, they are the same cells",
    BRACKET,
)
EDGE_HALFWIDTH = Tolerance(
    0.0, 1e-12, "a bracket is bisected to its width, or until the errors leave a verdict open", HALFWIDTH
)
CRITICAL_EDGE = Tolerance(0.0, 1e-12, "it is a closed expression, known to rounding")
PREDICTED_EDGE = Tolerance(
    0.0, 1e-9, "it is a closed expression with a difference of nearly equal numbers, known to rounding"
)
ERROR_GAUGE = Tolerance(1e-8, 0.0, "rounding makes it: only the magnitude of an error estimate matters")
STEP_COUNT = Tolerance(2.0, 0.0, "the last bit can move a turning point across the end of a step")
EVENT_COUNT = Tolerance(0.0, 0.0, "the last bit moves an event, but adds none")

#: Variables that depend on the steps and kernels of a run more than on the motion.
OF_THE_RUN = (ERROR_GAUGE, STEP_COUNT, EVENT_COUNT)


#: Errors smaller than this are written with a power of ten.
_READABLE = 1e-3


def with_unit(number: str, units: str) -> str:
    """Return a number with its unit; a pure number (unit ``1``) gets none."""
    return number if units in ("", "1") else f"{number} {units}"


def spell_size(size: float, units: str = "") -> str:
    """Return the size of an error, or of a difference, with two digits: ``6.7e-10 rad``, ``0.91``."""
    return with_unit(f"{size:.2g}" if size >= _READABLE else f"{size:.1e}", units)


@dataclass(frozen=True)
class Quantity:
    """One named quantity of an atlas.

    `symbol` is mathtext, `units` is CF's spelling, `flags` maps each code of an enumerated quantity to its name.
    """

    name: str
    symbol: str
    units: str
    long_name: str
    tolerance: Tolerance
    description: str = ""
    dtype: str = "f8"
    flags: Mapping[int, str] | None = field(default=None, hash=False)

    @property
    def shown_units(self) -> str:
        """Units of the quantity in messages, in plain text: deg for an angle, nothing for a pure number."""
        return _SHOWN.get(self.units, self.units)

    @property
    def plot_units(self) -> str:
        """Units of value * `plot_scale`, in mathtext; empty for a pure number."""
        return _POWER.sub(r"\1$^{\2}$", _SHOWN.get(self.units, self.units))

    @property
    def plot_label(self) -> str:
        """Label of an axis that shows value * `plot_scale`, in mathtext."""
        words = self.name.replace("_", " ") + (f" ${self.symbol}$" if self.symbol else "")
        return f"{words} ({self.plot_units})" if self.plot_units else words

    @property
    def plot_scale(self) -> float:
        """Factor from the value in `units` to the value in `shown_units`."""
        return math.degrees(1.0) if self.units == "rad" else 1.0

    def spell(self, value: float, digits: int = 10) -> str:
        """Return a value as text for messages: angles in degrees, angles of many turns in turns."""
        if self.units == "rad" and abs(value) >= _MANY_TURNS * math.tau:
            return f"{value / math.tau:.{digits}g} turns"
        return f"{value * self.plot_scale:.{digits}g} {self.shown_units}".rstrip()

    def flag(self, code: float) -> str:
        """Return the name of a code of an enumerated quantity, in words; an unknown code as a number."""
        return (self.flags or {}).get(code, f"{code:g}").replace("_", " ")  # type: ignore[call-overload, no-any-return]

    def attributes(self) -> dict[str, object]:
        """Return the CF attributes, ASCII only; an enumerated quantity has flags instead of units."""
        attributes: dict[str, object] = {"long_name": self.long_name}
        if self.flags is None:
            attributes["units"] = self.units
        else:
            attributes["flag_values"] = np.array(list(self.flags), dtype=self.dtype)
            attributes["flag_meanings"] = " ".join(self.flags.values())
        if self.description:
            attributes["comment"] = self.description
        return attributes


@dataclass(frozen=True, kw_only=True)
class Input(Quantity):
    """A quantity that a request may set: its default and the rule for its values.

    `allows` takes an array of values in `units` and returns an array of bool. Every rule is an interval, so a
    range is allowed if both its ends are. A request may give one of `words` instead of a number; `meaning` explains
    them if there are several. `constants` maps those of `words` that stand for a number to the number. The boundary of
    stability is searched along every axis that is a `control`.
    """

    default: float | str
    rule: str = "any finite number"
    allows: Callable[[Array], Truths] = field(default=np.isfinite, hash=False)
    words: tuple[str, ...] = ()
    meaning: str = ""
    control: bool = False
    constants: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}), hash=False)


@dataclass(frozen=True, kw_only=True)
class Substitute(Quantity):
    """A quantity that a request may give instead of a parameter: a scaled rate, speed or angle.

    substitute = (parameter - offset) * scale(values): `scale` takes a mapping with the values [SI] of the parameters
    `needs`, which must be numbers, and returns a nonzero number; a negative one if the substitute decreases with the
    parameter. Only requests know substitutes: specs and files contain the parameter.
    """

    parameter: str
    needs: tuple[str, ...]
    scale: Callable[[Mapping[str, float]], float] = field(hash=False)
    offset: float = 0.0


@dataclass(frozen=True)
class Word:
    """A setting that is text, not a number; one of `choices`, if there are any.

    `decides` is true if it changes the values of the cells, false if it only adds variables. `remark` may explain why
    there are no other choices.
    """

    name: str
    long_name: str
    default: str
    choices: tuple[str, ...] = ()
    decides: bool = True
    remark: str = ""


def table[Row: (Quantity, Input, Substitute, Word)](*rows: Row) -> Mapping[str, Row]:
    """Return a read-only mapping from the name of each row to the row."""
    return MappingProxyType({row.name: row for row in rows})


def positive(values: Array) -> Truths:
    """Return which values are above zero."""
    return values > 0.0


#: The verdict of a cell; a model may add a description.
STABILITY = Quantity(
    "stability", "", "1", "verdict of the stability criterion", DECISION, "", "i1",
    MappingProxyType({UNDECIDED: "undecided", STABLE: "stable", UNSTABLE: "unstable"}),
)  # fmt: skip

#: Settings that every model has.
DURATION = Input(
    "duration", "t", "s", "longest time simulated for a cell", GRID,
    default=300.0, rule="duration > 0", allows=positive,
)  # fmt: skip
STEP = Input(
    "step", "h", "s", "time step", GRID,
    default="auto", rule="step > 0, or auto", allows=positive, words=("auto",),
)  # fmt: skip


# Roles: what an ending means for the verdict; the names of endings differ between models.
#: The cell has not been integrated.
MISSING = "missing"
#: The extremes are final for all time, or for the duration if the model judges within it.
FINAL = "final"
#: Time ran out: the extremes could still grow.
OPEN = "open"
#: Unstable by any criterion that limits the coordinate.
LOST = "lost"
#: Nothing disturbs the motion: there is nothing to measure.
UNDISTURBED = "undisturbed"
#: Passes of different accuracy end differently: nothing is known about the motion.
SENSITIVE = "sensitive"
#: The cell could not be computed.
FAILED = "failed"


@dataclass(frozen=True)
class Ending:
    """One way in which the integration of a cell can end.

    `code` is the number that the kernels write. `name` and `meaning` are written to the file. `role` is one of the
    roles above. `reason` explains the verdict of such a cell in a sentence; empty if its extremes decide. `help` says
    what to do if a cell could not be computed.
    """

    code: int
    name: str
    meaning: str
    role: str
    reason: str = ""
    help: str = ""


class Endings:
    """The closed list of endings of a model.

    Parameters
    ----------
    *endings : Ending
        The ending with the role MISSING has the code 0.
    lost_time : str
        The measure with the time at which a motion was lost; empty if there is none. For other endings it is missing,
        or the time of that ending.
    """

    def __init__(self, *endings: Ending, lost_time: str = "") -> None:
        self._all, self.lost_time = endings, lost_time
        self._codes = {ending.name: ending.code for ending in endings}

    def __iter__(self) -> Iterator[Ending]:
        """Yield the endings."""
        return iter(self._all)

    def code(self, name: str) -> int:
        """Return the code of the ending with a name."""
        return self._codes[name]

    def of(self, code: float) -> Ending:
        """Return the ending with a code.

        Raises
        ------
        RequestError
            If there is none: the file is damaged.
        """
        for ending in self._all:
            if ending.code == code:
                return ending
        raise RequestError(
            f"The file is damaged: a cell has the ending {code:g}; the endings are "
            f"{', '.join(map(str, self.flags))}.",
            hint="Check it with eulerdisk verify.",
            where="ending",
        )

    def codes(self, *roles: str) -> list[int]:
        """Return the codes of all endings with one of the roles."""
        return [ending.code for ending in self._all if ending.role in roles]

    def have(self, role: str, ending: npt.NDArray[Any]) -> Truths:
        """Return which cells have an ending with a role; `ending` is an array of codes, any shape."""
        codes = self.codes(role)
        matches: Truths = ending == codes[0] if len(codes) == 1 else np.isin(ending, codes)
        return matches

    def among(self, ending: npt.NDArray[Any], *names: str) -> Truths:
        """Return which cells have one of the endings; `ending` is an array of codes, any shape."""
        # a tenth of the time of numpy.isin
        matches: Truths = ending == self._codes[names[0]]
        for name in names[1:]:
            matches |= ending == self._codes[name]
        return matches

    @property
    def flags(self) -> Mapping[int, str]:
        """The codes with their names, for the file."""
        return MappingProxyType({ending.code: ending.name for ending in self._all})

    @property
    def quantity(self) -> Quantity:
        """The variable with the codes, for the file."""
        meanings = "; ".join(f"{ending.name}: {ending.meaning}" for ending in self._all)
        words = "how the integration of the cell ended"
        return Quantity("ending", "", "1", words, DECISION, meanings, "i1", self.flags)
