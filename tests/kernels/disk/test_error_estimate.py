"""The error of the lane kernel's extremes, compared with the exact turning points."""

import kernel_runner
import numpy as np
import pytest
import referee
from kernel_runner import coarse, errors

from kernels.disk.endings import BOUNDED, FELL, UNRESOLVED

compiled = pytest.mark.compiled


PRINTED = [
    ({"tilt_rate": 0.01, "roll_rate": 2.0}, -41.6082, 41.6082),
    ({"tilt_rate": 0.01, "roll_rate": 2.5}, -13.1205, 13.1205),
    ({"tilt_rate": 0.1, "precession_rate": 3.5}, -28.6591, 28.6591),
    ({"tilt": 0.01, "roll_rate": 3.0}, 0.5730, 3.5887),
    ({"tilt": 0.5, "precession_rate": 4.5}, 28.6479, 79.3831),
]


@pytest.mark.slow_lane
def test_the_printed_extremes():
    """Kernel and referee both give the printed extreme tilts of the report's disk."""
    for case in PRINTED:
        start, least, greatest = case
        given = referee.starts(**start)
        truth, found = referee.extremes(given), kernel_runner.run(given, tolerance=1e-6)
        for extremes in (truth, found):
            degrees = np.degrees([extremes.least[0], extremes.greatest[0]])
            assert list(np.round(degrees, 4)) == [least, greatest], case


@pytest.mark.slow_lane
@compiled
def test_the_accuracy_of_the_presets(pick):
    """Peak tilts are exact to 1e-8 rad in 99 % of the resolved cells and to 1e-6 in all; all falls are right."""
    for preset in pick(["rolling", "spinning", "circling"], 1):
        given = coarse(preset)
        truth, found = referee.extremes(given), kernel_runner.run(given)
        resolved = np.isin(found.ending, (BOUNDED, FELL))
        assert resolved.mean() > 0.99, preset
        assert list(found.ending[resolved] == FELL) == list(truth.fell[resolved]), preset
        peak = np.abs(found.peak - truth.peak)[resolved]
        assert np.mean(peak <= 1e-8) >= 0.99, preset
        assert errors(found, truth)[resolved].max() <= 1e-6, preset


@pytest.mark.slow_lane
@compiled
def test_the_accuracy_of_random_starts(crowd):
    """For random parameters, extremes are exact to 1e-8 rad in 99 % of the cells and to 1e-6 in all."""
    given, truth = crowd
    found = kernel_runner.run(given)
    assert list(found.ending == FELL) == list(truth.fell)
    assert set(found.ending) == {BOUNDED, FELL}
    wrong = errors(found, truth)
    assert np.mean(wrong <= 1e-8) >= 0.99
    assert wrong.max() <= 1e-6


@pytest.mark.slow_lane
@compiled
def test_the_error_estimate_is_honest(crowd):
    """The true error is at most twice the stated one, apart from the referee's 1e-12 rad."""
    for tolerance in [1e-10, 1e-8, 1e-6, 1e-4]:
        given, truth = crowd
        found = kernel_runner.run(given, tolerance=tolerance)
        assert (found.tilt_error <= tolerance).all(), tolerance
        assert (errors(found, truth) <= 2.0 * found.tilt_error + 1e-12).all(), tolerance


@compiled
def test_too_long_a_step_is_repaired_or_admitted(crowd):
    """For any requested step, a cell is refined until its extremes are right, or it is unresolved."""
    for step in [0.01, 0.1, 1.0, 100.0, 1e5]:
        given, truth = crowd
        found = kernel_runner.run(given, step=step, duration=1e4)
        assert np.isin(found.ending, (BOUNDED, FELL, UNRESOLVED)).all(), step
        resolved = found.ending != UNRESOLVED
        assert list(found.ending[resolved] == FELL) == list(truth.fell[resolved]), step
        assert (errors(found, truth)[resolved] <= 1e-7).all(), step
        assert found.refinements.max() == 6 if step >= 100.0 else (found.refinements > 0).any(), step


@compiled
def test_a_loose_tolerance_is_kept(crowd):
    """With the loosest tolerances, steps are as long as the time scale, and extremes are within the tolerance."""
    for tolerance in [0.01, 0.1]:
        given, truth = crowd
        found = kernel_runner.run(given, tolerance=tolerance)
        assert list(found.ending == FELL) == list(truth.fell), tolerance
        assert (errors(found, truth) <= tolerance).all(), tolerance


def test_a_long_step_is_refined():
    """A step of half the motion's time scale is refined to the result of the automatic step."""
    given = referee.starts(tilt=0.3, roll_rate=4.0)
    truth = referee.extremes(given)
    own, long = kernel_runner.run(given, tolerance=1e-5), kernel_runner.run(given, tolerance=1e-5, step=0.3)
    assert own.refinements[0] <= 1
    assert long.refinements[0] >= 1
    assert long.steps[0] > 5
    for found in (own, long):
        assert errors(found, truth)[0] <= 1e-5


@compiled
def test_a_faint_kick_off_the_summit_swings_to_both_sides():
    """However faint the kick, an unstable upright disk swings equally far to both sides."""
    kicks, rates = np.meshgrid(np.geomspace(1e-9, 1e-2, 15), np.linspace(2.0, 2.5, 30))
    found = kernel_runner.run(referee.starts(tilt_rate=kicks.ravel(), roll_rate=rates.ravel()))
    assert (found.ending == BOUNDED).all()
    assert list(found.greatest) == list(-found.least)
    # relative to the depth of the wells; up to 1e-6 rad/s the swing is the same as without a kick
    swings = found.greatest.reshape(kicks.shape)
    assert np.abs(swings[:, 0] - swings[:, 6]).max() <= 1e-7


