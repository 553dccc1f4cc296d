"""An atlas that holds its boundary as curves, too, is drawn, compared and exported like one that does not."""

import numpy as np
import pandas as pd
import pytest

import sweep
from sweep.atlas.quantities import CURVES, POINTS
from sweep.checks.compare import compare
from sweep.checks.comparison_report import in_words
from sweep.figures import plots
from sweep.figures.disk import regimes as regimemap
from sweep.files.export import export

pytestmark = pytest.mark.compiled

SPECS = {
    "map": sweep.SweepSpec(roll_rate="2:4:9", tilt="0.1deg:3deg:6"),
    # a single row: its only curve has a single point
    "row": sweep.SweepSpec(roll_rate="2:4:9", tilt="0.1deg,"),
    "several curves": sweep.SweepSpec(roll_rate="-4:4:17", tilt="-3deg:3deg:8"),
    "no rate": sweep.SweepSpec(roll_rate=3, tilt="0.1deg:3deg:6", tilt_rate="0.001:1:7"),
}


@pytest.fixture(params=SPECS, name="both")
def _both(request):
    """Return an atlas with the boundary of its grid, and the same one with its boundary refined."""
    coarse = sweep.run(SPECS[request.param])
    refined = sweep.refine(coarse, 1e-6)
    assert {CURVES, POINTS} <= set(refined.dims)
    return coarse, refined


def test_it_is_drawn(both, tmp_path):
    """Both are figures of the same panels and words; a map also of regimes, with the same bytes."""
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


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_tables_have_its_cells(both, tmp_path, kind):
    """A table has a row for each cell and the columns of the atlas without curves."""
    coarse, refined = both
    for name, atlas in (("a", coarse), ("b", refined)):
        export(atlas, tmp_path / f"{name}.{kind}", kind)
    read = {"csv": pd.read_csv, "parquet": pd.read_parquet}[kind]
    one, other = (read(tmp_path / f"{name}.{kind}") for name in "ab")
    assert list(one) == list(other)
    assert len(other) == refined["ending"].size
    pd.testing.assert_series_equal(one["peak_tilt"], other["peak_tilt"])


def test_it_is_compared_with_every_point_of_its_curves(both):
    """It is the same as itself; a point that moves beyond the tolerance, or that is missing, is a difference."""
    _, refined = both
    comparison = compare(refined, refined.copy(deep=True))
    assert comparison.same
    assert {each.name: each.values for each in comparison.findings} == {
        name: variable.size for name, variable in refined.data_vars.items()
    }
    moved = refined.copy(deep=True)
    moved["curve_tilt"].values[-1] += 1e-6
    comparison = compare(moved, refined)
    assert [each.name for each in comparison.findings if each.different] == ["curve_tilt"]
    assert f"worst cell: curve_point {refined.sizes[POINTS] - 1}" in in_words(comparison)
    longer = refined.isel({POINTS: np.append(np.arange(refined.sizes[POINTS]), 0)})
    assert not compare(longer, refined).same


def test_curves_of_a_part_are_not_judged():
    """Of two grids that overlap the cells are compared, and it is told why the curves are not."""
    spec = SPECS["map"].replace(boundary="refined:1e-6")
    comparison = compare(sweep.run(spec), sweep.run(spec.replace(roll_rate="2:3:5")), common=True)
    assert comparison.same
    assert "curve_tilt is not compared: only a part of roll_rate is common" in comparison.notes


def test_curves_may_move_with_a_cell_that_flips_on_the_edge():
    """Where a cell stands on the limit of the criterion either verdict is right, and so are the curves of either."""
    spec = SPECS["map"].replace(boundary="refined:1e-6")
    atlas = sweep.run(spec)
    limit = float(atlas["tilt_max"][4, 2])
    one, other = (sweep.reclassify(atlas, f"departure:{limit + shift!r}rad") for shift in (-1e-9, 1e-9))
    assert int((one["stability"] != other["stability"]).sum()) == 1
    comparison = compare(one.assign_attrs(sweep_spec=other.attrs["sweep_spec"]), other)
    assert comparison.same
    assert {each.name for each in comparison.findings if each.on_edge} >= {"stability", "curve_tilt"}
