import itertools
from dataclasses import replace

import numpy as np
import pytest
import referee
from auditing import ENDINGS, PRESETS, atlas, changed, coarse, flags, moved
from messages import assert_facts, missing
from scipy.integrate import solve_ivp

import sweep
from sweep.checks import cell_audit
from sweep.checks.statement import Statement
from sweep.checks.verify import findings, verify
from sweep.commands.audit_report import audit_line, audit_text
from sweep.engine.compute import measure
from sweep.model.disk.exact import ExactReduction
from sweep.model.disk.tables import PARAMETERS
from sweep.request.spec import SweepSpec

pytestmark = pytest.mark.compiled


#: A cell that is bounded and stable in every coarse preset.
PLACE = {"rolling": (35, 12), "spinning": (35, 12), "circling": (20, 30)}


#: A variable of one cell, the change of its value, and the resulting flag of the cell.
# fmt: off
CHANGES = (
    ("tilt_min", lambda x: x + 1e-7, "extremes_differ"),
    ("tilt_min", lambda x: x - 1e-7, "extremes_differ"),
    ("tilt_max", lambda x: x + 1e-7, "extremes_differ"),
    ("tilt_max", lambda x: x - 1e-7, "extremes_differ"),
    ("tilt_min", lambda x: np.nan, "extremes_differ"),
    ("tilt_max", lambda x: np.inf, "extremes_differ"),
    # within the tolerance, but contradicting the peak
    ("peak_tilt", lambda x: x + 1e-9, "contradictory"),
    ("peak_tilt", lambda x: np.nan, "contradictory"),
    ("amplification", lambda x: x * (1.0 + 1e-9), "contradictory"),
    ("amplification", lambda x: np.nan, "contradictory"),
    ("stability", lambda x: 2, "verdict_differs"),
    ("stability", lambda x: 0, "verdict_differs"),
    ("ending", lambda x: ENDINGS["steady"], "ending_differs"),
    ("ending", lambda x: ENDINGS["horizon"], "ending_differs"),
    ("ending", lambda x: ENDINGS["fell"], "ending_differs"),
    ("ending", lambda x: ENDINGS["invalid"], "ending_differs"),
    ("ending", lambda x: ENDINGS["unresolved"], "contradictory"),
    ("nutation_period", lambda x: x * 1.01, "period_differs"),
    ("nutation_period", lambda x: 2.0 * x, "period_differs"),
    ("nutation_period", lambda x: np.nan, "contradictory"),
)
# fmt: on


@pytest.mark.slow_lane
def test_a_corrupted_cell_is_caught():
    """If one value of one cell is wrong, only that cell disagrees, for the right reason, and is named."""
    for preset, (number, (variable, change, flag)) in itertools.product(PRESETS, enumerate(CHANGES)):
        dataset, place, case = atlas(preset), PLACE[preset], (preset, variable, number)
        assert (dataset.ending.values[place], dataset.stability.values[place]) == (ENDINGS["bounded"], 1)
        audited = verify(changed(dataset, place, **{variable: change(dataset[variable].values[place])}))
        names = flags(audited)
        assert names[place] == flag, case
        assert np.count_nonzero(names != "agrees") == 1, case
        found = findings(audited)
        assert not found.passed, case
        where = {name: float(dataset[name][i]) for name, i in zip(dataset.ending.dims, place, strict=True)}
        assert found.named == [(flag, where)], case
        text = audit_text(found, SweepSpec.preset(preset))
        assert f"1 {flag.replace('_', ' ')}" in text, case
        assert f"tilt {np.degrees(where['tilt']):.10g} deg" in text, case
        last = text.splitlines()[-1]
        assert missing(last, ["NOT verified", "1 of 1200 cells", "0 are not computed", variable]) == [], case


def test_a_corrupted_roll_rate_of_circling_is_caught():
    """The computed steady roll rate of a cell is checked with the formula."""
    corrupted = changed(atlas("circling"), (3, 4), roll_rate=float(atlas("circling").roll_rate[3, 4]) + 1e-6)
    assert list(zip(*np.nonzero(flags(verify(corrupted)) == "contradictory"), strict=True)) == [(3, 4)]


