"""Nothing overlaps in figures of awkward atlases, according to the renderer's boxes."""

import itertools

import numpy as np
import pytest
from figure_words import misplaced, words_drawn
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.text import Text
from messages import assert_facts, refused

import sweep
from sweep.figures import plots
from sweep.figures.look import Look

pytestmark = pytest.mark.compiled

PLAIN = sweep.SweepSpec(roll_rate="2:4:21", tilt="0.1deg:4deg:15")

#: Atlases that are difficult to lay out.
AWKWARD = {
    "preset": sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:21", tilt="0.01deg:4deg:15:log"),
    "circling": sweep.SweepSpec.preset("circling").replace(tilt="1deg:30deg:16", precession_rate="0.05:5:21"),
    "1 x N": PLAIN.replace(tilt=["1deg"]),
    "N x 1": PLAIN.replace(roll_rate=[3.0], tilt="0.1deg:20deg:30"),
    "2 x 2": PLAIN.replace(roll_rate="2:4:2", tilt="0.1deg:1deg:2"),
    "all stable": PLAIN.replace(roll_rate="4:6:9", tilt="0.1deg:1deg:9"),
    "all unstable": PLAIN.replace(roll_rate="1:2:9"),
    "all undecided": PLAIN.replace(duration="0.05s"),
    "partly undecided": PLAIN.replace(duration="2s"),
    "negative": PLAIN.replace(roll_rate="-4:-2:21"),
    "both signs": sweep.SweepSpec(
        precession_rate="-6:6:25", tilt="-20deg:20deg:21", criterion="departure:5deg"
    ),
    "invalid": sweep.SweepSpec.preset("circling").replace(tilt="1deg:30deg:12", precession_rate="-1:1:11"),
    "alpha": PLAIN.replace(alpha="0.1:1:12", tilt="1deg"),
    "alpha and tilt": PLAIN.replace(alpha="0.1:1:12", roll_rate=2.5),
    "refined": PLAIN.replace(boundary="refined:1e-6"),
    "decades": PLAIN.replace(roll_rate="0.1:100:16:log", tilt="0.001deg:60deg:16:log"),
    "long numbers": PLAIN.replace(roll_rate="2.55001:2.55009:9", tilt="0.10001deg:0.10009deg:9"),
    "small and fast": PLAIN.replace(radius="1mm", roll_rate="20:400:20"),
    "two rates": PLAIN.replace(precession_rate="0:5:16", roll_rate="0:5:16", tilt="1deg"),
    "five alphas": PLAIN.replace(alpha="0.2:1:5"),
    "alphas and radii": PLAIN.replace(alpha="0.5,1", radius="0.1,0.5"),
    "two times two": PLAIN.replace(alpha="0.5,1", gravity="1.62,9.81"),
}

LOOKS = {
    "default": Look.read(),
    "column": Look.read(width="86mm"),
    "narrow": Look.read(width="64mm"),
    "large letters": Look.read(width="180mm", font_size=12),
    "scaled": Look.read(rate="scaled", width="86mm"),
    "low": Look.read(height="110mm"),
}


def drawn_as(atlas, look):
    """Return a rendered figure of an atlas."""
    drawn = plots.figure([atlas], look=look)
    drawn.draw_without_rendering()
    return drawn


def every_axes(drawn):
    """Return all axes of a figure, including second axes."""
    return [each for axes in drawn.axes for each in (axes, *axes.child_axes)]


def is_shown(text):
    """Return True if a text is visible and not empty."""
    return bool(text.get_visible() and text.get_text().strip())


def numbers_on(axis):
    """Return the labels and boxes of the numbers on an axis that are within its ends."""
    low, high = sorted(axis.get_view_interval())
    room = 1e-6 * (high - low)
    ticks = [tick for tick in axis.get_major_ticks() if low - room <= tick.get_loc() <= high + room]
    labels = [label for tick in ticks for label in (tick.label1, tick.label2) if is_shown(label)]
    return [(label.get_text(), label.get_window_extent()) for label in labels]