@pytest.mark.slow_lane
@compiled
def test_what_lies_on_a_separatrix_is_admitted():
    """A motion that reaches the summit of its potential with energy of the size of rounding is unresolved or right."""
    given = referee.starts(tilt=0.3, tilt_rate=np.linspace(-1.45, -1.25, 2001), roll_rate=1.5)
    found, truth = kernel_runner.run(given), referee.extremes(given)
    resolved = found.ending != UNRESOLVED
    assert resolved.mean() > 0.99
    assert errors(found, truth)[resolved].max() <= 1e-6


@pytest.mark.slow_lane
@compiled
def test_fast_disks_next_to_upright_are_resolved():
    """The rounding of large rates is not mistaken for a lost tilt: a fast disk at 1e-6 rad is stable and exact."""
    tilts, rates = (
        part.ravel() for part in np.meshgrid(np.geomspace(1e-6, 1e-4, 30), np.linspace(10.0, 60.0, 30))
    )
    for name in ("roll_rate", "precession_rate"):
        given = referee.starts(tilt=tilts, **{name: rates})
        found = kernel_runner.run(given)
        assert set(found.ending) == {BOUNDED}
        assert errors(found, referee.extremes(given)).max() <= 1e-10


#: Scaled starts (tilt, tilt rate, precession rate, roll rate, alpha) whose energy drift understates their
#: error.
DECEPTIVE = np.array(
    [
        (0.07518, 5.533, 6.499, 0.05481, 0.3751),
        (-0.3772, 10.29, -5.355, -0.4276, 0.5194),
        (-0.624, 19.2, 2.484, -3.937, 0.4381),
        (0.3248, -59.51, -0.3627, -25.33, 0.4374),
        (0.9535, -104.8, 0.2626, 21.02, 0.7823),
        (-0.08602, 129.8, -98.28, 26.33, 0.2265),
        (1.388, 2.993, -21.45, 21.82, 0.87),
        (-1.267, 0.0, 23.07, 24.16, 0.92),
        (1.205, 0.0, 37.85, -39.89, 1.0),
    ]
).T

#: Others, so fast that their drift is hidden by rounding.
FASTER = np.array(
    [
        (0.0001118, -98.13, -13.84, -49.29, 0.56),
        (0.07987, -703.2, -743.3, -91.82, 0.13),
        (1.707e-07, -203.4, 2.501, 132.9, 0.25),
        (5.96e-08, 890.9, -9.944, -439.6, 1.0),
        (-0.1465, -704.7, -259.9, -284.0, 1.0),
    ]
).T
SCALED = ("tilt", "tilt_rate", "precession_rate", "roll_rate", "alpha")


@compiled
def test_fast_disks_that_sweep_through_large_tilts_are_within_the_tolerance():
    """The tolerance holds even if energy is conserved much better than the other constants of the motion."""
    given = referee.starts(**dict(zip(SCALED, DECEPTIVE, strict=True)), radius=1.0, gravity=1.0)
    found = kernel_runner.run(given)
    assert np.isin(found.ending, (BOUNDED, FELL)).all()
    assert errors(found, referee.extremes(given)).max() <= 1e-8


@compiled
def test_where_rounding_hides_the_error_a_disk_is_unresolved_rather_than_wrong():
    """No cell whose extremes are beyond the tolerance is reported as resolved."""
    given = referee.starts(**dict(zip(SCALED, FASTER, strict=True)), radius=1.0, gravity=1.0)
    found = kernel_runner.run(given)
    within = errors(found, referee.extremes(given)) <= 1e-8
    assert (within | (found.ending == UNRESOLVED)).all()


@compiled
def test_what_only_just_reaches_fall_tilt_is_doubted():
    """Of motions that turn 1e-6 rad before fall_tilt, few are called falls, even with a loose tolerance."""
    rng = np.random.default_rng(5)
    given = referee.starts(
        tilt=rng.uniform(-0.6, 0.6, 150), tilt_rate=rng.normal(0.0, 2.0, 150), roll_rate=rng.uniform(2.0, 6.0, 150),
        precession_rate=rng.normal(0.0, 2.0, 150),
    )  # fmt: skip
    truth = referee.extremes(given)
    turns = np.flatnonzero(~truth.fell & (truth.peak < 1.4))
    endings = [
        kernel_runner.run(given[:, [i]], fall_tilt=truth.peak[i] + 1e-6, tolerance=1e-3).ending[0]
        for i in turns
    ]
    assert len(endings) > 140
    assert endings.count(FELL) <= 2


@pytest.mark.slow_lane
@compiled
def test_a_uniform_step_states_its_error_near_flat(rng):
    """With a uniform step, the stated error grows like 1/cos(tilt) near flat, where the rates change fastest."""
    given = referee.starts(
        tilt=rng.uniform(1.3, 1.5, 400), tilt_rate=rng.normal(0.0, 2.0, 400),
        precession_rate=rng.uniform(3.0, 9.0, 400), roll_rate=rng.uniform(-6.0, 6.0, 400),
    )  # fmt: skip
    truth = referee.extremes(given, 1.565)
    found = kernel_runner.run(given, step=0.01, tolerance=1e-4, fall_tilt=1.565)
    turned = (found.ending == BOUNDED) & ~truth.fell
    assert turned.sum() > 200
    assert (errors(found, truth) <= 3.0 * found.tilt_error)[turned].all()
