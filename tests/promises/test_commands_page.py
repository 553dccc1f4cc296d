"""docs/commands.md is runnable: every command and the spec file in it."""

import re
import shlex
import tomllib
from pathlib import Path

import numpy as np
import pytest

import sweep

PAGE = (Path(__file__).parents[2] / "docs" / "commands.md").read_text(encoding="utf-8")


def block(language):
    """Return the one block of a language."""
    (found,) = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    return found


@pytest.mark.compiled
def test_commands(command, tmp_path):
    """Every command runs, in the order shown, and leaves the file that it names."""
    for line in block("bash").splitlines():
        words = shlex.split(line, comments=True)
        assert words[0] == "eulerdisk"
        status, _, err = command(shlex.join(words[1:]))
        assert status == 0, (line, err)
        if "-o" in words:
            assert (tmp_path / words[words.index("-o") + 1]).stat().st_size > 0


@pytest.mark.compiled
def test_spec_file(command, tmp_path):
    """The spec file runs with the command in its first line."""
    text = block("toml")
    tomllib.loads(text)
    (tmp_path / "pushed.toml").write_text(text, encoding="utf-8")
    status, _, err = command(re.search(r"`eulerdisk (run .*)`", text)[1])
    assert status == 0, err
    with sweep.open_atlas(tmp_path / "pushed.nc") as atlas:
        # 120 values of the rate: about half of the pushes are too much for the fastest of them
        assert np.isfinite(atlas.boundary_roll_rate).sum() >= 30


def test_every_command_is_shown(command):
    """The page shows every command of the program but those of array jobs, which have a page of their own."""
    _, listed, _ = command("--help")
    known = re.findall(r"^  ([a-z]+) ", listed[listed.index("Commands:") :], flags=re.MULTILINE)
    shown = set(re.findall(r"eulerdisk ([a-z]+)", PAGE))
    assert len(known) > 10
    assert set(known) - shown <= {"prepare", "block", "assemble", "explore"}


def test_the_list_of_commands_is_whole(command):
    """Each command stands in the list with a sentence on one line; none is cut."""
    _, listed, _ = command("--help")
    lines = listed[listed.index("Commands:") :].splitlines()[1:]
    assert len(lines) > 10
    assert [line for line in lines if not re.fullmatch(r"  [a-z]+ +[A-Z].*[^.]\.", line)] == []
