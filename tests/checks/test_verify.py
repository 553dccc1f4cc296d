import lossy_runner
import numpy as np
import pytest
import referee
import xarray as xr
from auditing import ENDINGS, PRESETS, atlas, changed, coarse, counts, flags, moved
from disk_reduction import rates_to_maxima
from messages import assert_facts

import sweep
from sweep.checks.verify import findings, findings_of, verify
from sweep.commands.audit_report import audit_line, audit_text
from sweep.errors import RequestError
from sweep.model.disk.tables import PARAMETERS
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE
from sweep.request.criterion import Criterion
from sweep.request.spec import SweepSpec

pytestmark = pytest.mark.compiled


def place_of(worst):
    """Return the coordinates of the largest difference."""
    found = worst.isel(worst.argmax(...)).coords
    return {name: float(value) for name, value in found.items() if name in worst.dims}


def test_the_presets_agree():
    """Every cell of the RK4 presets agrees; none is marginal, unresolved or skipped."""
    for preset in PRESETS:
        audited = verify(atlas(preset))
        found, worst = findings(audited), audited.tilt_difference
        assert {name: count for name, count in found.counts.items() if count} == {"agrees": 1200}, preset
        assert found.named == [("agrees", place_of(worst))], preset
        assert found.passed, preset
        assert (found.cells, found.agreeing, found.disagreeing, found.missing) == (1200, 1200, 0, 0), preset
        assert 0.0 < found.extremes[0] < found.extremes[1] <= found.extremes[2] <= 1e-8, preset
        assert found.period_share < 0.5, preset


@pytest.mark.slow_lane
def test_the_exact_values_are_the_referee_s(pick):
    """The exact extremes in the audit agree with an independent quadrature to 1e-13 rad."""
    for preset in pick(PRESETS, 1):
        dataset = atlas(preset)
        audited = verify(dataset)
        given = [
            xr.broadcast(dataset[name], dataset.ending)[0].transpose(*dataset.ending.dims).values.ravel()
            for name in PARAMETERS
        ]
        truth = referee.extremes(np.array(given))
        assert np.abs(audited.exact_tilt_min.values.ravel() - truth.least).max() < 1e-13, preset
        assert np.abs(audited.exact_tilt_max.values.ravel() - truth.greatest).max() < 1e-13, preset
        difference = np.maximum(
            np.abs(dataset.tilt_min.values.ravel() - truth.least),
            np.abs(dataset.tilt_max.values.ravel() - truth.greatest),
        )
        assert np.abs(audited.tilt_difference.values.ravel() - difference).max() < 1e-13, preset


@pytest.mark.slow_lane
def test_all_kinds_of_atlases_agree():
    """Falls, steady motions, impossible starts, any axes and coarse tolerances agree or are counted separately."""
    for words, expected in [
        # falls and bounded motions in one atlas
        ({"tilt": "20deg", "roll_rate": "0:3:31"}, {"agrees": 31}),
        ({"tilt": "20deg", "roll_rate": "-3:3:7", "tilt_rate": "-1,0,1", "alpha": "0.3,1"}, {"agrees": 42}),
        # already fallen at the start
        ({"tilt": "-86deg,80deg,86deg"}, {"agrees": 3}),
        # at rest in equilibrium, undisturbed
        ({"tilt": 0, "roll_rate": "1:5:9"}, {"agrees": 9}),
        ({"tilt": "5deg:40deg:8", "precession_rate": "0.5:5:10", "roll_rate": "steady"}, {"agrees": 80}),
        # a tilted disk that does not precess has no steady roll rate
        (
            {"tilt": "10deg", "precession_rate": "-1:1:5", "roll_rate": "steady", "tilt_rate": 1e-3},
            {"agrees": 4, "invalid": 1},
        ),
        # computed steady precession rates, which a disk that does not roll lacks
        (
            {
                "tilt": "5deg,10deg",
                "precession_rate": "steady-slow",
                "roll_rate": "-6:6:5",
                "tilt_rate": 1e-3,
            },
            {"agrees": 8, "invalid": 2},
        ),
        # one cell, and three axes
        ({"tilt": "1deg", "roll_rate": 3}, {"agrees": 1}),
        ({"tilt": "1deg", "roll_rate": "2:4:5", "alpha": "0.1:1:4", "gravity": "1,9.81"}, {"agrees": 40}),
        # another tolerance and a given step
        ({"tilt": "0.1deg:40deg:9", "roll_rate": "1:5:9", "tolerance": 1e-4}, {"agrees": 81}),
        ({"tilt": "0.1deg:40deg:9", "roll_rate": "1:5:9", "step": 0.05}, {"agrees": 81}),
        # two steps between turning points, where the energy drift says nothing
        (
            {
                "tilt": "18.8437deg",
                "precession_rate": 0.04728708045015879,
                "roll_rate": "steady",
                "tilt_rate": 1e-4,
                "alpha": 0.6,
                "step": 0.1,
                "tolerance": 1e-9,
            },
            {"agrees": 1},
        ),
        # small swings of a long period, in steps almost as long
        (
            {
                "tilt": "0.25deg:30deg:9",
                "precession_rate": "0.1:5:9",
                "roll_rate": "steady",
                "tilt_rate": 1e-4,
                "step": 0.1,
            },
            {"agrees": 81},
        ),
    ]:
        dataset = sweep.run(SweepSpec(**words))
        assert counts(dataset) == expected, (words, expected)
        assert findings(verify(dataset)).passed, (words, expected)
        assert verify(dataset).audit.dims == dataset.ending.dims, (words, expected)


