"""The file of one motion in words, for `eulerdisk info`."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.dataset import require
from sweep.errors import counted, plain_text, printable
from sweep.motion.sampling import end_of, kind_of, losses_of
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr

#: Characters of an attribute that are shown.
_MOST_SHOWN = 300


def describe_motion(path: Path) -> str:
    """Return what is in the file of a motion: title, start, disk, how long it is, and the largest tilt.

    Raises
    ------
    RequestError
        If a variable is missing.
    """
    import xarray as xr

    with xr.open_dataset(path.absolute(), engine="netcdf4", decode_times=False) as file:
        kind = kind_of(file)
        start_names = tuple(name for name in kind.inputs if name in kind.variables)
        require(file, (*start_names, *kind.fixed, TIME.name, kind.ending_time, "ending"), str(path))
        title, made, source = (_text(file, name) for name in ("title", "history", "source"))
        start = [kind.variables[name].spell(float(file[name].values[0]), 6) for name in start_names]
        values = {name: float(file[name].values) for name in kind.fixed}
        # a loss that is not there, and a friction coefficient without a limit, say nothing
        values = {name: value for name, value in values.items() if value != 0.0 and np.isfinite(value)}
        disk = [kind.inputs[name].spell(value, 6) for name, value in values.items()]
        times, ending, lost = file[TIME.name].values, end_of(file), losses_of(file)
        peak = kind.variables["tilt"].spell(float(np.abs(file["tilt"].values).max()), 3)
    ending = f", {ending}" if ending else ""
    losses = [f"losses      {lost}"] if lost else []
    lines = [
        "This file holds one motion in time, as eulerdisk simulate makes it; it is no stability atlas.",
        "",
        title,
        f"start       {_pairs(start_names, start)}",
        f"disk        {_pairs(tuple(values), disk)}",
        f"time        {counted(times.size, 'sample')} from {times[0]:g} to {times[-1]:g} s{ending}",
        f"peak tilt   {peak}",
        *losses,
        f"made        {made}",
        f"by          {source}",
    ]
    return "\n".join(lines)


def _pairs(names: tuple[str, ...], values: list[str]) -> str:
    return ", ".join(f"{name} {value}" for name, value in zip(names, values, strict=True))


def _text(file: "xr.Dataset", name: str) -> str:
    return printable(plain_text(file.attrs.get(name, "unknown")))[:_MOST_SHOWN]
