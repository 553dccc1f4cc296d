"""Functions that are almost zero except in a short interval: every pass finds them, from rest and in motion."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import erf, fresnel
from system_passes import run

from kernels.system.endings import FIRST_EVENT, RUNS_ON

DOSE = """
@system(duration="100")
def dose(amount=0.0, *, width=0.5, when=50.0, t):
    return exp(-((t - when)/width)**2)
"""
SWITCHES = """
@system(duration="100")
def switches(a=0.0, b=0.0, c=0.0, d=0.0, *, width=0.01, when=50.0, t):
    u = (t - when)/width
    return (tanh(u) + 1)/2, 1/(1 + u**2)**2, sqrt((t - when)**2 + width**2), (t/when)**40
"""
FORCED = """
@system(duration="40")
def forced(x=0.0, v=0.0, *, width=0.05, when=20.0, strength=10.0, t):
    return v, -sin(x) - 0.05*v + strength*exp(-((t - when)/width)**2)
"""
PASSER = """
@system(duration="200", ends={"slow": "v < 0.5"}, measures={"fastest": "max v"})
def passer(x=-100.0, v=1.0, *, width=0.01, depth=0.2):
    return v, -2*depth*x/width**2*exp(-(x/width)**2)
"""
ANGLES = """
@system(duration="100")
def angles(a=0.0, x=1.0, y=0.0, s=0.0, *, width=0.01, when=50.0, t):
    return atan((t - when)/width)/pi + 1/2, -y, x, sin(atan2(y, x))
"""
CHIRP = """
@system(duration="10")
def chirp(x=0.0, *, k=1.0, t):
    return cos(k*t**2)
"""
FRICTION = """
@system(duration="50", measures={"reach": "max abs(x)"})
def block(x=0.0, v=0.0, *, mu=0.3, force=1.0, drive=0.8, eps=1e-3, t):
    return v, -x - mu*tanh(v/eps) + force*cos(drive*t)
