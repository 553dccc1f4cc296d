"""The potential of the reduced motion: its panels, its zeros, its saddle (scaled as in `kernels.disk`).

(1+alpha/2)/2 w^2 + V = h with V = (1+alpha)/2 s^2 + (alpha/4) o^2 + cos(tilt), and s, o functions of the tilt alone
(`kernels.legendre`). `y` is the stretched tilt atanh(sin(tilt)); (c1, c2) are the values of (s, o) at upright, the
two constants of a motion; "excess" is V - h, negative where the motion can be.

Sources: Borisov, Mamaev, Kilin, Regul. Chaotic Dyn. 8 (2003) 201; O'Reilly, Nonlinear Dynamics 10 (1996) 287.
"""

import math

from numba import njit

from kernels.disk import CONTRACT
from kernels.legendre import (
    COS1,
    DO1,
    DO2,
    DP1,
    DP2,
    DS1,
    DS2,
    NODES,
    ONE,
    PANEL,
    PANELS,
    PP,
    REACH,
    SIN,
    SP,
    SS,
    TERMS,
)

ROUNDING = 2.0**-53
#: Distance of two nodes.
NODE = 0.5 * PANEL
#: Saddles of V stay below 19.3 degrees for every alpha in (0, 1] (the top of the dome of unstable circling: 17.6 for
#: alpha -> 0, 18.62 disk, 19.20 hoop), which is y = 0.342; six half panels end at 0.375.
_SADDLE_NODES = 6
#: A saddle and a minimum can hide between two nodes; at the nearest node V' is then below NODE^2/2 max|V'''|.
_HIDDEN = 0.016
#: Newton inside a bracket ends by itself; the bound only makes that certain.
_MOST_STEPS = 100


@njit(error_model="numpy", fastmath=CONTRACT)
def value_slope(coef, x):
    """Value and derivative of the polynomial with ascending coefficients, in two halves for shorter chains."""
    xx = x * x
    even, odd, even_slope, odd_slope = coef[TERMS - 2], coef[TERMS - 1], 0.0, 0.0
    for n in range(TERMS - 4, -1, -2):
        even_slope = even_slope * xx + even
        odd_slope = odd_slope * xx + odd
        even = even * xx + coef[n]
        odd = odd * xx + coef[n + 1]
    return even + x * odd, odd + 2.0 * (x * even_slope + xx * odd_slope)


@njit(error_model="numpy", fastmath=CONTRACT)
def value(coef, x):
    """Value of the polynomial with ascending coefficients."""
    xx = x * x
    even, odd = coef[TERMS - 2], coef[TERMS - 1]
    for n in range(TERMS - 4, -1, -2):
        even = even * xx + coef[n]
        odd = odd * xx + coef[n + 1]
    return even + x * odd


@njit(error_model="numpy", fastmath=CONTRACT)
def slopes(coef, x):
    """First and second derivative of the polynomial with ascending coefficients; even and odd halves, as in `value`."""
    xx = x * x
    even, odd = (TERMS - 2) * coef[TERMS - 2], (TERMS - 1) * coef[TERMS - 1]
    even_slope, odd_slope = 0.0, 0.0
    for n in range(TERMS - 4, 0, -2):
        even_slope = even_slope * xx + even
        odd_slope = odd_slope * xx + odd
        even = even * xx + n * coef[n]
        odd = odd * xx + (n + 1) * coef[n + 1]
    odd_slope = odd_slope * xx + odd
    odd = odd * xx + coef[1]
    return odd + x * even, even + 2.0 * (xx * even_slope + x * odd_slope)


@njit(error_model="numpy", fastmath=CONTRACT)
def expand(panels, panel, s, p, out):
    """V as a polynomial on one panel, for the motion with (s, p) at the panel's centre."""
    ss, sp, pp = s * s, s * p, p * p
    # a length unknown to the compiler makes a vector loop; 16 known terms it writes out one by one
    for n in range(out.size):
        out[n] = (
            ss * panels[panel, SS, n]
            + sp * panels[panel, SP, n]
            + pp * panels[panel, PP, n]
            + panels[panel, ONE, n]
        )


@njit(error_model="numpy", fastmath=CONTRACT)
def rise(alpha, nodes, node, c1, c2):
    """V at a node minus V at upright, as a sum of differences: near upright far smaller than the potentials."""
    ds = nodes[node, DS1] * c1 + nodes[node, DS2] * c2
    do = nodes[node, DO1] * c1 + nodes[node, DO2] * c2
    rolling = 0.5 * (1.0 + alpha) * ds * (2.0 * c1 + ds)
    return rolling + 0.25 * alpha * do * (2.0 * c2 + do) + nodes[node, COS1]


@njit(error_model="numpy", fastmath=CONTRACT)
def expand_excess(alpha, table, panels, nodes, k, c1, c2, base, out):
    """Excess on panel k as a polynomial in the distance from its centre; `base` is h minus V at upright."""
    panel, node = table * PANELS + REACH + k, table * NODES + 2 * (REACH + k)
    s = c1 + (nodes[node, DS1] * c1 + nodes[node, DS2] * c2)
    p = c2 + (nodes[node, DP1] * c1 + nodes[node, DP2] * c2)
    expand(panels, panel, s, p, out)
    out[0] = rise(alpha, nodes, node, c1, c2) - base


@njit(error_model="numpy", fastmath=CONTRACT)
def shift(coef, x):
    """Move the expansion point of a polynomial by x, in place (repeated synthetic division)."""
    for i in range(TERMS - 1):
        for n in range(TERMS - 2, i - 1, -1):
            coef[n] += x * coef[n + 1]


