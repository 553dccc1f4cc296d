"""Atlases of the exact reduction."""

import numpy as np
import pytest
import referee
import xarray as xr
from auditing import ENDINGS, PRESETS, atlas, coarse
from disk_reduction import rates_to_maxima

import sweep
from sweep.figures import plots
from sweep.files.reading import open_atlas
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import PARAMETERS, REDUCTION, VARIABLES
from sweep.request.spec import SweepSpec
from sweep.runs.run import run_to_file

pytestmark = pytest.mark.compiled


def test_the_same_atlas():
    """Dimensions, coordinates, endings, verdicts and boundaries equal RK4's; extremes and periods almost."""
    for preset in PRESETS:
        exact, rk4 = sweep.run(coarse(preset, method="exact")), atlas(preset)
        assert exact.sizes == rk4.sizes, preset
        assert set(exact.data_vars) == {*rk4.data_vars, *REDUCTION}, preset
        for name in (
            *rk4.coords,
            "ending",
            "stability",
            *(each for each in rk4.data_vars if each not in VARIABLES),
        ):
            xr.testing.assert_equal(exact[name], rk4[name])
        for name in ("tilt_min", "tilt_max", "peak_tilt"):
            assert np.abs(exact[name] - rk4[name]).max() < 1e-8, preset
        # Near a separatrix the period is known less precisely.
        assert (np.abs(exact.nutation_period / rk4.nutation_period - 1.0) < 1e-5).mean() > 0.95, preset


def test_what_needs_a_history_is_missing():
    """There is no fall time, no drift and no steps; the attributes and the summary name the method."""
    exact = sweep.run(SweepSpec(tilt="20deg", roll_rate="0:3:11", method="exact"))
    assert set(np.unique(exact.ending)) == {ENDINGS["bounded"], ENDINGS["fell"]}
    for name in ("fall_time", "energy_drift"):
        assert np.isnan(exact[name]).all()
    for name in ("steps", "refinements"):
        assert (exact[name] == 0).all()
    assert np.array_equal(np.isfinite(exact.nutation_period), exact.ending == ENDINGS["bounded"])
    assert exact.attrs["method"] == "exact"
    assert exact.attrs["source"].endswith("method exact")
    assert "RK4" not in exact.attrs["summary"]


def test_time_never_ends_a_cell():
    """Verdicts hold for all time: no duration leaves a cell at its horizon."""
    for duration in [1e-3, 1.0, 300.0]:
        exact = sweep.run(coarse("rolling", method="exact", duration=duration))
        assert set(np.unique(exact.ending)) == {ENDINGS["bounded"]}, duration
        assert set(np.unique(exact.stability)) == {1, 2}, duration


@pytest.mark.slow_lane
def test_extremes_and_falls_of_random_starts(crowd):
    """Over all seven parameters, extremes and falls match an independent quadrature."""
    given, truth = crowd
    found = DISK.exact.measures(SweepSpec(), dict(zip(PARAMETERS, given, strict=True)))
    assert np.array_equal(found["ending"] == ENDINGS["fell"], truth.fell)
    assert np.abs(found["tilt_min"] - truth.least).max() < 1e-13
    assert np.abs(found["tilt_max"] - truth.greatest).max() < 1e-13


@pytest.mark.slow_lane
def test_every_start_near_flat_is_decided(rng):
    """RK4 resolves every start up to 89.9 degrees and beyond, with the reduction's endings and extremes."""
    for rates in (
        {"roll_rate": "wobble", "precession_rate": "uniform:2:400", "tilt_rate": "uniform:-10:10"},
        {
            "roll_rate": "uniform:-100:100",
            "precession_rate": "uniform:-100:100",
            "tilt_rate": "uniform:-30:30",
        },
        {"roll_rate": "uniform:-6:6", "precession_rate": "uniform:-10:10", "tilt_rate": 0},
    ):
        words = {"tilt": "uniform:85deg:89.89deg", "alpha": "uniform:0.05:1", "samples": 2000, "duration": 60}
        spec = SweepSpec(**rates, **words, fall_tilt="89.9deg", seed=int(rng.integers(2**31)))
        found, exact = sweep.run(spec), sweep.run(spec.replace(method="exact"))
        assert np.isin(found.ending, [ENDINGS["bounded"], ENDINGS["fell"]]).all(), rates
        assert np.array_equal(found.ending, exact.ending), rates
        for name in ("tilt_min", "tilt_max"):
            assert np.abs(found[name] - exact[name]).max() < 1e-8, rates
    steep = sweep.run(SweepSpec(method="exact", fall_tilt="89.999deg", tilt="1deg", roll_rate=[0.0, 1.0]))
    assert steep.ending.values.tolist() == [ENDINGS["fell"], ENDINGS["bounded"]]


