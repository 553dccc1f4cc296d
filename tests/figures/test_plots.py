import math
import re
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from figure_axes import CIRCLING, ROLLING, SPINNING, line, map_and_strip, points, said_in, words
from matplotlib.text import Text
from messages import assert_facts, assert_in_order, refused, with_facts

import sweep
from sweep.figures import plots
from sweep.figures.drawing import _automatic
from sweep.figures.look import Look
from sweep.figures.panels import panel
from sweep.model.disk.tables import ENDINGS
from sweep.model.quantity import UNSTABLE

# docs/theory.md: uniform disk, R = 0.5 m, g = 9.81 m/s2
G_OVER_3R = 6.54
FOUR_G_OVER_5R = 15.696

LINE = ROLLING.replace(tilt="0.1deg")


@pytest.mark.slow_lane
def test_axes_say_quantity_and_unit(panels):
    """Tilt is in degrees, the rate in rad s-1 and in units of sqrt(g/R), and the color bar in degrees."""
    for name in ("rolling", "spinning", "circling"):
        top, strip, second = map_and_strip(panels[name])
        rate = "roll rate" if name == "rolling" else "precession rate"
        assert_facts(strip.get_xlabel(), r"$\theta_0$", "(deg)")
        assert top.get_ylabel().startswith(rate)
        assert top.get_ylabel().replace("\n", " ").endswith(r"(rad s$^{-1}$)")
        assert top.get_yscale() == "linear"
        assert second.get_ylabel().endswith(r"/\sqrt{g/R}$")
        assert_facts(panels[name][-1].get_ylabel(), r"$\max|\theta|$", "(deg)")


def test_second_axis_is_the_first_in_units_of_root_g_over_r(panels):
    """At every height, one side shows the rate and the other the rate times sqrt(R/g)."""
    for name in ("rolling", "spinning", "circling"):
        top, _, second = map_and_strip(panels[name])
        heights = np.linspace(0.0, 1.0, 7)
        # the second axis gets its limits when it is drawn
        top.get_tightbbox()

        def reads(axes, heights=heights):
            to_data = axes.transAxes + axes.transData.inverted()
            return to_data.transform(np.column_stack((np.zeros(7), heights)))[:, 1]

        # the transforms go through pixels and back
        np.testing.assert_allclose(reads(second), reads(top) * math.sqrt(0.5 / 9.81), atol=1e-9)


def test_analytic_line_lies_where_linear_theory_puts_it(panels):
    """The uniform disk's line is at the square root of g/3R (rolling) or 4g/5R (spinning), and its label says so."""
    for name, expected, beside, told in (
        ("rolling", G_OVER_3R, r"$\sqrt{g/3R}$", r"$\dot\phi = \sqrt{g/3R}$ = 2.557 rad s$^{-1}$"),
        ("spinning", FOUR_G_OVER_5R, r"$\sqrt{4g/5R}$", r"$\dot\psi = \sqrt{4g/5R}$ = 3.962 rad s$^{-1}$"),
    ):
        top, strip, _ = map_and_strip(panels[name])
        np.testing.assert_allclose(line(top, "analytic")[1], math.sqrt(expected), rtol=1e-12)
        assert beside in words(top)
        assert f"analytic: {told}" in words(strip)


@pytest.mark.slow_lane
def test_rates_are_drawn_as_they_are_asked_for(atlases):
    """The rate axis is linear in the labeled quantity; line, number and second axis agree with it."""
    for rate, label, height, told, second in (
        ("linear", r"roll rate $\dot\phi_0$ (rad s$^{-1}$)", 6.54**0.5, "2.557 rad s$^{-1}$", True),
        (
            "squared",
            r"roll rate squared $\dot\phi_0^2$ (rad$^{2}$ s$^{-2}$)",
            6.54,
            "6.54 rad$^{2}$ s$^{-2}$",
            True,
        ),
        ("scaled", r"roll rate $\dot\phi_0\,/\sqrt{g/R}$", 3.0**-0.5, r"0.5774 $\sqrt{g/R}$", False),
    ):
        top, strip, *_ = plots.figure([atlases["rolling"]], look=Look.read(rate=rate)).axes
        assert top.get_ylabel().replace("\n", " ") == label
        assert top.get_yscale() == "linear"
        np.testing.assert_allclose(line(top, "analytic")[1], height, rtol=1e-9)
        assert next(each for each in words(strip) if each.startswith("analytic")).endswith(f"= {told}")
        assert bool(top.child_axes) == second
        # the ratio to the line is that of the drawn quantity
        [(_, y, _)], [(_, ratio, _)] = points(top), points(strip)
        np.testing.assert_allclose(ratio, y / height, rtol=1e-12)


