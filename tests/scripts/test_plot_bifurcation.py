"""Steady motions that share two constants, and the drift of the contact point, checked by other means."""

import numpy as np
import plot_bifurcation as bifurcation
import pytest
from matplotlib.path import Path as Outline
from scipy.integrate import solve_ivp

import sweep
from sweep.model.disk.theory import carried_rates

#: A disk with small constants lies nearly flat [rad].
_MOST = 1.5705


def test_the_fold_ends_in_the_critical_rates():
    """The fold in the plane of constants runs from critical rolling to critical spinning, its two cusps."""
    for alpha, rolling, spinning in [(0.5, 1 / 3, 4 / 5), (1.0, 1 / 4, 2 / 3)]:
        c1, c2 = bifurcation.fold(alpha)
        # The curve's smallest tilt is 1e-4 deg, so its ends are off by that to the power 4/3.
        assert [c1[0] ** 2, c2[0] ** 2] == pytest.approx([rolling, 0.0], abs=1e-7), (alpha, rolling, spinning)
        assert [c1[-1] ** 2, c2[-1] ** 2] == pytest.approx([0.0, spinning], abs=1e-7), (
            alpha,
            rolling,
            spinning,
        )


def standing(c1, c2, alpha):
    """Count steady motions for given constants: sign changes of the tilt acceleration, by SciPy."""
    grid = np.concatenate((-np.linspace(0.0, _MOST, 1501)[:0:-1], np.linspace(0.0, _MOST, 1501)))

    def slope(tilt, rates):
        return [-rates[1] / (1.0 + alpha), -2.0 * rates[0] + rates[1] * np.tan(tilt)]

    sides = []
    for way in (-1.0, 1.0):
        places = grid[grid * way >= 0.0][:: int(way)]
        found = solve_ivp(slope, (0.0, _MOST * way), [c1, c2], t_eval=places, rtol=1e-10, atol=1e-12)
        sides.append(found.y[:, :: int(way)])
    s, o = np.concatenate((sides[0][:, :-1], sides[1]), axis=1)
    p = o / np.cos(grid)
    force = np.sin(grid) + o * ((1.0 + alpha) * s - 0.5 * alpha * p * np.sin(grid))
    return int(np.count_nonzero(np.sign(force[1:]) != np.sign(force[:-1])))


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_three_steady_motions_inside_the_fold_one_outside():
    """Inside the fold there are two wells and three steady motions; outside there is one of each."""
    rng = np.random.default_rng(4)
    c1, c2 = rng.uniform(-0.7, 0.7, 40), rng.uniform(-1.0, 1.0, 40)
    x, y = bifurcation.fold(0.5)
    corners = np.stack((np.concatenate((np.abs(x), [0.0])), np.concatenate((y, [0.0]))), axis=1)
    inside = Outline(corners).contains_points(np.abs(np.stack((c1, c2), axis=1)))
    assert 8 < inside.sum() < 32
    for i in range(40):
        spec = sweep.SweepSpec(
            roll_rate=c1[i], precession_rate=c2[i], tilt_rate=1e-3, radius=1.0, gravity=1.0, method="exact"
        )
        assert int(sweep.run(spec).wells) == 1 + inside[i]
        assert standing(c1[i], c2[i], 0.5) == 1 + 2 * inside[i]


def test_branches_stand_still():
    """On both branches the equations of motion give no tilt acceleration; k > 0 on the stable ones."""
    for branch in bifurcation.branches(0.5, 0.3):
        some = slice(None, None, 7)
        tilt, c1 = branch.tilt[some], branch.c1[some]
        full = np.ones_like(tilt)
        s, o = carried_rates(0.0 * tilt, tilt, c1, 0.3 * full, 0.5 * full)
        p = o / np.cos(tilt)
        force = np.sin(tilt) + o * (1.5 * s - 0.25 * o * np.tan(tilt))
        assert np.abs(force).max() < 1e-9 * (1.0 + np.abs(o * s).max())
        f, sine = s - p * np.sin(tilt), np.sin(tilt)
        # From docs/theory.md, with alpha = 1/2 and R = g = 1.
        k = (-2.0 * np.cos(tilt) + 2.5 * p**2 + 7.0 * p * f * sine + 6.0 * f**2) / 2.5
        assert branch.stable[some].tolist() == (k > 0.0).tolist()


@pytest.mark.compiled
def test_drift_of_a_trapped_disk():
    """Heading and position after one nutation period match the equations of motion."""
    tilt, alpha, c1, c2 = np.radians([36.0, 44.0]), 0.5, 0.45, 0.03
    full = np.ones(2)
    s, o = carried_rates(0.0 * tilt, tilt, c1 * full, c2 * full, alpha * full)
    p = o / np.cos(tilt)
    f = s - p * np.sin(tilt)

    def slopes(_, x):
        theta, w, psi_rate, roll, psi = x[:5]
        S, C = np.sin(theta), np.cos(theta)
        up = (
            4.0 * S
            + (2.0 + alpha) * psi_rate**2 * np.sin(2.0 * theta)
            + 4.0 * (1.0 + alpha) * roll * psi_rate * C
        )
        spun = w * (2.0 * (1.0 + alpha) * roll * S - (2.0 + alpha) * psi_rate * C**2) / ((1.0 + alpha) * C)
        return [w, up / (2.0 * (2.0 + alpha)), -2.0 * roll * w / C, spun, psi_rate,
                -roll * np.sin(psi), roll * np.cos(psi)]  # fmt: skip

    for i in range(2):
        start = [tilt[i], 0.0, p[i], f[i], 0.0, 0.0, 0.0]
        done = solve_ivp(
            slopes, (0.0, 40.0), start, "DOP853", events=lambda _, x: x[1], rtol=1e-12, atol=1e-13
        )
        turns = done.t_events[0][done.t_events[0] > 0.1]
        period, end = turns[1], done.y_events[0][done.t_events[0] > 0.1][1]
        found = bifurcation.drift(tilt[i : i + 1], s[i : i + 1], o[i : i + 1], alpha, np.array([period]))
        assert found.turn[0] == pytest.approx(end[4], abs=1e-8)
        assert found.advance[0] == pytest.approx(np.hypot(end[5], end[6]), abs=1e-8)
        # For a rotation by the turn it is the chord of a circle.
        assert found.advance[0] == pytest.approx(2.0 * found.radius[0] * abs(np.sin(0.5 * end[4])), rel=1e-9)