def words_of(drawn):
    """Return the text and the box of all text in a figure: numbers, labels, titles, names, legends."""
    found = []
    for axes in every_axes(drawn):
        found += numbers_on(axes.xaxis) + numbers_on(axes.yaxis)
        texts = [axes.xaxis.label, axes.yaxis.label, axes._left_title, *axes.texts]
        legend = axes.get_legend()
        if legend is not None:
            texts += [*legend.get_texts(), legend.get_title()]
        found += [(text.get_text(), Text.get_window_extent(text)) for text in texts if is_shown(text)]
    return found + [(text.get_text(), text.get_window_extent()) for text in drawn.texts if is_shown(text)]


def overlap(one, other):
    """Return the smaller overlap of two boxes in x or y, in dots; it is negative if they do not overlap."""
    return min(min(one.x1, other.x1) - max(one.x0, other.x0), min(one.y1, other.y1) - max(one.y0, other.y0))


#: Awkward atlases similar to others, tested only before a release.
LIKE_OTHERS = {
    "2 x 2",
    "1 x N",
    "all unstable",
    "partly undecided",
    "negative",
    "alpha",
    "alpha and tilt",
    "two rates",
}


@pytest.mark.release
def test_nothing_lies_on_anything_else_in_a_column():
    """No two texts overlap, none leaves the figure, and no legend covers a panel."""
    check_all("column", AWKWARD.keys() - LIKE_OTHERS)


@pytest.mark.release
def test_nothing_lies_on_anything_else_in_a_figure_of_any_width():
    """The same holds for all atlases, also in the width that the panels prefer."""
    check_all("column", LIKE_OTHERS)
    check_all("default", AWKWARD)


def check_all(look, names):
    """Check texts, maps and names of awkward atlases in a look."""
    for name in sorted(names):
        spec = AWKWARD[name]
        atlas = sweep.run(spec)
        drawn = drawn_as(atlas, LOOKS[look])
        check_words(drawn, name)
        check_maps(drawn, name)
        check_verdicts(atlas, drawn, name)


#: One look for each of these atlases in the daily tests.
OTHERS = {"circling": "scaled", "negative": "narrow", "decades": "large letters", "alphas and radii": "low"}


@pytest.mark.release
def test_no_word_lies_on_another_in_other_looks():
    """The same holds for a narrow and a low figure, large letters and scaled rates."""
    for name, look in OTHERS.items():
        check_words(drawn_as(sweep.run(AWKWARD[name]), LOOKS[look]), (name, look))


@pytest.mark.release
def test_no_word_lies_on_another_in_all_looks():
    """The same holds for each of these atlases in each of these looks."""
    for name in OTHERS:
        atlas = sweep.run(AWKWARD[name])
        for look in OTHERS.values():
            check_words(drawn_as(atlas, LOOKS[look]), (name, look))


TITLED = {
    "rolling": {"roll_rate": "2:4:9", "tilt": "0.1deg:4deg:7"},
    "circling": {"precession_rate": "0.05:5:9", "tilt": "1deg:25deg:7"},
    "toy": {"precession_rate": "30:80:7", "tilt": "40deg:80deg:7"},
    "random": {"roll_rate": "uniform:2:4", "tilt": "normal:1deg:0.2deg", "samples": 50},
}


@pytest.mark.slow_lane
def test_the_title_that_the_program_gives_is_whole():
    """A long automatic title takes several lines; nothing is cut and no text overlaps."""
    looks = {
        "rolling": ("column", "narrow"),
        "circling": ("narrow",),
        "toy": ("default", "narrow"),
        "random": ("column",),
    }
    for name, words in TITLED.items():
        atlas = sweep.run(sweep.SweepSpec.preset("rolling" if name == "random" else name, **words))
        for look in looks[name]:
            assert misplaced(plots.figure([atlas], look=LOOKS[look])) == [], (name, look)
        if name in ("rolling", "toy"):
            assert misplaced(plots.figure([atlas] * 2, look=Look.read(width="160mm"))) == [], name


