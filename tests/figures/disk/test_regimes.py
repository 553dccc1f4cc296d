import numpy as np
import pytest
import referee
import xarray as xr
from messages import refused

import sweep
from sweep.figures import plots
from sweep.figures.disk.regimes import NAMES, figure, regimes
from sweep.figures.look import Look
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import PARAMETERS
from sweep.model.disk.theory import saddle_node_rates
from sweep.request.spec import SweepSpec

pytestmark = pytest.mark.compiled

#: An atlas with all four regimes and falls.
ALL = SweepSpec(
    title="Pushed: all regimes", roll_rate="0:4:30", tilt="1deg:40deg:25", tilt_rate=1.5, method="exact"
)
RELEASED = ALL.replace(tilt_rate=0.0, title="Released")


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas with all regimes."""
    return sweep.run(ALL)


@pytest.mark.slow_lane
def test_the_regimes_are_those_of_the_referees(atlas):
    """Crossings and falls agree with the tests' quadrature, and wells with the curve of folds."""
    found = regimes(atlas)
    given = [
        xr.broadcast(atlas[name], atlas.ending)[0].transpose(*atlas.ending.dims).values.ravel()
        for name in PARAMETERS
    ]
    truth = referee.extremes(np.array(given))
    assert np.array_equal(found.fell.ravel(), truth.fell)
    assert np.array_equal(found.regime.ravel() == -1, truth.fell)
    turns = ~truth.fell
    assert np.array_equal(
        found.regime.ravel()[turns] % 2 == 1, ((truth.least < 0.0) & (truth.greatest > 0.0))[turns]
    )
    fold = saddle_node_rates(atlas.tilt.values, "roll_rate", 0.5) * np.sqrt(9.81 / 0.5)
    two = atlas.roll_rate.values[:, None] < fold
    assert np.array_equal((found.regime >= 2)[~found.fell], two[~found.fell])
    assert set(np.unique(found.regime)) == {-1, 0, 1, 2, 3}
    assert not found.unknown.any()
    assert [name for name, cells in found.regions() if cells.any()] == [*NAMES, "falls"]


def test_the_way_it_was_computed_does_not_matter(atlas):
    """Method, duration, order of axes and selections do not change the regimes."""
    reference = regimes(atlas)
    for dataset in (
        sweep.run(ALL.replace(method="rk4", duration=0.1)),
        sweep.run(ALL.replace(axes=("tilt", "roll_rate"))),
        sweep.run(ALL.replace(alpha=[0.5, 0.7])).sel(alpha=0.5),
    ):
        found = regimes(dataset)
        assert np.array_equal(found.regime, reference.regime)
        assert np.array_equal(found.separatrix, reference.separatrix, equal_nan=True)
    part = regimes(atlas.isel(tilt=slice(3, 9), roll_rate=slice(2, 20)))
    assert np.array_equal(part.regime, reference.regime[2:20, 3:9])


def test_a_released_disk_stays_on_its_side():
    """A disk released at rest never crosses upright or passes a saddle: it can only fall outward and return."""
    found = regimes(sweep.run(RELEASED))
    assert set(np.unique(found.regime)) == {-1, 0, 2}
    assert not (found.separatrix < 0.0).any()


def test_the_curve_of_folds_is_drawn_where_there_is_one():
    """The curve of folds is drawn in the units of the axes, only in a plane of tilt and one rate."""
    for words, curves in (
        ({"roll_rate": "0:4:5", "tilt": "1deg:40deg:5"}, 1),
        ({"precession_rate": "0:4:5", "tilt": "1deg:40deg:5:log"}, 1),
        ({"roll_rate": "-4:4:5", "tilt": "-40deg:40deg:5"}, 2),
        # theory draws no line for a rolling and spinning disk or in other planes
        ({"roll_rate": "0:4:5", "tilt": "1deg:40deg:5", "precession_rate": 1.0}, 0),
        ({"roll_rate": "0:4:5", "alpha": "0.1:1:5", "tilt": "1deg"}, 0),
        ({"roll_rate": "steady", "tilt": "1deg:40deg:5", "precession_rate": "1:4:5"}, 0),
        ({"tilt_rate": "0:4:5", "tilt": "1deg:40deg:5"}, 0),
    ):
        found = regimes(sweep.run(SweepSpec(**words)))
        assert len(found.folds) == curves
        for i, (x, y) in enumerate(found.folds):
            axis = next(name for name in words if name != "tilt")
            rate = saddle_node_rates(np.radians(x), axis, 0.5) * np.sqrt(9.81 / 0.5)
            assert np.allclose(y, (1.0, -1.0)[i] * rate, rtol=1e-9)


