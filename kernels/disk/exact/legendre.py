"""Tables of the two motions' rates as functions of the tilt, one table per alpha.

Along any motion s = roll_rate + precession_rate sin(tilt) and o = precession_rate cos(tilt) (rates scaled by
sqrt(radius/gravity)) solve ds/dtilt = -o/(1+alpha), do/dtilt = -2s + o tan(tilt). With the stretched tilt
y = atanh(sin(tilt)) and p = o cos(tilt) this is s' = -p/(1+alpha), p' = -2 s sech^2 y: no pole on the real axis, and
the nearest singularities, y = +-i pi/2, are equally far from every real y near upright and farther elsewhere. So
equal panels of Taylor polynomials in y reach every tilt up to 89.9 degrees with one length and one degree. The
transfer matrix has determinant one.

Sources: Chaplygin (1897), Appell (1900), Korteweg (1899); Borisov, Mamaev, Kilin, Regul. Chaotic Dyn. 8 (2003) 201.
"""

import math

import numpy as np

from kernels.jit import kernel, simd
from kernels.native.entry import entry

PANEL = 0.125  # spacing of the panel centres in y; a power of two, so that every centre is exact
REACH = 57  # panels on each side of upright
TERMS = 16  # truncation at 3/4 PANEL is below 1e-18 of the sum (nearest singularity pi/2 away)
PANELS, NODES = 2 * REACH + 1, 4 * REACH + 1
Y_END = (REACH - 0.5) * PANEL  # 89.902 degrees, the last half panel that has a node at its end

# Rows of a panel: Taylor coefficients in x = y - centre, for the values (s, p) of the motion at the centre.
# Potential V = s^2 [SS] + s p [SP] + p^2 [PP] + [ONE]; transfer s(x) = s [S_S] + p [S_P], p(x) = s [P_S] + p [P_P].
SS, SP, PP, ONE, S_S, S_P, P_S, P_P, TILT = range(9)
# One more row, STEP: not a polynomial, but the numbers of the step from the centre before this one to this one. How s
# and p change (the first letter, in parts of the second one), how V changes, and how it does from this centre to the
# end of its panel, both for the values (s, p) where the change begins.
STEP = TILT + 1
ROWS = STEP + 1
DS_S, DS_P, DP_S, DP_P, STEP_SS, STEP_SP, STEP_PP, STEP_ONE, END_SS, END_SP, END_PP, END_ONE = range(12)

# Columns of a node (every half panel, y = i PANEL/2): how far s, p, o are from their upright values c1, c2, c2 (first
# index: of c1, second: of c2), then cos(tilt) - 1 and sin(tilt). Deviations, because near upright the difference of
# two potentials is far smaller than the potentials.
DS1, DS2, DP1, DP2, DO1, DO2, COS1, SIN = range(8)
COLUMNS = 8


@simd
def row_value(panels, panel, row, x):
    """Value at x of one row of one panel. Indices, not slices: a slice costs two atomic counts on a shared line."""
    xx = x * x
    even, odd = panels[panel, row, TERMS - 2], panels[panel, row, TERMS - 1]
    for n in range(TERMS - 4, -1, -2):
        even = even * xx + panels[panel, row, n]
        odd = odd * xx + panels[panel, row, n + 1]
    return even + x * odd


@kernel
def _excess(panels, panel, row, x):
    """`row_value` without the constant term, so that a matrix near the identity keeps its small part."""
    value = panels[panel, row, TERMS - 1]
    for n in range(TERMS - 2, 0, -1):
        value = value * x + panels[panel, row, n]
    return value * x


@kernel
def _product(a, b, out, factor):
    """Add factor times the truncated Taylor product of a and b to `out`."""
    for n in range(TERMS):
        total = 0.0
        for i in range(n + 1):
            total += a[i] * b[n - i]
        out[n] += factor * total


