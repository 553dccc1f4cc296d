"""Motions of bodies with a meridian expression: against a rigid body in space, quadrature, closed forms."""

import math

import body_runner
import numpy as np
import pytest
from body_referee import LENGTHS, REFERENCE, starts
from meridian_referee import Body
from numpy.polynomial import Polynomial
from scipy.integrate import quad

import sweep
from kernels.disk import endings as code
from kernels.system.endings import FIRST_EVENT
from sweep.engine.compute import compute
from sweep.model.system.model import model_of
from sweep.request.system_file import read_system

pytestmark = pytest.mark.compiled

#: One meridian for all tests, so only one kernel is compiled: ring, ellipsoid, offset, and polynomials beyond
#: arcs.
TEXT = """
from sweep.systems import body, cos, sin, sqrt

@body(duration="10 s", ends={"fell": "abs(tilt) > limit"})
def whole(tilt, *, core=0.0, shift=0.0, edge=1.0, axial=0.4, transverse=0.4, square=1.0, second=0.0, third=0.0,
          limit: "rad"=100.0, radius=1.0, gravity=1.0):
    u = sin(tilt)
    ellipse = edge*sqrt(cos(tilt)**2 + square*u**2)
    return core*cos(tilt) + ellipse + shift*u + second*u**2 + third*u**3, axial, transverse
"""
MODEL = model_of(read_system(TEXT))
BODY = ("core", "shift", "edge", "axial", "transverse", "square")
RUNS_ON, FELL = 1, FIRST_EVENT


def cells(duration, **starts):
    """Return the kernels' results for some starts, with all other parameters at their defaults."""
    count = max(np.size(each) for each in starts.values())
    known = {name: each.default for name, each in MODEL.parameters.items()} | starts
    spec = sweep.SweepSpec(model=MODEL, duration=duration)
    return compute(spec, {name: np.full(count, 0.0) + value for name, value in known.items()})


def start(tilt, w, o, s):
    """Return a start with scaled rates."""
    precession = o / np.cos(tilt)
    return {
        "tilt": tilt,
        "tilt_rate": w,
        "precession_rate": precession,
        "roll_rate": s - precession * np.sin(tilt),
    }


@pytest.mark.release
def test_extremes_of_the_bodies_of_the_table(pick):
    """Thin disk, rings, rounded disk, off-center ball and spheroids match all digits of the table."""
    assert REFERENCE.keys() == LENGTHS.keys()
    rows = [REFERENCE[name] for name in pick(REFERENCE, 3)]
    bodies = {name: np.array([getattr(row[0], name) for row in rows]) for name in BODY}
    found = cells(40.0, **bodies, **start(0.2, 0.1, 0.5, 0.6))
    assert set(found["ending"]) == {RUNS_ON}
    for number, name in ((1, "tilt_min"), (2, "tilt_max")):
        right = np.array([row[number] for row in rows])
        assert found[name] == pytest.approx(right, abs=2e-10)
        assert (found[f"{name}_error"] < 1e-8).all()
    assert (found["conserved_change"] < 1e-12).all()


@pytest.mark.parametrize("name", ["torus", "rounded", "spheroid", "ball", "arc"])
def test_extremes_are_those_of_the_kernels_of_bodies(name, rng):
    """Random bodies and starts: the same motions fall, and extremes agree within both stated errors."""
    count = 40
    rows = [body_runner.drawn(name, rng) for _ in range(count)]
    lengths = {word: np.array([row[0][word] for row in rows]) for word in rows[0][0]}
    core, shift, edge, square = np.array([row[2] for row in rows]).T
    axial, transverse = np.array([row[1] for row in rows]).T
    begun = start(
        rng.uniform(0.1, 1.2, count), rng.uniform(-0.5, 0.5, count), *rng.uniform(-1.5, 1.5, (2, count))
    )
    given = starts(count, **begun, **lengths, axial_moment=axial, transverse_moment=transverse)
    right = body_runner.run(given, name)
    found = cells(
        60.0, **begun, core=core, shift=shift, edge=edge, square=square, axial=axial, transverse=transverse,
        limit=100.0 if name in ("spheroid", "ball") else body_runner.FALL_TILT,
    )  # fmt: skip
    assert np.array_equal(found["ending"] == FELL, right.ending == code.FELL)
    # At least one whole nutation fits into the duration.
    whole = (right.ending == code.BOUNDED) & (right.period < 55.0) & (found["ending"] == RUNS_ON)
    assert whole.sum() > 0.8 * count
    for measure, extreme in (("tilt_min", right.least), ("tilt_max", right.greatest)):
        apart = np.abs(found[measure] - extreme)
        assert (apart <= found[f"{measure}_error"] + right.tilt_error)[whole].all()
        assert apart[whole].max() < 1e-8


