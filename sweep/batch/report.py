"""The final report of a batch: a table for people, JSON for programs, JUnit XML for a CI server."""

from collections.abc import Sequence
from typing import Any

from sweep.batch.execution import KEPT, REFUSED, Outcome, in_one_line
from sweep.batch.sweeps import Sweep
from sweep.checks.junit import Case, to_xml
from sweep.errors import counted
from sweep.progress.timetable import duration

#: The error of a sweep without an outcome.
_NOT_FINISHED = "not finished: the batch has not reached it, or was interrupted. The same command continues."

_HEAD = ("sweep", "cells", "not computed", "verified", "reference", "time")


def in_words(outcomes: Sequence[Outcome]) -> str:
    """Return a table with a line for each sweep, the problems in sentences, and a last line with the totals.

    The problems of refused sweeps are not repeated: they are reported before the batch begins.
    """
    rows = [_HEAD, *map(_row, outcomes)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
    problems = [
        f"{outcome.sweep.label}: {text}"
        for outcome in outcomes
        if outcome.state != REFUSED
        for text in outcome.problems.values()
    ]
    bad, count = sum(bool(outcome.problems) for outcome in outcomes), len(outcomes)
    result = f"all {count} sweeps passed" if count != 1 else "the sweep passed"
    if bad:
        result = f"NOT passed: {counted(bad, 'sweep', count)}"
    total = duration(sum(sum(outcome.seconds.values()) for outcome in outcomes))
    return "\n".join([*lines, *([""] if problems else []), *problems, "", f"{result}, {total}"])


def _row(outcome: Outcome) -> tuple[str, ...]:
    verified, compared = ("failed" if step in outcome.problems else "-" for step in ("verify", "compare"))
    if outcome.findings is not None:
        verified = "yes" if outcome.findings.passed else "WRONG"
    if outcome.comparison is not None:
        compared = in_one_line(outcome.comparison)
    return (
        outcome.sweep.label,
        "-" if outcome.sweep.spec is None else str(outcome.sweep.spec.size),
        (outcome.state if outcome.failures is None else str(outcome.failures.total))
        + " (kept)" * (outcome.state == KEPT),
        verified,
        compared,
        duration(sum(outcome.seconds.values())),
    )


def to_json(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return the contents of the table, and the whole comparisons, as plain values."""
    return {
        "fine": not any(outcome.problems for outcome in outcomes),
        "sweeps": [_sweep_to_json(outcome) for outcome in outcomes],
    }


def _sweep_to_json(outcome: Outcome) -> dict[str, Any]:
    spec, failures, findings, comparison = (
        outcome.sweep.spec,
        outcome.failures,
        outcome.findings,
        outcome.comparison,
    )
    return {
        "name": outcome.sweep.label,
        "source": outcome.sweep.source,
        "file": str(outcome.path) if outcome.sweep.name else None,
        "fine": not outcome.problems,
        "state": outcome.state,
        "cells": None if spec is None else spec.size,
        "not_computed": None if failures is None else failures.total,
        "verified": None if findings is None else findings.passed,
        "disagreeing_cells": None if findings is None else findings.disagreeing,
        "comparison": None if comparison is None else comparison.to_dict(),
        "problems": outcome.problems,
        "seconds": {name: round(value, 3) for name, value in outcome.seconds.items()},
    }


def to_junit(outcomes: Sequence[Outcome], waiting: Sequence[Sweep] = ()) -> str:
    """Return JUnit XML: a suite for each sweep, a test for each of its steps; sweeps still `waiting` are errors."""
    suites = [
        (
            outcome.sweep.label,
            [
                Case(step, seconds, outcome.problems.get(step, ""))
                for step, seconds in (outcome.seconds or {"run": 0.0}).items()
            ],
        )
        for outcome in outcomes
    ]
    return to_xml(
        [*suites, *((sweep.label, [Case("run", 0.0, _NOT_FINISHED, "error")]) for sweep in waiting)]
    )
