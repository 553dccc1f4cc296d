"""The tables of the disk: parameters, settings, options, endings and variables.

Their order is the order of the rows of the kernels' arrays (`kernels.disk.arrays`) and of the file.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from kernels.bodies import arrays as motion
from kernels.disk import endings as code
from sweep.model.disk.path import PATH
from sweep.model.quantity import (
    AMPLIFIED,
    DECISION,
    DURATION,
    ERROR_GAUGE,
    EXTREME,
    FAILED,
    FINAL,
    GRID,
    LOST,
    MISSING,
    OPEN,
    STABILITY,
    STEP,
    STEP_COUNT,
    TIMED,
    UNDISTURBED,
    Array,
    Ending,
    Endings,
    Input,
    Quantity,
    Substitute,
    Tolerance,
    Truths,
    Word,
    positive,
    table,
)

#: The word for the roll rate that keeps the tilt constant.
STEADY_ROLL = "steady"

#: The words for the slower and the faster precession rate that keep the tilt constant.
STEADY_PRECESSION = ("steady-slow", "steady-fast")
_TWO_RATES = (
    "two precession rates keep the tilt constant at a given roll_rate: steady-slow is the slower one, steady-fast "
    "the faster one; wobble, together with roll_rate=wobble, keeps the tilt constant while the centre of the disk rests"
)

#: The word for the rates of a wobble: circling with the centre of the disk at rest.
WOBBLE = "wobble"
_CENTRED = (
    "steady is the rate that keeps the tilt constant at a given precession_rate; wobble is the rate at which the "
    "centre of the disk rests"
)

_TILT = Tolerance(1e-13, 0.0, "each extreme tilt is as near to the true one as its atlas states", EXTREME)
_AMPLIFICATION = Tolerance(
    0.0, 1e-12, "it contains the errors of both extreme tilts over the size of the perturbation", AMPLIFIED
)
_TIME = Tolerance(
    0.0,
    1e-6,
    "it contains the errors of both extreme tilts over the size of the swing; RK4 keeps time less well than energy",
    TIMED,
)
_FORCE = Tolerance(2e-6, 2e-6, "each known extreme of the forces is within 1e-6 (1 + |x|) of the exact one")


def _input(
    name: str,
    symbol: str,
    units: str,
    long_name: str,
    default: float | str,
    rule: str,
    allows: Callable[[Array], Truths],
    words: tuple[str, ...] = (),
    description: str = "",
) -> Input:
    return Input(
        name, symbol, units, long_name, GRID, description,
        default=default, rule=rule, allows=allows, words=words,
    )  # fmt: skip


def _rate(
    name: str,
    symbol: str,
    long_name: str,
    words: tuple[str, ...] = (),
    meaning: str = "",
    control: bool = False,
    description: str = "",
) -> Input:
    return Input(
        name, symbol, "rad s-1", long_name, GRID, description,
        default=0.0, words=words, meaning=meaning, control=control,
    )  # fmt: skip


def _scaled(rate: str, symbol: str) -> Substitute:
    """Return the substitute of a rate: the rate in units of sqrt(gravity/radius)."""
    return Substitute(
        f"scaled_{rate}", rf"{symbol}\sqrt{{R/g}}", "1", f"{rate} in units of sqrt(gravity/radius)", GRID,
        parameter=rate, needs=("radius", "gravity"),
        # a division by sqrt(gravity/radius) would change the last bit of some rates in the presets
        scale=lambda disk: math.sqrt(disk["radius"] / disk["gravity"]),
    )  # fmt: skip


#: The cells in which an extreme is missing.
_NO_EXTREME = "missing where ending is not_computed, unresolved or invalid"

#: The formula of the scale of the perturbation, the denominator of the amplification.
AMPLIFICATION_SCALE = "scale = sqrt((tilt - steady tilt)^2 + tilt_rate^2 (2 + alpha) radius / (2 gravity))"

#: The meaning of the sign of an extreme.
_SIGNED = f"signed like the coordinate tilt: negative on the side opposite to positive starts; {_NO_EXTREME}"


def _upright(tilt: Array) -> Truths:
    return np.abs(tilt) < math.pi / 2


ENDINGS = Endings(
    Ending(
        code.NOT_COMPUTED, "not_computed", "the cell has not been integrated", MISSING,
        "the cell has not been integrated",
    ),
    Ending(
        code.BOUNDED, "bounded", "both turning points were passed: the extreme tilts hold for all time", FINAL,
        "both turning points were passed, so that this holds for all time",
    ),
    Ending(
        code.STEADY, "steady", "an exact steady motion with nothing to disturb it: there is nothing to measure",
        UNDISTURBED,
        "it is an exact steady motion that nothing disturbs, so its stability cannot be measured",
    ),
    Ending(
        code.HORIZON, "horizon", "the duration was over before both turning points were passed", OPEN,
        "was over before both turning points were passed: it may still go further",
    ),
    Ending(
        code.FELL, "fell", "the tilt reached fall_tilt", LOST,
        "the tilt reached fall_tilt, and a fall is unstable by this criterion",
    ),
    Ending(
        code.UNRESOLVED, "unresolved", "the estimated error stayed above the tolerance, or there were too many steps",
        FAILED, "the error of the integration stayed above the tolerance even at the smallest step",
    ),
    Ending(
        code.INVALID, "invalid", "impossible start: not finite, or outside the domain of a parameter", FAILED,
        "the start is impossible: nothing was integrated",
    ),
    lost_time="fall_time",
)  # fmt: skip

# fmt: off
PARAMETERS: Mapping[str, Input] = table(
    _input("tilt", r"\theta_0", "rad", "initial tilt of the plane of the disk from the vertical",
           0.0, "|tilt| < 90 deg", _upright,
           description="0: upright; positive: it leans to the right of its direction at a positive roll_rate"),
    _rate("tilt_rate", r"\dot\theta_0", "initial rate of the tilt"),
    _rate("precession_rate", r"\dot\psi_0", "initial rate of the heading about the vertical",
          (*STEADY_PRECESSION, WOBBLE), _TWO_RATES, control=True,
          description="positive: to the left, counterclockwise seen from above"),
    _rate("roll_rate", r"\dot\phi_0", "initial rate of roll about the axis of the disk, in the precessing frame",
          (STEADY_ROLL, WOBBLE), _CENTRED, control=True,
          description="times the radius, the speed of the contact point along its path; positive: forwards"),
    _input("alpha", r"\alpha", "1", "axial moment of inertia over mass times radius squared (0.5 disk, 1 hoop)",
           0.5, "0 < alpha <= 1", lambda alpha: (alpha > 0.0) & (alpha <= 1.0)),
    _input("radius", "R", "m", "radius of the disk", 0.5, "radius > 0", positive),
    _input("gravity", "g", "m s-2", "acceleration of gravity", 9.81, "gravity > 0", positive),
)

SUBSTITUTES: Mapping[str, Substitute] = table(
    _scaled("tilt_rate", r"\dot\theta_0"),
    _scaled("precession_rate", r"\dot\psi_0"),
    _scaled("roll_rate", r"\dot\phi_0"),
    # rolling without slipping: equal arcs on the rim and on the plane
    Substitute("speed", "v", "m s-1", "speed of the contact point along its path", GRID,
               parameter="roll_rate", needs=("radius",), scale=lambda disk: disk["radius"]),
    Substitute("inclination", "a", "rad", "angle of the plane of the disk from the table: 90 deg less the tilt", GRID,
               parameter="tilt", needs=(), scale=lambda _: -1.0, offset=math.pi / 2),
    Substitute("diameter", "D", "m", "diameter: twice the radius", GRID,
               parameter="radius", needs=(), scale=lambda _: 2.0),
)

SETTINGS: Mapping[str, Input] = table(
    DURATION,
    STEP,
    _input("fall_tilt", r"\theta_f", "rad", "tilt at which the disk counts as fallen",
           math.radians(85.0), "0 deg < fall_tilt < 90 deg", lambda tilt: (tilt > 0.0) & _upright(tilt)),
    _input("tolerance", r"\epsilon", "rad", "largest estimated error of a cell before its step is reduced",
           1e-8, "1e-12 rad <= tolerance <= 0.1 rad", lambda error: (error >= 1e-12) & (error <= 0.1)),
)

OPTIONS: Mapping[str, Word] = table(
    Word("contact", "whether the forces at the contact point are recorded: yes or no", "no", ("no", "yes"),
         decides=False),
    PATH,
)

VARIABLES: Mapping[str, Quantity] = table(
    ENDINGS.quantity,
    replace(STABILITY, description="follows from ending, tilt_min and tilt_max; a fall is unstable, an unresolved cell "
                                   "undecided"),
    Quantity("tilt_min", r"\theta_{\min}", "rad", "smallest tilt of the motion", _TILT, _SIGNED),
    Quantity("tilt_max", r"\theta_{\max}", "rad", "largest tilt of the motion", _TILT, _SIGNED),
    Quantity("peak_tilt", r"\max|\theta|", "rad", "largest magnitude of the tilt", _TILT,
             f"the larger of |tilt_min| and |tilt_max|; {_NO_EXTREME}"),
    Quantity("amplification", "A", "1", "largest distance from the steady tilt over the scale of the perturbation",
             _AMPLIFICATION,
             f"{AMPLIFICATION_SCALE}; missing where ending is steady, not_computed, unresolved or invalid"),
    Quantity("fall_time", "t_f", "s", "time until the tilt reached fall_tilt", _TIME,
             "missing where the disk did not fall: ending is not fell"),
    Quantity("nutation_period", "P", "s", "time between returns to the same extreme tilt", _TIME,
             "missing where not both turning points were passed: ending is not bounded"),
    Quantity("energy_drift", r"|\Delta E|/E", "1", "largest relative change of the energy at the events of the cell",
             ERROR_GAUGE, "the exact motion conserves energy, so this is an error of the integration", "f4"),
    Quantity("tilt_error", r"\delta\theta", "rad", "estimated error of the extreme tilts", ERROR_GAUGE,
             "change of the invariants of the motion, over the force at the turning point", "f4"),
    Quantity("steps", "n", "1", "number of steps of the accepted integration", STEP_COUNT, "", "i4"),
    Quantity("refinements", "", "1", "number of step reductions to meet the tolerance", STEP_COUNT, "", "i1"),
)

#: Additional variables with ``contact=yes``.
CONTACT_VARIABLES: Mapping[str, Quantity] = table(
    Quantity("least_normal_force", r"\min N/mg", "1", "least normal force of the motion over the weight", _FORCE,
             "the disk would lift off where it is not positive"),
    Quantity("friction_needed", r"\max\mu", "1", "friction coefficient that rolling without slipping needs",
             _FORCE, "missing where the normal force is not always positive"),
    Quantity("contact_state", "", "1", "knowledge of the contact forces", DECISION,
             "unresolved: the error of an extreme may exceed 1e-6 (1 + |x|); such an extreme is missing", "i1",
             {motion.NO_MOTION: "no_motion", motion.PRESSES: "presses", motion.LIFTS_OFF: "lifts_off",
              motion.UNRESOLVED_FORCES: "unresolved"}),
)

_NO_TIME = "method=exact has no time: "

#: Remarks on the variables that need an integration in time, for an atlas of the exact reduction.
UNTIMED: Mapping[str, str] = MappingProxyType({
    "ending": _NO_TIME + "the duration is not used, and no cell ends at the horizon",
    "fall_time": _NO_TIME + "no fall time is known, and all values are missing",
    "energy_drift": _NO_TIME + "nothing is integrated, and all values are missing",
    "steps": _NO_TIME + "0 in all cells",
    "refinements": _NO_TIME + "0 in all cells",
})

#: Additional variables of an atlas of the exact reduction.
REDUCTION: Mapping[str, Quantity] = table(
    Quantity("wells", "", "1", "wells of the potential that belongs to the constants of the motion", DECISION,
             "two wells: the potential has a maximum between them", "i1",
             {0: "unknown", 1: "one_well", 2: "two_wells"}),
    Quantity("separatrix", "", "1", "nearest maximum of the potential minus the energy of the motion, over m g R",
             Tolerance(1e-12, 1e-9, "it is a difference of energies, each known to rounding"),
             "negative: the motion passes the maximum; positive: it turns below; from a parabola at the maximum, so "
             "most exact near 0; missing: the motion passes no maximum and turns far from any"),
)
# fmt: on
