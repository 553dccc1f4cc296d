import numpy as np
import pytest
import referee
import xarray as xr
from scipy.integrate import solve_ivp

import sweep
from sweep.audit import audit, findings
from sweep.axes import Range
from sweep.criterion import Criterion
from sweep.errors import RequestError
from sweep.report import audit_line, audit_text
from sweep.schema import PARAMETERS, VARIABLES
from sweep.schema_exact import AUDIT
from sweep.spec import SweepSpec

PRESETS = ("rolling", "spinning", "circling")
ENDINGS = {name: code for code, name in VARIABLES["ending"].flags.items()}

pytestmark = pytest.mark.compiled


def coarse(preset, **changes):
    """Return a preset with 40 x 30 cells over its own ranges."""
    spec = SweepSpec.preset(preset)
    for name in spec.axes:
        axis = getattr(spec, name)
        count = 30 if name == "tilt" else 40
        spec = spec.replace(**{name: Range(axis.start, axis.stop, count, axis.spacing)})
    return spec.replace(**changes)


@pytest.fixture(scope="module")
def atlases():
    """Coarse atlases of the presets, not to be changed."""
    return {name: sweep.run(coarse(name)) for name in PRESETS}


def flags(audited):
    """Return the flag of each cell by its name."""
    return np.array(list(AUDIT["audit"].flags.values()))[audited.audit.values]


def counts(dataset):
    """Return what the audit says of how many cells, flags that occur."""
    return {name: count for name, count in findings(audit(dataset)).counts.items() if count}


def changed(dataset, place, **values):
    """Return a copy of an atlas with other values in one cell, given by its indices."""
    copy = dataset.copy(deep=True)
    for name, value in values.items():
        copy[name].values[place] = value
    return copy


def moved(dataset, place, low=0.0, high=0.0):
    """Return a copy with the extremes of one cell moved [rad], and all that follows from them made to follow."""
    copy = changed(
        dataset,
        place,
        tilt_min=dataset.tilt_min.values[place] + low,
        tilt_max=dataset.tilt_max.values[place] + high,
    )
    spec = SweepSpec.from_canonical(dataset.attrs["sweep_spec"])
    least, greatest = (float(copy[name].values[place]) for name in ("tilt_min", "tilt_max"))
    start = float(dataset.tilt[place[spec.axes.index("tilt")]]) if "tilt" in spec.axes else spec.tilt
    steady = start if spec.circling else 0.0
    reach = max(abs(least - steady), abs(greatest - steady))
    before = max(abs(float(dataset[name].values[place]) - steady) for name in ("tilt_min", "tilt_max"))
    scale = before / float(dataset.amplification.values[place])
    verdict = spec.criterion.verdict(dataset.ending.values[place], least, greatest, steady, scale)
    return changed(
        copy, place, peak_tilt=max(abs(least), abs(greatest)), amplification=reach / scale, stability=verdict
    )


# --- what is right is found right -----------------------------------------------------------------------------------


@pytest.mark.parametrize("preset", PRESETS)
def test_the_presets_agree(atlases, preset):
    """Every cell of the RK4 presets agrees: none is marginal, unresolved or left out."""
    found = findings(audit(atlases[preset]))
    assert {name: count for name, count in found.counts.items() if count} == {"agrees": 1200}
    assert found.passed
    assert (found.cells, found.agreeing, found.disagreeing, found.missing) == (1200, 1200, 0, 0)
    assert 0.0 < found.tilt[0] < found.tilt[1] <= found.tilt[2] <= 1e-8
    assert found.period_share < 0.01


