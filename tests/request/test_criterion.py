"""Criteria of stability: parsing, writing, storage, verdicts, and their descriptions."""

import json
import math
import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from messages import assert_facts, assert_in_order, refused

import sweep
from kernels.disk.endings import BOUNDED, FELL, HORIZON, INVALID, NOT_COMPUTED, STEADY, UNRESOLVED
from kernels.system import endings as of_system
from sweep.checks.verify import findings, verify
from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import ENDINGS
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.model.quantity import FILL, FINAL, MISSING, STABLE, UNDECIDED, UNSTABLE, Ending, Endings
from sweep.model.system.model import model_of
from sweep.request.criterion import Criterion
from sweep.request.criterion_reason import reason_of
from sweep.request.spec import SweepSpec
from sweep.request.system_file import read_system

DEPARTURE, AMPLIFICATION = Criterion("departure", 0.1), Criterion("amplification", 10.0)
TEXT = "peak_tilt > 10deg or fall_time < 2s"
NONE = np.array([math.nan])
LOSSY = {"contour_friction": "1um", "criterion": "aloft:10s"}
POSITIVE = st.floats(0, exclude_min=True, allow_infinity=False)
ANGLES = st.floats(0, math.pi, exclude_min=True, exclude_max=True)
CRITERIA = st.one_of(
    st.builds(lambda limit: Criterion("departure", limit), ANGLES),
    st.builds(
        lambda kind, limit: Criterion(kind, limit), st.sampled_from(["amplification", "aloft"]), POSITIVE
    ),
)


def by_reach(criterion, ending, reach, scale=0.01):
    """Return the verdict on one cell with a given reach."""
    found = criterion.verdict(ENDINGS, {"ending": np.array([ending])}, np.array([reach]), np.array([scale]))
    return int(found[0])


def by_values(text, ending, model=DISK, **values):
    """Return a criterion's verdict on one cell of which only the given variables are known."""
    criterion = Criterion.parse(text, model)
    cell = {
        name: np.array([values.get(name, math.nan)]) for name in (*criterion.needs(model), *model.parameters)
    }
    code = model.endings.code(ending) if isinstance(ending, str) else ending
    return int(criterion.verdict(model.endings, {**cell, "ending": np.array([code])}, NONE, NONE)[0])


def test_a_criterion_is_read_from_text():
    """Each kind is read with its units, and its own spelling is reproduced exactly."""
    for text, kind, limit in [
        ("departure:5deg", "departure", math.pi / 36),
        (" departure : 0.1 ", "departure", 0.1),
        ("amplification:10", "amplification", 10.0),
        (" aloft : 2min", "aloft", 120.0),
    ]:
        assert Criterion.parse(text) == Criterion(kind, limit)
    for text in ["departure:5deg", "departure:0.1rad", "amplification:2.5", "aloft:10s", TEXT]:
        assert str(Criterion.parse(text)) == text


@given(CRITERIA)
def test_a_criterion_comes_back_as_itself(criterion):
    """Its text, pickle, fields and plain types restore it bit for bit."""
    for same in (
        Criterion.parse(str(criterion)),
        pickle.loads(pickle.dumps(criterion)),
        Criterion(criterion.kind, criterion.limit),
        Criterion(**criterion.kept()),
    ):
        assert (same, hash(same), same.limit) == (criterion, hash(criterion), criterion.limit)


def test_a_criterion_is_one_of_its_kinds():
    """Criteria differ if their kinds or limits differ, and are immutable."""
    assert Criterion("departure", 1.0) != Criterion("amplification", 1.0)
    assert Criterion("departure", 1.0) != Criterion("departure", np.nextafter(1.0, 2.0))
    with pytest.raises(AttributeError):
        DEPARTURE.limit = 0.2


