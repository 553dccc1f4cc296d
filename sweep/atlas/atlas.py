"""What an atlas consists of: its variables and attributes, and the xarray.Dataset made of computed blocks."""

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import edges
from sweep.atlas.clock import created
from sweep.atlas.curves import Curves, curves
from sweep.engine.blocks import BLOCK_CELLS, chunk_shape
from sweep.engine.compiled import kernel_hash
from sweep.engine.runner import Block, run_blocks
from sweep.errors import RequestError
from sweep.request.spec import SweepSpec
from sweep.schema import FILL, PARAMETERS, SETTINGS, Quantity, boundary_quantities
from sweep.schema.curves import CURVES, POINTS, curve_quantities, point_quantities
from sweep.schema.exact import atlas_variables
from sweep.version import __version__

if TYPE_CHECKING:
    import xarray as xr

#: Version of the layout of the file; a reader refuses what is newer than it knows.
FORMAT = 1

CONVENTIONS = "CF-1.11, ACDD-1.3"

#: zlib level: 4 and more cost several times the time for a few per cent of the size.
COMPRESSION = 1

_SUMMARY = (
    "Stability atlas of a thin rigid disk that rolls without slipping on a horizontal plane: for every start of a "
    "grid the extreme tilts of the motion, {}, and the verdict of a criterion."
)
_WAYS = {
    "rk4": "integrated with RK4 until they are final",
    "exact": "as turning points of the exact reduction to one degree of freedom",
}

_REFERENCES = (
    "equations: McDonald and McDonald, arXiv:physics/0008227; integrals: Chaplygin 1897, Appell 1900, Korteweg 1899; "
    "stability: Borisov, Mamaev and Kilin, Regul. Chaotic Dyn. 8 (2003) 201"
)

#: What ACDD wants to know of every variable that is not a coordinate.
CONTENT = {"coverage_content_type": "modelResult"}


@dataclass(frozen=True)
class Declaration:
    """One variable of an atlas before it has values: name, dimensions, type and CF attributes."""

    name: str
    dims: tuple[str, ...]
    dtype: str
    attributes: Mapping[str, Any]
    coordinate: bool = False

    @property
    def fill(self) -> float | None:
        """Value that stands for "missing" in a file: measured floats only, never coordinates or flags."""
        return FILL if self.dtype.startswith("f") and not self.coordinate else None


def cell_declarations(spec: SweepSpec) -> list[Declaration]:
    """Return the variables that have one value per cell."""
    computed = {name: PARAMETERS[name] for name in _computed(spec)}
    return declare_cells(spec, {**atlas_variables(spec.method, spec.contact), **computed}, "ending")


def declare_cells(spec: SweepSpec, quantities: Mapping[str, Quantity], status: str) -> list[Declaration]:
    """Return quantities declared over the cells of a grid; `status` names the flag that says what they are worth."""
    method = {"cell_methods": " ".join(f"{axis}:" for axis in spec.axes) + " point"} if spec.axes else {}
    shared = method | CONTENT | _scalars(spec)
    declared = []
    for name, quantity in quantities.items():
        attributes = {**quantity.attributes(), **shared}
        if quantity.flags is None:
            attributes["ancillary_variables"] = status
        elif name == status:
            attributes["standard_name"] = "status_flag"
        declared.append(Declaration(name, spec.axes, quantity.dtype, attributes))
    return declared


def edge_declarations(spec: SweepSpec, axis: str, edge: str) -> list[Declaration]:
    """Return the variables of one edge of the unstable band, in the order in which `boundaries` has their values."""
    dims = tuple(name for name in spec.axes if name != axis)
    declared = []
    quantities = boundary_quantities(axis, edge)
    for name, quantity in quantities.items():
        attributes = quantity.attributes() | CONTENT | _scalars(spec)
        if f"{name}_halfwidth" in quantities:
            attributes["ancillary_variables"] = f"{name}_halfwidth"
        declared.append(Declaration(name, dims, quantity.dtype, attributes))
    return declared


