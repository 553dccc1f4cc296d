"""Figures of lists of starts: the plane, the points and their colors, the lines of theory, the texts."""

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from messages import assert_facts, assert_in_order, refused, with_facts

import sweep
from sweep.figures import plots, scatter
from sweep.figures.look import Look
from sweep.figures.scatter import plane_of
from sweep.model.disk.tables import ENDINGS
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

SPEC = sweep.SweepSpec.from_words(
    "rolling", ["roll_rate=uniform:2:4", "tilt=normal:1deg:0.2deg", "samples=300", "method=exact"]
)


@pytest.fixture(scope="module")
def atlas():
    """Return a small list of starts."""
    return sweep.run(SPEC).load()


def drawn(atlas):
    """Return the axes of the only panel."""
    (axes,) = plots.figure([atlas]).axes
    return axes


def labels(axes):
    """Return the texts of the legend, beginning with its title."""
    legend = axes.get_legend()
    return [legend.get_title().get_text(), *(each.get_text() for each in legend.get_texts())]


def test_the_plane():
    """Two varying parameters are the axes; of more, the first control and the tilt; one has the peak above it."""
    for words, plane in (
        ({}, ("tilt", "roll_rate", ())),
        ({"tilt": 0.02}, ("roll_rate", "peak_tilt", ())),
        ({"roll_rate": 3.0}, ("tilt", "peak_tilt", ())),
        ({"alpha": "uniform:0.4:1"}, ("tilt", "roll_rate", ("alpha",))),
        ({"tilt": 0.02, "alpha": "uniform:0.4:1"}, ("alpha", "roll_rate", ())),
        ({"roll_rate": 3.0, "alpha": "uniform:0.4:1"}, ("tilt", "alpha", ())),
        ({"precession_rate": "uniform:0:1"}, ("tilt", "precession_rate", ("roll_rate",))),
        ({"precession_rate": "uniform:0:1", "tilt": 0.02}, ("roll_rate", "precession_rate", ())),
    ):
        found = plane_of(SPEC.replace(**words))
        assert (found.x.name, found.y.name, found.hidden) == plane


def test_points_have_the_colours_of_their_verdicts(atlas):
    """Every start is a point at its parameters, in the units of the labels."""
    axes = drawn(atlas)
    (points,) = axes.collections
    x, y = points.get_offsets().T
    np.testing.assert_allclose(x, np.degrees(atlas.tilt))
    np.testing.assert_allclose(y, atlas.roll_rate)
    codes = {to_rgba("#6ccd5a"): STABLE, to_rgba("#453781"): UNSTABLE}
    assert [codes[tuple(each)] for each in points.get_facecolors()] == atlas.stability.values.tolist()
    assert_facts(axes.get_xlabel(), r"$\theta_0$", "(deg)")
    assert (axes.get_xlim()[0] < x.min(), axes.get_xlim()[1] > x.max()) == (True, True)


def test_lines_of_theory(atlas):
    """The analytic line is sqrt(g/3R); starts above the predicted line are stable, below it unstable."""
    axes = drawn(atlas)
    found = {line.get_label(): line.get_xydata().T for line in axes.get_lines()}
    (analytic,) = (
        line for label, line in found.items() if label.startswith(r"analytic: $\dot\phi = \sqrt{g/3R}$")
    )
    np.testing.assert_allclose(analytic[1], np.sqrt(9.81 / 1.5))
    (predicted,) = (line for label, line in found.items() if label.startswith("predicted, departure"))
    above = atlas.roll_rate > np.interp(np.degrees(atlas.tilt), *predicted)
    assert np.array_equal(above, atlas.stability == STABLE)


def test_circling_has_both_edges():
    """The curve k = 0 has a slow and a fast branch around the unstable starts."""
    words = ["precession_rate=uniform:0.1:6", "tilt=uniform:1deg:25deg", "samples=50", "method=exact"]
    axes = drawn(sweep.run(sweep.SweepSpec.from_words("circling", words)))
    assert sum(line.get_label().startswith("analytic") for line in axes.get_lines()) == 2
    assert len(with_facts(labels(axes), "analytic", "$k = 0$")) == 1


def test_one_parameter_has_vertical_lines():
    """The peak is plotted over the only parameter, with the critical and the predicted rate."""
    axes = drawn(sweep.run(SPEC.replace(tilt="1deg")))
    places = [line.get_xdata()[0] for line in axes.get_lines()]
    assert places[0] == pytest.approx(np.sqrt(9.81 / 1.5))
    assert axes.get_ylabel().startswith("peak tilt")


