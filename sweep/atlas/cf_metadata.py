"""The contents of an atlas file: variables with their attributes, coordinates, and global attributes."""

import json
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from sweep.atlas.row_edges import ROW_STATUS
from sweep.engine.compute import arithmetic_hash
from sweep.errors import RequestError
from sweep.model.description import Model
from sweep.model.quantity import (
    BRACKET,
    CRITICAL_EDGE,
    DECISION,
    EDGE_HALFWIDTH,
    FILL,
    MEASURED_EDGE,
    PREDICTED_EDGE,
    Input,
    Quantity,
    Tolerance,
    table,
)
from sweep.request.spec import SweepSpec
from sweep.version import HOME, __version__

#: Dimensions: the curves, and the points of all curves in sequence.
CURVES, POINTS = "curve", "curve_point"

#: The two edges of the unstable band: stable above, stable below.
EDGES = ("upper", "lower")

_STATUS_WORDS = (
    "found: the verdict changes once in this direction; stable_throughout, unstable_throughout: all cells of the row "
    "have this verdict; undecided: no change is known, and some cells are undecided; more_than_one_edge: the value is "
    "that of the outermost edge, missing where the range ends inside an unstable band; other_edge_only: the verdict "
    "changes in the other direction alone"
)

_COUNTED = Tolerance(0.0, 0.0, "the same curves have the same points")
_POINT = Tolerance(0.0, 1e-12, "both brackets hold the point of the curve", BRACKET)


def edge_names(axis: str, edge: str = "upper") -> tuple[str, str, str, str]:
    """Return the names of the variables of one edge along an axis: measured, its half-width, predicted, critical."""
    side = f"lower_{axis}" if edge == "lower" else axis
    return f"boundary_{side}", f"boundary_{side}_halfwidth", f"predicted_{side}", f"critical_{side}"


def status_name(axis: str, edge: str = "upper") -> str:
    """Return the name of the variable that states whether a row has an edge and, if not, why."""
    return f"{edge_names(axis, edge)[0]}_status"


def edge_quantities(model: Model, axis: str, edge: str = "upper") -> Mapping[str, Quantity]:
    """Return the quantities of one edge of the unstable band along a parameter.

    Parameters
    ----------
    model : Model
    axis : str
        One of its control parameters.
    edge : {"upper", "lower"}
        The edge above which, or below which, the motion is stable.

    Returns
    -------
    Mapping of str to Quantity
        The quantities of `edge_names`, all in the units of the parameter, and the flag of `status_name`.
    """
    along, of_theory = model.parameters[axis], model.line_words
    words, side = along.name.replace("_", " "), "below" if edge == "lower" else "above"
    rows = (
        (f"{words} {side} which the motion is stable, as measured", MEASURED_EDGE),
        (f"half-width of the bracket around the measured {words}", EDGE_HALFWIDTH),
        (of_theory.predicted.format(words), PREDICTED_EDGE),
        (of_theory.critical.format(words), CRITICAL_EDGE),
    )
    named = zip(edge_names(along.name, edge), rows, strict=True)
    return table(
        *(Quantity(name, along.symbol, along.units, *row) for name, row in named),
        Quantity(
            status_name(along.name, edge), "", "1",
            f"whether the row along {words} has this boundary, and if not, why",
            DECISION, _STATUS_WORDS, "i1", ROW_STATUS,
        ),
    )  # fmt: skip


def _missing_words(name: str, axis: str, edge: str) -> str:
    """Return the comment that explains why a variable of `edge_names` has no value in a row."""
    measured, _, predicted, critical = edge_names(axis, edge)
    if name == predicted:
        return "missing: theory has no value for this perturbation and criterion"
    if name == critical:
        return "missing: theory has no critical value for these parameters"
    return f"missing: this row has no such boundary among its cells, and {measured}_status says why"


def curve_quantities() -> Mapping[str, Quantity]:
    """Return the quantities that are stored for each curve."""
    return table(
        Quantity("curve_point_count", "", "1", "number of points of the curve", _COUNTED,
                 "the points of a curve follow on those of the one before", "i4"),
        Quantity("curve_closed", "", "1", "whether the curve is closed", _COUNTED,
                 "open: it ends at the border of the grid or at undecided cells", "i1", {0: "open", 1: "closed"}),
    )  # fmt: skip


