"""The share of unstable starts; its interval is compared with SciPy and with many samples."""

import numpy as np
import pytest
from messages import assert_facts, assert_in_order, refused
from scipy.stats import binomtest

import sweep
from sweep.atlas.share import Share, in_words, unstable_share, wilson
from sweep.model.disk.tables import ENDINGS
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

SPEC = sweep.SweepSpec.from_words(
    "rolling", ["roll_rate=uniform:2:4", "tilt=normal:1deg:0.2deg", "samples=400"]
)


def test_wilson():
    """Wilson intervals equal SciPy's."""
    for count, total in [(0, 1), (1, 1), (0, 50), (50, 50), (3, 7), (1, 10**6), (563302, 10**6)]:
        expected = binomtest(count, total).proportion_ci(method="wilson")
        assert wilson(count, total) == pytest.approx((expected.low, expected.high), rel=1e-12, abs=1e-15)


def test_of_no_draws_nothing_is_known():
    """Without decided starts the interval is 0 to 1, and no percentage is printed."""
    assert wilson(0, 0) == (0.0, 1.0)
    told = in_words(Share(0, 0, 2, 1, 0))
    assert_facts(told, "no start", "2 undecided", "1 failed")
    assert "%" not in told


def test_the_interval_holds_the_truth():
    """The intervals of about 95 % of 500 samples of 100 starts contain the share of all starts."""
    atlas = sweep.run(SPEC.replace(tilt="1deg", samples=50_000, method="exact"))
    truth = unstable_share(atlas).value
    parts = [unstable_share(atlas.isel(start=slice(at, at + 100))) for at in range(0, 50_000, 100)]
    held = sum(low <= truth <= high for low, high in (part.interval for part in parts))
    # 3.5 standard deviations of a binomial distribution
    assert 458 <= held <= 492


def test_what_has_no_verdict_is_counted_apart():
    """Undecided, failed and missing cells are counted separately and are neither stable nor unstable."""
    atlas = sweep.run(SPEC).load()
    verdict, ending = atlas["stability"].values, atlas["ending"].values
    verdict[:], ending[:] = STABLE, ENDINGS.code("bounded")
    verdict[:120], verdict[120:130] = UNSTABLE, UNDECIDED
    ending[123:125], ending[125:130] = ENDINGS.code("unresolved"), ENDINGS.code("not_computed")
    found = unstable_share(atlas)
    assert found == Share(unstable=120, stable=270, undecided=3, failed=2, missing=5)
    assert found.value == 120 / 390
    told = in_words(found)
    assert_in_order(told, "30.8 %", "390 starts", "95 %", "26.4", "35.5 %")
    assert_facts(told, "Wilson", "3 undecided", "2 failed", "5 not computed")


def test_the_digits_are_those_that_are_known():
    """A million starts give hundredths of a percent; if none is unstable, the upper end has more digits."""
    assert_in_order(
        in_words(Share(563302, 436698, 0, 0, 0)), "56.33 %", "1000000 starts", "95 %", "56.23", "56.43 %"
    )
    assert_in_order(
        in_words(Share(0, 10**6, 0, 0, 0)), "0.00000 %", "1000000 starts", "95 %", "0.00000", "0.00038 %"
    )


def test_accessor():
    """dataset.eulerdisk has the share, also for selections, and its repr shows it."""
    atlas = sweep.run(SPEC)
    share = atlas.eulerdisk.unstable_share
    assert share.unstable == int((atlas.stability == UNSTABLE).sum())
    assert share.decided == 400
    assert atlas.isel(start=slice(0, 100)).eulerdisk.unstable_share.decided == 100
    assert f"unstable   {in_words(share)}" in repr(atlas.eulerdisk)


def test_a_grid_has_no_share():
    """A grid has no unstable share, because its axes end where the user chose."""
    with refused("grid"):
        unstable_share(sweep.run(sweep.SweepSpec(roll_rate="2:4:5", tilt="1deg")))


def test_the_share_follows_from_the_prediction():
    """At one tilt, the share is the part of the uniform rates below the predicted boundary."""
    spec = SPEC.replace(tilt="1deg", samples=20_000, method="exact")
    grid = sweep.run(sweep.SweepSpec(roll_rate="2:4:3", tilt="1deg", criterion=spec.criterion))
    expected = (float(grid.predicted_roll_rate) - 2.0) / 2.0
    low, high = unstable_share(sweep.run(spec)).interval
    assert low <= expected <= high
    assert np.isclose(expected, 0.56, atol=0.02)
