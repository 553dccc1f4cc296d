"""Explanation of one cell of an atlas: stored values, repeated run, exact values, and the reason for the verdict.

The cell is recomputed from the file only: the spec in the file gives the start, the step and the criterion.
"""

import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas import row_edges
from sweep.atlas.cf_metadata import edge_names
from sweep.atlas.dataset import edge_status, found_edges, require, spec_of
from sweep.atlas.parts import nearest_cell
from sweep.atlas.report_units import ReportedAs, reported_as
from sweep.checks.tally import difference, other_bits
from sweep.checks.variables import Stated, allowed_of_cells
from sweep.engine.compute import arithmetic_hash, compute, reach_and_scale
from sweep.engine.grid import Span, starts_of
from sweep.model.description import Starts
from sweep.model.quantity import (
    FAILED,
    MISSING,
    OF_THE_RUN,
    UNDISTURBED,
    UNSTABLE,
    Quantity,
    spell_size,
    with_unit,
)
from sweep.request.criterion_reason import reason_of
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

_WIDTH = 118


@dataclass(frozen=True)
class Explanation:
    """The explanation of a cell.

    `text` is the report. `start` has every parameter. `stored` has every measure, NaN if the cell or the atlas lacks
    it. `exact` has the measures that the exact reference knows [SI]; it is empty if the model has no reference.
    `repeated` is true if a new run of the cell agrees within the tolerances, `exactly` if it agrees bit for bit, and
    `confirmed` if no stored value contradicts the motion followed in time. All three are true for a cell that was not
    computed.
    """

    text: str
    spec: SweepSpec
    start: Mapping[str, float]
    stored: Mapping[str, float]
    exact: Mapping[str, float]
    repeated: bool
    exactly: bool
    confirmed: bool


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
    exact = {}
    if model.exact is not None:
        exact = {name: float(values[0]) for name, values in model.exact.measures(spec, starts).items()}
    repeated = "not repeated: the cell has not been computed"
    differing, beyond = list[str](), list[str]()
    if model.endings.of(stored["ending"]).role != MISSING:
        made = str(dataset.attrs.get("kernel_hash", "unknown"))
        own = made == arithmetic_hash(spec)
        differing, beyond = _repeat(spec, starts, cell, table, own)
        kernels = "the same kernels" if own else f"different kernels from the file's ({made[:12]})"
        outcome = "every value agrees bit for bit"
        if differing:
            outcome = (
                f"not bit for bit ({', '.join(differing)}), but within the tolerances of eulerdisk compare"
            )
        repeated = f"from the file only, with {kernels}: {_beyond(beyond) if beyond else outcome}"
    in_time = _followed(spec, start, stored)
    contradicted = [
        name for name, (value, error) in in_time.items() if _apart(table[name], stored[name], value, error)
    ]
    reported = reported_as(spec, given)
    lines = [
        *_where(spec, place, given, reported),
        *_start(spec, start, reported),
        "",
        *_stored(spec, stored),
        "",
        f"repeated    {repeated}",
        *_exact(spec, exact, stored),
        *_in_time(spec, in_time, stored, contradicted),
        "",
        *model.linear_prediction(spec, start, stored),
        *_lines(dataset, spec, start, place, reported),
        "",
        f"verdict     {measures['stability'].flag(stored['stability'])} by {spec.criterion}",
        f"because     {_reason(spec, start, stored)}",
    ]
    # only long lines: `fill` would collapse the spaces of short ones. Continuations are indented past the label
    folded = [_fold(line, spec) if len(line) > _WIDTH else line for line in lines]
    return Explanation(
        "\n".join(folded), spec, start, stored, exact, not beyond, not differing, not contradicted
    )


def _fold(line: str, spec: SweepSpec) -> str:
    """Return a line broken into several, with each number next to its unit."""
    model = spec.model
    quantities = (*model.parameters.values(), *model.cell_variables(spec).values())
    known = {units for each in quantities for units in (each.units, each.shown_units)} - {"1", ""}
    units = "|".join(map(re.escape, sorted(known, key=len, reverse=True)))
    joined = re.sub(rf"(?<=\d) (?:{units})(?![\w])", lambda found: found[0].replace(" ", "\xa0"), line)
    return textwrap.fill(joined, _WIDTH, subsequent_indent=" " * 12).replace("\xa0", " ")


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


def _where(
    spec: SweepSpec, place: Mapping[str, int], given: Mapping[str, object], reported: Mapping[str, ReportedAs]
) -> Iterator[str]:
    at = []
    for name, i in place.items():
        axis, shown = getattr(spec, name).array(), reported[name]
        held = f"{name} {spec.quantities[name].spell(axis[i])}"
        is_held = shown.quantity.name == name
        place_of_it = f"{i + 1} of {axis.size}" if is_held else f"{held}, {i + 1} of {axis.size}"
        at.append(f"{held if is_held else f'{shown.quantity.name} {shown.spell(axis[i])}'} ({place_of_it})")
    asked = ", ".join(f"{name}={value}" for name, value in given.items())
    yield f"cell        {', '.join(at) or 'the only one'}" + (f"; nearest to {asked}" if asked else "")


