import os
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest
from messages import assert_facts, refused

import sweep
from sweep.figures import plots

CHECKOUT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def atlas():
    """Return a small atlas whose figure has hatching, both edges and a strip."""
    spec = sweep.SweepSpec.preset("circling")
    return sweep.run(spec.replace(tilt="1deg:30deg:20", precession_rate="0.05:5:31", duration="3s"))


@pytest.mark.slow_lane
@pytest.mark.parametrize(
    ("ending", "magic"), [("png", b"\x89PNG\r\n"), ("pdf", b"%PDF-1."), ("svg", b"<?xml")]
)
def test_same_atlas_same_bytes(atlas, tmp_path, monkeypatch, ending, magic):
    """Drawing twice, on different days, gives the same file and no others."""
    for name, day in (("first", "0"), ("second", "86400")):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", day)
        plots.save(plots.figure([atlas]), tmp_path / f"{name}.{ending}")
    first, second = ((tmp_path / f"{name}.{ending}").read_bytes() for name in ("first", "second"))
    assert first.startswith(magic)
    assert first == second
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"first.{ending}", f"second.{ending}"]


def test_failed_save_leaves_the_old_figure(atlas, tmp_path, monkeypatch):
    """A figure that fails halfway leaves the old file and no temporary file."""
    path = tmp_path / "figure.png"
    path.write_text("old")
    drawn = plots.figure([atlas])

    def fail(unfinished, **_):
        Path(unfinished).write_text("half")
        raise OSError("disk full")

    monkeypatch.setattr(drawn, "savefig", fail)
    with refused("disk full"):
        plots.save(drawn, path)
    assert [each.name for each in tmp_path.iterdir()] == ["figure.png"]
    assert path.read_text() == "old"


def test_a_figure_has_the_dots_that_were_asked_for(atlas, tmp_path):
    """The PNG header has the figure's size in inches times the dots per inch."""
    drawn = plots.figure([atlas])
    for dpi in (50, 120):
        plots.save(drawn, tmp_path / f"{dpi}.png", dpi)
        head = (tmp_path / f"{dpi}.png").read_bytes()[16:24]
        dots = [int.from_bytes(head[:4]), int.from_bytes(head[4:])]
        assert dots == pytest.approx([side * dpi for side in drawn.get_size_inches()], abs=1.0)


@pytest.mark.slow_lane
def test_missing_folder(atlas, tmp_path):
    """A folder that does not exist is named in the refusal."""
    with refused("absent", "mkdir -p"):
        plots.save(plots.figure([atlas]), tmp_path / "absent" / "figure.png")


@pytest.mark.slow_lane
def test_no_global_state(atlas):
    """Drawing does not load pyplot or change settings."""
    before = dict(matplotlib.rcParams)
    plots.figure([atlas])
    assert dict(matplotlib.rcParams) == before
    script = "import sys, sweep; from sweep.figures import plots; print('matplotlib.pyplot' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=CHECKOUT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"


@pytest.mark.slow_lane
def test_script_draws_what_it_is_given(atlas, tmp_path):
    """scripts/plot_boundaries.py draws atlas files into one figure; a bad request exits with 2 and a message."""
    sweep.save(atlas, tmp_path / "rolling.nc")
    command = [
        sys.executable,
        str(CHECKOUT / "scripts" / "plot_boundaries.py"),
        str(tmp_path / "rolling.nc"),
        "-o",
    ]
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    done = subprocess.run([*command, str(tmp_path / "b.png")], env=environment, check=False)
    assert done.returncode == 0
    assert (tmp_path / "b.png").stat().st_size > 10_000
    refused = subprocess.run(
        [*command, "b.jpg"], env=environment, check=False, capture_output=True, text=True
    )
    assert refused.returncode == 2
    assert_facts(refused.stderr, ".png", ".pdf", ".svg")


@pytest.mark.slow_lane
def test_a_refined_atlas_is_drawn():
    """Curves are not axes: an atlas with a refined boundary is still one map, and a further axis makes two."""
    spec = sweep.SweepSpec.preset("rolling").replace(
        roll_rate="2:3:5", tilt="0.1deg:1deg:4", boundary="refined:1e-6"
    )
    atlas = sweep.run(spec)
    assert "curve_point" in atlas.dims
    assert len([axes for axes in plots.figure([atlas]).axes if axes.get_title(loc="left")]) == 1
    two = plots.figure([sweep.run(spec.replace(alpha=[0.5, 1.0]))])
    titles = [axes.get_title(loc="left") for axes in two.axes]
    assert [title for title in titles if title] == [r"$\alpha = 0.5$", r"$\alpha = 1$"]
