"""One motion of a preset or of a spec file: what the file says, with one number for each of its axes."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sweep.errors import RequestError
from sweep.model.disk.tables import WOBBLE
from sweep.motion.request import REQUESTS, MotionRequest, check_names, known_names, request_class
from sweep.request.spec import SweepSpec
from sweep.request.substitutes import changed, parameter_of
from sweep.request.words import find_spec_file, place, read_file


def is_preset(word: str) -> bool:
    """Return whether a word of a command line names a preset or a file: it has no value, and is no name of one."""
    return "=" not in word and word.strip() not in ("", *known_names())


def request_of_preset(spec: str | Path, words: Mapping[str, Any]) -> MotionRequest:
    """Return the request for one motion of a preset.

    Parameters
    ----------
    spec : str or Path
        Name of a preset, or a TOML file.
    words : mapping of str to anything
        Words of a request for one motion, which replace those of the file.

    Raises
    ------
    RequestError
        If there is no such file, an axis of it is left without a number, or the result is no request.

    Notes
    -----
    A file has axes, and a motion one start. Where the centre of the disk rests and no word gives the precession rate,
    it is that of the wobble: then the tilt stays, but for the losses. What the file says of the cells of an atlas, such
    as a criterion, is left out. The duration is that of the file, but no longer than that of any other motion.
    """
    path = find_spec_file(spec)
    check_names(words)
    sweep = SweepSpec.read(path)
    _check_can_move(sweep, path)
    held = read_file(path)
    merged = changed(held, words, sweep.model)
    kind = request_class(merged).kind
    open_axes = {
        name: parameter
        for name in merged
        if name not in words and (parameter := parameter_of(name, sweep.model)) in sweep.axes
    }
    found = {
        name: raw for name, raw in merged.items() if name in {*kind.names, *words} and name not in open_axes
    }
    unknown = [*open_axes.values()]
    if "precession_rate" in unknown and merged.get("roll_rate") == WOBBLE:
        found["precession_rate"] = WOBBLE
        unknown.remove("precession_rate")
    if unknown:
        _refuse_open(sweep, path, unknown)
    if "duration" not in words:
        found["duration"] = min(float(kind.inputs["duration"].default), sweep.duration)
    return MotionRequest.read(**found)


def _check_can_move(sweep: SweepSpec, path: Path) -> None:
    """Refuse a file of a model that has no single motions, or with a list of starts."""
    if sweep.model.name not in REQUESTS:
        raise RequestError(
            f"A single motion is one of the model {' or '.join(REQUESTS)}; {place(path)} is of the model "
            f"{sweep.model.name}.",
            hint="Name another preset.",
        )
    if sweep.is_list:
        raise RequestError(
            f"A motion has one start, and {place(path)} has a list of them.",
            hint="Compute its atlas, and follow one of its cells: eulerdisk simulate --from ATLAS.nc start=0.",
        )


def _refuse_open(sweep: SweepSpec, path: Path, names: Sequence[str]) -> None:
    examples = []
    for name in names:
        values = getattr(sweep, name).array()
        quantity = sweep.model.parameters[name]
        text = quantity.spell(float(values[len(values) // 2]), 3).replace(" ", "")
        examples.append(f"{name}={text if quantity.units == 'rad' else text.partition('rad')[0]}")
    raise RequestError(
        f"A motion has one start, and {place(path)} has many values of {' and of '.join(names)}.",
        hint=f"Add one of each, as in {' '.join(examples)}.",
        where=names[0],
    )