@kernel
def _hyperbolic(y, sech, sech2, tanh, cosh2):
    """Taylor coefficients at y of sech, sech^2, tanh and cosh^2."""
    cosh = math.cosh(y)
    sech[0] = 1.0 / cosh
    sech2[0] = sech[0] * sech[0]
    tanh[0] = math.tanh(y)
    cosh2[0] = cosh * cosh
    power = 1.0
    for n in range(TERMS - 1):
        low, high = 0.0, 0.0
        for i in range(n + 1):
            low -= sech[i] * tanh[n - i]
            high -= 2.0 * sech2[i] * tanh[n - i]
        tanh[n + 1] = sech2[n] / (n + 1)
        sech[n + 1] = low / (n + 1)
        sech2[n + 1] = high / (n + 1)
        cosh2[n + 1] = power * (math.sinh(2.0 * y) if n % 2 == 0 else math.cosh(2.0 * y))
        power *= 2.0 / (n + 2)


@kernel
def _transfer(alpha, sech2, s, p):
    """Complete the Taylor coefficients of a solution (s, p) whose first ones are given."""
    for n in range(TERMS - 1):
        force = 0.0
        for i in range(n + 1):
            force += sech2[i] * s[n - i]
        s[n + 1] = -p[n] / ((1.0 + alpha) * (n + 1))
        p[n + 1] = -2.0 * force / (n + 1)


@kernel
def _potential(alpha, panel, cosh2, work):
    """Fill the potential rows of a panel from its transfer rows: (1+alpha) s^2/2 + (alpha/4) p^2 cosh^2 + sech."""
    for row, i, j, twice in ((SS, 0, 0, 1.0), (SP, 0, 1, 2.0), (PP, 1, 1, 1.0)):
        panel[row] = 0.0
        work[:] = 0.0
        _product(panel[S_S + i], panel[S_S + j], panel[row], 0.5 * twice * (1.0 + alpha))
        _product(panel[P_S + i], panel[P_S + j], work, 0.25 * twice * alpha)
        _product(work, cosh2, panel[row], 1.0)


@kernel
def _panel(alpha, y, panel, work):
    """Fill all rows of the panel centred at y."""
    sech2, tanh, cosh2 = work[0], work[1], work[2]
    _hyperbolic(y, panel[ONE], sech2, tanh, cosh2)
    panel[S_S, 0], panel[P_S, 0], panel[S_P, 0], panel[P_P, 0] = 1.0, 0.0, 0.0, 1.0
    _transfer(alpha, sech2, panel[S_S], panel[P_S])
    _transfer(alpha, sech2, panel[S_P], panel[P_P])
    _potential(alpha, panel, cosh2, work[3])
    panel[TILT, 0] = math.atan(math.sinh(y))
    for n in range(1, TERMS):
        panel[TILT, n] = panel[ONE, n - 1] / n


@kernel
def _node(y, deviation, panels, panel, x, node):
    """Fill the node at y: `deviation` at the panel's centre, carried over x. Returns the deviation there."""
    d11, d12, d21, d22 = deviation
    t11, t12 = _excess(panels, panel, S_S, x), _excess(panels, panel, S_P, x)
    t21, t22 = _excess(panels, panel, P_S, x), _excess(panels, panel, P_P, x)
    e11 = d11 + (t11 + t11 * d11 + t12 * d21)
    e12 = d12 + (t12 + t11 * d12 + t12 * d22)
    e21 = d21 + (t21 + t21 * d11 + t22 * d21)
    e22 = d22 + (t22 + t21 * d12 + t22 * d22)
    cosh, half = math.cosh(y), math.sinh(0.5 * y)
    node[DS1], node[DS2], node[DP1], node[DP2] = e11, e12, e21, e22
    node[DO1] = cosh * e21
    node[DO2] = 2.0 * half * half + cosh * e22
    node[COS1] = -2.0 * half * half / cosh
    node[SIN] = math.tanh(y)
    return e11, e12, e21, e22


@kernel
def _mirror(panels, nodes, panel, node):
    """Fill the negative tilts: under y -> -y, p -> -p the system is unchanged, so the table is bit-symmetric."""
    for k in range(1, REACH + 1):
        for row in range(STEP):
            sign = -1.0 if row in (SP, S_P, P_S, TILT) else 1.0
            for n in range(TERMS):
                panels[panel - k, row, n] = sign * panels[panel + k, row, n]
                sign = -sign
    for i in range(1, 2 * REACH + 1):
        for column in range(COLUMNS):
            sign = -1.0 if column in (DS2, DP1, DO1, SIN) else 1.0
            nodes[node - i, column] = sign * nodes[node + i, column]


