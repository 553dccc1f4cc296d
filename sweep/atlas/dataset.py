"""An atlas as an xarray.Dataset: the declared variables with the values of computed blocks."""

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import Seen, unseen
from sweep.atlas.boundary_search import boundary_groups
from sweep.atlas.cf_metadata import (
    COMPRESSION,
    EDGES,
    Declaration,
    cell_declarations,
    coordinate_declarations,
    edge_names,
    global_attributes,
    read_texts,
    status_name,
)
from sweep.atlas.row_edges import ROW_STATUS, ROW_UNDECIDED
from sweep.engine.grid import chunk_shape
from sweep.errors import RequestError
from sweep.model.description import Columns
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr


def empty_columns(spec: SweepSpec) -> dict[str, npt.NDArray[Any]]:
    """Return a column of shape (size,) for each variable of the cells, to fill with the values of computed blocks."""
    return {each.name: np.zeros(spec.size, each.dtype) for each in cell_declarations(spec)}


def assemble(spec: SweepSpec, columns: Columns, command: str, seen: Seen = unseen) -> "xr.Dataset":
    """Build the atlas of a spec from the columns of all its cells.

    Parameters
    ----------
    spec : SweepSpec
    columns : mapping of str to array, shape (size,)
        The columns of `empty_columns`, filled.
    command : str
        What the user ran, for the history.
    seen : callable, optional
        Called now and then with the completed share of the search for the boundary, from 0 to 1.

    Returns
    -------
    xarray.Dataset
        The variables of the model, over the axes of the spec in order. Their encoding follows the file profile, so
        that ``to_netcdf(path, format="NETCDF4_CLASSIC", engine="netcdf4")`` writes an atlas.
    """
    import xarray as xr

    stability = columns["stability"].reshape(spec.shape)
    held = {
        each.name: as_variable(each, columns[each.name].reshape(spec.shape), spec)
        for each in cell_declarations(spec)
    }
    listed = {name: held.pop(name) for name in spec.listed}
    return xr.Dataset(
        held | edge_variables(spec, stability, seen),
        listed | {each.name: as_variable(each, values, spec) for each, values in coordinates(spec)},
        global_attributes(spec, command),
    )


def spec_named(dataset: "xr.Dataset") -> SweepSpec:
    """Return the spec that an atlas states. The atlas may be a selection of its cells.

    Raises
    ------
    RequestError
        If the spec cannot be read.
    """
    try:
        requested = read_texts(dataset.attrs.get("requested_as"))
        return SweepSpec.from_canonical(dataset.attrs["sweep_spec"], requested)
    except RequestError as error:
        raise error.at(place_of(dataset)) from None


def spec_of(dataset: "xr.Dataset") -> SweepSpec:
    """Return the spec from which an atlas was made.

    Raises
    ------
    RequestError
        If the spec cannot be read, or the atlas has only a part of its cells.
    """
    spec = spec_named(dataset)
    ending = dataset["ending"]
    sizes, whole = (
        dict(zip(*each, strict=True)) for each in ((ending.dims, ending.shape), (spec.axes, spec.shape))
    )
    if sizes != whole:
        raise RequestError(
            f"This is not the whole atlas: its dimensions must be the axes of its spec, {whole}; got {sizes}.",
            hint="Use the whole atlas, or turn the selection into an atlas: dataset.eulerdisk.atlas in Python.",
            where=place_of(dataset),
        )
    if tuple(sizes) != spec.axes:
        raise RequestError(
            f"The dimensions must be in the order of the axes of the spec, {', '.join(spec.axes)}; got "
            f"{', '.join(map(str, sizes))}.",
            hint=f"Use dataset.transpose({', '.join(map(repr, spec.axes))}, ...) in Python.",
            where=place_of(dataset),
        )
    return _with_starts(spec, dataset) if spec.starts else spec


def _with_starts(spec: SweepSpec, dataset: "xr.Dataset") -> SweepSpec:
    """Return a spec with the values of its table of starts, which the atlas stores as coordinates."""
    require(dataset, spec.listed)
    columns = {name: np.asarray(dataset[name].values, np.float64) for name in spec.listed}
    try:
        return SweepSpec.from_canonical(spec.canonical(), spec.requested, spec.starts.filled(columns))
    except RequestError as error:
        raise error.at(place_of(dataset)) from None


