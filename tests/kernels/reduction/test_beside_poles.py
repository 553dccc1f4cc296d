"""The reduction of balls and spheroids near and through their poles."""

import math

import mpmath
import numpy as np
import pytest
from body_referee import Body, start_of, starts
from body_runner import reduce
from scipy.integrate import quad

from kernels.bodies.arrays import PARAMETERS
from kernels.bodies.shapes import spheroid_moments
from kernels.disk.endings import BOUNDED, INVALID

#: Words and the referee's body: a ball and two spheroids with offset centers of mass.
BODIES = (
    ("ball", {"offset": 0.3}, Body(0.0, 0.3, 1.0, 0.42, 0.38)),
    ("spheroid", {"flattening": 0.4, "offset": -0.2}, Body(0.0, -0.2, 1.0, 0.4, 0.3, 0.36)),
    ("spheroid", {"flattening": -0.6, "offset": 0.1}, Body(0.0, 0.1, 1.0, 0.35, 0.6, 2.56)),
)


class Ball:
    """Motion of a ball to 40 digits, reduced to one degree of freedom by Jellett's and Routh's integrals.

    With the sine u of the tilt, G at e along the axis and the moments I and A, J = A x + I (u + e) s and
    K = s sqrt(I A + I (u + e)^2 + A (1 - u^2)) are constant, where x is the cosine times the precession of
    G's axis; the
    energy gives u'. See Routh, Advanced Rigid Dynamics, article 243.
    """

    def __init__(self, start):
        cell = {name: mpmath.mpf(float(value)) for name, value in zip(PARAMETERS, start[:, 0], strict=True)}
        self.e, self.I, self.A = cell["offset"], cell["axial_moment"], cell["transverse_moment"]
        u, c = mpmath.sin(cell["tilt"]), mpmath.cos(cell["tilt"])
        w, o = cell["tilt_rate"], cell["precession_rate"] * c
        s = cell["roll_rate"] + cell["precession_rate"] * u
        across = self.A + c * c + (u + self.e) ** 2
        self.J = self.A * c * o + self.I * (u + self.e) * s
        self.K = s * mpmath.sqrt(self.square(u))
        sideways = c * s - (u + self.e) * o
        self.E = (across * w * w + self.A * o * o + self.I * s * s + sideways**2) / 2 + self.e * u
        self.first = mpmath.atanh(u)

    def square(self, u):
        """Return the square of Routh's factor."""
        return self.I * self.A + self.I * (u + self.e) ** 2 + self.A * (1 - u * u)

    def speed_square(self, z):
        """Return the squared rate of u = tanh z."""
        u = mpmath.tanh(z)
        s = self.K / mpmath.sqrt(self.square(u))
        x = (self.J - self.I * (u + self.e) * s) / self.A
        c = 1 - u * u
        turning = self.A * x * x + self.I * s * s * c + (c * s - (u + self.e) * x) ** 2
        return (2 * c * (self.E - self.e * u) - turning) / (self.A + c + (u + self.e) ** 2)

    def turn(self, side):
        """Return the turning point on one side of the start, as z."""
        z, step = self.first, mpmath.mpf(side) / 20
        while self.speed_square(z + step) > 0:
            z += step
        return mpmath.findroot(self.speed_square, (z, z + step), solver="anderson", tol=1e-36)

    def extremes(self):
        """Return the extreme tilts and the period."""
        ends = [self.turn(side) for side in (-1, 1)]
        middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2

        def slowness(angle):
            z = middle + half * mpmath.sin(angle)
            size = mpmath.sqrt(abs(self.speed_square(z)))
            return half * mpmath.cos(angle) / (mpmath.cosh(z) ** 2 * size)

        period = 2 * mpmath.quad(slowness, mpmath.linspace(-mpmath.pi / 2, mpmath.pi / 2, 7))
        return [*(float(mpmath.asin(mpmath.tanh(z))) for z in ends), float(period)]


def test_a_ball_beside_a_pole_is_right_to_rounding():
    """For starts 1e-8 to 0.1 rad from a pole, some of which leave it, tilts and periods are right to rounding."""
    rng = np.random.default_rng(3)
    stay = 0
    for along in (1e-8, 1e-7, 1e-6, 1e-5, 1e-3, 0.1):
        across, offset = rng.uniform(0.2, 0.6), rng.uniform(-0.7, 0.7)
        tilt = (0.5 * math.pi - along) * rng.choice([-1.0, 1.0])
        rates = along * rng.normal(), along * rng.normal(), 1.5 * rng.normal()
        given, _ = start_of("ball", tilt, *rates, across * rng.uniform(0.5, 1.5), across, offset=offset)
        found = reduce(given, "ball")
        with mpmath.workdps(40):
            least, greatest, period = Ball(given).extremes()
        assert found["ending"].tolist() == [BOUNDED]
        # from 1e-8 rad to the other turning point there are 80 panels, and each adds rounding
        assert found["tilt_min"][0] == pytest.approx(least, abs=5e-15), along
        assert found["tilt_max"][0] == pytest.approx(greatest, abs=5e-15), along
        # a ball that leaves the pole lingers there; its energy above the potential is the square of `along`
        assert found["nutation_period"][0] == pytest.approx(period, rel=1e-12 + 1e-19 / along**2), along
        stay += greatest - least < 3.0 * along
    assert 1 <= stay <= 5


