"""The tables of the disk with losses: parameters, settings, options, endings and variables.

Their order is the order of the rows of the kernels' arrays (`kernels.lossy_disk.arrays`) and of the file. Rows that the
disk without losses has too come from its tables.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from kernels.lossy_disk import arrays
from kernels.lossy_disk import endings as code
from kernels.lossy_disk.arrays import AIR_LAWS as AIR_LAWS
from sweep.model.disk import tables as disk
from sweep.model.lossy_disk.air import AIR
from sweep.model.quantity import (
    DECISION,
    DURATION,
    ERROR_GAUGE,
    EVENT_COUNT,
    FAILED,
    FINAL,
    GRID,
    LOST,
    MISSING,
    OPEN,
    STEP,
    UNDISTURBED,
    Array,
    Ending,
    Endings,
    Input,
    Quantity,
    Tolerance,
    Truths,
    Word,
    positive,
    table,
)

#: The words for a mass that no law needs, and for a friction coefficient without a limit.
UNKNOWN, UNLIMITED = "unknown", "unlimited"

#: The laws of the air, in the order of their codes (`kernels.lossy_disk.arrays`).
NO_AIR, MOFFATT, BILDSTEN, *_ = AIR_LAWS


def some(value: Any) -> bool:
    """Return whether a parameter is not 0 in some cell, from its value in a request."""
    return bool(value.ends().any()) if hasattr(value, "ends") else value != 0.0


def _not_negative(values: Array) -> Truths:
    return values >= 0.0


def _loss(name: str, symbol: str, units: str, long_name: str, description: str = "") -> Input:
    """Return the row of a coefficient of a loss, with the default 0."""
    return Input(
        name, symbol, units, long_name, GRID, description,
        default=0.0, rule=f"{name} >= 0", allows=_not_negative,
    )  # fmt: skip


_ARM = "its torque is this arm times the normal force, opposite to that rotation"

# fmt: off
PARAMETERS: Mapping[str, Input] = table(
    *(row for name, row in disk.PARAMETERS.items() if name in arrays.PARAMETERS),
    Input("mass", "m", "kg", "mass", GRID,
          f"{UNKNOWN}: no law of the request needs it",
          default=UNKNOWN, rule="mass > 0", allows=positive, words=(UNKNOWN,), constants={UNKNOWN: 1.0}),
    _loss("rolling_friction", "c_r", "m", "lever arm of dry rolling friction, against rotation about the horizontal",
          _ARM),
    _loss("pivoting_friction", "c_p", "m", "lever arm of dry pivoting friction, against rotation about the vertical",
          _ARM),
    _loss("contour_friction", "c_c", "m", "lever arm of dry contour friction, against rolling along the rim", _ARM),
    _loss("contour_damping", "k_c", "N m s", "viscous contour friction: torque against rolling along the rim, over "
          "roll_rate"),
    _loss("air_viscosity", r"\mu", "Pa s", "dynamic viscosity of the air", "used by the law that air_law names"),
    _loss("air_density", r"\rho", "kg m-3", "density of the air", "used only by air_law=bildsten"),
    Input("friction", r"\mu_s", "1", "friction coefficient at the contact", GRID,
          f"a motion slips where rolling needs more; {UNLIMITED}: it never slips",
          default=UNLIMITED, rule="friction > 0", allows=positive, words=(UNLIMITED,), constants={UNLIMITED: math.inf}),
)

SUBSTITUTES = disk.SUBSTITUTES

#: Lever arms of dry friction.
ARMS = ("rolling_friction", "pivoting_friction", "contour_friction")

#: The parameters that only a disk with losses has.
LOSS_PARAMETERS = (*ARMS, "contour_damping", *AIR)

SETTINGS: Mapping[str, Input] = table(
    DURATION,
    STEP,
    replace(disk.SETTINGS["fall_tilt"], name="flat_tilt", long_name="tilt that counts as flat",
            default=math.radians(89.9), rule="0 deg < flat_tilt < 90 deg"),
    replace(disk.SETTINGS["tolerance"], units="1", rule="1e-12 <= tolerance <= 0.1",
            long_name="largest imbalance of the energy of a cell, over m g R: it determines the length of the steps"),
)

OPTIONS: Mapping[str, Word] = table(
    Word("air_law", "which law the drag of the air obeys", NO_AIR, AIR_LAWS),
)

ENDINGS = Endings(
    Ending(
        code.NOT_COMPUTED, "not_computed", "the cell has not been integrated", MISSING,
        "the cell has not been integrated",
    ),
    Ending(
        code.FLAT, "flat", "the tilt reached flat_tilt", LOST,
        "the tilt reached flat_tilt, and lying flat is unstable by this criterion",
    ),
    Ending(
        code.REST, "rest", "dry friction holds it at rest, at a tilt below flat_tilt", FINAL,
        "dry friction holds it at rest, so that this holds for all time",
    ),
    Ending(
        code.HORIZON, "horizon", "the duration was over; all values hold within it", FINAL,
        "the duration was over, and within it this holds",
    ),
    Ending(
        code.LIFT_OFF, "lift_off", "the normal force vanished: it leaves the table, and the model ends", OPEN,
        "it left the table",
    ),
    Ending(
        code.SLIP, "slip", "rolling needed more than the friction coefficient: it slips, and the model ends",
        OPEN, "it slipped",
    ),
    Ending(
        code.UNDISTURBED, "undisturbed", "upright with nothing to disturb it: there is nothing to measure",
        UNDISTURBED,
        "it stands exactly upright and nothing disturbs it, so its stability cannot be measured",
    ),
    Ending(
        code.UNRESOLVED, "unresolved",
        "the imbalance of the energy stayed above the tolerance even with shorter steps, or there were too many steps "
        "or switches of friction, or rolling friction was barely too weak to hold it", FAILED,
        "the imbalance of its energy stayed above the tolerance even with shorter steps, or it took too many steps or "
        "switches of friction, or rolling friction was barely too weak to hold it",
    ),
    Ending(
        code.INVALID, "invalid", "impossible start: not finite, or outside the domain of a parameter", FAILED,
        "the start is impossible: nothing was integrated",
    ),
    lost_time="end_time",
)

#: Law -> (parameter with the strength of the law, measure of the energy lost to it), in the order of the ledger.
LOSSES: Mapping[str, tuple[str, str]] = MappingProxyType({
    "rolling_friction": ("rolling_friction", "rolling_loss"),
    "pivoting_friction": ("pivoting_friction", "pivoting_loss"),
    "contour_friction": ("contour_friction", "contour_loss"),
    "contour_damping": ("contour_damping", "damping_loss"),
    "air": ("air_viscosity", "air_loss"),
})

_NO_CELLS = "where ending is not_computed, undisturbed, unresolved or invalid"
_NO_NUMBERS = f"missing {_NO_CELLS}"
_TIME = Tolerance(0.0, 1e-9, "each time is as near to the true one as time_error states", "time_error")
_STATE = Tolerance(1e-6, 1e-5, "the state at the ending is known less well than its time")
_LATE = Tolerance(1e-6, 1e-5, "a motion gets delayed when it passes a maximum of its potential slowly: tilt_error "
                  "states the effect", "tilt_error")
_TURNED = Tolerance(1e-6, 1e-5, "a delayed motion has turned by another angle: heading_error states the difference",
                    "heading_error")
_ROLLED = Tolerance(1e-7, 1e-5, "a delayed motion has rolled another distance: path_error states the difference",
                    "path_error")
_SUM = Tolerance(1e-7, 1e-5, "it is an integral along the motion, to the order of the method")


def _lost_to(law: str, measure: str) -> Quantity:
    words = law.replace("_", " ")
    return Quantity(measure, "W", "1", f"energy lost to {words}, over mass * gravity * radius", _SUM, _NO_NUMBERS)


def describe_amplification(scale: str) -> str:
    """Return the description of the amplification, with the formula of its scale."""
    return f"{scale}; missing where that is 0, and {_NO_CELLS}"


def _as_without_losses(name: str, description: str) -> Quantity:
    """Return a row of the disk without losses with another description."""
    return replace(disk.VARIABLES[name], description=description)


VARIABLES: Mapping[str, Quantity] = table(
    ENDINGS.quantity,
    _as_without_losses("stability", "within the duration; follows from ending, tilt_min and tilt_max; flat is "
                                    "unstable, an unresolved cell undecided"),
    _as_without_losses("tilt_min", f"signed like the coordinate tilt, until the ending; {_NO_NUMBERS}"),
    _as_without_losses("tilt_max", f"signed like the coordinate tilt, until the ending; {_NO_NUMBERS}"),
    _as_without_losses("peak_tilt", f"the larger of |tilt_min| and |tilt_max|; {_NO_NUMBERS}"),
    _as_without_losses("amplification", describe_amplification(disk.AMPLIFICATION_SCALE)),
    Quantity("end_time", "t_e", "s", "time until the ending", _TIME,
             "where ending is flat: the time aloft; rest: the time until it stopped; otherwise: the time for "
             f"which the motion was computed; {_NO_NUMBERS}"),
    Quantity("end_tilt", r"\theta_e", "rad", "tilt at the ending", _LATE, f"signed; {_NO_NUMBERS}"),
    Quantity("heading_turned", r"\Delta\psi", "rad", "angle by which the heading turned", _TURNED,
             f"signed like precession_rate; {_NO_NUMBERS}"),
    Quantity("path_length", r"\ell", "m", "length of the path of the contact point on the plane", _ROLLED,
             _NO_NUMBERS),
    *(_lost_to(law, measure) for law, (_, measure) in LOSSES.items()),
    Quantity("largest_loss", "", "1", "the loss that took most energy", DECISION, "none: nothing was lost", "i1",
             MappingProxyType(dict(enumerate(("none", *LOSSES))))),
    Quantity("breach_time", "t_b", "s", "time until the criterion of the request was first broken", _STATE,
             "missing where it was not broken, and for a criterion that does not limit the departure"),
    Quantity("energy_imbalance", r"|\Delta E|", "1",
             "largest imbalance of the energy and all losses, over mass * gravity * radius", ERROR_GAUGE,
             "the exact motion has none, so this is an error of the integration", "f4"),
    replace(disk.VARIABLES["tilt_error"], long_name="estimated error of tilt_min, tilt_max and end_tilt",
            description="from the tolerance, the imbalance of the energy, and the slow passages over maxima of the "
                        "potential"),
    Quantity("time_error", r"\delta t", "s", "estimated error of end_time", ERROR_GAUGE,
             "from the tolerance, the imbalance of the energy, all losses, and the slow passages over maxima of the "
             "potential; 0 where ending is horizon", "f4"),
    Quantity("heading_error", r"\delta\psi", "rad", "estimated error of heading_turned", ERROR_GAUGE,
             "from the tolerance, time, path and heading, and the slow passages over maxima of the potential", "f4"),
    Quantity("path_error", r"\delta\ell", "m", "estimated error of path_length", ERROR_GAUGE,
             "like heading_error", "f4"),
    disk.VARIABLES["steps"],
    disk.VARIABLES["refinements"],
    Quantity("switches", "", "1", "number of times that dry friction reversed, stuck or let go", EVENT_COUNT, "",
             "i4"),
)
# fmt: on
