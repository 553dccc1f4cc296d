"""The starts of the disk: the rates that a cell computes for itself so that its tilt stays constant."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kernels.disk.steady import steady_precession_rates, steady_roll_rate
from sweep.errors import RequestError
from sweep.model.description import Request, Starts
from sweep.model.disk.tables import STEADY_PRECESSION, STEADY_ROLL


def computed_rate(spec: Request) -> str | None:
    """Return the rate that each cell computes so that its tilt stays constant; None if all rates are given."""
    if spec.roll_rate == STEADY_ROLL:
        return "roll_rate"
    return "precession_rate" if spec.precession_rate in STEADY_PRECESSION else None


def circling(spec: Request) -> bool:
    """Whether each cell has the rates that keep its tilt: then it disturbs circling at its tilt, otherwise upright."""
    return computed_rate(spec) is not None


def check_steady_rates(values: Mapping[str, Any]) -> None:
    """Refuse steady rates that do not follow from the others.

    Raises
    ------
    RequestError
    """
    roll, precession = values["roll_rate"], values["precession_rate"]
    if roll == STEADY_ROLL and precession in STEADY_PRECESSION:
        raise RequestError(
            f"roll_rate=steady and precession_rate={precession} leave both rates open: one of them has to be given.",
            hint="Give a number, a list or a range for one of them, as in roll_rate=-8:8:400.",
            where="precession_rate",
        )
    if (
        roll == STEADY_ROLL
        and (precession.ends().any() if hasattr(precession, "ends") else precession) == 0.0
    ):
        raise RequestError(
            f"No roll rate keeps the tilt constant without precession: roll_rate=steady needs a precession_rate "
            f"other than 0; got {precession}.",
            hint="Give a precession_rate, as in precession_rate=0.05:5:400, or a number for roll_rate.",
            where="precession_rate",
        )


def complete(spec: Request, starts: Starts) -> Starts:
    """Return starts with the rate that the spec leaves to the cell, not finite where no such rate exists.

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array, shape (n,)
        Every parameter but the computed rate, in SI; a value that it has for that one is not looked at.
    """
    disk = [starts[name] for name in ("alpha", "radius", "gravity")]
    rate = computed_rate(spec)
    with np.errstate(divide="ignore", invalid="ignore"):
        if rate == "roll_rate":
            return {**starts, rate: steady_roll_rate(starts["tilt"], starts["precession_rate"], *disk)}
        if rate == "precession_rate":
            both = steady_precession_rates(starts["tilt"], starts["roll_rate"], *disk)
            return {**starts, rate: both[STEADY_PRECESSION.index(str(spec.precession_rate))]}
    return starts
