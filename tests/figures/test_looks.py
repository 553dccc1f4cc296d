"""Options of a figure: quantities, contour lines, the caller's axes, maps of more than two axes."""

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import QuadMesh
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from messages import assert_facts, refused, with_facts

import sweep
from sweep.figures import plots
from sweep.figures.look import Look
from sweep.figures.panels import panel
from sweep.figures.shade import variables_of_cells
from sweep.files.reading import opened
from sweep.model.disk.model import DISK
from sweep.model.quantity import FAILED

pytestmark = pytest.mark.compiled

PLAIN = sweep.SweepSpec(roll_rate="0:4:22", tilt="0.1deg:30deg:16", tilt_rate=1.5)
NB = "\u00a0"
CUBE = sweep.SweepSpec(roll_rate="2:4:21", tilt="0.1deg:2deg:8", alpha="0.2,0.5,1")


@pytest.fixture(scope="module")
def plain():
    """Return an atlas of two axes, in which some cells fall."""
    return sweep.run(PLAIN)


@pytest.fixture(scope="module")
def cube():
    """Return an atlas of three axes."""
    return sweep.run(CUBE)


def draw(atlas, **words):
    """Return a figure of an atlas with these look options."""
    return plots.figure([atlas], look=Look.read(**words))


def mesh(axes):
    """Return the colored mesh of a map."""
    return next(each for each in axes.collections if isinstance(each, QuadMesh))


def told(drawn):
    """Return the lines of the legends of a figure."""
    legends = [axes.get_legend() for axes in drawn.axes]
    return [text.get_text() for legend in legends if legend for text in legend.get_texts()]


def maps(drawn):
    """Return the axes with a map, or other axes with a title."""
    return [axes for axes in drawn.axes if axes.get_title(loc="left")]


def test_no_number_of_a_failed_cell_is_drawn(plain):
    """Numbers of failed cells have no color, except their error estimate."""
    failed = next(each.code for each in DISK.endings if each.role == FAILED)
    place = {"roll_rate": 3, "tilt": 4}
    changed = plain.copy(deep=True)
    changed["ending"][place] = failed
    for name, is_drawn in (("peak_tilt", False), ("tilt_error", True)):
        changed[name][place] = 0.25
        shade = panel(changed, look=Look(quantity=name)).shade
        assert np.isfinite(shade.values[3, 4]) == is_drawn, name


@pytest.mark.release
def test_any_number_of_the_cells_is_drawn(plain):
    """Any variable that is not a flag can be drawn, in the bar's unit; missing values are hatched."""
    for name in variables_of_cells(plain):
        if name in ("ending", "stability"):
            continue
        drawn = draw(plain, quantity=name)
        values = plain[name].transpose("roll_rate", "tilt").values * (
            np.degrees(1.0) if plain[name].units == "rad" else 1.0
        )
        shown = np.ma.masked_array(mesh(drawn.axes[0]).get_array())
        known = np.isfinite(values)
        assert (~np.ma.getmaskarray(shown) == known).all(), name
        # on a logarithmic scale, zero has the first color
        norm = mesh(drawn.axes[0]).norm
        np.testing.assert_allclose(shown[known], values[known].clip(norm.vmin, norm.vmax), rtol=1e-6)
        if known.any():
            assert name.replace("_", " ") in drawn.axes[-1].get_ylabel().replace("\n", " ")
        assert (f"no {name.replace('_', ' ')}" in told(drawn)) == bool((~known).any())


@pytest.mark.slow_lane
def test_numbers_are_logarithmic_where_they_span_decades(plain):
    """Errors span decades and get a logarithmic scale; fall times do not, and tilts of both signs cannot."""
    names = ("tilt_min", "fall_time", "energy_drift")
    found = [type(mesh(draw(plain, quantity=name).axes[0]).norm).__name__ for name in names]
    assert found == ["Normalize", "Normalize", "LogNorm"]


