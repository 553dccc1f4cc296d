"""Panels of a body: the linear pair of its motions and the climb of their potential, as power series of the tilt.

In the stretched tilt y, where dtilt = cos(tilt) dy and sin(tilt) = tanh(y), the spin s and p = o cos(tilt) of any
motion obey a linear system without a pole on the real axis:

    ds/dy = (a A/D) (g s - f p),    dp/dy = -(I/A) C^2 s + (b I/D) C (g s - f p),
    f = a - r C,    g = (r S + (I/A) b) C,

and the potential V = A o^2/2 + I s^2/2 + v^2/2 + h of the motion has the slope

    dV/dy = -C l - (I + a^2 - a b T) s p + ((A + b^2) T - a b)/C p^2.

The letters are the same as in `kernels.bodies.equations`. A panel is an interval of y. Its series depend only on the
body, so all cells with the same body share them. The shape enters only through the meridian (a, b, r, l), also near
the real axis. Panels are at y > 0; panels at negative tilts are those of the mirror image of the body.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from kernels.bodies.shapes import Body
from kernels.jit import kernel

#: Number of terms of a series; maximum number of panels on one side.
TERMS, REACH = 16, 192

#: Longest panel; longest panel over its distance from a singularity of the body.
LONGEST, _SHARE = 0.25, 0.16

#: The stretched tilt that counts as a pole: the cosine of the tilt is below 1e-17 there.
POLE = 40.0

#: Rows of a panel: coefficients of the powers of x, which is -1 and 1 at the ends. The pair at x, from the pair at
#: the centre: s = s_0 [S_S] + p_0 [S_P], p = s_0 [P_S] + p_0 [P_P]. The climb of the potential from the centre, without
#: its constant term: V(x) - V(0) = s_0^2 [SS] + s_0 p_0 [SP] + p_0^2 [PP] + [ONE].
S_S, S_P, P_S, P_P, SS, SP, PP, ONE = range(8)

#: One more row holds numbers: half of the length; the matrices that carry (s, p) from the centre to the outer and to
#: the inner end, and back; the climb from end to end; the bound of the second derivative of the climb, for 1, s_0^2
#: and p_0^2; the slope dV/dy at both ends, for 1, s p and p^2 there.
NUMBERS = 8
HALF, TO_OUTER, TO_INNER, FROM_OUTER, FROM_INNER, CLIMB, MOST_BEND, OUTER_SLOPE, INNER_SLOPE = (
    0, 1, 5, 9, 13, 17, 21, 24, 27,
)  # fmt: skip
_ROWS, _COLUMNS = 9, 30

#: Numbers of a body in `Table.bodies`.
_OF_A_BODY = len(Body._fields)

# The coefficients come from Cauchy's integral over a circle of twice the length of a panel, at 13 points of its upper
# half: the error of coefficient n from rounding falls as 2^-n.
_POINTS, _CIRCLE = 13, 2.0
_ANGLES = np.pi / (_POINTS - 1) * np.arange(_POINTS)
_X = _CIRCLE * np.exp(1j * _ANGLES)
_WEIGHTS = np.where((np.arange(_POINTS) % (_POINTS - 1)) == 0, 0.5, 1.0) / (_POINTS - 1)
_TO_SERIES = (
    _CIRCLE ** -np.arange(TERMS)[:, None] * np.exp(-1j * np.arange(TERMS)[:, None] * _ANGLES) * _WEIGHTS
)
_SINH, _COSH = np.sinh(0.5 * LONGEST * _X), np.cosh(0.5 * LONGEST * _X)
_REAL, _IMAGINARY = np.ascontiguousarray(_TO_SERIES.real.T), np.ascontiguousarray(_TO_SERIES.imag.T)


class Table(NamedTuple):
    """The panels of one body, made when they are first needed.

    Attributes
    ----------
    bodies : float64[2, len(Body)]
        The body and its mirror image.
    edges : float64[REACH + 1]
        Where panels begin and end, in y.
    made : int64[2, REACH]
        Whether a panel of the body, or of its mirror image, has been made.
    panels : float64[2, REACH, rows, columns]
    work : float64[8, TERMS]
    """

    bodies: Any
    edges: Any
    made: Any
    panels: Any
    work: Any


#: Types of the arrays of a `Table`, for entry points.
TABLE_TYPES = {
    "bodies": "float64[:, ::1]",
    "edges": "float64[::1]",
    "made": "int64[:, ::1]",
    "panels": "float64[:, :, :, ::1]",
    "work": "float64[:, ::1]",
}


def table_memory():
    """Return the arrays of a `Table`, uninitialised: call `clear_table` before use."""
    return (
        np.empty((2, _OF_A_BODY)), np.empty(REACH + 1), np.empty((2, REACH), np.int64),
        np.empty((2, REACH, _ROWS, _COLUMNS)), np.empty((8, TERMS)),
    )  # fmt: skip


@kernel
def body_on(table, side):
    """Return the `Body` of a side of a table."""
    row = table.bodies[side]
    return Body(row[0], row[1], row[2], row[3], row[4], row[5], row[6])


@kernel
def _meridian_of(S, C, n, body):
    """Return `meridian`, from n = 1/sqrt(C^2 + square S^2)."""
    flat = body.edge * body.square * n
    lever = body.core * S - body.shift * C + body.edge * (1.0 - body.square) * n * S * C
    return body.core + body.edge * n * C, -body.shift - flat * S, flat * n * n, lever


@kernel
def meridian(S, C, body):
    """Return (a, b, r, l): levers along and across the axis, radius of curvature, lever of the weight."""
    n = 1.0 / math.sqrt(1.0 - (1.0 - body.square) * S * S)
    return _meridian_of(S, C, n, body)


@kernel
def _slope_of(a, b, lever, S, C, sec, body):
    """Return `slope_terms`, from sec = 1/C."""
    T = S * sec
    return -C * lever, -(body.axial + a * (a - b * T)), ((body.transverse + b * b) * T - a * b) * sec


@kernel
def slope_terms(S, C, body):
    """Return the coefficients of 1, s p and p^2 in the slope dV/dy."""
    a, b, _, lever = meridian(S, C, body)
    return _slope_of(a, b, lever, S, C, 1.0 / C, body)


@kernel
def _inverse(z):
    """Return 1/z, by a division of complex numbers without scaling."""
    per = 1.0 / (z.real * z.real + z.imag * z.imag)
    return complex(z.real * per, -z.imag * per)


@kernel
def _inverse_root(z):
    """Return 1/sqrt(z), for z whose real part is not much below 0."""
    size = math.sqrt(z.real * z.real + z.imag * z.imag)
    real = math.sqrt(0.5 * (size + z.real))
    return _inverse(complex(real, 0.5 * z.imag / real))


@kernel
def _hyperbolic(z):
    """Return (sinh(z), cosh(z))."""
    sinh, cosh, sine, cosine = math.sinh(z.real), math.cosh(z.real), math.sin(z.imag), math.cos(z.imag)
    return complex(sinh * cosine, cosh * sine), complex(cosh * cosine, sinh * sine)


@kernel
def _expand_body(centre, half, body, work):
    """Write the series of the linear system and of the slope about a centre into the first seven rows of `work`."""
    S_0, C_0 = math.tanh(centre), 1.0 / math.cosh(centre)
    A, I = body.transverse, body.axial
    work[:7] = 0.0
    for j in range(_POINTS):
        sinh, cosh = _SINH[j], _COSH[j]
        if half != 0.5 * LONGEST:
            sinh, cosh = _hyperbolic(half * _X[j])
        over = cosh + S_0 * sinh
        per, sec = _inverse(over), over / C_0
        S, C, n = (S_0 * cosh + sinh) * per, C_0 * per, complex(1.0, 0.0)
        if body.square != 1.0:
            n = _inverse_root(1.0 - (1.0 - body.square) * S * S)
        a, b, r, lever = _meridian_of(S, C, n, body)
        constant, mixed, square = _slope_of(a, b, lever, S, C, sec, body)
        per = _inverse(I * (A + b * b) + A * a * a)
        f, g, along, across = a - r * C, (r * S + body.ratio * b) * C, a * A * per, b * I * C * per
        values = (
            along * g, -along * f, across * g - body.ratio * C * C, -across * f, constant, mixed, square,
        )  # fmt: skip
        for i in range(7):
            for k in range(TERMS):
                work[i, k] += values[i].real * _REAL[j, k] - values[i].imag * _IMAGINARY[j, k]


@kernel
def _fill_transfer(half, panel, work):
    """Fill the rows of the pair: the power series of two solutions."""
    for row in range(4):
        panel[row, 0] = 1.0 if row == S_S or row == P_P else 0.0
    for n in range(TERMS - 1):
        for s, p in ((S_S, P_S), (S_P, P_P)):
            ds = dp = 0.0
            for i in range(n + 1):
                ds += work[0, i] * panel[s, n - i] + work[1, i] * panel[p, n - i]
                dp += work[2, i] * panel[s, n - i] + work[3, i] * panel[p, n - i]
            panel[s, n + 1], panel[p, n + 1] = half / (n + 1) * ds, half / (n + 1) * dp


@kernel
def _add_product(one, other, factor, out):
    for i in range(TERMS):
        share = factor * one[i]
        for n in range(TERMS - i):
            out[i + n] += share * other[n]


@kernel
def _fill_climb(half, panel, work):
    """Fill the rows of the climb: integrals of the slope."""
    mixed, square, product = work[5], work[6], work[7]
    for row, s1, s2, p1, p2 in (
        (SS, S_S, S_S, P_S, P_S), (SP, S_S, S_P, P_S, P_P), (PP, S_P, S_P, P_P, P_P)
    ):  # fmt: skip
        panel[row, :TERMS] = 0.0
        twice = 1.0 if row == SP else 0.5
        product[:] = 0.0
        _add_product(panel[s1], panel[p2], twice, product)
        _add_product(panel[s2], panel[p1], twice, product)
        _add_product(product, mixed, 1.0, panel[row])
        product[:] = 0.0
        _add_product(panel[p1], panel[p2], 2.0 * twice, product)
        _add_product(product, square, 1.0, panel[row])
    for n in range(TERMS):
        panel[ONE, n] = half / (n + 1) * work[4, n]
        for row in (SS, SP, PP):
            panel[row, n] *= half / (n + 1)


@kernel
def _fill_end(x, y, to, back, slope, body, panel):
    """Fill the numbers of one end of a panel."""
    numbers = panel[NUMBERS]
    for i in range(4):
        numbers[to + i] = 0.0
        for n in range(TERMS - 1, -1, -1):
            numbers[to + i] = numbers[to + i] * x + panel[i, n]
    a, b, c, d = numbers[to], numbers[to + 1], numbers[to + 2], numbers[to + 3]
    size = a * d - b * c
    numbers[back], numbers[back + 1] = d / size, -b / size
    numbers[back + 2], numbers[back + 3] = -c / size, a / size
    numbers[slope], numbers[slope + 1], numbers[slope + 2] = slope_terms(
        math.tanh(y), 1.0 / math.cosh(y), body
    )


@kernel
def _fill_bounds(panel):
    """Fill the climb from end to end and the bound of its second derivative."""
    numbers = panel[NUMBERS]
    numbers[MOST_BEND : MOST_BEND + 3] = 0.0
    for i in range(4):
        climb = bend = 0.0
        for n in range(TERMS):
            # the column n belongs to the power n + 1
            climb += 2.0 * panel[SS + i, n] if n % 2 == 0 else 0.0
            bend += n * (n + 1) * abs(panel[SS + i, n])
        numbers[CLIMB + i] = climb
        if i == 3:
            numbers[MOST_BEND] += bend
        else:
            # |s p| is at most half the sum of both squares
            numbers[MOST_BEND + 1] += (1.0, 0.5, 0.0)[i] * bend
            numbers[MOST_BEND + 2] += (0.0, 0.5, 1.0)[i] * bend


@kernel
def need_panel(table, side, k):
    """Make panel k of a side, unless it has been made."""
    if table.made[side, k] == 0:
        low, high, body, panel = (
            table.edges[k],
            table.edges[k + 1],
            body_on(table, side),
            table.panels[side, k],
        )
        half = 0.5 * (high - low)
        _expand_body(low + half, half, body, table.work)
        _fill_transfer(half, panel, table.work)
        _fill_climb(half, panel, table.work)
        panel[NUMBERS, HALF] = half
        _fill_end(1.0, high, TO_OUTER, FROM_OUTER, OUTER_SLOPE, body, panel)
        _fill_end(-1.0, low, TO_INNER, FROM_INNER, INNER_SLOPE, body, panel)
        _fill_bounds(panel)
        table.made[side, k] = 1


@kernel
def panel_at(table, y):
    """Return the number of the panel at y >= 0, or REACH beyond the last one."""
    k = min(int(y * (1.0 / LONGEST)), REACH)
    while k < REACH and table.edges[k + 1] <= y:
        k += 1
    return k


@kernel
def clear_table(table):
    """Empty a table, so that it belongs to no body."""
    table.bodies[:] = math.nan


@kernel
def _place_edges(table, body):
    """Place the edges of panels, closer to each other near singularities of the body close to the real axis."""
    A, I, square, away, beside = body.transverse, body.axial, body.square, 0.5 * math.pi, 0.0
    # for a prolate body, a zero of D near upright
    excess = I * (square * square + A * (square - 1.0)) - A
    if body.core == 0.0 and excess > 0.0:
        away = min(away, math.atan(math.sqrt(A * (1.0 + I) / excess)))
        beside = abs(body.shift) / square
    table.edges[0] = 0.0
    for k in range(REACH):
        begin = table.edges[k]
        table.edges[k + 1] = begin + min(LONGEST, _SHARE * math.hypot(max(0.0, begin - beside), away))


@kernel
def take_body(table, body):
    """Give a table to a body, unless it already belongs to it."""
    same = True
    for i in range(_OF_A_BODY):
        same &= table.bodies[0, i] == body[i]
    if same:
        return
    for i in range(_OF_A_BODY):
        table.bodies[0, i] = table.bodies[1, i] = body[i]
    table.bodies[1, 1] = -body.shift
    table.made[:] = 0
    _place_edges(table, body)


@kernel
def pair_at(table, side, k, x, s, p):
    """Return (s, p) at x of a panel, from (s, p) at its centre."""
    panel, s_there, p_there = table.panels[side, k], 0.0, 0.0
    for n in range(TERMS - 1, -1, -1):
        s_there = s_there * x + (s * panel[S_S, n] + p * panel[S_P, n])
        p_there = p_there * x + (s * panel[P_S, n] + p * panel[P_P, n])
    return s_there, p_there


@kernel
def pair_at_centre(table, side, k, x, s, p):
    """Return (s, p) at the centre of a panel, from (s, p) at x."""
    panel = table.panels[side, k]
    ss = sp = ps = pp = 0.0
    for n in range(TERMS - 1, -1, -1):
        ss, sp = ss * x + panel[S_S, n], sp * x + panel[S_P, n]
        ps, pp = ps * x + panel[P_S, n], pp * x + panel[P_P, n]
    size = ss * pp - sp * ps
    return (pp * s - sp * p) / size, (ss * p - ps * s) / size
