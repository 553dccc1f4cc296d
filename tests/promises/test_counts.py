"""Counts in messages: one cell is no cells."""

import ast
import re
from itertools import pairwise
from pathlib import Path

import pytest

import sweep
from sweep.errors import are, counted

#: Things that messages count.
_THINGS = (
    "blocks|cells|sweeps|rows|starts|values|files|columns|frames|steps|samples|points|edges|threads|atlases|curves|"
    "variables|processors|lines|ticks|motions|names|axes|processes|pictures|levels|panels|parts|digits|tests"
)
_PLURAL = re.compile(rf"\s(?:\w+ )?({_THINGS})\b")

#: Largest values that are allowed: none of them is 1.
_LIMIT = re.compile(r"_?[A-Z_]+")

#: What stands before a plural and is no count, or is never 1 there: file, expression.
_NOT_ONE = {
    ("accessor.py", "edge"),
    ("batch/report.py", "count"),
    ("checks/boundary_audit.py", "_by(stored.shape)"),
    ("explorer/about.py", "shape[1]"),
    ("explorer/export.py", "y.size"),
    ("explorer/stored.py", "' x '.join(map(str, spec.shape)) or 'one'"),
    ("figures/arrange.py", "72.0 * self.letter"),
    ("figures/multiples.py", "count"),
    ("figures/multiples.py", "len(datasets)"),
    ("figures/multiples.py", "len(drawn_dims(dataset))"),
    ("figures/plots.py", "len(panels)"),
    ("figures/scales.py", "quantity.name"),
    ("figures/thumbnail.py", "style"),
    ("request/expression_text.py", "shown(given)"),
    ("request/start_list.py", "_said(name, given, values)"),
    ("runs/forecast.py", "found.rate"),
    ("runs/journal.py", "shown(count)"),
    ("runs/run.py", "cells"),
}


def test_a_count_has_its_noun_and_verb():
    """The noun follows the number of all things, the verb that of those which are meant."""
    assert [counted(count, "cell") for count in (0, 1, 2)] == ["0 cells", "1 cell", "2 cells"]
    assert [counted(1, "block", of) for of in (1, 3)] == ["1 of 1 block", "1 of 3 blocks"]
    assert [are(count) for count in (0, 1, 2)] == ["are", "is", "are"]
    assert are(1, "was", "were") == "was"


def _plurals(path):
    """Yield the expressions of f-strings that a plural follows directly."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        for value, text in pairwise(node.values if isinstance(node, ast.JoinedStr) else []):
            before = isinstance(value, ast.FormattedValue) and isinstance(text, ast.Constant)
            if before and _PLURAL.match(text.value):
                yield ast.unparse(value.value)


def test_messages_count_with_the_one_function_that_knows_the_singular():
    """No message writes a number before a plural by itself, but where the number is never 1."""
    room = Path(sweep.__file__).parent
    found = {
        (path.relative_to(room).as_posix(), each)
        for path in room.rglob("*.py")
        for each in _plurals(path)
        if not _LIMIT.fullmatch(each)
    }
    assert found == _NOT_ONE


@pytest.mark.compiled
def test_one_of_everything(command, spec_file):
    """Runs, batches, parts, plans and reports of a single cell in a single block."""
    spec_file('roll_rate = 3\ntilt = "1deg"\n', "one.toml")
    said = []
    commands = [
        ("plan one.toml", 0),
        ("prepare one.toml -o a.nc", 0),
        # nothing is computed yet
        ("assemble a.nc.run", 2),
        ("info a.nc.run", 0),
        *[("block --run a.nc.run --part 1/1", 0)] * 2,
        ("assemble a.nc.run", 0),
        *((words, 0) for words in ("info a.nc", "verify a.nc", "compare a.nc a.nc", "export a.nc --to csv")),
        ("batch one.toml -o tonight --verify", 0),
        # the folder has no reference of this sweep
        ("batch one.toml -o tonight --reference .", 1),
    ]
    for words, expected in commands:
        status, out, messages = command(words)
        assert status == expected, (words, out, messages)
        said += [out, messages]
    text = "\n".join(said)
    assert not re.findall(rf"(?<![\d.,:-])1 (?:\w+ )?(?:{_THINGS})\b[^\n]*", text)
    assert "1 of 1 block is missing" in text
    assert "the one sweep is as it should be" in text
