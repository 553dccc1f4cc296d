"""Text report of the results of `verify`."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from sweep.checks.findings import Findings
from sweep.checks.statement import Statement
from sweep.errors import are, counted
from sweep.model.quantity import spell_size, with_unit
from sweep.request.spec import SweepSpec

#: Largest number of wrong variables and attributes named in the last line of an audit.
_MOST_WRONG = 6


def audit_text(found: Findings, spec: SweepSpec) -> str:
    """Return the report of an audit: counts, the distribution of the difference, and the cells to look at."""
    counted = ", ".join(f"{count} {word.replace('_', ' ')}" for word, count in found.counts.items() if count)
    lines = [f"cells        {counted}"]
    if np.isfinite(found.extremes[2]):
        lines.append(f"{found.told} {with_unit(_spread(found.extremes), found.units)}")
    if found.has_period:
        lines.append(
            f"periods      relative difference from the exact ones {_spread(found.period)}; "
            f"largest {found.period_share:.2g} of what the tolerance allows"
        )
    if found.sampled:
        lines.append(f"sample       {found.sampled}")
    units = spec.model.settings["tolerance"].units
    lines.append(f"tolerance    {with_unit(f'{found.tolerance:.1e}', units)}")
    head = "wrong" if found.disagreeing else "worst cell"
    lines += [f"{head:<12} {_cell(place, spec)}, {flag.replace('_', ' ')}" for flag, place in found.named]
    if found.disagreeing > len(found.named):
        lines.append(f"             and {found.disagreeing - len(found.named)} more")
    if spec.model.exact is not None and (unknown := spec.model.exact.untimed(spec)):
        lines.append(f"note         method={found.method} gives {unknown}: there is nothing to check")
    return "\n".join([*lines, "", *_statement_lines(found.statements), "", audit_line(found)])


def _statement_lines(statements: Sequence[Statement]) -> Iterator[str]:
    """Yield a table of the variables, then the wrong attributes, then the statements that were not checked."""
    variables = [statement for statement in statements if statement.checked and _is_variable(statement)]
    width = max((len(statement.name) for statement in variables), default=0)
    yield f"{'variable':<{width}}  {'difference':<10}  {'allowed':<17}  compared with"
    for variable in variables:
        allowed = with_unit(_small(variable.allowed), variable.units)
        yield f"{variable.name:<{width}}  {_small(variable.difference):<10}  {allowed:<17}  {variable.against}"
        yield from _wrong_values(variable)
    attributes = [statement for statement in statements if statement.checked and not _is_variable(statement)]
    judged = sum(attribute.judged for attribute in attributes)
    wrong = sum(attribute.wrong for attribute in attributes)
    yield f"attributes: {judged - wrong} of {judged} agree with the spec, the tables of the model and this version"
    for attribute in attributes:
        if attribute.wrong:
            yield f"    wrong: {attribute.name}, compared with {attribute.against}: {'; '.join(attribute.named)}"
    for statement in statements:
        if not statement.checked and not statement.name.endswith(":"):
            yield f"not checked: {statement.name}, {statement.against}"


def _is_variable(statement: Statement) -> bool:
    """Return whether a statement is about the values of a variable, not about an attribute."""
    return not math.isnan(statement.allowed) and ":" not in statement.name


def _wrong_values(statement: Statement) -> Iterator[str]:
    if statement.wrong:
        more = f", and {statement.wrong - len(statement.named)} more" * (
            statement.wrong > len(statement.named)
        )
        yield f"    wrong in {statement.wrong} of {statement.judged}: {'; '.join(statement.named)}{more}"


def _small(value: float) -> str:
    if math.isnan(value):
        return "missing"
    return f"{value:.1e}" if value else "0"


def audit_line(found: Findings) -> str:
    """Return the outcome of an audit in one line."""
    agreeing = counted(found.agreeing, "cell", found.cells)
    known = np.isfinite(found.extremes[2])
    if found.passed and found.method == "exact":
        largest = f", largest difference {spell_size(found.extremes[2], found.units)}" if known else ""
        sample = (
            f"a sample agrees with another method ({found.sampled})"
            if found.sampled
            else "but only the file was checked: no cell has a motion that another method can follow"
        )
        return f"verified: {agreeing} agree with the reduction, recomputed{largest}; {sample}"
    if found.passed and found.sampled:
        largest = f", largest difference {spell_size(found.extremes[2], found.units)}" if known else ""
        return (
            f"verified: {agreeing} are consistent, and a sample of {found.compared} agrees with a second computation "
            f"({found.sampled}){largest}"
        )
    if found.passed:
        largest = f", largest difference {spell_size(found.extremes[2], found.units)}" if known else ""
        return f"verified: {agreeing} within {with_unit(f'{found.tolerance:g}', found.units)}{largest}"
    names = [statement.name for statement in found.wrong]
    wrong = f"; wrong: {', '.join(names[:_MOST_WRONG])}" if names else ""
    more = f" and {len(names) - _MOST_WRONG} more" if len(names) > _MOST_WRONG else ""
    if not (found.disagreeing or found.missing or names):
        return (
            f"NOT verified: none of {counted(found.cells, 'cell')} could be compared with another computation"
        )
    disagree = (
        f"{counted(found.disagreeing, 'cell', found.cells)} {are(found.disagreeing, 'disagrees', 'disagree')}"
    )
    return f"NOT verified: {disagree}, {found.missing} {are(found.missing)} not computed{wrong}{more}"


def _spread(distribution: tuple[float, float, float]) -> str:
    return "{:.1e} (median), {:.1e} (99 %), {:.1e} (largest)".format(*distribution)


def _cell(place: Mapping[str, float], spec: SweepSpec) -> str:
    words = [f"{name} {spec.quantities[name].spell(value)}" for name, value in place.items()]
    return ", ".join(words) or "the one cell"
