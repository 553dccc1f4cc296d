"""Scalar motions from start to ending, through every hold, reversal and release."""

import math

import lossy_cells
import lossy_referee as referee
import numpy as np
import pytest
from lossy_follower import energy, energy_of, followed
from scipy.integrate import solve_ivp

from kernels.jit import kernel
from kernels.lossy_disk import endings, follow
from kernels.lossy_disk.arrays import ALPHA

MEASURES = (
    "tilt_min", "tilt_max", "heading_turned", "path_length", "rolling_loss", "pivoting_loss", "contour_loss",
    "damping_loss", "air_loss",
)  # fmt: skip

#: Reverses within a step of its release by pivoting friction; passes while almost at rest on its contact.
BRINKS = (
    referee.starts(
        tilt=0.635, tilt_rate=0.096, precession_rate=0.644, roll_rate=-1.137, contour_damping=1e-4,
        pivoting_friction=0.004837690319428873,
    ),
    referee.starts(
        tilt=-0.9258584323827086, tilt_rate=0.26161622908149307, precession_rate=-0.4070698106241398, alpha=0.62,
        contour_friction=1.3728713e-4, rolling_friction=0.0827888877, pivoting_friction=0.0047399391,
        contour_damping=0.0011455493511901334,
    ),
)  # fmt: skip


def differences(mine, found, cell):
    """Return the largest difference of all measures, relative above 1, and the relative one of the time."""
    largest = max(
        abs(mine.measures[name] - found.measures[name][cell]) / max(1.0, abs(mine.measures[name]))
        for name in MEASURES
    )
    time = found.end_time[cell]
    return largest, abs(mine.end_time - time) / time if time > 0.0 else abs(mine.end_time)


@pytest.mark.compiled
def test_endings_and_switches_are_those_of_the_referee():
    """For new random mixtures, endings, switches, times and all measures agree; doubtful cells are left out."""
    seed = np.random.SeedSequence().entropy
    compared, left_out, apart = 0, 0, []
    for air, given in lossy_cells.random_cells(75, np.random.default_rng(seed)).items():
        found = referee.run(given, air=air, duration=20.0)
        coarser = referee.run(given, air=air, duration=20.0, rtol=1e-11)
        for cell, start in enumerate(given.T):
            if (
                coarser.ending[cell] != found.ending[cell]
                or abs(coarser.end_time[cell] - found.end_time[cell]) > 1e-7 * found.end_time[cell]
            ):
                left_out += 1
                continue
            mine = followed(start, air=air, horizon=20.0, relative_step=0.015)
            assert mine.ending == found.ending[cell], (seed, air, cell)
            largest, time = differences(mine, found, cell)
            assert largest < 5e-6, (seed, air, cell)
            assert time < 1e-6, (seed, air, cell)
            apart += [(seed, air, cell)] if mine.switches != found.switches[cell] else []
            compared += 1
    # doubtful: an excursion on the brink of a hold, and a rate that comes from rounding
    assert len(apart) <= 3, apart
    assert compared > 10 * left_out


def test_motions_on_a_brink_are_followed():
    """A rate that reverses at once is held again; a contact that is almost at rest takes small steps."""
    for brink in [0, 1]:
        given = BRINKS[brink]
        found = referee.run(given, duration=200.0)
        for relative_step in (0.04, 0.02):
            mine = followed(given[:, 0], horizon=200.0, relative_step=relative_step)
            assert mine.ending == found.ending[0], brink
            assert abs(mine.switches - found.switches[0]) <= 4, brink
            assert mine.end_time == pytest.approx(found.end_time[0], rel=1e-6), brink


def test_energy_and_losses_balance_through_holds_reversals_and_releases():
    """With many switches, energy plus losses is constant to 1e-10, and the error is of fourth order."""
    given = lossy_cells.random_cells(120, np.random.default_rng(3), ("slow", "nearly upright", "tumbling"))[
        "none"
    ]
    switched = 0
    for start in given.T:
        found = followed(start, horizon=10.0, relative_step=0.005)
        switched += found.switches > 0
        whole = energy_of(start)
        assert abs(energy(found.state, start[ALPHA]) + found.lost - whole) < 1e-10 * max(1.0, whole)
    assert switched > 10


def test_a_hundred_reversals_keep_the_fourth_order():
    """For a disk whose roll rate changes sign a hundred times, the end converges with the fourth power of the step."""
    start = referee.starts(
        tilt=0.2,
        tilt_rate=0.1,
        precession_rate=2.2,
        roll_rate=0.05,
        contour_friction=1e-5,
        pivoting_friction=1e-5,
    )[:, 0]
    ends = {}
    for relative_step in (0.08, 0.04, 0.02, 0.005):
        found = followed(start, horizon=150.0, relative_step=relative_step)
        assert found.ending == endings.HORIZON
        assert found.switches >= 100
        ends[relative_step] = np.array([*found.state, found.lost, found.heading_turned])
    errors = [np.linalg.norm(ends[step] - ends[0.005]) for step in (0.08, 0.04, 0.02)]
    # part of the error is of fifth order
    assert 3.8 < np.log2(errors[0] / errors[1]) < 5.2
    assert 3.8 < np.log2(errors[1] / errors[2]) < 5.2


