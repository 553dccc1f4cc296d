"""The distribution of many values in constant memory, against numpy's of all of them."""

import numpy as np

from sweep.checks import distribution
from sweep.checks.distribution import Distribution


def summary(parts):
    """Return the summary of values that come in parts."""
    found = Distribution()
    for part in parts:
        found.add(part)
    return found.summary()


def exact(values):
    """Return numpy's median, 99 % and largest of the finite values."""
    return tuple(np.percentile(values[np.isfinite(values)], [50, 99, 100]).tolist())


def test_of_few_values_it_is_exact():
    """The same bits as numpy's, in parts of any size."""
    for count in [1, 2, 3, 1000]:
        values = np.random.default_rng(count).lognormal(-20.0, 3.0, count)
        values[count // 2 + 1 :: 7] = np.nan
        assert summary([values]) == summary(np.array_split(values, 7)) == exact(values), count


def test_of_none():
    """Without a finite value there is nothing to say."""
    for parts in ([], [np.zeros(0)], [np.array([np.nan, np.inf])]):
        assert np.isnan(summary(parts)).all()


def test_of_many_values_it_is_known_to_a_part_in_two_thousand(monkeypatch):
    """Two digits, which `verify` prints, are right; the largest is exact; parts and zeros make no difference."""
    for spread in [1e-6, 0.01, 3.0]:
        monkeypatch.setattr(distribution, "_MOST_KEPT", 5000)
        values = np.random.default_rng(3).lognormal(-20.0, spread, 200_000)
        values[::50] = np.nan
        values[1::50] = 0.0
        found = summary(np.array_split(values, 13))
        assert found == summary([values])
        np.testing.assert_allclose(found, exact(values), rtol=2.0**-11)
        assert found[2] == np.nanmax(values)


def test_of_zeros_and_of_what_is_out_of_the_range_of_bins(monkeypatch):
    """Values too small for a bin of their own are 0, larger ones than any bin the largest that there is."""
    monkeypatch.setattr(distribution, "_MOST_KEPT", 10)
    assert summary([np.zeros(100)]) == (0.0, 0.0, 0.0)
    assert summary([np.full(100, 1e-300)]) == (0.0, 0.0, 1e-300)
    most = summary([np.full(100, 1e300)])
    assert most[2] == 1e300
    assert most[0] > 1e19