def test_periods():
    """The period is the time between returns to a turning point in SciPy's integration."""
    for start in [
        {"tilt_rate": 0.01, "roll_rate": 2.0},
        {"tilt": 0.01, "roll_rate": 3.0},
        {"tilt": 0.5, "precession_rate": 4.5},
        {"tilt": -0.3, "tilt_rate": 0.4, "roll_rate": 4.0, "precession_rate": -2.0, "alpha": 0.9},
    ]:
        given = referee.starts(**start)
        period = DISK.exact.measures(SweepSpec(), dict(zip(PARAMETERS, given, strict=True)))[
            "nutation_period"
        ][0]
        assert np.isfinite(period), start
        times = referee.motion(given[:, 0], 6.0 * period).turn_times
        assert times.size >= 10, start
        assert np.allclose(times[2:] - times[:-2], period, rtol=1e-8), start


def test_wells_and_separatrix():
    """There are two wells below the critical rate, one above; only a kicked disk leaves its own well."""
    words = {"roll_rate": "2:3:11", "method": "exact"}
    released = sweep.run(SweepSpec(tilt="0.001deg", **words))
    critical = np.sqrt(9.81 / 0.5 / 3.0)
    assert np.array_equal(released.wells, np.where(released.roll_rate < critical, 2, 1))
    assert np.array_equal(released.separatrix > 0.0, released.roll_rate < critical)
    assert np.array_equal(np.isnan(released.separatrix), released.roll_rate > critical)
    kicked = sweep.run(SweepSpec(tilt_rate=0.01, **words))
    # The kick lifts the disk over the barrier by its own energy, (1 + alpha/2) w^2 / 2 over g/R.
    assert np.allclose(-kicked.separatrix[released.wells == 2], 0.5 * 1.25 * 1e-4 * 0.5 / 9.81, rtol=1e-12)
    assert (kicked.tilt_min < 0.0).all()


def test_unresolved_where_the_tolerance_asks_too_much():
    """A cell whose extremes are less certain than the tolerance is unresolved and has none."""
    start = {"tilt": "20deg", "roll_rate": 1.0}
    given = referee.starts(tilt=np.radians(20.0), roll_rate=1.0)
    push = -float(rates_to_maxima(given)[0]) * (1.0 - 1e-12)
    sure = sweep.run(SweepSpec(**start, tilt_rate=push, method="exact", tolerance=1e-2))
    vague = sweep.run(SweepSpec(**start, tilt_rate=push, method="exact", tolerance=1e-12))
    assert sure.ending == ENDINGS["bounded"]
    assert 1e-12 < float(sure.tilt_error) < 1e-2
    assert vague.ending == ENDINGS["unresolved"]
    assert vague.stability == 0
    for name in ("tilt_min", "tilt_max", "peak_tilt", "nutation_period", "tilt_error"):
        assert np.isnan(vague[name])
    assert vague.wells == 2


@pytest.mark.usefixtures("two_threads")
def test_bits_do_not_depend_on_threads_and_blocks():
    """Threads, block size and the number of alpha tables change no bit."""
    for alpha in [0.5, "0.01:1:140"]:
        spec = SweepSpec(alpha=alpha, tilt="-40deg:60deg:7", tilt_rate=0.3, roll_rate="0:4:5", method="exact")
        reference = sweep.run(spec)
        for how in ({"threads": 1}, {"block_cells": 900}, {"threads": 2, "block_cells": 1000}):
            xr.testing.assert_identical(
                sweep.run(spec, **how).drop_attrs(deep=False), reference.drop_attrs(deep=False)
            )


def test_the_file_is_the_dataset(tmp_path):
    """An exact atlas written block by block reads back equal to the result of `run`."""
    spec = SweepSpec(tilt="1deg:60deg:5", roll_rate="0:4:7", method="exact")
    run_to_file(spec, tmp_path / "a.nc", block_cells=6)
    with open_atlas(tmp_path / "a.nc") as read:
        xr.testing.assert_equal(read, sweep.run(spec))
        assert read.wells.attrs["flag_meanings"] == "unknown one_well two_wells"


@pytest.mark.slow_lane
def test_figures_name_the_method():
    """The legends of maps and profiles name the method of the boundary."""
    for method, word in [("rk4", "RK4"), ("exact", "exact")]:
        for words in ({"tilt": "1deg:4deg:5"}, {"tilt": "1deg"}):
            drawn = plots.figure([sweep.run(SweepSpec(roll_rate="2:4:9", method=method, **words))])
            told = [
                text.get_text()
                for axes in drawn.axes
                if axes.get_legend()
                for text in axes.get_legend().get_texts()
            ]
            assert any(f"{word} boundary" in each for each in told), (method, word)
