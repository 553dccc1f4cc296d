"""docs/words.md and another-disk.md are runnable: commands, the refusal and the Python are executed here."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from sweep.model.disk.model import DISK

CHECKOUT = Path(__file__).resolve().parents[2]
PAGE = "".join(
    (CHECKOUT / "docs" / name).read_text(encoding="utf-8") for name in ("another-disk.md", "words.md")
)


def blocks(language):
    """Return the blocks of both pages in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)


def test_every_substitute_is_in_the_table():
    """The page has a row for each word that stands for a parameter, and no other."""
    rows = re.findall(r"^\| `(\w+)` \| `(\w+)` \|", PAGE, flags=re.MULTILINE)
    assert sorted(rows) == sorted((name, each.parameter) for name, each in DISK.substitutes.items())


@pytest.mark.compiled
def test_its_commands_run(command, tmp_path):
    """Every command runs, in the order of the page, and leaves the files that it names."""
    for line in "".join(blocks("bash")).splitlines():
        status, _, err = command(line.removeprefix("eulerdisk "))
        assert status == 0, (line, err)
        for option in ("-o", "--plot"):
            if option in (words := shlex.split(line)):
                assert (tmp_path / words[words.index(option) + 1]).stat().st_size > 0


def test_its_refusal_is_the_one_of_the_program(command):
    """The message is the one on the page, and what it says to give makes the request possible."""
    (block,) = blocks("text")
    line, message = block.splitlines()
    asked = line.removeprefix("$ eulerdisk ")
    status, _, err = command(asked)
    assert (status, err) == (2, f"{message}\n")
    instead = message.rpartition(" ")[2].removesuffix(".")
    planned = asked.replace("run", "plan", 1).replace(" -o", f" {instead} --no-calibrate -o")
    assert command(planned)[0] == 0


@pytest.mark.compiled
def test_its_python_runs(tmp_path):
    """The Python block runs without a warning, and prints the critical rate of its comment."""
    (block,) = blocks("python")
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", block],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) == pytest.approx(16.5, abs=0.05)
    assert (tmp_path / "moon-spin.nc").exists()
