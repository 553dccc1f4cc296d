import itertools
import math
from itertools import pairwise

import mpmath
import numpy as np
import pytest
import referee
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from sweep.atlas.boundary import theory_lines
from sweep.model.disk import theory
from sweep.model.disk.theory import carried_rates
from sweep.request.sources import Range
from sweep.request.spec import SweepSpec
from sweep.runs.in_memory import run

CRITICAL = {"roll_rate": 9.81 / 0.5 / 3.0, "precession_rate": 4.0 * 9.81 / 0.5 / 5.0}
RATES = list(CRITICAL)


def predicted(axis, **words):
    """Return the predicted boundary of an upright disk along a rate, as (rate / critical rate)^2."""
    spec = SweepSpec(**{axis: "1:8:3"}, **words)
    return (theory_lines(spec, axis)["upper"][1]) ** 2 / CRITICAL[axis]


def test_five_degrees_of_departure():
    """For vanishing perturbations it happens below r = 0.993457 (rolling) and 0.992617 (spinning)."""
    for axis, ratio in [("roll_rate", 0.993457), ("precession_rate", 0.992617)]:
        for perturbation in ({"tilt": 1e-9}, {"tilt_rate": 1e-6}):
            assert round(float(predicted(axis, **perturbation)), 6) == ratio, (axis, ratio)


def test_departure_bends_the_line_quadratically():
    """The boundary of a departure criterion approaches 1 - c limit^2 as the limit shrinks."""
    for alpha, axis, c in [
        (0.5, "roll_rate", 31 / 36),
        (1.0, "roll_rate", 5 / 6),
        (0.5, "precession_rate", 35 / 36),
        (1.0, "precession_rate", 11 / 12),
    ]:
        critical = theory_lines(SweepSpec(**{axis: "1:8:3"}, alpha=alpha, tilt=1e-13), axis)["upper"][0]
        for limit in (0.02, 0.01):
            spec = SweepSpec(**{axis: "1:8:3"}, alpha=alpha, tilt=1e-13, criterion=f"departure:{limit}rad")
            ratio = (theory_lines(spec, axis)["upper"][1] / critical) ** 2
            assert (1.0 - ratio) / limit**2 == pytest.approx(c, abs=3.0 * limit**2), (alpha, axis, c)


def test_amplification_in_linear_theory():
    """Kicked: r = 1 + 1/A^2; released rolling: 1 + 2/(A-1); released spinning: 1 + 4/(A-3)."""
    for limit, (axis, perturbation, excess) in itertools.product(
        [5.0, 10.0, 40.0],
        [
            ("roll_rate", {"tilt_rate": 1e-4}, lambda A: 1.0 / A**2),
            ("precession_rate", {"tilt_rate": 1e-4}, lambda A: 1.0 / A**2),
            ("roll_rate", {"tilt": 1e-5}, lambda A: 2.0 / (A - 1.0)),
            ("precession_rate", {"tilt": 1e-5}, lambda A: 4.0 / (A - 3.0)),
        ],
    ):
        ratio = predicted(axis, criterion=f"amplification:{limit}", **perturbation)
        # The remainder is of the order of the squared tilts, which reach at most 40 times 2.5e-5 rad.
        assert ratio == pytest.approx(1.0 + excess(limit), rel=1e-6), limit


def test_the_smallest_amplification_of_a_released_spinning_disk():
    """Released spinning disks reach at least three times their tilt; a smaller limit has no boundary."""
    assert np.isnan(predicted("precession_rate", tilt=1e-6, criterion="amplification:2.9"))


@pytest.mark.slow_lane
def test_the_predicted_rate_turns_the_disk_at_the_limit(pick):
    """The exact peak exceeds the limit 1e-8 below the predicted rate, but not 1e-8 above it."""
    starts = [{"tilt": 0.03}, {"tilt": -0.02}, {"tilt_rate": 0.05}, {"tilt": 0.01, "tilt_rate": -0.04}]
    for axis, start in pick(itertools.product(RATES, starts), 3):
        limit = 0.12
        spec = SweepSpec(**{axis: "1:8:3"}, criterion=f"departure:{limit}rad", **start)
        found = float(theory_lines(spec, axis)["upper"][1])

        peaks = referee.extremes(
            referee.starts(**{axis: found * np.array([1.0 - 1e-8, 1.0 + 1e-8])}, **start)
        ).peak
        assert peaks[0] > limit > peaks[1], (axis, start)


