"""The report of a comparison: in words for a person, in JUnit XML for a CI server."""

from collections.abc import Iterator
from xml.etree import ElementTree

from sweep.checks.compare import Comparison, Finding
from sweep.errors import printable

#: Characters of an attribute that the words show; the JSON has all.
_SHOWN = 60


def in_words(comparison: Comparison) -> str:
    """Return the report of a comparison: the outcome, a line per variable, its worst cell, and what made the files."""
    lines = [_outcome(comparison), ""]
    for finding in comparison.findings:
        lines += _lines(finding)
    lines += [f"not judged: {note}" for note in comparison.notes]
    return "\n".join([*lines, "", *_provenance(comparison)])


def to_junit(comparison: Comparison, name: str) -> str:
    """Return JUnit XML: a test suite with one test for each variable.

    Parameters
    ----------
    comparison : Comparison
    name : str
        What the suite is called, for example the name of the file.
    """
    name = printable(name)
    failed = [finding for finding in comparison.findings if finding.different]
    counts = {"tests": str(len(comparison.findings)), "failures": str(len(failed)), "errors": "0"}
    root = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(root, "testsuite", {"name": name, **counts})
    for finding in comparison.findings:
        case = ElementTree.SubElement(
            suite, "testcase", {"classname": name, "name": finding.name, "time": "0"}
        )
        if finding.different:
            text = _what(finding)
            ElementTree.SubElement(case, "failure", {"message": text}).text = "\n".join(_lines(finding))
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _outcome(comparison: Comparison) -> str:
    cells = f"{comparison.cells} {'common ' if comparison.common else ''}cell{'s' * (comparison.cells != 1)}"
    names = [finding.name for finding in comparison.findings if finding.different]
    flips = {finding.name: finding.on_edge for finding in comparison.findings}
    edge = max(flips.get("ending", 0), flips.get("stability", 0))
    apart = f"; {edge} on an edge flipped, which is no disagreement" if edge else ""
    outcome = f"DIFFERENT in {', '.join(names)}" if names else "the same"
    return f"{outcome}: {cells}{apart}"


def _lines(finding: Finding) -> Iterator[str]:
    yield f"{'DIFFERS' if finding.different else 'same':<8} {finding.name:<32} {_what(finding)}"
    if finding.worst is not None:
        values = " and ".join(
            "missing" if value is None else f"{value:.17g}"
            for value in (finding.worst.new, finding.worst.reference)
        )
        yield f"{'':<8} worst cell: {finding.worst.place}: {values}"
    if finding.different and not finding.note:
        limit = finding.tolerance
        yield f"{'':<8} tolerance: {limit.absolute:g} + {limit.relative:g} |reference|, because {limit.reason}"


def _what(finding: Finding) -> str:
    if finding.note:
        return printable(finding.note)
    parts = [f"{finding.different} of {finding.values} differ"] if finding.different else []
    parts += [f"{finding.on_edge} flipped on an edge"] if finding.on_edge else []
    units = f" {finding.units}".removesuffix(" 1")
    parts += [f"largest difference {finding.largest:.2g}{units}"] if finding.largest else []
    return ", ".join(parts) or f"{finding.values} equal"


def _provenance(comparison: Comparison) -> Iterator[str]:
    if not comparison.provenance:
        yield "made alike: no attribute differs"
        return
    yield "made differently (provenance, not judged; new, then reference):"
    for name, (new, reference) in comparison.provenance.items():
        yield f"  {name}: {_short(new)} | {_short(reference)}"


def _short(text: str) -> str:
    line = printable(" / ".join(text.splitlines())) or "(none)"
    return line if len(line) <= _SHOWN else f"{line[: _SHOWN - 4]} ..."
