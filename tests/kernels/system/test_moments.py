"""Moments of motions compared with closed forms and a fine scan: counts, first and last times, greatest values."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from system_passes import run

from kernels.system.lanes import LEGS
from kernels.system.moments import NUMBERS
from kernels.system.polynomials import ORDER
from kernels.system.roots import next_turn, write_slope

COUNTED, LEVEL, WHEN, WORTH = range(NUMBERS)

#: A sine of the time; its conditions need no accurate states.
WAVE = """
@system(duration="30", measures={
    "over": "value of cos(w*t + p) at first sin(w*t + p) > c",
    "late": "value of x at last sin(w*t + p) > c",
    "either": "count abs(sin(w*t + p)) > c",
    "within": "count abs(sin(w*t + p)) < c",
    "both": "count sin(w*t + p) > c and t > 10",
    "top": "value of x at max sin(w*t + p) - t/50",
    "mean": "mean sin(w*t + p)**2",
})
def wave(x=0.0, *, w=1.0, p=0.0, c=0.5, t):
    return 1 + 0*x + 0*w
"""


def moments_of(text, starts, **given):
    """Return the numbers of the moments of the last pass, shape (moments, 4, n), and all its rows."""
    endings, rows, _ = run(text, starts, **given)
    assert np.all(endings == 1)
    last = rows[-1]
    # one state and one integral: states, time, sizes, moments
    return last[5:].reshape(-1, NUMBERS, last.shape[1]), last


def crossings(w, p, c, duration):
    """Return the times in (0, duration] at which sin(w t + p) rises above c, in order."""
    whole = np.arange(-2, int(w * duration / 6) + 2)
    times = (np.arcsin(c) - p + 2.0 * np.pi * whole) / w
    return times[(times > 0.0) & (times <= duration)]


def test_counts_first_and_last_times(rng, count):
    """Of a sine, every crossing is counted, also of excursions far shorter than a step; times agree to 1e-12."""
    n = count(150, 3000)
    w, p = rng.uniform(0.3, 12.0, n), rng.uniform(-3.0, 3.0, n)
    # excursions down to a millionth of a radian
    c = rng.choice([-1.0, 1.0], n) * (1.0 - 10.0 ** rng.uniform(-12.0, 0.0, n))
    found, _ = moments_of(WAVE, {"w": w, "p": p, "c": np.abs(c)})
    for i in range(n):
        up, down = crossings(w[i], p[i], abs(c[i]), 30.0), crossings(w[i], p[i] + np.pi, abs(c[i]), 30.0)
        assert found[0, COUNTED, i] == min(up.size, 1), i
        assert found[1, COUNTED, i] == up.size, i
        assert found[2, COUNTED, i] == up.size + down.size, i
        assert found[4, COUNTED, i] == np.sum(up > 10.0) + (np.sin(w[i] * 10.0 + p[i]) > abs(c[i])), i
        if up.size:
            # a crossing of a shallow excursion is uncertain by the rounding of the sine over its slope
            slack = 1e-12 + 1e-15 / np.sqrt(1.0 - c[i] ** 2)
            assert found[0, WHEN, i] == pytest.approx(up[0], abs=slack)
            assert found[1, WHEN, i] == pytest.approx(up[-1], abs=slack)
            assert found[0, WORTH, i] == pytest.approx(np.cos(w[i] * up[0] + p[i]), abs=12.0 * slack)
            assert found[1, WORTH, i] == pytest.approx(up[-1], abs=slack)
        else:
            assert np.isnan(found[:2, WHEN:, i]).all()


def test_counts_of_chosen_steps(rng):
    """Steps that end at crossings, before or behind them by rounding, count each of them once."""
    for step in (0.25, 0.5, 1.0 / 3.0, 0.1):
        found, _ = moments_of(WAVE, {"w": np.full(8, np.pi), "p": np.zeros(8), "c": np.zeros(8)}, step=step)
        # the first crossing is at the start, which is none; the last one, at the end, is uncertain by rounding
        assert np.all((found[1, COUNTED] == 14.0) | (found[1, COUNTED] == 15.0))
        assert np.all(found[1, LEVEL] < 1e-13)
        shifted = rng.uniform(0.01, 0.3, 8)
        found, _ = moments_of(WAVE, {"w": np.full(8, np.pi), "p": shifted, "c": np.sin(shifted)}, step=step)
        # it starts at the limit, rising
        assert np.all(found[1, LEVEL] < 1e-13)
        assert np.all((found[1, COUNTED] == 14.0) | (found[1, COUNTED] == 15.0))


def test_a_greatest_value_and_the_second_one(rng):
    """The time of the greatest maximum is right to 1e-11, and the second maximum is known."""
    n = 200
    w, p = rng.uniform(0.5, 8.0, n), rng.uniform(-3.0, 3.0, n)
    found, _ = moments_of(WAVE, {"w": w, "p": p, "c": np.full(n, 0.5)})
    for i in range(n):
        # maxima where w cos(w t + p) = 1/50, the start, and the end
        turns = np.arccos(1.0 / (50.0 * w[i])) * -1.0 - p[i] + 2.0 * np.pi * np.arange(-2, 60)
        rises = np.cos(p[i]) * w[i] > 0.02, np.cos(30.0 * w[i] + p[i]) * w[i] > 0.02
        falls = (-turns - 2.0 * p[i]) / w[i]
        times = falls[(falls > 0.0) & (falls < 30.0)]
        times = np.concatenate([times, [] if rises[0] else [0.0], [30.0] if rises[1] else []])
        values = np.sin(w[i] * times + p[i]) - times / 50.0
        order = np.argsort(values)
        assert found[5, WHEN, i] == pytest.approx(times[order[-1]], abs=1e-11), i
        assert found[5, WORTH, i] == pytest.approx(times[order[-1]], abs=1e-11)
        assert found[5, LEVEL, i] == pytest.approx(values[order[-1]], abs=1e-13)
        assert found[5, COUNTED, i] == pytest.approx(values[order[-2]], abs=1e-13)


def test_an_integral(rng):
    """The integral of a squared sine agrees with its closed form to 1e-12."""
    w, p = rng.uniform(0.3, 12.0, 100), rng.uniform(-3.0, 3.0, 100)
    _, rows = moments_of(WAVE, {"w": w, "p": p})
    truth = 15.0 - (np.sin(2.0 * (30.0 * w + p)) - np.sin(2.0 * p)) / (4.0 * w)
    assert np.abs(rows[1] - truth).max() < 1e-11


def test_the_turning_points_of_a_polynomial(rng, count):
    """All turning points are visited in order, with the direction before them; NumPy is the referee."""
    compared = 0
    for _ in range(count(300, 3000)):
        roots = np.sort(rng.uniform(-0.3, 1.3, rng.integers(1, ORDER)))
        polynomial = Polynomial.fromroots(roots).integ() * rng.normal()
        slope, inside = polynomial.deriv(), roots[(roots > 0.0) & (roots < 1.0)]
        # a turning point is uncertain by the rounding of the slope over the bend
        slack = 1e-12 + 1e-14 * np.sum(np.abs(slope.coef)) / np.abs(slope.deriv()(inside))
        if np.max(slack, initial=0.0) > 1e-10:
            continue
        memory = np.zeros(3 * (ORDER + 1))
        memory[: polynomial.coef.size] = polynomial.coef
        write_slope(0, 2 * (ORDER + 1), memory)
        ends = [0.0]
        while ends[-1] < 1.0:
            end, rises = next_turn(2 * (ORDER + 1), ends[-1], 1.0, ORDER + 1, memory)
            assert rises == (slope(0.5 * (ends[-1] + end)) > 0.0)
            ends.append(end)
        assert len(ends) == inside.size + 2
        assert np.all(np.abs(np.array(ends[1:-1]) - inside) <= slack)
        compared += 1
    assert compared > 100


def test_all_passes_begin_anew():
    """Every pass has the same counts as the last one."""
    _, rows, _ = run(WAVE, {"w": np.linspace(1.0, 5.0, 9)})
    counts = rows[:, 5::NUMBERS].reshape(len(LEGS), -1, 9)[:, :5]
    assert np.array_equal(counts, np.broadcast_to(counts[-1], counts.shape))
