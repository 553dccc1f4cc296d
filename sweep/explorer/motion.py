"""Whether a start has a motion, and the words of a request for it: of what the page shows, for copies and words."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from sweep.errors import NoMotionError, RequestError
from sweep.explorer.body import is_body
from sweep.explorer.losses import has_losses, loss_words
from sweep.model.disk.model import DISK
from sweep.model.lossy_disk.tables import NO_AIR
from sweep.motion.lossy_body_tables import LOSSY_BODY_MOTION
from sweep.motion.tables import DISK_MOTION, LOSSY_MOTION, kind_of_model
from sweep.request.body import check_body_named
from sweep.request.spec import SweepSpec

#: Rates over sqrt(g/R) are smaller: the energy has their squares.
_LARGEST = 1e100

#: Values of words that a spec does not have.
_NONE = (None, 0.0, NO_AIR)

_STATE = ("tilt", "tilt_rate", "precession_rate", "roll_rate")


def is_lossy(spec: SweepSpec, losses: Mapping[str, Any]) -> bool:
    """Return whether a motion has losses: those of its cells, or words that ask for some."""
    return has_losses(spec) or bool(loss_words(losses))


def words_of(spec: SweepSpec, start: Mapping[str, float], losses: Mapping[str, Any]) -> dict[str, Any]:
    """Return the words of a request for the motion of a cell, all but its duration.

    Parameters
    ----------
    spec : SweepSpec
        It has the settings: the tilt at which the disk has fallen, or is flat, among them.
    start : mapping of str to float
        Every parameter of its model [SI].
    losses : mapping of str to number or text
        As for `motion`.

    Raises
    ------
    RequestError
        If a name is none of a loss, or the body has no losses.
    """
    words: dict[str, Any] = dict(start) | {name: getattr(spec, name) for name in spec.constants}
    lost = loss_words(losses)
    if lost and is_body(spec):
        check_body_named(LOSSY_BODY_MOTION.model, {"body": spec.body})
    lossy = has_losses(spec)
    known = kind_of_model(spec.model).words
    words |= {name: getattr(spec, name) for name in spec.model.options if name in known}
    fall = (LOSSY_MOTION if lossy or lost else DISK_MOTION).largest_tilt
    if hasattr(spec, fall):
        words[fall] = getattr(spec, fall)
    if lossy and losses:
        lost = lost or dict(losses)
        # what a law needs is added where the cells have none of it
        lost = {name: each for name, each in lost.items() if name in losses or words.get(name) in _NONE}
        if lost.get("air_law", words.get("air_law")) == NO_AIR:
            words |= dict.fromkeys(("air_viscosity", "air_density"), 0.0)
    return words | lost


def check_start(spec: SweepSpec, start: Mapping[str, float]) -> None:
    """Refuse a start that has no motion.

    Raises
    ------
    NoMotionError
        If a rate was to keep the tilt constant and none does, or a parameter is beyond its limits, as some at the
        border of a map are.
    RequestError
        If the energy of it is no number.
    """
    none = [name for name in _STATE if not math.isfinite(start[name])]
    if none:
        raise NoMotionError(
            f"Here is no motion: no {none[0]} keeps this tilt constant.",
            hint="Choose another place of the map.",
            where=none[0],
        )
    for name, known in (spec.model if is_body(spec) else DISK).parameters.items():
        if not known.allows(np.array([start[name]]))[0]:
            raise NoMotionError(
                f"Here is no motion: it needs {known.rule}; got {known.spell(start[name])}.",
                hint="Choose another place of the map.",
                where=name,
            )
    unit = _unit(start)
    for name in _STATE:
        if not abs(start[name]) * (1.0 if name == "tilt" else unit) < _LARGEST:
            raise RequestError(
                f"Here is no motion: {name} is so large that its energy is no number.",
                hint="Choose another place of the map, or a smaller number.",
                where=name,
            )


def _unit(start: Mapping[str, float]) -> float:
    """Return the disk's own unit of time, sqrt(R/g) [s]."""
    return math.sqrt(start["radius"]) / math.sqrt(start["gravity"])