def test_while_contour_friction_holds_the_motion_is_holonomic():
    """While the contact point rests, the motion follows its own equation with constant angular momentum."""
    alpha, tilt, v = 0.62, 0.3, 0.15
    start = referee.starts(tilt=tilt, tilt_rate=-0.5, precession_rate=v, alpha=alpha, contour_friction=0.3)[
        :, 0
    ]

    def inertia(tilt):
        return (1 + alpha) * math.sin(tilt) ** 2 + alpha / 2 * math.cos(tilt) ** 2

    momentum = inertia(tilt) * v

    def slopes(_, y):
        turning = momentum / inertia(y[0])
        pull = math.sin(y[0]) * (1 + (1 + alpha / 2) * turning**2 * math.cos(y[0]))
        return y[1], pull / (1 + alpha / 2), turning

    exact = solve_ivp(slopes, (0, 1.2), (tilt, -0.5, 0.0), method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    found = followed(start, horizon=1.2, relative_step=0.01)
    assert found.senses.roll == 0.0
    assert found.path_length == 0.0
    np.testing.assert_allclose([found.end_tilt, found.state[2], found.heading_turned], exact, rtol=1e-9)
    assert found.state[3] == 0.0
    assert found.lost == 0.0


def test_upright_motions_slow_by_their_closed_forms():
    """Dry friction: s0 - c t/(1+alpha) and o0 - 2 c t/alpha; viscous: s0 exp(-k t/(1+alpha))."""
    for alpha in [0.5, 1.0]:
        for law in ("rolling_friction", "contour_friction"):
            start = referee.starts(roll_rate=1.0, alpha=alpha, **{law: 0.01})[:, 0]
            assert followed(start, horizon=50.0).state[3] == pytest.approx(
                1 - 0.01 * 50 / (1 + alpha), rel=1e-12
            ), alpha
            stopped = followed(start, horizon=1e3)
            assert stopped.ending == endings.REST, alpha
            assert stopped.end_time == pytest.approx((1 + alpha) / 0.01, rel=1e-12), alpha
            assert stopped.path_length == pytest.approx(0.5 * (1 + alpha) / 0.01, rel=1e-11), alpha
        start = referee.starts(roll_rate=1.0, alpha=alpha, contour_damping=0.01)[:, 0]
        assert followed(start, horizon=50.0, relative_step=0.01).state[3] == pytest.approx(
            math.exp(-0.5 / (1 + alpha)), rel=1e-12
        ), alpha
        start = referee.starts(precession_rate=1.0, alpha=alpha, pivoting_friction=1e-3)[:, 0]
        assert followed(start, horizon=50.0).state[4] == pytest.approx(1 - 2e-3 * 50 / alpha, rel=1e-13), (
            alpha
        )
        stopped = followed(start, horizon=1e3)
        assert stopped.ending == endings.REST, alpha
        assert stopped.end_time == pytest.approx(alpha / 2e-3, rel=1e-13), alpha


@pytest.mark.compiled
def test_mirror_images_agree_to_the_bit(rng):
    """Both reflections of a start give the same motion with changed signs, through all friction events."""
    mirrors = np.array([[-1, -1, 1, -1], [1, 1, -1, -1]])
    for air, given in lossy_cells.random_cells(45, rng).items():
        for start in given.T:
            found = followed(start, air=air, horizon=3.0)
            for signs in mirrors:
                image = start.copy()
                image[:4] *= signs
                other = followed(image, air=air, horizon=3.0)
                assert (other.ending, other.switches, other.steps) == (
                    found.ending,
                    found.switches,
                    found.steps,
                )
                tilt, turn = signs[0], signs[2]
                S, C, w, f, v = found.state
                assert other.state == (tilt * S, C, tilt * w, tilt * turn * f, turn * v)
                assert other.end_time == found.end_time
                assert other.lost == found.lost


def test_pieces_make_the_same_motion():
    """A motion that is interrupted and resumed continues to the same bit."""
    given = lossy_cells.random_cells(30, np.random.default_rng(8))["none"]
    several = 0
    for start in given.T:
        whole, pieces = followed(start, horizon=5.0), followed(start, horizon=5.0, piece=0.3)
        assert (pieces.state, pieces.ending, pieces.lost) == (whole.state, whole.ending, whole.lost)
        several += pieces.pieces > 1
    assert several > 5


def test_the_first_breach_is_found():
    """The time when the tilt first departs from the start by the limit agrees with the referee."""
    given = lossy_cells.random_cells(45, np.random.default_rng(4))["none"]
    found = referee.run(given, duration=5.0, limit=0.02, from_start=True)
    seen = 0
    for cell, start in enumerate(given.T):
        mine = followed(start, horizon=5.0, reach=0.02, relative_step=0.015)
        np.testing.assert_allclose(mine.breach_time, found.breach_time[cell], rtol=1e-6, atol=1e-9)
        assert mine.ending == found.ending[cell]
        seen += math.isfinite(mine.breach_time)
    assert seen > 5


@kernel
def _endless(switches, steps):
    return follow.endless(follow.Record(0.0, 0.0, 0.0, steps, switches))


def test_endless_switching_is_given_up():
    """Friction that switches more often than the motion steps is given up, but not a hundred reversals."""
    assert _endless(5000.0, 5000.0)
    assert not _endless(100.0, 150.0)
    assert not _endless(5000.0, 100000.0)