@kernel
def _climb(panels, panel, x):
    """V at x minus V at the centre of a panel, as a quadratic form of the rates there."""
    return (
        _excess(panels, panel, SS, x),
        _excess(panels, panel, SP, x),
        _excess(panels, panel, PP, x),
        _excess(panels, panel, ONE, x),
    )


@kernel
def _step(panels, panel):
    """Fill the step to a panel from the one before; V changes up to their common end, and from there on."""
    step, before = panels[panel, STEP], panel - 1
    a, b = _excess(panels, before, S_S, PANEL), _excess(panels, before, S_P, PANEL)
    c, d = _excess(panels, before, P_S, PANEL), _excess(panels, before, P_P, PANEL)
    step[DS_S], step[DS_P], step[DP_S], step[DP_P] = a, b, c, d
    ss, sp, pp, one = _climb(panels, panel, -0.5 * PANEL)
    a, d = 1.0 + a, 1.0 + d
    to_ss, to_sp, to_pp, to_one = _climb(panels, before, 0.5 * PANEL)
    step[STEP_SS] = to_ss - (a * a * ss + a * c * sp + c * c * pp)
    step[STEP_SP] = to_sp - (2.0 * a * b * ss + (a * d + b * c) * sp + 2.0 * c * d * pp)
    step[STEP_PP] = to_pp - (b * b * ss + b * d * sp + d * d * pp)
    step[STEP_ONE] = to_one - one
    step[END_SS], step[END_SP], step[END_PP], step[END_ONE] = _climb(panels, panel, 0.5 * PANEL)


@entry(
    alphas="float64[::1]",
    panels="float64[:, :, ::1], written",
    nodes="float64[:, ::1], written",
    work="float64[:, ::1], written",
)
def build_tables(alphas, panels, nodes, work):
    """Fill the tables of several values of alpha, one after the other.

    Parameters
    ----------
    alphas : (m,) float64
        Mass distribution, in (0, 1].
    panels : (m*PANELS, ROWS, TERMS) float64, out
        Taylor polynomials on panels of the stretched tilt, and steps from one to the next.
    nodes : (m*NODES, COLUMNS) float64, out
        The motion's deviation from its upright values at every half panel.
    work : (4, TERMS) float64
        Memory for intermediate results.
    """
    for a in range(alphas.size):
        panel, node = a * PANELS + REACH, a * NODES + 2 * REACH
        nodes[node] = 0.0
        deviation = (0.0, 0.0, 0.0, 0.0)
        for k in range(REACH + 1):
            y = k * PANEL
            _panel(alphas[a], y, panels[panel + k], work)
            if k < REACH:
                middle, end = nodes[node + 2 * k + 1], nodes[node + 2 * k + 2]
                _node(y + 0.5 * PANEL, deviation, panels, panel + k, 0.5 * PANEL, middle)
                deviation = _node(y + PANEL, deviation, panels, panel + k, PANEL, end)
        _mirror(panels, nodes, panel, node)
        panels[panel - REACH, STEP] = 0.0
        for k in range(1 - REACH, REACH + 1):
            _step(panels, panel + k)


def tables(alphas):
    """Tables for several values of alpha, each in (0, 1]: the pair (panels, nodes) of `build_tables`."""
    alphas = np.ascontiguousarray(alphas, dtype=np.float64)
    panels = np.empty((alphas.size * PANELS, ROWS, TERMS))
    nodes = np.empty((alphas.size * NODES, COLUMNS))
    build_tables(alphas, panels, nodes, np.empty((4, TERMS)))
    return panels, nodes


@kernel
def stretched(sin, cos):
    """Stretched tilt atanh(sin(tilt)), to rounding at every tilt; odd to the last bit."""
    u = abs(sin)
    return math.copysign(0.5 * math.log1p(2.0 * u * (1.0 + u) / (cos * cos)), sin)