def test_a_corrupted_precession_rate_of_circling_is_caught():
    """A computed precession rate must be the one that keeps the disk steady."""
    steady = sweep.run(
        SweepSpec(tilt="5deg,10deg", precession_rate="steady-slow", roll_rate="4,6", tilt_rate=1e-3)
    )
    corrupted = changed(steady, (0, 1), precession_rate=float(steady.precession_rate[0, 1]) + 1e-6)
    assert {flag: n for flag, n in findings(verify(corrupted)).counts.items() if n} == {
        "agrees": 3,
        "contradictory": 1,
    }


def test_a_corrupted_fall_is_caught():
    """A wrong ending, verdict, period or extreme of a fall is found."""
    dataset = sweep.run(SweepSpec(tilt="20deg,30deg", tilt_rate=-1.0))
    assert (dataset.ending == ENDINGS["fell"]).all()
    wrong = {"ending": ENDINGS["horizon"], "stability": 1, "nutation_period": 1.0}
    wrong |= {name: float(dataset[name][1]) + 1e-7 for name in ("tilt_min", "tilt_max")}
    for variable, value in wrong.items():
        found = findings(verify(changed(dataset, 1, **{variable: value})))
        assert (found.disagreeing, found.agreeing) == (1, 1), variable
        assert found.named[0][1]["tilt"] == float(dataset.tilt[1]), variable


def test_a_run_that_time_ended_beyond_the_exact_extremes_is_caught():
    """Time excuses neither extremes beyond the exact ones nor a verdict before both ends are known."""
    dataset = sweep.run(coarse("rolling", duration=1.2))
    truth = verify(dataset)
    place = tuple(
        np.argwhere((dataset.ending.values == ENDINGS["horizon"]) & (truth.exact_stability.values == 1))[0]
    )
    exact = float(truth.exact_tilt_max.values[place])
    beyond = exact - float(dataset.tilt_max.values[place]) + 1e-7
    assert flags(verify(moved(dataset, place, high=beyond)))[place] == "extremes_differ"
    assert flags(verify(changed(dataset, place, stability=1)))[place] == "contradictory"


def test_cells_that_are_not_computed_do_not_pass():
    """A partly computed atlas does not pass, although nothing in it is wrong."""
    dataset = changed(atlas("rolling"), (slice(10), slice(None)), ending=0, stability=0)
    found = findings(verify(dataset))
    assert (found.missing, found.disagreeing, found.agreeing) == (300, 0, 900)
    assert not found.passed
    text = audit_text(found, SweepSpec.preset("rolling"))
    assert_facts(text.splitlines()[-1], "NOT verified", "0 of 1200 cells", "300 are not computed")


def test_at_most_five_wrong_cells_are_named():
    """The report names five cells, three values of a variable and six variables, and counts the others."""
    dataset = changed(atlas("rolling"), (slice(2), slice(4)), stability=0)
    found = findings(verify(dataset))
    lines = audit_text(found, SweepSpec.preset("rolling")).splitlines()
    assert sum(line.startswith("wrong ") for line in lines) == 5
    assert "             and 3 more" in lines
    (named,) = (line for line in lines if line.startswith("    wrong in 8 of 1200: "))
    assert (named.count("roll_rate"), named.endswith(", and 5 more")) == (3, True)
    several = [Statement(name, "nothing", judged=1, wrong=1) for name in "abcdefgh"]
    assert audit_line(replace(found, statements=several)).endswith("; wrong: a, b, c, d, e, f and 2 more")


