"""The step of the coarse search along the tilt, against SciPy."""

import numpy as np
from scipy.integrate import solve_ivp

from kernels.disk.equations import inertia
from kernels.disk.summit import _step_along

ALPHA = 0.7


def right_side(_, y):
    """Return ds/dtilt = -o/(1 + alpha), do/dtilt = o tan(tilt) - 2 s (Chaplygin 1897), times dtilt/dy = cos(tilt)."""
    tilt, s, o = y
    cos, sin = np.cos(tilt), np.sin(tilt)
    return [cos, -o * cos / (1.0 + ALPHA), o * sin - 2.0 * s * cos]


def test_the_step_is_of_the_fourth_order():
    """Each of the four values has a sixteenth of the error with half the step, and what it has is small."""
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
