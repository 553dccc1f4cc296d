"""Motions as datasets: whether a dataset is one, and the same motion with samples close enough to be drawn."""

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from sweep.errors import RequestError
from sweep.model import registry
from sweep.motion.request import MotionRequest, motions_of
from sweep.motion.tables import LAWS, TIME, MotionKind
from sweep.request.words import AUTOMATIC

if TYPE_CHECKING:
    import xarray as xr

#: Angle [rad] by which tilt, heading and roll angle may change between two samples of a motion that is drawn.
_TURN = 0.25

#: Samples of a whole motion that is drawn at least, so that no swing of the tilt falls between them; one less than the
#: engine takes by itself, because of rounding.
_LEAST = 999

_REQUEST = "trajectory_request"


def is_motion(dataset: "xr.Dataset") -> bool:
    """Return whether a dataset is one motion in time, as `sweep.simulate` returns it, or a part of one."""
    return "eulerdisk_trajectory_format" in dataset.attrs


def kind_of(dataset: "xr.Dataset") -> MotionKind:
    """Return of which model a motion is: a file that names none is one of the disk without losses.

    Raises
    ------
    RequestError
        If it is of a system that cannot be read.
    """
    name = str(dataset.attrs.get("model", registry.DEFAULT))
    return motions_of(name) if name in registry.names() else request_of(dataset).kind


def is_of_body(dataset: "xr.Dataset") -> bool:
    """Return whether a motion is one of a body of revolution that has a shape."""
    return kind_of(dataset).called == "body"


def ending_of(dataset: "xr.Dataset") -> str:
    """Return the name of the ending of a motion."""
    return kind_of(dataset).variables["ending"].flag(float(dataset["ending"].values))


def end_of(dataset: "xr.Dataset") -> str:
    """Return how and when a motion came to its end before its duration, in words; empty if it did not, or goes on."""
    kind = kind_of(dataset)
    if "sensitive_from" in kind.variables and np.isfinite(since := float(dataset["sensitive_from"])):
        return f"too sensitive to its start from {kind.time.spell(since, 6)} on"
    time = float(dataset[kind.ending_time].values)
    if not time <= dataset[TIME.name].values[-1]:
        return ""
    return f"{kind.endings[ending_of(dataset)]} at {kind.time.spell(time, 6)}"


def peaks_of(dataset: "xr.Dataset") -> Iterator[tuple[str, str]]:
    """Yield what is told of a motion: names and values, the largest magnitudes and the last values of its kind."""
    kind = kind_of(dataset)
    for name in kind.peaks:
        largest = float(np.abs(dataset[name].values).max())
        yield f"peak {name}", kind.variables[name].spell(largest, 3)
    for name in kind.results:
        quantity, last = kind.variables[name], float(dataset[name].values.flat[-1])
        yield name.replace("_", " "), quantity.flag(last) if quantity.flags else quantity.spell(last, 6)


def check_filmed(kind: MotionKind, hint: str) -> None:
    """Refuse a film of a motion that no film shows: the picture of a film is a disk; the hint says how to draw it.

    Raises
    ------
    RequestError
    """
    if not kind.largest_tilt:
        raise RequestError(
            f"A film shows a rolling disk, and {kind.model.name} is another system.",
            hint=hint,
        )


def losses_of(dataset: "xr.Dataset") -> str:
    """Return what took the energy of a motion, in words with shares; empty if nothing was lost, or nothing can be."""
    if not kind_of(dataset).stops:
        return ""
    lost = {words: float(dataset[name].values[-1] - dataset[name].values[0]) for name, words in LAWS.items()}
    total = sum(lost.values())
    parts = [f"{words} {100.0 * energy / total:.1f} %" for words, energy in lost.items() if energy > 0.0]
    return f"{total:.4g} J, of it {', '.join(parts)}" if parts else ""


def check_motion(dataset: "xr.Dataset") -> None:
    """Refuse what is no motion, or only so little of one that it cannot be drawn.

    Raises
    ------
    RequestError
    """
    if not is_motion(dataset):
        given = ", ".join(map(str, dataset.data_vars)) or "no variables"
        raise RequestError(
            "This is no motion: a motion is what sweep.simulate and eulerdisk simulate make; "
            f"got a dataset of {given}.",
            hint="Keep its attributes (xarray.set_options(keep_attrs=True)).",
        )
    kind = kind_of(dataset)
    missing = [name for name in (*kind.variables, *kind.fixed) if name not in dataset]
    if missing:
        raise RequestError(
            f"A part of this motion is missing, and a figure or film needs it: {', '.join(missing)}.",
            hint="Take the dataset as sweep.simulate returned it; a stretch of elapsed_time can be chosen.",
        )
    times = np.atleast_1d(dataset[TIME.name].values)
    if not (np.diff(times) > 0.0).all():
        raise RequestError(
            f"The samples of a motion follow one another: {TIME.name} must increase.",
            hint=f"Use dataset.sortby({TIME.name!r}).",
            where=TIME.name,
        )
    size = dataset.sizes.get(TIME.name, 1)
    if size < 2:
        raise RequestError(
            f"A figure or film needs two samples of a motion or more; got {size}.",
            hint="Choose a longer stretch of elapsed_time.",
        )


def closely_sampled(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return the same motion with samples that are close enough together to be drawn through.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, or a stretch of it in time. If its samples are close enough, it is what is returned.

    Raises
    ------
    RequestError
        If it is no motion, or cannot be computed again.
    """
    # not above: this module is also asked whether a dataset is a motion, for which nothing need be computed
    from sweep.motion.trajectory import simulate

    check_motion(dataset)
    request = request_of(dataset)
    if _is_close(dataset, request):
        return dataset
    whole = simulate(MotionRequest.read(**request.words() | {"interval": AUTOMATIC}))
    times = dataset[TIME.name].values
    inside = (whole[TIME.name] >= times[0]) & (whole[TIME.name] <= times[-1])
    found = whole.isel({TIME.name: inside.values})
    return found if found.sizes[TIME.name] > times.size else dataset


def request_of(dataset: "xr.Dataset") -> MotionRequest:
    """Return the request that a motion was made from; it is refused if its attribute cannot be read."""
    try:
        words = json.loads(str(dataset.attrs[_REQUEST]))
        # the file may be of anybody's: it carries the text of a system, and never opens another file
        if "model" in words:
            raise ValueError("a motion names no model")
        return MotionRequest.read(**words)
    except (KeyError, TypeError, ValueError):
        raise RequestError(
            f"The request that this motion was made from cannot be read: its attribute {_REQUEST} is missing or was "
            "changed.",
            hint="Take the dataset as sweep.simulate returned it.",
        ) from None


def _is_close(dataset: "xr.Dataset", request: MotionRequest) -> bool:
    if not request.kind.turning:
        return bool(request.interval == AUTOMATIC)
    times = dataset[TIME.name].values
    ended = float(dataset[request.kind.ending_time])
    # a disk that is at rest from its start is sampled for the duration
    length = ended if ended > 0.0 else request.duration
    turns = [np.abs(np.diff(dataset[name].values)).max() for name in request.kind.turning]
    return bool(_LEAST * np.diff(times).max() <= length and max(turns) <= _TURN)
