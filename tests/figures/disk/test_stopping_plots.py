"""The figure of a motion with losses shows exactly the stored data."""

import math
import re

import numpy as np
import pytest
from matplotlib.colors import to_hex
from messages import assert_facts, refused, with_facts

import sweep
from sweep.checks.explain import explain
from sweep.figures import plots
from sweep.figures.disk import stopping_plots
from sweep.figures.disk.losses_map import COLOURS
from sweep.motion.theory import flat_time

pytestmark = pytest.mark.compiled

#: Panels of the figure of a wobble.
PICTURE, TILT, RATES, LEDGER, APPROACH, SPEEDING_UP = range(6)


@pytest.fixture(scope="module")
def toy():
    """Return the toy that wobbles from 80 deg until it is flat."""
    return sweep.simulate("toy", tilt="80deg", title="The toy")


@pytest.fixture(scope="module")
def rolling():
    """Return a coin that still rolls at the end of the duration."""
    return sweep.simulate("coin", roll_rate=40, rolling_friction="10um", duration="2s")


def lines_of(axes):
    """Return the lines of a panel by label."""
    return dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))


@pytest.mark.slow_lane
def test_tilt_and_rates_are_those_of_the_file(toy, rolling):
    """A wobble has panels of inclination, wobble rate and disk rate; a rolling disk has tilt and rates."""
    axes = stopping_plots.figure(toy).axes
    (line,) = axes[TILT].lines
    np.testing.assert_array_equal(line.get_xdata(), toy["elapsed_time"])
    np.testing.assert_allclose(line.get_ydata(), 90.0 - np.degrees(toy["tilt"]), atol=1e-12)
    assert_facts(line.get_label(), "flat", f"{float(toy['end_time']):.6g} s")
    fast, slow = axes[RATES].lines
    np.testing.assert_array_equal(fast.get_ydata(), toy["precession_rate"])
    vertical = toy["precession_rate"] + toy["roll_rate"] * np.sin(toy["tilt"])
    np.testing.assert_allclose(slow.get_ydata(), vertical, atol=1e-12)
    axes = stopping_plots.figure(rolling).axes
    np.testing.assert_array_equal(axes[TILT].lines[0].get_ydata(), np.degrees(rolling["tilt"]))
    assert_facts(axes[TILT].lines[0].get_label(), "not", "end")
    np.testing.assert_array_equal(axes[RATES].lines[1].get_ydata(), rolling["roll_rate"])


@pytest.mark.slow_lane
def test_the_areas_of_the_ledger_are_the_losses(toy):
    """The losses are stacked in the file's order and colors; with the remaining energy they add up to the start."""
    axes = stopping_plots.figure(toy).axes[LEDGER]
    assert_facts(axes.get_ylabel(), "energy", "(mJ)")
    below = np.zeros(toy.sizes["elapsed_time"])
    for area, name in zip(axes.collections, ("contour_loss", "air_loss", "energy"), strict=True):
        vertices = area.get_paths()[0].vertices
        above = below + 1e3 * toy[name].values
        assert vertices[:, 1].max() == pytest.approx(above.max(), rel=1e-9)
        for moment in (0.1, 0.5, 0.9):
            index = int(moment * below.size)
            time = float(toy["elapsed_time"][index])
            here = np.unique(vertices[vertices[:, 0] == time, 1])
            np.testing.assert_allclose(here, [below[index], above[index]], rtol=1e-9)
        if name != "energy":
            assert to_hex(area.get_facecolor()[0]) == COLOURS[name].lower()
        below = above
    np.testing.assert_allclose(below, 1e3 * float(toy["energy"][0]), rtol=1e-6)
    (whole,) = axes.lines
    assert whole.get_ydata()[0] == pytest.approx(1e3 * float(toy["energy"][0]))
    labels = axes.get_legend_handles_labels()[1]
    lost = {name: float(toy[name][-1]) for name in ("contour_loss", "air_loss")}
    share = lost["contour_loss"] / sum(lost.values())
    assert with_facts(labels, "contour friction", "15 \u00b5m", f"{100.0 * share:.0f} %")
    assert with_facts(labels, "air", "Bildsten", f"{100.0 - 100.0 * share:.0f} %")


@pytest.mark.slow_lane
def test_the_end_is_drawn_against_the_time_that_is_left(toy):
    """Near the end, both axes are logarithmic; each law has a guide with the named slope next to the curve."""
    for panel, name, times in ((APPROACH, "inclination", 1.0), (SPEEDING_UP, "precession_rate", -0.5)):
        axes = stopping_plots.figure(toy).axes[panel]
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
        lines = lines_of(axes)
        curve = lines.pop("motion")
        left, scale = (
            flat_time(toy) - toy["elapsed_time"].values,
            math.degrees(1.0) if name == "inclination" else 1.0,
        )
        np.testing.assert_allclose(curve.get_xdata(), left)
        np.testing.assert_allclose(curve.get_ydata(), scale * toy[name].values)
        slopes = {"contour friction": (2 / 3, "contour_loss"), "air": (4 / 9, "air_loss")}
        laws = {law: with_facts(lines, "slope", law) for law in slopes}
        assert len(lines) == 2
        assert sorted(label for labels in laws.values() for label in labels) == sorted(lines)
        for law, (slope, measure) in slopes.items():
            (label,) = laws[law]
            line = lines[label]
            (x0, x1), (y0, y1) = line.get_xdata(), line.get_ydata()
            assert math.log(y1 / y0) / math.log(x1 / x0) == pytest.approx(times * slope, rel=1e-12)
            (number,) = re.findall(r"\u2212?\d[\d/.]*", label)
            assert eval(number.replace("\u2212", "-")) == pytest.approx(times * slope)
            assert to_hex(line.get_color()) == COLOURS[measure].lower()
            near = (left <= x1) & (left >= x0)
            beside = np.interp(left[near], [x0, x1], [y0, y1]) / (scale * toy[name].values[near])
            assert 1.0 < beside.min() < 2.0
        # friction at the contact is largest at first, and air at the end
        middle = {law: np.mean(np.log(lines[label].get_xdata())) for law, (label,) in laws.items()}
        assert middle["contour friction"] > middle["air"]