def _start(spec: SweepSpec, start: Mapping[str, float], reported: Mapping[str, ReportedAs]) -> Iterator[str]:
    fixed = [f"body {spec.body}"] if "body" in spec.model.options else []
    for name in [each for each in start if each not in spec.axes]:
        word = getattr(spec, name) if name in spec.constants else "none"
        spelled = reported[name].spell(start[name]) if np.isfinite(start[name]) else word
        # a constant of 0 is a length that the body does not have; its moments of inertia are not 0
        if start[name] != 0.0 or name not in spec.constants:
            fixed.append(f"{reported[name].quantity.name} {spelled}")
    yield f"start       {', '.join(fixed)}"
    if spec.model.coordinate:
        yield f"reference   {spec.model.disturbed_motion(spec, start)}"


def _stored(spec: SweepSpec, stored: Mapping[str, float]) -> Iterator[str]:
    variables = spec.model.cell_variables(spec)
    yield f"ending      {variables['ending'].flag(stored['ending'])}"
    for name, quantity in variables.items():
        value = stored[name]
        if not np.isfinite(value) or name in ("ending", "stability"):
            continue
        digits = 3 if quantity.dtype == "f4" else 10
        says = quantity.spell(value, digits) if quantity.flags is None else quantity.flag(value)
        yield f"  {name:<17} {says:<22} {quantity.long_name}"


def _exact(spec: SweepSpec, exact: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    if spec.model.exact is None:
        return
    variables = spec.model.variables
    yield f"exact       without time stepping: {variables['ending'].flag(exact['ending'])}"
    for name in spec.model.exact.compared:
        if np.isfinite(exact[name]):
            yield f"  {name:<17} {_beside(variables[name], exact[name], stored[name], 22)}"


def _in_time(
    spec: SweepSpec,
    found: Mapping[str, tuple[float, float]],
    stored: Mapping[str, float],
    contradicted: Sequence[str],
) -> Iterator[str]:
    if not found:
        return
    says = _beyond(contradicted) if contradicted else "no stored value contradicts it"
    yield f"in time     the motion followed in time: {says}"
    variables = spec.model.cell_variables(spec)
    for name, (value, _) in found.items():
        yield f"  {name:<18} {_beside(variables[name], value, stored[name], 21)}"


def _beside(quantity: Quantity, value: float, stored: float, width: int) -> str:
    """Return another value of a variable, and the distance of the stored value from it."""
    apart, shown = abs(value - stored), quantity.spell(value) if np.isfinite(value) else "none"
    # in SI, like the tolerance with which it is compared
    off = f"the cell differs by {spell_size(apart, quantity.units)}"
    return f"{shown:<{width}} {off if np.isfinite(apart) else 'the cell has no value'}"


def _beyond(names: Sequence[str]) -> str:
    return f"{', '.join(names)} DIFFER beyond the tolerance"


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


def _lines(
    dataset: "xr.Dataset",
    spec: SweepSpec,
    start: Mapping[str, float],
    place: Mapping[str, int],
    reported: Mapping[str, ReportedAs],
) -> Iterator[str]:
    """Yield the lines on the boundaries of the cell's row."""
    for axis, edge in found_edges(dataset, spec):
        measured, halfwidth, predicted, critical = (
            float(_value_at(dataset, name, place)) for name in edge_names(axis, edge)
        )
        shown, name = reported[axis], reported[axis].quantity.name
        measured, predicted, critical = map(shown.value, (measured, predicted, critical))
        others = [str(name) for name in dataset[edge_names(axis, edge)[0]].dims]
        row = f" at this {' and '.join(reported[each].quantity.name for each in others)}" if others else ""
        side = f"stable {'below' if edge == 'lower' else 'above'} {name}"
        here = f"this cell is at {shown.value(start[axis]):.6g}"
        if np.isfinite(measured):
            half = f"+- {shown.width(halfwidth):.2g} as measured"
            yield f"boundary    {side} {_value(measured, shown.quantity)} {half}{row}; {here}"
        else:
            status = edge_status(dataset, axis, edge)[tuple(map(place.__getitem__, others))]
            reason = row_edges.name(int(status), edge)
            yield f"boundary    none measured{row} ({side}): {reason}; {here}"
        if not np.isfinite([predicted, critical]).any():
            yield f"            theory has no line{row}"
            continue
        how, words = "as" if np.isfinite(predicted) else "is", spec.model.line_words
        yield f"            {_value(predicted, shown.quantity)} {how} {words.told}"
        yield f"            {_value(critical, shown.quantity)} {words.limit}"


def _value(value: float, quantity: Quantity) -> str:
    return with_unit(f"{value:.6g}", quantity.units) if np.isfinite(value) else "none"


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