# Rates of 1e-160 underflow to zero when SciPy's error estimate squares them.
_RATE = st.floats(-5.0, 5.0).filter(lambda rate: rate == 0.0 or abs(rate) > 1e-6)


@pytest.mark.slow_lane
@given(*[st.floats(-1.45, 1.45)] * 2, _RATE, _RATE, st.floats(0.01, 1.0))
def test_carried_rates_solve_chaplygins_equations(start, tilt, s0, o0, alpha):
    """Power series and numerical integration give the same rates at any other tilt."""

    def slope(tilt, y):
        s, o = y
        return -o / (1.0 + alpha), -2.0 * s + o * math.tan(tilt)

    run = solve_ivp(slope, (start, tilt), (s0, o0), method="DOP853", rtol=1e-12, atol=1e-13)
    given = (np.array([number]) for number in (start, tilt, s0, o0, alpha))
    found = np.array(carried_rates(*given))[:, 0]
    size = (abs(s0) + abs(o0)) / math.cos(start) / math.cos(tilt)
    assert found == pytest.approx(run.y[:, -1], abs=1e-10 * (1.0 + size))


def test_carried_rates_are_hypergeometric():
    """From upright the two solutions are Gauss's hypergeometric functions of sin(tilt)^2, by mpmath."""
    for tilt in [1e-6, 0.1, 0.7, 1.2, 1.48]:
        alpha = 0.5
        a = mpmath.mpc(0.25, -0.5 * mpmath.sqrt(mpmath.mpf(13) / 12))
        u = mpmath.sin(tilt)
        even = float(mpmath.re(mpmath.hyp2f1(a, mpmath.conj(a), 0.5, u**2)))
        odd = float(mpmath.re(u * mpmath.hyp2f1(a + 0.5, mpmath.conj(a) + 0.5, 1.5, u**2)))
        one, zero = np.array([1.0]), np.array([0.0])
        carry = (zero, np.array([tilt]))
        assert carried_rates(*carry, one, zero, np.array([alpha]))[0][0] == pytest.approx(even, rel=1e-13), (
            tilt
        )
        slope = carried_rates(*carry, zero, -(1.0 + alpha) * one, np.array([alpha]))[0][0]
        assert slope == pytest.approx(odd, rel=1e-13), tilt


def test_no_line_where_theory_has_none():
    """A disk that rolls and spins has no predicted boundary; along a tilt none is sought."""
    spec = SweepSpec(roll_rate="2:4:3", precession_rate=1.0, tilt="0.01:0.02:2")
    assert theory_lines(spec, "roll_rate") == {}
    assert spec.model.controls(spec.axes) == ["roll_rate"]
    assert spec.model.controls(("tilt", "alpha", "radius")) == []


def sharp(preset, axis, tilts, count, **words):
    """Return a preset's atlas at a few tilts along a finely divided rate."""
    return run(SweepSpec.preset(preset).replace(**{"tilt": tilts, axis: count}, **words))


@pytest.mark.compiled
def test_the_measured_boundary_of_released_disks_is_the_predicted_one():
    """Over the preset's tilts the measured boundary is within its half-width of the predicted one."""
    for (preset, axis, rates), alpha in itertools.product(
        [("rolling", "roll_rate", "2:4:900"), ("spinning", "precession_rate", "3:6:900")], [0.5, 1.0]
    ):
        atlas = sharp(preset, axis, "0.001deg:4.9deg:25:log", rates, alpha=alpha)
        off = np.abs(atlas[f"boundary_{axis}"] - atlas[f"predicted_{axis}"])
        inside = np.isfinite(atlas[f"boundary_{axis}"])
        line = atlas[f"predicted_{axis}"]
        # A boundary is measured exactly where the predicted one is within the range of rates.
        assert np.array_equal(inside, (line > atlas[axis][0]) & (line < atlas[axis][-1])), (
            preset,
            axis,
            rates,
            alpha,
        )
        assert inside.sum() >= 15, (preset, axis, rates, alpha)
        assert (off <= atlas[f"boundary_{axis}_halfwidth"] * (1.0 + 1e-9))[inside].all(), (
            preset,
            axis,
            rates,
            alpha,
        )


