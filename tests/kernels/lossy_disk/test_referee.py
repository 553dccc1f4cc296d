"""The referee of the disk with losses is checked with Lagrange's form and regularized friction."""

import math

import lagrange
import lossy_cells
import lossy_motion as single
import lossy_referee as referee
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from kernels.lossy_disk.endings import HORIZON

pytestmark = pytest.mark.compiled


def forces(y, n, mode, par, hold_roll, hold_turn):
    """Return the generalized forces of all laws on tilt, roll and turn, as in the table of laws."""
    tilt, w, P, f = y[:4]
    C, v = math.cos(tilt), P + f * math.sin(tilt)
    size = math.hypot(w, C * f)
    roll = -n * (par[single.ROLLING] * C * C * f / size + par[single.CONTOUR] * mode[single.ROLL])
    roll -= (par[single.DAMPING] + par[single.MOFFATT] / C + par[single.BILDSTEN] * abs(f) ** 0.5) * f
    turn = -n * par[single.PIVOTING] * np.sign(v) * abs(mode[single.TURN])
    return -par[single.ROLLING] * n * w / size, roll + hold_roll, turn + hold_turn


def test_accelerations_and_forces_are_those_of_five_coordinates_with_multipliers(rng):
    """With every law sliding, or one rate held, accelerations, normal and horizontal forces agree."""
    for held in ["nothing", "roll", "turn"]:
        out = np.zeros(single.SIZE)
        for _ in range(200):
            par = np.array([rng.uniform(0.1, 1.0), *10.0 ** rng.uniform(-4, -1, 6), np.inf])
            y = np.zeros(single.SIZE)
            y[: single.PATH] = rng.uniform(-1.5, 1.5), *rng.normal(0, 2, 4)
            S, C = math.sin(y[0]), math.cos(y[0])
            if held == "roll":
                y[3] = 0.0
            if held == "turn":
                y[2] = -y[3] * S
            w, P, f = y[1:4]
            mode = np.sign([f, P + f * S if held != "turn" else 0.0, w])
            n, across, along, *holding = single.slopes(y, mode, par, out)
            push, roll, turn = forces(y, n, mode, par, *holding)
            q = np.array([0.0, 0.0, y[single.HEADING], y[0], 0.0])
            rates = np.array([*out[single.PLACE :], P, w, f])
            W = lagrange.constraint_matrix(q, 1.0)
            np.testing.assert_allclose(W @ rates, 0.0, atol=1e-14)
            saddle = np.zeros((7, 7))
            saddle[:5, :5], saddle[:5, 5:], saddle[5:, :5] = (
                lagrange.mass_matrix(q, par[0], 1.0, 1.0),
                -W.T,
                W,
            )
            right = np.array([0.0, 0.0, turn, push, roll + turn * S, 0.0, 0.0])
            right[:5] -= lagrange.velocity_forces(q, rates, par[0], 1.0, 1.0)
            right[:5] -= lagrange.potential_forces(q, 1.0, 1.0, 1.0)
            right[5:] -= lagrange.constraint_matrix_rate(q, rates) @ rates
            solved = np.linalg.solve(saddle, right)
            normal = 1.0 - solved[3] * S - w * w * C
            noise = 1e-14 * np.linalg.cond(saddle) * np.abs(solved).max()
            np.testing.assert_allclose(
                [*out[1:4], across, along, n], [*solved[[3, 2, 4, 5, 6]], normal], atol=noise
            )
            if held == "roll":
                assert out[3] == 0.0, held
            if held == "turn":
                assert abs(out[2] + S * out[3] + C * w * f) < noise, held