@pytest.mark.slow_lane
def test_the_figure(atlas, tmp_path):
    """Each panel names every regime or has a legend, and both lines; the file depends only on the atlas."""
    drawn = figure([atlas, sweep.run(RELEASED)])
    pushed, released = (axes for axes in drawn.axes if axes.get_title(loc="left"))
    assert [axes.get_title(loc="left") for axes in (pushed, released)] == [
        "(a) Pushed: all regimes",
        "(b) Released",
    ]
    for axes, regions in ((pushed, {*NAMES, "falls"}), (released, {NAMES[0], NAMES[2], "falls"})):
        told = {text.get_text() for text in axes.texts}
        told |= {text.get_text().replace(", ", "\n") for text in axes.get_legend().get_texts()}
        assert regions <= told
        assert not ({*NAMES, "falls"} - regions) & told
    labels = [[text.get_text() for text in axes.get_legend().get_texts()] for axes in (pushed, released)]
    assert all(any(each.startswith("fold: ") for each in part) for part in labels)
    assert [any(each.startswith("separatrix: ") for each in part) for part in labels] == [True, False]
    for name in ("a.png", "b.png"):
        plots.save(figure([atlas]), tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_cells_without_a_motion_are_named_for_what_they_are():
    """A cell without a steady motion is marked as invalid, not as an unknown regime."""
    spec = SweepSpec(tilt="5deg:30deg:6", roll_rate="1:6:6", precession_rate="steady-slow", tilt_rate=1e-3)
    found = regimes(sweep.run(spec))
    assert found.unknown.any()
    assert found.lost == "invalid"
    told = [text.get_text() for text in figure([sweep.run(spec)]).axes[0].get_legend().get_texts()]
    assert "invalid" in told


def test_the_drawn_separatrix_is_where_the_saddle_is_just_reached(atlas):
    """On the drawn line, the height of the saddle above the energy is much smaller than next to it."""
    axes = next(axes for axes in figure([atlas]).axes if axes.get_title(loc="left"))
    lines = [line for line in axes.get_lines() if line.get_linestyle() == "--"]
    found = regimes(atlas)
    x, y = np.concatenate([line.get_xydata() for line in lines]).T
    inside = (x > 2.0) & (x < 39.0)
    given = {
        **{name: np.full(inside.sum(), 0.0) for name in PARAMETERS},
        "tilt": np.radians(x[inside]), "tilt_rate": np.full(inside.sum(), 1.5), "roll_rate": y[inside],
        "alpha": np.full(inside.sum(), 0.5), "radius": np.full(inside.sum(), 0.5),
        "gravity": np.full(inside.sum(), 9.81),
    }  # fmt: skip
    height = DISK.exact.measures(ALL, given)["separatrix"]
    assert inside.sum() > 10
    assert np.nanmax(np.abs(height)) < 0.03 * np.nanmax(np.abs(found.separatrix))


def test_what_is_no_map_is_refused():
    """An atlas with no, one or three axes, and an empty list, are refused with the reason."""
    for draw, facts in (
        (lambda: plots.regimes([], Look()), ["draw"]),
        (
            lambda: figure([sweep.run(SweepSpec(roll_rate="2:4:5", tilt="1deg"))]),
            ["two axes", "roll_rate"],
        ),
        (lambda: figure([sweep.run(SweepSpec(tilt="1deg"))]), ["single cell", "start:stop:count"]),
        (
            lambda: figure([sweep.run(SweepSpec(roll_rate="2:4:3", tilt="1deg,2deg", alpha="0.5,1"))]),
            ["3", "roll_rate, tilt, alpha"],
        ),
    ):
        with refused(*facts):
            draw()


def test_regimes_of_other_bodies(atlas):
    """A torus without a tube has the disk's regimes; a rim that falls onto its other edge is named as such."""
    torus = {"body": "torus", "tube": 0.0, "axial_moment": 0.5, "transverse_moment": 0.25}
    found, expected = regimes(sweep.run(ALL.replace(**torus))), regimes(atlas)
    assert np.array_equal(found.regime, expected.regime)
    assert not found.folds
    spec = SweepSpec(body="rim", thickness=0.4, tilt="2deg:50deg:8", roll_rate="0:6:8", precession_rate=1.0)
    rim = regimes(sweep.run(spec))
    assert rim.lost == "edge change"
    assert set(np.unique(rim.regime)) == {-1, 0}
