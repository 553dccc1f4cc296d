"""The file of one motion in words, for `eulerdisk info`."""

from pathlib import Path

import numpy as np

from sweep.atlas.contents import Atlas
from sweep.atlas.dataset import require
from sweep.errors import plain_text, printable
from sweep.files.atlas_file import AtlasFile
from sweep.motion.disk_tables import MOTION_INPUTS, TRAJECTORY
from sweep.motion.kind import TIME

#: What a motion starts from: the parameters of which each sample has a value.
_START = tuple(name for name in MOTION_INPUTS if name in TRAJECTORY)

#: Of the disk, in the order in which they are told.
_DISK = ("alpha", "radius", "gravity", "mass", "friction")

#: Characters of an attribute that are shown.
_MOST_SHOWN = 300


def describe_motion(path: Path) -> str:
    """Return what is in the file of a motion: title, start, disk, how long it is, and the largest tilt.

    Raises
    ------
    RequestError
        If a variable is missing.
    """
    with AtlasFile(path) as file:
        require(file, (*_START, *_DISK, TIME.name, "fall_time"), str(path))
        title, made, source = (_text(file, name) for name in ("title", "history", "source"))
        start = [TRAJECTORY[name].spell(float(file[name].values[0]), 6) for name in _START]
        disk = [MOTION_INPUTS[name].spell(float(file[name].values), 6) for name in _DISK]
        times, fell = file[TIME.name].values, float(file["fall_time"].values)
        peak = TRAJECTORY["tilt"].spell(float(np.abs(file["tilt"].values).max()), 3)
    ending = f", fell at {fell:.6g} s" if np.isfinite(fell) else ""
    lines = [
        "This file holds one motion in time, as eulerdisk simulate makes it; it is no stability atlas.",
        "",
        title,
        f"start       {_pairs(_START, start)}",
        f"disk        {_pairs(_DISK, disk)}",
        f"time        {times.size} samples from {times[0]:g} to {times[-1]:g} s{ending}",
        f"peak tilt   {peak}",
        f"made        {made}",
        f"by          {source}",
    ]
    return "\n".join(lines)


def _pairs(names: tuple[str, ...], values: list[str]) -> str:
    return ", ".join(f"{name} {value}" for name, value in zip(names, values, strict=True))


def _text(file: Atlas, name: str) -> str:
    return printable(plain_text(file.attrs.get(name, "unknown")))[:_MOST_SHOWN]
