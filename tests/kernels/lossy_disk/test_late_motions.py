"""Motions that linger near a maximum of their potential state the errors of time, tilt, heading and path."""

import audit_losses
import lossy_cells
import lossy_referee as referee
import lossy_runner
import numpy as np
import pytest

from kernels.lossy_disk import arrays
from kernels.lossy_disk.endings import FLAT, HORIZON
from sweep.model.quantity import PROMISED

pytestmark = pytest.mark.compiled

#: Measures and the measures that state their errors.
STATED = {
    "end_time": "time_error",
    "end_tilt": "tilt_error",
    "heading_turned": "heading_error",
    "path_length": "path_error",
}

RATES = ("tilt_rate", "precession_rate", "roll_rate")

#: Relative error of a time, and of a heading of about as many radians, without a lag.
NOT_LATE = 6.4e-7


def off(found, true, name):
    """Return the error of a measure."""
    return np.abs(getattr(found, name) - getattr(true, name))


def beyond(found, true, times=1.0):
    """Return True where any measure's error exceeds this multiple of its stated error."""
    return np.any(
        [off(found, true, name) > times * getattr(found, error) for name, error in STATED.items()], axis=0
    )


def less_lossy(n, rng):
    """Return random motions by air law, many of which pass maxima of their potential; few lose much."""
    kinds = ("nearly upright", "tumbling", "slow", "nutating")
    strengths = [arrays.PARAMETERS.index(name) for name in audit_losses.STRENGTHS]
    for air, given in lossy_cells.random_cells(n, rng, kinds).items():
        cells = given.shape[1]
        given[strengths] *= 10.0 ** rng.uniform(-4, 0, cells) * (rng.random(cells) < 0.7)
        yield air, lossy_cells.without(given, ("friction",))


def circle(tilt, turning, alpha):
    """Return the scaled roll rate of the steady circle with a tilt and precession rate, and if it is a maximum."""
    S, C, T = np.sin(tilt), np.cos(tilt), np.tan(tilt)
    o = turning * C
    # the tilt acceleration S + o q vanishes; o' = o T - 2 s and s' = -o/(1 + alpha) along the tilt
    q = -S / o
    s = (q + 0.5 * alpha * o * T) / (1.0 + alpha)
    do = o * T - 2.0 * s
    dq = -o - 0.5 * alpha * (do * T + o * (1.0 + T * T))
    return s - turning * S, C + do * q + o * dq > 0.0


def passing(n, rng):
    """Return starts that pass an unstable steady circle with little energy towards greater tilts."""
    chosen = []
    while len(chosen) < n:
        tilt, turning, alpha = rng.uniform(0.2, 1.0), rng.uniform(0.2, 1.5), rng.uniform(0.3, 1.0)
        rolling, unstable = circle(tilt, turning, alpha)
        if not unstable:
            continue
        # start from the circle towards smaller tilts, and reverse the motion
        away = referee.starts(
            tilt=tilt, tilt_rate=-(10.0 ** rng.uniform(-3.5, -2)), precession_rate=turning, roll_rate=rolling,
            alpha=alpha,
        )  # fmt: skip
        there = referee.run(away, duration=rng.uniform(8.0, 14.0), rtol=1e-13).state[:, 0]
        back = {name: -rate for name, rate in zip(RATES, there[1:], strict=True)}
        rubbing = 1e-9 * (rng.random() < 0.5)
        chosen.append(referee.starts(tilt=there[0], alpha=alpha, contour_friction=rubbing, **back))
    return np.concatenate(chosen, axis=1)


def test_motions_that_pass_an_unstable_circle_state_what_is_off_when_time_ends_them(rng):
    """For new starts, the stated errors hold against DOP853 at, near and some nutations after the circle."""
    given, late, wrong = passing(80, rng), 0, 0
    for duration in (5.0, 14.0, 60.0):
        found = lossy_runner.run(given, duration=duration)
        true = referee.run(given, duration=duration, flat_tilt=lossy_runner.FLAT_TILT, rtol=1e-13)
        # not lift-offs: a force that only just vanishes may do so a nutation later
        same = (found.ending == HORIZON) & (true.ending == HORIZON)
        assert same.mean() > 0.7
        wrong += beyond(found, true, PROMISED)[same].sum()
        late += (off(found, true, "path_length") > NOT_LATE * duration)[same].sum()
    # at most five of 1,400 that passed had errors of more than twice the stated ones
    assert wrong <= 3
    assert late > 0


def falling(n, rng):
    """Return slowly rolling starts that pass upright with little energy and fall straight on the other side."""
    alpha, tilt = rng.uniform(0.3, 1.0, n), rng.uniform(0.2, 0.8, n)
    left = 10.0 ** rng.uniform(-6.3, -3.0, n)
    rate = np.sqrt(2.0 * (1.0 - np.cos(tilt) + left) / (1.0 + 0.5 * alpha))
    return referee.starts(
        tilt=-tilt, tilt_rate=rate, roll_rate=rng.normal(0.0, 1e-4, n), alpha=alpha,
    )  # fmt: skip


def test_a_disk_that_passes_upright_slowly_is_flat_as_much_later_as_it_states(rng):
    """Stated errors of time and rolled angle hold for straight falls to 50 degrees, before any lift-off."""
    given = falling(200, rng)
    found, true = (
        lossy_runner.run(given, duration=100.0, flat_tilt=np.deg2rad(50.0)),
        referee.run(given, duration=100.0, flat_tilt=np.deg2rad(50.0), rtol=1e-13),
    )
    flat = (found.ending == FLAT) & (true.ending == FLAT) & (found.end_tilt > 0.0) & (true.end_tilt > 0.0)
    assert flat.mean() > 0.9
    for name, error in STATED.items():
        assert (off(found, true, name) <= getattr(found, error))[flat].all(), name
    late = off(found, true, "end_time") > NOT_LATE * found.end_time
    assert late[flat].sum() > 20


@pytest.mark.slow_lane
def test_fresh_motions_with_few_losses_state_what_is_off(rng, count):
    """Compared with a hundredth of the tolerance, at most three of 600 motions exceed their stated errors."""
    wrong, cells, drawn = 0, 0, count(25, 600)
    for air, given in less_lossy(drawn, rng):
        found, true = (lossy_runner.run(given, air=air, tolerance=each) for each in (1e-8, 1e-10))
        same = (found.ending == true.ending) & np.isfinite(found.end_time)
        wrong, cells = wrong + beyond(found, true)[same].sum(), cells + same.sum()
    assert cells > 0.9 * drawn
    assert wrong <= drawn // 200
