"""The paths of bodies over a nutation, compared with the contact point of a rigid body followed in space."""

import math

import numpy as np
import pytest
from body_referee import LENGTHS, REFERENCE, cross, start_of
from body_runner import FALL_TILT, TORUS
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from kernels.bodies.arrays import ANNULAR_PATH, PATH, UNBOUNDED_PATH, UNKNOWN_PATH
from kernels.bodies.shapes import NAMES
from sweep.model.bodies.exact import kernel_of

#: Accuracy of the time of an extreme.
CLOSE = {"xatol": 1e-9}


def _signed(t, distance, sign):
    return sign * distance(t)


def followed(body, tilt, w, o, s):
    """Return heading and displacement gained in a nutation from the smallest tilt, and the motion itself.

    The state also has the heading and the contact point, which moves with the center of mass and over the
    body.
    """

    def right_side(t, y):
        n, turning = y[:3], y[3:6]
        n_rate, cosine = cross(turning, n), math.sqrt(1.0 - n[2] ** 2)
        arm, arm_rate = body.contact(n, n_rate)
        moved = arm_rate - cross(turning, arm)
        heading = (n[0] * n_rate[1] - n[1] * n_rate[0]) / cosine**2
        return np.concatenate([body.right_side(t, y[:6]), [heading, moved[0], moved[1]]])

    def turns(_, y):
        return cross(y[3:6], y[:3])[2]

    turns.terminal = 4
    first = np.concatenate([body.start(tilt, w, o, s), np.zeros(3)])
    found = solve_ivp(
        right_side,
        (0.0, 300.0),
        first,
        method="DOP853",
        rtol=1e-11,
        atol=1e-13,
        events=turns,
        dense_output=True,
    )
    states, times = found.y_events[0], found.t_events[0]
    low = 0 if states[0][2] < states[1][2] else 1
    begin, end = states[low], states[low + 2]
    heading = end[6] - begin[6]
    return heading, complex(*(end - begin)[7:]), begin, (times[low], times[low + 2]), found.sol


def ring(heading, moved, begin, times, motion):
    """Return the least and greatest distance of the contact point from the ring's center, and the center."""
    centre = complex(*begin[7:]) + moved / (1.0 - np.exp(1j * heading))

    def distance(t):
        return abs(complex(*motion(t)[7:]) - centre)

    places = np.linspace(*times, 200)
    apart = [distance(t) for t in places]
    step, best = places[1] - places[0], []
    for sign in (1.0, -1.0):
        t = places[int(np.argmin(sign * np.array(apart)))]
        bounds = (t - step, t + step)
        near = minimize_scalar(_signed, args=(distance, sign), bounds=bounds, method="bounded", options=CLOSE)
        best.append(sign * near.fun)
    return [*best, centre.real, centre.imag]


def path_of(given, body):
    """Return the measures of one cell and its class."""
    measures, classes = np.full((len(PATH), given.shape[1]), -7.0), np.zeros(given.shape[1], np.int64)
    kernel_of(body, "paths").load()(
        np.ascontiguousarray(given), float(NAMES.index(body)), FALL_TILT, measures, classes
    )
    return measures[:, 0], classes[0]


@pytest.mark.slow_lane
def test_the_ring_of_a_nutation(pick):
    """Heading, chord, radii and center agree for tori, the thin disk, a rounded disk, a ball and a spheroid."""
    cases = (
        ("torus", (0.2, 0.1, 0.5, 0.6)),
        ("disk", (0.2, 0.1, 0.5, 0.6)),
        ("edge", (-0.4, 0.3, -1.1, 0.9)),
        ("edge", (-0.4, -0.3, -1.1, 0.9)),
        ("torus", (0.3, -0.2, 1.5, -0.6)),
        ("ball", (0.2, 0.1, 0.5, 0.6)),
        ("oblate", (0.2, 0.1, 0.5, 0.6)),
    )
    for name, start in pick(cases, 3):
        body, (word, lengths) = REFERENCE[name][0], LENGTHS[name]
        given, _ = start_of(word, *start, body.axial, body.transverse, **lengths(body))
        found, shape = path_of(given, word)
        heading, moved, *motion = followed(body, *start)
        assert shape == ANNULAR_PATH, name
        assert found[0] == pytest.approx(heading, abs=1e-9), name
        assert found[1] == pytest.approx(abs(moved), abs=1e-9), name
        assert found[2:] == pytest.approx(ring(heading, moved, *motion), abs=1e-8), name


def test_a_ring_that_wobbles_along_a_line_goes_ever_further():
    """A ring kicked off its straight path tilts equally to both sides, gains no turn and has a straight path."""
    body = REFERENCE["torus"][0]
    given, _ = start_of(
        "torus", 0.0, 0.2, 0.0, 0.9, TORUS["axial_moment"], TORUS["transverse_moment"], tube=0.25
    )
    given[-2] = 3.0  # the radius: lengths are in meters
    given[1:4] /= math.sqrt(3.0)
    found, shape = path_of(given, "torus")
    heading, moved, *_ = followed(body, 0.0, 0.2, 0.0, 0.9)
    assert shape == UNBOUNDED_PATH
    assert abs(heading) < 1e-9
    assert found[0] == pytest.approx(0.0, abs=1e-9)
    assert found[1] == pytest.approx(3.0 * abs(moved), abs=1e-8)
    assert np.isnan(found[2:]).all()


def test_what_falls_or_rests_has_no_nutation():
    """The path of a fall, of rest, and of a ball over its poles, where the heading jumps, is missing."""
    ball, _ = start_of("ball", 0.3, 1.0, 0.0, 0.0, 0.4, 0.4)
    assert path_of(ball, "ball")[1] == UNKNOWN_PATH
    for start in ((0.3, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.9)):
        given, _ = start_of("torus", *start, TORUS["axial_moment"], TORUS["transverse_moment"], tube=0.25)
        found, shape = path_of(given, "torus")
        assert shape == UNKNOWN_PATH
        assert np.isnan(found).all()


def test_a_start_at_rest_has_the_path_of_one_that_hardly_moves():
    """Released at its smallest or greatest tilt, to either side, a start has the measures of a slow one."""
    at_least = set()
    for name in ("torus", "disk", "ball"):
        body, (word, lengths) = REFERENCE[name][0], LENGTHS[name]
        for tilt, o, s in ((0.2, 0.5, 0.6), (-0.2, 0.5, 0.6), (1.2, -1.0, 0.3), (-1.2, 1.0, 0.3)):
            rest, kicked = (
                path_of(start_of(word, tilt, w, o, s, body.axial, body.transverse, **lengths(body))[0], word)
                for w in (0.0, 1e-9)
            )
            assert rest[1] == kicked[1] == ANNULAR_PATH, (name, tilt)
            assert rest[0] == pytest.approx(kicked[0], rel=1e-6, abs=1e-6), (name, tilt)
            least, greatest, _ = body.extremes(tilt, 0.0, o, s)
            at_least.add(abs(tilt - least) < abs(tilt - greatest))
    assert at_least == {False, True}
