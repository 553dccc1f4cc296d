"""The gallery shows every figure with the command that makes it."""

import importlib.util
import re
import sys
from pathlib import Path

import lossy_runner
import numpy as np
import pytest
from figure_words import watched

import sweep
from sweep.figures import plots

CHECKOUT = Path(__file__).resolve().parents[2]


def script(name):
    """Return a script as a module."""
    spec = importlib.util.spec_from_file_location(name, CHECKOUT / "scripts" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    # Dataclasses look up their module.
    sys.modules[name] = module
    spec.loader.exec_module(module)
    del sys.modules[name]
    return module


GALLERY = script("make_gallery")
#: Figures that the program makes itself; the words of a film are in its frames.
OWN = [
    each
    for each in GALLERY.ENTRIES
    if all(words.startswith("python -m sweep ") for words in each.commands) and each.files[0].endswith("png")
]


@pytest.fixture(scope="module")
def gallery():
    """Return scripts/make_gallery.py as a module."""
    return GALLERY


@pytest.fixture(autouse=True)
def words_have_their_places():
    """Check that no word in any saved figure is cut, outside the sheet or on top of another."""
    with watched() as noted:
        yield
    assert [each for each in noted if each[1]] == []


def coarse(words):
    """Return a gallery command for fewer cells, with the same words on the figure."""
    return re.sub(r":\d{2,3}(?=:log| )", ":9", words).replace("samples=2e4", "samples=200")


@pytest.mark.release
@pytest.mark.compiled
@pytest.mark.parametrize("entry", OWN, ids=lambda entry: entry.files[0])
def test_the_words_of_a_coarse_figure_have_their_places(command, tmp_path, entry):
    """Each command runs on a coarse grid; the fixture checks what it draws."""
    with lossy_runner.general_kernels():
        for words in entry.commands:
            line = coarse(words.removeprefix("python -m sweep ").format(folder=tmp_path))
            status, _, told = command(line)
            assert status == 0, told


def figures_of(text):
    """Return the figure files that a page shows."""
    return re.findall(r"!\[[^]]*\]\(([^)]+)\)", text)


def test_the_page_is_what_the_script_writes(gallery):
    """docs/gallery.md equals the script's page; with examples.md it shows every figure in docs/.

    The explorer's pictures come from a browser: scripts/record_explorer.py takes them.
    """
    docs = CHECKOUT / "docs"
    assert (docs / "gallery.md").read_text(encoding="utf-8") == gallery.page()
    examples = figures_of((docs / "examples.md").read_text(encoding="utf-8"))
    assert examples == [each.files[0] for each in gallery.ENTRIES if not each.caption]
    assert {*figures_of(gallery.page()), *examples} == {
        str(path.relative_to(docs))
        for ending in ("png", "gif")
        for path in docs.rglob(f"*.{ending}")
        if "atlases" not in path.parts and not path.stem.startswith("explorer")
    }


def test_every_figure_is_there_and_small(gallery):
    """All figures are in docs/ and under 400 kB, and the page shows those with a caption."""
    assert figures_of(gallery.page()) == [
        file for each in gallery.ENTRIES if each.caption for file in each.files
    ]
    files = [file for each in gallery.ENTRIES for file in each.files]
    assert all((CHECKOUT / "docs" / name).stat().st_size < 400_000 for name in files)


def test_every_command_names_a_script(gallery):
    """The page's commands run existing scripts or the package, and the last one writes the figures."""
    for entry in gallery.ENTRIES:
        for command in entry.commands:
            words = command.split()
            assert words[:3] == ["python", "-m", "sweep"] or (CHECKOUT / words[1]).is_file()
        folders = {f"{{folder}}/{file}".rpartition("/")[0] for file in entry.files}
        assert {entry.commands[-1].split()[-1]} in ({f"{{folder}}/{entry.files[0]}"}, folders) or (
            f"--plot {{folder}}/{entry.files[0]}" in entry.commands[-1]
            or f"--animate {{folder}}/{entry.files[0]}" in entry.commands[-1]
        )


@pytest.mark.release
@pytest.mark.compiled
def test_the_map_of_steady_motions(tmp_path):
    """Coarse maps draw; beyond the predicted offset no verdict contradicts the sign of k."""
    steady = script("plot_steady_map")
    coarse = {"tilt": "-85deg:85deg:35"}
    atlases = {
        name: steady.compute(
            name, **coarse, **{axis: words.replace(":240", ":24") for axis, words in each.items()}
        )
        for name, each in steady.MAPS.items()
    }
    for name, atlas in atlases.items():
        assert " 0 of them contradict the sign of k" in steady.describe_agreement(atlas), name
    drawn = steady.figure(atlases)
    # Marks at the critical rates, which are roots.
    marks = [each.get_text() for axes in drawn.axes for each in axes.texts if "\n" in each.get_text()]
    assert marks == ["spinning\n$\\sqrt{4g/5R}$", "rolling\n$\\sqrt{g/3R}$"]
    plots.save(drawn, tmp_path / "steady.pdf")


@pytest.mark.release
@pytest.mark.compiled
def test_the_family_of_disks(tmp_path, monkeypatch):
    """A coarse three-axis atlas draws; the hoop is unstable up to 19.20 deg, the disk to 18.62 (theory.md)."""
    alphas = script("plot_alphas")
    monkeypatch.setitem(alphas.SPEC, "precession_rate", "0.3:5:41")
    monkeypatch.setitem(alphas.SPEC, "tilt", "2deg:20deg:19")
    monkeypatch.setitem(alphas.SPEC, "alpha", "0.5,1")
    atlas = sweep.run(sweep.SweepSpec(**alphas.SPEC))
    found = alphas.curves(atlas)
    most = [max(np.degrees(each["tilt"]).max() for a, each in found if a == alpha) for alpha in (0.5, 1.0)]
    # A criterion of 20 times the kick adds 0.04 deg; the grid of rates subtracts a little.
    assert most == pytest.approx([18.62, 19.20], abs=0.1)
    plots.save(alphas.figure(atlas), tmp_path / "alphas.pdf")


@pytest.mark.release
@pytest.mark.compiled
def test_the_bifurcation_diagram(tmp_path):
    """A disk trapped on one side drifts in a ring; one that passes upright does not."""
    diagram = script("plot_bifurcation")
    plots.save(diagram.figure(), tmp_path / "bifurcation.pdf")
    trapped, drift = diagram.family(0.45, 0.0, np.radians([38.0, 50.0]))
    assert trapped.tolist() == [True, False]
    assert drift.radius[0] < 3.0
    # Its swings to both sides turn it back and forth by the same angle.
    assert drift.turn[1] == pytest.approx(0.0, abs=1e-8)
    assert drift.advance[1] > 1.0
