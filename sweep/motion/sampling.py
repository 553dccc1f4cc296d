"""Motions as datasets: checks, descriptions, and the same motion with samples close enough for figures."""

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from sweep.errors import RequestError
from sweep.model import registry
from sweep.model.quantity import UNKNOWN_ERROR
from sweep.motion.lossy_tables import LAWS
from sweep.motion.request import MotionRequest, motions_of
from sweep.motion.tables import TIME, MotionKind
from sweep.request.words import AUTOMATIC

if TYPE_CHECKING:
    import xarray as xr

#: Largest change [rad] of tilt, heading and roll angle between two samples of a motion in a figure.
_TURN = 0.25

#: Least number of samples of a whole motion in a figure, so that no swing of the tilt falls between them; one less than
#: with interval=auto, because of rounding.
_LEAST = 999

_REQUEST = "trajectory_request"


def is_motion(dataset: "xr.Dataset") -> bool:
    """Return whether a dataset is a motion as `sweep.simulate` returns it, or a part of one."""
    return "eulerdisk_trajectory_format" in dataset.attrs


def kind_of(dataset: "xr.Dataset") -> MotionKind:
    """Return the kind of a motion, from its model.

    Raises
    ------
    RequestError
        If its system cannot be read.
    """
    name = str(dataset.attrs.get("model", ""))
    return motions_of(name) if name in registry.names() else request_of(dataset).kind


def is_of_body(dataset: "xr.Dataset") -> bool:
    """Return whether a motion is of a body of revolution other than the thin disk."""
    return kind_of(dataset).called == "body"


def ending_of(dataset: "xr.Dataset") -> str:
    """Return the name of the ending of a motion."""
    return kind_of(dataset).variables["ending"].flag(float(dataset["ending"].values))


def end_of(dataset: "xr.Dataset") -> str:
    """Return how and when a motion ended before its duration, in words; empty if it did not."""
    kind = kind_of(dataset)
    if "sensitive_from" in kind.variables and np.isfinite(since := float(dataset["sensitive_from"])):
        return f"too sensitive to its start from {kind.time.spell(since, 6)} on"
    time = float(dataset[kind.ending_time].values)
    if not time <= dataset[TIME.name].values[-1]:
        return ""
    return f"{kind.endings[ending_of(dataset)]} at {kind.time.spell(time, 6)}"


def peaks_of(dataset: "xr.Dataset") -> Iterator[tuple[str, str]]:
    """Yield names and values for reports of a motion: the largest magnitudes and the last values of its kind."""
    kind = kind_of(dataset)
    for name in kind.peaks:
        largest = float(np.abs(dataset[name].values).max())
        yield f"peak {name}", kind.variables[name].spell(largest, 3)
    for name in kind.results:
        quantity, last = kind.variables[name], float(dataset[name].values.flat[-1])
        value = quantity.flag(last) if quantity.flags else quantity.spell(last, 6)
        stated = dataset.get(quantity.tolerance.stated)
        if stated is not None and float(stated.values[-1]) >= UNKNOWN_ERROR:
            value = "undecided"
        yield name.replace("_", " "), "missing" if np.isnan(last) else value


def check_filmed(kind: MotionKind, hint: str) -> None:
    """Refuse a film of a motion without a disk or body; `hint` says how to draw the motion instead.

    Raises
    ------
    RequestError
    """
    if not kind.largest_tilt:
        raise RequestError(
            f"A film shows a rolling disk or body, but {kind.model.name} is another system.",
            hint=hint,
        )


def losses_of(dataset: "xr.Dataset") -> str:
    """Return the losses of a motion in words, with their shares; empty if nothing was lost."""
    if not kind_of(dataset).stops:
        return ""
    lost = {words: float(dataset[name].values[-1] - dataset[name].values[0]) for name, words in LAWS.items()}
    total = sum(lost.values())
    parts = [f"{words} {100.0 * energy / total:.1f} %" for words, energy in lost.items() if energy > 0.0]
    return f"{total:.4g} J, of it {', '.join(parts)}" if parts else ""


def check_motion(dataset: "xr.Dataset") -> None:
    """Refuse a dataset that is not a motion, or too small a part of a motion to draw.

    Raises
    ------
    RequestError
    """
    if not is_motion(dataset):
        names = ", ".join(map(str, dataset.data_vars)) or "no variables"
        raise RequestError(
            f"This is not a motion from sweep.simulate or eulerdisk simulate; got a dataset of {names}.",
            hint="If it was one, keep its attributes (xarray.set_options(keep_attrs=True)).",
        )
    kind = kind_of(dataset)
    missing = [name for name in (*kind.variables, *kind.fixed) if name not in dataset]
    if missing:
        raise RequestError(
            f"Variables that a figure or film needs are missing in this motion: {', '.join(missing)}.",
            hint="Use the dataset as sweep.simulate returned it; you may select a part of elapsed_time.",
        )
    times = np.atleast_1d(dataset[TIME.name].values)
    if not (np.diff(times) > 0.0).all():
        raise RequestError(
            f"The samples of a motion must be in order: {TIME.name} must increase.",
            hint=f"Use dataset.sortby({TIME.name!r}).",
            where=TIME.name,
        )
    size = dataset.sizes.get(TIME.name, 1)
    if size < 2:
        raise RequestError(
            f"A figure or film needs at least two samples of a motion; got {size}.",
            hint="Select a longer part of elapsed_time.",
        )


def closely_sampled(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return the same motion with samples close enough to draw curves through them.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, or a part of it in time; it is returned itself if its samples are close enough.

    Raises
    ------
    RequestError
        If it is not a motion, or cannot be computed again.
    """
    # imported here: `is_motion` must not load what only a computation needs
    from sweep.motion.trajectory import simulate

    check_motion(dataset)
    request = request_of(dataset)
    if _is_close(dataset, request):
        return dataset
    whole = simulate(MotionRequest.read(**request.words() | {"interval": AUTOMATIC}))
    times = dataset[TIME.name].values
    inside = (whole[TIME.name] >= times[0]) & (whole[TIME.name] <= times[-1])
    part = whole.isel({TIME.name: inside.values})
    return part if part.sizes[TIME.name] > times.size else dataset


def request_of(dataset: "xr.Dataset") -> MotionRequest:
    """Return the request that a motion was made from; raise RequestError if its attribute cannot be read."""
    try:
        words = json.loads(str(dataset.attrs[_REQUEST]))
        # the file is not trusted: it contains the text of a system and must not name another file
        if "model" in words:
            raise ValueError("a motion names no model")
        return MotionRequest.read(**words)
    except (KeyError, TypeError, ValueError):
        raise RequestError(
            f"The request that this motion was made from cannot be read: its attribute {_REQUEST} is missing or was "
            "changed.",
            hint="Use the dataset as sweep.simulate returned it.",
        ) from None


def _is_close(dataset: "xr.Dataset", request: MotionRequest) -> bool:
    if not request.kind.turning:
        return bool(request.interval == AUTOMATIC)
    times = dataset[TIME.name].values
    ended = float(dataset[request.kind.ending_time])
    # a disk at rest from its start is sampled for the duration
    length = ended if ended > 0.0 else request.duration
    turns = [np.abs(np.diff(dataset[name].values)).max() for name in request.kind.turning]
    return bool(_LEAST * np.diff(times).max() <= length and max(turns) <= _TURN)
