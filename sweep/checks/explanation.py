"""The explanation of a cell of an atlas: a record, and its words."""

import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sweep.atlas import row_edges
from sweep.atlas.report_units import ReportedAs
from sweep.model.quantity import ERROR_GAUGE, UNKNOWN_ERROR, Quantity, spell_size, with_unit
from sweep.request.spec import SweepSpec

_WIDTH = 118


class Repetition(NamedTuple):
    """A new run of the cell: the names of values that differ in any bit, and of those beyond their tolerance."""

    #: Hash of the kernels that made the file, and whether they are those of this program.
    kernel_hash: str
    own: bool
    differing: Sequence[str]
    beyond: Sequence[str]


class RowBoundary(NamedTuple):
    """A boundary in the row of the cell along an axis: measured, and as theory has it, in SI; NaN if there is none."""

    axis: str
    edge: str
    #: The axes across the row, and the status of the row.
    others: Sequence[str]
    status: int
    measured: float
    halfwidth: float
    predicted: float
    critical: float


@dataclass(frozen=True)
class Explanation:
    """The explanation of a cell.

    `place` has the number of the cell along each axis, and `asked` the values that were asked for. `start` has every
    parameter. `stored` has every measure, NaN if the cell or the atlas lacks it. `exact` has the measures that the
    exact reference knows [SI]; it is empty if the model has no reference. `in_time` has values that follow from the
    motion followed in time, with their errors, and `contradicted` the stored ones among them that are wrong.
    `repetition` is None for a cell that was not computed. `linear` has sentences of theory, and `reason` the reason for
    the verdict.
    """

    spec: SweepSpec
    place: Mapping[str, int]
    asked: Mapping[str, object]
    reported: Mapping[str, ReportedAs]
    start: Mapping[str, float]
    stored: Mapping[str, float]
    exact: Mapping[str, float]
    in_time: Mapping[str, tuple[float, float]]
    contradicted: Sequence[str]
    repetition: Repetition | None
    boundaries: Sequence[RowBoundary]
    linear: Sequence[str]
    reason: str

    @property
    def repeated(self) -> bool:
        """Whether a new run of the cell agrees within the tolerances; true for a cell that was not computed."""
        return self.repetition is None or not self.repetition.beyond

    @property
    def exactly(self) -> bool:
        """Whether a new run of the cell agrees bit for bit; true for a cell that was not computed."""
        return self.repetition is None or not self.repetition.differing

    @property
    def confirmed(self) -> bool:
        """Whether no stored value contradicts the motion followed in time."""
        return not self.contradicted

    @property
    def text(self) -> str:
        """The report."""
        return write_explanation(self)


def write_explanation(found: Explanation) -> str:
    """Return the report about a cell of an atlas."""
    return _write_sections(found, _write_place(found), [f"repeated    {_write_repetition(found)}"])


def write_computed_cell(found: Explanation, at: Mapping[str, float]) -> str:
    """Return the report about a cell that was computed for it, without its place in an atlas and its repetition.

    Parameters
    ----------
    found : Explanation
    at : mapping of str to float
        The values of parameters [SI] that were asked for.
    """
    parameters = found.spec.model.parameters
    where = ", ".join(f"{name} {parameters[name].spell(value)}" for name, value in at.items())
    return _write_sections(found, where, [])


def _write_sections(found: Explanation, where: str, repetition: Sequence[str]) -> str:
    verdict = found.spec.model.cell_variables(found.spec)["stability"].flag(found.stored["stability"])
    sections: tuple[Sequence[str], ...] = (
        [f"cell        {where}", *_start_lines(found)],
        list(_stored_lines(found)),
        [*repetition, *_exact_lines(found), *_time_lines(found)],
        [*found.linear, *_boundary_lines(found)],
        [f"verdict     {verdict} by {found.spec.criterion}", f"because     {found.reason}"],
    )
    # only long lines: `fill` would collapse the spaces of short ones
    return "\n\n".join(
        "\n".join(_fold(line) if len(line) > _WIDTH else line for line in lines)
        for lines in sections
        if lines
    )


def _fold(line: str) -> str:
    """Return a line broken into several, indented past the label, with each number next to its unit."""
    joined = re.sub(r"(?<=\d) | (?=[a-z]+-?\d)", "\xa0", line)
    return textwrap.fill(joined, _WIDTH, subsequent_indent=" " * 12).replace("\xa0", " ")


def _write_place(found: Explanation) -> str:
    spec, at = found.spec, []
    for name, i in found.place.items():
        axis, shown = getattr(spec, name).array(), found.reported[name]
        held = f"{name} {spec.quantities[name].spell(axis[i])}"
        is_held = shown.quantity.name == name
        place_of_it = f"{i + 1} of {axis.size}" if is_held else f"{held}, {i + 1} of {axis.size}"
        at.append(f"{held if is_held else f'{shown.quantity.name} {shown.spell(axis[i])}'} ({place_of_it})")
    asked = ", ".join(f"{name}={value}" for name, value in found.asked.items())
    return (", ".join(at) or "the only one") + (f"; nearest to {asked}" if asked else "")


