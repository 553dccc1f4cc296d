"""Systems in Python: the decorator reads the source of a function, which can still be called with numbers."""

import math
import subprocess
import sys
from pathlib import Path

import pytest
from messages import assert_facts, refused

from sweep.errors import RequestError
from sweep.request.system_file import read_system_file
from sweep.systems import System, cos, pi, sin, system

FILE = Path(__file__).parent / "request" / "systems" / "five.py"
STIFFNESS = 3.0


def test_a_file_that_is_imported_has_the_systems_that_are_read():
    """Importing and reading a file give the same definitions, including their text."""
    space = {}
    exec(compile(FILE.read_text(encoding="utf-8"), str(FILE), "exec"), space)
    for name in ("driven_pendulum", "duffing", "magnetic_pendulum", "henon_heiles", "kapitza"):
        assert space[name].definition == read_system_file(FILE, name)


def test_constants_of_the_module_and_of_a_function_around_it():
    """They become numbers of the system; an argument of the same name takes precedence."""
    width = 0.25
    pi_is_known = pi

    @system(duration="10", ends={"far": "x > STIFFNESS"})
    def spring(x=STIFFNESS / 2, v=0.0, *, damping=0.1):
        """A spring."""
        return v, -STIFFNESS * x - damping * v + width * sin(pi * x)

    assert isinstance(spring, System)
    assert (spring.__name__, spring.__doc__) == ("spring", "A spring.")
    assert pi_is_known == math.pi
    x, v = 0.3, 0.2
    expected = (v, -3.0 * x - 0.1 * v + 0.25 * math.sin(math.pi * x))
    assert spring(x, v) == pytest.approx(expected, rel=1e-15)
    assert spring(x, v=v, damping=0.1, t=5.0) == spring(x, v)
    assert spring()[1] == pytest.approx(-4.5 + 0.25 * math.sin(1.5 * math.pi))
    assert repr(spring) == "<system spring of x, v>"
    for given, named in (((1.0, 2.0, 3.0), {}), ((), {"mass": 1.0}), ((1.0,), {"x": 1.0})):
        with refused("spring", "x, v", error=TypeError):
            spring(*given, **named)


def test_a_time_of_the_motion():
    """The time is 0 unless given."""

    @system(duration="10")
    def driven(v=0.0, *, t):
        return cos(2 * t)

    assert driven() == (1.0,)
    assert driven(t=0.3) == (math.cos(0.6),)


def test_what_is_refused_has_the_line_of_this_file():
    """The decorator raises immediately, even on a function inside a test."""
    first = test_what_is_refused_has_the_line_of_this_file.__code__.co_firstlineno
    with refused("duration") as caught:

        @system(ends={})
        def falling(x=1.0):
            return -x

    assert str(caught.value).startswith(f"test_systems.py, line {first + 5}: ")
    with refused("kink"):

        @system(duration="10")
        def bent(x=1.0):
            return -abs(x)

    with refused("@system", "duration"):

        @system
        def bare(x=1.0):
            return -x


@pytest.mark.parametrize("value", [3, print, type("thing", (), {}), lambda x: x])
def test_what_is_no_function_with_a_source(value):
    """A number, a built-in, a class and a lambda are refused."""
    with pytest.raises(RequestError):
        system(duration="10")(value)


def test_a_source_that_cannot_be_found():
    """Code from a string has no source."""
    text = "from sweep.systems import system\n@system(duration='1')\ndef f(x=1.0):\n    return -x\n"
    with refused("source"):
        exec(compile(text, "<nowhere>", "exec"), {})


@pytest.mark.slow_lane
def test_in_a_notebook(tmp_path):
    """A system in an IPython cell uses constants of earlier cells; a refusal names the cell's line."""
    cells = (
        "from sweep.systems import system, sin; g = 9.81\n",
        "@system(duration='10')\ndef falling(v=0.0, *, drag=0.1):\n    return g - drag*v\n\nprint(falling(1.0))\n",
        "@system(duration='10')\ndef falling(v=0.0):\n    return g - drag*v\n",
    )
    script = tmp_path / "cells.py"
    script.write_text(
        "from IPython.core.interactiveshell import InteractiveShell\nshell = InteractiveShell()\n"
        f"for cell in {cells!r}:\n    done = shell.run_cell(cell)\nprint(done.error_in_exec)\n",
        encoding="utf-8",
    )
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, check=True, cwd=FILE.parents[3],
        env={"PYTHONPATH": str(FILE.parents[3]), "HOME": str(tmp_path), "PATH": ""},
    )  # fmt: skip
    assert "(9.71,)" in done.stdout
    assert_facts(done.stdout, "this cell, line 3", "drag")
