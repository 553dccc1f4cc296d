"""Tables of the potential on wide panels, one table per alpha, for quadratures over a whole swing.

On a panel the stretched tilt is y = centre + 2 atanh(w). The map takes the strip |Im y| < pi/2, in which a motion's
rates have no singularity (`kernels.disk.exact.legendre`), to the unit disc |w| < 1, so that a Taylor series about any
centre converges for every tilt, as fast as powers of w. Neither tilt nor potential need another function:
cos(tilt) = (1 - w^2)/q and dtilt = 2 dw/q, with q = cosh(centre) (1 + w^2) + 2 sinh(centre) w.

Of s and o as in `kernels.disk.exact.legendre`, the products S = s^2, Z = s o, O = o^2 obey
q S' = -4 Z/(1+alpha), q (1-w^2) Z' = 2 g Z - 2 (1-w^2) (O/(1+alpha) + 2 S), q (1-w^2) O' = 4 g O - 8 (1-w^2) Z with
g = sinh(centre) (1 + w^2) + 2 cosh(centre) w: recurrences of five terms. Source of the equations: as there.
"""

import math

import numpy as np

from kernels.disk.exact.legendre import PANEL, REACH
from kernels.jit import kernel
from kernels.native.entry import entry

#: Panels of `kernels.disk.exact.legendre` from centre to centre, and the distance in y.
STRIDE = 4
SPACING = STRIDE * PANEL
#: Centres on each side of upright: the last one is at 89.9 degrees.
SIDE = REACH // STRIDE
CENTRES = 2 * SIDE + 1
#: Truncation is below rounding, of the second derivative too, up to |w| = 0.38, 0.8 in y from the centre.
WIDE_TERMS = 42

#: Rows of a panel, as in `kernels.disk.exact.legendre`: V = s^2 [W_SS] + s p [W_SP] + p^2 [W_PP] + [W_ONE].
W_SS, W_SP, W_PP, W_ONE = range(4)
WIDE_ROWS = W_ONE + 1


@kernel
def _before(series, n):
    """Coefficient n of a series; zero for negative n."""
    return series[n] if n >= 0 else 0.0


@kernel
def _products(alpha, cosh, sinh, S, Z, O):
    """Complete the Taylor coefficients of S, Z and O whose first ones are given."""
    share = 1.0 / (1.0 + alpha)
    for n in range(WIDE_TERMS - 1):
        Z_1, Z_2, O_1, O_2 = _before(Z, n - 1), _before(Z, n - 2), _before(O, n - 1), _before(O, n - 2)
        slope = -4.0 * share * Z[n] - 2.0 * sinh * n * S[n] - cosh * (n - 1) * _before(S, n - 1)
        pull = share * (O[n] - O_2) + 2.0 * (S[n] - _before(S, n - 2))
        # q (1 - w^2) = cosh + 2 sinh w - 2 sinh w^3 - cosh w^4
        bent_z = 2.0 * (sinh * (Z[n] + Z_2) + 2.0 * cosh * Z_1) - 2.0 * pull
        bent_z += 2.0 * sinh * ((n - 2) * Z_2 - n * Z[n]) + cosh * (n - 3) * _before(Z, n - 3)
        bent_o = 4.0 * (sinh * (O[n] + O_2) + 2.0 * cosh * O_1) - 8.0 * (Z[n] - Z_2)
        bent_o += 2.0 * sinh * ((n - 2) * O_2 - n * O[n]) + cosh * (n - 3) * _before(O, n - 3)
        every = 1.0 / (cosh * (n + 1))
        S[n + 1], Z[n + 1], O[n + 1] = slope * every, bent_z * every, bent_o * every


@kernel
def _wide_panel(alpha, y, panel, work):
    """Fill the rows of the panel centred at y."""
    cosh, sinh = math.cosh(y), math.sinh(y)
    S, Z, O = work[0], work[1], work[2]
    for row in range(W_ONE):
        S[0], Z[0], O[0] = 0.0, 0.0, 0.0
        work[row, 0] = cosh**row
        _products(alpha, cosh, sinh, S, Z, O)
        for n in range(WIDE_TERMS):
            panel[row, n] = 0.5 * (1.0 + alpha) * S[n] + 0.25 * alpha * O[n]
    one = panel[W_ONE]
    for n in range(WIDE_TERMS):
        constant = 1.0 if n == 0 else (-1.0 if n == 2 else 0.0)
        one[n] = (constant - 2.0 * sinh * _before(one, n - 1)) / cosh - _before(one, n - 2)


@entry(alphas="float64[::1]", wide="float64[:, :, ::1], written", work="float64[:, ::1], written")
def build_wide_panels(alphas, wide, work):
    """Fill the wide panels of several values of alpha, one after the other.

    Parameters
    ----------
    alphas : (m,) float64
        Mass distribution, in (0, 1].
    wide : (m*CENTRES, WIDE_ROWS, WIDE_TERMS) float64, out
        Taylor polynomials in w on panels whose centres are multiples of SPACING.
    work : (3, WIDE_TERMS) float64
        Memory for intermediate results.
    """
    for a in range(alphas.size):
        for k in range(-SIDE, SIDE + 1):
            _wide_panel(alphas[a], k * SPACING, wide[a * CENTRES + SIDE + k], work)


def wide_panels(alphas):
    """Wide panels of several values of alpha, each in (0, 1], as `build_wide_panels` fills them."""
    wide = np.empty((alphas.size * CENTRES, WIDE_ROWS, WIDE_TERMS))
    build_wide_panels(alphas, wide, np.empty((3, WIDE_TERMS)))
    return wide


def no_wide_panels():
    """What takes the place of `wide_panels` where no period is asked for: nothing has to be compiled for it."""
    return np.empty((0, WIDE_ROWS, WIDE_TERMS))
