"""The one table of everything that has a name: parameters, settings, variables.

Name, symbol, units (as CF spells them), long name, type, flags, label and tolerance stand here and nowhere else.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from kernels.disk.endings import ENDINGS

#: Stands in a file where a float has no value: netCDF's own default fill, because some readers mishandle NaN.
FILL = 9.969209968386869e36

#: The word for `roll_rate` that asks for the roll rate which keeps the tilt constant.
STEADY_ROLL = "steady"

#: The words for `precession_rate` that ask for the slower or the faster rate which keeps the tilt constant.
STEADY_PRECESSION = ("steady-slow", "steady-fast")

#: The words for `boundary`: as the grid has it, or bisected; and the width if none is given.
GRID, REFINED, REFINED_WIDTH = "grid", "refined", 1e-9

#: The word for `step` that leaves the step to the engine, which chooses it from each cell's own rates.
AUTOMATIC = "auto"

#: The methods of integration.
METHODS = ("rk4", "exact")

#: Where the cells are computed.
DEVICES = ("cpu", "cuda")

UNDECIDED, STABLE, UNSTABLE = 0, 1, 2

Array = npt.NDArray[np.float64]
Truths = npt.NDArray[np.bool_]

#: units -> (spelling on a label, label = value * factor): files hold radians, readers think in degrees.
_SHOWN: Mapping[str, tuple[str, float]] = {
    "1": ("", 1.0),
    "rad": ("deg", math.degrees(1.0)),
    "rad s-1": (r"rad s$^{-1}$", 1.0),
    "m": ("m", 1.0),
    "m s-2": (r"m s$^{-2}$", 1.0),
    "s": ("s", 1.0),
    "kg": ("kg", 1.0),
    "N": ("N", 1.0),
    "J": ("J", 1.0),
    "kg m2 s-1": (r"kg m$^2$ s$^{-1}$", 1.0),
    "kg m2 s-2": (r"kg m$^2$ s$^{-2}$", 1.0),
}

#: units -> what a request may write, for messages.
FITTING: Mapping[str, str] = {
    "1": "no unit, it is a pure number",
    "rad": "deg, rad, arcmin",
    "rad s-1": "rad/s, deg/s, rpm, turn/s",
    "m": "m, cm, inch",
    "m s-2": "m/s2, cm/s2, g_0",
    "s": "s, ms, min",
    "kg": "kg, g, pound",
}

#: Spelling in a request -> (units of the table, factor). Any other spelling is looked up in pint, which takes
#: a quarter of a second to load: these are the ones that should not wait for it.
EVERYDAY_UNITS: Mapping[str, tuple[str, float]] = {
    units: (units, 1.0) for units in FITTING if units != "1"
} | {
    "deg": ("rad", math.radians(1.0)),
    "°": ("rad", math.radians(1.0)),
    "rad/s": ("rad s-1", 1.0),
    "deg/s": ("rad s-1", math.radians(1.0)),
    "m/s2": ("m s-2", 1.0),
}


@dataclass(frozen=True)
class Tolerance:
    """How far two atlases may differ in a quantity, and why: |new - old| <= absolute + relative * |old|."""

    absolute: float
    relative: float
    reason: str


EXACT_DECISION = Tolerance(0.0, 0.0, "a decision is the same or it is not")
_GRID = Tolerance(0.0, 1e-12, "the logarithm in a range differs in its last bits between processors")
_TILT = Tolerance(2e-6, 0.0, "each resolved extreme tilt is within 1e-6 rad of the exact one")
_DERIVED = Tolerance(
    1e-9, 2e-3, "two tilts 2e-8 rad apart, over the smallest start of the presets, 1.7e-5 rad"
)
_FORCE = Tolerance(1e-5, 1e-5, "the extremes of the forces lie between steps, on a parabola through three")
_BOUNDARY = Tolerance(
    0.0, 1.3e-3, "a verdict on the edge can move it by one cell: 2/800 rad/s of 2 rad/s in the presets"
)
_GAUGE = Tolerance(1e-8, 0.0, "made of rounding: a gauge matters by its size, not by its digits")
_COUNT = Tolerance(2.0, 0.0, "the last bit can move a turning point across a step's end")


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
    def plot_label(self) -> str:
        """Label of an axis that shows value * `plot_scale`, in mathtext."""
        words = self.name.replace("_", " ") + (f" ${self.symbol}$" if self.symbol else "")
        shown = _SHOWN[self.units][0]
        return f"{words} ({shown})" if shown else words

    @property
    def plot_scale(self) -> float:
        """Factor from the value in `units` to the value that `plot_label` speaks of."""
        return _SHOWN[self.units][1]

    def spell(self, value: float, digits: int = 10) -> str:
        """Return a value as a message says it, angles in degrees."""
        shown = "deg" if self.units == "rad" else self.units
        return f"{value * self.plot_scale:.{digits}g}" + (f" {shown}" if shown != "1" else "")

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
    range is allowed if both its ends are.
    """

    default: float | str
    rule: str = "any finite number"
    allows: Callable[[Array], Truths] = field(default=np.isfinite, hash=False)


