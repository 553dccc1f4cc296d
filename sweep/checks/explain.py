"""One cell of an atlas explained: what is stored, whether it can be repeated, what is exact, and why the verdict.

The run is repeated from the file alone: its spec says which start, which step and which criterion.
"""

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.dataset import require, spec_of
from sweep.checks import expectation
from sweep.checks.nearest import nearest_cell
from sweep.checks.why import reach_of, why
from sweep.engine import cells
from sweep.engine.blocks import Span
from sweep.engine.compiled import kernel_hash
from sweep.engine.runner import compute, exact_measures
from sweep.request.spec import SweepSpec
from sweep.schema import EFFORT, PARAMETERS, VARIABLES, Quantity
from sweep.schema.exact import atlas_variables

if TYPE_CHECKING:
    import xarray as xr


_WIDTH = 118

#: The code of an ending, and what is said where there is nothing to repeat.
_NOT_COMPUTED = next(
    code for code, name in (VARIABLES["ending"].flags or {}).items() if name == "not_computed"
)
_NOTHING = ("repeated    nothing to repeat: the cell has not been computed",)


@dataclass(frozen=True)
class Explanation:
    """A cell in words.

    `text` is the report; `start` has every parameter, `stored` every measure of the cell, `exact` those that the
    exact reduction knows [SI]; `repeated` says whether a new run of the cell agrees within the tolerances, `exactly`
    whether to the bit. A cell that was not computed has nothing to disagree with.
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
        A value for every axis, as in `nearest.nearest_cell`.

    Raises
    ------
    RequestError
        If the atlas is not whole, or no cell is meant.
    """
    spec = spec_of(dataset)
    place = nearest_cell(spec, given)
    number = int(np.ravel_multi_index(tuple(place.values()), spec.shape)) if place else 0
    span = Span(number, number + 1)
    starts = cells.starts(spec, span)
    start = {name: float(values[0]) for name, values in starts.items()}
    measures = atlas_variables(spec.method, spec.contact)
    require(dataset, measures)
    table = {**measures, **PARAMETERS}
    cell = dataset[[name for name in table if name in dataset.data_vars]].isel(place).load()
    stored = {str(name): float(values) for name, values in cell.data_vars.items()}
    exact = {name: float(values[0]) for name, values in exact_measures(spec, starts).items()}
    computed = int(stored["ending"]) != _NOT_COMPUTED
    differing, beyond = _repeat(spec, span, cell, table) if computed else ([], [])
    if dataset.attrs.get("kernel_hash") != kernel_hash():
        beyond = [name for name in beyond if name not in EFFORT]
    lines = [
        *_where(spec, place, given),
        *_start(spec, start),
        "",
        *_stored(spec, stored),
        "",
        *(_repeated(dataset, differing, beyond) if computed else _NOTHING),
        *_exact(exact, stored),
        "",
        *expectation.in_words(dataset, spec, start, stored, place),
        "",
        *why(spec, start, stored),
    ]
    return Explanation("\n".join(map(_folded, lines)), spec, start, stored, exact, not beyond, not differing)


def _folded(line: str) -> str:
    """Return a line folded under its own text, past the label."""
    return textwrap.fill(line, _WIDTH, subsequent_indent=" " * 12) if len(line) > _WIDTH else line


def _repeat(
    spec: SweepSpec, span: Span, cell: "xr.Dataset", table: Mapping[str, Quantity]
) -> tuple[list[str], list[str]]:
    """Run one cell again: the names of the values that differ in any bit, and of those beyond their tolerance."""
    differing, beyond = [], []
    for name, column in compute(spec, span).items():
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
        at.append(f"{name} {PARAMETERS[name].spell(axis[i])} ({i + 1} of {axis.size})")
    asked = ", ".join(f"{name}={value}" for name, value in given.items())
    yield f"cell        {', '.join(at) or 'the only one'}" + (f"; nearest to {asked}" if asked else "")


def _start(spec: SweepSpec, start: Mapping[str, float]) -> Iterator[str]:
    fixed = [
        f"{name} {PARAMETERS[name].spell(value) if np.isfinite(value) else 'none'}"
        for name, value in start.items()
        if name not in spec.axes
    ]
    yield f"start       {', '.join(fixed)}"
    yield f"disturbed   {'steady circling at this tilt' if spec.circling else 'the upright disk'}"


def _stored(spec: SweepSpec, stored: Mapping[str, float]) -> Iterator[str]:
    codes = VARIABLES["ending"].flags or {}
    yield f"ending      {codes[int(stored['ending'])].replace('_', ' ')}"
    for name, quantity in atlas_variables(spec.method, spec.contact).items():
        value: Any = stored.get(name, np.nan)
        if quantity.flags is None and np.isfinite(value):
            digits = 3 if quantity.dtype == "f4" else 10
            yield f"  {name:<17} {quantity.spell(value, digits):<22} {quantity.long_name}"


def _repeated(dataset: "xr.Dataset", differing: list[str], beyond: list[str]) -> Iterator[str]:
    made = str(dataset.attrs.get("kernel_hash", "unknown"))
    kernels = (
        "the same kernels" if made == kernel_hash() else f"other kernels than those of the file ({made[:12]})"
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


def _exact(exact: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    ending = (VARIABLES["ending"].flags or {})[int(exact["ending"])]
    yield f"exact       without time stepping: {ending.replace('_', ' ')}"
    for name in ("tilt_min", "tilt_max", "nutation_period"):
        quantity, value = VARIABLES[name], exact[name]
        if np.isfinite(value):
            apart = abs(value - stored[name])
            # a difference of tilts is nothing to be read in degrees
            says = (
                f"the cell is off by {apart:.1e} {quantity.units}"
                if np.isfinite(apart)
                else "the cell has none"
            )
            yield f"  {name:<17} {quantity.spell(value):<22} {says}"


def departure(explanation: Explanation) -> tuple[float, float]:
    """Return the steady tilt of an explained cell and the limit of its departure from it, both [rad]."""
    return reach_of(explanation.spec, explanation.start, explanation.stored)[1:]
