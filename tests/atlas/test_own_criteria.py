"""Atlases by your own criterion: boundaries where it changes, no predicted line, functions in memory."""

import math

import numpy as np
import pytest
import referee
import xarray as xr
from messages import assert_facts, refused

import sweep
from sweep.atlas.boundary import theory_lines
from sweep.files.reading import open_atlas
from sweep.model.disk.model import Disk
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE
from sweep.runs.run import run_to_file

ROLLING = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:30", tilt="0.1deg:4deg:6:log")
FALLS = sweep.SweepSpec(tilt="58deg:70deg:9", roll_rate="0:3:31")
OWN = {
    "falls": FALLS.replace(criterion="fall_time < 0.25s"),
    "peak": ROLLING.replace(criterion="peak_tilt > 3*tilt or amplification > 1000"),
    "period": ROLLING.replace(criterion="nutation_period > 3s", boundary="refined:1e-6"),
    "wells": ROLLING.replace(method="exact", criterion="wells == two_wells and separatrix < 0.1"),
    "contact": ROLLING.replace(contact="yes", criterion="friction_needed > 0.2 or contact_state == lifts_off"),
    "steady": sweep.SweepSpec(
        tilt="5deg,10deg", precession_rate="steady-slow", roll_rate="-8:8:5", tilt_rate=1e-3,
        criterion="tilt_max > 1.01*tilt or abs(precession_rate) < 1rad/s",
    ),
    "cell": sweep.SweepSpec(tilt="1deg", roll_rate=3, criterion="ending == bounded"),
}  # fmt: skip


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Give all atlases of one spec the same date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")


def test_reclassified_is_as_if_run_with_it():
    """Reclassifying gives the bits and attributes of a new run, in both directions; only the request differs."""
    for spec in OWN.values():
        fresh, before = sweep.run(spec), sweep.run(spec.replace(criterion="departure:5deg"))
        assert len(np.unique(fresh.stability)) > (spec.size > 1)
        for given, wanted in ((before, fresh), (fresh, before)):
            found = sweep.reclassify(given, wanted.attrs["criterion"])
            found.attrs |= {name: wanted.attrs[name] for name in ("history", "requested_as")}
            xr.testing.assert_identical(found, wanted)


def test_without_falls_it_can_say_what_departure_says():
    """For upright disks, departure is peak tilt: an expression with peak tilt and falls gives the same boundary."""
    limited = sweep.run(
        ROLLING.replace(roll_rate="0.5:4:40", criterion="departure:5deg", boundary="refined:1e-7")
    )
    own = sweep.reclassify(limited, "peak_tilt > 5deg or ending == fell")
    assert set(np.unique(own.stability)) == {STABLE, UNSTABLE}
    xr.testing.assert_equal(own.stability, limited.stability)
    for name in ("boundary_roll_rate", "critical_roll_rate", "boundary_roll_rate_status"):
        np.testing.assert_allclose(own[name], limited[name], rtol=0.0, atol=2e-7)


def test_no_line_of_prediction_is_stored():
    """Theory predicts no boundary for it: the line is missing, the file says why, and the analytic line stays."""
    limited, own = sweep.run(ROLLING), sweep.run(OWN["peak"])
    assert limited.predicted_roll_rate.notnull().all()
    assert own.predicted_roll_rate.isnull().all()
    assert_facts(own.predicted_roll_rate.attrs["comment"], "missing", "theory")
    np.testing.assert_array_equal(own.critical_roll_rate, limited.critical_roll_rate)
    for critical, predicted in theory_lines(OWN["peak"], "roll_rate").values():
        assert np.isnan(predicted).all()
        assert np.isfinite(critical).all()


def test_what_a_model_predicts_is_left_out(monkeypatch):
    """A model's own predicted line is dropped, too."""
    ones = {"upper": (np.ones(6), np.ones(6))}
    monkeypatch.setattr(Disk, "lines", lambda self, spec, axis, starts: ones)
    for spec, known in ((ROLLING, True), (OWN["peak"], False)):
        critical, predicted = theory_lines(spec, "roll_rate")["upper"]
        assert np.isfinite(critical).all()
        assert np.isfinite(predicted).all() == known