"""


@pytest.mark.parametrize("step", [0.0, 1.0])
def test_a_dose_from_nothing(rng, step):
    """A pulse from rest adds width times the root of pi, in every pass and even with a longest step."""
    width, when = 10.0 ** rng.uniform(-4.0, 1.0, 40), rng.uniform(30.0, 70.0, 40)
    endings, found, _ = run(DOSE, {"width": width, "when": when}, step=step)
    truth = 0.5 * math.sqrt(math.pi) * width * (erf((100.0 - when) / width) + erf(when / width))
    assert np.all(endings == RUNS_ON)
    for leg, share in enumerate((1e-3, 1e-5, 1e-8, 1e-10)):
        assert np.all(np.abs(found[leg, 0] - truth) <= share * truth), leg


@pytest.mark.compiled
def test_switches_far_from_where_they_switch(rng):
    """A tanh step, a squared Lorentzian, a corner and a high power agree with their integrals."""
    width, when = 10.0 ** rng.uniform(-3.0, 0.0, 20), rng.uniform(30.0, 70.0, 20)
    endings, found, _ = run(SWITCHES, {"width": width, "when": when})
    assert np.all(endings == RUNS_ON)
    ends = (100.0 - when) / width, -when / width
    # log(cosh(x)), and the integrals of the square of a Lorentzian and of a hyperbola
    logs = [np.abs(x) + np.log1p(np.exp(-2.0 * np.abs(x))) - math.log(2.0) for x in ends]
    assert found[-1, 0] == pytest.approx(50.0 + 0.5 * width * (logs[0] - logs[1]), rel=1e-9)
    bells = [0.5 * (x / (1.0 + x**2) + np.arctan(x)) for x in ends]
    assert found[-1, 1] == pytest.approx(width * (bells[0] - bells[1]), rel=1e-9)
    arcs = [0.5 * (x * np.sqrt(x**2 + 1.0) + np.arcsinh(x)) for x in ends]
    assert found[-1, 2] == pytest.approx(width**2 * (arcs[0] - arcs[1]), rel=1e-9)
    assert found[-1, 3] == pytest.approx(when / 41.0 * (100.0 / when) ** 41, rel=1e-9)


@pytest.mark.compiled
@pytest.mark.parametrize("x", [0.0, 0.5])
def test_a_pendulum_gets_a_push(x):
    """A pendulum at rest or swinging gets a push, as in SciPy with steps that cannot skip it."""
    for width in (0.05, 0.3):
        _, found, _ = run(FORCED, {"x": np.array([x]), "width": np.array([width])})

        def rates(t, y, width=width):
            return y[1], -math.sin(y[0]) - 0.05 * y[1] + 10.0 * math.exp(-(((t - 20.0) / width) ** 2))

        # a first rate of 1e-200 has squares of zero
        with np.errstate(invalid="ignore"):
            truth = solve_ivp(
                rates, (0.0, 40.0), [x, 0.0], "DOP853", rtol=1e-12, atol=1e-13, max_step=width / 4.0
            )
        assert found[-1, :2, 0] == pytest.approx(truth.y[:, -1], abs=1e-9)
        assert found[0, :2, 0] == pytest.approx(truth.y[:, -1], abs=1e-2)


def test_a_narrow_well_that_a_straight_motion_passes():
    """Crossing a well of a ten thousandth of its path, a body has the speed in the middle that energy gives."""
    depth = np.array([0.2, -0.2, -0.4])
    endings, found, _ = run(PASSER, {"depth": depth, "width": np.array([0.01, 0.01, 0.1])})
    # a hill of 0.2 reduces v to sqrt(1 - 0.4), one of 0.4 to below 1/2; a well of 0.2 gives sqrt(1.4)
    assert np.all(endings[-1] == [RUNS_ON, RUNS_ON, FIRST_EVENT])
    assert found[-1, 3] == pytest.approx([math.sqrt(1.4), 1.0, 1.0], rel=1e-9)


def test_terms_that_vanish_at_the_start():
    """The last terms of the series of cos(t**2) are zero at t = 0; the sum is still Fresnel's integral."""
    k = np.array([0.3, 1.0, 3.0])
    endings, found, _ = run(CHIRP, {"k": k})
    assert np.all(endings == RUNS_ON)
    truth = np.sqrt(np.pi / 2.0 / k) * fresnel(10.0 * np.sqrt(2.0 * k / np.pi))[1]
    assert found[-1, 0] == pytest.approx(truth, abs=1e-10)


@pytest.mark.compiled
def test_dry_friction_that_is_smoothed():
    """Friction that switches within a thousandth of the largest speed agrees with SciPy's Radau."""
    eps = np.array([1e-3, 1e-2])
    endings, found, _ = run(FRICTION, {"eps": eps})
    assert np.all(endings == RUNS_ON)
    for column, width in enumerate(eps):

        def rates(t, y, width=width):
            return y[1], -y[0] - 0.3 * np.tanh(y[1] / width) + np.cos(0.8 * t)

        truth = solve_ivp(rates, (0.0, 50.0), [0.0, 0.0], "Radau", rtol=1e-9, atol=1e-11)
        assert found[-1, :2, column] == pytest.approx(truth.y[:, -1], abs=1e-5)


@pytest.mark.compiled
def test_angles(rng):
    """A step of the arc tangent is found, and a point may go round: closed forms."""
    width, when = 10.0 ** rng.uniform(-12.0, 0.0, 20), rng.uniform(30.0, 70.0, 20)
    endings, found, _ = run(ANGLES, {"width": width, "when": when})
    assert np.all(endings == RUNS_ON)
    areas = [u * np.arctan(u) - 0.5 * np.log1p(u**2) for u in ((100.0 - when) / width, -when / width)]
    assert found[-1, 0] == pytest.approx(50.0 + width / np.pi * (areas[0] - areas[1]), rel=1e-9)
    assert found[-1, 3] == pytest.approx(np.full(20, 1.0 - math.cos(100.0)), abs=1e-9)
