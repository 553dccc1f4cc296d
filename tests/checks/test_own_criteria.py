"""The checks with your own criterion: cells on its edge or within its errors, and the reason for a verdict."""

import itertools
import math

import numpy as np
import pytest
from auditing import changed, flags
from comparing import finding, found
from messages import assert_facts, assert_in_order, row

import sweep
from sweep.checks.compare import compare
from sweep.checks.explain import explain
from sweep.checks.verify import findings, verify
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

SPEC = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:9", tilt="0.1deg:4deg:6:log")
CELL = (5, 3)


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas that tests must not change."""
    return sweep.run(SPEC)


def test_a_verdict_may_flip_on_the_edge_alone(atlas):
    """If a value equals its limit, the last bit decides the verdict, and two atlases may differ."""
    for name in ["peak_tilt", "amplification", "nutation_period", "tilt_max"]:
        value = float(atlas[name].values[CELL])
        for text, excused in ((f"{name} > {value!r}", True), (f"not {name} <= {value!r} and tilt > 0", True),
                              (f"{name} > {1.001 * value!r}", False)):  # fmt: skip
            edge = sweep.reclassify(atlas, text)
            assert edge.stability.values[CELL] == (UNDECIDED if excused else STABLE), name
            comparison = compare(changed(edge, CELL, stability=UNSTABLE), edge)
            assert comparison.same == excused, text
            if excused:
                assert finding(comparison, "stability").on_edge == 1, name
            else:
                assert found(comparison) == {"stability": 1}, name


def test_a_verdict_flips_between_two_values(atlas):
    """If the limit is between two values that agree within the stated errors, the verdicts may differ."""
    period = float(atlas.nutation_period.values[CELL])
    later = changed(atlas, CELL, nutation_period=period * (1.0 + 1e-7))
    for share, same in ((0.5e-7, True), (1e-3, False)):
        text = f"nutation_period > {period * (1.0 + share)!r}"
        new, old = sweep.reclassify(later, text), sweep.reclassify(atlas, text)
        assert {int(each.stability.values[CELL]) for each in (new, old)} == {UNDECIDED if same else STABLE}
        assert compare(new, old).same
        other = changed(new, CELL, stability=UNSTABLE + STABLE - old.stability.values[CELL])
        assert compare(other, old).same == same


def test_a_rate_that_cells_compute_is_known():
    """A limit may depend on a rate that each cell computes; verdicts may differ only on that edge."""
    spec = sweep.SweepSpec(
        tilt="5deg,10deg", precession_rate="steady-slow", roll_rate="4:8:3", tilt_rate=1e-3
    )
    atlas = sweep.run(spec)
    rate, size = abs(float(atlas.precession_rate.values[0, 0])), float(atlas.amplification.values[0, 0])
    for text, same in (
        (f"amplification > {size!r} and abs(precession_rate) > {0.5 * rate!r}", True),
        (f"amplification > {size!r} and abs(precession_rate) > {2.0 * rate!r}", False),
    ):
        edge = sweep.reclassify(atlas, text)
        flipped = UNSTABLE + STABLE - int(edge.stability.values[0, 0])
        assert compare(changed(edge, (0, 0), stability=flipped), edge).same == same


def test_a_verdict_follows_a_value_that_differs(atlas):
    """If a value differs too much, that is the finding, and the verdict that changes with it is excused."""
    period = float(atlas.nutation_period.values[CELL])
    text = f"nutation_period > {period * 1.01!r}"
    later = sweep.reclassify(changed(atlas, CELL, nutation_period=period * 1.02), text)
    comparison = compare(later, sweep.reclassify(atlas, text))
    assert finding(comparison, "nutation_period").different == 1
    assert finding(comparison, "stability").on_edge == 1


def test_within_the_tolerance_of_its_edge_a_cell_is_marginal(atlas):
    """A value within the tolerance of its limit may be on either side of the exact value; others may not."""
    for name in ["peak_tilt", "amplification", "nutation_period"]:
        value = float(atlas[name].values[CELL])
        # the error that a tolerance of 1e-8 rad allows
        for share in (-1e-10, 1e-10):
            edge = sweep.reclassify(atlas, f"{name} > {value * (1.0 + share)!r}")
            assert findings(verify(edge)).passed, name
        edge = sweep.reclassify(atlas, f"{name} > {value * 1.01!r}")
        wrong = verify(changed(edge, CELL, stability=UNSTABLE))
        assert flags(wrong)[CELL] == "verdict_differs", name
        assert [each.name for each in findings(wrong).wrong if each.name == "stability"] == ["stability"], (
            name
        )


def test_a_verdict_of_exact_values_is_marginal_not_wrong(atlas):
    """If only the exact value is beyond the edge, the cell is marginal, because its verdict follows from the file."""
    exact = sweep.run(SPEC.replace(method="exact"))
    ours, theirs = atlas.peak_tilt.values, exact.peak_tilt.values
    place = np.unravel_index(int(np.argmax(np.abs(ours - theirs))), ours.shape)
    assert ours[place] != theirs[place]
    edge = sweep.reclassify(atlas, f"peak_tilt > {float(ours[place] + theirs[place]) / 2.0!r}")
    audited = verify(edge)
    assert flags(audited)[place] == "marginal"
    assert findings(audited).passed


def test_verify_says_what_it_held_the_verdicts_against():
    """`verify` states whether it checks verdicts with exact or stored values, and finds wrong ones either way."""
    for criterion, words, says in [
        ("fall_time < 0.3s", {}, "on the stored values"),
        ("friction_needed > 0.1", {"contact": "yes"}, "on the stored values"),
        ("peak_tilt > 5deg", {}, "those of the exact reduction"),
        ("wells == two_wells", {"method": "exact"}, "those of the exact reduction"),
    ]:
        atlas = sweep.run(SPEC.replace(criterion=criterion, **words))
        assert findings(verify(atlas)).passed, (criterion, words, says)
        statement = next(each for each in findings(verify(atlas)).statements if each.name == "stability")
        assert says in statement.against, (criterion, words, says)
        flipped = UNSTABLE + STABLE - atlas.stability.values[CELL]
        wrong = findings(verify(changed(atlas, CELL, stability=flipped)))
        assert "stability" in [each.name for each in wrong.wrong], (criterion, words, says)


def test_what_was_true_when_time_ran_out_is_no_fault():
    """A verdict that follows from the values until time ran out is right, even if the exact extremes give another."""
    atlas = sweep.run(SPEC.replace(duration=1.0, criterion="peak_tilt < 5deg"))
    audited = findings(verify(atlas))
    assert audited.counts["within"] > 5
    assert audited.passed


def test_explain_shows_the_comparisons():
    """The report shows each comparison with the cell's value, and the verdict of the whole expression."""
    text = "peak_tilt > 10deg or fall_time < 2s"
    atlas = sweep.run(SPEC.replace(criterion=text))
    explained = explain(atlas, {"roll_rate": 2.5, "tilt": "4deg"}).text
    assert_facts(row(explained, "verdict"), text)
    because = row(explained, "because")
    assert_in_order(because, "peak_tilt > 10deg", "true", "fall_time < 2s", "false", "missing")
    assert_facts(row(explained, "boundary"), "none is predicted", "criterion")
    explained = " ".join(explain(atlas, {"roll_rate": 4, "tilt": "0.1deg"}).text.split())
    assert_facts(explained, "bounded")