@pytest.mark.slow_lane
def test_a_law_that_the_motion_has_not_is_not_drawn():
    """A motion with only one law has one guide and one area, for every law."""
    motion = sweep.simulate(
        inclination="5deg",
        precession_rate="wobble",
        roll_rate="wobble",
        rolling_friction="50um",
        radius=0.0375,
    )
    axes = stopping_plots.figure(motion).axes
    for panel, slope in ((APPROACH, "2"), (SPEEDING_UP, "\u22121")):
        labels = [*lines_of(axes[panel])]
        assert (len(labels), "motion" in labels) == (2, True)
        assert with_facts(labels, "slope", slope, "rolling friction")
    assert len(axes[LEDGER].collections) == 2


@pytest.mark.slow_lane
def test_what_is_no_wobble_has_no_panels_of_its_end(tmp_path):
    """A fall, a coin that stands, one that slips and one without losses are drawn without a warning."""
    for words in (
        {"tilt": "60deg", "radius": 0.0375, "contour_friction": "1um"},  # falls over
        {"tilt": "0.5deg", "radius": "12mm", "rolling_friction": "1mm"},  # stays upright
        {
            "tilt": "20deg",
            "precession_rate": 60.0,
            "radius": "12mm",
            "contour_friction": "2um",
            "friction": 0.3,
        },
        {"tilt": "1deg", "roll_rate": 40.0, "radius": "12mm", "rolling_friction": 0.0, "duration": "1s"},
    ):
        drawn = stopping_plots.figure(sweep.simulate(**words))
        assert len(drawn.axes) == 4
        plots.save(drawn, tmp_path / "figure.png")


@pytest.mark.release
def test_same_motion_same_bytes(toy, tmp_path):
    """Drawing twice gives the same file; a motion with sparse samples is recomputed with dense ones."""
    for name in ("first", "second"):
        plots.save(plots.motion_figure(toy), tmp_path / f"{name}.png")
    first, second = ((tmp_path / f"{name}.png").read_bytes() for name in ("first", "second"))
    assert first == second
    coarse = sweep.simulate("toy", tilt="80deg", interval="0.1s")
    (line,) = stopping_plots.figure(coarse).axes[TILT].lines
    assert line.get_xdata().size > 1000


@pytest.mark.slow_lane
def test_the_accessor_draws_each_motion_as_its_model_does(toy):
    """The accessor draws a ledger for a motion with losses and contact panels for one without."""
    assert_facts(toy.eulerdisk.plot().axes[LEDGER].get_ylabel(), "energy", "(mJ)")
    plain = sweep.simulate(tilt="1deg", duration=0.1).eulerdisk.plot()
    assert_facts(plain.axes[3].get_ylabel(), "contact", "(1)")
    with refused("missing", "contour_loss"):
        plots.motion_figure(toy.drop_vars("contour_loss"))


@pytest.mark.slow_lane
def test_the_figure_of_an_explained_cell_is_its_motion(tmp_path):
    """The figure has the cell's end and its verdict in the title; a cell without a start has no figure."""
    atlas = sweep.run("toy", tilt="75deg,80deg", precession_rate="wobble")
    explanation = explain(atlas, {"tilt": "80deg"})
    drawn = stopping_plots.figure_of_cell(explanation)
    assert_facts(drawn.texts[0].get_text(), "unstable", "aloft:60s")
    assert drawn.axes[TILT].lines[0].get_xdata()[-1] == pytest.approx(float(atlas["end_time"][1]), rel=1e-6)
    impossible = sweep.run(
        sweep.SweepSpec(tilt="0,10deg", roll_rate=0.1, precession_rate="steady-fast", rolling_friction=0)
    )
    with refused("precession_rate"):
        stopping_plots.figure_of_cell(explain(impossible, {"tilt": "10deg"}))


def test_all_panels_over_time_have_one_time_axis():
    """All panels over time share one time axis, for motions with and without losses."""
    for words in ({"model": "toy"}, {}):
        start = {"tilt": "80deg"} if words else {"tilt_rate": 0.01, "roll_rate": 2.0}
        motion = sweep.simulate(*words.values(), **start, duration="1s")
        drawn = plots.motion_figure(motion)
        ends = {axes.get_xlim() for axes in drawn.axes if axes.get_xlabel().startswith("elapsed time")}
        assert len(ends) == 1
        low, high = ends.pop()
        assert low < 0.0 < 1.0 < high