def coordinates(spec: SweepSpec) -> list[tuple[Declaration, npt.NDArray[np.float64]]]:
    """Return the axes with their values, and the fixed parameters as scalars."""
    found = []
    for name in (*spec.axes, *(name for name in PARAMETERS if name not in spec.axes)):
        if name in _computed(spec):
            continue
        value = getattr(spec, name)
        values = value.array() if name in spec.axes else np.array(value)
        dims = (name,) if name in spec.axes else ()
        found.append((Declaration(name, dims, "f8", PARAMETERS[name].attributes(), True), values))
    return found


def global_attributes(spec: SweepSpec, command: str, made: str | None = None) -> dict[str, Any]:
    """Return the global attributes: what it is, how it was made, and all that is needed to make it again.

    Parameters
    ----------
    spec : SweepSpec
    command : str
        What the user ran, for the history.
    made : str, optional
        When, as `created` says it; now if not given.
    """
    from importlib.metadata import version

    now = made or created()
    return {
        "Conventions": CONVENTIONS,
        "title": _ascii(spec.title or "Stability atlas of a rolling disk"),
        "summary": _SUMMARY.format(_WAYS[spec.method]),
        "keywords": "rolling disk, Euler's disk, nonholonomic dynamics, stability, parameter sweep",
        "references": _REFERENCES,
        "source": f"eulerdisk {__version__}, method {spec.method}",
        "history": _ascii(f"{now} {command}"),
        "date_created": now,
        "eulerdisk_format": np.int32(FORMAT),
        "criterion": str(spec.criterion),
        **{name: getattr(spec, name) for name in SETTINGS},
        "method": spec.method,
        "sweep_spec": spec.canonical(),
        "sweep_fingerprint": spec.fingerprint(),
        "kernel_hash": kernel_hash(),
        "versions": json.dumps(
            {name: version(name) for name in ("numba", "llvmlite", "numpy", "xarray", "netCDF4")},
            sort_keys=True,
        ),
    }


def assemble(spec: SweepSpec, blocks: Iterable[Block], command: str) -> "xr.Dataset":
    """Return the atlas of a spec from its computed blocks.

    Parameters
    ----------
    spec : SweepSpec
    blocks : iterable of Block
        All cells, in any order.
    command : str
        What the user ran, for the history.

    Returns
    -------
    xarray.Dataset
        Dimensions: the spec's axes in order. See `schema.VARIABLES` for the variables; their encoding is that of the
        file profile, so that ``to_netcdf(path, format="NETCDF4_CLASSIC", engine="netcdf4")`` writes an atlas.
    """
    import xarray as xr

    declared = cell_declarations(spec)
    flat = {each.name: np.zeros(spec.size, each.dtype) for each in declared}
    for block in blocks:
        for name, column in block.columns.items():
            flat[name][block.span.start : block.span.stop] = column
    stability = flat["stability"].reshape(spec.shape)
    return xr.Dataset(
        {each.name: as_variable(each, flat[each.name].reshape(spec.shape), spec) for each in declared}
        | edge_variables(spec, stability),
        {each.name: as_variable(each, values, spec) for each, values in coordinates(spec)},
        global_attributes(spec, command),
    )


def spec_of(dataset: "xr.Dataset") -> SweepSpec:
    """Return the spec that an atlas was made from.

    Raises
    ------
    RequestError
        If the atlas is only a part of what its spec asks for.
    """
    spec = SweepSpec.from_canonical(dataset.attrs["sweep_spec"])
    if dataset["ending"].dims != spec.axes or dataset["ending"].shape != spec.shape:
        raise RequestError(
            "not the whole atlas",
            "the dimensions of an atlas are the axes of its spec",
            f"{dict(dataset['ending'].sizes)} of {dict(zip(spec.axes, spec.shape, strict=True))}",
            "take the whole atlas, and select from the result",
        )
    return spec