@pytest.mark.slow_lane
def test_starts_with_losses_that_nothing_disturbs_have_no_numbers():
    """Undisturbed starts with losses have no numbers, and their comments say so; an atlas of them compares nothing."""
    spec = SweepSpec.read("rolling", contour_friction="0.1mm", tilt=0, roll_rate="2,3", duration=1)
    with lossy_runner.general_kernels():
        made = sweep.run(spec)
        found = findings_of(made)
    numbers = [name for name in spec.model.measures if "undisturbed" in made[name].attrs.get("comment", "")]
    assert len(numbers) >= 10
    assert np.isnan([made[name].values for name in numbers]).all()
    # nothing is wrong, but nothing was compared with another computation either
    assert (found.wrong, found.disagreeing, found.compared, found.passed) == ([], 0, 0, False)
    assert "nan" not in audit_text(found, spec)


def test_a_run_that_time_ended_is_within():
    """If time ended a run, its extremes lie within the exact ones; such cells are counted separately and pass."""
    for preset in PRESETS:
        dataset = sweep.run(coarse(preset, duration=1.2))
        audited = verify(dataset)
        found = findings(audited)
        horizon = int((dataset.ending == ENDINGS["horizon"]).sum())
        assert 200 <= horizon == found.counts["within"], preset
        assert found.agreeing == 1200, preset
        assert found.passed, preset
        if horizon < 1200:
            assert found.named == [("agrees", place_of(audited.tilt_difference))], preset
        # the extremes do not include cells that time ended
        assert np.isnan(found.extremes[0]) if horizon == 1200 else 0.0 < found.extremes[2] < 1e-8, preset


def test_exact_atlases_agree():
    """An atlas by the exact reduction agrees with it to the last bit."""
    for preset in PRESETS:
        found = findings(verify(sweep.run(coarse(preset, method="exact"))))
        assert found.agreeing == 1200
        assert found.extremes == (0.0, 0.0, 0.0)


def test_unresolved_cells_are_counted_apart():
    """Cells that the atlas or the reduction cannot resolve are counted, but not as wrong."""
    lost = sweep.run(SweepSpec(tilt="1deg,2deg,3deg", step=1e5, duration=1e6))
    assert counts(lost) == {"unresolved_in_the_atlas": 3}
    # a push with just enough energy for the saddle of its potential: rounding decides whether it passes
    words = {"tilt": "20deg", "roll_rate": 1.0}
    push = -float(rates_to_maxima(referee.starts(tilt=np.radians(20.0), roll_rate=1.0))[0])
    saddle = sweep.run(SweepSpec(**words, tilt_rate=[push, 0.5 * push], duration=0.05))
    assert counts(saddle) == {"unresolved_by_the_reduction": 1, "within": 1}
    assert findings(verify(saddle)).passed
    # nothing could be compared
    found = findings(verify(lost))
    assert (found.passed, found.compared, found.cells) == (False, 0, 3)
    assert_facts(audit_line(found), "NOT verified", "3 cells", "none")


def test_a_criterion_on_a_cell_s_reach():
    """If the limit is within the tolerance of the reach, either verdict is right; a different one is marginal."""
    for offset in [-3e-9, 0.0, 3e-9]:
        exact = verify(atlas("rolling"))
        place = (10, 20)
        limit = Criterion("departure", float(exact.exact_tilt_max.values[place]) + offset)
        dataset = sweep.reclassify(atlas("rolling"), limit)
        for shift in (-6e-9, 6e-9):
            audited = verify(moved(dataset, place, high=shift))
            stored = 2 if shift > offset else 1
            agrees = stored == audited.exact_stability.values[place]
            assert flags(audited)[place] == ("agrees" if agrees else "marginal"), offset
            assert findings(audited).disagreeing == 0, offset
        # even there, a verdict that contradicts the stored extremes is wrong
        flipped = changed(dataset, place, stability=3 - dataset.stability.values[place])
        assert flags(verify(moved(flipped, place, high=2e-9)))[place] in ("agrees", "marginal"), offset
        assert (
            flags(verify(changed(moved(dataset, place, high=6e-9), place, stability=1)))[place]
            == "contradictory"
        ), offset


