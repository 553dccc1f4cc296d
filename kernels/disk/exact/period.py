"""The nutation period of a bounded motion: a quadrature between its two turning points (scaled).

A motion is the tuple (alpha, table, y0, k0, x0, c1, c2, base): the stretched tilt y0 of the start, x0 from the centre
of panel k0; the rates c1, c2 at upright; h minus V at upright. `near` is its excess about the start, `work` scratch for
the excess on another panel.
"""

import math

from kernels.disk.exact.legendre import (
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
    SP,
    SS,
    row_value,
)
from kernels.disk.exact.polynomial import slopes, value
from kernels.disk.exact.potential import NEAR, rise, rise_at
from kernels.jit import internal

_FEWEST, _MOST = 16, 1 << 14
#: Two successive trapezoidal sums may differ by this much; the error is then nearer to its square (1e-11 measured).
_AGREEMENT = 1e-7


@internal
def _expand_excess(alpha, table, panels, nodes, k, c1, c2, base, out):
    """Excess on panel k as a polynomial in the distance from its centre; `base` is h minus V at upright."""
    panel, node = table * PANELS + REACH + k, table * NODES + 2 * (REACH + k)
    s = c1 + (nodes[node, DS1] * c1 + nodes[node, DS2] * c2)
    p = c2 + (nodes[node, DP1] * c1 + nodes[node, DP2] * c2)
    ss, sp, pp = s * s, s * p, p * p
    # a length unknown to the compiler makes a vector loop; 16 known terms it writes out one by one
    for n in range(out.size):
        out[n] = (
            ss * panels[panel, SS, n]
            + sp * panels[panel, SP, n]
            + pp * panels[panel, PP, n]
            + panels[panel, ONE, n]
        )
    out[0] = rise(alpha, rise_at(nodes, node), c1, c2) - base


@internal
def _kinetic_and_cos(motion, panels, nodes, near, work, held, dy):
    """-excess and cos(tilt) at the distance dy in y from the start, and the panel that `work` holds now."""
    alpha, table, y0, k0, x0, c1, c2, base = motion
    k, x = k0, x0 + dy
    if abs(x) <= NEAR:
        excess = value(near, 0, 1, dy)
    else:
        k = int(round((y0 + dy) / PANEL))
        x = (y0 - k * PANEL) + dy
        if k != held:
            _expand_excess(alpha, table, panels, nodes, k, c1, c2, base, work)
            held = k
        excess = value(work, 0, 1, x)
    return -excess, row_value(panels, table * PANELS + REACH + k, ONE, x), held


@internal
def _end(y, slope, half, stretch):
    """Limit of the integrand at a turning point: 0/0 there."""
    return math.sqrt(2.0 * half * stretch / abs(slope)) / math.cosh(y)


@internal
def _trapezoid(motion, panels, nodes, near, work, ends, full, anchor, sign, width, middle, half):
    """Integral of dtilt/sqrt(-excess) over a in [0, pi] (`full`) or [0, pi/2], u = middle + half cos(a).

    dy = anchor + width sinh(u) (full) or anchor + sign 2 width sinh(u/2)^2. The integrand is smooth, even and
    periodic in a, so the error squares at each doubling. NaN if 16384 intervals do not do.
    """
    n, step, before, held = 1, math.pi if full else 0.5 * math.pi, math.inf, REACH + 1
    total = ends
    while n < _MOST:
        for i in range(n):
            angle = (i + 0.5) * step
            u = middle + half * math.cos(angle)
            if width == 0.0:
                dy, stretch = u, 1.0
            elif full:
                sinh = math.sinh(u)
                dy, stretch = anchor + width * sinh, width * math.sqrt(1.0 + sinh * sinh)
            else:
                sinh = math.sinh(0.5 * u)
                dy = anchor + sign * 2.0 * width * sinh * sinh
                stretch = 2.0 * width * sinh * math.sqrt(1.0 + sinh * sinh)
            kinetic, cos, held = _kinetic_and_cos(motion, panels, nodes, near, work, held, dy)
            total += cos * stretch * half * math.sin(angle) / math.sqrt(kinetic)
        n *= 2
        step *= 0.5
        now = total * step
        if n >= _FEWEST and abs(now - before) <= _AGREEMENT * now:
            return now
        before = now
    return math.nan


@internal
def period(motion, panels, nodes, near, work, dy1, slope1, dy2, slope2, top, height):
    """Scaled nutation period: 2 int dtilt/w with w^2 = -4 excess/(2 + alpha).

    Near a separatrix the motion is slow at the saddle `top`, where the integrand has a pair of poles or a second root
    near the interval. The substitution dy = width sinh(u) about the saddle (motion over it) or width cosh(u) (motion
    that turns before it) makes the integrand smooth, with widths for which a parabolic saddle is integrated exactly:
    the cost grows like the logarithm of the distance from the separatrix.
    """
    alpha, table, y0, k0, x0, c1, c2, base = motion
    factor = math.sqrt(2.0 + alpha)
    if math.isnan(top):
        half = 0.5 * abs(dy1 - dy2)
        ends = 0.5 * (_end(y0 + dy1, slope1, half, 1.0) + _end(y0 + dy2, slope2, half, 1.0))
        middle = 0.5 * (dy1 + dy2)
        return factor * _trapezoid(motion, panels, nodes, near, work, ends, True, 0.0, 1.0, 0.0, middle, half)
    away = top - y0
    if height < 0.0:
        k = int(round(top / PANEL))
        _expand_excess(alpha, table, panels, nodes, k, c1, c2, base, work)
        width = math.sqrt(2.0 * height / slopes(work, 0, 1, top - k * PANEL)[1])
        u1, u2 = math.asinh((dy1 - away) / width), math.asinh((dy2 - away) / width)
        half = 0.5 * abs(u1 - u2)
        ends = 0.5 * _end(y0 + dy1, slope1, half, math.hypot(width, dy1 - away))
        ends += 0.5 * _end(y0 + dy2, slope2, half, math.hypot(width, dy2 - away))
        middle = 0.5 * (u1 + u2)
        return factor * _trapezoid(
            motion, panels, nodes, near, work, ends, True, away, 1.0, width, middle, half
        )
    if abs(dy1 - away) > abs(dy2 - away):
        dy1, slope1, dy2, slope2 = dy2, slope2, dy1, slope1
    width, sign = abs(dy1 - away), math.copysign(1.0, dy2 - dy1)
    sinh = math.sqrt(0.5 * abs(dy2 - dy1) / width)
    half = 2.0 * math.asinh(sinh)
    stretch = 2.0 * width * sinh * math.sqrt(1.0 + sinh * sinh)
    ends = 0.5 * _end(y0 + dy2, slope2, half, stretch)
    ends += 0.5 * half * math.sqrt(2.0 * width / abs(slope1)) / math.cosh(y0 + dy1)
    return factor * _trapezoid(motion, panels, nodes, near, work, ends, False, dy1, sign, width, 0.0, half)