def test_flags_have_colours_and_names(plain):
    """Each flag has its own color, distinguishable in gray, and a legend entry."""
    drawn = draw(plain, quantity="ending")
    colours = mesh(drawn.axes[0])
    present = np.unique(plain["ending"].values)
    assert len(present) > 1
    grey = [float(np.dot(colours.cmap(colours.norm(code))[:3], (0.299, 0.587, 0.114))) for code in present]
    assert np.abs(np.diff(grey)).min() > 0.2
    assert {"ending: bounded", "ending: fell"} <= set(told(drawn))
    assert len(drawn.axes) < 4


def test_a_flag_of_one_axis_has_its_names_on_the_axis(plain):
    """A profile of endings has a step for each, with names in place of numbers."""
    axes = draw(plain.isel(tilt=-1), quantity="ending").axes[0]
    assert {label.get_text() for label in axes.get_yticklabels()} == {"bounded", "fell"}


@pytest.mark.slow_lane
def test_contour_lines_run_where_the_quantity_has_their_levels(plain):
    """Along each contour line the quantity equals its level, which the color bar and the legend name."""
    drawn = draw(plain, contours="25deg,60deg")
    lines = next(each for each in drawn.axes[0].collections if isinstance(each, QuadContourSet))
    np.testing.assert_allclose(lines.levels, [25.0, 60.0], rtol=1e-12)
    peak = np.degrees(plain["peak_tilt"])
    for level, path in zip((25.0, 60.0), lines.get_paths(), strict=True):
        tilt, rate = path.vertices.T
        at = peak.interp(tilt=("n", np.radians(tilt)), roll_rate=("n", rate))
        np.testing.assert_allclose(at, level, rtol=1e-6)
    assert with_facts(told(drawn), "peak tilt", "25, 60 deg")
    on_bar = sorted(float(each.get_ydata()[0]) for each in drawn.axes[-1].get_lines())
    np.testing.assert_allclose(on_bar, [25.0, 60.0], rtol=1e-12)
    many = draw(plain, contours="auto").axes[0].collections
    many = draw(plain, contours="auto").axes[0].collections
    automatic = next(each for each in many if isinstance(each, QuadContourSet))
    assert 2 <= len(automatic.levels) <= 12


@pytest.mark.slow_lane
def test_bad_looks_are_refused(plain):
    """Bad looks are refused with the bad word and the valid ones."""
    for words, facts in (
        ({"rate": "sqared"}, ["rate", "linear", "squared", "scaled", "speed", "sqared", "squared?"]),
        ({"quantity": "peak_tlt"}, ["quantity", "peak_tlt", "ending", "peak_tilt?"]),
        ({"quantity": "roll_rate"}, ["quantity", "roll_rate", "ending"]),
        ({"width": "0mm"}, ["width", "20 mm", "2 m", "0mm"]),
        ({"width": "nan"}, ["width=nan", "finite"]),
        ({"width": float("inf")}, ["width=inf", "finite"]),
        ({"height": "8"}, ["height", "20 mm", "2 m", "8"]),
        ({"height": "3kg"}, ["height=3kg", "kg", "m", "cm", "inch"]),
        ({"font_size": float("nan")}, ["font size", "4", "40", "nan"]),
        ({"font_size": "8pt"}, ["font_size=8pt", "pt", "pure number"]),
        ({"font_size": True}, ["font size", "4", "40", "True"]),
        ({"without": "bar, strip"}, []),
        ({"without": ("bar", " strip")}, []),
        ({"without": 5}, ["title", "caption", "legend", "strip", "bar", "5"]),
        ({"without": ["bar", 5]}, ["title", "bar", "5"]),
        ({"dpi": 0}, ["dpi", "10", "2400", "0"]),
        ({"dpi": 99.5}, ["dpi", "99.5"]),
        ({"contours": "25deg,"}, []),
        ({"contours": "nan"}, ["contours=nan", "finite"]),
        ({"contours": "5m"}, ["contours=5m", "m", "deg", "rad"]),
        ({"contours": "5"}, ["286.5 deg", "rad"]),
        ({"contours": "1deg:60deg:40"}, ["contour", "1", "12", "40"]),
        ({"contours": "1", "quantity": "ending"}, ["ending", "flag"]),
        ({"family": True}, ["three axes", "roll_rate, tilt"]),
        ({"family": True, "quantity": "steps"}, ["family", "quantity"]),
    ):
        if not facts:
            assert draw(plain, **words).axes
            continue
        with refused(*facts):
            draw(plain, **words)


