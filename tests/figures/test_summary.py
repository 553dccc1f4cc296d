"""The short summary of an atlas: its numbers are those of the dataset, and it never raises."""

import re
import subprocess
import sys

import numpy as np
import pytest
from messages import assert_facts, assert_in_order

import sweep
from sweep.figures.summary import as_html, as_text

ROLLING = {"roll_rate": "2:4:21", "tilt": "0.1deg:20deg:12:log"}


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas of three axes."""
    return sweep.run("rolling", alpha="0.3,0.5,1", **ROLLING)


def line(text, label):
    """Return the rest of the line that begins with a label."""
    (found,) = re.findall(rf"^{label} +(.*)$", text, flags=re.MULTILINE)
    return found


def test_the_axes_are_named_with_their_values(atlas):
    """The summary gives count, ends, unit and spacing of each axis, and the product of the sizes."""
    text = as_text(atlas)
    assert_in_order(line(text, "grid"), "21 x 12 x 3", "756 cells")
    assert_in_order(line(text, " +roll_rate"), "21", "2 to 4 rad s-1")
    assert_in_order(line(text, " +tilt"), "12", "0.1 to 20 deg", "logarithmic")
    assert "logarithmic" not in line(text, " +roll_rate")
    assert_in_order(line(text, " +alpha"), "3", "0.3 to 1")
    assert_facts(line(text, "fixed"), "radius 0.5 m", "gravity 9.81 m s-2")


def test_a_boundary_of_another_kind_is_not_held_against_the_limit(atlas):
    """For another criterion, the analytic limit is given without a distance, because the two are not related."""
    text = as_text(sweep.reclassify(atlas, "peak_tilt > 10deg"))
    assert "boundary_roll_rate" in text
    (told,) = re.findall(r".*\banalytic\b.*", text)
    assert re.search(r"\d", told)
    assert "%" not in told


def test_the_boundary_is_held_against_theory(atlas):
    """The summary gives the largest relative distance from the analytic and the predicted line over known rows."""
    text = as_text(atlas)
    measured = atlas["boundary_roll_rate"].values
    there = np.isfinite(measured)
    assert_facts(line(text, "boundary"), f"{there.sum()} of 36 rows", "roll_rate")
    for name, word in (("predicted", "predicted"), ("critical", "analytic")):
        theory = atlas[f"{name}_roll_rate"].values
        (stated,) = re.findall(rf"\b{word}\b.* ([\d.]+) %", text)
        largest = max(abs(a / b - 1) for a, b in zip(measured[there], theory[there], strict=True))
        assert float(stated) == pytest.approx(100 * largest, rel=0.06)


def test_a_boundary_below_theory_deviates_too(atlas):
    """A boundary a tenth below the analytic limit and one a tenth above it are both 10 % away."""
    for factor in (0.9, 1.1):
        moved = atlas.assign(boundary_roll_rate=factor * atlas["critical_roll_rate"])
        assert re.search(r"\banalytic\b.* 10 %", as_text(moved)), factor


def test_random_starts_have_a_share_and_no_map():
    """Random starts have a share of unstable starts with its interval instead of a boundary."""
    starts = sweep.run("rolling", roll_rate="uniform:2:4", tilt="normal:1deg:0.2deg", samples=50, seed=7)
    text = as_text(starts)
    assert line(text, "grid") == "50 starts"
    assert_facts(line(text, "unstable"), "50 starts", "95 %")
    assert "<svg" not in as_html(starts)


def test_a_plane_has_a_map():
    """Only an atlas with two axes has a map; a single cell is called "one cell"."""
    for words, has_map in (
        (ROLLING, True),
        ({"roll_rate": 3.0, "tilt": "0.1deg:20deg:12"}, False),
        ({"roll_rate": "2:4:5", "tilt": "1deg"}, False),
        ({"roll_rate": 3.0, "tilt": 0.1}, False),
    ):
        found = sweep.run(sweep.SweepSpec(**words))
        page = as_html(found)
        assert ("<svg" in page) == has_map, words
        assert ("one cell" in page) == (found["ending"].size == 1), words


def test_rows_of_a_boundary_are_counted():
    """The known rows of a boundary are counted only if there are at least two rows."""
    for tilts, counted in (("1deg,2deg", ["2 of 2 rows", "roll_rate"]), ("1deg", [])):
        told = line(as_text(sweep.run(sweep.SweepSpec(roll_rate="2:4:9", tilt=tilts))), "boundary")
        assert_facts(told, "rad s-1", *counted)
        assert ("rows" in told) == bool(counted), tilts


def test_the_map_is_a_plane_of_the_atlas(atlas):
    """The rate is drawn upward; for a third axis, one value is shown and named."""
    page = as_html(atlas)
    assert_facts(page, "alpha = 0.5")
    labels = re.findall(r"<text[^>]*>(\w+)</text>", page)
    assert labels == ["tilt", "roll_rate"]
    assert page.count("<polyline") >= 2


def test_a_selection_or_a_changed_atlas_is_summed_up_too(atlas):
    """Selections and modified atlases have a summary without errors."""
    for changed in (
        atlas.isel(alpha=0),
        atlas.isel(alpha=0, tilt=slice(2)),
        atlas.isel(roll_rate=0, tilt=0),
        atlas.drop_vars(["tilt"]),
        atlas.drop_vars(["boundary_roll_rate", "critical_roll_rate"]),
        atlas.assign_attrs(sweep_spec="{}"),
        atlas.where(atlas["alpha"] > 0.4),
    ):
        assert as_text(changed).startswith("eulerdisk  ")
        assert as_html(changed).startswith("<div")


@pytest.mark.slow_lane
def test_a_summary_does_not_load_matplotlib():
    """The summary does not load matplotlib, so it appears at once."""
    code = (
        "import sys, sweep; atlas = sweep.run('rolling', roll_rate='2:4:5', tilt='1deg:2deg:3');"
        "atlas.eulerdisk._repr_html_(); repr(atlas.eulerdisk); print('matplotlib' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
