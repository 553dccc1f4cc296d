"""The report of a comparison: text for people, JUnit XML for CI servers."""

from collections.abc import Iterator

from sweep.checks.compare import Comparison
from sweep.checks.finding import Finding
from sweep.checks.junit import Case, to_xml
from sweep.errors import are, counted, printable
from sweep.model.quantity import with_unit

#: Number of characters of an attribute that the text shows; the JSON has all.
_SHOWN = 60


def in_words(comparison: Comparison) -> str:
    """Return the text of the report: the outcome, each variable with its worst cell, and the provenance."""
    lines = [_outcome(comparison), ""]
    for finding in comparison.findings:
        lines += _lines(finding)
    lines += [f"note: {note}" for note in comparison.notes]
    return "\n".join([*lines, "", *_provenance(comparison)])


def to_junit(comparison: Comparison, name: str, seconds: float = 0.0) -> str:
    """Return JUnit XML: a test suite with one test for each variable.

    Parameters
    ----------
    comparison : Comparison
    name : str
        Name of the suite, for example the name of the file.
    seconds : float
        Duration of the comparison. Variables are compared together, so each gets an equal share of it.
    """
    share = seconds / max(len(comparison.findings), 1)
    cases = [
        Case(each.name, share, what(each) if each.different else "", details="\n".join(_lines(each)))
        for each in comparison.findings
    ]
    return to_xml([(name, cases)])


def _outcome(comparison: Comparison) -> str:
    cells = counted(comparison.cells, "common cell" if comparison.common else "cell")
    different = [finding for finding in comparison.findings if finding.different]
    flips = {finding.name: finding.on_edge for finding in comparison.findings}
    edge = max(flips.get("ending", 0), flips.get("stability", 0))
    apart = f"; {counted(edge, 'borderline cell')} flipped, which is not a difference" if edge else ""
    if different:
        compared = f"; compared {cells}" if comparison.common else ""
        return f"DIFFERENT in {', '.join(map(_counted, different))}{compared}{apart}"
    if comparison.identical:
        return f"identical: {cells}, all {counted(len(comparison.findings), 'variable')} bit for bit"
    least = max(comparison.findings, key=lambda finding: finding.share)
    most = (
        f"; at most {_percent(least.share)} of the allowed difference ({least.name})" if least.share else ""
    )
    return f"within tolerance: {cells}{most}{apart}"


def _counted(finding: Finding) -> str:
    # all values differ: the units differ, or one atlas lacks the variable
    if finding.note:
        return finding.name
    return f"{finding.name} ({counted(finding.different, 'value', finding.values)})"


def _lines(finding: Finding) -> Iterator[str]:
    outcome = "DIFFERS" if finding.different else "identical" if finding.bitwise else "within"
    yield f"{outcome:<9} {finding.name:<34} {what(finding)}"
    if finding.worst is not None:
        values = " and ".join(
            "missing" if value is None else f"{value:.17g}"
            for value in (finding.worst.new, finding.worst.reference)
        )
        values = finding.worst.flags or values
        limit = f"; allowed there {finding.worst.allowed:.2g}" if finding.worst.allowed else ""
        yield f"{'':<9} worst cell: {finding.worst.place}: {values}{limit}"
    if finding.different and not finding.note:
        so_much = (
            "this difference" if finding.worst is not None and finding.worst.allowed else "no difference"
        )
        yield f"{'':<9} {so_much} is allowed because {finding.reason}"


def what(finding: Finding) -> str:
    """Return how a variable differs: the number of values, the largest difference, the allowed difference."""
    if finding.note:
        return printable(finding.note)
    parts = (
        [f"{finding.different} of {finding.values} {are(finding.different, 'differs', 'differ')}"]
        if finding.different
        else []
    )
    parts += [f"{finding.on_edge} flipped in borderline cells"] if finding.on_edge else []
    if finding.largest:
        parts.append(
            f"largest difference {with_unit(f'{finding.largest:.2g}', finding.units)}, allowed {finding.allowed:.2g}"
        )
    if finding.share and not finding.different:
        parts.append(f"at most {_percent(finding.share)} of the allowed difference")
    return ", ".join(parts) or f"{finding.values} equal"


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"


def _provenance(comparison: Comparison) -> Iterator[str]:
    if not comparison.provenance:
        yield "provenance: no attribute differs"
        return
    yield "provenance differs (not judged; new | reference):"
    for name, (new, reference) in comparison.provenance.items():
        yield f"  {name}: {_short(new)} | {_short(reference)}"


def _short(text: str) -> str:
    line = printable(" / ".join(text.splitlines())) or "(none)"
    return line if len(line) <= _SHOWN else f"{line[: _SHOWN - 4]} ..."
