"""The tables of the disk: parameters, settings, options, endings and variables.

Their order is the order of the rows of the kernels' arrays (`kernels.disk.arrays`) and of the file.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from kernels.disk import endings as code
from kernels.disk import motion_arrays as motion
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

#: The word for `roll_rate` that asks for the roll rate which keeps the tilt constant.
STEADY_ROLL = "steady"

#: The words for `precession_rate` that ask for the slower or the faster rate which keeps the tilt constant.
STEADY_PRECESSION = ("steady-slow", "steady-fast")
_TWO_RATES = (
    "two precession rates keep the tilt constant at a given roll_rate; steady-slow asks for the slower one, "
    "steady-fast for the faster one; wobble, beside roll_rate=wobble, for the rate that keeps it while the centre rests"
)

#: The word that asks for the rates of the wobble, circling with the centre of the disk at rest.
WOBBLE = "wobble"
_CENTRED = (
    "steady asks for the rate that keeps the tilt constant at a given precession_rate, wobble for the one with which "
    "the centre of the disk is at rest"
)

_TILT = Tolerance(1e-13, 0.0, "each extreme tilt is as near to the true one as its atlas states", EXTREME)
_AMPLIFICATION = Tolerance(
    0.0, 1e-12, "the errors of both extreme tilts, over the size of the perturbation", AMPLIFIED
)
_TIME = Tolerance(
    0.0,
    1e-6,
    "the errors of both extreme tilts, over the size of the swing; RK4 keeps time less well than energy",
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
    """Return the pure number that may be given instead of a rate: the rate in units of sqrt(gravity/radius)."""
    return Substitute(
        f"scaled_{rate}", rf"{symbol}\sqrt{{R/g}}", "1", f"{rate} in units of sqrt(gravity/radius)", GRID,
        parameter=rate, needs=("radius", "gravity"),
        # not a product with sqrt(gravity/radius): of the default disk some rates of the presets are none to the bit
        scale=lambda disk: math.sqrt(disk["radius"] / disk["gravity"]),
    )  # fmt: skip


#: The cells in which an extreme is missing.
_NO_EXTREME = "missing where ending is not_computed, unresolved or invalid"

#: The unit of the amplification.
AMPLIFICATION_SCALE = "scale = sqrt((tilt - steady tilt)^2 + tilt_rate^2 (2 + alpha) radius / (2 gravity))"

#: The meaning of the sign of an extreme.
_SIGNED = (
    f"signed, as the coordinate tilt: a negative one is on the side away from positive starts; {_NO_EXTREME}"
)


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
        "it is an exact steady motion and nothing disturbs it: whether it is stable cannot be measured from it",
    ),
    Ending(
        code.HORIZON, "horizon", "the duration was over before both turning points were passed", OPEN,
        "was over before both turning points were passed: it may yet go further",
    ),
    Ending(
        code.FELL, "fell", "the tilt reached fall_tilt", LOST,
        "the tilt reached fall_tilt, and a fall is unstable by this criterion",
    ),
    Ending(
        code.UNRESOLVED, "unresolved", "the estimated error stayed over the tolerance, or the steps were too many",
        FAILED, "the error of the integration stayed over the tolerance even at the smallest step",
    ),
    Ending(
        code.INVALID, "invalid", "no such start: not finite, or outside the domain of a parameter", FAILED,
        "there is no such start: nothing was integrated",
    ),
    lost_time="fall_time",
)  # fmt: skip

# fmt: off
PARAMETERS: Mapping[str, Input] = table(
    _input("tilt", r"\theta_0", "rad", "initial tilt of the plane of the disk from the vertical",
           0.0, "|tilt| < 90 deg", _upright,
           description="0 upright; positive: it leans to the right of where a positive roll_rate takes it"),
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
    # equal arcs on the rim and on the plane: that is rolling without slipping
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
             "what the invariants of the motion have lost, over the force at the turning point", "f4"),
    Quantity("steps", "n", "1", "steps of the accepted integration", STEP_COUNT, "", "i4"),
    Quantity("refinements", "", "1", "how often the step was reduced to meet the tolerance", STEP_COUNT, "", "i1"),
)

#: Additional variables with ``contact=yes``.
CONTACT_VARIABLES: Mapping[str, Quantity] = table(
    Quantity("least_normal_force", r"\min N/mg", "1", "least normal force of the motion over the weight", _FORCE,
             "the disk would lift off where it is not positive"),
    Quantity("friction_needed", r"\max\mu", "1", "largest friction coefficient that rolling without slip needs",
             _FORCE, "missing where the normal force is not positive all the time"),
    Quantity("contact_state", "", "1", "what is known of the contact forces", DECISION,
             "unresolved: an error of the extremes may be over 1e-6 (1 + |x|); what is not known is missing", "i1",
             {motion.NO_MOTION: "no_motion", motion.PRESSES: "presses", motion.LIFTS_OFF: "lifts_off",
              motion.UNRESOLVED_FORCES: "unresolved"}),
)

_NO_TIME = "method=exact has no time: "

#: Comments on variables that need an integration in time, in an atlas of the exact reduction.
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
             "two wells: the tilt has a saddle between them", "i1", {0: "unknown", 1: "one_well", 2: "two_wells"}),
    Quantity("separatrix", "", "1", "maximum of the potential beside the motion minus its energy, over m g R",
             Tolerance(1e-12, 1e-9, "a difference of energies, each known to rounding"),
             "of the nearest maximum that the motion passes (negative) or turns below (positive), from the parabola "
             "there: the nearer, the more exact; missing: it passes none, and none is near enough to bend the "
             "potential down where it turns"),
)
# fmt: on