def test_what_is_not_a_criterion_is_refused():
    """The error names the criterion, the broken rule and the given value."""
    for text, facts in [
        ("departure", ["departure:ANGLE", "amplification:NUMBER"]),
        ("energy:3", ["departure:ANGLE", "amplification:NUMBER", "energy:3"]),
        ("departure:0deg", ["above 0"]),
        ("departure:-5deg", ["above 0", "-5deg"]),
        ("amplification:-10", ["above 0", "-10"]),
        ("departure:5", ["bare number", "rad", "180 deg"]),
        ("departure:180deg", ["below 180 deg"]),
        ("departure:5s", ["s", "deg, rad"]),
        ("amplification:10deg", ["deg", "no unit"]),
        ("amplification:inf", ["finite"]),
        ("departure:1deg,2deg", ["one number"]),
        ("departure:", ["number"]),
        ("aloft:0s", ["above 0"]),
        ("aloft:5deg", ["deg", "s, ms, min"]),
        ("function:f", ["departure:ANGLE", "function:f"]),
        ("function f", ["departure:ANGLE", "function f"]),
    ]:
        with pytest.raises(RequestError) as caught:
            Criterion.parse(text)
        assert caught.value.where.partition("=")[0] == "criterion"
        assert_facts(str(caught.value), *facts)
        assert caught.value.hint
    for raw in [("energy", 3.0), ("departure", 0.0), ("amplification", math.nan), ("expression", 3.0),
                ("function", 3), ("function", "a\x1bb")]:  # fmt: skip
        with pytest.raises(RequestError):
            Criterion(*raw)


# -- verdicts


def test_the_verdict_of_every_ending():
    """Each ending has verdicts for a reach within or beyond the limit, and for false or true expressions."""
    assert {each.code for each in ENDINGS} == {
        BOUNDED, HORIZON, FELL, STEADY, UNRESOLVED, INVALID, NOT_COMPUTED
    }  # fmt: skip
    for ending, within, beyond, false, true in [
        (BOUNDED, STABLE, UNSTABLE, STABLE, UNSTABLE),
        (HORIZON, UNDECIDED, UNSTABLE, UNDECIDED, UNSTABLE),
        (FELL, UNSTABLE, UNSTABLE, STABLE, UNSTABLE),
        (STEADY, UNDECIDED, UNDECIDED, UNDECIDED, UNSTABLE),
        (UNRESOLVED, UNDECIDED, UNDECIDED, UNDECIDED, UNDECIDED),
        (INVALID, UNDECIDED, UNDECIDED, UNDECIDED, UNDECIDED),
        (NOT_COMPUTED, UNDECIDED, UNDECIDED, UNDECIDED, UNDECIDED),
        (99, UNDECIDED, UNDECIDED, UNDECIDED, UNDECIDED),
        (-1, UNDECIDED, UNDECIDED, UNDECIDED, UNDECIDED),
    ]:
        for criterion in [DEPARTURE, AMPLIFICATION]:
            assert (by_reach(criterion, ending, 0.05), by_reach(criterion, ending, 0.2)) == (within, beyond)
        found = [by_values("peak_tilt > 10deg", ending, peak_tilt=peak) for peak in (0.1, 0.2)]
        assert found == [false, true], ending


def test_the_verdict_by_a_time():
    """A cell is unstable only if lost before the time, and undecided if not followed that long."""
    for model, ending, time, expected in [
        (LOSSY_DISK, "flat", 9.999, UNSTABLE),
        (LOSSY_DISK, "flat", 10.0, STABLE),
        (LOSSY_DISK, "rest", 3.0, STABLE),
        (LOSSY_DISK, "horizon", 10.0, STABLE),
        (LOSSY_DISK, "lift_off", 9.0, UNDECIDED),
        (LOSSY_DISK, "slip", 11.0, STABLE),
        (LOSSY_DISK, "undisturbed", np.nan, UNDECIDED),
        (LOSSY_DISK, "unresolved", np.nan, UNDECIDED),
        (LOSSY_DISK, "not_computed", np.nan, UNDECIDED),
        (DISK, "fell", 9.0, UNSTABLE),
        (DISK, "fell", 11.0, STABLE),
        (DISK, "bounded", np.nan, STABLE),
        (DISK, "horizon", np.nan, STABLE),
        (DISK, "steady", np.nan, UNDECIDED),
        (DISK, "invalid", np.nan, UNDECIDED),
    ]:
        given = {model.endings.lost_time: time}
        assert by_values("aloft:10s", ending, model, **given) == expected, (model.name, ending)


