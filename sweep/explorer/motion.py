"""Whether a start has a motion, and the words of a request for it, from what the page shows."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from sweep.errors import NoMotionError, RequestError
from sweep.explorer.body import is_body
from sweep.explorer.losses import has_losses, loss_words
from sweep.model.disk.model import DISK
from sweep.model.lossy_disk.tables import NO_AIR
from sweep.motion.lossy_tables import LOSSY_BODY_MOTION, LOSSY_MOTION
from sweep.motion.tables import DISK_MOTION, kind_of_model
from sweep.request.body import check_body_named
from sweep.request.spec import SweepSpec

#: Largest rate, in units of sqrt(g/R): the energy contains its square.
_LARGEST = 1e100

#: Values of words that mean that a spec lacks the loss.
_NONE = (None, 0.0, NO_AIR)

_STATE = ("tilt", "tilt_rate", "precession_rate", "roll_rate")


def is_lossy(spec: SweepSpec, losses: Mapping[str, Any]) -> bool:
    """Return whether a motion has losses, either those of its cells or requested ones."""
    return has_losses(spec) or bool(loss_words(losses))


def words_of(spec: SweepSpec, start: Mapping[str, float], losses: Mapping[str, Any]) -> dict[str, Any]:
    """Return the words of a request for the motion of a cell, except its duration.

    Parameters
    ----------
    spec : SweepSpec
        Also provides the settings, such as the tilt at which the disk counts as fallen or as flat.
    start : mapping of str to float
        Every parameter of the spec's model [SI].
    losses : mapping of str to number or text
        The requested losses, as from the page.

    Raises
    ------
    RequestError
        If a name is not that of a loss, or the body has no losses.
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
        # adds what a law needs if the cells do not provide it
        lost = {name: each for name, each in lost.items() if name in losses or words.get(name) in _NONE}
        if lost.get("air_law", words.get("air_law")) == NO_AIR:
            words |= dict.fromkeys(("air_viscosity", "air_density"), 0.0)
    return words | lost


def check_start(spec: SweepSpec, start: Mapping[str, float]) -> None:
    """Raise an error if a start has no motion.

    Raises
    ------
    NoMotionError
        If no rate keeps the tilt constant although one should, or a parameter is outside its range, as at the border of
        some maps.
    RequestError
        If its energy is not finite.
    """
    none = [name for name in _STATE if not math.isfinite(start[name])]
    if none:
        raise NoMotionError(
            f"No motion here: no {none[0]} keeps this tilt constant.",
            hint="Choose another place on the map.",
            where=none[0],
        )
    for name, known in (spec.model if is_body(spec) else DISK).parameters.items():
        if not known.allows(np.array([start[name]]))[0]:
            raise NoMotionError(
                f"No motion here: it needs {known.rule}; got {known.spell(start[name])}.",
                hint="Choose another place on the map.",
                where=name,
            )
    unit = _unit(start)
    for name in _STATE:
        if not abs(start[name]) * (1.0 if name == "tilt" else unit) < _LARGEST:
            raise RequestError(
                f"No motion here: {name} is so large that the energy overflows.",
                hint="Choose another place on the map, or a smaller number.",
                where=name,
            )


def _unit(start: Mapping[str, float]) -> float:
    """Return the natural time unit of the disk, sqrt(R/g) [s]."""
    return math.sqrt(start["radius"]) / math.sqrt(start["gravity"])
