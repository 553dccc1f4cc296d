"""docs/starts.md and docs/tables.md are runnable: their commands, their table and their Python are executed here."""

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXT = "".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("starts.md", "tables.md"))


def blocks(language):
    """Return the blocks of the page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL)


@pytest.mark.compiled
def test_commands_of_the_page(command):
    """In the order of the page, in one folder, the table of the page beside them; fewer starts than the page has."""
    (table,) = blocks("csv")
    Path("pushes.csv").write_text(table)
    lines = [line for block in blocks("bash") for line in block.splitlines()]
    assert len(lines) == 8
    for line in lines:
        words = shlex.split(line)
        assert words[0] == "eulerdisk"
        status, _, errors = command(shlex.join(words[1:]).replace("1e5", "1e3").replace("2e5", "2e3"))
        assert status == 0, f"{line}: {errors}"


@pytest.mark.compiled
def test_python_of_the_page(capsys):
    """The snippet runs, and one of its two starts is unstable."""
    (code,) = blocks("python")
    exec(compile(code, "docs/tables.md", "exec"), {})
    assert capsys.readouterr().out == "1 of 2\n"


def test_links_and_languages():
    """Every link leads to a file, and no block escapes these tests."""
    for target in re.findall(r"\]\(([^)]+)\)", TEXT):
        assert (ROOT / "docs" / target).is_file(), target
    assert set(re.findall(r"^```(\w+)$", TEXT, flags=re.MULTILINE)) == {"bash", "csv", "python"}