def test_an_ending_of_no_model_is_undecided():
    """A code unknown to the model, as in a damaged file, gets no verdict, even next to a final one."""
    endings = Endings(Ending(0, "none", "", MISSING), Ending(1, "done", "", FINAL))
    for criterion in (DEPARTURE, Criterion("aloft", 1.0), Criterion.parse(TEXT)):
        found = criterion.outcome(endings, np.array([1, 2, 9, -1], np.int8), np.zeros(4, bool))
        assert found.tolist() == [STABLE, UNDECIDED, UNDECIDED, UNDECIDED]


def test_a_cell_without_numbers_is_never_stable():
    """A cell without extremes (NaN or the file's fill value) is never called stable by a limit."""
    for missing in [math.nan, FILL]:
        for ending in {each.code for each in ENDINGS} - {FELL}:
            for criterion in (DEPARTURE, AMPLIFICATION):
                assert by_reach(criterion, ending, missing) != STABLE
    for scale in (math.nan, 0.0):
        assert by_reach(AMPLIFICATION, BOUNDED, 0.0, scale) == UNDECIDED


def test_the_limit_itself_is_stable():
    """A reach of exactly the limit is stable; an amplification's limit scales with the perturbation."""
    assert by_reach(DEPARTURE, BOUNDED, 0.1) == STABLE
    assert by_reach(DEPARTURE, BOUNDED, np.nextafter(0.1, 1.0)) == UNSTABLE
    assert by_reach(AMPLIFICATION, BOUNDED, 0.05, scale=0.006) == STABLE
    assert by_reach(AMPLIFICATION, BOUNDED, 0.05, scale=0.004) == UNSTABLE
    scales = np.array([0.0, 0.01, 0.03])
    assert Criterion("departure", 0.2).allowed(scales).tolist() == [0.2, 0.2, 0.2]
    # The relative tolerance is one rounding.
    assert AMPLIFICATION.allowed(scales) == pytest.approx([math.nan, 0.1, 0.3], rel=1e-15, nan_ok=True)
    assert np.isnan(Criterion.parse(TEXT).allowed(np.ones(3))).all()


def test_verdicts_keep_the_shape_of_the_grid():
    """Verdicts are int8 in the shape of the cells, even for a single cell without dimensions."""
    ending = {"ending": np.full((2, 3), BOUNDED, dtype=np.int8)}
    result = DEPARTURE.verdict(ENDINGS, ending, np.zeros((2, 3)), np.ones(3))
    assert (result.shape, result.dtype) == ((2, 3), np.int8)
    one = DEPARTURE.verdict(ENDINGS, {"ending": np.int8(BOUNDED)}, np.float64(0.0), np.float64(1.0))
    assert one.shape == ()


def test_a_comparison_with_a_missing_value_is_false():
    """With any sign, only `not` makes it true; a chain with a missing value is false."""
    for sign in ["<", "<=", ">", ">=", "==", "!="]:
        for missing in [math.nan, math.inf, -math.inf]:
            for text, expected in [
                (f"fall_time {sign} 2s", STABLE),
                (f"2s {sign} fall_time", STABLE),
                (f"not fall_time {sign} 2s", UNSTABLE),
                (f"0 <= nutation_period {sign} fall_time", STABLE),
            ]:
                assert by_values(text, BOUNDED, nutation_period=2.0, fall_time=missing) == expected, text


def test_what_an_expression_compares():
    """Parameters, named flags and double precision work: a float32 0.1 exceeds 0.1."""
    for text, ending, values, expected in [
        ("peak_tilt > 3*tilt", BOUNDED, {"peak_tilt": 0.31, "tilt": 0.1}, UNSTABLE),
        ("peak_tilt > 3*tilt", BOUNDED, {"peak_tilt": 0.31, "tilt": 0.11}, STABLE),
        ("abs(tilt_min) > 2*abs(tilt)", BOUNDED, {"tilt_min": -0.3, "tilt": -0.1}, UNSTABLE),
        ("roll_rate < 0", BOUNDED, {"roll_rate": -1.0}, UNSTABLE),
        ("ending == fell", FELL, {}, UNSTABLE),
        ("ending == fell", BOUNDED, {}, STABLE),
        ("ending != bounded", HORIZON, {}, UNSTABLE),
        ("energy_drift > 0.1", BOUNDED, {"energy_drift": np.float32(0.1)}, UNSTABLE),
    ]:
        assert by_values(text, ending, **values) == expected, text