@pytest.mark.slow_lane
def test_formula_follows_alpha():
    """The hoop has its own fractions of g/R; any other disk has the general formula."""
    for spec, alpha, formula in (
        (ROLLING, 1.0, r"$\dot\phi = \sqrt{g/4R}$"),
        (SPINNING, 1.0, r"$\dot\psi = \sqrt{2g/3R}$"),
        (ROLLING, 0.4, r"$\dot\phi = \sqrt{g/[2(1{+}\alpha)R]}$"),
        (SPINNING, 0.4, r"$\dot\psi = \sqrt{2g/[(2{+}\alpha)R]}$"),
    ):
        drawn = plots.figure([sweep.run(spec.replace(alpha=alpha, tilt="0.1deg:1deg:3"))])
        assert any(each.startswith(f"analytic: {formula} = ") for each in said_in(drawn))


def test_prediction_is_the_atlas_s(atlases, panels):
    """The dashed line runs through the stored predicted rates."""
    atlas = atlases["spinning"]
    x, y = line(map_and_strip(panels["spinning"])[0], "predicted, departure 5°")
    tilt, rate = np.degrees(atlas["tilt"].values), atlas["predicted_precession_rate"].values
    # the curve is smooth here and drawn with 400 points
    seen = rate < 6.0
    np.testing.assert_allclose(np.interp(tilt[seen], x, y), rate[seen], rtol=1e-4)


def test_circling_curve_ends_at_both_lines(panels):
    """The curve k = 0 goes from the spinning end over the dome's top at 18.62 deg to zero precession."""
    top, _, _ = map_and_strip(panels["circling"])
    x, y = line(top, "analytic: $k = 0$")
    np.testing.assert_allclose(x[[0, -1]], 0.0, atol=1e-4)
    np.testing.assert_allclose(y[[0, -1]], [math.sqrt(FOUR_G_OVER_5R), 0.0], atol=1e-4)
    # 30 deg in 400 points: the last one is within 0.08 deg of the top
    assert x.max() == pytest.approx(18.62, abs=0.08)
    ends = {text.get_text(): text.xy[1] for text in top.texts if hasattr(text, "xy")}
    assert ends[r"spinning: $\dot\psi^2 = 4g/5R$"] == pytest.approx(math.sqrt(FOUR_G_OVER_5R), abs=1e-4)
    assert ends[r"rolling: $\dot\phi^2 = g/3R$"] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.slow_lane
def test_one_branch_of_steady_motions_is_no_curve():
    """One branch of steady motions has no marked ends, with one edge or without lines of theory."""
    for branch in ("steady-slow", "steady-fast"):
        for count in (6, 26):
            spec = sweep.SweepSpec(
                roll_rate=f"1:6:{count}", tilt=f"1deg:30deg:{count}", precession_rate=branch, tilt_rate=1e-4
            )
            top = plots.figure([sweep.run(spec)]).axes[0]
            assert not [each for each in top.get_lines() if each.get_marker() == "D"], spec


def test_background_is_the_peak_tilt_in_degrees(atlases, panels):
    """The colors of the cells are the peak tilt in degrees, with rows along the rate."""
    atlas = atlases["rolling"]
    drawn = map_and_strip(panels["rolling"])[0].collections[0].get_array()
    expected = np.degrees(atlas["peak_tilt"].transpose("roll_rate", "tilt").values)
    np.testing.assert_allclose(drawn, expected, rtol=1e-12)