def test_the_file_states_it(tmp_path):
    """The criterion is in the attributes of atlas and verdicts and in the spec; a run from the file is identical."""
    own = sweep.run(OWN["falls"])
    assert own.attrs["criterion"] == "fall_time < 0.25s"
    assert "unstable if fall_time < 0.25s;" in own.attrs["criterion_meaning"]
    assert "fall_time < 0.25s" in own.stability.attrs["comment"]
    assert "tilt_max" not in own.stability.attrs["comment"]
    sweep.save(own, tmp_path / "own.nc")
    run_to_file(OWN["falls"], tmp_path / "run.nc")
    with open_atlas(tmp_path / "own.nc") as one, open_atlas(tmp_path / "run.nc") as other:
        assert sweep.SweepSpec.from_canonical(one.attrs["sweep_spec"]) == OWN["falls"]
        xr.testing.assert_equal(one, other)
        assert one.stability.attrs["comment"] == other.stability.attrs["comment"]
        xr.testing.assert_equal(sweep.run(one.eulerdisk.spec), one)


@pytest.mark.compiled
def test_the_fall_takes_a_quarter_of_a_second_inside_the_bracket():
    """DOP853 falls before 0.25 s at one end of every bracket and later at the other."""
    atlas = sweep.refine(sweep.run(OWN["falls"]), 1e-6)
    middle, half = atlas.boundary_roll_rate.values, atlas.boundary_roll_rate_halfwidth.values
    known = np.flatnonzero(np.isfinite(middle))
    assert known.size >= 4
    for row in known:
        fast, slow = (
            referee.motion(referee.starts(tilt=atlas.tilt.values[row], roll_rate=rate)[:, 0], 5.0).fall_time
            for rate in (middle[row] - half[row], middle[row] + half[row])
        )
        assert fast < 0.25 < slow
        # a fall time is known to a relative 1e-6, and the bracket is no wider than that
        assert 4e-7 < slow - fast < 1e-6


@pytest.mark.compiled
def test_the_exact_period_crosses_inside_the_bracket():
    """Twice DOP853's time to the turning point is above 3 s at one end of a bracket and below it at the other."""
    atlas = sweep.run(OWN["period"])
    rows = np.flatnonzero(np.isfinite(atlas.boundary_roll_rate.values))
    assert rows.size >= 4
    for row in rows:
        middle, half = atlas.boundary_roll_rate.values[row], atlas.boundary_roll_rate_halfwidth.values[row]
        periods = []
        for rate in (middle - half, middle + half):
            start = referee.starts(tilt=atlas.tilt.values[row], roll_rate=rate)[:, 0]
            # released at rest: the next turning point is half a period away
            periods.append(2.0 * float(referee.motion(start, 5.0).turn_times[0]))
        assert periods[0] > 3.0 > periods[1]


def test_what_the_exact_reduction_is_asked_for():
    """The exact reduction computes the periods of a period boundary and agrees with RK4 within the tolerance."""
    spec = OWN["period"]
    names = ["boundary_roll_rate", "boundary_roll_rate_halfwidth"]
    (ours, half), (exact, width) = (
        (atlas[names[0]].values, atlas[names[1]].values)
        for atlas in (sweep.run(spec), sweep.run(spec.replace(method="exact")))
    )
    assert np.isfinite(exact).any()
    assert (np.isnan(ours) == np.isnan(exact)).all()
    assert (np.abs(ours - exact) <= half + width)[np.isfinite(ours)].all()


@pytest.mark.compiled
def test_a_bracket_is_no_narrower_than_what_is_known():
    """The boundary of the exact reduction lies inside the bracket of a coarse integration, however small the width."""
    for criterion in ["peak_tilt > 20*tilt", "amplification > 20", "nutation_period > 3s"]:
        spec = ROLLING.replace(criterion=criterion, tolerance=1e-6)
        found = sweep.refine(sweep.run(spec), 1e-12)
        exact = sweep.refine(sweep.run(spec.replace(method="exact", tolerance=1e-12)), 1e-13)
        apart = np.abs(found.boundary_roll_rate - exact.boundary_roll_rate).values
        known = np.isfinite(apart)
        assert known.sum() >= 3
        half, width = (atlas.boundary_roll_rate_halfwidth.values[known] for atlas in (found, exact))
        assert (apart[known] <= half + width).all()
        assert (half > 1e-11).all()