def test_a_known_motion_beside_a_pole():
    """A ball released 1e-7 rad from its pole with twice the critical spin agrees with published numbers."""
    given = starts(
        tilt=1.5707962229583714,
        roll_rate=1.5065163766172431,
        offset=0.2,
        axial_moment=0.42,
        transverse_moment=0.38,
    )
    found = reduce(given, "ball")
    leans = [abs(0.5 * math.pi - float(found[name][0])) for name in ("tilt_min", "tilt_max")]
    assert leans[0] / leans[1] == pytest.approx(1.15045, rel=1e-5)
    assert found["nutation_period"][0] == pytest.approx(5.390509, rel=1e-6)


def test_spheroids_beside_a_pole_are_those_of_a_body_in_space():
    """Motions through a pole or 1e-6 to 0.1 rad from it agree: extreme tilts to 1e-10, periods to 1e-7."""
    for number, along in enumerate((0.0, 1e-6, 1e-4, 3e-3, 0.1)):
        for word, lengths, body in BODIES:
            if along == 0.0:
                tilt, rates = 0.4, (2.5, 0.0, 0.0)
            else:
                tilt, rates = 0.5 * math.pi - along, (1e-3 * (number + 1), 1.3, 0.4 + number)
            given, _ = start_of(word, tilt, *rates, body.axial, body.transverse, **lengths)
            found = reduce(given, word)
            least, greatest, period = body.extremes(tilt, *rates)
            assert found["ending"][0] == BOUNDED, (word, along)
            for value, right in ((found["tilt_min"][0], least), (found["tilt_max"][0], greatest)):
                # at a pole the sine of the tilt is flat, so the referee's tilt is known to the root of its
                # error
                assert value == pytest.approx(right, abs=1e-10 if along else 1e-8), (word, along)
            assert found["nutation_period"][0] == pytest.approx(period, rel=1e-7), (word, along)


def test_a_body_that_rolls_end_over_end_turns_at_both_poles():
    """A ball turns uniformly, once per period; a spheroid's time is an integral over the angle."""
    given, _ = start_of("ball", 0.3, 0.7, 0.0, 0.0, 0.4, 0.4)
    found = reduce(given, "ball", fall_tilt=0.1)
    assert found["ending"][0] == BOUNDED
    assert [found["tilt_min"][0], found["tilt_max"][0]] == pytest.approx(
        [-0.5 * math.pi, 0.5 * math.pi], abs=1e-8
    )
    assert found["nutation_period"][0] == pytest.approx(2.0 * math.pi / 0.7, rel=1e-9)
    for flattening in (0.5, -0.5):
        q, (axial, transverse) = 1.0 - flattening, spheroid_moments(flattening)
        given, _ = start_of("spheroid", 0.0, 1.5, 0.0, 0.0, axial, transverse, flattening=flattening)

        def slowness(angle, q=q, transverse=transverse):
            square = math.cos(angle) ** 2 + (q * math.sin(angle)) ** 2
            inertia = transverse + (math.cos(angle) ** 2 + (q * q * math.sin(angle)) ** 2) / square
            kinetic = 0.5 * (1.0 + transverse) * 1.5**2 + 1.0 - math.sqrt(square)
            return math.sqrt(0.5 * inertia / kinetic)

        found = reduce(given, "spheroid")
        assert found["tilt_max"][0] == pytest.approx(0.5 * math.pi, abs=1e-8)
        expected = 4.0 * quad(slowness, 0.0, 0.5 * math.pi, epsabs=1e-12)[0]
        assert found["nutation_period"][0] == pytest.approx(expected, rel=1e-8)


def test_no_tilt_is_a_fall_and_what_is_no_body_is_none():
    """A start near the pole is followed with any fall_tilt; a flattening of 1 or more is invalid."""
    given = starts(tilt=1.5, tilt_rate=1.0, axial_moment=0.4, transverse_moment=0.4)
    for word in ("ball", "spheroid"):
        assert reduce(given, word, fall_tilt=0.5)["ending"].tolist() == [BOUNDED]
    flat = starts(flattening=1.0, axial_moment=0.4, transverse_moment=0.4)
    assert reduce(flat, "spheroid")["ending"].tolist() == [INVALID]