@pytest.mark.parametrize("preset", PRESETS)
def test_the_exact_values_are_the_referee_s(atlases, preset):
    """The extremes that the atlas is held against are those of an independent quadrature, to 1e-13 rad."""
    dataset = atlases[preset]
    audited = audit(dataset)
    given = [
        xr.broadcast(dataset[name], dataset.ending)[0].transpose(*dataset.ending.dims).values.ravel()
        for name in PARAMETERS
    ]
    truth = referee.extremes(np.array(given))
    assert np.abs(audited.exact_tilt_min.values.ravel() - truth.least).max() < 1e-13
    assert np.abs(audited.exact_tilt_max.values.ravel() - truth.greatest).max() < 1e-13
    difference = np.maximum(
        np.abs(dataset.tilt_min.values.ravel() - truth.least),
        np.abs(dataset.tilt_max.values.ravel() - truth.greatest),
    )
    assert np.abs(audited.tilt_difference.values.ravel() - difference).max() < 1e-13


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        # falls and bounded motions side by side
        ({"tilt": "20deg", "roll_rate": "0:3:31"}, {"agrees": 31}),
        ({"tilt": "20deg", "roll_rate": "-3:3:7", "tilt_rate": "-1,0,1", "alpha": "0.3,1"}, {"agrees": 42}),
        # already fallen at the start
        ({"tilt": "-86deg,80deg,86deg"}, {"agrees": 3}),
        # at rest on equilibria: nothing to disturb them
        ({"tilt": 0, "roll_rate": "1:5:9"}, {"agrees": 9}),
        ({"tilt": "5deg:40deg:8", "precession_rate": "0.5:5:10", "roll_rate": "steady"}, {"agrees": 80}),
        # no roll rate holds a tilted disk that does not precess
        (
            {"tilt": "10deg", "precession_rate": "-1:1:5", "roll_rate": "steady", "tilt_rate": 1e-3},
            {"agrees": 4, "invalid": 1},
        ),
        # one cell, and three axes
        ({"tilt": "1deg", "roll_rate": 3}, {"agrees": 1}),
        ({"tilt": "1deg", "roll_rate": "2:4:5", "alpha": "0.1:1:4", "gravity": "1,9.81"}, {"agrees": 40}),
        # another tolerance, and a step of one's own
        ({"tilt": "0.1deg:40deg:9", "roll_rate": "1:5:9", "tolerance": 1e-4}, {"agrees": 81}),
        ({"tilt": "0.1deg:40deg:9", "roll_rate": "1:5:9", "step": 0.05}, {"agrees": 81}),
    ],
)  # fmt: skip
def test_all_kinds_of_atlases_agree(words, expected):
    """Falls, steady motions, impossible starts, any number of axes, coarse tolerances: all agree or are set apart."""
    dataset = sweep.run(SweepSpec(**words))
    assert counts(dataset) == expected
    assert findings(audit(dataset)).passed
    assert audit(dataset).audit.dims == dataset.ending.dims


@pytest.mark.parametrize("preset", PRESETS)
def test_a_run_that_time_ended_is_within(preset):
    """Where time ended the run, what it saw lies inside the exact extremes; such cells are counted apart, and pass."""
    dataset = sweep.run(coarse(preset, duration=1.2))
    found = findings(audit(dataset))
    horizon = int((dataset.ending == ENDINGS["horizon"]).sum())
    assert 200 <= horizon == found.counts["within"]
    assert found.agreeing == 1200
    assert found.passed
    # they say nothing of how exact the others are
    assert np.isnan(found.tilt[0]) if horizon == 1200 else 0.0 < found.tilt[2] < 1e-8


def test_exact_atlases_agree():
    """An atlas made by the reduction agrees with it to the last bit."""
    for preset in PRESETS:
        found = findings(audit(sweep.run(coarse(preset, method="exact"))))
        assert found.agreeing == 1200
        assert found.tilt == (0.0, 0.0, 0.0)


