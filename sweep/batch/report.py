"""The closing report of a batch: a table for people, JSON for programs, JUnit XML for a CI server."""

import shlex
from collections.abc import Iterator, Mapping, Sequence
from typing import Any
from xml.etree import ElementTree

from sweep.batch.night import KEPT, REFUSED, Outcome
from sweep.batch.sweeps import Sweep
from sweep.checks.comparison_report import what
from sweep.errors import are, counted, printable
from sweep.progress.timetable import duration

#: Why a sweep has no outcome.
_NOT_FINISHED = "not finished: the batch has not come to it, or was interrupted. The same command goes on."

_HEAD = ("sweep", "cells", "not computed", "verified", "reference", "time")


def in_words(outcomes: Sequence[Outcome], most: float) -> str:
    """Return a table with a line for each sweep, the problems in sentences, and a last line with the sum.

    Why a sweep was refused is told before a batch begins, and not here.

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
    problems = [
        f"{each.sweep.label}: {text}"
        for each in outcomes
        if each.state != REFUSED
        for text in problems_of(each, most).values()
    ]
    bad = sum(not each.is_fine(most) for each in outcomes)
    total = duration(sum(sum(each.seconds.values()) for each in outcomes))
    count = len(outcomes)
    fine = (
        f"NOT as it should be: {counted(bad, 'sweep', count)}"
        if bad
        else "the one sweep is as it should be"
        if count == 1
        else f"all {count} sweeps are as they should be"
    )
    return "\n".join([*lines, *([""] if problems else []), *problems, "", f"{fine}, {total}"])


def to_json(outcomes: Sequence[Outcome], most: float) -> dict[str, Any]:
    """Return all that the table says, and the whole comparisons, as plain values."""
    return {
        "fine": all(each.is_fine(most) for each in outcomes),
        "sweeps": [
            {
                "name": each.sweep.label,
                "source": each.sweep.source,
                "file": str(each.path) if each.sweep.name else None,
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


def to_junit(outcomes: Sequence[Outcome], most: float, waiting: Sequence[Sweep] = ()) -> str:
    """Return JUnit XML: a suite for each sweep, a test for each of its steps, with the time that each took.

    Parameters
    ----------
    outcomes, most
        As in `in_words`.
    waiting : sequence of Sweep
        Those that are not finished: an error each.
    """
    root = ElementTree.Element("testsuites")
    for each in outcomes:
        failed = problems_of(each, most)
        steps = each.seconds or {"run": 0.0}
        _suite(root, each.sweep.label, steps, {step: ("failure", text) for step, text in failed.items()})
    for sweep in waiting:
        _suite(root, sweep.label, {"run": 0.0}, {"run": ("error", _NOT_FINISHED)})
    for count in ("tests", "failures", "errors"):
        root.set(count, str(sum(int(suite.get(count, "0")) for suite in root)))
    root.set("time", f"{sum(sum(each.seconds.values()) for each in outcomes):.3f}")
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _suite(
    root: ElementTree.Element, label: str, steps: Mapping[str, float], wrong: Mapping[str, tuple[str, str]]
) -> None:
    """Add the suite of a sweep: step -> seconds, and step -> the kind of what is wrong, and the reason."""
    name, kinds = printable(label), [kind for kind, _ in wrong.values()]
    counts = {
        "tests": str(len(steps)),
        "failures": str(kinds.count("failure")),
        "errors": str(kinds.count("error")),
        "time": f"{sum(steps.values()):.3f}",
    }
    suite = ElementTree.SubElement(root, "testsuite", {"name": name, **counts})
    for step, seconds in steps.items():
        case = ElementTree.SubElement(
            suite, "testcase", {"classname": name, "name": step, "time": f"{seconds:.3f}"}
        )
        if step in wrong:
            kind, text = wrong[step][0], printable(wrong[step][1])
            ElementTree.SubElement(case, kind, {"message": text}).text = text


def _row(found: Outcome, most: float) -> tuple[str, ...]:
    size = "-" if found.sweep.spec is None else str(found.sweep.spec.size)
    undone = "-" if found.failures is None else str(found.failures.total)
    if found.failures is None:
        undone = found.state
    return (
        found.sweep.label,
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


def problems_of(found: Outcome, most: float) -> dict[str, str]:
    """Return the steps of a sweep that are not as they should be, and why; `most` as in `in_words`."""
    return dict(_problems(found, most))


def _problems(found: Outcome, most: float) -> Iterator[tuple[str, str]]:
    yield from found.problems.items()
    if found.failures is not None and found.too_many_failed(most):
        yield "run", "; ".join(line.strip() for line in found.failures.describe())
    if found.findings is not None and not found.findings.passed:
        wrong = [each.name for each in found.findings.wrong]
        apart, missing = found.findings.disagreeing, found.findings.missing
        disagree = f"{counted(apart, 'cell')} {are(apart, 'disagrees', 'disagree')} with the exact reduction"
        named = f"; wrong: {', '.join(wrong[:6])}" if wrong else ""
        command = shlex.join(["eulerdisk", "verify", str(found.path)])
        yield (
            "verify",
            f"{disagree}, {missing} {are(missing, 'lacks', 'lack')} a value{named}. More is said by: {command}",
        )
    if found.comparison is not None and not found.comparison.same:
        worst = next(each for each in found.comparison.findings if each.different)
        command = shlex.join(["eulerdisk", "compare", str(found.path), str(found.trusted)])
        yield "compare", f"{_compared(found)}: {what(worst)}. More is said by: {command}"
