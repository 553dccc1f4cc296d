"""Bisected boundaries: each bracket holds the exact change of verdict and is as narrow as requested."""

import math

import numpy as np
import pytest
import referee

import sweep
from sweep.atlas import boundary
from sweep.atlas.boundary import Brackets, bisected
from sweep.model.disk.tables import PARAMETERS
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

ROLL = list(PARAMETERS).index("roll_rate")


def judged_by(rule, calls=None):
    """Replace the integration by a verdict that depends only on the roll rate."""

    def judged(spec, given):
        if calls is not None:
            calls.append(given["roll_rate"].size)
        return rule(given["roll_rate"]).astype(np.int8)

    return judged


def segments(near, far, near_verdict=UNSTABLE, far_verdict=STABLE):
    """Segments along the roll rate."""
    near, far = np.atleast_1d(np.asarray(near, float)), np.atleast_1d(np.asarray(far, float))
    values = {name: np.full(near.shape, 0.5) for name in PARAMETERS}
    along, codes = np.full(near.shape, ROLL), np.ones(near.shape, np.int8)
    return Brackets(values, along, near, far, near_verdict * codes, far_verdict * codes)


def test_every_bracket_holds_its_change(monkeypatch):
    """A thousand brackets, rising and falling, close to within 1e-9 around sqrt(2) in a single call."""
    calls = []
    monkeypatch.setattr(
        boundary, "judged", judged_by(lambda x: np.where(x < math.sqrt(2), UNSTABLE, STABLE), calls)
    )
    low, high = np.linspace(0.1, 1.4, 1000), np.linspace(1.5, 90.0, 1000)
    for given in (segments(low, high), segments(high, low, STABLE, UNSTABLE)):
        calls.clear()
        found = bisected(sweep.SweepSpec(), given, 1e-9)
        least, most = np.minimum(found.near, found.far), np.maximum(found.near, found.far)
        assert (most - least <= 1e-9).all()
        assert (least < math.sqrt(2)).all()
        assert (most >= math.sqrt(2)).all()
        assert len(calls) <= math.ceil(math.log2(90.0 / 1e-9))


def test_undecided_starts_stay_inside(monkeypatch):
    """An undecided stretch from 1 to 1.1 stays inside the bracket, which is only slightly wider."""

    def rule(x):
        return np.where(x < 1.0, UNSTABLE, np.where(x > 1.1, STABLE, UNDECIDED))

    monkeypatch.setattr(boundary, "judged", judged_by(rule))
    found = bisected(sweep.SweepSpec(), segments([0.0, 0.9, 0.99], [2.0, 7.0, 1.2]), 1e-6)
    assert (found.near < 1.0).all()
    assert (found.far > 1.1).all()
    assert found.near == pytest.approx(1.0, abs=3e-7)
    assert found.far == pytest.approx(1.1, abs=3e-7)


def test_no_width_is_too_small(monkeypatch):
    """A bisection to width 0 stops at neighboring floating-point numbers."""
    monkeypatch.setattr(boundary, "judged", judged_by(lambda x: np.where(x < math.pi, UNSTABLE, STABLE)))
    found = bisected(sweep.SweepSpec(), segments(1.0, 5.0), 1e-300)
    assert found.far[0] == math.pi
    assert found.near[0] == np.nextafter(math.pi, 0.0)


def rows(criterion):
    """Return a coarse atlas of rolling disks with a refined boundary."""
    return sweep.run(
        sweep.SweepSpec.preset("rolling").replace(
            roll_rate="2:4:9", tilt="0.001deg:0.5deg:12:log", criterion=criterion, boundary="refined:1e-9"
        )
    )


@pytest.mark.compiled
def test_the_exact_peak_passes_the_limit_inside_the_bracket():
    """At the two ends of every bracket, the peak tilt by independent quadrature is on either side of 5 deg."""
    atlas = rows("departure:5deg")
    middle, half = atlas["boundary_roll_rate"].values, atlas["boundary_roll_rate_halfwidth"].values
    assert np.isfinite(middle).all()
    # the bracket includes the estimated error of the extremes
    assert (half <= 1e-9).all()
    tilt = np.tile(atlas["tilt"].values, 2)
    rate = np.concatenate((middle - half, middle + half))
    exact = referee.extremes(referee.starts(tilt=tilt, roll_rate=rate))
    beyond = np.maximum(np.abs(exact.least), np.abs(exact.greatest)) > math.radians(5.0)
    assert beyond.tolist() == [True] * 12 + [False] * 12


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_a_bracket_is_no_narrower_than_what_is_known():
    """The exact boundary lies inside the bracket, even for a coarse integration and a tiny width."""
    for words in [
        {"roll_rate": "1:4:9", "tilt": "0.1deg:1.8deg:12"},
        {"precession_rate": "2:6:9", "tilt": "0.01deg:0.3deg:12:log"},
        {
            "precession_rate": "0.05:5:15",
            "tilt": "2deg:17deg:12",
            "roll_rate": "steady",
            "tilt_rate": 1e-4,
            "criterion": "amplification:10",
        },
        # only a fall counts as unstable here
        {
            "roll_rate": "1:4:9",
            "tilt": "20deg:30deg:12",
            "criterion": "amplification:10",
            "fall_tilt": "70deg",
        },
    ]:
        for tolerance in [1e-6, 1e-8, 1e-10]:
            spec = sweep.SweepSpec(**words, tolerance=tolerance)
            found = sweep.refine(sweep.run(spec), 1e-12)
            exact = sweep.refine(sweep.run(spec.replace(method="exact", tolerance=1e-12)), 1e-13)
            names = [
                name
                for name in found.data_vars
                if name.startswith("boundary_") and f"{name}_halfwidth" in found
            ]
            assert sum(int(found[name].notnull().sum()) for name in names) >= 8
            for name in names:
                off, half = np.abs(found[name] - exact[name]), found[f"{name}_halfwidth"]
                both = half + exact[f"{name}_halfwidth"]
                assert bool(((off <= both) | found[name].isnull()).all()), float((off / both).max())
                # and no wider than the tolerance of the tilts justifies: the tilts change by at least 0.05
                # rad per rad/s, and twice the stated error counts on each side
                assert float(half.max()) <= 2.0 * 2.0 * tolerance / 0.05 + 1e-9


@pytest.mark.compiled
def test_refining_a_finished_atlas_is_the_same_as_asking_for_it():
    """`refine` gives an atlas with a grid boundary the variables of `boundary = "refined"`, bit for bit."""
    whole = rows("departure:2deg")
    coarse = sweep.run(sweep.SweepSpec.from_canonical(whole.attrs["sweep_spec"]).replace(boundary="grid"))
    assert not [name for name in coarse.variables if name.startswith("curve_")]
    later = sweep.refine(coarse, 1e-9)
    assert set(later.variables) == set(whole.variables)
    assert all(later[name].equals(whole[name]) for name in whole.variables)
    assert later.attrs["sweep_fingerprint"] == whole.attrs["sweep_fingerprint"]