def test_unresolved_cells_are_counted_apart():
    """Cells that the atlas or the reduction could not resolve are neither dropped nor wrong."""
    lost = sweep.run(SweepSpec(tilt="1deg,2deg,3deg", step=1e5, duration=1e6))
    assert counts(lost) == {"unresolved_in_the_atlas": 3}
    # pushed just as hard as it takes to reach the saddle of its potential: whether it passes is not known to rounding
    words = {"tilt": "20deg", "roll_rate": 1.0}
    height = float(sweep.run(SweepSpec(**words, method="exact")).separatrix)
    push = -np.sqrt(2.0 * height / 1.25 * 9.81 / 0.5)
    saddle = sweep.run(SweepSpec(**words, tilt_rate=[push, 0.5 * push], duration=0.05))
    assert counts(saddle) == {"unresolved_by_the_reduction": 1, "within": 1}
    for dataset in (lost, saddle):
        found = findings(audit(dataset))
        assert found.passed
        assert found.cells == dataset.ending.size
        assert f"{found.agreeing} of {found.cells} cells" in audit_line(found)


# --- what is wrong is found, and named ------------------------------------------------------------------------------

#: A cell that is bounded and stable in every coarse preset.
PLACE = {"rolling": (35, 12), "spinning": (35, 12), "circling": (20, 30)}


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize(
    ("variable", "change", "flag"),
    [
        ("tilt_min", lambda x: x + 1e-7, "extremes_differ"),
        ("tilt_min", lambda x: x - 1e-7, "extremes_differ"),
        ("tilt_max", lambda x: x + 1e-7, "extremes_differ"),
        ("tilt_max", lambda x: x - 1e-7, "extremes_differ"),
        ("tilt_min", lambda x: np.nan, "extremes_differ"),
        ("tilt_max", lambda x: np.inf, "extremes_differ"),
        # within the tolerance, but then the peak no longer follows
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
    ],
)  # fmt: skip
def test_a_corrupted_cell_is_caught(atlases, preset, variable, change, flag):
    """One wrong value in one cell: exactly that cell does not agree, for the right reason, and is named."""
    dataset, place = atlases[preset], PLACE[preset]
    assert (dataset.ending.values[place], dataset.stability.values[place]) == (ENDINGS["bounded"], 1)
    corrupted = changed(dataset, place, **{variable: change(dataset[variable].values[place])})
    audited = audit(corrupted)
    names = flags(audited)
    assert names[place] == flag
    assert np.count_nonzero(names != "agrees") == 1
    found = findings(audited)
    assert not found.passed
    where = {name: float(dataset[name][i]) for name, i in zip(dataset.ending.dims, place, strict=True)}
    assert found.named == [(flag, where)]
    text = audit_text(found)
    assert f"1 {flag.replace('_', ' ')}" in text
    assert f"tilt {np.degrees(where['tilt']):.10g} deg" in text
    assert text.endswith("NOT verified: 1 of 1200 cells disagree, 0 are not computed")


def test_a_corrupted_roll_rate_of_circling_is_caught(atlases):
    """The steady roll rate, computed for each cell, is held against the formula."""
    corrupted = changed(
        atlases["circling"], (3, 4), roll_rate=float(atlases["circling"].roll_rate[3, 4]) + 1e-6
    )
    assert list(zip(*np.nonzero(flags(audit(corrupted)) == "contradictory"), strict=True)) == [(3, 4)]


@pytest.mark.parametrize("variable", ["tilt_min", "tilt_max", "nutation_period", "ending", "stability"])
def test_a_corrupted_fall_is_caught(variable):
    """A fall shows fall_tilt and what came before, is unstable, and has no period."""
    dataset = sweep.run(SweepSpec(tilt="20deg,30deg", tilt_rate=-1.0))
    assert (dataset.ending == ENDINGS["fell"]).all()
    wrong = {"ending": ENDINGS["horizon"], "stability": 1, "nutation_period": 1.0}
    value = wrong.get(variable, float(dataset[variable][1]) + 1e-7)
    found = findings(audit(changed(dataset, 1, **{variable: value})))
    assert (found.disagreeing, found.agreeing) == (1, 1)
    assert found.named[0][1]["tilt"] == float(dataset.tilt[1])