def test_no_line_where_a_third_parameter_varies():
    """With a third varying parameter the lines would be surfaces; the caption says what is not shown."""
    axes = drawn(sweep.run(SPEC.replace(alpha="uniform:0.4:1")))
    assert not axes.get_lines()
    assert_facts(labels(axes)[0], "alpha")


def test_words_below(atlas):
    """The text below has criterion, fixed parameters, and the share with its interval."""
    title, *names = labels(drawn(atlas))
    value, low, high = atlas.eulerdisk.unstable_share.percentages()
    assert_in_order(title, f"{value} %", "300", "unstable", "95 %", low, f"{high} %")
    assert r"$\alpha = 0.5$" in title
    assert names[:2] == ["stable", "unstable"]


def test_undecided_and_failed_starts_have_signs(atlas):
    """Undecided and failed starts are crosses and named in the legend."""
    changed = atlas.copy(deep=True)
    changed["stability"][:4] = UNDECIDED
    changed["ending"][:2] = ENDINGS.code("invalid")
    axes = drawn(changed)
    assert sorted(len(each.get_offsets()) for each in axes.collections) == [2, 2, 296]
    assert {"undecided", "failed"} <= {*labels(axes)}


def test_many_starts_are_thinned(atlas, monkeypatch):
    """Only as many points as can be distinguished are drawn, evenly from the list; the caption says so."""
    monkeypatch.setattr(scatter, "_MOST_POINTS", 100)
    axes = drawn(atlas)
    (points,) = axes.collections
    assert len(points.get_offsets()) == 100
    assert_facts(labels(axes)[0], "100 of 300 starts")


@pytest.mark.slow_lane
def test_selections_and_several_panels(atlas):
    """A selection can be drawn, and panels are side by side."""
    assert len(drawn(atlas.isel(start=slice(0, 10))).collections[0].get_offsets()) == 10
    figure = plots.figure([atlas] * 4)
    assert sum(axes.get_visible() for axes in figure.axes) == 4


def test_a_small_rate_is_not_squeezed():
    """A loguniform parameter has a logarithmic axis; a uniform one from zero has a linear axis."""
    log = drawn(sweep.run(SPEC.replace(tilt="loguniform:0.01deg:5deg")))
    linear = drawn(sweep.run(SPEC.replace(tilt="uniform:0:5deg")))
    assert (log.get_xscale(), linear.get_xscale()) == ("log", "linear")


def test_lists_and_grids_are_drawn_apart(atlas):
    """A list and a grid in one figure are refused."""
    grid = sweep.run(sweep.SweepSpec(roll_rate="2:4:5", tilt="1deg"))
    with refused("grids", "lists"):
        plots.figure([atlas, grid])


def test_a_map_of_a_list_is_refused(atlas):
    """Maps of regimes or losses are refused for lists, with or without a grid."""
    grid = sweep.run(sweep.SweepSpec(roll_rate="2:4:5", tilt="1deg:2deg:3"))
    for draw, option in ((plots.regimes, "--regimes"), (plots.losses, "--losses")):
        for datasets in ([atlas], [grid, atlas], [atlas, grid]):
            with refused(option, "list of starts"):
                draw(datasets, Look.read())


def test_figures_of_one_list_have_the_same_bytes(atlas, tmp_path):
    """Drawing twice gives the same file."""
    for name in ("a.png", "b.png"):
        plots.save(plots.figure([atlas]), tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_sizes_of_a_figure(atlas):
    """Width, height and letter size are as requested; options of maps are refused by name."""
    figure = plots.figure([atlas], look=Look.read(width="86mm", height="70mm", font_size=7))
    assert figure.get_size_inches() == pytest.approx([3.386, 2.756], abs=1e-3)
    assert figure.axes[0].xaxis.label.get_fontsize() == pytest.approx(7.0)
    for look in ({"family": True}, {"contours": "auto"}, {"quantity": "tilt_max"}, {"rate": "scaled"}):
        with refused(next(iter(look))):
            plots.figure([atlas], look=Look.read(**look))


def test_a_wide_figure_is_wider_than_high(atlas):
    """A page-wide figure is wider than high, because points need little height; in a column it is about square."""
    for width, low, high in (("172mm", 0.5, 0.75), ("86mm", 1.0, 1.4)):
        across, up = plots.figure([atlas], look=Look.read(width=width)).get_size_inches()
        assert low < up / across < high, width


def test_axes_of_a_caller(atlas):
    """A list is drawn into the given axes."""
    figure = Figure()
    axes = figure.add_subplot()
    assert plots.figure([atlas], axes=axes) is figure
    assert len(axes.collections) == 1
    with refused("ax", "one atlas"):
        plots.figure([atlas, atlas], axes=axes)