def test_a_time_within_its_error_leaves_the_verdict_open():
    """A motion lost within the stated error of the time is open, others are not."""
    spec = SweepSpec(**LOSSY, tilt="1deg,2deg,3deg")
    flat, horizon = (LOSSY_DISK.endings.code(name) for name in ("flat", "horizon"))
    measured = {
        "ending": np.array([flat, flat, horizon]),
        "end_time": np.array([9.999, 9.9, 10.0]),
        "time_error": np.array([1e-3, 1e-3, 1e-3], np.float32),
        "tilt_min": np.zeros(3),
        "tilt_max": np.array([1.57, 1.57, 0.5]),
        "stability": np.array([UNSTABLE, UNSTABLE, STABLE]),
    }
    assert spec.criterion.is_open(spec, {}, measured, np.zeros(3)).tolist() == [True, False, False]


def test_a_reach_within_its_error_leaves_the_verdict_open():
    """A reach within its error of the limit, or a possible fall, is open; a fall is always unstable."""
    spec = SweepSpec(tilt="1deg,2deg,3deg,4deg,5deg", criterion="departure:0.1rad")
    measured = {
        "ending": np.array([BOUNDED, BOUNDED, BOUNDED, FELL, HORIZON]),
        "tilt_min": np.zeros(5),
        "tilt_max": np.array([0.0995, 0.0985, 0.1005, 0.0995, 0.0995]),
        "stability": np.array([STABLE, STABLE, UNSTABLE, UNSTABLE, UNDECIDED]),
    }
    starts, error = {name: np.zeros(5) for name in DISK.parameters}, np.full(5, 1e-3)
    found = spec.criterion.is_open(spec, starts, measured, error)
    assert found.tolist() == [True, False, True, False, False]
    near_fall = spec.replace(criterion="departure:100deg", fall_tilt=0.1)
    found = near_fall.criterion.is_open(near_fall, starts, measured, error)
    assert found.tolist() == [True, False, False, False, False]


# -- in a spec


def test_it_is_written_as_it_is_read(spec_file):
    """Words, file, Python and canonical text give one criterion and one fingerprint."""
    spec = SweepSpec.preset("rolling").replace(criterion="((peak_tilt>10.0 deg)) or fall_time < 2000ms")
    assert str(spec.criterion) == TEXT
    for same in (
        SweepSpec.from_words("rolling", [f"criterion={TEXT}"]),
        SweepSpec.from_canonical(spec.canonical()),
        SweepSpec.from_toml(spec_file(spec.to_toml())),
        pickle.loads(pickle.dumps(spec)),
        spec.replace(criterion=Criterion.parse(TEXT)),
    ):
        assert (same.criterion, same.fingerprint()) == (spec.criterion, spec.fingerprint())
    assert json.loads(spec.canonical())["criterion"] == TEXT
    with refused("sweep.toml:", "criterion=peak_tilt > 10deg or:", "21"):
        SweepSpec.from_toml(spec_file('criterion = "peak_tilt > 10deg or"\n'))


def test_what_the_atlas_does_not_have_is_refused_by_name():
    """The message names the variable and the input that adds it, which makes the criterion valid."""
    for criterion, words, facts in [
        ("wells == two_wells", {"method": "exact"}, ["wells", "method=exact"]),
        ("friction_needed > 0.2", {"contact": "yes"}, ["friction_needed", "contact=yes"]),
        (
            "contact_state == lifts_off or wells == one_well",
            {"contact": "yes", "method": "exact"},
            ["contact=yes", "method=exact"],
        ),
    ]:
        assert str(SweepSpec(criterion=criterion, **words).criterion) == criterion
        with refused(*facts):
            SweepSpec(criterion=criterion)
    for words, facts in [
        ({"criterion": "fall_time < 2s", "method": "exact"}, ["fall_time", "method=exact", "method=rk4"]),
        ({"criterion": "aloft:10s", "method": "exact"}, ["fall_time", "method=exact"]),
        ({"criterion": "stability == stable"}, ["1", "stability", "ending, tilt_min"]),
        ({**LOSSY, "duration": "5s"}, ["aloft:10s", "duration=5s", "10s"]),
    ]:
        with refused(*facts) as caught:
            SweepSpec(**words)
        assert caught.value.where.partition("=")[0] == "criterion"
    assert SweepSpec(**LOSSY, duration="10s").duration == 10.0