@dataclass(frozen=True)
class Word:
    """A setting that is text, not a number."""

    name: str
    long_name: str
    default: str


_Row = TypeVar("_Row", Quantity, Input, Word)


def table(*rows: _Row) -> Mapping[str, _Row]:
    """Return rows by their names, not to be changed."""
    return MappingProxyType({row.name: row for row in rows})


def _input(
    name: str,
    symbol: str,
    units: str,
    long_name: str,
    default: float | str,
    rule: str,
    allows: Callable[[Array], Truths],
) -> Input:
    return Input(name, symbol, units, long_name, _GRID, default=default, rule=rule, allows=allows)


def _rate(name: str, symbol: str, long_name: str) -> Input:
    return Input(name, symbol, "rad s-1", long_name, _GRID, default=0.0)


def _positive(values: Array) -> Truths:
    return values > 0.0


def _upright(tilt: Array) -> Truths:
    return np.abs(tilt) < math.pi / 2


# fmt: off
PARAMETERS: Mapping[str, Input] = table(
    _input("tilt", r"\theta_0", "rad", "initial tilt of the plane of the disk from the vertical",
           0.0, "|tilt| < 90 deg", _upright),
    _rate("tilt_rate", r"\dot\theta_0", "initial rate of the tilt"),
    _rate("precession_rate", r"\dot\psi_0", "initial rate of the heading about the vertical"),
    _rate("roll_rate", r"\dot\phi_0", "initial rate of roll about the axis of the disk, in the precessing frame"),
    _input("alpha", r"\alpha", "1", "axial moment of inertia over mass times radius squared (0.5 disk, 1 hoop)",
           0.5, "0 < alpha <= 1", lambda alpha: (alpha > 0.0) & (alpha <= 1.0)),
    _input("radius", "R", "m", "radius of the disk", 0.5, "radius > 0", _positive),
    _input("gravity", "g", "m s-2", "acceleration of gravity", 9.81, "gravity > 0", _positive),
)

SETTINGS: Mapping[str, Input] = table(
    _input("duration", "t", "s", "longest time simulated for a cell", 300.0, "duration > 0", _positive),
    _input("step", "h", "s", "time step", AUTOMATIC, "step > 0, or auto", _positive),
    _input("fall_tilt", r"\theta_f", "rad", "tilt at which the disk counts as fallen",
           math.radians(85.0), "0 deg < fall_tilt < 90 deg", lambda tilt: (tilt > 0.0) & _upright(tilt)),
    _input("tolerance", r"\epsilon", "rad", "error that the gauges of a cell may show before its step is reduced",
           1e-8, "1e-12 rad <= tolerance <= 0.1 rad", lambda error: (error >= 1e-12) & (error <= 0.1)),
)

WORDS: Mapping[str, Word] = table(
    Word("title", "what the atlas is about, in one line", ""),
    Word("criterion", "what counts as unstable", "departure:5deg"),
    Word("method", "how the motion is integrated", METHODS[0]),
    Word("contact", "whether the forces at the contact point are recorded: yes or no", "no"),
    Word("boundary", "how closely the boundary is looked for", GRID),
    Word("device", "what the cells are computed on", DEVICES[0]),
)

