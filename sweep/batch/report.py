"""The closing report of a batch: a table for people, JSON for programs, JUnit XML for a CI server."""

from collections.abc import Iterator, Sequence
from typing import Any
from xml.etree import ElementTree

from sweep.batch.night import KEPT, Outcome
from sweep.engine.estimate import duration
from sweep.errors import printable

_HEAD = ("sweep", "cells", "not computed", "verified", "reference", "time")


def in_words(outcomes: Sequence[Outcome], most: float) -> str:
    """Return a table with a line for each sweep, the problems in sentences, and a last line with the sum.

    Parameters
    ----------
    outcomes : sequence of Outcome
    most : float
        Per cent of the cells of a sweep that may be unresolved or invalid.
    """
    rows = [_HEAD, *(_row(each, most) for each in outcomes)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
    problems = [f"{each.sweep.name}: {text}" for each in outcomes for _, text in _problems(each, most)]
    bad = sum(not each.is_fine(most) for each in outcomes)
    total = duration(sum(sum(each.seconds.values()) for each in outcomes))
    count = len(outcomes)
    fine = (
        f"all {count} sweeps are as they should be"
        if not bad
        else f"NOT as it should be: {bad} of {count} sweeps"
    )
    return "\n".join([*lines, *([""] if problems else []), *problems, "", f"{fine}, {total}"])


def to_json(outcomes: Sequence[Outcome], most: float) -> dict[str, Any]:
    """Return all that the table says, and the whole comparisons, as plain values."""
    return {
        "fine": all(each.is_fine(most) for each in outcomes),
        "sweeps": [
            {
                "name": each.sweep.name,
                "source": each.sweep.source,
                "file": str(each.path),
                "fine": each.is_fine(most),
                "state": each.state,
                "cells": None if each.sweep.spec is None else each.sweep.spec.size,
                "not_computed": None if each.failures is None else each.failures.total,
                "verified": None if each.findings is None else each.findings.passed,
                "disagreeing_cells": None if each.findings is None else each.findings.disagreeing,
                "comparison": None if each.comparison is None else each.comparison.to_dict(),
                "problems": each.problems,
                "seconds": {name: round(value, 3) for name, value in each.seconds.items()},
            }
            for each in outcomes
        ],
    }


def to_junit(outcomes: Sequence[Outcome], most: float) -> str:
    """Return JUnit XML: a suite for each sweep, a test for each of its steps, with the time that each took."""
    root = ElementTree.Element("testsuites")
    sums = [0, 0, 0.0]
    for each in outcomes:
        failed = dict(_problems(each, most))
        steps = each.seconds or {"run": 0.0}
        took = sum(steps.values())
        counts = {
            "tests": str(len(steps)),
            "failures": str(len(failed)),
            "errors": "0",
            "time": f"{took:.3f}",
        }
        name = printable(each.sweep.name)
        suite = ElementTree.SubElement(root, "testsuite", {"name": name, **counts})
        for step, seconds in steps.items():
            case = ElementTree.SubElement(
                suite, "testcase", {"classname": name, "name": step, "time": f"{seconds:.3f}"}
            )
            if step in failed:
                text = printable(failed[step])
                ElementTree.SubElement(case, "failure", {"message": text}).text = text
        sums = [sums[0] + len(steps), sums[1] + len(failed), sums[2] + took]
    root.attrib |= {"tests": str(sums[0]), "failures": str(sums[1]), "errors": "0", "time": f"{sums[2]:.3f}"}
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _row(found: Outcome, most: float) -> tuple[str, ...]:
    size = "-" if found.sweep.spec is None else str(found.sweep.spec.size)
    undone = "-" if found.failures is None else str(found.failures.total)
    if found.failures is None:
        undone = found.state
    return (
        found.sweep.name,
        size,
        undone + " (kept)" * (found.state == KEPT),
        _verified(found),
        _compared(found),
        duration(sum(found.seconds.values())),
    )


def _verified(found: Outcome) -> str:
    if found.findings is None:
        return "failed" if "verify" in found.problems else "-"
    return "yes" if found.findings.passed else "WRONG"


def _compared(found: Outcome) -> str:
    if found.comparison is None:
        return "failed" if "compare" in found.problems else "-"
    names = [each.name for each in found.comparison.findings if each.different]
    if not names:
        return found.comparison.outcome
    return f"DIFFERENT in {names[0]}" + (f" and {len(names) - 1} more" if len(names) > 1 else "")


def _problems(found: Outcome, most: float) -> Iterator[tuple[str, str]]:
    """Yield the steps of a sweep that are not as they should be, and why."""
    yield from found.problems.items()
    if found.failures is not None and found.too_many_failed(most):
        yield "run", "; ".join(line.strip() for line in found.failures.describe())
    if found.findings is not None and not found.findings.passed:
        wrong = [each.name for each in found.findings.wrong]
        counts = f"{found.findings.disagreeing} cells disagree with the exact reduction, {found.findings.missing} lack"
        named = f"; wrong: {', '.join(wrong[:6])}" if wrong else ""
        yield "verify", f"{counts} a value{named}. eulerdisk verify {found.path} says more."
    if found.comparison is not None and not found.comparison.same:
        yield "compare", f"{_compared(found)}: eulerdisk compare {found.path} with its reference says more."
