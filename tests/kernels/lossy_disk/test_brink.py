"""A turning disk at the limit of rolling friction is on the brink, and its motion is not followed."""

import math

import lossy_referee as referee
import lossy_runner
import numpy as np
import pytest
from messages import refused

import sweep
from kernels.lossy_disk.dry_friction import is_held
from kernels.lossy_disk.endings import FLAT, HORIZON, LIFT_OFF, UNRESOLVED
from kernels.lossy_disk.loss_coefficients import Losses
from kernels.lossy_disk.rk4 import inertia
from sweep.errors import NoMotionError

pytestmark = pytest.mark.compiled


def holding_tilt(turning, alpha, rolling):
    """Return the tilt up to which friction holds a disk with this scaled turning rate, to the last bit."""
    losses, of_disk, low, high = Losses(0.0, 0.0, rolling, 0.0, 0.0, 0.0), inertia(alpha), 0.0, 0.5
    while low < 0.5 * (low + high) < high:
        tilt = 0.5 * (low + high)
        held = is_held(math.sin(tilt), math.cos(tilt), turning, 0.0, of_disk, losses)
        low, high = (tilt, high) if held else (low, tilt)
    return low


@pytest.mark.parametrize(("arm", "turning", "alpha"), [(0.2, 0.7, 0.5), (0.2, -2.5, 0.5), (0.05, 0.7, 1.0)])
def test_only_a_disk_on_the_brink_is_unresolved(arm, turning, alpha):
    """Below the limit the disk is held, an excess of 1e-5 is unresolved, and at 1e-3 the disk falls."""
    excess = np.array([-1e-5, 1e-12, 1e-9, 1e-5, 1e-3, 1e-2])
    expected = [HORIZON, UNRESOLVED, UNRESOLVED, UNRESOLVED, FLAT, FLAT]
    given = referee.starts(
        tilt=holding_tilt(turning, alpha, arm) * (1 + excess),
        precession_rate=turning,
        rolling_friction=arm,
        alpha=alpha,
    )
    assert lossy_runner.run(given, duration=100.0).ending.tolist() == expected
    # a disk that friction holds forever is at rest when a single motion ends
    assert lossy_runner.run_single(given, duration=100.0).ending.tolist()[1:] == expected[1:]


def test_a_disk_on_the_brink_that_does_not_turn_is_followed():
    """A disk on the brink that does not turn falls straight until it lifts off, without stiffness."""
    given = referee.starts(tilt=math.asin(0.1) * (1 + 1e-12), rolling_friction=0.1)
    assert lossy_runner.run(given, duration=100.0).ending.tolist() == [LIFT_OFF]


def test_a_motion_on_the_brink_is_refused():
    """The refusal gives the reason and what to change."""
    tilt = holding_tilt(0.7, 0.5, 0.2) * (1 + 1e-7)
    with refused("friction", "rolling_friction", error=NoMotionError):
        sweep.simulate(
            tilt=tilt, precession_rate=0.7, radius=1, gravity=1, alpha=0.5, rolling_friction=0.2, duration=10
        )
