"""The tally of wrong values: the allowed share, the worst value, and the named ones."""

import math

import numpy as np
import pytest
from messages import assert_facts

from sweep.checks.statement import Checks, Statement, from_text, to_text
from sweep.checks.tally import Tally, difference, other_bits
from sweep.model.audit import CellCheck


def stated(wrong, judged, share=0.0, difference=2.0):
    """Return the statement of values with an allowed difference of 1, which the first ones exceed."""
    apart = np.zeros(judged)
    apart[:wrong] = difference
    checks = Checks("end_time", "s")
    for start in range(0, judged, 64):
        part = apart[start : start + 64]
        every = np.ones(part.shape, bool)
        checks.add(start, CellCheck("end_time", "another run", part, np.ones(part.size), every, share=share))
    return checks.statement(lambda place: f"value {place}")


def test_a_share_of_the_values_may_differ_and_five_standard_deviations_more():
    """Of 10000 values, a share of 1 % allows 100 + 5 * 10 + 5; of 100, 0.1 % allows 0.1 + 5 * 0.32 + 5."""
    for judged, share, most in ((10_000, 0.01, 155), (100, 0.001, 6)):
        assert stated(most, judged, share).wrong == 0
        beyond = stated(most + 1, judged, share)
        assert (beyond.wrong, beyond.named) == (most + 1, ["value 0", "value 1", "value 2"])


def test_without_a_share_one_wrong_value_is_one_too_many():
    """The statement gives its difference and the tolerance; a missing value counts as the worst."""
    assert stated(0, 300).wrong == 0
    one = stated(1, 300)
    assert (one.wrong, one.named, one.difference, one.allowed) == (1, ["value 0"], 2.0, 1.0)
    missing = stated(4, 300, difference=math.nan)
    assert (missing.wrong, missing.judged) == (4, 300)
    assert math.isnan(missing.difference)


def test_values_are_counted_that_nothing_is_held_against():
    """With every third value checked, the others are counted as not checked; a wrong one is named by its place."""
    checks, five = Checks("steps", "1"), np.zeros(5)
    apart = np.array([0.0, 0.0, 2.0, 0.0, 0.0])
    checks.add(0, CellCheck("steps", "its repetition", five, five, np.ones(5, bool)), step=3)
    checks.add(16, CellCheck("steps", "its repetition", apart, five, np.ones(5, bool)), step=3)
    found = checks.statement(str)
    assert_facts(found.against, "its repetition", "not checked", "20 values")
    assert (found.judged, found.wrong, found.named) == (10, 1, ["22"])


def test_differences_have_no_sign_and_one_missing_value_is_none():
    """Two missing values or equal infinities differ by 0; if only one is missing, the difference is NaN."""
    stored = np.array([1.0, 3.0, np.nan, np.nan, 1.0, np.inf, -np.inf])
    right = np.array([3.0, 1.0, np.nan, 1.0, np.nan, np.inf, 1.0])
    assert difference(stored, right).tolist() == pytest.approx(
        [2, 2, 0, np.nan, np.nan, 0, np.inf], nan_ok=True
    )
    assert other_bits(np.array([0.0, np.nan, 1.0]), np.array([-0.0, -np.nan, 1.0])).tolist() == [
        True,
        False,
        False,
    ]


def test_the_worst_value_is_one_that_is_too_far_off():
    """A value beyond its tolerance ranks above a larger share of a tolerance; excused ones are counted separately."""
    tally, one = Tally(), np.ones(4)
    apart, allowed = np.array([0.9, 3.0, 0.0, 5.0]), np.array([1.0, 2.0, 1.0, 1.0])
    beyond, excused = np.array([False, False, True, True]), np.array([False, False, False, True])
    tally.add(10, apart, allowed, beyond=beyond, excused=excused, values=(one, one))
    assert (tally.judged, tally.beyond, tally.excused, tally.first) == (4, 1, 1, [12])
    assert (tally.worst.place, tally.worst.beyond) == (12, True)
    assert (tally.largest, tally.allowed, tally.ratio) == (3.0, 2.0, 1.5)


def test_a_variable_held_against_two_things_is_as_wrong_as_the_worse_one_says():
    """All 8 values repeat, but two of the four with a known exact value are wrong."""
    checks, fine, every = Checks("tilt_max", "rad"), np.zeros(8), np.ones(8, bool)
    checks.add(0, CellCheck("tilt_max", "the same run again", fine, np.ones(8), every))
    apart = np.array([0.0, 3.0, 0.5, 2.0])
    checks.add(0, CellCheck("tilt_max", "the exact value", apart, np.ones(4), every[:4]), step=2)
    found = checks.statement(lambda place: f"value {place}")
    assert (found.judged, found.wrong, found.named) == (8, 2, ["value 2", "value 6"])
    assert (found.difference, found.allowed) == (3.0, 1.0)


@pytest.mark.parametrize("size", [math.inf, -math.inf, math.nan, 2.5])
def test_a_difference_of_any_size_is_written_and_read(size):
    """JSON has no infinity: a difference that is not finite is written as missing and read as NaN."""
    (read,) = from_text(to_text([Statement("end_time", "another run", 3, 1, size, 1.0, "s", ["value 0"])]))
    assert (read.name, read.judged, read.wrong, read.allowed, [*read.named]) == (
        "end_time",
        3,
        1,
        1.0,
        ["value 0"],
    )
    assert read.difference == size if math.isfinite(size) else math.isnan(read.difference)