@pytest.mark.slow_lane
def test_the_title_of_axes_of_a_user_is_whole():
    """In the user's narrow axes, the title is at most as wide as the axes."""
    drawn = Figure(layout="constrained", figsize=(4.0, 6.0))
    spec = sweep.SweepSpec.preset("toy", **TITLED["toy"])
    sweep.run(spec).eulerdisk.plot(ax=drawn.subplots())
    assert misplaced(drawn) == []


#: A title of at least two lines in every figure.
LONG = "A coin of twelve millimetres on glass, nudged by four degrees as it rolls"


@pytest.mark.slow_lane
def test_a_long_title_pushes_the_panels_down():
    """All lines of a long title are above the panels and complete, also next to a common title."""
    for name, looks in (("rolling", ("default", "narrow")), ("random", ("column",))):
        atlas = sweep.run(sweep.SweepSpec.preset("rolling", title=LONG, **TITLED[name]))
        for look in looks:
            drawn = plots.figure([atlas], look=LOOKS[look])
            assert misplaced(drawn) == [], (name, look)
            assert LONG in [" ".join(each.get_text().split()) for each, _ in words_drawn(drawn)]
        if name == "rolling":
            assert misplaced(plots.figure([atlas] * 2, look=Look.read(width="160mm"))) == []


@pytest.mark.release
def test_a_long_title_of_more_than_two_axes_is_whole():
    """A family of maps has one complete title above all maps."""
    atlas = sweep.run(PLAIN.replace(alpha="0.5,1", title=LONG))
    for width in ("86mm", "120mm", "180mm"):
        drawn = plots.figure([atlas], look=Look.read(width=width))
        assert misplaced(drawn) == []
        assert LONG in [" ".join(each.get_text().split()) for each, _ in words_drawn(drawn)]


@pytest.mark.slow_lane
def test_a_long_title_of_a_motion_is_whole():
    """The panels of a motion are below all lines of its title and caption."""
    for start in ({}, {"rolling_friction": "10um"}):
        rates = {"tilt_rate": -1.234, "precession_rate": -12.34, "roll_rate": -12.34, "gravity": 9.625}
        motion = sweep.simulate(
            radius="12.345mm", tilt="1.234deg", duration=1.0, title=LONG, **rates, **start
        )
        drawn = plots.motion_figure(motion)
        assert misplaced(drawn) == []
        assert LONG in [" ".join(each.get_text().split()) for each, _ in words_drawn(drawn)]


def test_the_legend_of_a_narrow_figure_is_inside_it_and_begins_with_the_measurement():
    """A legend as wide as the figure starts left of the axes; the measurement precedes colors and lines."""
    criterion = "peak_tilt > 10deg or fall_time < 2s or tilt_max > 20deg and tilt_min < 1deg"
    look = Look.read(width="70mm", quantity="ending")
    drawn = plots.figure([sweep.run(PLAIN.replace(criterion=criterion))], look=look)
    drawn.draw_without_rendering()
    (legend,) = (axes.get_legend() for axes in drawn.axes if axes.get_legend() is not None)
    box, axes = legend.get_window_extent(), legend.axes.get_window_extent()
    assert box.x1 <= drawn.bbox.x1
    assert axes.x0 > box.x0 >= drawn.bbox.x0
    assert legend.get_texts()[0].get_text().startswith("RK4 boundary")


def check_words(drawn, case):
    """Compare the boxes of all texts of a figure with each other and with its panels."""
    words = words_of(drawn)
    touching = [(a[0], b[0]) for a, b in itertools.combinations(words, 2) if overlap(a[1], b[1]) > 1.0]
    assert not touching, case
    outside = [text for text, box in words if overlap(box, drawn.bbox) < min(box.width, box.height) - 1.0]
    assert not outside, case
    for axes in drawn.axes:
        legend = axes.get_legend()
        if legend is not None:
            assert all(overlap(legend.get_window_extent(), each.bbox) <= 0.0 for each in drawn.axes), case