def test_a_run_that_time_ended_beyond_the_exact_extremes_is_caught():
    """Time is no excuse for extremes that the motion never reaches, nor for a verdict before both ends are known."""
    dataset = sweep.run(coarse("rolling", duration=1.2))
    truth = audit(dataset)
    place = tuple(
        np.argwhere((dataset.ending.values == ENDINGS["horizon"]) & (truth.exact_stability.values == 1))[0]
    )
    exact = float(truth.exact_tilt_max.values[place])
    beyond = exact - float(dataset.tilt_max.values[place]) + 1e-7
    assert flags(audit(moved(dataset, place, high=beyond)))[place] == "extremes_differ"
    assert flags(audit(changed(dataset, place, stability=1)))[place] == "contradictory"


def test_cells_that_are_not_computed_do_not_pass(atlases):
    """An atlas that is computed in part does not pass, though nothing in it is wrong."""
    dataset = changed(atlases["rolling"], (slice(10), slice(None)), ending=0, stability=0)
    found = findings(audit(dataset))
    assert (found.missing, found.disagreeing, found.agreeing) == (300, 0, 900)
    assert not found.passed
    assert audit_text(found).endswith("NOT verified: 0 of 1200 cells disagree, 300 are not computed")


def test_at_most_five_wrong_cells_are_named(atlases):
    """The first five cells are named, the number of the others is told."""
    dataset = changed(atlases["rolling"], (slice(2), slice(4)), stability=0)
    text = audit_text(findings(audit(dataset)))
    assert text.count("\nwrong ") == 5
    assert "and 3 more" in text


def wrong_equation(spec, coefficient):
    """Return an atlas of a spec as someone makes it who has another coefficient in the equation of the tilt."""
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


@pytest.mark.parametrize(("coefficient", "agree"), [(1.0, True), (1.001, False)])
def test_an_atlas_made_with_a_wrong_equation_is_caught(coefficient, agree):
    """A gyroscopic term that is 0.1 % too large is caught in every cell; with the right one SciPy's atlas is right."""
    spec = SweepSpec(tilt="5deg,10deg", roll_rate="2.7:4:3", tilt_rate=0.2, tolerance=1e-5)
    found = findings(audit(wrong_equation(spec, coefficient)))
    assert (found.agreeing, found.disagreeing) == ((6, 0) if agree else (0, 6))
    assert found.counts["extremes_differ"] == found.disagreeing


def test_an_atlas_made_with_another_constant_is_caught(atlases):
    """An atlas whose spec and coordinate claim alpha = 0.5 but that was made with 0.501 disagrees all over."""
    made = sweep.run(coarse("rolling", alpha=0.501))
    claimed = made.assign_attrs(sweep_spec=atlases["rolling"].attrs["sweep_spec"]).assign_coords(alpha=0.5)
    found = findings(audit(claimed))
    # released from 1e-5 rad far above the critical rate the disk hardly moves, whatever its alpha
    assert found.counts["extremes_differ"] > 900
    assert not found.passed


# --- near a verdict's or an ending's edge ---------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [-3e-9, 0.0, 3e-9])
def test_a_criterion_on_a_cell_s_reach(atlases, offset):
    """With the limit within the tolerance of a reach either verdict is right; one that differs is marginal."""
    exact = audit(atlases["rolling"])
    place = (10, 20)
    limit = Criterion("departure", float(exact.exact_tilt_max.values[place]) + offset)
    dataset = sweep.reclassify(atlases["rolling"], limit)
    for shift in (-6e-9, 6e-9):
        audited = audit(moved(dataset, place, high=shift))
        stored = 2 if shift > offset else 1
        agrees = stored == audited.exact_stability.values[place]
        assert flags(audited)[place] == ("agrees" if agrees else "marginal")
        assert findings(audited).passed
    # a verdict that does not follow from its own extremes is wrong there, too
    flipped = changed(dataset, place, stability=3 - dataset.stability.values[place])
    assert flags(audit(moved(flipped, place, high=2e-9)))[place] in ("agrees", "marginal")
    assert (
        flags(audit(changed(moved(dataset, place, high=6e-9), place, stability=1)))[place] == "contradictory"
    )


