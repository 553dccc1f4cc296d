"""Counts in messages: "1 cell", not "1 cells"."""

import re

import pytest
from messages import assert_facts

from sweep.errors import are, counted

#: Things that messages count.
_THINGS = (
    "blocks|cells|sweeps|rows|starts|values|files|columns|frames|steps|samples|points|edges|threads|atlases|curves|"
    "variables|processors|lines|ticks|motions|names|axes|processes|pictures|levels|panels|parts|digits|tests"
)


def test_a_count_has_its_noun_and_verb():
    """The noun agrees with the total count, the verb with the selected count."""
    assert [counted(count, "cell") for count in (0, 1, 2)] == ["0 cells", "1 cell", "2 cells"]
    assert [counted(1, "block", of) for of in (1, 3)] == ["1 of 1 block", "1 of 3 blocks"]
    assert [are(count) for count in (0, 1, 2)] == ["are", "is", "are"]
    assert are(1, "was", "were") == "was"


@pytest.mark.compiled
def test_one_of_everything(command, spec_file):
    """Runs, batches, parts, plans and reports of a single cell in a single block use the singular."""
    spec_file('roll_rate = 3\ntilt = "1deg"\n', "one.toml")
    said = []
    commands = [
        ("plan one.toml", 0),
        ("prepare one.toml -o a.nc", 0),
        # Nothing is computed yet.
        ("assemble a.nc.run", 2),
        ("info a.nc.run", 0),
        *[("block --run a.nc.run --part 1/1", 0)] * 2,
        ("assemble a.nc.run", 0),
        *((words, 0) for words in ("info a.nc", "verify a.nc", "compare a.nc a.nc", "export a.nc --to csv")),
        ("batch one.toml -o tonight --verify", 0),
        # The folder has no reference for this sweep.
        ("batch one.toml -o tonight --reference .", 1),
    ]
    for words, expected in commands:
        status, out, messages = command(words)
        assert status == expected, (words, out, messages)
        said += [out, messages]
    text = "\n".join(said)
    assert not re.findall(rf"(?<![\d.,:-])1 (?:\w+ )?(?:{_THINGS})\b[^\n]*", text)
    assert_facts(text, "1 of 1 block")
    assert_facts(text, "1 of 1 sweep")