VARIABLES: Mapping[str, Quantity] = table(
    Quantity("ending", "", "1", "how the integration of the cell ended", EXACT_DECISION,
             "; ".join(f"{name}: {meaning}" for name, meaning in ENDINGS.values()),
             "i1", MappingProxyType({code: name for code, (name, _) in ENDINGS.items()})),
    Quantity("stability", "", "1", "verdict of the stability criterion", EXACT_DECISION,
             "follows from ending, tilt_min and tilt_max; a fall is unstable, an unresolved cell undecided",
             "i1", MappingProxyType({UNDECIDED: "undecided", STABLE: "stable", UNSTABLE: "unstable"})),
    Quantity("tilt_min", r"\theta_{\min}", "rad", "smallest tilt of the motion", _TILT, "signed"),
    Quantity("tilt_max", r"\theta_{\max}", "rad", "largest tilt of the motion", _TILT, "signed"),
    Quantity("peak_tilt", r"\max|\theta|", "rad", "largest magnitude of the tilt", _TILT,
             "the larger of |tilt_min| and |tilt_max|"),
    Quantity("amplification", "A", "1", "largest distance from the steady tilt over the scale of the perturbation",
             _DERIVED, "scale = sqrt((tilt - steady tilt)^2 + tilt_rate^2 (2 + alpha) radius / (2 gravity))"),
    Quantity("fall_time", "t_f", "s", "time until the tilt reached fall_tilt", _DERIVED),
    Quantity("nutation_period", "P", "s", "time between returns to the same extreme tilt", _DERIVED),
    Quantity("energy_drift", r"|\Delta E|/E", "1", "largest relative change of the energy at the events of the cell",
             _GAUGE, "the exact motion conserves energy, so this is an error of the integration", "f4"),
    Quantity("tilt_error", r"\delta\theta", "rad", "estimated error of the extreme tilts", _GAUGE,
             "what the invariants of the motion have lost, over the force at the turning point", "f4"),
    Quantity("steps", "n", "1", "steps of the accepted integration", _COUNT, "", "i4"),
    Quantity("refinements", "", "1", "how often the step was reduced to meet the tolerance", _COUNT, "", "i1"),
)

#: What an atlas holds besides with ``contact=yes``.
CONTACT_VARIABLES: Mapping[str, Quantity] = table(
    Quantity("least_normal_force", r"\min N/mg", "1", "least normal force of the motion over the weight", _FORCE,
             "the disk would lift off where it is not positive"),
    Quantity("friction_needed", r"\max\mu", "1", "largest friction coefficient that rolling without slip needs",
             _FORCE, "missing where the normal force is not positive all the time"),
)
# fmt: on

#: Variables of the run rather than of the disk, its errors and its work: other kernels or steps have others.
EFFORT = ("energy_drift", "tilt_error", "steps", "refinements")


def boundary_quantities(axis: str, edge: str = "upper") -> Mapping[str, Quantity]:
    """Return the quantities of one edge of the unstable band along a parameter.

    Parameters
    ----------
    axis : str
        A name of `PARAMETERS`, in practice a rate.
    edge : {"upper", "lower"}
        The edge above which, or below which, the motion is stable.

    Returns
    -------
    Mapping of str to Quantity
        ``boundary_<axis>``, ``boundary_<axis>_halfwidth``, ``predicted_<axis>`` and ``critical_<axis>``, all in the
        units of the parameter; those of the lower edge have ``lower_`` before the axis.
    """
    along = PARAMETERS[axis]
    words = axis.replace("_", " ")
    lower = "lower_" if edge == "lower" else ""
    side = "below" if lower else "above"
    meanings = {
        f"boundary_{lower}{axis}": f"{words} {side} which the motion is stable, as measured",
        f"boundary_{lower}{axis}_halfwidth": f"half-width of the bracket around the measured {words}",
        f"predicted_{lower}{axis}": f"{words} at which theory puts the boundary for this criterion and perturbation",
        f"critical_{lower}{axis}": f"analytic critical {words}, the limit of a vanishing perturbation",
    }
    return table(
        *(Quantity(name, along.symbol, along.units, words, _BOUNDARY) for name, words in meanings.items())
    )
