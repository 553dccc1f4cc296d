"""docs/figures.md and figure-options.md: commands and Python run as printed, and every option is named."""

import re
from pathlib import Path

import pytest
from matplotlib import pyplot
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import sweep

CHECKOUT = Path(__file__).resolve().parents[2]
PAGE = "".join(
    (CHECKOUT / "docs" / name).read_text(encoding="utf-8") for name in ("figures.md", "figure-options.md")
)


def blocks(language):
    """Return the lines of the blocks of code in a language."""
    return [
        line
        for block in re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
        for line in block.splitlines()
    ]


@pytest.mark.compiled
def test_its_commands_run(command, tmp_path):
    """Every command of the page writes its figure."""
    small = "tilt=0.1deg:4deg:9 roll_rate=2:4:12"
    assert command(f"run rolling {small} -o rolling.nc")[0] == 0
    assert command(f"run rolling {small} alpha=0.2,0.5,1 -o alphas.nc")[0] == 0
    toy = "tilt=60deg:85deg:6 contour_friction=1um:30um:7:log rolling_friction=15um precession_rate=wobble"
    assert command(f"run toy {toy} -o toy.nc")[0] == 0
    lines = blocks("bash")
    assert len(lines) >= 8
    for line in lines:
        program, _, words = line.partition(" ")
        status, _, err = command(words)
        assert (program, status) == ("eulerdisk", 0), (line, err)
        assert (tmp_path / words.rpartition(" ")[2]).stat().st_size > 5_000


@pytest.mark.compiled
def subplots(**words):
    """Do what `pyplot.subplots` does, for a figure that needs no screen."""
    drawn = Figure(**words)
    FigureCanvasAgg(drawn)
    return drawn, drawn.subplots()


def test_its_python_runs(monkeypatch, tmp_path):
    """Every line of Python runs, given an atlas."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(pyplot, "subplots", subplots)
    names = {"atlas": sweep.run(sweep.SweepSpec(tilt="0.1deg:4deg:9", roll_rate="2:4:12"))}
    for line in blocks("python"):
        exec(line, names)
    assert (tmp_path / "column.pdf").stat().st_size > 5_000
    assert names["ax"].has_data()
    assert names["figure"].get_layout_engine() is not None


def test_it_names_every_option(command):
    """Each option of the command stands on the page, and each word of `.plot` too."""
    from sweep.accessor import Eulerdisk

    _, out, _ = command("plot --help")
    options = set(re.findall(r"--[a-z][a-z-]+", out)) - {"--help", "--output", "--regimes"}
    assert len(options) >= 10
    assert [option for option in options if f"`{option}`" not in PAGE] == []
    words = set(Eulerdisk.plot.__annotations__) - {"return"}
    assert [word for word in words if not re.search(rf"`{word}(=True)?`", PAGE)] == []