@pytest.mark.slow_lane
def test_a_map_for_each_value_of_a_further_axis(cube, tmp_path):
    """A further axis gives three maps with one color scale, one per slice, from memory and from a file."""
    sweep.save(cube, tmp_path / "cube.nc")
    with opened(tmp_path / "cube.nc", indexed=False) as file:
        from_file = draw(file)
    for drawn in (draw(cube), from_file):
        assert [axes.get_title(loc="left") for axes in maps(drawn)] == [
            r"$\alpha = 0.2$", r"$\alpha = 0.5$", r"$\alpha = 1$",
        ]  # fmt: skip
        for i, axes in enumerate(maps(drawn)):
            expected = np.degrees(cube["peak_tilt"].isel(alpha=i).transpose("roll_rate", "tilt").values)
            np.testing.assert_allclose(mesh(axes).get_array(), expected, rtol=1e-12)
            theory = float(cube["critical_roll_rate"].isel(alpha=i, tilt=0))
            line = next(each for each in axes.get_lines() if str(each.get_label()).startswith("analytic"))
            np.testing.assert_allclose(line.get_ydata(), theory, rtol=1e-12)
        assert len({mesh(axes).norm for axes in maps(drawn)}) == 1
        # all maps share one legend with the same formula
        assert with_facts(told(drawn), "analytic", r"$\dot\phi = \sqrt{g/[2(1{+}\alpha)R]}$")


def test_a_family_of_boundaries_is_one_panel(cube):
    """Each slice's boundary is a curve with its own marker, color and legend entry."""
    drawn = draw(cube, family=True)
    [axes] = maps(drawn)
    sets = [each for each in axes.containers if hasattr(each, "has_yerr")]
    assert len(sets) == 3
    for i, each in enumerate(sets):
        edge = cube["boundary_roll_rate"].isel(alpha=i).dropna("tilt")
        x, y = each[0].get_data()
        np.testing.assert_allclose(x, np.degrees(edge.tilt), rtol=1e-12)
        np.testing.assert_allclose(y, edge, rtol=1e-12)
    assert len({(each[0].get_marker(), each[0].get_color().__str__()) for each in sets}) == 3
    assert [line for line in told(drawn) if line.startswith(r"$\alpha")] == [
        "$\\alpha = 0.2$", "$\\alpha = 0.5$", "$\\alpha = 1$",
    ]  # fmt: skip
    assert_facts(axes.get_legend().get_title().get_text(), "stable above", "unstable below")


def test_too_many_maps_are_refused_with_their_number(cube):
    """Too many maps or curves are refused with their number and a selection to make."""
    many = sweep.run(CUBE.replace(alpha="0.1:1:13", roll_rate="2:4:3", tilt="1deg,2deg"))
    with refused("alpha", "13", "12", "alpha=0.1"):
        draw(many)
    with refused("13 curves", "8", "alpha=0.1"):
        draw(many, family=True)
    with refused("2 atlases"):
        plots.figure([cube, cube])


def test_scaled_rates_of_unlike_disks_meet():
    """In units of sqrt(g/R), all radii have the same critical line, and each map ends with its own cells."""
    atlas = sweep.run(sweep.SweepSpec(roll_rate="2:8:9", tilt="0.1deg,1deg", radius="0.1,0.5"))
    drawn = draw(atlas, rate="scaled")
    heights, ends = [], []
    for axes in maps(drawn):
        line = next(each for each in axes.get_lines() if str(each.get_label()).startswith("analytic"))
        heights.append(float(line.get_ydata()[0]))
        ends.append(axes.get_ylim())
    np.testing.assert_allclose(heights, 3.0**-0.5, rtol=1e-12)
    # so each has its own numbers
    assert ends[0] != ends[1]
    assert all(axes.yaxis.get_tick_params()["labelleft"] for axes in maps(drawn))
    # a single map over both has no such axis
    with refused("rate=scaled", "roll_rate", "linear", "squared"):
        draw(atlas.isel(tilt=0), rate="scaled")


