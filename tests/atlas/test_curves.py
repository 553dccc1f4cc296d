"""Boundary curves: every grid edge between unlike cells gives a point, and the points are joined correctly.

An atlas with curves is drawn, compared and exported like one without.
"""

import subprocess
import sys
from unittest import mock

import boundary_referee as referee
import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from messages import assert_facts, missing

import sweep
from sweep.atlas import boundary
from sweep.atlas import curves as curve_module
from sweep.atlas.cf_metadata import CURVES, POINTS
from sweep.atlas.curves import Curves
from sweep.checks.compare import compare
from sweep.checks.comparison_report import in_words
from sweep.figures import plots
from sweep.figures.disk import regimes as regimemap
from sweep.files.export import export
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE


class Drawn:
    """Boundary curves with all their points, bisected to a width."""

    def __init__(self, lines, width):
        self.counts, self.closed = lines.counts, lines.closed
        self.points = lines.measured(width)
        self.halfwidths = self.points.halfwidths

    def places(self, axis):
        """Return the coordinates of the points along an axis."""
        return self.points.along(axis)[0]

    def widths(self, axis):
        """Return the half-widths of the points along an axis."""
        return self.points.along(axis)[1]


def curves_of(spec, stability, width):
    """Return the curves of a grid in memory."""
    return Drawn(Curves(spec, stability), width)


@pytest.fixture
def drawn(monkeypatch):
    """Return a function that draws the curves of a rule, not of a motion, on a grid of (tilt, roll rate)."""

    def draw(rule, count=41, width=1e-9, **more):
        spec = sweep.SweepSpec(tilt=f"-1:1:{count}", roll_rate=f"-1:1:{count + 1}", **more)

        def judge(given):
            return np.where(rule(given["tilt"], given["roll_rate"]), UNSTABLE, STABLE).astype(np.int8)

        monkeypatch.setattr(boundary, "judged", lambda spec, given: judge(given))
        tilt, rate = np.meshgrid(spec.tilt.array(), spec.roll_rate.array(), indexing="ij")
        return spec, curves_of(spec, judge({"tilt": tilt, "roll_rate": rate}), width)

    return draw


def test_a_disk_has_one_closed_curve(drawn):
    """An unstable disk of radius 0.7 has one closed curve; every point is on the circle within its half-width."""
    _, found = drawn(lambda x, y: x**2 + y**2 < 0.49)
    assert found.closed.tolist() == [True]
    x, y = found.places("tilt"), found.places("roll_rate")
    # across the circle, a half-width along an axis counts at most with its full length
    assert np.hypot(x, y) == pytest.approx(0.7, abs=1e-9)
    angle = np.unwrap(np.arctan2(y, x))
    assert abs(angle[-1] - angle[0]) == pytest.approx(2.0 * np.pi, abs=0.2)
    assert (np.diff(angle) > 0).all() or (np.diff(angle) < 0).all()
    on_grid = (found.widths("tilt") == 0.0) != (found.widths("roll_rate") == 0.0)
    assert on_grid.all()
    assert found.halfwidths.max() <= 0.5e-9


def test_islands_and_a_curve_that_leaves_the_grid(drawn):
    """Two islands and a strip along the border are two closed curves and an open one that ends on the border."""

    def rule(x, y):
        return (np.hypot(x - 0.3, y) < 0.2) | (np.hypot(x + 0.5, y + 0.1) < 0.15) | (y > 0.6 + 0.2 * x)

    _, found = drawn(rule)
    assert sorted(found.closed.tolist()) == [False, True, True]
    start = np.concatenate(([0], np.cumsum(found.counts)))
    (at,) = np.flatnonzero(~found.closed)
    ends = found.places("tilt")[[start[at], start[at + 1] - 1]]
    assert sorted(ends) == [-1.0, 1.0]


@pytest.mark.parametrize(("sign", "closed"), [(1, 2), (-1, 1)])
def test_the_middle_of_a_square_decides_what_belongs_together(drawn, sign, closed):
    """In a square with alternating corners, the start at its middle distinguishes an hourglass from two islands."""
    reach = 0.05

    def rule(x, y):
        # unstable quadrants near the middle (0.025, 0), joined there or separate
        apart = (x - 0.025) * (y - 0.0) > (-1e-4 if sign < 0 else 1e-4)
        return apart & (np.hypot(x - 0.025, y) < 8 * reach)

    _, found = drawn(rule, count=41)
    assert found.closed.all()
    assert len(found.counts) == closed


def test_undecided_cells_end_a_curve():
    """No point is next to an undecided cell, and the curve is open there."""
    spec = sweep.SweepSpec(tilt="0.01:0.04:4", roll_rate="2:3:3", boundary="refined:1e-3")
    stability = np.array([[2, 2, 1], [2, 2, 1], [2, 0, 1], [2, 2, 1]], np.int8)
    assert stability[2, 1] == UNDECIDED
    found = curves_of(spec, stability, 1.0)
    assert sorted(found.counts.tolist()) == [1, 2]
    assert not found.closed.any()


