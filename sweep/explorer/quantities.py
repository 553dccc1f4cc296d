"""The quantities that the map shows as colours, and the numbers of a point."""

from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.description import Columns
from sweep.model.disk.path import PATH_VARIABLES
from sweep.model.quantity import DECISION, FAILED, LOST, Quantity
from sweep.request.spec import SweepSpec

#: Kinds of motion: wells of the potential, and whether the motion crosses upright; or why neither is known.
REGIME = Quantity(
    "regime", "", "1", "kind of motion", DECISION,
    "wells of the potential for the constants of the motion, and whether the disk passes upright", "u1",
    MappingProxyType({
        0: "one_well,_one_side", 1: "one_well,_crosses", 2: "two_wells,_one_side", 3: "two_wells,_crosses",
        4: "falls", 5: "no_result",
    }),
)  # fmt: skip


@dataclass(frozen=True)
class Shown:
    """A quantity that the map can show.

    Parameters
    ----------
    quantity : Quantity
    needs : tuple of str
        Columns of a cell that `values` needs.
    values : callable
        (spec, columns) -> array, shape (n,): float64, or the codes of `quantity`.
    timed : bool
        Whether it needs the period or more, which takes several times as long.
    """

    quantity: Quantity
    needs: tuple[str, ...]
    values: Callable[[SweepSpec, Columns], npt.NDArray[Any]]
    timed: bool = False


def shown_of(spec: SweepSpec) -> dict[str, Shown]:
    """Return the quantities of a spec's cells that the map can show, the default one first."""
    model = spec.model
    variables = model.cell_variables(spec)
    names = (
        model.drawn_of(spec), model.peak, *model.shown, "peak_tilt", "stability",
        "amplification", "separatrix", "nutation_period", "fall_time",
        "end_time", "largest_loss", "least_normal_force", "friction_needed", *PATH_VARIABLES,
    )  # fmt: skip
    unknown = model.unknown_to.get(spec.method, ())
    found = {
        name: Shown(variables[name], (name,), _column(name), name not in _EXTREMES)
        for name in names
        if name in variables and name not in unknown
    }
    if {"wells", *model.extremes} <= variables.keys():
        found[REGIME.name] = Shown(REGIME, ("ending", "wells", *model.extremes), _regime)
    return found


#: Columns that are available without computing periods.
_EXTREMES = ("peak_tilt", "stability", "amplification", "separatrix")


def _column(name: str) -> Callable[[SweepSpec, Columns], npt.NDArray[Any]]:
    def values(spec: SweepSpec, columns: Columns) -> npt.NDArray[Any]:
        coded = spec.model.cell_variables(spec)[name].flags is not None
        return columns[name].astype(np.uint8 if coded else np.float64, copy=False)

    return values


def _regime(spec: SweepSpec, columns: Columns) -> npt.NDArray[np.uint8]:
    endings, ending = spec.model.endings, columns["ending"]
    low, high = (columns[name] for name in spec.model.extremes)
    found = 2 * (columns["wells"].astype(np.int8) - 1) + ((low < 0.0) & (high > 0.0))
    found = np.where(columns["wells"] > 0, found, 5)
    found = np.where(endings.have(LOST, ending), 4, found)
    return np.where(endings.have(FAILED, ending), 5, found).astype(np.uint8)


def described(quantity: Quantity) -> dict[str, Any]:
    """Return the page's description of a number: names, unit, factor, flags, and whether files store it in 4 bytes."""
    flags = quantity.flags
    return {
        "name": quantity.name,
        "label": quantity.name.replace("_", " "),
        "description": quantity.long_name,
        "unit": quantity.shown_units,
        "factor": quantity.plot_scale,
        "single": quantity.dtype == "f4",
        "flags": None if flags is None else {str(code): quantity.flag(code) for code in flags},
    }