def check_maps(drawn, case):
    """Check that axes end with the cells, no text in a map covers a point or a line, and no panel is empty."""
    for axes in drawn.axes:
        meshes = [
            each for each in axes.collections if isinstance(each, QuadMesh) and axes.get_title(loc="left")
        ]
        for mesh in meshes:
            corners = mesh.get_coordinates().reshape(-1, 2)
            np.testing.assert_allclose(sorted(axes.get_xlim()), [corners[:, 0].min(), corners[:, 0].max()])
            np.testing.assert_allclose(sorted(axes.get_ylim()), [corners[:, 1].min(), corners[:, 1].max()])
            assert min(axes.bbox.width, axes.bbox.height) > 0.7 * drawn.dpi
        boxes = [(text.get_text(), Text.get_window_extent(text)) for text in axes.texts if meshes]
        for each in axes.get_lines():
            with np.errstate(invalid="ignore", divide="ignore"):
                at = each.get_transform().transform_path(each.get_path()).interpolated(50).vertices
            for text, box in boxes:
                on = (at[:, 0] > box.x0) & (at[:, 0] < box.x1) & (at[:, 1] > box.y0) & (at[:, 1] < box.y1)
                assert not on.any(), (case, text, each.get_label())


def check_verdicts(atlas, drawn, case):
    """Check that each verdict in a panel is named, except one without room."""
    names = {0: "undecided", 1: "stable", 2: "unstable"}
    there = {names[int(code)] for code in np.unique(atlas["stability"].values)}
    if (atlas["ending"].values >= 5).any():
        there.discard("undecided")
    told = {text.partition(",")[0] for text, _ in words_of(drawn)}
    assert len(there - told) <= 1, case


@pytest.mark.slow_lane
def test_too_small_a_figure_is_refused_with_the_size_that_will_do():
    """The size that a refusal suggests is enough."""
    for width, font_size in (("25mm", 8), ("86mm", 30), ("30mm", 8)):
        atlas = sweep.run(PLAIN)
        with refused("width") as caught:
            plots.figure([atlas], look=Look.read(width=width, font_size=font_size))
        named = str(caught.value).partition("width=")[2].partition("mm")[0]
        plots.figure([atlas], look=Look.read(width=f"{named}mm", font_size=font_size))


def test_a_figure_has_the_size_that_was_asked_for(tmp_path):
    """Width and height are exact to a dot, and letters have the requested size."""
    from matplotlib.image import imread

    drawn = plots.figure(
        [sweep.run(PLAIN)], look=Look.read(width="86mm", height="100mm", font_size=7, dpi=300)
    )
    np.testing.assert_allclose(drawn.get_size_inches() * 25.4, [86.0, 100.0], rtol=1e-12)
    plots.save(drawn, tmp_path / "a.png", 300)
    assert imread(tmp_path / "a.png").shape[:2] == (int(100 / 25.4 * 300), int(86 / 25.4 * 300))
    assert drawn.axes[0].xaxis.label.get_fontsize() == 7.0


@pytest.mark.slow_lane
def test_axes_are_on_whole_dots_of_the_file():
    """Cells are sharp at the requested dots per inch, by default 200."""
    for dpi in (200, 300, 310):
        drawn = plots.figure([sweep.run(PLAIN)], look=Look.read(dpi=None if dpi == 200 else dpi))
        for axes in drawn.axes:
            dots = axes.get_position().get_points() * drawn.get_size_inches() * dpi
            np.testing.assert_allclose(dots, np.round(dots), rtol=0.0, atol=1e-6)


def width_of_map(drawn):
    """Return the width [mm] of the map of a figure with one panel."""
    drawn.draw_without_rendering()
    [axes] = [each for each in drawn.axes if any(isinstance(one, QuadMesh) for one in each.collections)][:1]
    return axes.get_window_extent().width / drawn.dpi * 25.4