@pytest.mark.slow_lane
def test_a_rate_is_drawn_as_the_speed_of_the_contact_point():
    """As a speed, rate times radius, upright rolling is stable above sqrt(g R / 3); the legend has the number."""
    for radius, unit, factor in (("0.01mm", "mm", 1e3), ("11.6mm", "cm", 1e2), ("0.5m", "m", 1.0)):
        spec = sweep.SweepSpec.preset("rolling", radius=radius).replace(tilt="0.1deg:1deg:8")
        atlas = sweep.run(spec)
        drawn = draw(atlas, rate="speed")
        [axes] = maps(drawn)
        critical = factor * np.sqrt(9.81 * spec.radius / 3.0)
        line = next(each for each in axes.get_lines() if str(each.get_label()).startswith("analytic"))
        np.testing.assert_allclose(line.get_ydata(), critical, rtol=1e-12)
        label = axes.get_ylabel().replace("\n", " ")
        assert label == rf"speed $R\dot\phi_0$ ({unit} s$^{{-1}}$)"
        assert f"={NB}{critical:.4g}{NB}{unit}{NB}s$^{{-1}}$" in str(line.get_label())
        rows = mesh(axes).get_coordinates()[:, 0, 1]
        np.testing.assert_allclose(
            0.5 * (rows[1:] + rows[:-1]), factor * spec.radius * atlas["roll_rate"].values, rtol=1e-9
        )
        other = axes.child_axes[0]
        drawn.draw_without_rendering()
        np.testing.assert_allclose(
            other.get_ylim(), np.array(axes.get_ylim()) / critical / 3.0**0.5, rtol=1e-9
        )
        along = draw(atlas.isel(tilt=2), rate="speed").axes[0]
        assert along.get_xlabel().replace("\n", " ") == label
        family = draw(sweep.run(spec.replace(alpha="0.2,1")), rate="speed", family=True)
        assert family.axes[0].get_ylabel().replace("\n", " ") == label


def test_what_is_no_speed_is_refused():
    """Only the roll rate can be drawn as a speed, and only if all cells have the same radius."""
    spinning = sweep.run(sweep.SweepSpec(precession_rate="3:6:3", tilt="1deg,2deg"))
    with refused("rate=speed", "roll_rate", "precession_rate"):
        draw(spinning, rate="speed")
    radii = sweep.run(sweep.SweepSpec(roll_rate="2:8:3", tilt="0.1deg,1deg", radius="0.1,0.5"))
    for words in ({}, {"family": True}):
        with refused("rate=speed", "radius"):
            draw(radii, rate="speed", **words)
    with refused("rate=speed", "radius"):
        draw(radii.isel(tilt=0), rate="speed")
    with refused("rate", "speed", "tilt"):
        draw(sweep.run(sweep.SweepSpec(tilt="1deg:2deg:3")), rate="speed")


def own_axes():
    """Return axes of the caller's own figure."""
    with matplotlib.rc_context({"font.size": 10.0}):
        figure = Figure(figsize=(9, 5), layout="constrained")
        FigureCanvasAgg(figure)
        return figure.subplots(1, 2)


@pytest.mark.slow_lane
def test_a_map_is_drawn_into_axes_of_a_caller(plain, cube):
    """`plot(ax=...)` returns the caller's figure with map, bar and legend, and leaves other axes unchanged."""
    before = dict(matplotlib.rcParams)
    ax, other = own_axes()
    drawn = plain.eulerdisk.plot(ax=ax, quantity="amplification", contours="auto", rate="scaled")
    assert drawn is ax.figure
    assert mesh(ax)
    assert ax.get_legend() is not None
    assert not other.has_data()
    assert len(drawn.axes) == 3
    assert dict(matplotlib.rcParams) == before
    assert cube.eulerdisk.plot(ax=other, family=True) is drawn
    drawn.draw_without_rendering()
    below = ax.get_legend().get_window_extent()
    assert below.y1 <= ax.get_window_extent().y0
    assert below.y0 >= 0.0


