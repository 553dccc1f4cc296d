import math

import mpmath
import numpy as np
import pytest
from numpy.polynomial.polynomial import polyval

from kernels.disk.exact import legendre
from kernels.disk.exact.legendre import DP1, DP2, DS1, DS2, P_P, P_S, PANEL, REACH, S_P, S_S

# uncompiled, the tables alone take minutes
pytestmark = pytest.mark.compiled

DEGREE = np.pi / 180.0


def basis(panels, nodes, tilt):
    """The even solution (s, o) = (1, 0) at upright and the odd one, (0, 1), of one alpha's table at one tilt [rad]."""
    size, cos = abs(math.sin(tilt)), math.cos(tilt)
    stretched = math.copysign(0.5 * math.log1p(2.0 * size * (1.0 + size) / (cos * cos)), tilt)
    k = round(stretched / PANEL)
    panel, node = panels[REACH + k], nodes[2 * (REACH + k)]
    transfer = [
        [polyval(stretched - k * PANEL, panel[row]) for row in pair] for pair in ((S_S, S_P), (P_S, P_P))
    ]
    at_centre = np.array([[1.0 + node[DS1], node[DS2]], [node[DP1], 1.0 + node[DP2]]])
    (s_even, s_odd), (p_even, p_odd) = transfer @ at_centre
    return s_even, p_even / cos, s_odd, p_odd / cos


def test_basis_functions():
    """Both solutions are Legendre's hypergeometric series, to 1e-14 of each value up to 89.9 degrees."""
    for alpha in [1e-6, 0.3, 0.5, 1.0]:
        panels, nodes = legendre.tables([alpha])
        h = mpmath.mpf(1) / 2
        with mpmath.workdps(30):
            mu = mpmath.sqrt(2 / (1 + mpmath.mpf(alpha)) - mpmath.mpf(1) / 4)
            a, b = mpmath.mpc(0.25, -mu / 2), mpmath.mpc(0.25, mu / 2)
            for tilt in (1e-9, -0.01, 0.0625, 0.5, -0.9, 1.3, -89.0 * DEGREE, 89.9 * DEGREE):
                u, c = mpmath.sin(mpmath.mpf(tilt)), mpmath.cos(mpmath.mpf(tilt))
                even, odd = mpmath.hyp2f1(a, b, h, u * u), mpmath.hyp2f1(a + h, b + h, 3 * h, u * u)
                even_u = 2 * u * a * b / h * mpmath.hyp2f1(a + 1, b + 1, 3 * h, u * u)
                odd_u = odd + 2 * u * u * (a + h) * (b + h) / (3 * h) * mpmath.hyp2f1(
                    a + 3 * h, b + 3 * h, 5 * h, u * u
                )
                exact = (
                    even,
                    -(1 + mpmath.mpf(alpha)) * c * even_u,
                    -u * odd / (1 + mpmath.mpf(alpha)),
                    c * odd_u,
                )
                expected = [float(mpmath.re(x)) for x in exact]
                assert basis(panels, nodes, tilt) == pytest.approx(expected, rel=1e-14), alpha