@pytest.mark.slow_lane
def test_a_fall_tilt_on_a_peak():
    """If fall_tilt is within the tolerance of a peak, either ending is right, although a fall shows only one side."""
    for kick in [{"tilt_rate": 0.1}, {"tilt_rate": -0.1}, {"tilt": 0.01}]:
        words = {"precession_rate": 3.5, **kick}
        peak = float(referee.extremes(referee.starts(**words)).peak[0])
        grazing, clear = {-3e-9: "fell", 3e-9: "bounded"}, {}
        for offset, ending in grazing.items():
            spec = SweepSpec(**words, fall_tilt=peak + offset)
            clear[ending] = sweep.run(spec)
            assert clear[ending].ending == ENDINGS[ending], kick
            assert counts(clear[ending]) == {"agrees": 1}, kick
        # with the fall_tilt swapped, the atlas and the reduction disagree about the same motion
        bounded, fell = clear["bounded"], clear["fell"]
        below = {
            "tilt_min": max(float(bounded.tilt_min), -peak + 6e-9),
            "tilt_max": min(float(bounded.tilt_max), peak - 6e-9),
        }
        below["peak_tilt"] = max(map(abs, below.values()))
        below["amplification"] = float(bounded.amplification) * below["peak_tilt"] / float(bounded.peak_tilt)
        elsewhere = {"kernel_hash": "0" * 64}
        claims_to_turn = changed(bounded, (), **below).assign_attrs(
            sweep_spec=fell.attrs["sweep_spec"], **elsewhere
        )
        assert counts(claims_to_turn) == {"marginal": 1}, kick
        ends = {name: np.sign(float(fell[name])) * (peak + 3e-9) for name in ("tilt_min", "tilt_max")
                if abs(float(fell[name])) == peak - 3e-9}  # fmt: skip
        above = {**ends, "peak_tilt": peak + 3e-9}
        above["amplification"] = float(fell.amplification) * above["peak_tilt"] / float(fell.peak_tilt)
        claims_to_fall = changed(fell, (), **above).assign_attrs(
            sweep_spec=bounded.attrs["sweep_spec"], **elsewhere
        )
        assert counts(claims_to_fall) == {"marginal": 1}, kick
        # further from the peak, it is no longer the same motion
        far = SweepSpec(**words, fall_tilt=peak + 1e-6)
        assert counts(claims_to_fall.assign_attrs(sweep_spec=far.canonical())).keys() <= {
            "extremes_differ",
            "ending_differs",
        }, kick


def test_what_cannot_be_verified_is_refused():
    """Missing or inconsistent parts are refused by name."""
    for spoil, named in [
        (lambda d: d.drop_vars("tilt_min"), {"tilt_min"}),
        (lambda d: d.drop_vars(["ending", "nutation_period"]), {"ending"}),
        (lambda d: d.assign(tilt_max=d.tilt_max.isel(tilt=0)), {"roll_rate, tilt", "tilt_max"}),
        (lambda d: d.isel(tilt=0, drop=True), {"coordinate tilt"}),
        (lambda d: d.assign_coords(radius=("tilt", d.tilt.values)), {"coordinate radius"}),
        (lambda d: xr.Dataset({"ending": d.ending}), {"sweep_spec"}),
    ]:
        with pytest.raises(RequestError) as refusal:
            verify(spoil(atlas("rolling")))
        for each in named:
            assert each in refusal.value.message, spoil
        assert refusal.value.hint, spoil


def test_the_atlas_is_not_changed():
    """An audit does not change the atlas."""
    before = atlas("circling").copy(deep=True)
    verify(atlas("circling"))
    xr.testing.assert_identical(atlas("circling"), before)


def test_a_cell_on_the_limit_is_undecided_and_beside_its_error_may_have_either_verdict():
    """If the limit is within the tilt's error, the cell is undecided; at the error itself rounding decides."""
    atlas = sweep.run("rolling", roll_rate="2:4:9", tilt="0.5deg:5deg:7")
    tilt, error = float(atlas["tilt_max"][4, 3]), 2.0 * float(atlas["tilt_error"][4, 3]) + 2e-14
    for shift, right in (
        (0.0, {UNDECIDED}),
        (0.9 * error, {UNDECIDED}),
        (error, {UNDECIDED, STABLE}),
        (-error, {UNDECIDED, UNSTABLE}),
        (1.1 * error, {STABLE}),
        (-1.1 * error, {UNSTABLE}),
    ):
        judged = sweep.reclassify(atlas, f"departure:{tilt + shift!r}rad").copy(deep=True)
        assert int(judged["stability"][4, 3]) in right, shift
        for verdict in (UNDECIDED, STABLE, UNSTABLE):
            judged["stability"][4, 3] = verdict
            wrong = {each.name for each in findings_of(judged).statements if each.wrong}
            assert ("stability" in wrong) == (verdict not in right), (shift, verdict)