@pytest.mark.compiled
def test_the_measured_boundary_of_circling_disks_is_the_predicted_one():
    """After a kick of 1e-6 rad/s both edges match k within half a cell plus 1e-5 of the rate."""
    atlas = sharp("circling", "precession_rate", "2deg:18deg:9", "0.05:5:1500", tilt_rate="1e-6rad/s")
    for edge in ("", "lower_"):
        measured, line = (atlas[f"{word}_{edge}precession_rate"] for word in ("boundary", "predicted"))
        halfwidth = atlas[f"boundary_{edge}precession_rate_halfwidth"]
        assert np.isfinite(measured).all()
        assert (np.abs(measured - line) <= halfwidth + 1e-5 * line).all()


@pytest.mark.compiled
def test_the_measured_boundary_converges_to_the_critical_rate():
    """As perturbation and limit shrink together, the measured boundary converges to the critical rate."""
    for preset, axis in [("rolling", "roll_rate"), ("spinning", "precession_rate")]:
        critical = math.sqrt(CRITICAL[axis])
        rates = f"{0.95 * critical!r}:{1.02 * critical!r}:1500"
        distances = []
        for limit in ("10deg", "5deg", "2deg"):
            atlas = sharp(preset, axis, "1e-4deg,2e-4deg", rates, criterion=f"departure:{limit}")
            distances.append(float(abs(atlas[f"boundary_{axis}"] - critical).max()))
        assert all(after < 0.4 * before for before, after in pairwise(distances)), (preset, axis)
        assert distances[-1] < 1e-3 * critical, (preset, axis)


def test_edges_on_a_negative_axis_are_mirrored():
    """The motion is symmetric under a sign change of its rates: upper and lower edge swap places and sign."""
    for preset in ["rolling", "spinning", "circling"]:
        spec = SweepSpec.preset(preset)
        axis = next(name for name in spec.axes if name != "tilt")
        along = getattr(spec, axis)
        mirrored = spec.replace(**{axis: Range(-along.stop, -along.start, along.count)})
        lines, negative = theory_lines(spec, axis), theory_lines(mirrored, axis)
        other = {"upper": "lower", "lower": "upper"}
        assert set(negative) == {other[edge] for edge in lines}, preset
        for edge, (critical, predicted) in lines.items():
            assert np.array_equal(negative[other[edge]][0], -critical, equal_nan=True), preset
            assert np.array_equal(negative[other[edge]][1], -predicted, equal_nan=True), preset


def test_starts_beyond_the_limit_cost_nothing(monkeypatch):
    """The slow series of a steep tilt is not summed for a start that is already beyond the limit.

    The predicted rates are bit-identical whether computed in batches or one by one.
    """
    steepest = []
    legendre = theory._legendre

    def watched(u, alpha):
        steepest.append(float(np.max(np.abs(u), initial=0.0)))
        return legendre(u, alpha)

    monkeypatch.setattr(theory, "_legendre", watched)
    spec = SweepSpec.preset("rolling").replace(tilt="1deg,4deg,20deg,60deg", criterion="departure:5deg")
    rates = theory_lines(spec, "roll_rate")["upper"][1]
    assert np.isfinite(rates).tolist() == [True, True, False, False]
    assert max(steepest) <= np.sin(np.radians(5.0)) * (1.0 + 1e-12)
    monkeypatch.setattr(theory, "_AT_ONCE", 0)
    np.testing.assert_array_equal(theory_lines(spec, "roll_rate")["upper"][1], rates)