@pytest.mark.parametrize("kick", [{"tilt_rate": 0.1}, {"tilt_rate": -0.1}, {"tilt": 0.01}])
def test_a_fall_tilt_on_a_peak(kick):
    """With fall_tilt within the tolerance of a peak either ending is right, though a fall shows but one side."""
    words = {"precession_rate": 3.5, **kick}
    peak = float(referee.extremes(referee.starts(**words)).peak[0])
    grazing, clear = {-3e-9: "fell", 3e-9: "bounded"}, {}
    for offset, ending in grazing.items():
        spec = SweepSpec(**words, fall_tilt=peak + offset)
        clear[ending] = sweep.run(spec)
        assert clear[ending].ending == ENDINGS[ending]
        assert counts(clear[ending]) == {"agrees": 1}
    # each with the other's fall_tilt: the atlas and the reduction then say different things of one motion
    bounded, fell = clear["bounded"], clear["fell"]
    below = {
        "tilt_min": max(float(bounded.tilt_min), -peak + 6e-9),
        "tilt_max": min(float(bounded.tilt_max), peak - 6e-9),
    }
    below["peak_tilt"] = max(map(abs, below.values()))
    below["amplification"] = float(bounded.amplification) * below["peak_tilt"] / float(bounded.peak_tilt)
    claims_to_turn = changed(bounded, (), **below).assign_attrs(sweep_spec=fell.attrs["sweep_spec"])
    assert counts(claims_to_turn) == {"marginal": 1}
    ends = {name: np.sign(float(fell[name])) * (peak + 3e-9) for name in ("tilt_min", "tilt_max")
            if abs(float(fell[name])) == peak - 3e-9}  # fmt: skip
    above = {**ends, "peak_tilt": peak + 3e-9}
    above["amplification"] = float(fell.amplification) * above["peak_tilt"] / float(fell.peak_tilt)
    claims_to_fall = changed(fell, (), **above).assign_attrs(sweep_spec=bounded.attrs["sweep_spec"])
    assert counts(claims_to_fall) == {"marginal": 1}
    # further from the peak it is no longer the same motion
    far = SweepSpec(**words, fall_tilt=peak + 1e-6)
    assert counts(claims_to_fall.assign_attrs(sweep_spec=far.canonical())).keys() <= {
        "extremes_differ",
        "ending_differs",
    }


# --- what cannot be verified ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("spoil", "rule", "given"),
    [
        (lambda d: d.drop_vars("tilt_min"), "an atlas has ending, stability, tilt_min", "missing: tilt_min"),
        (lambda d: d.drop_vars(["ending", "nutation_period"]), "an atlas has ending", "missing: ending, nutation"),
        (lambda d: d.assign(tilt_max=d.tilt_max.isel(tilt=0)), "dimensions are roll_rate, tilt", "others: tilt_max"),
        (lambda d: d.isel(tilt=0), "the dimensions of an atlas are the axes of its spec", "{'roll_rate': 40}"),
        (lambda d: d.assign_coords(tilt=d.tilt * (1.0 + 1e-9)), "coordinates of an atlas are", "other values of tilt"),
        (lambda d: d.assign_coords(alpha=0.6), "the coordinates of an atlas are those", "other values of alpha"),
        (lambda d: d.drop_vars("radius"), "the coordinates of an atlas are those", "other values of radius"),
        (lambda d: xr.Dataset({"ending": d.ending}), "an atlas has the attribute sweep_spec", "it is missing"),
    ],
)  # fmt: skip
def test_what_cannot_be_verified_is_refused(atlases, spoil, rule, given):
    """What is missing or does not belong together is said, not guessed."""
    with pytest.raises(RequestError) as refusal:
        audit(spoil(atlases["rolling"]))
    assert rule in refusal.value.rule
    assert given in refusal.value.given


def test_the_atlas_is_not_changed(atlases):
    """An audit reads."""
    before = atlases["circling"].copy(deep=True)
    audit(atlases["circling"])
    xr.testing.assert_identical(atlases["circling"], before)