def point_quantities(parameters: Mapping[str, Input], axes: Sequence[str]) -> Mapping[str, Quantity]:
    """Return the quantities that are stored for each point of a curve: position along every axis, and half-widths."""
    rows = []
    for axis in axes:
        along, words = parameters[axis], axis.replace("_", " ")
        rows += [
            Quantity(f"curve_{axis}", along.symbol, along.units, f"{words} of a point on the boundary", _POINT),
            Quantity(f"curve_{axis}_halfwidth", along.symbol, along.units,
                     f"half-width of the bracket around the {words}", EDGE_HALFWIDTH,
                     "0 where the point lies on the grid"),
        ]  # fmt: skip
    return table(*rows)


#: Version of the file layout; a reader refuses newer versions than its own.
FORMAT = 1

CONVENTIONS = "CF-1.11, ACDD-1.3"

#: zlib level for saving from memory: level 4 and higher take several times as long and save a few per cent of the size.
#: The chunks of a run are deflated by another library (`sweep.files.raw_chunks`) to about the same size.
COMPRESSION = 1

#: Packages that compute and write an atlas, whose versions it records.
PACKAGES = ("numba", "llvmlite", "numpy", "xarray", "netCDF4", "h5py", "isal")

_WAYS = {
    "rk4": "integrated with RK4 until they are final",
    "taylor": "integrated by Taylor series four times, with smaller and smaller tolerance",
    "exact": "as turning points of the exact reduction to one degree of freedom, which has no time (no duration, no "
    "fall time)",
}

#: The license of an atlas or a motion, the software, and its citation.
LICENSE = "the software is under BSD-3-Clause, and restricts nothing that is done with its data"
SOFTWARE = f"eulerdisk {__version__}, a Python package{f': {HOME}' if HOME else ''}"
CITATION = (
    f"the eulerdisk authors: eulerdisk {__version__}, stability atlases of a disk rolling without slip (software); for "
    "the equations see references"
)

#: An attribute that ACDD recommends for every variable that is not a coordinate.
CONTENT = {"coverage_content_type": "modelResult"}


@dataclass(frozen=True)
class Declaration:
    """A variable of an atlas without its values: name, dimensions, type and CF attributes."""

    name: str
    dims: tuple[str, ...]
    dtype: str
    attributes: Mapping[str, Any]
    coordinate: bool = False

    @property
    def fill(self) -> float | None:
        """Fill value for missing values; only measured floats have one, not coordinates or flags."""
        return FILL if self.dtype.startswith("f") and not self.coordinate else None


def cell_declarations(spec: SweepSpec) -> list[Declaration]:
    """Return the variables that have one value per cell."""
    computed = {name: spec.model.parameters[name] for name in spec.computed}
    quantities = {**spec.model.cell_variables(spec), **computed}
    if comment := spec.criterion.comment(spec.model):
        quantities["stability"] = replace(quantities["stability"], description=ascii_text(comment))
    return [*declare_cells(spec, quantities, "ending"), *start_declarations(spec)]


def start_declarations(spec: SweepSpec) -> list[Declaration]:
    """Return the parameters that differ between the starts of a list, as auxiliary coordinates."""
    attributes = {name: spec.model.parameters[name].attributes() for name in spec.listed}
    return [Declaration(name, spec.axes, "f8", each, True) for name, each in attributes.items()]


def declare_cells(spec: SweepSpec, quantities: Mapping[str, Quantity], status: str) -> list[Declaration]:
    """Declare quantities over the cells of a grid; `status` names the flag that qualifies them."""
    method = {"cell_methods": " ".join(f"{axis}:" for axis in spec.axes) + " point"} if spec.axes else {}
    shared = method | CONTENT | _auxiliary(spec)
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
    """Return the variables of one edge of the unstable band, in the order of their values."""
    dims = tuple(name for name in spec.axes if name != axis)
    declared = []
    measured, halfwidth, _, _ = edge_names(axis, edge)
    for name, quantity in edge_quantities(spec.model, axis, edge).items():
        attributes = quantity.attributes() | CONTENT | _auxiliary(spec)
        if quantity.flags is None:
            attributes["comment"] = _missing_words(name, axis, edge)
        if name == measured:
            attributes["ancillary_variables"] = f"{halfwidth} {status_name(axis, edge)}"
        elif quantity.flags is not None:
            attributes["standard_name"] = "status_flag"
        declared.append(Declaration(name, dims, quantity.dtype, attributes))
    return declared


