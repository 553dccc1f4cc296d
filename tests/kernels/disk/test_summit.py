"""The coarse search along the tilt for the slowest point of a motion, compared with SciPy and a closed form."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from kernels.disk.equations import inertia, per_inertia
from kernels.disk.summit import _slow_between, _step_along

ALPHA = 0.7


def right_side(_, y):
    """Return ds/dtilt = -o/(1 + alpha), do/dtilt = o tan(tilt) - 2 s (Chaplygin 1897), times dtilt/dy = cos(tilt)."""
    tilt, s, o = y
    cos, sin = np.cos(tilt), np.sin(tilt)
    return [cos, -o * cos / (1.0 + ALPHA), o * sin - 2.0 * s * cos]


def test_the_step_is_of_the_fourth_order():
    """Halving the step divides the error of all four values by 16, and the error is small."""
    start, length = [0.2, 1.3, -0.8], 0.4
    tilt, s, o = solve_ivp(right_side, (0.0, length), start, rtol=1e-12, atol=1e-14).y[:, -1]
    expected = np.array([np.sin(tilt), np.cos(tilt), s, o])
    errors = []
    for steps in (4, 8, 16):
        state = (np.sin(start[0]), np.cos(start[0]), start[1], start[2])
        for _ in range(steps):
            state = _step_along(*state, length / steps, inertia(ALPHA))
        errors.append(np.abs(np.array(state) - expected))
    assert errors[0].max() < 1e-4
    for coarse, fine in ((0, 1), (1, 2)):
        assert (errors[coarse] / errors[fine] > 12.0).all(), errors


@pytest.mark.parametrize("left", [1e-9, 1e-4, 1e-3, 0.01, 0.5])
def test_a_slow_pass_over_upright_is_seen(left):
    """A disk with only a tilt rate has the potential cos(tilt); its remaining energy upright is found."""
    constants, tilt = inertia(ALPHA), -0.25
    for end in (0.25, 0.1):
        w = math.sqrt(
            2.0 * (left + 1.0 - math.cos(tilt)) * per_inertia(math.sin(tilt), math.cos(tilt), constants)
        )
        state = (math.sin(tilt), math.cos(tilt), math.tan(tilt), w, 0.0, 0.0)
        assert _slow_between(state, end, constants) == (left < 2e-3)
    # from upright on, it only accelerates
    w = math.sqrt(2.0 * 1e-4 * per_inertia(math.sin(0.01), math.cos(0.01), constants))
    assert not _slow_between((math.sin(0.01), math.cos(0.01), math.tan(0.01), w, 0.0, 0.0), 0.3, constants)