def test_a_third_axis_makes_a_plane_each(drawn):
    """In a grid of three axes, every value of the first axis has its own plane of curves."""
    spec = sweep.SweepSpec(alpha="0.5,1", tilt="-1:1:5", roll_rate="2:3:3")
    stability = np.full(spec.shape, STABLE, np.int8)
    stability[:, 2, 1] = UNSTABLE
    found = curves_of(spec, stability, 1.0)
    assert found.counts.tolist() == [4, 4]
    assert found.closed.all()
    assert found.places("alpha").tolist() == [0.5] * 4 + [1.0] * 4


@pytest.mark.compiled
def test_curves_in_a_file(tmp_path):
    """A refined boundary is written as a ragged array, identically from memory and block by block."""
    spec = sweep.SweepSpec.preset("circling").replace(
        tilt="2deg:25deg:12", precession_rate="0.2:5:31", boundary="refined"
    )
    sweep.save(sweep.run(spec), tmp_path / "memory.nc")
    sweep.run_to_file(spec, tmp_path / "blocks.nc")
    with sweep.open_atlas(tmp_path / "memory.nc") as one, sweep.open_atlas(tmp_path / "blocks.nc") as other:
        assert one.equals(other)
        assert one.curve_point_count.attrs["sample_dimension"] == "curve_point"
        assert int(one.curve_point_count.sum()) == one.sizes["curve_point"]
        assert one.curve_tilt.attrs["units"] == "rad"
        # the dome closes above 18.62 deg (theory.md), a little later for ten times the kick: its curve leaves
        # the grid only at the smallest tilt and rate
        (count,), closed = one.curve_point_count.values, bool(one.curve_closed[0])
        assert not closed
        assert count == one.sizes["curve_point"]
        assert one.curve_precession_rate.values[0] == 0.2
        assert one.curve_tilt.values[-1] == spec.tilt.start
        assert 18.0 < np.degrees(one.curve_tilt.values.max()) < 19.0


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_the_command_refines_a_file(tmp_path):
    """`boundary --refine` prints the refined rows and writes them to a new file; a width of 0 is refused."""
    spec = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:9", tilt="0.001deg:1deg:3:log")
    sweep.run_to_file(spec, tmp_path / "a.nc")
    command = [sys.executable, "-m", "sweep", "boundary", "a.nc", "--refine"]
    done = subprocess.run(
        [*command, "1e-9", "-o", "b.nc"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    with sweep.open_atlas(tmp_path / "b.nc") as atlas:
        assert float(atlas.boundary_roll_rate_halfwidth.max()) <= 0.5e-9
        assert f"{float(atlas.boundary_roll_rate[0]):.8f}"[:10] in done.stdout
    refused = subprocess.run([*command, "0"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert_facts(refused.stderr, "refined:WIDTH")


AXES = ("gravity", "alpha", "tilt", "roll_rate")


@st.composite
def grids(draw):
    """Draw a grid of two to four axes: noise, or few undecided cells and many squares with alternating corners."""
    shape = draw(array_shapes(min_dims=2, max_dims=4, max_side=6))
    codes = draw(
        st.sampled_from(((UNDECIDED, STABLE, UNSTABLE), (STABLE, UNSTABLE), (STABLE, STABLE, UNSTABLE)))
    )
    return draw(arrays(np.int8, shape, elements=st.sampled_from(codes)))


#: A loop around one cell that starts next to a saddle and leads away from it.
BESIDE_SADDLE = np.array([[1, 2, 1, 1], [1, 1, 2, 1], [1, 1, 1, 1]], np.int8)


def judged(spec, starts):
    """Judge any start without integration; stable and unstable starts lie close together."""
    waves = np.sin(97.0 * starts["tilt"] + 31.0 * starts["roll_rate"] + starts["alpha"] + starts["gravity"])
    return np.where(waves > 0.0, UNSTABLE, STABLE).astype(np.int8)


@given(grids(), st.integers(1, 40))
@example(BESIDE_SADDLE, 40)
@example(3 - BESIDE_SADDLE, 40)
def test_curves_of_any_grid(grid, at_once):
    """On any grid, the curves have the points of the reference, in its order, however many are measured at a time."""
    values = [
        np.linspace(0.1 * number + 0.1, 0.1 * number + 0.9, count) for number, count in enumerate(grid.shape)
    ]
    names = AXES[-grid.ndim :]
    spec = sweep.SweepSpec(**dict(zip(names, map(np.ndarray.tolist, values), strict=True)))
    coordinates = np.meshgrid(*values, indexing="ij")

    def like_corner(place):
        far = (*place[:-2], place[-2] + 1, place[-1] + 1)
        middle = {
            name: 0.5 * (each[place] + each[far]) for name, each in zip(names, coordinates, strict=True)
        }
        return judged(spec, {"alpha": spec.alpha, "gravity": spec.gravity} | middle) == grid[place]

    with (
        mock.patch.object(boundary, "judged", judged),
        mock.patch.object(boundary, "AT_ONCE", at_once),
        mock.patch.object(curve_module, "AT_ONCE", at_once),
    ):
        found = Curves(spec, grid)
        # wider than any bracket, so the points stay at the middles of the grid edges
        points = found.measured(10.0)
    expected, closed = referee.chains(grid, like_corner)
    assert found.counts.tolist() == [len(chain) for chain in expected]
    assert found.closed.tolist() == closed
    order = np.array([point for chain in expected for point in chain], int)
    down, across = referee.pairs(grid)
    here = np.concatenate((down, across))[order]
    after = here + np.where(order < down.size, grid.shape[-1], 1)
    for name, each in zip(names, coordinates, strict=True):
        one, other = each.reshape(-1)[here], each.reshape(-1)[after]
        places, widths = points.along(name)
        assert places.tolist() == (0.5 * (one + other)).tolist()
        assert widths.tolist() == (0.5 * np.abs(other - one)).tolist()


SPECS = {
    "map": sweep.SweepSpec(roll_rate="2:4:9", tilt="0.1deg:3deg:6"),
    # a single row: its only curve has one point
    "row": sweep.SweepSpec(roll_rate="2:4:9", tilt="0.1deg,"),
    "several curves": sweep.SweepSpec(roll_rate="-4:4:17", tilt="-3deg:3deg:8"),
    "no rate": sweep.SweepSpec(roll_rate=3, tilt="0.1deg:3deg:6", tilt_rate="0.001:1:7"),
}


@pytest.fixture(params=SPECS, name="both")
def _both(request):
    """Return an atlas with a grid boundary and the same atlas with a refined boundary."""
    coarse = sweep.run(SPECS[request.param])
    refined = sweep.refine(coarse, 1e-6)
    assert {CURVES, POINTS} <= set(refined.dims)
    return coarse, refined


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_an_atlas_with_curves_is_drawn(both, tmp_path):
    """Both atlases give the same panels and texts; the regime maps have the same bytes."""
    coarse, _ = both
    drawn = [plots.figure([atlas]) for atlas in both]
    texts = [
        [text.get_text() for axes in each.axes for text in (*axes.texts, axes.title, axes.xaxis.label)]
        for each in drawn
    ]
    assert texts[0] == texts[1]
    if all(count > 1 for count in coarse["ending"].shape):
        for name, atlas in zip(("a.png", "b.png"), both, strict=True):
            plots.save(regimemap.figure([atlas]), tmp_path / name)
        assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.compiled
@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_tables_have_its_cells(both, tmp_path, kind):
    """A table has a row for each cell and the columns of an atlas without curves."""
    coarse, refined = both
    for name, atlas in (("a", coarse), ("b", refined)):
        export(atlas, tmp_path / f"{name}.{kind}", kind)
    read = {"csv": pd.read_csv, "parquet": pd.read_parquet}[kind]
    one, other = (read(tmp_path / f"{name}.{kind}") for name in "ab")
    assert list(one) == list(other)
    assert len(other) == refined["ending"].size
    pd.testing.assert_series_equal(one["peak_tilt"], other["peak_tilt"])


@pytest.mark.compiled
def test_it_is_compared_with_every_point_of_its_curves(both):
    """The atlas equals its copy; a point that is missing or moved beyond the tolerance is a difference."""
    _, refined = both
    comparison = compare(refined, refined.copy(deep=True))
    assert comparison.same
    assert {each.name: each.values for each in comparison.findings} == {
        name: variable.size for name, variable in refined.variables.items()
    }
    moved = refined.copy(deep=True)
    moved["curve_tilt"].values[-1] += 1e-6
    comparison = compare(moved, refined)
    assert [each.name for each in comparison.findings if each.different] == ["curve_tilt"]
    assert f"worst cell: curve_point {refined.sizes[POINTS] - 1}" in in_words(comparison)
    longer = refined.isel({POINTS: np.append(np.arange(refined.sizes[POINTS]), 0)})
    assert not compare(longer, refined).same


@pytest.mark.compiled
def test_curves_of_a_part_are_not_judged():
    """If two grids overlap in part, their cells are compared, and a note says why their curves are not."""
    spec = SPECS["map"].replace(boundary="refined:1e-6")
    comparison = compare(sweep.run(spec), sweep.run(spec.replace(roll_rate="2:3:5")), common=True)
    assert comparison.same
    assert any(not missing(each, ["curve_tilt", "roll_rate"]) for each in comparison.notes)


@pytest.mark.compiled
def test_curves_may_move_with_a_cell_that_flips_on_the_edge():
    """A cell within its error of the limit may have either verdict, and the curves may move with it."""
    spec = SPECS["map"].replace(boundary="refined:1e-6")
    atlas = sweep.run(spec)
    limit = float(atlas["tilt_max"][4, 2])
    beside = -3.0 * float(atlas["tilt_error"][4, 2])
    one, other = (sweep.reclassify(atlas, f"departure:{limit + shift!r}rad") for shift in (beside, 0.0))
    assert int((one["stability"] != other["stability"]).sum()) == 1
    comparison = compare(one.assign_attrs(other.attrs), other)
    assert comparison.same
    flipped = {each.name for each in comparison.findings if each.on_edge}
    assert "stability" in flipped
    assert any(name.startswith("curve_") for name in flipped)