def require(dataset: "xr.Dataset", names: Iterable[str], place: str | None = None) -> None:
    """Refuse an atlas that lacks some variables.

    Raises
    ------
    RequestError
        With the names of the missing variables and the file, `place`.
    """
    missing = [name for name in names if name not in dataset]
    if missing:
        raise RequestError(
            f"The atlas lacks {', '.join(missing)}, needed here.",
            hint="Give an unchanged atlas of eulerdisk run.",
            where=place or place_of(dataset),
        )


def place_of(dataset: "xr.Dataset") -> str:
    """Return the name of an atlas in messages: its file, if it has one."""
    return str(dataset.encoding.get("source", "atlas"))


def found_edges(dataset: "xr.Dataset", spec: SweepSpec) -> Iterator[tuple[str, str]]:
    """Yield the edges of an atlas: an axis, and the edge of the unstable band along it."""
    yield from ((axis, edge) for axis in spec.axes for edge in EDGES if edge_names(axis, edge)[0] in dataset)


def in_order(variable: "xr.DataArray | xr.Variable", dims: Sequence[Any]) -> npt.NDArray[Any]:
    """Return the values of a variable with its dimensions in the given order, without other dimensions, of length 1."""
    ordered = [name for name in dims if name in variable.dims]
    rest = [name for name in variable.dims if name not in ordered]
    values = variable.values.transpose([variable.dims.index(name) for name in (*ordered, *rest)])
    return values.reshape(values.shape[: len(ordered)])


def edge_status(dataset: "xr.Dataset", axis: str, edge: str) -> npt.NDArray[np.int8]:
    """Return the status of the rows of an edge (`sweep.atlas.row_edges.RowEdges.status`).

    It has the dimensions of the measured boundary.

    Raises
    ------
    RequestError
        If the variable is missing, or contains an unknown code.
    """
    name = status_name(axis, edge)
    require(dataset, [name])
    # if xarray has masked rows, flags are floats
    stored: npt.NDArray[Any] = np.nan_to_num(dataset[name].values, nan=ROW_UNDECIDED)
    if strange := sorted({*np.unique(stored).tolist()} - {*ROW_STATUS}):
        raise RequestError(
            f"The file is damaged: {name} contains {strange[0]}, which is none of {', '.join(map(str, ROW_STATUS))}.",
            hint="Compute it again with eulerdisk run.",
            where=place_of(dataset),
        )
    return stored.astype(np.int8)


def coordinates(spec: SweepSpec) -> list[tuple[Declaration, npt.NDArray[Any]]]:
    """Return the axes with their values, and the fixed parameters as scalars, in their declared types."""
    pairs = ((declared, getattr(spec, declared.name)) for declared in coordinate_declarations(spec))
    return [
        (declared, np.asarray(value.array() if isinstance(value, Range | Values) else value, declared.dtype))
        for declared, value in pairs
    ]


def boundaries(
    spec: SweepSpec, stability: npt.NDArray[np.integer], seen: Seen = unseen
) -> list[tuple[Declaration, npt.NDArray[Any]]]:
    """Return the variables of the boundary of a grid of verdicts, which has the shape of the spec.

    The edges have one value per row along each rate. If the boundary is refined and the grid has a plane, the curves
    are included.
    """
    return [pair for group in boundary_groups(spec, stability, seen) for pair in group]


def edge_variables(
    spec: SweepSpec, stability: npt.NDArray[np.integer], seen: Seen = unseen
) -> dict[str, "xr.Variable"]:
    """Return the variables of `boundaries` by their names."""
    return {each.name: as_variable(each, values, spec) for each, values in boundaries(spec, stability, seen)}


def as_variable(declared: Declaration, values: npt.NDArray[Any], spec: SweepSpec) -> "xr.Variable":
    """Return a declared variable with its values and the encoding of the file profile."""
    import xarray as xr

    attributes = dict(declared.attributes)
    # xarray keeps this attribute in the encoding
    attributes.pop("coordinates", None)
    return xr.Variable(declared.dims, values, attributes, encoding_of(declared, spec))


def encoding_of(declared: Declaration, spec: SweepSpec) -> dict[str, Any]:
    """Return the encoding with which xarray stores a declared variable: the file profile."""
    encoding: dict[str, Any] = {"dtype": declared.dtype, "_FillValue": declared.fill}
    if declared.dims == spec.axes and spec.axes:
        encoding |= {
            "zlib": True,
            "complevel": COMPRESSION,
            "shuffle": True,
            "chunksizes": chunk_shape(spec.shape),
            # with this, xarray drops the chunk sizes when it saves a selection that is smaller than a chunk
            "original_shape": spec.shape,
        }
    if "coordinates" in declared.attributes:
        encoding["coordinates"] = declared.attributes["coordinates"]
    return encoding