def test_what_axes_of_a_caller_cannot_hold_is_refused(cube):
    """A size and several maps are refused for one given axes, which stays empty."""
    for words, facts in (
        ({"width": "86mm"}, ["ax", "width"]),
        ({"dpi": 300, "height": 0.1}, ["ax", "height", "dpi"]),
        ({}, ["ax", "3 axes", "roll_rate, tilt, alpha", "family=True"]),
    ):
        ax, _ = own_axes()
        with refused(*facts):
            cube.eulerdisk.plot(ax=ax, **words)
        assert not ax.has_data()


def test_a_motion_has_none_of_these_looks():
    """The figure of a motion refuses each option of a map by name."""
    motion = sweep.simulate(sweep.TrajectorySpec.read(tilt_rate=0.01, roll_rate=3, duration=0.1))
    assert motion.eulerdisk.plot().axes
    with refused("rate", "contours", "motion"):
        motion.eulerdisk.plot(rate="scaled", contours=np.array([1.0, 2.0]))


@pytest.mark.slow_lane
def test_many_maps_fit_a_column_of_a_journal():
    """Five maps fit side by side in pairs in 86 mm and on a page; a higher figure is refused with a hint."""
    atlas = sweep.run(sweep.SweepSpec(roll_rate="2:4:9", tilt="0.1deg:2deg:5", alpha="0.2:1:5"))
    drawn = draw(atlas, width="86mm")
    assert len({round(axes.get_position().x0, 3) for axes in maps(drawn)}) == 2
    assert drawn.get_size_inches()[1] * 25.4 < 200.0
    many = sweep.run(sweep.SweepSpec(roll_rate="2:4:3", tilt="1deg,2deg", alpha="0.1:1:12"))
    with refused("12 maps", "60 mm", "671 mm", "297 mm", "width"):
        draw(many, width="60mm")


def test_cells_end_within_what_a_parameter_allows():
    """At alpha = 1, the hoop, the cells end; the cells of 0.5 extend half way to the next on both sides."""
    atlas = sweep.run(sweep.SweepSpec(roll_rate="2:4:5", tilt="1deg", alpha="0.5,1"))
    [axes] = maps(draw(atlas))
    np.testing.assert_allclose(mesh(axes).get_coordinates()[0, :, 0], [0.25, 0.75, 1.0], rtol=1e-15)
    assert axes.get_xlim() == (0.25, 1.0)
    radii = sweep.run(sweep.SweepSpec(roll_rate="2:4:5", tilt="1deg", radius="0.1,0.5"))
    assert 0.0 < maps(draw(radii))[0].get_xlim()[0] < 1e-12


@pytest.mark.release
def test_a_bar_of_colours_has_three_numbers_or_its_ends():
    """A color bar has at least three numbers or numbers at its ends, because one number would be useless."""
    for own in (False, True):
        # in the last one, 1, 2 and 5 times powers of ten would leave one number
        for rates, tilt in (
            ("2.5:2.9:6", "2deg:3deg:5"), ("2.5:2.9:6", "3deg:3.1deg:5"), ("6:7:3", "2.2deg:9.5deg:5"),
        ):  # fmt: skip
            atlas = sweep.run(sweep.SweepSpec(roll_rate=rates, tilt=tilt))
            drawn = atlas.eulerdisk.plot(ax=own_axes()[0]) if own else draw(atlas, width="86mm")
            drawn.draw_without_rendering()
            bar = next(axes for axes in drawn.axes if "peak" in axes.get_ylabel() + axes.get_xlabel())
            axis = bar.yaxis if bar.get_ylabel() else bar.xaxis
            low, high = axis.get_view_interval()
            numbers = [each for each in axis.get_majorticklocs() if low <= each <= high]
            assert len(numbers) >= 3 or {low, high} <= set(numbers)


def test_number_and_unit_of_the_line_stay_together():
    """In a narrow figure, the legend breaks before the number or not at all."""
    drawn = draw(sweep.run(PLAIN.replace(tilt_rate=0.0)), width="70mm")
    [entry] = [
        each.get_text()
        for axes in drawn.axes
        if (legend := axes.get_legend())
        for each in legend.get_texts()
        if each.get_text().startswith("analytic")
    ]
    assert entry.split("\n")[-1].endswith("=\u00a02.557\u00a0rad\u00a0s$^{-1}$")
