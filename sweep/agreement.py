"""Whether cells of an atlas agree with the exact reduction: the comparison, on arrays."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep import cells
from sweep.runner import exact_measures
from sweep.schema import STABLE, UNDECIDED, UNSTABLE, VARIABLES, Array, Truths
from sweep.schema_exact import (
    AGREES,
    ATLAS_UNRESOLVED,
    DISAGREES,
    EXACT_UNRESOLVED,
    INVALID,
    MARGINAL,
    NOT_COMPUTED,
)
from sweep.spec import SweepSpec
from sweep.theory import limit

Columns = Mapping[str, Array]

#: What the audit reads of an atlas.
NEEDED = ("ending", "stability", "tilt_min", "tilt_max", "peak_tilt", "amplification", "nutation_period")

#: Periods follow the tilts except near a separatrix; RK4 at the default tolerance stays below 2e-8 in the presets.
_PERIOD_SHARE = 1e-4

#: An energy error as large as the tilt tolerance (times m g R) moves the passage of a saddle, whose height over the
#: energy is the separatrix, by up to tolerance/separatrix in units of sqrt(R/g); measured: half of that.
_PERIOD_AT_SADDLE = 2.0

#: Tilts are known to about this much [rad], besides the reduction's own error; a swing of hardly more has a period of
#: few digits.
_PERIOD_ROUNDING = 1e-14

_CODES = {name: code for code, name in (VARIABLES["ending"].flags or {}).items()}


def check(spec: SweepSpec, given: dict[str, Array], stored: Columns) -> dict[str, npt.NDArray[Any]]:
    """Hold stored cells against the exact reduction.

    Parameters
    ----------
    spec : SweepSpec
    given : dict of str to array, shape (n,)
        The starts of the cells.
    stored : mapping of str to array, shape (n,)
        The variables of `NEEDED`.

    Returns
    -------
    dict of str to array, shape (n,)
        The variables of `schema_exact.AUDIT`.
    """
    exact = exact_measures(spec, given)
    steady, scale = cells.steady_tilt(spec, given), cells.scale(spec, given)
    exact_stability = spec.criterion.verdict(
        exact["ending"], exact["tilt_min"], exact["tilt_max"], steady, scale
    )
    allowed = spec.tolerance + 2.0 * np.nan_to_num(exact["tilt_error"])
    difference = _tilt_difference(stored, exact)
    period_difference = stored["nutation_period"] - exact["nutation_period"]
    sound = (
        (difference <= allowed)
        & _period_agrees(spec, given, period_difference, exact)
        & _derived_agree(stored, steady, scale)
        & _finite_where_due(stored)
    )
    same = _endings_agree(stored, exact, allowed) & _verdicts_agree(stored, exact_stability)
    margin = _margin(spec, given, stored, exact, steady) <= allowed
    code = np.where(sound & same, AGREES, np.where(sound & margin, MARGINAL, DISAGREES))
    code = _set_apart(code, stored["ending"], exact["ending"])
    return {
        "audit": code.astype(np.int8),
        "tilt_difference": difference,
        "period_difference": period_difference,
        "exact_tilt_min": exact["tilt_min"],
        "exact_tilt_max": exact["tilt_max"],
        "exact_period": exact["nutation_period"],
        "exact_stability": exact_stability,
        "wells": exact["wells"].astype(np.int8),
        "separatrix": exact["separatrix"],
    }


def _tilt_difference(stored: Columns, exact: Columns) -> Array:
    """Larger difference of the two extremes; a run that time ended need only lie inside the exact ones."""
    low, high = stored["tilt_min"] - exact["tilt_min"], stored["tilt_max"] - exact["tilt_max"]
    horizon = stored["ending"] == _CODES["horizon"]
    return np.where(
        horizon,
        np.maximum(0.0, np.maximum(-low, high)),
        np.maximum(np.abs(low), np.abs(high)),
    )


def _period_agrees(spec: SweepSpec, given: Columns, difference: Array, exact: Columns) -> Truths:
    unit = np.sqrt(given["radius"] / given["gravity"])
    separatrix = np.abs(exact["separatrix"])
    with np.errstate(divide="ignore"):
        lingering = np.where(np.isnan(separatrix), 0.0, _PERIOD_AT_SADDLE * spec.tolerance / separatrix)
    # where one of the two has no period (a fall, no ending in time) there is nothing to compare
    with np.errstate(divide="ignore"):
        blur = _PERIOD_ROUNDING + 10.0 * exact["tilt_error"]
        share = _PERIOD_SHARE + blur / (exact["tilt_max"] - exact["tilt_min"])
    near = np.abs(difference) <= share * exact["nutation_period"] + unit * lingering
    agrees: Truths = near | np.isnan(difference)
    return agrees


def _derived_agree(stored: Columns, steady: Array, scale: Array) -> Truths:
    """Whether the numbers that follow from the extremes do follow from them, bit for bit."""
    least, greatest = stored["tilt_min"], stored["tilt_max"]
    reach = np.maximum(np.abs(greatest - steady), np.abs(least - steady))
    with np.errstate(divide="ignore", invalid="ignore"):
        amplification = np.where(scale > 0.0, reach / scale, np.nan)
    return _same(stored["peak_tilt"], np.maximum(np.abs(least), np.abs(greatest))) & _same(
        stored["amplification"], amplification
    )


def _same(one: Array, other: Array) -> Truths:
    same: Truths = (one == other) | (np.isnan(one) & np.isnan(other))
    return same


def _finite_where_due(stored: Columns) -> Truths:
    bounded = stored["ending"] == _CODES["bounded"]
    fine: Truths = ~bounded | np.isfinite(stored["nutation_period"])
    return fine


def _margin(
    spec: SweepSpec, given: dict[str, Array], stored: Columns, exact: Columns, steady: Array
) -> Array:
    """How near [rad] the motion comes to where its verdict or its ending would change."""
    reach = np.maximum(np.abs(exact["tilt_max"] - steady), np.abs(exact["tilt_min"] - steady))
    peak = np.maximum(np.abs(exact["tilt_max"]), np.abs(exact["tilt_min"]))
    # of a fall the reduction knows no turning point: the atlas says how near it comes
    peak = np.where(exact["ending"] == _CODES["fell"], stored["peak_tilt"], peak)
    return np.minimum(np.abs(reach - limit(spec, given)), np.abs(peak - spec.fall_tilt))


def _endings_agree(stored: Columns, exact: Columns, allowed: Array) -> Truths:
    """Whether endings mean the same.

    A run that time ended says nothing of the end, and a motion within the tolerance of rest is as good as steady.
    """
    ending = stored["ending"]
    at_rest = exact["tilt_max"] - exact["tilt_min"] <= allowed
    calm = np.isin(ending, (_CODES["bounded"], _CODES["steady"])) & at_rest
    agree: Truths = (ending == exact["ending"]) | (ending == _CODES["horizon"]) | calm
    return agree


def _verdicts_agree(stored: Columns, exact: npt.NDArray[Any]) -> Truths:
    stability = stored["stability"]
    contrary = ((stability == STABLE) & (exact == UNSTABLE)) | ((stability == UNSTABLE) & (exact == STABLE))
    # only a run that time ended may leave open what the reduction decides
    open_ = (stability == UNDECIDED) & (exact != UNDECIDED) & (stored["ending"] != _CODES["horizon"])
    agree: Truths = ~contrary & ~open_
    return agree


def _set_apart(code: npt.NDArray[Any], ending: npt.NDArray[Any], exact: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Cells that one of the two has nothing to say of."""
    code = np.where(exact == _CODES["unresolved"], EXACT_UNRESOLVED, code)
    code = np.where(ending == _CODES["unresolved"], ATLAS_UNRESOLVED, code)
    code = np.where((ending == _CODES["invalid"]) & (exact == _CODES["invalid"]), INVALID, code)
    code = np.where((ending == _CODES["invalid"]) ^ (exact == _CODES["invalid"]), DISAGREES, code)
    return np.where(ending == _CODES["not_computed"], NOT_COMPUTED, code)