def test_a_criterion_that_the_model_cannot_serve_is_refused(monkeypatch):
    """The message names the criterion, the missing variable and the model."""
    monkeypatch.setattr(Criterion, "needs", lambda self, model: ("ending", "time_aloft"))
    with refused("departure:5deg", "time_aloft", "disk"):
        SweepSpec(criterion="departure:5deg")


def test_a_function_judges_no_new_cells():
    """A spec can name a function, but cannot compute with it."""
    spec = SweepSpec(criterion=Criterion("function", "f"))
    assert SweepSpec.from_canonical(spec.canonical()) == spec
    assert str(spec.criterion) == "function f"
    with refused("function f", "memory"):
        sweep.run(spec)


def test_verdicts_follow_from_what_a_criterion_needs():
    """It needs the ending, and both extremes, the time for `aloft`, or an expression's variables."""
    long = Criterion.parse(f"{TEXT} or not (amplification > 3 and abs(tilt_min) > 2*abs(tilt))")
    for criterion, model, needed in [
        (DEPARTURE, DISK, ("tilt_min", "tilt_max")),
        (AMPLIFICATION, DISK, ("tilt_min", "tilt_max")),
        (Criterion("aloft", 1.0), DISK, ("fall_time",)),
        (Criterion("aloft", 1.0), LOSSY_DISK, ("end_time",)),
        (long, DISK, ("peak_tilt", "fall_time", "amplification", "tilt_min")),
    ]:
        assert criterion.needs(model) == ("ending", *needed)
        assert criterion.limits_reach == (criterion in (DEPARTURE, AMPLIFICATION))
        assert criterion.predictable == (criterion is not long)


@pytest.mark.compiled
def test_a_map_of_the_disk_without_losses():
    """A time criterion gives the verdict of an expression in the fall time; the file passes `verify`."""
    words = {"tilt": "10deg:80deg:8", "roll_rate": "0:3:7", "duration": "20s"}
    atlas = sweep.run(SweepSpec(**words, criterion="aloft:0.7s"))
    fell = atlas.ending == DISK.endings.code("fell")
    np.testing.assert_array_equal(atlas.stability, np.where(fell & (atlas.fall_time < 0.7), UNSTABLE, STABLE))
    assert {UNSTABLE, STABLE} == set(np.unique(atlas.stability).tolist())
    assert findings(verify(atlas)).passed


# -- in words


def test_its_words():
    """Messages, figures and files state the limit and what counts as lost."""
    aloft, own = Criterion("aloft", 10.0), Criterion.parse(f"{TEXT} or not (amplification > 3 and steps > 2)")
    for criterion, model, unstable, label, caption, comment in [
        (
            Criterion.parse("departure:5deg"),
            DISK,
            ["tilt", "5 deg", "falls"],
            ["departure", "5°"],
            ["departure", "5°", "falls"],
            [],
        ),
        (
            AMPLIFICATION,
            DISK,
            ["tilt", "10", "perturbation", "falls"],
            ["amplification", "10"],
            ["amplification", "10", "falls"],
            [],
        ),
        (
            aloft,
            LOSSY_DISK,
            ["falls", "flat", "10 s"],
            ["aloft", "10 s"],
            ["aloft", "10 s"],
            ["unstable", "end_time", "10 s", "stable", "unresolved", "undecided"],
        ),
    ]:
        for text, facts in (
            (criterion.unstable_if(model), unstable),
            (criterion.label(model), label),
            (criterion.caption(model), caption),
            (criterion.comment(model), comment),
        ):
            assert_facts(text, *facts)
            assert len(re.findall(r"\d+", text)) == (1 if facts else 0)
        # It must fit into a legend.
        assert len(criterion.label(model)) < 20
    assert own.unstable_if(DISK) == own.label(DISK) == str(own)
    assert max(map(len, own.caption(DISK).split("\n"))) <= 60
    assert own.caption(DISK).replace("\n", " ").replace("°", "deg") == str(own)
    assert_facts(
        own.comment(DISK), "unstable", str(own), "stable", "bounded", "fell", "unresolved", "undecided"
    )