def test_an_atlas_without_a_variable_is_refused():
    """Reclassifying an atlas without the criterion's variable is refused; the message names the variable."""
    atlas = sweep.run(ROLLING)
    with refused("lacks nutation_period"):
        sweep.reclassify(atlas.drop_vars("nutation_period"), "nutation_period > 1s")
    with refused("friction_needed", "contact=yes"):
        sweep.reclassify(atlas, "friction_needed > 0.1")


# -- functions


def peaks(atlas):
    """Return True where the peak tilt is above 5 degrees."""
    return atlas.peak_tilt > math.radians(5)


@pytest.mark.parametrize(
    "function",
    [
        peaks,
        lambda atlas: peaks(atlas).values,
        lambda atlas: peaks(atlas).transpose(),
        lambda atlas: peaks(atlas).rename(None).drop_vars("alpha"),
    ],
    ids=["variable", "array", "transposed", "without names"],
)
def test_a_function_judges_in_memory(function):
    """A function's results are the verdicts, with a grid boundary, as for the equivalent expression."""
    spec = ROLLING.replace(roll_rate="0.5:4:40", duration=1.0)
    atlas = sweep.run(spec)
    found, same = sweep.reclassify(atlas, function), sweep.reclassify(atlas, "peak_tilt > 5deg")
    assert set(np.unique(found.stability)) == {STABLE, UNSTABLE, UNDECIDED}
    for name in same.data_vars:
        xr.testing.assert_equal(found[name], same[name])
    assert found.attrs["criterion"].startswith("function ")
    assert_facts(found.stability.attrs["comment"], "Python")
    assert_facts(found.attrs["history"], "memory")


def test_of_a_refined_atlas_a_function_judges_the_cells():
    """A function cannot judge between cells: a refined atlas gets a grid boundary and no curves."""
    found = sweep.run(ROLLING.replace(boundary="refined")).eulerdisk.reclassify(peaks)
    assert not [name for name in found.data_vars if name.startswith("curve_")]
    half = found.boundary_roll_rate_halfwidth
    assert (half.where(half.notnull(), 1.0) > 0.01).all()
    assert half.notnull().any()
    assert found.eulerdisk.spec.boundary == "grid"
    assert "function peaks" in repr(found.eulerdisk)


def test_what_a_function_judged_is_not_saved(tmp_path):
    """An atlas judged by a function cannot be saved; reclassifying it by an expression makes that possible."""
    found = sweep.reclassify(sweep.run(ROLLING), peaks)
    with refused("function peaks", "file"):
        sweep.save(found, tmp_path / "a.nc")
    assert not list(tmp_path.iterdir())
    with refused("function peaks", "memory"):
        sweep.refine(found, 1e-6)
    with refused("function peaks", "memory"):
        sweep.verify(found)
    sweep.save(sweep.reclassify(found, "peak_tilt > 5deg"), tmp_path / "a.nc")
    # a file written by other means is not accepted as an atlas
    found.to_netcdf(tmp_path / "b.nc", format="NETCDF4_CLASSIC", engine="netcdf4")
    with refused("function peaks", "memory"):
        open_atlas(tmp_path / "b.nc")


@pytest.mark.parametrize(
    ("function", "facts"),
    [
        (lambda atlas: None, ["NoneType"]),
        (lambda atlas: "peak_tilt", ["str"]),
        (lambda atlas: True, ["bool of shape ()"]),
        (lambda atlas: atlas.peak_tilt, ["float64"]),
        (lambda atlas: atlas.stability, ["int8"]),
        (lambda atlas: peaks(atlas).values[:, :2], ["bool of shape (30, 2)"]),
        (lambda atlas: peaks(atlas).values.T, ["bool of shape (6, 30)"]),
        (lambda atlas: peaks(atlas).isel(tilt=0), ["roll_rate"]),
        (lambda atlas: peaks(atlas).isel(tilt=slice(2)), ["cells"]),
        (lambda atlas: peaks(atlas).sortby("tilt", ascending=False), ["cells"]),
        (lambda atlas: peaks(atlas).values.tolist(), ["list"]),
        (lambda atlas: atlas, ["Dataset"]),
    ],
)
def test_a_function_returns_a_bool_for_each_cell(function, facts):
    """A function that does not return a bool for each cell is refused, with the required shape."""
    with refused(*facts) as caught:
        sweep.reclassify(sweep.run(ROLLING), function)
    assert "(30, 6)" in str(caught.value)
    assert caught.value.hint