def test_explain_compares_with_the_start():
    """A comparison with a start parameter uses the cell's value of it."""
    atlas = sweep.run(SPEC.replace(criterion="peak_tilt > 3*tilt"))
    explained = " ".join(explain(atlas, {"roll_rate": 2, "tilt": "0.1deg"}).text.split())
    assert_facts(explained, "peak_tilt > 3*tilt", "true")
    assert_facts(explained, "tilt", "0.1 deg")


def test_a_steady_motion_can_be_unstable():
    """An undisturbed cell can be unstable; the reason is the expression, not that nothing was measured."""
    atlas = sweep.run(sweep.SweepSpec(tilt="0,1deg", roll_rate=3, criterion="abs(tilt) < 0.5deg"))
    assert atlas.stability.values.tolist() == [UNSTABLE, STABLE]
    assert_facts(explain(atlas, {"tilt": 0}).text, "abs(tilt) < 0.5deg", "true")
    assert findings(verify(atlas)).passed
    assert math.isfinite(atlas.peak_tilt.values[0])


def test_a_verdict_that_holds_at_one_double_is_found_again():
    """If a bracket ends at a grid value, it is checked with the exact verdict at that value."""
    for criterion, tilt in itertools.product(
        ["tilt == 1deg", "roll_rate > 30deg/s and not (tilt == 2deg or tilt == 1deg)"],
        ["1deg:3deg:4", "1deg,1.7deg,2deg", "1deg:2deg:4:log"],
    ):
        words = ["roll_rate=2:4:5", f"tilt={tilt}", f"criterion={criterion}", "boundary=refined:1e-4"]
        atlas = sweep.run(sweep.SweepSpec.from_words("rolling", words))
        assert findings(verify(atlas)).passed, (criterion, tilt)