def boundaries(
    spec: SweepSpec, stability: npt.NDArray[np.integer]
) -> list[tuple[Declaration, npt.NDArray[Any]]]:
    """Return the variables of the boundary that a grid of verdicts, of the spec's shape, has.

    One value per row of each rate for the edges; where it is refined and the grid has a plane, the curves too.
    """
    found: list[tuple[Declaration, npt.NDArray[Any]]] = []
    for (axis, edge), line in edges(spec, stability).items():
        values = (line.measured, line.halfwidth, line.predicted, line.critical)
        found += zip(edge_declarations(spec, axis, edge), values, strict=True)
    if spec.boundary_width is not None and len(spec.axes) > 1:
        found += _curve_variables(spec, curves(spec, stability, spec.boundary_width))
    return found


def _curve_variables(spec: SweepSpec, lines: Curves) -> Iterator[tuple[Declaration, npt.NDArray[Any]]]:
    # netCDF's classic model has no dimension without length, but for the one unlimited
    if not lines.counts.size:
        return
    of_curves = (lines.counts.astype("i4"), lines.closed.astype("i1"))
    for quantity, counted in zip(curve_quantities().values(), of_curves, strict=True):
        ragged = {"sample_dimension": POINTS} if quantity.name == "curve_point_count" else {}
        yield Declaration(quantity.name, (CURVES,), quantity.dtype, quantity.attributes() | ragged), counted
    measured = (part[axis] for axis in spec.axes for part in (lines.points, lines.halfwidths))
    for quantity, values in zip(point_quantities(spec.axes).values(), measured, strict=True):
        yield Declaration(quantity.name, (POINTS,), quantity.dtype, quantity.attributes()), values


def edge_variables(spec: SweepSpec, stability: npt.NDArray[np.integer]) -> dict[str, "xr.Variable"]:
    """Return the variables of `boundaries` by their names."""
    return {each.name: as_variable(each, values, spec) for each, values in boundaries(spec, stability)}


def run(spec: SweepSpec, *, threads: int | None = None, block_cells: int = BLOCK_CELLS) -> "xr.Dataset":
    """Compute the atlas of a spec in memory.

    Parameters
    ----------
    spec : SweepSpec
    threads : int, optional
        Threads to use; all that this process may use if not given.
    block_cells : int
        Cells computed at a time. Neither this nor `threads` changes a bit of the result.

    Returns
    -------
    xarray.Dataset
        As in `assemble`.

    Raises
    ------
    RequestError
        If `threads` or `block_cells` is out of range.
    """
    return assemble(spec, run_blocks(spec, threads=threads, block_cells=block_cells), "sweep.run")


def _computed(spec: SweepSpec) -> tuple[str, ...]:
    return (spec.computed_rate,) if spec.computed_rate else ()


def _scalars(spec: SweepSpec) -> dict[str, str]:
    fixed = [name for name in PARAMETERS if name not in spec.axes and name not in _computed(spec)]
    return {"coordinates": " ".join(fixed)} if fixed else {}


def as_variable(declared: Declaration, values: npt.NDArray[Any], spec: SweepSpec) -> "xr.Variable":
    """Return a declared variable with its values and the encoding of the file profile."""
    import xarray as xr

    encoding: dict[str, Any] = {"dtype": declared.dtype, "_FillValue": declared.fill}
    if declared.dims == spec.axes and spec.axes:
        encoding |= {
            "zlib": True,
            "complevel": COMPRESSION,
            "shuffle": True,
            "chunksizes": chunk_shape(spec.shape),
        }
    attributes = dict(declared.attributes)
    if "coordinates" in attributes:
        # xarray keeps this one attribute among the encoding
        encoding["coordinates"] = attributes.pop("coordinates")
    return xr.Variable(declared.dims, values, attributes, encoding)


def _ascii(text: str) -> str:
    return text.encode("ascii", "backslashreplace").decode("ascii")