def far(found, number, body, tilt, rates, end):
    """Return a cell's distance from the rigid body in space at the end, and its stated error."""
    path = body.path(tilt, *rates, np.array([0.0, end]))
    names = ("tilt", "tilt_rate", "precession_rate", "roll_rate")
    tilt, rate, precession, roll = (found[f"{name}_end"][number] for name in names)
    stated = sum(found[f"{name}_end_error"][number] for name in names)
    n, turning = path["axis"][1], path["turning"][1]
    # Quantities that do not depend on the heading: spin about the vertical, spin about the axis, tilt rate.
    sine, cosine = math.sin(tilt), math.cos(tilt)
    here = np.array([sine, precession + roll * sine, roll + precession * sine, cosine * rate])
    there = [n[2], turning[2], turning @ n, np.cross(turning, n)[2]]
    return np.abs(here - there).max(), stated + 2e-11


@pytest.mark.release
def test_any_meridian_against_a_rigid_body_in_space(rng):
    """Random bodies, some with a flat side, match axis and angular velocity within the stated errors."""
    count, end = 12, 6.0
    given = {
        "core": np.where(np.arange(count) < 4, rng.uniform(0.2, 0.8, count), 0.0),
        "shift": rng.uniform(-0.2, 0.2, count), "edge": rng.uniform(0.5, 1.0, count),
        "axial": rng.uniform(0.3, 0.5, count), "transverse": rng.uniform(0.3, 0.5, count),
        "square": rng.uniform(0.6, 1.6, count),
    }  # fmt: skip
    more = {"second": rng.uniform(-0.1, 0.1, count), "third": rng.uniform(-0.05, 0.05, count)}
    tilts, rates = rng.uniform(-0.8, 0.8, count), rng.uniform(-0.8, 0.8, (3, count))
    found = cells(end, **given, **more, **start(tilts, *rates))
    assert set(found["ending"]) == {RUNS_ON}
    for number in range(count):
        polynomial = Polynomial([0.0, 0.0, *(more[name][number] for name in more)])
        body = Body(**{name: values[number] for name, values in given.items()}, more=polynomial)
        distance, stated = far(found, number, body, tilts[number], rates[:, number], end)
        assert distance <= stated
        assert stated < 1e-8


@pytest.mark.slow_lane
def test_by_the_poles():
    """An egg passing near a pole stays within its stated error; through the pole it goes end over end."""
    precession = np.array([1e-1, 1e-3, 1e-5, 1e-9, 0.0])
    egg = {"axial": 0.4, "transverse": 0.45, "second": 0.2, "third": 0.05}
    found = cells(8.0, **egg, tilt=0.3, tilt_rate=1.8, precession_rate=precession)
    assert list(found["ending"] == RUNS_ON) == [True] * 5
    body = Body(0.0, 0.0, 1.0, 0.4, 0.45, more=Polynomial([0.0, 0.0, 0.2, 0.05]))
    for number in range(5):
        rates = 1.8, precession[number] * math.cos(0.3), precession[number] * math.sin(0.3)
        distance, stated = far(found, number, body, 0.3, rates, 8.0)
        assert distance <= stated
        # At 1e-9 it passes so near to the pole that afterwards little is known.
        assert stated < 2e-5 or precession[number] == 1e-9
    assert found["tilt_max"][2] < 0.5 * math.pi < 2.0 * math.pi < found["tilt_max"][4]


def test_a_fall_takes_the_time_of_its_quadrature():
    """A hoop and a ring fall without spin to 85 degrees in the time that follows from their energy."""
    tube, first, last = np.array([0.0, 0.3]), 0.1, math.radians(85.0)
    axial, transverse = (1.0 - tube) ** 2 + 0.75 * tube**2, 0.5 * (1.0 - tube) ** 2 + 0.625 * tube**2
    ring = {"core": 1.0 - tube, "edge": tube, "axial": axial, "transverse": transverse}
    found = cells(30.0, **ring, tilt=first, limit=last)
    assert list(found["ending"]) == [FELL, FELL]
    assert found["tilt_end"] == pytest.approx([last, last], abs=1e-12)
    for number, width in enumerate(tube):
        core = 1.0 - width

        def slowness(root, core=core, width=width, about=transverse[number]):
            # tilt = first + root^2 removes the singularity of the integrand at the start.
            tilt = first + root * root
            inertia = about + core**2 + 2.0 * core * width * math.cos(tilt) + width**2
            fallen = 2.0 * core * math.sin(0.5 * (first + tilt)) * math.sin(0.5 * root * root)
            return 2.0 * root * math.sqrt(0.5 * inertia / fallen) if root else 0.0

        time, _ = quad(slowness, 1e-9, math.sqrt(last - first), epsabs=1e-13, epsrel=1e-13)
        assert found["end_time"][number] == pytest.approx(time, abs=1e-8)
