"""The distribution of many values in constant memory, compared with numpy's of all values."""

import numpy as np

from sweep.checks import distribution
from sweep.checks.distribution import Distribution


def summary(parts):
    """Return the summary of values that arrive in parts."""
    found = Distribution()
    for part in parts:
        found.add(part)
    return found.summary()


def exact(values):
    """Return numpy's median, 99 % quantile and maximum of the finite values."""
    return tuple(np.percentile(values[np.isfinite(values)], [50, 99, 100]).tolist())


def test_of_few_values_it_is_exact():
    """For few values, the result equals numpy's bit for bit, in parts of any size."""
    for count in [1, 2, 3, 1000]:
        values = np.random.default_rng(count).lognormal(-20.0, 3.0, count)
        values[count // 2 + 1 :: 7] = np.nan
        assert summary([values]) == summary(np.array_split(values, 7)) == exact(values), count


def test_of_none():
    """Without a finite value, the result is NaN."""
    for parts in ([], [np.zeros(0)], [np.array([np.nan, np.inf])]):
        assert np.isnan(summary(parts)).all()


def test_of_many_values_an_even_part_is_kept(monkeypatch):
    """Median and 99 % quantile come from an evenly spaced sample and the maximum from all values."""
    monkeypatch.setattr(distribution, "_MOST_KEPT", 5000)
    for spread in [1e-6, 0.01, 3.0]:
        values = np.random.default_rng(3).lognormal(-20.0, spread, 200_000)
        values[::50] = np.nan
        found = summary(np.array_split(values, 13))
        assert found == summary([values]) == summary(np.array_split(values, 1000))
        assert found[2] == np.nanmax(values)
        # the sample has 3063 values, every 64th of 196,000; five standard deviations of the share below
        for value, share in zip(found, [0.5, 0.99], strict=False):
            below = np.mean(values[np.isfinite(values)] < value)
            assert abs(below - share) < 5.0 * np.sqrt(share * (1.0 - share) / 3063)


def test_little_is_kept(monkeypatch):
    """The number of kept values stays within the limit."""
    monkeypatch.setattr(distribution, "_MOST_KEPT", 100)
    found = Distribution()
    for _ in range(500):
        found.add(np.arange(37.0))
        assert sum(each.size for each in found._kept) <= 100