def test_verdicts_are_named_where_they_hold(atlases, panels):
    """The words stable and unstable are on cells with that verdict, so the map can be read without color."""
    atlas = atlases["rolling"]
    top, _, _ = map_and_strip(panels["rolling"])
    for text in top.texts:
        if text.get_text() not in {"stable", "unstable"}:
            continue
        pixel = top.transAxes.transform(text.get_position())
        tilt, rate = top.transData.inverted().transform(pixel)
        cell = atlas.sel(tilt=math.radians(tilt), roll_rate=rate, method="nearest")
        assert (int(cell["stability"]) == UNSTABLE) == (text.get_text() == "unstable")
    assert {"stable", "unstable"} <= set(words(top))


def test_one_verdict_gets_one_word():
    """A map of unstable cells has neither the word stable nor a boundary, and says that the lines are elsewhere."""
    axes = plots.figure([sweep.run(ROLLING.replace(roll_rate="1:2:10"))]).axes[0]
    said = words(axes)
    assert "unstable" in said
    assert "stable" not in said
    assert not points(axes)
    told = r"analytic: $\dot\phi = \sqrt{g/3R}$ = 2.557 rad s$^{-1}$ (outside the map)"
    assert told in [each.replace("\n", " ") for each in said]


def test_names_have_their_places(panels):
    """A single verdict is in the middle, a formula above the right end of its line, an end's name next to it."""
    (lone,) = plots.figure([sweep.run(ROLLING.replace(roll_rate="1:2:10"))]).axes[0].texts
    # as far from both sides as possible
    assert abs(lone.get_position()[0] - 0.5) < 0.05
    top, _, _ = map_and_strip(panels["rolling"])
    (formula,) = (each for each in top.texts if "sqrt" in each.get_text())
    line_at = top.transAxes.inverted().transform(top.transData.transform((1.0, math.sqrt(G_OVER_3R))))[1]
    assert formula.get_position()[0] > 0.8
    assert formula.get_position()[1] > line_at
    top, _, _ = map_and_strip(panels["circling"])
    top.figure.draw_without_rendering()
    away = []
    for each in (each for each in top.texts if hasattr(each, "xy")):
        box, at = Text.get_window_extent(each), top.transData.transform(each.xy)
        away.append(np.hypot(*np.maximum(np.maximum([box.x0, box.y0] - at, at - [box.x1, box.y1]), 0.0)))
    assert min(away) < 20.0 * top.figure.dpi / 72.0


@pytest.mark.slow_lane
def test_hatching_is_explained_only_where_it_is(panels):
    """Undecided and impossible cells are hatched and explained in the legend; other maps have no entry."""
    assert not {"undecided", "invalid"} & set(words(map_and_strip(panels["rolling"])[1]))
    assert "undecided" in said_in(plots.figure([sweep.run(ROLLING.replace(duration="2s"))]))
    assert "invalid" in said_in(plots.figure([sweep.run(CIRCLING.replace(precession_rate="-1:1:5"))]))


def test_hatching_covers_the_cells_that_it_is_for():
    """On maps and profiles along both axes, the hatching covers exactly the invalid cells."""
    spec = sweep.SweepSpec(
        roll_rate="1:6:6", tilt="5deg:30deg:6", precession_rate="steady-slow", tilt_rate=1e-3
    )
    atlas = sweep.run(spec)
    rates, tilts = atlas["roll_rate"].values, np.degrees(atlas["tilt"].values)
    invalid = atlas["ending"].transpose("roll_rate", "tilt").values == ENDINGS.code("invalid")
    assert 0 < invalid.sum() < invalid.size

    def patches(drawn):
        return [each for each in drawn.axes[0].patches if each.get_label() == "invalid"]

    [patch] = patches(plots.figure([atlas]))
    middles = np.column_stack([each.ravel() for each in np.meshgrid(tilts, rates)])
    np.testing.assert_array_equal(patch.get_path().contains_points(middles), invalid.ravel())
    for part, x, cells in (
        (atlas.isel(tilt=4), rates, invalid[:, 4]),
        (atlas.isel(roll_rate=2), tilts, invalid[2]),
    ):
        spans = [
            each.get_path().transformed(each.get_patch_transform()).get_extents()
            for each in patches(plots.figure([part]))
        ]
        hatched = [any(box.x0 < middle < box.x1 for box in spans) for middle in x]
        np.testing.assert_array_equal(hatched, cells)