@njit(error_model="numpy", fastmath=CONTRACT)
def zero(coef, inner, outer, guess, scale):
    """Root of a polynomial, negative at `inner`, positive at `outer`, and its slope there: Newton in a bracket.

    Exact to the rounding of numbers of size `scale`. At a nearly double root Newton only halves its distance at each
    step until it sees the two roots apart; the bracket keeps it on the right side.
    """
    x, last, last_slope = guess, math.inf, math.nan
    for _ in range(_MOST_STEPS):
        here, slope = value_slope(coef, x)
        if here > 0.0:
            outer = x
        else:
            inner = x
        step = here / slope
        new = x - step
        if not (new - inner) * (new - outer) <= 0.0:
            new = 0.5 * (inner + outer)
            step, last = x - new, math.inf
        # What Newton leaves is step^2 V''/(2 V'), and the last two slopes tell V'': it saves one evaluation.
        left = abs(step) if math.isinf(last) else abs(step * step * (slope - last_slope) / (last * slope))
        if min(left, abs(step)) <= ROUNDING * (2.0 * abs(x) + scale):
            return new, slope if math.isinf(last) else slope + step * (slope - last_slope) / last
        x, last, last_slope = new, step, slope
    return x, last_slope


@njit(error_model="numpy", fastmath=CONTRACT)
def _climb(alpha, nodes, node, c1, c2):
    """Slope dV/dy at a node."""
    s = c1 + (nodes[node, DS1] * c1 + nodes[node, DS2] * c2)
    o = c2 + (nodes[node, DO1] * c1 + nodes[node, DO2] * c2)
    cos, sin = 1.0 + nodes[node, COS1], nodes[node, SIN]
    return 0.5 * alpha * sin * o * o - cos * ((1.0 + alpha) * s * o + sin)


@njit(error_model="numpy", fastmath=CONTRACT)
def _slopes_at(alpha, table, panels, nodes, t, middle, side, c1, c2, out):
    """V' and V'' at the distance t from upright towards `side`, on the panel that holds the distance `middle`."""
    k = side * ((int(middle / NODE) + 1) // 2)
    expand_excess(alpha, table, panels, nodes, k, c1, c2, 0.0, out)
    return slopes(out, side * t - k * PANEL)


@njit(error_model="numpy", fastmath=CONTRACT)
def _flattest(alpha, table, panels, nodes, side, node, c1, c2, out):
    """Distance from upright where V' is least, between a node's neighbours: by bisection, for it is rarely wanted."""
    low, high = max(node - 1, 0) * NODE, (node + 1) * NODE
    for _ in range(60):
        t = 0.5 * (low + high)
        if _slopes_at(alpha, table, panels, nodes, t, t, side, c1, c2, out)[1] < 0.0:
            low = t
        else:
            high = t
    return high


@njit(error_model="numpy", fastmath=CONTRACT)
def _summit(alpha, table, panels, nodes, side, inner, outer, guess, c1, c2, out):
    """Maximum of V between two distances from upright on one half panel: Newton on V' kept inside the bracket."""
    t = guess
    k = side * ((int(0.5 * (inner + outer) / NODE) + 1) // 2)
    expand_excess(alpha, table, panels, nodes, k, c1, c2, 0.0, out)
    for _ in range(_MOST_STEPS):
        first, second = slopes(out, side * t - k * PANEL)
        if side * first < 0.0:
            outer = t
        else:
            inner = t
        new = t - side * first / second
        if not (new - inner) * (new - outer) <= 0.0:
            new = 0.5 * (inner + outer)
        # V is flat there: half of the digits of the saddle's tilt are all of the digits of its height
        if abs(new - t) <= 1e-5 * t:
            return side * new
        t = new
    return side * t


@njit(error_model="numpy", fastmath=CONTRACT)
def saddle(alpha, table, panels, nodes, c1, c2, out):
    """Stretched tilt of the maximum of V; NaN if V has one well only.

    V has one well unless V'' < 0 at upright (checked along the whole curve of folds). The maximum lies on the side on
    which V rises from upright; with c1 c2 = 0 it is upright itself.
    """
    if not 2.0 * (1.0 + alpha) * c1 * c1 + (1.0 + 0.5 * alpha) * c2 * c2 < 1.0:
        return math.nan
    if c1 * c2 == 0.0:
        return 0.0
    side = -1 if c1 * c2 > 0.0 else 1
    upright = table * NODES + 2 * REACH
    before = least = (1.0 + alpha) * abs(c1 * c2)
    where = 0
    for i in range(1, _SADDLE_NODES + 1):
        climb = side * _climb(alpha, nodes, upright + side * i, c1, c2)
        if climb < 0.0:
            guess = (i - 1 + before / (before - climb)) * NODE
            return _summit(alpha, table, panels, nodes, side, (i - 1) * NODE, i * NODE, guess, c1, c2, out)
        before = climb
        if climb < least:
            least, where = climb, i
    if least > _HIDDEN:
        return math.nan
    dip = _flattest(alpha, table, panels, nodes, side, where, c1, c2, out)
    if not side * _slopes_at(alpha, table, panels, nodes, dip, dip, side, c1, c2, out)[0] < 0.0:
        return math.nan
    inner = where * NODE if dip > where * NODE else (where - 1) * NODE
    return _summit(alpha, table, panels, nodes, side, inner, dip, 0.5 * (inner + dip), c1, c2, out)
