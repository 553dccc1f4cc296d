"""Criteria of one's own in requests: their verdicts, where they are kept, and what they cannot judge by."""

import json
import math
import pickle

import numpy as np
import pytest

import sweep
from kernels.disk.endings import BOUNDED, FELL, HORIZON, INVALID, NOT_COMPUTED, STEADY, UNRESOLVED
from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import ENDINGS
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE
from sweep.request.criterion import Criterion
from sweep.request.spec import SweepSpec

TEXT = "peak_tilt > 10deg or fall_time < 2s"
NONE = np.array([math.nan])


def verdict(text, ending, **values):
    """The verdict of an expression on one cell, of which the variables given are known."""
    criterion = Criterion.parse(text)
    cell = {name: np.array([values.get(name, math.nan)]) for name in criterion.needs(DISK)}
    cell |= {name: np.array([values.get(name, math.nan)]) for name in DISK.parameters}
    return int(criterion.verdict(DISK.endings, {**cell, "ending": np.array([ending])}, NONE, NONE)[0])


def test_the_verdict_of_every_ending():
    """True is unstable, false is stable where the ending is final; what could not be computed stays undecided."""
    for ending, true, false in [
        (BOUNDED, UNSTABLE, STABLE),
        (FELL, UNSTABLE, STABLE),
        (HORIZON, UNSTABLE, UNDECIDED),
        (STEADY, UNSTABLE, UNDECIDED),
        (UNRESOLVED, UNDECIDED, UNDECIDED),
        (INVALID, UNDECIDED, UNDECIDED),
        (NOT_COMPUTED, UNDECIDED, UNDECIDED),
        (99, UNDECIDED, UNDECIDED),
    ]:
        assert verdict("peak_tilt > 10deg", ending, peak_tilt=0.2) == true
        assert verdict("peak_tilt > 10deg", ending, peak_tilt=0.1) == false
        assert {each.code for each in ENDINGS} == {
            BOUNDED,
            FELL,
            HORIZON,
            STEADY,
            UNRESOLVED,
            INVALID,
            NOT_COMPUTED,
        }


def test_a_comparison_with_a_missing_value_is_false():
    """Whatever the sign: only `not` makes it true, and a chain is false if one of its values is missing."""
    for sign in ["<", "<=", ">", ">=", "==", "!="]:
        for missing in [math.nan, math.inf, -math.inf]:
            assert verdict(f"fall_time {sign} 2s", BOUNDED, fall_time=missing) == STABLE
            assert verdict(f"2s {sign} fall_time", BOUNDED, fall_time=missing) == STABLE
            assert verdict(f"not fall_time {sign} 2s", BOUNDED, fall_time=missing) == UNSTABLE
            assert (
                verdict(
                    f"0 <= nutation_period {sign} fall_time", BOUNDED, nutation_period=2.0, fall_time=missing
                )
                == STABLE
            )


def test_parameters_of_the_start_are_compared_too():
    """Thrice the tilt that the disk began with, and the sign of a rate."""
    assert verdict("peak_tilt > 3*tilt", BOUNDED, peak_tilt=0.31, tilt=0.1) == UNSTABLE
    assert verdict("peak_tilt > 3*tilt", BOUNDED, peak_tilt=0.31, tilt=0.11) == STABLE
    assert verdict("abs(tilt_min) > 2*abs(tilt)", BOUNDED, tilt_min=-0.3, tilt=-0.1) == UNSTABLE
    assert verdict("roll_rate < 0", BOUNDED, roll_rate=-1.0) == UNSTABLE


def test_flags_are_compared_by_their_names():
    """The names are those of the file."""
    assert verdict("ending == fell", FELL) == UNSTABLE
    assert verdict("ending == fell", BOUNDED) == STABLE
    assert verdict("ending != bounded", HORIZON) == UNSTABLE


def test_it_is_compared_in_double_precision():
    """A variable that the file holds in single precision is not compared in it: 0.1 is no float32."""
    found = Criterion.parse("energy_drift > 0.1").verdict(
        DISK.endings, {"ending": np.array([BOUNDED]), "energy_drift": np.array([0.1], np.float32)}, NONE, NONE
    )
    assert float(np.float32(0.1)) > 0.1
    assert found.tolist() == [UNSTABLE]


def test_it_is_written_as_it_is_read():
    """In words, in Python and from the canonical text of a spec: the same criterion, the same fingerprint."""
    spec = SweepSpec.preset("rolling").replace(criterion="((peak_tilt>10.0 deg)) or fall_time < 2000ms")
    assert str(spec.criterion) == TEXT
    for same in (
        SweepSpec.from_words("rolling", [f"criterion={TEXT}"]),
        SweepSpec.from_canonical(spec.canonical()),
        pickle.loads(pickle.dumps(spec)),
        spec.replace(criterion=Criterion.parse(TEXT)),
        spec.replace(title=""),
    ):
        assert same.criterion == spec.criterion
        assert same.criterion.kind == "expression"
        assert same.fingerprint() == spec.fingerprint()
    assert json.loads(spec.canonical())["criterion"] == TEXT
    assert pickle.loads(pickle.dumps(spec.criterion)) == spec.criterion
    assert spec.criterion != Criterion.parse("peak_tilt > 10deg")
    assert spec.criterion != Criterion("departure", math.radians(10))


