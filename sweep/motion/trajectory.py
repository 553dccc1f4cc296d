"""Computation of one motion in time, as an xarray.Dataset with path, invariants and contact forces."""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import (
    CITATION,
    COMPRESSION,
    CONTENT,
    CONVENTIONS,
    LICENSE,
    SOFTWARE,
    ascii_text,
    created,
    versions,
)
from sweep.errors import RequestError
from sweep.model.kernel import code_hash
from sweep.model.quantity import FILL, Array, Quantity
from sweep.motion.origin import request_of_preset
from sweep.motion.request import MotionRequest, TrajectorySpec, start_of
from sweep.motion.tables import MotionKind
from sweep.version import __version__

if TYPE_CHECKING:
    import xarray as xr

    from sweep.systems import System

#: Version of the file format.
FORMAT = 1

#: Packages whose versions are written to a file.
_PACKAGES = ("numba", "llvmlite", "numpy", "scipy", "xarray", "netCDF4")


def simulate(
    spec: "MotionRequest | System | str | Path | None" = None,
    *,
    command: str = "sweep.simulate",
    **words: Any,
) -> "xr.Dataset":
    """Compute one motion.

    Parameters
    ----------
    spec : TrajectorySpec, str, Path or System, optional
        A request, without `words`; or the name of a preset or the path of a TOML file, with `words` for its axes, one
        number each; or a system, or the path of its file: `words` replace its defaults. If not given, the request is
        read from `words`.
    command : str
        The user's command, for the attribute history.
    **words
        As in `TrajectorySpec.read`, for example ``roll_rate=3, tilt_rate="1deg/s", duration="10s"``.

    Returns
    -------
    xarray.Dataset
        Dimension elapsed_time [s]; tilt, rates, path, energy, momentum or losses, contact forces; for a system its
        states and measures. The last sample is at the end of the motion: its fall, its event, or the duration.
        ``sweep.save`` writes it.

    Raises
    ------
    RequestError
        If the request cannot be read or carried out, or the motion is too fast to be resolved.
    """
    if spec is None:
        spec = TrajectorySpec.read(**words)
    elif isinstance(spec, str | Path):
        spec = request_of_preset(spec, words)
    elif not isinstance(spec, MotionRequest):
        if not hasattr(spec, "definition"):
            raise RequestError(
                "simulate needs a TrajectorySpec, a system, the name of a preset or the path of a file; got a "
                f"{type(spec).__name__}.",
                hint='Write for example sweep.simulate("toy", tilt="80deg").',
            )
        spec = MotionRequest.read(**{**words, "model": spec})
    start = start_of(spec)
    times, values = import_module(spec.kind.path).follow(spec, start)
    return _dataset(spec, start, times, values, command)


def _dataset(
    spec: MotionRequest, start: Array, times: Array, values: dict[str, npt.NDArray[Any]], command: str
) -> "xr.Dataset":
    import xarray as xr

    kind = spec.kind
    # a parameter that is a word in the request is a number in the start
    known = spec.words() | dict(zip(kind.model.parameters, start.tolist(), strict=True))
    fixed = {
        name: _variable(kind, kind.inputs[name], known[name], (), coordinate=True) for name in kind.fixed
    }
    variables = {
        name: _variable(kind, kind.variables[name], value, (kind.time.name,) if value.ndim else ())
        for name, value in values.items()
    }
    time = _variable(kind, kind.time, times, (kind.time.name,), coordinate=True)
    return xr.Dataset(variables, {kind.time.name: time} | fixed, _attributes(spec, command))


def _variable(
    kind: MotionKind, quantity: Quantity, values: Any, dims: tuple[str, ...], coordinate: bool = False
) -> "xr.Variable":
    import xarray as xr

    measured = quantity.dtype.startswith("f") and not coordinate
    encoding: dict[str, Any] = {"dtype": quantity.dtype, "_FillValue": FILL if measured else None}
    attributes = quantity.attributes()
    if dims:
        encoding |= {"zlib": True, "complevel": COMPRESSION, "shuffle": True}
    if not coordinate:
        # a system may have no parameters
        encoding |= {"coordinates": " ".join(kind.fixed)} if kind.fixed else {}
        attributes |= CONTENT
    if quantity.flags is not None:
        attributes["standard_name"] = "status_flag"
    if dims and not coordinate:
        attributes["cell_methods"] = f"{kind.time.name}: point"
    return xr.Variable(dims, values, attributes, encoding)


def _attributes(spec: MotionRequest, command: str) -> dict[str, Any]:
    now = created()
    kind = spec.kind
    return {
        "Conventions": CONVENTIONS,
        "title": ascii_text(spec.title or kind.headline),
        "summary": kind.summary,
        "keywords": kind.keywords,
        "references": kind.model.words.references,
        "source": f"eulerdisk {__version__}, method {kind.method}",
        "software": SOFTWARE,
        "license": LICENSE,
        "citation": CITATION,
        "history": ascii_text(f"{now} {command}"),
        "date_created": now,
        "eulerdisk_trajectory_format": np.int32(FORMAT),
        "model": kind.model.name,
        "trajectory_request": spec.canonical(),
        "method": kind.method,
        "kernel_hash": code_hash(kind.kernels),
        "versions": versions(_PACKAGES),
    }