def regularised(start, duration, width):
    """Return the state after `duration`, with dry frictions smooth in their rates and constant beyond `width`."""
    par, _ = referee.coefficients(start, "none")
    alpha, rolling, pivoting, contour = par[:4]
    inertia = 1.0 + 0.5 * alpha

    def smooth(rate, *others):
        # replaces the sign of a rate, or the direction of several
        return rate / math.sqrt(rate * rate + sum(other * other for other in others) + width * width)

    def slope(_, y):
        tilt, w, P, f = y
        S, C = math.sin(tilt), math.cos(tilt)
        push = S + inertia * P * P * S * C + (1.0 + alpha) * f * P * C
        across, along = rolling * smooth(w, C * f), rolling * smooth(C * f, w)
        n = (1.0 - S * push / inertia - w * w * C) / (1.0 - S * across / inertia)
        turn = -pivoting * n * smooth(P + f * S)
        roll = -n * (along * C + contour * smooth(f))
        carried = [
            [(1.0 + alpha) * S * S + 0.5 * alpha * C * C, (1.0 + alpha) * S],
            [(1.0 + alpha) * S, 1.0 + alpha],
        ]
        gain = np.linalg.solve(carried, [turn, roll + turn * S])
        free = w * (2.0 * (1.0 + alpha) * f * S - (2.0 + alpha) * P * C * C) / ((1.0 + alpha) * C)
        return w, (push - n * across) / inertia, gain[0] - 2.0 * f * w / C, gain[1] + free

    return solve_ivp(slope, (0.0, duration), start[:4], "Radau", rtol=1e-9, atol=1e-11).y[:, -1]


#: Starts and durations in which friction holds, releases or reverses.
STICKING = {
    "upright spinning, roll held": ({"tilt": 0.01, "precession_rate": 2.0, "contour_friction": 0.02}, 5.0),
    "turning held in a wobble": (
        {"tilt": 1.3, "precession_rate": 2.6, "roll_rate": -2.5, "pivoting_friction": 0.03}, 8.0
    ),
    "lands on rolling friction": (
        {"tilt": 1e-3, "roll_rate": 0.05, "precession_rate": 0.2, "rolling_friction": 0.03, "pivoting_friction": 0.004},
        5.0,
    ),
    "breaks away, roll held": (
        {"tilt": 0.3, "precession_rate": 1.0, "rolling_friction": 0.05, "pivoting_friction": 0.1,
         "contour_friction": 0.1}, 2.0,
    ),
    "breaks away in both": (
        {"tilt": 0.3, "precession_rate": 1.0, "rolling_friction": 0.05, "pivoting_friction": 0.1,
         "contour_friction": 0.001}, 2.0,
    ),
    "breaks away by turning": (
        {"tilt": 0.01, "precession_rate": 0.1, "rolling_friction": 0.0102, "pivoting_friction": 0.5,
         "contour_friction": 0.001}, 2.0,
    ),
    "reverses": (
        {"tilt": 0.2, "precession_rate": 1.5, "roll_rate": 0.1, "contour_friction": 0.02, "pivoting_friction": 0.005},
        5.0,
    ),
}  # fmt: skip


@pytest.mark.slow_lane
def test_regularised_friction_tends_to_the_set_valued_one(pick):
    """The difference shrinks with the width; while friction holds, the creep rate is below the width."""
    for name in pick(STICKING, 1):
        parameters, duration = STICKING[name]
        start = referee.starts(**parameters)
        found = referee.run(start, duration=duration)
        assert found.ending[0] == HORIZON, name
        wide, narrow = (
            np.abs(regularised(start[:, 0], duration, width) - found.state[:, 0]).max()
            for width in (4e-4, 4e-5)
        )
        assert narrow < 2e-3, name
        assert narrow < 0.45 * wide, name


@pytest.mark.slow_lane
def test_energy_and_losses_are_constant_and_tolerances_agree(rng, count):
    """For random mixtures and all endings, the ledger closes, and tolerances 1e-13 and 1e-12 agree."""
    cells = lossy_cells.random_cells(count(9, 60), rng)
    for air, given in cells.items():
        found, finer = (referee.run(given, air=air, duration=200.0, rtol=rtol) for rtol in (1e-12, 1e-13))
        assert max(found.energy_imbalance.max(), finer.energy_imbalance.max()) < 1e-9
        same = np.abs(found.end_time - finer.end_time) <= 1e-7 * finer.end_time
        assert np.mean(same) > 0.9
        np.testing.assert_array_equal(found.ending[same], finer.ending[same])