@pytest.mark.slow_lane
def test_the_map_of_a_column_of_a_journal_is_55_mm_wide():
    """An 86 mm figure has a 55 mm map, with or without text; a bare one has a one-line legend inside."""
    atlas = sweep.run(AWKWARD["preset"])
    for words in ({}, {"bare": True}, {"bare": True, "without": "strip"}):
        drawn = plots.figure([atlas], look=Look.read(width="86mm", **words))
        assert width_of_map(drawn) >= 54.95
        assert misplaced(drawn) == []
        # at the file's dots per inch, text is slightly wider
        drawn.set_dpi(200)
        assert misplaced(drawn) == []
    [legend] = [axes.get_legend() for axes in drawn.axes if axes.get_legend()]
    assert [each.get_text() for each in legend.get_texts()] == ["measured", "predicted", "analytic"]
    assert legend.get_window_extent().height < 2.0 * 8.0 / 72.0 * drawn.dpi


def test_what_a_bare_figure_leaves_out_is_its_label():
    """A bare figure has no title or caption; its label has both and the legend; other parts are omitted by name."""
    atlas = sweep.run(AWKWARD["preset"])
    drawn = plots.figure([atlas], look=Look.read(bare=True, without=["strip", "legend", "bar"]))
    assert len(drawn.axes) == 1
    told = [text for text, _ in words_of(drawn)]
    full = plots.figure([atlas], look=Look.read())
    title = full.axes[0].get_title(loc="left")
    caption = f"unstable: {atlas.eulerdisk.spec.criterion.caption(atlas.eulerdisk.spec.model)}"
    [legend] = [axes.get_legend() for axes in full.axes if axes.get_legend()]
    lines = drawn.get_label().split("\n")
    assert not any(title in each or each.startswith("unstable:") for each in told)
    assert lines[:2] == [title, caption]
    for each in legend.get_texts():
        assert " ".join(each.get_text().split()) in lines
    assert_facts(lines[-1], r"$\max|\theta|$", "(deg)")
    assert full.get_label() == drawn.get_label()


def test_a_bracket_is_drawn_over_its_marker():
    """A bracket is visible even if its marker is larger."""
    drawn = plots.figure([sweep.run(AWKWARD["preset"])], look=Look.read())
    sets = [each for axes in drawn.axes for each in axes.containers if hasattr(each, "has_yerr")]
    assert sets
    for markers, caps, bars in sets:
        assert not caps
        assert all(bar.get_zorder() > markers.get_zorder() for bar in bars)


@pytest.mark.slow_lane
def test_the_legend_of_an_incomplete_last_row_is_in_its_empty_place():
    """An incomplete last row has the legend in its empty place, and all panels of a row have numbers or none."""
    drawn = plots.figure([sweep.run(AWKWARD["five alphas"])], look=Look.read())
    assert misplaced(drawn) == []
    [legend] = [axes.get_legend() for axes in drawn.axes if axes.get_legend()]
    box, panels = legend.get_window_extent(), drawn.axes[:5]
    assert box.x0 > panels[4].bbox.x1
    assert box.y1 <= panels[4].bbox.y1 + 1.0
    numbered = [bool(numbers_on(each.xaxis)) for each in panels]
    assert numbered == [True] * 5


@pytest.mark.slow_lane
def test_a_number_of_the_request_stays_as_it_was_given():
    """A given radius of 12.875 mm keeps its digits in captions; a computed rate has four digits."""
    spec = sweep.SweepSpec(radius="12.875mm", gravity=9.80665, roll_rate="20:40:5", tilt="0.1deg:4deg:4")
    text = plots.figure([sweep.run(spec)]).get_label()
    assert "$R = 12.875$ mm, $g = 9.80665$ m s$^{-2}$" in text
    motion = sweep.simulate("toy", radius="12.875mm", tilt="62.125deg", duration="0.1s")
    told = [text for text, _ in words_of(plots.motion_figure(motion))]
    [caption] = [each for each in told if each.startswith("R = ")]
    assert_facts(" ".join(caption.split()), "R = 12.875 mm", "α = 0.5", "tilt 62.125 deg")
    assert len(caption.split("precession rate ")[1].split(" ")[0]) == 5
