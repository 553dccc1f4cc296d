"""All output of commands goes through one place, which escapes control characters."""

import ast
import shlex
from pathlib import Path

import pytest
from messages import assert_facts

import sweep
from sweep.commands import terminal
from sweep.errors import RequestError, printable

COMMANDS = sorted((Path(sweep.__file__).parent / "commands").glob("*.py"))


@pytest.mark.parametrize("path", COMMANDS, ids=lambda path: path.stem)
def test_commands_do_not_print_by_themselves(path):
    """Only `show` and `say` print, so text from a file cannot control the terminal."""
    if path.stem == "terminal":
        return
    called = [
        node.func
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
    ]
    assert not [each.lineno for each in called if isinstance(each, ast.Name) and each.id == "print"]


def test_only_line_breaks_pass(capsys):
    """A result keeps its lines, a message is one line, and unprintable characters are escaped."""
    terminal.show("a\x1b[31m\tb\nc\x9b\u202e")
    terminal.say("a\nb\x07")
    out, err = capsys.readouterr()
    assert out == "a\\x1b[31m\\tb\nc\\x9b\\u202e\n"
    assert err == "eulerdisk: a\\nb\\x07\n"


def test_an_error_is_one_line_that_prints():
    """User's words and file contents in an error message are escaped, too."""
    error = RequestError("What \x1b]0;is\x07\nwrong.", "Do \u2028this.", "file\n.nc")
    assert str(error) == "file\\n.nc: What \\x1b]0;is\\x07\\nwrong. Do \\u2028this."
    long = str(RequestError("It is too long.", where="x" * 10**6))
    assert long.startswith("xxx")
    assert long.endswith("xxx: It is too long.")
    assert len(long) < 5000
    assert printable("\u6eda 5 $ [red]") == "\u6eda 5 $ [red]"


@pytest.mark.parametrize("part", ["\uff11/\uff13", "1/3\n", "0/3", "4/3", "1/\u0663"])
def test_a_part_is_two_ascii_numbers(command, part):
    """The parts of a run are numbered with ASCII digits only."""
    status, _, err = command(shlex.join(["block", "--run", "nowhere", "--part", part]))
    assert status == 2
    assert_facts(err, "--part", "I/N", "1 <= I <= N")


@pytest.mark.parametrize(
    ("option", "text"),
    [
        ("run rolling -o a.nc --threads", "\uff12"),
        ("run rolling -o a.nc --block-cells", "1_000"),
        ("run rolling -o a.nc --max-failed", "\u0661"),
        ("boundary a.nc --refine", "1_0e-3"),
        ("plot a.nc -o a.png --friction", "\uff11"),
    ],
)
def test_numbers_of_options_are_ascii(command, option, text):
    """Numeric options refuse non-ASCII digits and underscores, which a reader could misunderstand."""
    status, out, err = command(f"{option} {text}")
    assert (status, out) == (2, "")
    assert_facts(err, f"'{option.split()[-1]}'", f"'{text}'")
