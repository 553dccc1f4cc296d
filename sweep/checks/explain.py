"""Explain one cell of an atlas: what is stored, whether a new run repeats it, what is exact, and why this verdict.

The cell is computed again from the file alone: its spec gives the start, the step and the criterion.
"""

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.dataset import found_edges, require, spec_of
from sweep.atlas.quantities import edge_names
from sweep.checks.nearest_cell import nearest_cell
from sweep.engine.compute import arithmetic_hash, compute, reach_and_scale
from sweep.engine.grid import Span, starts_of
from sweep.model.description import FAILED, LOST, MISSING, UNDISTURBED
from sweep.model.quantity import ERROR_GAUGE, STABLE, STEP_COUNT, UNSTABLE, Quantity
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr


_WIDTH = 118

_NOT_REPEATED = ("repeated    nothing to repeat: the cell has not been computed",)


@dataclass(frozen=True)
class Explanation:
    """A cell in words.

    `text` is the report; `start` has every parameter, `stored` every measure of the cell, `exact` those that the
    exact reference knows [SI], none if the model lacks one; `repeated` says whether a new run of the cell agrees within
    the tolerances, `exactly` whether to the bit. A cell that was not computed has nothing to disagree with.
    """

    text: str
    spec: SweepSpec
    start: Mapping[str, float]
    stored: Mapping[str, float]
    exact: Mapping[str, float]
    repeated: bool
    exactly: bool


def explain(dataset: "xr.Dataset", given: Mapping[str, object]) -> Explanation:
    """Explain the cell nearest to given values.

    Parameters
    ----------
    dataset : xarray.Dataset
        A whole atlas.
    given : mapping of str to number or text
        A value for every axis, as in `nearest_cell`.

    Raises
    ------
    RequestError
        If it is only a part of an atlas, or the values do not name one of its cells.
    """
    spec = spec_of(dataset)
    place = nearest_cell(spec, given)
    number = int(np.ravel_multi_index(tuple(place.values()), spec.shape)) if place else 0
    span = Span(number, number + 1)
    starts, model = starts_of(spec, span), spec.model
    start = {name: float(values[0]) for name, values in starts.items()}
    measures = model.cell_variables(spec)
    require(dataset, measures)
    table = {**measures, **model.parameters}
    cell = dataset[[name for name in table if name in dataset.data_vars]].isel(place).load()
    stored = {str(name): float(values) for name, values in cell.data_vars.items()}
    exact = {}
    if model.exact is not None:
        exact = {name: float(values[0]) for name, values in model.exact.measures(spec, starts).items()}
    computed = model.endings.of(stored["ending"]).role != MISSING
    differing, beyond = _repeat(spec, span, cell, table) if computed else ([], [])
    if dataset.attrs.get("kernel_hash") != arithmetic_hash(spec):
        # other kernels make other errors with other work
        beyond = [name for name in beyond if table[name].tolerance not in (ERROR_GAUGE, STEP_COUNT)]
    lines = [
        *_where(spec, place, given),
        *_start(spec, start),
        "",
        *_stored(spec, stored),
        "",
        *(_repeated(spec, dataset, differing, beyond) if computed else _NOT_REPEATED),
        *_exact(spec, exact, stored),
        "",
        *model.expectation(spec, start, stored),
        *_lines(dataset, spec, start, place),
        "",
        *_verdict(spec, start, stored),
    ]
    return Explanation("\n".join(map(_folded, lines)), spec, start, stored, exact, not beyond, not differing)


def _folded(line: str) -> str:
    """Return a line folded under its own text, past the label."""
    return textwrap.fill(line, _WIDTH, subsequent_indent=" " * 12) if len(line) > _WIDTH else line


def _repeat(
    spec: SweepSpec, span: Span, cell: "xr.Dataset", table: Mapping[str, Quantity]
) -> tuple[list[str], list[str]]:
    """Compute one cell again: the names of the values that differ in any bit, and of those beyond their tolerance."""
    differing, beyond = [], []
    for name, column in compute(spec, starts_of(spec, span)).items():
        new, old = column[0], cell[name].values[()]
        if new.tobytes() == old.tobytes() or (np.isnan(new) and np.isnan(old)):
            continue
        differing.append(name)
        tolerance = table[name].tolerance
        if not abs(float(new) - float(old)) <= tolerance.absolute + tolerance.relative * abs(float(old)):
            beyond.append(name)
    return differing, beyond


def _where(spec: SweepSpec, place: Mapping[str, int], given: Mapping[str, object]) -> Iterator[str]:
    at = []
    for name, i in place.items():
        axis = getattr(spec, name).array()
        at.append(f"{name} {spec.model.parameters[name].spell(axis[i])} ({i + 1} of {axis.size})")
    asked = ", ".join(f"{name}={value}" for name, value in given.items())
    yield f"cell        {', '.join(at) or 'the only one'}" + (f"; nearest to {asked}" if asked else "")