def test_it_stands_in_a_spec_file(tmp_path):
    """A TOML file holds it in quotes, and the text that a spec writes of itself reads back."""
    path = tmp_path / "own.toml"
    path.write_text(f'roll_rate = "2:4:9"\ntilt = "1deg"\ncriterion = "{TEXT}"\n')
    spec = SweepSpec.from_toml(path)
    assert str(spec.criterion) == TEXT
    path.write_text(spec.to_toml())
    assert SweepSpec.from_toml(path) == spec
    path.write_text('criterion = "peak_tilt > 10deg or"\n')
    with pytest.raises(RequestError) as caught:
        SweepSpec.from_toml(path)
    assert "own.toml: criterion=peak_tilt > 10deg or" in str(caught.value)
    assert "At character 21" in str(caught.value)


def test_what_the_atlas_does_not_have_is_refused_by_name():
    """The variable is named, and the word that adds it."""
    for words, facts in [
        ({"criterion": "wells == two_wells"}, ["wells", "method=exact"]),
        ({"criterion": "separatrix < 0"}, ["separatrix", "method=exact"]),
        ({"criterion": "friction_needed > 0.2"}, ["friction_needed", "contact=yes"]),
        ({"criterion": "contact_state == lifts_off or wells == one_well"}, ["contact=yes and method=exact"]),
        ({"criterion": "fall_time < 2s", "method": "exact"}, ["fall_time", "method=exact", "method=rk4"]),
        ({"criterion": "steps > 100", "method": "exact"}, ["steps", "method=rk4"]),
        ({"criterion": "stability == stable"}, ["stability names nothing"]),
        ({"criterion": "hoop_rate > 3rad/s"}, ["hoop_rate names nothing"]),
    ]:
        with pytest.raises(RequestError) as caught:
            SweepSpec(**words)
        assert caught.value.where.partition("=")[0] == "criterion"
        assert all(fact in str(caught.value) for fact in facts), str(caught.value)
        assert caught.value.hint


def test_what_the_request_adds_can_be_compared():
    """With the word that adds it a variable can stand in an expression."""
    for words in [
        {"criterion": "wells == two_wells and separatrix > 0", "method": "exact"},
        {"criterion": "friction_needed > 0.2", "contact": "yes"},
        {"criterion": "friction_needed > 0.2", "contact": "yes", "method": "exact"},
        {"criterion": "nutation_period > 1s", "method": "exact"},
    ]:
        assert str(SweepSpec(**words).criterion) == words["criterion"]


def test_its_words():
    """It says what it is, in the file what is stable where it is false, and in figures degrees as a sign."""
    criterion = Criterion.parse(f"{TEXT} or not (amplification > 3 and abs(tilt_min) > 2*abs(tilt))")
    assert criterion.unstable_if(DISK) == str(criterion)
    assert criterion.label(DISK) == str(criterion)
    assert "peak_tilt > 10° or" in criterion.caption(DISK)
    assert max(map(len, criterion.caption(DISK).split("\n"))) <= 60
    assert criterion.caption(DISK).replace("\n", " ").replace("°", "deg") == str(criterion)
    comment = criterion.comment(DISK)
    assert str(criterion) in comment
    assert "bounded or fell" in comment
    assert comment.isascii()
    assert np.isnan(criterion.allowed(np.ones(3))).all()
    assert not criterion.limits_reach
    assert criterion.needs(DISK) == ("ending", "peak_tilt", "fall_time", "amplification", "tilt_min")


def test_it_gives_the_reason_of_a_verdict():
    """Each comparison with whether it is true, and the values of the cell."""
    for ending, stability, values, facts in [
        (
            BOUNDED,
            UNSTABLE,
            {"peak_tilt": 0.2},
            [
                "peak_tilt > 10deg is true: peak_tilt is 11.4592 deg",
                "fall_time < 2s is false: fall_time is missing",
            ],
        ),
        (
            BOUNDED,
            STABLE,
            {"peak_tilt": 0.1},
            ["peak_tilt > 10deg is false", "the ending, bounded, is final"],
        ),
        (
            FELL,
            STABLE,
            {"peak_tilt": 0.1, "fall_time": 3.0},
            ["fall_time is 3 s", "the ending, fell, is final"],
        ),
        (HORIZON, UNDECIDED, {"peak_tilt": 0.1}, ["is false", "duration of 300 s was over"]),
        (HORIZON, UNSTABLE, {"peak_tilt": 0.2}, ["is true"]),
    ]:
        cell = {
            "ending": ending,
            "stability": stability,
            "peak_tilt": math.nan,
            "fall_time": math.nan,
            **values,
        }
        reason = Criterion.parse(TEXT).reason(SweepSpec(), cell, math.nan, math.nan)
        assert all(fact in reason for fact in facts), reason
        assert "any criterion" not in reason


def test_a_function_is_no_criterion_of_a_request():
    """No word spells it, and what names one computes nothing."""
    for text in ("function", "function:f", "function f"):
        with pytest.raises(RequestError, match="is no criterion"):
            SweepSpec(criterion=text)
    spec = SweepSpec(criterion=Criterion("function", "f"))
    assert SweepSpec.from_canonical(spec.canonical()) == spec
    assert str(spec.criterion) == "function f"
    with pytest.raises(RequestError, match="judged the cells of an atlas in memory"):
        sweep.run(spec)
    for name in (3, "a\x1bb"):
        with pytest.raises(RequestError, match="name of a function"):
            Criterion("function", name)