def test_a_criterion_gives_the_reason_of_a_verdict():
    """The reason states the reach and its limit, the time of the loss, or the true comparisons."""
    reach = ["departure:5deg", "amplification:10"]
    for texts, ending, stability, far, values, facts in [
        (reach, BOUNDED, UNSTABLE, 6.0, {}, ["tilt", "6 deg", "5 deg"]),
        (reach, BOUNDED, STABLE, 4.0, {}, ["tilt", "4 deg", "5 deg", "turning points"]),
        (reach, HORIZON, UNDECIDED, 4.0, {}, ["tilt", "4 deg", "5 deg", "300 s", "turning points"]),
        (reach, FELL, UNSTABLE, 85.0, {"fall_time": 7.0}, ["fall_tilt", "85 deg", "7 s"]),
        (["aloft:0.7s"], FELL, UNSTABLE, 0.0, {"fall_time": 0.5}, ["falls", "0.5 s", "0.7 s"]),
        (["aloft:0.7s"], HORIZON, STABLE, 0.0, {}, ["0.7 s", "300 s"]),
        ([TEXT], BOUNDED, UNSTABLE, 0.0, {"peak_tilt": 0.2},
         ["peak_tilt > 10deg", "true", "11.4592 deg", "fall_time < 2s", "false", "missing"]),
        ([TEXT], BOUNDED, STABLE, 0.0, {"peak_tilt": 0.1},
         ["peak_tilt > 10deg", "false", "5.72958 deg", "fall_time < 2s", "false", "missing", "bounded"]),
        ([TEXT], FELL, STABLE, 0.0, {"peak_tilt": 0.1, "fall_time": 3.0},
         ["peak_tilt > 10deg", "false", "5.72958 deg", "fall_time < 2s", "false", "3 s", "fell"]),
        ([TEXT], HORIZON, UNDECIDED, 0.0, {"peak_tilt": 0.1},
         ["peak_tilt > 10deg", "false", "5.72958 deg", "fall_time < 2s", "false", "missing", "300 s"]),
        ([TEXT], HORIZON, UNSTABLE, 0.0, {"peak_tilt": 0.2}, ["peak_tilt > 10deg", "true", "11.4592 deg"]),
    ]:  # fmt: skip
        cell = {"ending": ending, "stability": stability, "peak_tilt": math.nan, "fall_time": math.nan}
        for text in texts:
            # Ten times half a degree is 5 deg.
            half = math.radians(0.5)
            reason = reason_of(
                Criterion.parse(text), SweepSpec(), {**cell, **values}, math.radians(far), half
            )
            assert_in_order(reason, *facts)
            assert ("300 s" in reason) == ("300 s" in facts), reason
            assert ("0.5 deg" in reason) == (text.startswith("amplification") and ending != FELL)


def test_a_disk_that_friction_holds_is_stable():
    """It never moves again, so it is stable; a disk lying flat is not."""
    endings = LOSSY_DISK.endings
    codes = np.array([endings.code(name) for name in ("rest", "flat")])
    found = Criterion("departure", 0.1).outcome(endings, codes, np.zeros(2, bool))
    assert found.tolist() == [STABLE, UNSTABLE]


# -- what is known

SYSTEM = """
@system(duration="10", measures={"top": "max x"}, stable="top < 2")
def swing(x=1.0, v=0.0, *, rate=1.0):
    return v, -(rate**2)*x
"""


