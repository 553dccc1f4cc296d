"""One motion of a body sampled in time, compared with a rigid body in space and the thin disk."""

import math

import numpy as np
import pytest
from body_motion import COMPARED, apart, referee_of
from body_referee import Body, start_of, starts
from body_runner import drawn

from kernels.bodies import motion_arrays as at
from kernels.bodies.shapes import FIRST_WITH_POLES, NAMES
from kernels.disk.endings import EDGE_CHANGE, FELL, HORIZON
from sweep.model.kernel import Kernel

pytestmark = pytest.mark.compiled


KERNELS = [Kernel(f"kernels.bodies.{name}", "trajectory") for name in ("trajectory", "poles.trajectory")]


def follow(given, number, times, step=0.0, relative_step=0.005, fall_tilt=1.5):
    """Return the ending, the sample times and the samples by name."""
    samples = np.full((len(at.SAMPLES), times.size), np.nan)
    settings = np.array([step, relative_step, fall_tilt, float(number)])
    ending, filled, last, _ = KERNELS[number >= FIRST_WITH_POLES].load()(given, settings, times, samples)
    return (
        ending,
        np.append(times[: filled - 1], last),
        dict(zip(at.SAMPLES, samples[:, :filled], strict=True)),
    )


@pytest.mark.slow_lane
def test_random_motions_are_those_of_a_body_in_space():
    """For all bodies and rates over a decade, axis, roll, rates, path, center and forces agree to 1e-9."""
    rng = np.random.default_rng(24)
    ended = []
    for number in range(15):
        word = NAMES[number % len(NAMES)]
        lengths, moments, arc = drawn(word, rng)
        tilt, rates = rng.uniform(-1.2, 1.2), rng.normal(size=3) * rng.choice([0.3, 0.6, 1.5])
        given, kind = start_of(word, tilt, *rates, *moments, **lengths)
        ending, times, found = follow(given, kind, np.linspace(0.0, 5.0, 26))
        ended.append(ending)
        off = apart(found, referee_of(word, arc, moments, tilt), tilt, rates, times)
        size = 1.0 + np.linalg.norm(
            [found["friction_across"], found["friction_along"], found["normal_force"]], axis=0
        )
        for name in COMPARED:
            assert (off[name] <= 1e-9 * size).all(), (word, number, name)
        assert np.abs(found["energy_drift"]).max() < 1e-10
        assert (
            np.abs(
                found["vertical_momentum"] - found["vertical_momentum"][0] - found["momentum_gained"]
            ).max()
            < 1e-10
        )
    assert {HORIZON, EDGE_CHANGE} <= {*ended}


@pytest.mark.slow_lane
def test_motions_that_pass_a_pole_are_those_of_a_body_in_space(pick):
    """Balls and spheroids that pass a pole at 1e-9 to 0.1 rad agree to 1e-9 with regular motions in space."""
    for passed in pick((1e-9, 1e-6, 1e-3, 0.1, -1e-4), 2):
        for word, lengths, body in (
            ("ball", {"offset": 0.3}, Body(0.0, 0.3, 1.0, 0.42, 0.38)),
            ("spheroid", {"flattening": 0.4, "offset": -0.2}, Body(0.0, -0.2, 1.0, 0.4, 0.3, 0.36)),
            ("spheroid", {"flattening": -0.6, "offset": 0.1}, Body(0.0, 0.1, 1.0, 0.35, 0.6, 2.56)),
        ):
            tilt, rates = 0.4, (3.0, passed, 0.5 * passed)
            given, kind = start_of(word, tilt, *rates, body.axial, body.transverse, **lengths)
            _, times, found = follow(given, kind, np.linspace(0.0, 5.0, 40))
            assert np.abs(found["heading"]).max() > 2.0
            for name, off in apart(found, body, tilt, rates, times).items():
                assert off.max() < 1e-9, (word, passed, name)


def test_a_ball_rolls_end_over_end():
    """The ball moves straight at v t and passes each pole once per turn, where its heading jumps by half a turn."""
    rate, times = 2.0, np.linspace(0.0, 10.0, 41)
    given = starts(tilt=0.3, tilt_rate=rate, axial_moment=0.4, transverse_moment=0.4)
    _, _, found = follow(given, NAMES.index("ball"), times)
    turned = 0.3 + rate * times
    np.testing.assert_allclose(found["tilt"], np.arcsin(np.sin(turned)), atol=1e-9)
    np.testing.assert_allclose(found["contact_x"], rate * times, atol=1e-9)
    np.testing.assert_allclose(found["contact_y"], 0.0, atol=1e-9)
    np.testing.assert_allclose(found["centre_z"], 1.0, atol=1e-12)
    np.testing.assert_allclose(found["normal_force"], 1.0, atol=1e-9)
    over = np.floor(turned / math.pi + 0.5)
    np.testing.assert_allclose(np.cos(found["heading"]), np.cos(math.pi * over), atol=1e-9)
    assert np.abs(found["heading"][-1]) > 3.0


@pytest.mark.parametrize("word", ["disk", "torus", "spheroid"])
def test_every_quantity_is_of_fourth_order(word):
    """Halving the step divides the errors of path, angles and state by 16, even near a pole."""
    body = {
        "disk": Body(1.0, 0.0, 0.0, 0.5, 0.25),
        "torus": Body(0.75, 0.0, 0.25, 0.609375, 0.3203125),
        "spheroid": Body(0.0, 0.0, 1.0, 0.4, 0.25, 0.25),
    }[word]
    lengths = {"disk": {"tube": 0.0}, "torus": {"tube": 0.25}, "spheroid": {"flattening": 0.5}}[word]
    tilt, rates = (1.2, (2.0, 0.3, 0.2)) if word == "spheroid" else (0.4, (0.5, 1.0, -0.7))
    given, kind = start_of(
        "torus" if word == "disk" else word, tilt, *rates, body.axial, body.transverse, **lengths
    )
    times = np.linspace(0.0, 2.0, 11)
    coarse, fine = (
        apart(follow(given, kind, times, step=step)[2], body, tilt, rates, times) for step in (0.01, 0.005)
    )
    for name in COMPARED:
        assert 14.0 < coarse[name].max() / fine[name].max() < 18.0, name


def test_where_a_motion_ends():
    """Motions end at fall_tilt; a coin that falls onto its other edge ends at tilt 0, on either side."""
    given = starts(tilt=0.5, tube=0.25, axial_moment=0.609375, transverse_moment=0.3203125)
    ending, times, found = follow(given, NAMES.index("torus"), np.linspace(0.0, 9.0, 10))
    assert ending == FELL
    assert found["tilt"][-1] == pytest.approx(1.5, abs=1e-12)
    assert times[-1] < 9.0
    ends = []
    for tilt in (0.05, -0.05):
        lean = starts(tilt=tilt, thickness=0.2, axial_moment=0.5, transverse_moment=0.25)
        ending, times, found = follow(lean, NAMES.index("rim"), np.linspace(0.0, 9.0, 10))
        assert ending == EDGE_CHANGE
        assert found["tilt"][-1] == pytest.approx(0.0, abs=1e-12)
        # both edges are on the plane: the center is a radius above it
        assert found["centre_z"][-1] == pytest.approx(1.0, abs=1e-12)
        ends.append(times[-1])
    assert ends[0] == pytest.approx(ends[1], rel=1e-13)
