"""The critical rates found by integration alone match theory."""

import numpy as np
import pytest
from plot_convergence import convergence, extrapolated


def test_extrapolation_of_a_polynomial():
    """Through four points of 3 - 2x + 5x^2 - x^3 the value at 0 is 3 and the slope is -2."""
    x = np.array([0.1, 0.2, 0.5, 0.7])
    value, slope = extrapolated(x, 3.0 - 2.0 * x + 5.0 * x**2 - x**3)
    assert value == pytest.approx(3.0, rel=1e-12)
    assert slope == pytest.approx(-2.0, rel=1e-11)


@pytest.mark.release
@pytest.mark.compiled
def test_critical_rates_by_integration_alone():
    """For disk and hoop rate^2 R/g extrapolates to theory within 1e-6, with the slope of docs/theory.md."""
    for axis, limits, bends in [
        ("roll_rate", [1 / 3, 1 / 4], [31 / 36, 5 / 6]),
        ("precession_rate", [4 / 5, 2 / 3], [35 / 36, 11 / 12]),
    ]:
        found = convergence(axis, "departure", (0.1, 0.15, 0.2), [0.5, 1.0])
        assert found.value == pytest.approx(np.array(limits), rel=1e-6), (axis, limits, bends)
        # Three angles leave an error of the fourth power of the angle, 0.03^2 of it.
        assert found.slope / limits == pytest.approx(-np.array(bends), rel=1e-3), (axis, limits, bends)


@pytest.mark.release
@pytest.mark.compiled
def test_amplification_converges_to_the_same_line():
    """From above, as 1 + 1/A^2, the amplification criterion extrapolates to the same rates within 1e-6."""
    for axis, limit in [("roll_rate", 1 / 3), ("precession_rate", 4 / 5)]:
        found = convergence(axis, "amplification", (3.0, 5.0), [0.5])
        assert found.value[0] == pytest.approx(limit, rel=1e-6), (axis, limit)
        assert found.slope[0] / limit == pytest.approx(1.0, rel=1e-4), (axis, limit)