def decided(criterion, **columns):
    """Return the verdicts on cells of `SYSTEM` with these values, 0 where none is given."""
    model = model_of(read_system(SYSTEM))
    spec = SweepSpec(model=model, criterion=criterion)
    size = len(columns["ending"])
    held = {name: np.zeros(size) for name in model.variables} | {
        name: np.asarray(values) for name, values in columns.items()
    }
    nothing = np.full(size, np.nan)
    return spec.criterion.decide(
        spec, {name: np.zeros(size) for name in model.parameters}, held, nothing, nothing
    )


def test_a_measure_within_its_stated_error_decides_nothing():
    """Beyond twice the error it decides, on either side, whatever is known about the ending."""
    top = [1.0, 1.9, 2.0, 2.1, 3.0]
    for ending in (of_system.RUNS_ON, of_system.DIFFERENT):
        found = decided("top > 2", ending=[ending] * 5, top=top, top_error=[0.06] * 5)
        assert found.tolist() == [STABLE, UNDECIDED, UNDECIDED, UNDECIDED, UNSTABLE]
        found = decided("not (top <= 2)", ending=[ending] * 5, top=top, top_error=[0.0] * 5)
        # Exactly on the limit, rounding decides.
        assert found.tolist() == [STABLE, STABLE, UNDECIDED, UNSTABLE, UNSTABLE]


def test_an_ending_that_nobody_knows_decides_nothing():
    """For sensitive motions a criterion about endings is open, unless its other terms decide."""
    endings = [of_system.RUNS_ON, of_system.DIFFERENT, of_system.UNRESOLVED]
    assert decided("ending != runs_on", ending=endings).tolist() == [STABLE, UNDECIDED, UNDECIDED]
    both = decided("ending != runs_on or top > 2", ending=endings, top=[3.0, 3.0, 3.0])
    assert both.tolist() == [UNSTABLE, UNSTABLE, UNDECIDED]
    both = decided("ending != runs_on and top > 2", ending=endings, top=[1.0, 1.0, 1.0])
    assert both.tolist() == [STABLE, STABLE, UNDECIDED]


@pytest.mark.parametrize("error", [0.0, 1e-9])
def test_a_motion_that_leaves_its_start_no_further_is_at_its_start(error):
    """The start's tilt is exact: a start at the limit is stable if it goes no further, otherwise open."""
    limit = 0.1
    spec = SweepSpec(tilt=[0.05, limit], criterion=f"departure:{limit}rad")
    highs = np.array([limit, limit, limit + 1e-9, limit + 1e-6])
    tilts = np.array([0.05, limit, limit, limit])
    columns = {
        "ending": np.full(4, BOUNDED), "tilt_min": np.zeros(4), "tilt_max": highs, "tilt_error": np.full(4, error)
    }  # fmt: skip
    starts = {name: np.zeros(4) for name in DISK.parameters} | {"tilt": tilts}
    found = spec.criterion.decide(spec, starts, columns, highs, tilts)
    within = UNDECIDED if error else UNSTABLE
    assert found.tolist() == [UNDECIDED, STABLE, within, UNSTABLE]


def test_a_verdict_that_errors_leave_open_says_so():
    """It has the number, its error and the limit; for a sensitive motion also if the known part decides."""
    departure = SweepSpec(criterion="departure:0.1rad")
    cell = {"ending": BOUNDED, "stability": UNDECIDED, "tilt_min": 0.0, "tilt_max": 0.1, "tilt_error": 1e-6}
    told = reason_of(departure.criterion, departure, cell, 0.1, 0.05)
    assert_in_order(told, "5.72958 deg", "+-", "0.000115 deg", "5.72958 deg")
    model = model_of(read_system(SYSTEM))
    spec = SweepSpec(model=model, criterion="top > 2")
    values = dict.fromkeys(model.variables, 0.0) | {"ending": of_system.DIFFERENT}
    open_ = reason_of(spec.criterion, spec, {**values, "top": 2.0, "stability": UNDECIDED}, np.nan, np.nan)
    known = reason_of(spec.criterion, spec, {**values, "top": 1.0, "stability": STABLE}, np.nan, np.nan)
    assert_facts(open_, "top is 2", "but", "sensitive")
    assert_facts(known, "top is 1", "known", "sensitive")
