"""docs/explore.md: its commands and its Python run; docs/explorer.md: its limits are those of the code."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from explorer_client import ask

import sweep
from sweep.explorer import export, lines, motion, server, view, window, window_files

CHECKOUT = Path(__file__).resolve().parents[2]
HOWTO, PAGE = (
    (CHECKOUT / "docs" / name).read_text(encoding="utf-8") for name in ("explore.md", "explorer.md")
)

pytestmark = pytest.mark.compiled


def blocks(language):
    """Return the blocks of the page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", HOWTO, flags=re.MULTILINE | re.DOTALL)


def test_its_commands_run(tmp_path):
    """Each command prints an address that is answered, or writes the page that it names."""
    sweep.run_to_file("rolling", tmp_path / "hoop.nc", alpha=1, roll_rate="1:4:9", tilt="1deg:5deg:8")
    (block,) = blocks("bash")
    for line in block.splitlines():
        program, *words = shlex.split(line, comments=True)
        assert program == "eulerdisk"
        command = [sys.executable, "-m", "sweep", *words]
        if "--export" in words:
            subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
            assert (tmp_path / words[-1]).stat().st_size > 1e6
            continue
        with subprocess.Popen(
            [*command, "--no-browser"], cwd=tmp_path, stdout=subprocess.PIPE, text=True
        ) as running:
            url = running.stdout.readline().strip()
            assert ask(url).status == 200
            running.send_signal(2)
        assert running.returncode == 0


def test_its_python_runs(capsys):
    """The example prints the address of a page, which is answered no more after the block."""
    (block,) = blocks("python")
    exec(compile(block, "docs/explore.md", "exec"), {})
    (url,) = capsys.readouterr().out.split()
    with pytest.raises(ConnectionError):
        ask(url)


@pytest.mark.parametrize(
    ("said", "is_so"),
    [
        ("at most 64 KiB and ten seconds", server.MOST_BYTES == 65536 and server.ARRIVAL == 10.0),
        ("a window at most four million pixels", window.MOST_PIXELS == 4_000_000),
        ("128 connections", server.MOST_CONNECTIONS == 128),
        ("CSV, netCDF, up to a million", window_files.MOST_CELLS == 1_000_000),
        ("4000 of its own units of time", motion._UNITS == 4000.0),
        ("`method=exact`; up to a million", export.MOST_CELLS == 1_000_000),
        ("grid of 96 x 72 exact cells", lines.COARSE == (96, 72)),
        ("a pixel is 8 units in the last place wide", view.ULPS == 8),
        ("listens at 127.0.0.1 alone", server.HOST == "127.0.0.1"),
    ],
)
def test_its_limits_are_those_of_the_code(said, is_so):
    """Every number of the page that the code has too is the same there."""
    assert said in " ".join(PAGE.split())
    assert is_so
