"""The closing report of a batch: a table for people, JSON for programs, JUnit XML for a CI server."""

from collections.abc import Sequence
from typing import Any

from sweep.batch.execution import KEPT, REFUSED, Outcome, in_one_line
from sweep.batch.sweeps import Sweep
from sweep.checks.junit import Case, to_xml
from sweep.errors import counted
from sweep.progress.timetable import duration

#: Why a sweep has no outcome.
_NOT_FINISHED = "not finished: the batch has not come to it, or was interrupted. The same command goes on."

_HEAD = ("sweep", "cells", "not computed", "verified", "reference", "time")


def in_words(outcomes: Sequence[Outcome]) -> str:
    """Return a table with a line for each sweep, the problems in sentences, and a last line with the sum.

    Why a sweep was refused is told before a batch begins, and not here.
    """
    rows = [_HEAD, *map(_row, outcomes)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
    problems = [
        f"{each.sweep.label}: {text}"
        for each in outcomes
        if each.state != REFUSED
        for text in each.problems.values()
    ]
    bad, count = sum(bool(each.problems) for each in outcomes), len(outcomes)
    fine = f"all {count} sweeps are as they should be" if count != 1 else "the one sweep is as it should be"
    if bad:
        fine = f"NOT as it should be: {counted(bad, 'sweep', count)}"
    total = duration(sum(sum(each.seconds.values()) for each in outcomes))
    return "\n".join([*lines, *([""] if problems else []), *problems, "", f"{fine}, {total}"])


def _row(found: Outcome) -> tuple[str, ...]:
    verified, compared = ("failed" if step in found.problems else "-" for step in ("verify", "compare"))
    if found.findings is not None:
        verified = "yes" if found.findings.passed else "WRONG"
    if found.comparison is not None:
        compared = in_one_line(found.comparison)
    return (
        found.sweep.label,
        "-" if found.sweep.spec is None else str(found.sweep.spec.size),
        (found.state if found.failures is None else str(found.failures.total))
        + " (kept)" * (found.state == KEPT),
        verified,
        compared,
        duration(sum(found.seconds.values())),
    )


def to_json(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return all that the table says, and the whole comparisons, as plain values."""
    return {
        "fine": not any(each.problems for each in outcomes),
        "sweeps": [
            {
                "name": each.sweep.label,
                "source": each.sweep.source,
                "file": str(each.path) if each.sweep.name else None,
                "fine": not each.problems,
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


def to_junit(outcomes: Sequence[Outcome], waiting: Sequence[Sweep] = ()) -> str:
    """Return JUnit XML: a suite for each sweep, a test for each of its steps; those that are `waiting` are errors."""
    suites = [
        (
            each.sweep.label,
            [
                Case(step, seconds, each.problems.get(step, ""))
                for step, seconds in (each.seconds or {"run": 0.0}).items()
            ],
        )
        for each in outcomes
    ]
    return to_xml([*suites, *((each.label, [Case("run", 0.0, _NOT_FINISHED, "error")]) for each in waiting)])
