import itertools

import numpy as np
import pytest
import referee
from auditing import ENDINGS
from scipy.integrate import solve_ivp

from sweep.model.disk.model import DISK
from sweep.model.disk.tables import PARAMETERS
from sweep.model.disk.theory import saddle_node_rates
from sweep.request.spec import SweepSpec

ALPHAS = (0.05, 0.5, 1.0)
RATES = ("roll_rate", "precession_rate")


def wells(rate, tilt, axis, alpha):
    """Count the wells of a tilted start's potential with SciPy: its slope has one or three zeros.

    The slope is minus the tilt acceleration at rest; the rates as functions of the tilt follow from the
    equations of motion at a tilt rate of one.
    """
    start = (0.0, rate) if axis == "roll_rate" else (rate, 0.0)

    def change(theta, y):
        return referee.accelerations((theta, 1.0, *y), alpha, 1.0, 1.0)[1:]

    zeros = 0
    for end in (-1.4, 1.4):
        places = np.linspace(tilt, end, 1500)
        run = solve_ivp(change, (tilt, end), start, rtol=1e-10, atol=1e-12, t_eval=places)
        slopes = [
            referee.accelerations((theta, 0.0, *y), alpha, 1.0, 1.0)[0]
            for theta, y in zip(run.t, run.y.T, strict=True)
        ]
        zeros += np.count_nonzero(np.diff(np.sign(slopes)))
    return (zeros + 1) // 2


@pytest.mark.slow_lane
def test_the_potential_has_two_wells_below_the_fold():
    """By SciPy and the equations of motion the potential has two wells just below the curve, one above."""
    for alpha, axis, tilt in itertools.product([0.3, 1.0], RATES, [2.0, 12.0]):
        tilt = np.radians(tilt)
        rate = float(saddle_node_rates(np.array([tilt]), axis, alpha)[0])
        assert [wells(rate * factor, tilt, axis, alpha) for factor in (0.8, 0.999, 1.001, 1.2)] == [
            2,
            2,
            1,
            1,
        ], (alpha, axis, tilt)


@pytest.mark.compiled
def test_the_reduction_counts_the_same_wells():
    """From upright to 70 deg the reduction finds two wells 1e-6 below the curve and one 1e-6 above."""
    for alpha, axis in itertools.product(ALPHAS, RATES):
        tilt = np.radians(np.linspace(0.01, 70.0, 300))
        given = {
            name: np.full(tilt.shape, 1.0 if name in ("radius", "gravity") else 0.0) for name in PARAMETERS
        }
        for factor, count in ((1.0 - 1e-6, 2), (1.0 + 1e-6, 1)):
            start = given | {
                "tilt": tilt,
                "alpha": np.full(tilt.shape, alpha),
                axis: factor * saddle_node_rates(tilt, axis, alpha),
            }
            found = DISK.exact.measures(SweepSpec(fall_tilt="89deg", method="exact"), start)
            assert (found["wells"] == count).all(), (alpha, axis)
            assert np.isin(found["ending"], (ENDINGS["bounded"], ENDINGS["fell"])).all(), (alpha, axis)


def test_it_starts_at_the_critical_rates():
    """At upright the squares are 1/[2(1+alpha)] and 2/(2+alpha); the curve falls from there on both sides."""
    for alpha in ALPHAS:
        tilt = np.radians(np.linspace(1e-6, 60.0, 200))
        for axis, squared in (("roll_rate", 0.5 / (1.0 + alpha)), ("precession_rate", 2.0 / (2.0 + alpha))):
            rates = saddle_node_rates(tilt, axis, alpha)
            assert rates[0] ** 2 == pytest.approx(squared, rel=1e-4), alpha
            assert (np.diff(rates) < 0.0).all(), alpha
            assert np.array_equal(saddle_node_rates(-tilt, axis, alpha), rates), alpha