def _start_lines(found: Explanation) -> Iterator[str]:
    spec, start = found.spec, found.start
    fixed = [f"body {spec.body}"] if "body" in spec.model.options else []
    for name in [each for each in start if each not in spec.axes]:
        word = getattr(spec, name) if name in spec.constants else "none"
        spelled = found.reported[name].spell(start[name]) if np.isfinite(start[name]) else word
        # a constant of 0 is a length that the body does not have; its moments of inertia are not 0
        if start[name] != 0.0 or name not in spec.constants:
            fixed.append(f"{found.reported[name].quantity.name} {spelled}")
    yield f"start       {', '.join(fixed)}"
    if spec.model.coordinate:
        yield f"reference   {spec.model.disturbed_motion(spec, start)}"


def _stored_lines(found: Explanation) -> Iterator[str]:
    variables, stored = found.spec.model.cell_variables(found.spec), found.stored
    yield f"ending      {variables['ending'].flag(stored['ending'])}"
    for name, quantity in variables.items():
        value = stored[name]
        if not np.isfinite(value) or name in ("ending", "stability"):
            continue
        digits = 3 if quantity.dtype == "f4" else 10
        says = quantity.spell(value, digits) if quantity.flags is None else quantity.flag(value)
        if quantity.tolerance == ERROR_GAUGE and value >= UNKNOWN_ERROR:
            says = "undecided"
        yield f"  {name:<17} {says:<22} {quantity.long_name}"


def _write_repetition(found: Explanation) -> str:
    again = found.repetition
    if again is None:
        return "not repeated: the cell has not been computed"
    kernels = (
        "the same kernels" if again.own else f"different kernels from the file's ({again.kernel_hash[:12]})"
    )
    outcome = "every value agrees bit for bit"
    if again.beyond:
        outcome = _beyond(again.beyond)
    elif again.differing:
        names = ", ".join(again.differing)
        outcome = f"not bit for bit ({names}), but within the tolerances of eulerdisk compare"
    return f"from the file only, with {kernels}: {outcome}"


def _exact_lines(found: Explanation) -> Iterator[str]:
    model, exact = found.spec.model, found.exact
    if model.exact is None:
        return
    yield f"exact       without time stepping: {model.variables['ending'].flag(exact['ending'])}"
    for name in model.exact.compared:
        if np.isfinite(exact[name]):
            yield f"  {name:<17} {_beside(model.variables[name], exact[name], found.stored[name], 22)}"


def _time_lines(found: Explanation) -> Iterator[str]:
    if not found.in_time:
        return
    says = _beyond(found.contradicted) if found.contradicted else "no stored value contradicts it"
    yield f"in time     the motion followed in time: {says}"
    variables = found.spec.model.cell_variables(found.spec)
    for name, (value, _) in found.in_time.items():
        yield f"  {name:<18} {_beside(variables[name], value, found.stored[name], 21)}"


def _beside(quantity: Quantity, value: float, stored: float, width: int) -> str:
    """Return another value of a variable, and the distance of the stored value from it."""
    apart, shown = abs(value - stored), quantity.spell(value) if np.isfinite(value) else "none"
    # in SI, like the tolerance with which it is compared
    off = f"the cell differs by {spell_size(apart, quantity.units)}"
    return f"{shown:<{width}} {off if np.isfinite(apart) else 'the cell has no value'}"


def _beyond(names: Sequence[str]) -> str:
    return f"{', '.join(names)} DIFFER beyond the tolerance"


def _boundary_lines(found: Explanation) -> Iterator[str]:
    """Yield the lines on the boundaries of the cell's row."""
    for row in found.boundaries:
        shown, name = found.reported[row.axis], found.reported[row.axis].quantity.name
        predicted, critical = map(shown.value, (row.predicted, row.critical))
        others = " and ".join(found.reported[each].quantity.name for each in row.others)
        where = f" at this {others}" if others else ""
        side = f"stable {'below' if row.edge == 'lower' else 'above'} {name}"
        here = f"this cell is at {shown.value(found.start[row.axis]):.6g}"
        if np.isfinite(row.measured):
            half = f"+- {shown.width(row.halfwidth):.2g} as measured"
            yield f"boundary    {side} {_value(shown.value(row.measured), shown.quantity)} {half}{where}; {here}"
        else:
            yield f"boundary    none measured{where} ({side}): {row_edges.name(row.status, row.edge)}; {here}"
        if not np.isfinite([predicted, critical]).any():
            yield f"            theory has no line{where}"
            continue
        how, words = "as" if np.isfinite(predicted) else "is", found.spec.model.line_words
        yield f"            {_value(predicted, shown.quantity)} {how} {words.told}"
        yield f"            {_value(critical, shown.quantity)} {words.limit}"


def _value(value: float, quantity: Quantity) -> str:
    return with_unit(f"{value:.6g}", quantity.units) if np.isfinite(value) else "none"
