"""The README works: these tests execute every command and snippet in it."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

_ROOT = Path(__file__).parents[2]
_TEXT = (_ROOT / "README.md").read_text(encoding="utf-8")


def _blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", _TEXT, flags=re.MULTILINE | re.DOTALL)


def _commands(block: str) -> list[str]:
    return [line.split("#")[0].strip() for line in block.splitlines() if line.strip()]


def _run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_readme_is_short():
    """The README has at most 90 lines, and its Python at most ten."""
    assert len(_TEXT.splitlines()) <= 90
    assert len([line for line in _blocks("python")[0].splitlines() if line]) <= 10


def test_readme_links_lead_somewhere():
    """Every relative link and picture of the README points to a file of the project, or a heading in one."""
    for target in re.findall(r"\]\(([^)]+)\)", _TEXT):
        file, _, anchor = target.partition("#")
        assert (_ROOT / file).is_file(), target
        if anchor:
            headings = re.findall(r"^#+ (.+)$", (_ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in {heading.lower().replace(" ", "-") for heading in headings}, target


def test_every_block_is_known():
    """These tests cover every block of the README; its languages are bash, python, and text for output."""
    assert set(re.findall(r"^```(\w*)$", _TEXT, flags=re.MULTILINE)) <= {"bash", "python", "text", ""}
    assert [len(_blocks(language)) for language in ("bash", "python", "text")] == [2, 2, 1]


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_atlas_command(tmp_path):
    """`scripts/atlas` writes its five files and ends with the table shown in the README."""
    assert _commands(_blocks("bash")[0]) == ["scripts/atlas", "scripts/test"]
    done = _run([str(_ROOT / "scripts" / "atlas")], tmp_path)
    assert done.returncode == 0, done.stderr
    made = {path.name for path in (tmp_path / "atlas-out").iterdir()}
    assert made == {"rolling.nc", "spinning.nc", "circling.nc", "boundaries.png", "regimes.png"}
    assert done.stdout.startswith(_blocks("text")[0])


def test_test_command_explains_itself(tmp_path):
    """`scripts/test`, which may be running this test, explains itself with --help."""
    done = _run([str(_ROOT / "scripts" / "test"), "--help"], tmp_path)
    assert done.returncode == 0
    assert "ruff, mypy" in done.stdout


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_command_line(tmp_path):
    """Every command of the second block runs, in order, and writes the file that it names.

    The explorer runs until stopped: tests/promises/test_pages.py starts and stops it.
    """
    commands = _commands(_blocks("bash")[1])
    assert "eulerdisk explore" in commands
    for line in commands:
        if line == "eulerdisk explore":
            continue
        command = shlex.split(line)
        done = _run(command, tmp_path)
        assert done.returncode == 0, (line, done.stderr)
        if "-o" in command:
            assert (tmp_path / command[command.index("-o") + 1]).stat().st_size > 0


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_a_system_of_ones_own(tmp_path):
    """The second Python block runs as a file and prints the boundary in its comment, within a grid step."""
    script = tmp_path / "readme.py"
    script.write_text(_blocks("python")[1])
    done = _run([sys.executable, "-W", "error", str(script)], tmp_path)
    assert done.returncode == 0, done.stderr
    measured = float(re.search(r"boundary_shake: (\S+) rad s-1", done.stdout)[1])
    assert measured == pytest.approx(99.05, abs=100.0 / 49.0)


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_python_block(tmp_path):
    """The Python block runs without warnings: a hoop at 1/4, and a toy that stops as on the command line."""
    done = _run([sys.executable, "-W", "error", "-c", _blocks("python")[0]], tmp_path)
    assert done.returncode == 0, done.stderr
    peak, rate, seconds = map(float, done.stdout.splitlines())
    assert 0.1 < peak < 1.5
    # A departure of 5 deg moves the boundary by 5/6 * 0.0873^2 = 0.6 %, a grid step of 0.0025 rad/s by 0.1 %.
    assert rate == pytest.approx(0.25, rel=0.01)
    assert seconds == pytest.approx(5.04, abs=0.01)