def wrong_equation(spec, coefficient):
    """Return an atlas made with another coefficient in the tilt equation."""
    dataset = sweep.run(spec)
    for place in np.ndindex(*spec.shape):
        where = dict(zip(spec.axes, place, strict=True))
        start = [
            float(dataset[name].isel({name: where[name]} if name in where else {})) for name in PARAMETERS
        ]
        alpha = start[4]

        def slope(_, y, start=start, alpha=alpha):
            tilting, turning, rolling = referee.accelerations(y, *start[4:])
            sideways = 2.0 * (1.0 + alpha) / (2.0 + alpha) * y[3] * y[2] * np.cos(y[0])
            return y[1], tilting + (coefficient - 1.0) * sideways, turning, rolling

        run = solve_ivp(slope, (0.0, 20.0), start[:4], rtol=1e-10, atol=1e-12, events=lambda _, y: y[1])
        turns = run.y_events[0][:, 0]
        dataset = moved(
            dataset,
            place,
            turns.min() - dataset.tilt_min.values[place],
            turns.max() - dataset.tilt_max.values[place],
        )
    return dataset


@pytest.mark.slow_lane
def test_an_atlas_made_with_a_wrong_equation_is_caught():
    """A gyroscopic term that is 0.1 % too large is found in every cell; SciPy's atlas with the right one passes."""
    spec = SweepSpec(tilt="5deg,10deg", roll_rate="2.7:4:3", tilt_rate=0.2, tolerance=1e-5)
    for coefficient, disagreeing in ((1.0, 0), (1.001, 6)):
        found = findings(verify(wrong_equation(spec, coefficient)))
        assert (found.agreeing, found.disagreeing) == (6 - disagreeing, disagreeing)
        assert found.counts["extremes_differ"] == disagreeing


def test_an_atlas_made_with_another_constant_is_caught():
    """An atlas that claims alpha = 0.5 but was made with 0.501 disagrees almost everywhere."""
    made = sweep.run(coarse("rolling", alpha=0.501))
    claimed = made.assign_attrs(sweep_spec=atlas("rolling").attrs["sweep_spec"]).assign_coords(alpha=0.5)
    found = findings(verify(claimed))
    # released from 1e-5 rad far above the critical rate, the disk hardly moves for any alpha
    assert found.counts["extremes_differ"] > 900
    assert not found.passed


def test_a_cell_that_is_wrongly_impossible_or_wrongly_possible_is_caught():
    """A wrong claim that a start does or does not exist is found, even if all other values are missing."""
    words = {"tilt": "10deg", "precession_rate": "-1:1:5", "roll_rate": "steady", "tilt_rate": 1e-3}
    dataset = sweep.run(SweepSpec(**words))
    nothing = dict.fromkeys(("tilt_min", "tilt_max", "peak_tilt", "amplification", "nutation_period"), np.nan)
    refused = changed(dataset, 0, ending=ENDINGS["invalid"], stability=0, **nothing)
    assert flags(verify(refused)).tolist() == ["ending_differs", "agrees", "invalid", "agrees", "agrees"]
    claimed = changed(dataset, 2, ending=ENDINGS["steady"])
    assert flags(verify(claimed)).tolist() == ["agrees", "agrees", "ending_differs", "agrees", "agrees"]


def test_rest_within_the_tolerance_is_as_good_as_steady():
    """A swing within the tolerance may be called steady and left undecided; a wider one may not."""
    dataset = sweep.run(
        SweepSpec(tilt="10deg", precession_rate="5,6", roll_rate="steady", tilt_rate="1e-9,1e-4", duration=30)
    )
    assert (dataset.ending == ENDINGS["bounded"]).all()
    still = changed(dataset, (0, slice(None)), ending=ENDINGS["steady"], stability=0, nutation_period=np.nan)
    # marked as the result of other code, so that the integration is not repeated
    still = still.assign_attrs(kernel_hash="0" * 64)
    assert flags(verify(still)).tolist() == [["agrees", "ending_differs"], ["agrees", "agrees"]]


def without_period(monkeypatch, place):
    """Make the reduction of `verify` return no period for a cell."""
    truth = ExactReduction.truth

    def lacking(self, spec, starts, first, stored):
        found = truth(self, spec, starts, first, stored)
        found["nutation_period"][place] = np.nan
        return found

    monkeypatch.setattr(ExactReduction, "truth", lacking)