@pytest.mark.slow_lane
def test_the_analytic_rate_has_a_number_where_it_is_one_number(atlases):
    """Along the radius, the critical rate varies, and the legend has only the formula."""
    many = sweep.run(ROLLING.replace(roll_rate="2:4:11", radius="0.3:0.6:4", tilt="1deg"))
    one, several = (
        [text for axes in plots.figure([each]).axes for text in words(axes)]
        for each in (atlases["rolling"], many)
    )
    assert rf"= {math.sqrt(G_OVER_3R):.4g} rad" in " ".join(one)
    assert any(text.endswith(r"\sqrt{g/3R}$") for text in several)


def test_contour_levels_are_round_numbers():
    """From 1 to 200 the levels are 2, 5, 10, ...; over five decades powers of ten; over a narrow range equal steps."""
    wide = [SimpleNamespace(values=np.geomspace(1.0, high, 50)) for high in (200.0, 3e5)]
    assert _automatic(wide[:1], 1.0, 200.0) == (2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
    assert _automatic(wide[1:], 1.0, 3e5) == (1e1, 1e2, 1e3, 1e4, 1e5)
    narrow = SimpleNamespace(values=np.linspace(1.0, 2.0, 50))
    assert np.ptp(np.diff(_automatic([narrow], 1.0, 2.0))) < 1e-12


@pytest.mark.slow_lane
def test_legend_names_the_criterion(atlases):
    """The label of the prediction names its criterion."""
    other = sweep.reclassify(atlases["rolling"], "amplification:20")
    said = words(map_and_strip(plots.figure([other]).axes)[1])
    assert "predicted, amplification 20" in said


def test_other_axes_than_rates():
    """A map without a rate has no measured boundary, but shows where unstable cells end."""
    atlas = sweep.run(ROLLING.replace(roll_rate=2.5, tilt="0.1deg:2deg:5", alpha="0.2:1:6"))
    axes = plots.figure([atlas]).axes
    labels = axes[0].get_xlabel(), axes[0].get_ylabel()
    assert {*with_facts(labels, r"$\theta_0$", "(deg)"), *with_facts(labels, r"$\alpha$")} == {*labels}
    assert not points(axes[0])
    assert len(axes) == 2


@pytest.mark.slow_lane
def test_negative_rates():
    """If a rate changes sign, both lines are drawn, at plus and minus the square root of 4g/5R."""
    atlas = sweep.run(SPINNING.replace(precession_rate="-6:6:13", tilt="0.1deg:0.3deg:4"))
    axes = plots.figure([atlas]).axes[0]
    heights = {
        round(float(each.get_ydata()[0]), 9) for each in axes.get_lines() if len(each.get_ydata()) == 400
    }
    assert_facts(axes.get_ylabel(), r"$\dot\psi_0$", "(rad s$^{-1}$)")
    assert {round(sign * math.sqrt(FOUR_G_OVER_5R), 9) for sign in (-1, 1)} <= heights
    assert with_facts(said_in(plots.figure([atlas])), "analytic", r"$\dot\psi^2 = 4g/5R$")
    with refused("precession_rate", "-6 rad s-1"):
        plots.figure([atlas], look=Look(rate="squared"))


def test_single_axis_is_a_profile():
    """An atlas with one axis is drawn as a curve of peak tilts; the analytic rate is a vertical line."""
    atlas = sweep.run(LINE)
    axes = plots.figure([atlas]).axes[0]
    assert axes.get_xlabel().startswith("roll rate")
    assert_facts(axes.get_ylabel(), r"$\max|\theta|$", "(deg)")
    x, y = axes.get_lines()[0].get_data()
    np.testing.assert_allclose(x, atlas["roll_rate"].values, rtol=1e-14)
    np.testing.assert_allclose(y, np.degrees(atlas["peak_tilt"].values), rtol=1e-14)
    np.testing.assert_allclose(line(axes, "analytic")[0], math.sqrt(G_OVER_3R), rtol=1e-12)
    assert {"stable", "unstable"} <= set(words(axes))
    assert with_facts(words(axes), "bracket", "RK4")


def test_selection_from_a_larger_atlas():
    """A selection from an atlas of three axes is one map, with the selected value in the caption."""
    atlas = sweep.run(ROLLING.replace(roll_rate="2:4:9", tilt="0.1deg:1deg:4", alpha=[0.5, 1.0]))
    hoop = plots.figure([atlas.sel(alpha=1.0)])
    legend = map_and_strip(hoop.axes)[1].get_legend()
    assert any(r"\sqrt{g/4R}" in text.get_text() for text in legend.get_texts())
    assert r"$\alpha = 1$" in legend.get_title().get_text()


def test_nothing_to_draw():
    """A single cell and an empty list are refused."""
    with refused("one or two axes", "single cell", "start:stop"):
        plots.figure([sweep.run(LINE.replace(roll_rate=3.0))])
    with refused("atlas"):
        plots.figure([])


@pytest.mark.slow_lane
def test_panel_is_as_wide_as_a_column(atlases):
    """Three panels are side by side, each at least 3.4 in wide and with text of at least 7 pt."""
    drawn = plots.figure(list(atlases.values()))
    assert drawn.get_size_inches()[0] >= 3 * 3.4
    sizes = [text.get_fontsize() for text in drawn.findobj(matplotlib.text.Text) if text.get_text()]
    assert min(sizes) >= 7.0


@pytest.mark.slow_lane
def test_words_do_not_overlap(atlases):
    """No two texts on a map overlap, and none leaves the map."""
    drawn = plots.figure(list(atlases.values()))
    drawn.canvas.draw()
    for axes in drawn.axes:
        boxes = [text.get_window_extent() for text in axes.texts]
        assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
        assert all(axes.bbox.x0 <= box.x0 and box.x1 <= axes.bbox.x1 for box in boxes)


@pytest.mark.slow_lane
def test_a_figure_says_why_there_is_no_boundary(atlases):
    """Tilts without a boundary have the reason below the map, by edge if the reasons differ."""

    def caption(atlas):
        drawn = [axes.get_legend() for axes in plots.figure([atlas]).axes]
        return next(each for each in drawn if each is not None).get_title().get_text().splitlines()

    low = sweep.run(ROLLING.replace(roll_rate="1:2:5", tilt="0.1deg:1deg:4"))
    for each in (low, low.isel(tilt=0)):
        assert_facts(caption(each)[-1], "boundary", "unstable throughout")
        assert not re.search(r"\d", caption(each)[-1])
    assert not any("boundary" in line for line in caption(atlases["rolling"].isel(tilt=slice(0, 5))))
    assert_facts(caption(atlases["circling"])[-1], "12 of 30", "values of tilt", "stable throughout")
    slow = sweep.run(CIRCLING.replace(precession_rate="0.05:1.5:9", tilt="10deg,20deg"))
    upper, lower = caption(slow)[-2:]
    assert_in_order(upper, "upper edge", "1 stable throughout", "1 lower edge only")
    assert_in_order(lower, "lower edge", "1 of 2", "stable throughout")
    assert_facts(lower, "values of tilt")


@pytest.mark.slow_lane
def test_an_own_criterion_is_drawn_without_a_prediction():
    """The caption has the expression, wrapped to the panel; of theory only the analytic line is drawn."""
    text = "peak_tilt > 10deg or fall_time < 2s or amplification > 300 and abs(tilt_min) > 2*abs(tilt)"
    atlas = sweep.run(ROLLING.replace(criterion=text))
    drawn = plots.figure([atlas])
    top, strip, _ = map_and_strip(drawn.axes)
    caption = strip.get_legend().get_title().get_text()
    assert " ".join(caption.split()).startswith(f"unstable: {text.replace('deg', '°')}")
    assert max(map(len, caption.split("\n"))) <= 72
    assert not [each for each in said_in(drawn) if "predicted" in each]
    assert {"stable", "unstable"} <= set(words(top))
    for axes in (top, strip):
        assert not [each for each in axes.get_lines() if "predicted" in str(each.get_label())]
    # the strip has only the analytic line
    assert np.isnan(
        np.concatenate([each.get_ydata() for each in strip.get_lines()[1:] if len(each.get_ydata()) > 99])
    ).all()
    said = said_in(plots.figure([sweep.run(LINE.replace(criterion=text))]))
    assert any("analytic" in each for each in said)
    assert not [each for each in said if "predicted" in each]


def test_what_a_function_judged_is_drawn():
    """An atlas judged by a function is drawn like any other, and the caption names the function."""

    def steep(atlas):
        return atlas.peak_tilt > 0.1

    drawn = plots.figure([sweep.reclassify(sweep.run(ROLLING), steep)])
    caption = map_and_strip(drawn.axes)[1].get_legend().get_title().get_text()
    assert "steep" in caption


def test_a_cell_without_a_result_is_hatched_once():
    """A cell without a result is labeled by its ending, not as lacking the quantity."""
    drawn = panel(sweep.run(CIRCLING.replace(precession_rate="-1:1:5")))
    assert drawn.no_result.any()
    assert np.isnan(drawn.shade.values[drawn.no_result]).all()
    assert not (drawn.shade.absent & drawn.no_result).any()


def test_a_map_of_endings_has_no_lines_around_single_cells():
    """A map of endings has no borders, as colors show them; a map of verdicts without a line of theory has one."""
    atlas = sweep.run("henon_heiles", u="-1:1:16", v="-1:1:16", duration=20)
    for name, outlined in (("ending", False), ("stability", True)):
        figure = plots.figure([atlas], look=Look(quantity=name))
        labels = [each.get_label() for each in figure.axes[0].collections]
        assert bool(with_facts(labels, "border", "unstable")) == outlined, name


def test_several_atlases_are_told_apart(tmp_path, atlases):
    """Each of several panels has a letter and its file name below; a single atlas has neither."""
    opened = []
    for name in ("rolling", "spinning"):
        sweep.save(atlases[name], tmp_path / f"{name}.nc")
        opened.append(sweep.open_atlas(tmp_path / f"{name}.nc"))
    drawn = [axes for axes in plots.figure(opened).axes if axes.get_title(loc="left")]
    assert [axes.get_title(loc="left")[:4] for axes in drawn] == ["(a) ", "(b) "]
    told = plots.figure(opened).get_label()
    assert_in_order(told, "(a)", "rolling.nc", "(b)", "spinning.nc")
    bare = plots.figure(opened, look=Look(without=frozenset({"title", "caption"})))
    assert [axes.get_title(loc="left") for axes in bare.axes if axes.get_title(loc="left")] == ["(a)", "(b)"]
    for dataset in opened:
        assert "rolling.nc" not in plots.figure([dataset]).get_label()
        assert "(a)" not in plots.figure([dataset]).get_label()
        dataset.close()


def test_a_caption_of_a_system_is_in_words():
    """For a system, the caption says in words which early ends are unstable; a map of labels without any does not."""
    atlas = sweep.run("henon_heiles", u="-1:1:8", v="-1:1:8", duration=20)
    told = plots.figure([atlas]).get_label()
    assert "runs_on" not in told
    assert_facts(told, "unstable:", "duration")
    basins = sweep.run("magnets", x="-1:1:4", y="-1:1:4", duration=10)
    assert "unstable" not in plots.figure([basins]).get_label()
