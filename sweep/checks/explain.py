"""Explanation of one cell of an atlas: stored values, repeated run, exact values, and the reason for the verdict.

The cell is recomputed from the file only: the spec in the file gives the start, the step and the criterion.
"""

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.cf_metadata import edge_names
from sweep.atlas.dataset import edge_status, found_edges, require, spec_of
from sweep.atlas.parts import nearest_cell
from sweep.atlas.report_units import reported_as
from sweep.checks.explanation import Explanation, Repetition, RowBoundary
from sweep.checks.tally import difference, other_bits
from sweep.checks.variables import Stated, allowed_of_cells
from sweep.engine.compute import arithmetic_hash, compute, reach_and_scale
from sweep.engine.grid import Span, starts_of
from sweep.model.description import Starts
from sweep.model.quantity import FAILED, MISSING, OF_THE_RUN, UNDISTURBED, UNSTABLE, Quantity
from sweep.request.criterion_reason import reason_of
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr


def explain(dataset: "xr.Dataset", given: Mapping[str, object]) -> Explanation:
    """Explain the cell nearest to the given values.

    Parameters
    ----------
    dataset : xarray.Dataset
        A whole atlas.
    given : mapping of str to number or text
        A value for every axis, as in `nearest_cell`.

    Raises
    ------
    RequestError
        If the dataset is only part of an atlas, or the values do not identify a cell.
    """
    spec = spec_of(dataset)
    place = nearest_cell(spec, given)
    number = int(np.ravel_multi_index(tuple(place.values()), spec.shape)) if place else 0
    span = Span(number, number + 1)
    starts, model = starts_of(spec, span), spec.model
    start = {name: float(values[0]) for name, values in starts.items()}
    measures = model.cell_variables(spec)
    require(dataset, ("stability", *spec.criterion.needs(model)))
    table = {**measures, **model.parameters}
    # another program may have dropped some variables
    cell = {name: _value_at(dataset, name, place) for name in (*measures, *spec.computed) if name in dataset}
    stored = dict.fromkeys(measures, np.nan)
    stored |= {name: float(value) for name, value in cell.items()}
    exact, repetition = {}, None
    if model.exact is not None:
        exact = {name: float(values[0]) for name, values in model.exact.measures(spec, starts).items()}
    if model.endings.of(stored["ending"]).role != MISSING:
        kernel_hash = str(dataset.attrs.get("kernel_hash", "unknown"))
        own = kernel_hash == arithmetic_hash(spec)
        repetition = Repetition(kernel_hash, own, *_repeat(spec, starts, cell, table, own))
    in_time = _followed(spec, start, stored)
    return Explanation(
        spec=spec,
        place=place,
        asked=given,
        reported=reported_as(spec, given),
        start=start,
        stored=stored,
        exact=exact,
        in_time=in_time,
        contradicted=[
            name
            for name, (value, error) in in_time.items()
            if _apart(table[name], stored[name], value, error)
        ],
        repetition=repetition,
        boundaries=list(_boundaries(dataset, spec, place)),
        linear=list(model.linear_prediction(spec, start, stored)),
        reason=_reason(spec, start, stored),
    )


def _value_at(dataset: "xr.Dataset", name: str, place: Mapping[str, int]) -> Any:
    """Return the value of a variable in one cell, or in its row, as a numpy scalar."""
    variable = dataset.variables[name]
    return np.asarray(variable[tuple(place[str(dim)] for dim in variable.dims)])[()]


def _repeat(
    spec: SweepSpec, starts: Starts, cell: Mapping[str, Any], table: Mapping[str, Quantity], own: bool
) -> tuple[list[str], list[str]]:
    """Recompute one cell; return the names of values that differ in any bit, and of those beyond their tolerance.

    `cell` holds the stored values in their stored types; `own` is true if the same kernels made them.
    """
    differing, beyond = [], []
    again = compute(spec, starts)
    stored = {name: np.atleast_1d(value) for name, value in cell.items()}
    both = Stated(spec, again), Stated(spec, stored)
    for name in [each for each in again if each in stored]:
        if not other_bits(again[name], stored[name])[0]:
            continue
        differing.append(name)
        # different kernels have different errors and different step counts
        judged = own or table[name].tolerance not in OF_THE_RUN
        most = allowed_of_cells(table[name], *both, starts)
        if judged and not (difference(again[name], stored[name]) <= most)[0]:
            beyond.append(name)
    return differing, beyond


def _followed(
    spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Return the values of variables found by following the cell's motion in time, and their errors.

    See `Model.in_time`.
    """
    module, _, function = spec.model.in_time.partition(":")
    if not module:
        return {}
    found: dict[str, tuple[float, float]] = getattr(import_module(module), function)(spec, start, stored)
    return found


def _apart(quantity: Quantity, stored: float, value: float, error: float) -> bool:
    """Return whether a stored value contradicts another value, which has the given error."""
    if np.isnan(stored):
        return False
    tolerance = quantity.tolerance
    return not abs(stored - value) <= tolerance.absolute + tolerance.relative * abs(stored) + error


def _boundaries(dataset: "xr.Dataset", spec: SweepSpec, place: Mapping[str, int]) -> Iterator[RowBoundary]:
    """Yield the boundaries of the cell's row."""
    for axis, edge in found_edges(dataset, spec):
        names = edge_names(axis, edge)
        others = [str(name) for name in dataset[names[0]].dims]
        status = edge_status(dataset, axis, edge)[tuple(map(place.__getitem__, others))]
        yield RowBoundary(
            axis, edge, others, int(status), *(float(_value_at(dataset, name, place)) for name in names)
        )


def _reason(spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float]) -> str:
    ending = spec.model.endings.of(stored["ending"])
    if ending.role in (MISSING, FAILED) or (ending.role == UNDISTURBED and stored["stability"] != UNSTABLE):
        return ending.reason
    starts, measured = ({name: np.array([each[name]]) for name in each} for each in (start, stored))
    reach, scale = reach_and_scale(spec, starts, measured)
    return reason_of(spec.criterion, spec, {**start, **stored}, float(reach[0]), float(scale[0]))


def departure(spec: SweepSpec, start: Mapping[str, float]) -> tuple[float, float]:
    """Return the undisturbed value of a cell, and the departure that the criterion allows, both in SI."""
    starts = {name: np.array([value]) for name, value in start.items()}
    allowed = spec.criterion.allowed(spec.model.perturbation(spec, starts))
    return float(spec.model.undisturbed(spec, starts)[0]), float(allowed[0])
