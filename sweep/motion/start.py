"""The start of one motion: every parameter as a number, with the rates that keep its tilt where words ask for them."""

import math
from typing import Any

import numpy as np

from sweep.errors import RequestError
from sweep.model.quantity import Array
from sweep.motion.request import MotionRequest


def start_of(spec: MotionRequest) -> Array:
    """Return the start of a motion, shape (number of parameters,), in the order of the model's parameters.

    Raises
    ------
    RequestError
        If no rate keeps the tilt constant that should.
    """
    model = spec.kind.model
    # what completes starts takes arrays too: a number without dimensions is both
    given: dict[str, Any] = {
        name: value if isinstance(value := getattr(spec, name), str) else np.float64(value)
        for name in model.parameters
    }
    values = model.complete(spec, given)
    for rate in ("precession_rate", "roll_rate"):
        if isinstance(given[rate], str) and not np.isfinite(values[rate]):
            other = "precession_rate" if rate == "roll_rate" else "roll_rate"
            raise RequestError(
                f"No {rate} keeps this tilt constant; got {rate}={given[rate]} with {other}="
                f"{given[other]:.6g} tilt={math.degrees(spec.tilt):.6g}deg.",
                hint=f"Give a larger {other}, a tilt other than 0, or a number for {rate}.",
                where=rate,
            )
    return np.array([values[name] for name in model.parameters], dtype=np.float64)