def _start(spec: SweepSpec, start: Mapping[str, float]) -> Iterator[str]:
    fixed = [
        f"{name} {spec.model.parameters[name].spell(value) if np.isfinite(value) else 'none'}"
        for name, value in start.items()
        if name not in spec.axes
    ]
    yield f"start       {', '.join(fixed)}"
    yield f"disturbed   {spec.model.disturbed_motion(spec)}"


def _stored(spec: SweepSpec, stored: Mapping[str, float]) -> Iterator[str]:
    variables = spec.model.cell_variables(spec)
    yield f"ending      {variables['ending'].flag(stored['ending'])}"
    for name, quantity in variables.items():
        value: Any = stored.get(name, np.nan)
        if quantity.flags is None and np.isfinite(value):
            digits = 3 if quantity.dtype == "f4" else 10
            yield f"  {name:<17} {quantity.spell(value, digits):<22} {quantity.long_name}"


def _repeated(
    spec: SweepSpec, dataset: "xr.Dataset", differing: list[str], beyond: list[str]
) -> Iterator[str]:
    made = str(dataset.attrs.get("kernel_hash", "unknown"))
    kernels = (
        "the same kernels"
        if made == arithmetic_hash(spec)
        else f"other kernels than those of the file ({made[:12]})"
    )
    if not differing:
        yield f"repeated    from the file alone, with {kernels}: every value agrees bit for bit"
    elif not beyond:
        yield (
            f"repeated    from the file alone, with {kernels}: not to the bit ({', '.join(differing)}), but within the "
            "tolerances of eulerdisk compare"
        )
    else:
        yield f"repeated    from the file alone, with {kernels}: {', '.join(beyond)} DIFFER beyond the tolerance"


def _exact(spec: SweepSpec, exact: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    if spec.model.exact is None:
        return
    variables = spec.model.variables
    yield f"exact       without time stepping: {variables['ending'].flag(exact['ending'])}"
    for name in spec.model.exact.compared:
        quantity, value = variables[name], exact[name]
        if np.isfinite(value):
            apart = abs(value - stored[name])
            # a difference is compared with a tolerance, which is in SI
            says = (
                f"the cell is off by {apart:.1e} {quantity.units}"
                if np.isfinite(apart)
                else "the cell has none"
            )
            yield f"  {name:<17} {quantity.spell(value):<22} {says}"


def _lines(
    dataset: "xr.Dataset", spec: SweepSpec, start: Mapping[str, float], place: Mapping[str, int]
) -> Iterator[str]:
    """Yield where the boundaries of the cell's row lie."""
    for axis, edge in found_edges(dataset, spec):
        row = {name: i for name, i in place.items() if name != axis}
        measured, halfwidth, predicted, critical = (
            float(dataset[name].isel(row)) for name in edge_names(axis, edge)
        )
        units = spec.model.parameters[axis].units
        width = f" +- {halfwidth:.2g}" if np.isfinite(halfwidth) else ""
        side = f"stable {'below' if edge == 'lower' else 'above'} {axis}"
        here = f"this cell is at {start[axis]:.6g}"
        yield f"boundary    {side} {_value(measured, units)}{width} as measured in this row; {here}"
        yield f"            {_value(predicted, units)} as predicted for this start and this criterion"
        yield f"            {_value(critical, units)} in the limit of no perturbation"


def _value(value: float, units: str) -> str:
    return f"{value:.6g} {units}" if np.isfinite(value) else "none"


def _verdict(spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    """Yield the verdict of a cell and its reason."""
    yield f"verdict     {spec.model.variables['stability'].flag(stored['stability'])} by {spec.criterion}"
    yield f"because     {_reason(spec, start, stored)}"


def _reason(spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float]) -> str:
    model, ending, verdict = spec.model, spec.model.endings.of(stored["ending"]), int(stored["stability"])
    if ending.role in (MISSING, FAILED, UNDISTURBED):
        return ending.reason
    if ending.role == LOST:
        return model.lost_in_words(spec, stored)
    reach, _, limit = departure(spec, start, stored)
    coordinate = model.parameters[model.coordinate]
    far, name = coordinate.spell(reach, 6), model.coordinate.replace("_", " ")
    allowed = spec.criterion.limit_in_words(limit, coordinate)
    if verdict == UNSTABLE:
        return f"the {name} left its steady value by {far}, more than {allowed}"
    if verdict == STABLE:
        return (
            f"the {name} never leaves its steady value by more than {far}, at most {allowed}; {ending.reason}"
        )
    return (
        f"the {name} has left its steady value by {far}, at most {allowed}, but the duration of {spec.duration:g} s "
        f"{model.endings.of(stored['ending']).reason}"
    )


def departure(
    spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float]
) -> tuple[float, float, float]:
    """Return how far a cell left its undisturbed value, that value, and the limit of the criterion, all in SI."""
    starts = {name: np.array([value]) for name, value in start.items()}
    measured = {name: np.array([stored[name]]) for name in spec.model.extremes}
    reach, scale = reach_and_scale(spec, starts, measured)
    limit = float(np.nan_to_num(spec.criterion.allowed(scale))[0])
    return float(reach[0]), float(spec.model.undisturbed(spec, starts)[0]), limit