def test_a_period_that_rounding_decides_is_missing(monkeypatch):
    """An exact atlas may lack the period only in cells where the reduction has none."""
    dataset = sweep.run(SweepSpec.from_words("rolling", ["tilt=0.05,0.06", "roll_rate=1", "method=exact"]))
    assert (dataset.ending.values == ENDINGS["bounded"]).all()
    # marked as the result of other code: nothing is repeated
    dataset = dataset.assign_attrs(kernel_hash="0" * 64)
    period = dataset.nutation_period.values
    lacking = changed(dataset, 0, nutation_period=np.nan)
    assert flags(verify(lacking)).tolist() == ["contradictory", "agrees"]
    without_period(monkeypatch, 0)
    assert flags(verify(lacking)).tolist() == ["agrees", "agrees"]
    assert findings(verify(lacking)).passed
    for made_up in (period[0], 1.0, 2.0 * period[0]):
        other = changed(lacking, 0, nutation_period=made_up)
        assert flags(verify(other)).tolist() == ["contradictory", "agrees"]
        assert [each.name for each in findings(verify(other)).wrong] == ["nutation_period"]


def test_a_period_that_nothing_is_known_of_is_said_not_to_be_checked(monkeypatch):
    """Periods that the reduction lacks are counted as not checked, unless their integration is repeated."""
    dataset = sweep.run(SweepSpec(tilt="0.05,0.06", roll_rate=1))
    without_period(monkeypatch, 1)
    assert not said_open(dataset)
    assert said_open(dataset.assign_attrs(kernel_hash="0" * 64)) == {
        "nutation_period": 1, "energy_drift": 2, "tilt_error": 2, "steps": 2, "refinements": 2,
    }  # fmt: skip


def said_open(dataset):
    """Return the number of values that `verify` reports as not checked, by variable."""
    said = [
        (each.name, each.against.split("otherwise not checked: "))
        for each in findings(verify(dataset)).statements
    ]
    return {name: int(words[1].split()[0]) for name, words in said if len(words) > 1}


def rounded_otherwise(monkeypatch, ulps):
    """Shift the results that `verify` repeats by a few units in the last place."""

    def measured(spec, starts):
        found = dict(measure(spec, starts))
        for name, values in found.items():
            if values.dtype == np.float64:
                found[name] = values + ulps * np.spacing(values)
        return found

    monkeypatch.setattr(cell_audit, "measure", measured)


def test_a_file_of_another_processor_passes(monkeypatch):
    """If all times differ in their last bits, another processor made the file, and tolerances apply."""
    dataset = atlas("circling")
    rounded_otherwise(monkeypatch, 3)
    found = findings(verify(dataset))
    assert found.passed, found.wrong
    told = {each.name: each.against for each in found.statements}
    assert_facts(told["nutation_period"], "processor", "rounds")
    wrong = findings(verify(dataset.assign(fall_time=1.001 * dataset.fall_time)))
    assert "fall_time" in [each.name for each in wrong.wrong]


def test_a_file_of_this_processor_is_held_to_the_bit():
    """If most times are equal, this processor made the file, and a differing last bit is wrong."""
    dataset = atlas("circling")
    period = dataset.nutation_period.values.copy()
    place = tuple(np.argwhere(np.isfinite(period))[0])
    period[place] = np.nextafter(period[place], np.inf)
    found = findings(verify(dataset.assign(nutation_period=dataset.nutation_period.copy(data=period))))
    assert next(each for each in found.wrong if each.name == "nutation_period").wrong == 1


def test_errors_of_periods_have_no_sign():
    """Periods that are all too short by a millionth show in the median, 99 % and largest error."""
    found = findings(
        verify(atlas("rolling").assign(nutation_period=lambda each: each.nutation_period * (1.0 - 1e-6)))
    )
    assert found.period == pytest.approx([1e-6] * 3, rel=0.05)
