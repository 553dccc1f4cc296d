"""The prediction of linear theory for one cell: small oscillations about the steady motion that its start disturbs."""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from kernels.disk.steady import (
    critical_precession_rate_squared,
    critical_roll_rate_squared,
    stability_coefficient,
)
from sweep.model.disk.initial_conditions import circling
from sweep.model.disk.tables import PARAMETERS

if TYPE_CHECKING:
    from sweep.request.spec import SweepSpec

_DISK = ("alpha", "radius", "gravity")


def in_words(spec: "SweepSpec", start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    """Yield the lines with the prediction for a cell, from its start and its stored measures [SI]."""
    if not all(np.isfinite(list(start.values()))):
        return
    if not circling(spec) and start["roll_rate"] and start["precession_rate"]:
        yield "linear      no prediction: a disk that rolls and precesses at once has no upright steady motion"
        return
    k = coefficient(spec, start)
    if not math.isfinite(k):
        yield "linear      no prediction: the squares of these rates overflow"
        return
    if k <= 0.0:
        growth = math.sqrt(-k)
        speed = (
            f"a small tilt doubles every {math.log(2.0) / growth:.4g} s" if growth else "a small tilt grows"
        )
        yield f"linear      unstable: k = {k:.6g} rad2 s-2 < 0, {speed} until it is no longer small"
        return
    period = 2.0 * math.pi / math.sqrt(k)
    measured = stored["nutation_period"]
    beside = f" (the cell has {measured:.6g} s)" if np.isfinite(measured) else ""
    yield f"linear      stable: k = {k:.6g} rad2 s-2 > 0, small oscillations of period {period:.6g} s{beside}"
    reach = small_reach(spec, start, k)
    if reach is not None:
        yield f"            that leave the steady tilt by {_angle(reach)}"


def coefficient(spec: "SweepSpec", start: Mapping[str, float]) -> float:
    """Return k [rad2 s-2] of the steady motion that a cell disturbs: upright, or circling at its own tilt."""
    tilt = start["tilt"] if circling(spec) else 0.0
    rates = np.array([start["precession_rate"], start["roll_rate"]])
    with np.errstate(over="ignore", invalid="ignore"):
        return float(stability_coefficient(tilt, *rates, *(start[name] for name in _DISK)))


def small_reach(spec: "SweepSpec", start: Mapping[str, float], k: float) -> float | None:
    """Return the largest departure [rad] that linear theory predicts for a stable cell; None for mixed starts.

    Notes
    -----
    A kick e swings out by e/sqrt(k). A release from the tilt t swings, about a steady motion that the release itself
    has changed, out to t (1 + 2/(r-1)) rolling and t (3 + 4/(r-1)) spinning, r = (rate / critical rate)^2.
    """
    if circling(spec) or start["tilt"] == 0.0:
        return abs(start["tilt_rate"]) / math.sqrt(k)
    if start["tilt_rate"] != 0.0:
        return None
    if start["roll_rate"]:
        r = start["roll_rate"] ** 2 / float(critical_roll_rate_squared(*(start[name] for name in _DISK)))
        return abs(start["tilt"]) * (1.0 + 2.0 / (r - 1.0))
    r = start["precession_rate"] ** 2 / float(
        critical_precession_rate_squared(*(start[name] for name in _DISK))
    )
    return abs(start["tilt"]) * (3.0 + 4.0 / (r - 1.0))


def _angle(value: float) -> str:
    return PARAMETERS["tilt"].spell(value, 6)