def curve_declarations(spec: SweepSpec) -> tuple[list[Declaration], list[Declaration]]:
    """Return the variables that describe the curves of the boundary, and those that describe their points."""
    of_curves, of_points = list[Declaration](), list[Declaration]()
    for quantity in curve_quantities().values():
        ragged = {"sample_dimension": POINTS} if quantity.name == "curve_point_count" else {}
        attributes = quantity.attributes() | CONTENT | ragged
        of_curves.append(Declaration(quantity.name, (CURVES,), quantity.dtype, attributes))
    for quantity in point_quantities(spec.model.parameters, spec.axes).values():
        attributes = quantity.attributes() | CONTENT
        of_points.append(Declaration(quantity.name, (POINTS,), quantity.dtype, attributes))
    return of_curves, of_points


def coordinate_declarations(spec: SweepSpec) -> list[Declaration]:
    """Return the axes, and the fixed parameters as scalars."""
    quantities = spec.quantities
    return [
        Declaration(
            name,
            (name,) if name in spec.axes else (),
            quantities[name].dtype,
            quantities[name].attributes(),
            True,
        )
        for name in (*spec.axes, *spec.fixed)
    ]


def global_attributes(spec: SweepSpec, command: str, made: str | None = None) -> dict[str, Any]:
    """Return the global attributes of an atlas: what it is, how it was made, and everything needed to repeat it.

    Parameters
    ----------
    spec : SweepSpec
    command : str
        What the user ran, for the history.
    made : str, optional
        The time in the form of `created`; now if not given.
    """
    now, words = made or created(), spec.model.words
    return {
        "Conventions": CONVENTIONS,
        "title": ascii_text(spec.headline),
        "summary": words.summary.format(_WAYS[spec.method]),
        "keywords": words.keywords,
        "references": words.references,
        "source": f"eulerdisk {__version__}, method {spec.method}",
        "software": SOFTWARE,
        "license": LICENSE,
        "citation": CITATION,
        "history": ascii_text(f"{now} {command}"),
        "requested_as": json.dumps(dict(spec.requested)),
        "date_created": now,
        "eulerdisk_format": np.int32(FORMAT),
        **spec_attributes(spec),
        "kernel_hash": arithmetic_hash(spec),
        "versions": versions(PACKAGES),
    }


@lru_cache
def versions(packages: tuple[str, ...]) -> str:
    """Return the versions of packages as JSON. The result is cached, because reading takes 1 ms per package."""
    from importlib.metadata import version

    return json.dumps({name: version(name) for name in packages}, sort_keys=True)


def read_texts(attribute: object) -> dict[str, str] | None:
    """Return the texts by name that an attribute holds as JSON; None if it does not."""
    try:
        texts = json.loads(str(attribute))
    except (ValueError, RecursionError):
        return None
    return (
        texts if isinstance(texts, dict) and all(isinstance(each, str) for each in texts.values()) else None
    )


def spec_attributes(spec: SweepSpec) -> dict[str, Any]:
    """Return the global attributes that follow from the spec: settings and fixed parameters with their units.

    The parameters are also scalar coordinates, but programs that select variables drop those.
    """
    model = spec.model
    quantities = {**model.settings, **{name: model.parameters[name] for name in spec.fixed}}
    values = {name: getattr(spec, name) for name in quantities}
    return {
        "criterion": str(spec.criterion),
        "criterion_meaning": ascii_text(
            f"a cell is unstable if {spec.criterion.unstable_if(model)}; stable if it is known not to be; undecided if "
            "neither is known"
        ),
        "method": spec.method,
        **values,
        **{f"{name}_units": quantities[name].units for name in values if not isinstance(values[name], str)},
        "sweep_spec": spec.canonical(),
        "sweep_fingerprint": spec.fingerprint(),
    }


def _auxiliary(spec: SweepSpec) -> dict[str, str]:
    """Return the attribute that names the parameters of a cell that are not dimensions."""
    names = (*spec.listed, *spec.fixed)
    return {"coordinates": " ".join(names)} if names else {}


def created() -> str:
    """Return the creation time that an atlas records, ISO 8601 in UTC: now, or $SOURCE_DATE_EPOCH.

    Raises
    ------
    RequestError
        If $SOURCE_DATE_EPOCH is not a time.
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(None if epoch is None else int(epoch)))
    except (ValueError, OverflowError, OSError) as problem:
        raise RequestError(
            f"SOURCE_DATE_EPOCH must be a number of seconds since 1970; got {epoch!r}.",
            hint="Unset it.",
            where="SOURCE_DATE_EPOCH",
        ) from problem


def ascii_text(text: str) -> str:
    """Escape the non-ASCII characters of an attribute, because they would make it an NC_STRING."""
    return text.encode("ascii", "backslashreplace").decode("ascii")
