"""The map of losses: hues are the largest losses; strengths and lines are the stored times."""

import itertools

import lossy_runner
import matplotlib
import numpy as np
import pytest
from messages import assert_facts, refused, with_facts

import sweep
from sweep.figures import plots
from sweep.figures.disk.losses_map import COLOURS, figure, losses_map
from sweep.figures.look import Look
from sweep.model.lossy_disk.tables import LOSSES

pytestmark = pytest.mark.compiled

SPEC = sweep.SweepSpec.preset(
    "toy", contour_friction="0.3um:30um:12:log", tilt="50deg:89deg:10", precession_rate="wobble",
    rolling_friction="15um", criterion="departure:5deg", title="Which loss",
)  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def general():
    """Use the general kernels, so that none is compiled only for this file."""
    with lossy_runner.general_kernels():
        yield


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas in which rolling friction, contour friction and air are each the largest loss somewhere."""
    return sweep.run(SPEC)


def colours_of(drawn):
    """Return the colors of the cells of the first map, shape (rows, columns, 4)."""
    (mesh,) = (
        each for each in drawn.axes[0].collections if isinstance(each, matplotlib.collections.QuadMesh)
    )
    return np.asarray(mesh.get_array())


def test_the_hue_of_a_cell_is_its_largest_loss(atlas):
    """Each color is between white and the color of the largest stored loss."""
    found, cells = losses_map(atlas), colours_of(figure([atlas]))
    largest = np.stack([atlas[measure].values for _, measure in LOSSES.values()]).argmax(axis=0)
    np.testing.assert_array_equal(found.loss, 1 + largest)
    hues = np.array([matplotlib.colors.to_rgb(COLOURS[measure]) for _, measure in LOSSES.values()])
    away = 1.0 - cells[..., :3]
    for row, column in np.ndindex(found.loss.shape):
        whole = 1.0 - hues[largest[row, column]]
        strength = away[row, column].max() / whole.max()
        assert 0.15 < strength < 1.0
        np.testing.assert_allclose(away[row, column], strength * whole, atol=1e-12)
    assert {name for name, _ in found.regions()} == {"rolling\nfriction", "contour\nfriction", "air"}


@pytest.mark.parametrize("width", ["86mm", "70mm", "172mm"])
def test_names_and_numbers_lie_apart(atlas, width):
    """The names of the losses do not cover the numbers on the lines of equal time."""
    drawn = figure([atlas], Look.read(width=width))
    drawn.draw_without_rendering()
    words = [(each.get_text(), each.get_window_extent()) for each in drawn.axes[0].texts]
    assert len(words) >= 4
    for (one, box), (other, beside) in itertools.combinations(words, 2):
        assert not box.overlaps(beside), (one, other)


def test_the_longer_aloft_the_stronger_the_hue(atlas):
    """Among the cells of one law, stronger hues mean longer times."""
    found, cells = losses_map(atlas), colours_of(figure([atlas]))
    np.testing.assert_array_equal(found.times, atlas["end_time"].values)
    for code in np.unique(found.loss):
        some = found.loss == code
        order = np.argsort(found.times[some])
        assert (np.diff((1.0 - cells[..., :3]).max(axis=-1)[some][order]) >= 0.0).all()


def test_the_shortest_time_is_faint_and_the_longest_strong(atlas):
    """The strengths span the whole bar, because a uniformly faint map would hide the losses."""
    found, cells = losses_map(atlas), colours_of(figure([atlas]))
    for place, strength in ((found.times.argmin(), 0.18), (found.times.argmax(), 0.95)):
        row, column = np.unravel_index(place, found.times.shape)
        hue = matplotlib.colors.to_rgb(COLOURS[list(LOSSES.values())[found.loss[row, column] - 1][1]])
        np.testing.assert_allclose(1.0 - cells[row, column, :3], strength * (1.0 - np.array(hue)), rtol=1e-12)
        assert cells[row, column, 3] == 1.0


def test_the_lines_have_the_times_that_they_name(atlas):
    """Along each line, the interpolated time equals its level."""
    drawn = figure([atlas])
    axes = drawn.axes[0]
    (lines,) = (each for each in axes.collections if isinstance(each, matplotlib.contour.QuadContourSet))
    assert 2 <= len(lines.levels) <= 6
    assert {text.get_text() for text in lines.labelTexts} <= {f"{level:g} s" for level in lines.levels}
    times, panel = atlas["end_time"].values, losses_map(atlas).panel
    for level, segments in zip(lines.levels, lines.allsegs, strict=True):
        for x, y in (point for segment in segments for point in segment):
            column, row = np.searchsorted(panel.x.values, x), np.searchsorted(panel.y.values, y)
            around = times[max(row - 1, 0) : row + 1, max(column - 1, 0) : column + 1]
            assert around.min() <= level * (1.0 + 1e-9)
            assert around.max() >= level * (1.0 - 1e-9)


@pytest.mark.slow_lane
def test_where_the_duration_ended_it_cells_are_hatched_and_have_no_lines(atlas):
    """Cells still aloft at the end have only a lower bound; cells that lift off have no time aloft."""
    short = sweep.run(SPEC, duration="5s")
    found = losses_map(short)
    assert found.ended["horizon"].any()
    np.testing.assert_array_equal(found.ended["horizon"], short["end_time"].values == 5.0)
    axes = figure([short]).axes[0]
    # with these motions, there would be lines at the duration itself
    for lines in (each for each in axes.collections if isinstance(each, matplotlib.contour.QuadContourSet)):
        assert max(lines.levels) < 5.0
    assert with_facts(axes.get_legend_handles_labels()[1], "aloft", "duration")
    lifted = sweep.run("toy", tilt="35deg,45deg", precession_rate="105,110")
    slid = losses_map(sweep.run("toy", tilt="60deg,70deg", precession_rate="20,30", friction=0.02))
    assert slid.ended["slip"].all()
    assert np.isnan(slid.times).all()
    assert losses_map(lifted).ended["lift_off"].all()
    assert np.isnan(losses_map(lifted).times).all()
    figure([lifted])


@pytest.mark.slow_lane
def test_several_atlases_share_one_scale(atlas):
    """One bar is valid for several atlases: equal times have equal strength."""
    short = sweep.run(SPEC, duration="5s")
    drawn = figure([atlas, short])
    titles = [f"(a) {atlas.title}", f"(b) {short.title}"]
    assert [axes.get_title(loc="left") for axes in drawn.axes[:2]] == titles
    bar = drawn.axes[-1]
    assert_facts(bar.get_ylabel(), "aloft", "(s)")
    times = np.concatenate([atlas["end_time"].values.ravel(), short["end_time"].values.ravel()])
    assert bar.get_ylim() == pytest.approx((times.min(), times.max()))


def test_a_selection_and_the_order_of_the_axes_do_not_matter(atlas):
    """A transposed atlas is drawn transposed; a third axis needs one selected value."""
    other = sweep.run(SPEC.replace(axes=("contour_friction", "tilt")))
    one, two = losses_map(atlas), losses_map(other)
    same = one.panel.y.quantity.name == two.panel.y.quantity.name
    np.testing.assert_array_equal(one.times, two.times if same else two.times.T)
    three = sweep.run(SPEC.replace(alpha=[0.4, 0.5]))
    np.testing.assert_array_equal(losses_map(three.sel(alpha=0.5)).times, one.times)


def test_what_has_no_losses_or_no_two_axes_is_refused(atlas):
    """An atlas without losses, one with a single axis and an empty list are refused."""
    with refused("disk", "losses"):
        plots.losses([sweep.run(sweep.SweepSpec(roll_rate="2:3:3", tilt="1deg,2deg"))], Look())
    with refused("two axes", "one", "tilt"):
        plots.losses([atlas.isel(contour_friction=3)], Look())
    with refused("end_time"):
        figure([atlas.drop_vars("end_time")])
    with refused("atlas"):
        plots.losses([], Look())


def test_the_command_draws_it(command, atlas, tmp_path):
    """`plot --losses` draws the map and refuses a criterion and other quantities."""
    sweep.save(atlas, tmp_path / "toy.nc")
    assert command("plot toy.nc --losses -o toy.png")[0] == 0
    assert (tmp_path / "toy.png").stat().st_size > 10_000
    for option in ("--criterion aloft:2s", "--regimes", "--quantity steps", "--family"):
        status, _, err = command(f"plot toy.nc --losses {option} -o other.png")
        assert status == 2
        assert option.split()[0] in err
    assert not (tmp_path / "other.png").exists()


def test_arms_are_shown_in_micrometres(atlas):
    """Friction arms are in micrometers on the axis and in the caption; the radius is in millimeters."""
    axes = figure([atlas]).axes[0]
    assert_facts(axes.get_xlabel(), "$c_c$", "(\u00b5m)")
    np.testing.assert_allclose(axes.get_xlim(), losses_map(atlas).panel.x.borders[[0, -1]])
    np.testing.assert_allclose(losses_map(atlas).panel.x.values, 1e6 * atlas["contour_friction"].values)
    caption = losses_map(atlas).caption[0]
    assert "$c_r = 15$\u00a0\u00b5m" in caption
    assert "$R = 37.55$\u00a0mm" in caption
    assert r"$\mu = 1.8\times 10^{-5}$" in caption
