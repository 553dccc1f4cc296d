"""Frequencies and growth rates of steady motions, measured from trajectories, against linear theory."""

import itertools

import kernel_runner
import numpy as np
import pytest
import referee
from messages import refused
from steady_motions import measured_coefficients, with_coefficients

import sweep
from kernels.disk.steady import steady_precession_rates


def wandering(n, seed):
    """Return random steady motions for all tilts, precession signs and disks, with k by docs/theory.md."""
    rng = np.random.default_rng(seed)
    radius, gravity = 10.0 ** rng.uniform(-2.0, 1.0, n), 10.0 ** rng.uniform(-0.5, 1.5, n)
    tilt, alpha = np.radians(rng.uniform(-85.0, 85.0, n)), rng.uniform(0.02, 1.0, n)
    p = rng.uniform(0.05, 3.0, n) * rng.choice([-1.0, 1.0], n) * np.sqrt(gravity / radius)
    push = 4.0 * gravity * np.sin(tilt) + (2.0 + alpha) * radius * p**2 * np.sin(2.0 * tilt)
    f = -push / (4.0 * (1.0 + alpha) * radius * p * np.cos(tilt))
    pull = -2.0 * gravity / radius * np.cos(tilt) + (6.0 + 2.0 * alpha) * p * f * np.sin(tilt)
    k = (pull + (2.0 + alpha) * p**2 + 4.0 * (1.0 + alpha) * f**2) / (2.0 + alpha)
    given = referee.starts(
        tilt=tilt, precession_rate=p, roll_rate=f, alpha=alpha, radius=radius, gravity=gravity
    )
    return given, k


@pytest.mark.compiled
def test_growth_and_swing_of_ten_thousand_motions():
    """For 10^4 random steady motions the measured sqrt(|k|) matches theory within 1e-4, with its sign."""
    given, k = wandering(10_000, seed=11)
    found = measured_coefficients(given)
    assert (k < 0.0).sum() > 300
    assert (np.sign(found) == np.sign(k)).all()
    assert np.abs(np.sqrt(found / k) - 1.0).max() < 1e-4


@pytest.mark.compiled
def test_nutation_of_a_small_kick():
    """For a small kick the atlas's nutation period is 2 pi over sqrt(k), within 1e-4."""
    given, k = wandering(10_000, seed=12)
    given, k = given[:, k > 0.0], k[k > 0.0]
    given[1] = 1e-6 * np.sqrt(given[6] / given[5])
    found = kernel_runner.run(given, fall_tilt=np.radians(89.9))
    resolved = found.ending == 1
    assert resolved.mean() > 0.999
    assert np.abs(2.0 * np.pi / found.period[resolved] / np.sqrt(k[resolved]) - 1.0).max() < 1e-4


def test_both_precessions_keep_the_tilt():
    """For both steady precession rates the tilt acceleration vanishes; the slow rate is smaller."""
    for tilt, alpha in itertools.product([-70.0, -8.0, 0.3, 15.0, 60.0], [0.1, 0.5, 1.0]):
        tilt = np.radians(tilt)
        for roll in (-30.0, 30.0):
            slow, fast = steady_precession_rates(tilt, roll, alpha, 0.5, 9.81)
            assert abs(slow) < abs(fast), (tilt, alpha)
            assert np.sign(slow) == np.sign(fast) == -np.sign(roll * tilt), (tilt, alpha)
            for rate in (slow, fast):
                push = 4.0 * 9.81 * np.sin(tilt) + (2.0 + alpha) * 0.5 * rate**2 * np.sin(2.0 * tilt)
                turn = 4.0 * (1.0 + alpha) * 0.5 * roll * rate * np.cos(tilt)
                assert push + turn == pytest.approx(0.0, abs=1e-12 * abs(turn)), (tilt, alpha)


def test_no_precession_holds_a_slow_roll():
    """Below the fold, (1+alpha)^2 f^2 = 2 (2+alpha) (g/R) sin tan, no precession rate keeps the tilt."""
    tilt, alpha = np.radians(20.0), 0.5
    fold = np.sqrt(2.0 * 2.5 * 9.81 / 0.5 * np.sin(tilt) * np.tan(tilt)) / 1.5
    assert np.isnan(steady_precession_rates(tilt, 0.999 * fold, alpha, 0.5, 9.81)).all()
    slow, fast = steady_precession_rates(tilt, 1.000001 * fold, alpha, 0.5, 9.81)
    assert slow == pytest.approx(fast, rel=4e-3)


@pytest.mark.compiled
def test_an_atlas_of_a_branch():
    """It stores the slow branch's precession rates, is invalid where there are none, and agrees with k."""
    spec = sweep.SweepSpec(
        tilt="-30deg:30deg:14", roll_rate="-8:8:18", precession_rate="steady-slow", tilt_rate=1e-5,
        criterion="amplification:10",
    )  # fmt: skip
    atlas = with_coefficients(sweep.run(spec))
    k = atlas.stability_coefficient.values
    missing = np.isnan(atlas.precession_rate.values)
    assert np.array_equal(missing, atlas.ending.values == 6)
    assert 10 < missing.sum() < 100
    # A kick grows by Omega/sqrt(k) in a stable motion: tenfold where k = Omega^2/100.
    offset = 2.0 * 9.81 / 0.5 / 2.5 / 100.0
    assert (atlas.stability.values[k > 1.01 * offset] == 1).all()
    assert (atlas.stability.values[k < 0.0] == 2).all()
    swinging = k > offset
    frequency = atlas.nutation_frequency.values[swinging]
    assert frequency == pytest.approx(np.sqrt(k[swinging]), rel=1e-4)
    assert atlas.growth_rate.values[k < 0.0] == pytest.approx(np.sqrt(-k[k < 0.0]), rel=1e-4)


@pytest.mark.compiled
def test_an_atlas_of_upright_disks_is_refused():
    """Without a steady rate there is no coefficient; two steady rates are not a valid request."""
    with refused("steady"):
        with_coefficients(sweep.run(sweep.SweepSpec(roll_rate="2:3:2")))
    with refused("roll_rate=steady", "precession_rate=steady-fast"):
        sweep.SweepSpec(roll_rate="steady", precession_rate="steady-fast")
