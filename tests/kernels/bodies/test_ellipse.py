"""The geometry of an elliptic meridian, compared with derivatives of its support function."""

import cmath
import math

import numpy as np
import pytest

from kernels.bodies import ellipse, pair
from kernels.bodies.shapes import Body
from kernels.reduction.panels import meridian

#: A spheroid with an offset center of mass, and a ring whose tube is an ellipse.
BODIES = (Body(0.0, 0.2, 1.0, 0.3, 0.4, 0.3, 4.0 / 3.0), Body(0.7, -0.1, 0.3, 2.5, 0.6, 0.4, 1.5))


def support(tilt, body):
    """Return the height of the center of mass, also for a complex tilt."""
    sine, cosine = cmath.sin(tilt), cmath.cos(tilt)
    root = cmath.sqrt(cosine * cosine + body.square * sine * sine)
    return body.core * cosine + body.shift * sine + body.edge * root


def derivatives(tilt, body):
    """Return the height and its two derivatives by a complex step and by a difference of such steps."""

    def slope(there):
        return support(complex(there, 1e-30), body).imag / 1e-30

    return support(tilt, body).real, slope(tilt), (slope(tilt + 1e-5) - slope(tilt - 1e-5)) / 2e-5


def test_the_functions_are_those_of_the_support_function():
    """A = C h - S h', b = -S h - C h', l = -h', r = h + h''."""
    for body in BODIES:
        for tilt in (-1.4, -0.3, 0.0, 0.7, 1.2):
            S, C = math.sin(tilt), math.cos(tilt)
            h, slope, second = derivatives(tilt, body)
            a, b, r = C * h - S * slope, -S * h - C * slope, h + second
            found = meridian(S, C, body)
            assert (found[0], found[1], found[3]) == pytest.approx((a, b, -slope), abs=1e-14)
            assert found[2] == pytest.approx(r, abs=1e-9)


def test_the_series_are_those_functions_along_a_panel():
    """At the end of a panel, the series equal these functions."""
    way = 0.05
    for body in BODIES:
        for y in (-1.0, 0.0, 0.6):
            series = np.zeros((pair.ROWS, pair.TERMS))
            series[pair.SIN, 0], series[pair.COS, 0], series[pair.ALONG, 0] = (
                math.tanh(y),
                1.0 / math.cosh(y),
                1.0,
            )
            radius = np.empty(pair.TERMS)
            for k in range(pair.TERMS):
                ellipse.describe(series, body, k, float(k == 0))
                radius[k] = ellipse.radius_of(series, body, k, float(k == 0))
                across = sum(series[pair.SIN, i] * series[pair.COS, k - i] for i in range(k + 1))
                square = sum(series[pair.COS, i] * series[pair.COS, k - i] for i in range(k + 1))
                if k + 1 < pair.TERMS:
                    series[pair.SIN, k + 1], series[pair.COS, k + 1] = square / (k + 1), -across / (k + 1)
            S, C = math.tanh(y + way), 1.0 / math.cosh(y + way)
            a, b, r, lever = meridian(S, C, body)
            powers = way ** np.arange(pair.TERMS)
            found = [
                float(series[row] @ powers)
                for row in (pair.LONG, pair.WIDE, pair.LEVER, pair.HEIGHT, pair.MIX)
            ]
            expected = [a, b, lever, support(math.asin(S), body).real, r * S + body.ratio * b]
            assert found == pytest.approx(expected, abs=1e-14)
            assert float(radius @ powers) == pytest.approx(r, abs=1e-14)
            inner = [ellipse.evolute_along(series, body, k) for k in range(pair.TERMS)]
            assert float(np.array(inner) @ powers) == pytest.approx(a - r * C, abs=1e-14)
