"""Ctrl-C while a command is loading ends it at once with status 130 and one line, at any import."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]

#: A module finder that finds nothing and sends Ctrl-C to its process when a given module is imported.
INTERRUPTED = """
import os, signal, sys
signal.signal(signal.SIGINT, {handler})

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Finder())
from sweep.cli import main
sys.argv = ["eulerdisk", *{words!r}]
main()
"""
WORDS = ["plan", "rolling", "--no-calibrate"]
TOLD = "eulerdisk: interrupted; no unfinished file was written.\n"


def python(code, folder, *words):
    """Run code, or other arguments of the interpreter, in a fresh process."""
    return subprocess.run(
        [sys.executable, *(words or ("-c", code))],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


def interrupted_at(name, folder, handler="signal.default_int_handler"):
    """Run a command with Ctrl-C during the import of a module, optionally with Ctrl-C ignored by the shell."""
    return python(INTERRUPTED.format(name=name, words=WORDS, handler=handler), folder)


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """Return the modules that a command imports, in order, after the package and what `main` needs."""
    code = f"import sys, signal, sweep.cli; before = {{*sys.modules}}; sys.argv = ['eulerdisk', *{WORDS}]\n"
    code += "try: sweep.cli.main()\n"
    code += "finally: print(*(each for each in sys.modules if each not in before), file=sys.stderr)"
    found = python(code, tmp_path_factory.mktemp("imported")).stderr.splitlines()[-1].split()
    assert len(found) > 100
    return [each for each in found if each != "builtins"]


@pytest.mark.slow_lane
def test_an_interrupt_while_modules_are_imported(imported, tmp_path):
    """Ctrl-C during any of six imports gives no traceback, one line and status 130."""
    places = {round(i * (len(imported) - 1) / 5) for i in range(6)}
    for name in [imported[place] for place in sorted(places)]:
        done = interrupted_at(name, tmp_path)
        assert (name, done.returncode, done.stderr) == (name, 130, TOLD)


@pytest.mark.parametrize("name", ["typer", "sweep.request.spec"])
def test_who_ignores_interrupts_goes_on(name, tmp_path):
    """A background process, for which the shell ignores Ctrl-C, continues."""
    done = interrupted_at(name, tmp_path, "signal.SIG_IGN")
    assert done.returncode == 0
    assert "160200" in done.stdout
    assert done.stderr == ""


def test_an_interrupt_while_text_is_executed(tmp_path):
    """`dataclasses` executes text, during which ``python -m`` would exit as if the interrupt were not caught."""
    code = """
import sys
from sweep import cli

def parser(words):
    exec("raise KeyboardInterrupt")

cli.parser = parser
sys.argv = ["eulerdisk", "plan", "rolling"]
cli.main()
"""
    (tmp_path / "program.py").write_text(code)
    done = python("", tmp_path, "-m", "program")
    assert (done.returncode, done.stderr) == (130, TOLD)


def test_a_program_that_calls_the_command_line_has_its_interrupts_back(command):
    """After a call of the command line, a program has its own handling of Ctrl-C again."""
    before = signal.getsignal(signal.SIGINT)
    assert command("--version")[0] == 0
    assert signal.getsignal(signal.SIGINT) is before
