"""Initial conditions of the disk: the rates that each cell computes so that its tilt stays constant."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kernels.disk.steady import (
    centred_roll_rate,
    steady_precession_rates,
    steady_roll_rate,
    wobble_precession_rate,
)
from sweep.errors import RequestError
from sweep.model.description import Request, Starts
from sweep.model.disk.tables import STEADY_PRECESSION, STEADY_ROLL, WOBBLE


def computed_rates(spec: Request) -> tuple[str, ...]:
    """Return the rates that each cell computes from its tilt and the other rate; empty if all are given."""
    return tuple(name for name in ("precession_rate", "roll_rate") if isinstance(getattr(spec, name), str))


def circling(spec: Request) -> bool:
    """Return whether the undisturbed motion of each cell is circling at its own tilt, instead of the upright disk.

    Then the cell computes rates that keep its tilt constant. With the centre at rest, only one precession rate does so:
    at any other rate the disk nutates about upright.
    """
    return isinstance(spec.precession_rate, str) or spec.roll_rate == STEADY_ROLL


def check_steady_rates(values: Mapping[str, Any]) -> None:
    """Refuse words for steady rates that do not determine the rates.

    Raises
    ------
    RequestError
    """
    roll, precession = values["roll_rate"], values["precession_rate"]
    if precession == WOBBLE and roll != WOBBLE:
        raise RequestError(
            f"precession_rate=wobble is the rate that keeps the tilt constant while the centre of the disk rests. It "
            f"needs roll_rate=wobble; got roll_rate={roll}.",
            hint="Add roll_rate=wobble, or give a number for precession_rate.",
            where="precession_rate",
        )
    if roll == WOBBLE and precession in STEADY_PRECESSION:
        raise RequestError(
            f"precession_rate={precession} needs a number for roll_rate; got roll_rate=wobble.",
            hint="Write precession_rate=wobble, or give a number for one of them.",
            where="precession_rate",
        )
    if roll == STEADY_ROLL and precession in STEADY_PRECESSION:
        raise RequestError(
            f"roll_rate=steady and precession_rate={precession} leave both rates open: one of them must be given.",
            hint="Give a number, a list or a range for one of them, as in roll_rate=-8:8:400.",
            where="precession_rate",
        )
    if (
        roll == STEADY_ROLL
        and (precession.ends().any() if hasattr(precession, "ends") else precession) == 0.0
    ):
        raise RequestError(
            f"Without precession no roll rate keeps the tilt constant: roll_rate=steady needs a precession_rate "
            f"other than 0; got precession_rate={precession}.",
            hint="Give a precession_rate, as in precession_rate=0.05:5:400, or a number for roll_rate.",
            where="precession_rate",
        )


def complete(spec: Request, starts: Starts) -> Starts:
    """Return starts with the rates that the spec leaves to the cell; not finite where no such rate exists.

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array, shape (n,)
        Every parameter except the computed rates, in SI; values for those are ignored.
    """
    tilt, disk = starts["tilt"], [starts[name] for name in ("alpha", "radius", "gravity")]
    completed = dict(starts)
    with np.errstate(divide="ignore", invalid="ignore"):
        if spec.precession_rate == WOBBLE:
            completed["precession_rate"] = wobble_precession_rate(tilt, *disk)
        elif isinstance(spec.precession_rate, str):
            both = steady_precession_rates(tilt, starts["roll_rate"], *disk)
            completed["precession_rate"] = both[STEADY_PRECESSION.index(spec.precession_rate)]
        if spec.roll_rate == WOBBLE:
            completed["roll_rate"] = centred_roll_rate(tilt, completed["precession_rate"])
        elif isinstance(spec.roll_rate, str):
            completed["roll_rate"] = steady_roll_rate(tilt, starts["precession_rate"], *disk)
    return completed
