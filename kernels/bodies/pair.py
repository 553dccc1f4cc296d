"""The linear pair s, o of a body, and the kinetic energy of its tilt, as power series in the stretched tilt.

Along a motion the rates s and o obey a linear system in the tilt (`kernels.bodies.equations`), so the kinetic energy
of the tilt, B w^2/2, is a function of the tilt too. In the stretched tilt y, where dtilt = cos(tilt) dy and
sin(tilt) = tanh y, all are analytic about the real axis. A panel is their series about one tilt.
"""

from kernels.jit import kernel

#: Number of terms of a series.
TERMS = 20

#: Rows of `series`: sine and cosine of the tilt, s, o, kinetic energy over m g R; intermediate quantities: a, b, the
#: lever of the weight, the height, B - A and D, b I/A + r S, the twist P/D;
SIN, COS, SPIN, ALONG, KINETIC, LONG, WIDE, LEVER, HEIGHT, SQUARES, DETERMINANT, MIX, TWIST = range(13)
#: products;
_TWIST_COS, SPEED, _ALONG_SIN, _SPIN_COS, _TORQUE = range(13, 18)
#: the first row that only an ellipse has (`kernels.bodies.ellipse`).
OF_ELLIPSE = 18
ROWS = 24

#: The longest panel, in y; a panel ends where the omitted terms are this share of its values.
LONGEST, _LEFT_OUT = 0.25, 1e-18


@kernel
def product(series, one, other, k):
    """Return term k of the product of two rows."""
    total = 0.0
    for i in range(k + 1):
        total += series[one, i] * series[other, k - i]
    return total


@kernel
def describe(series, body, k, first):
    """Compute term k of the rows of the meridian; `first` is 1 for term 0, otherwise 0."""
    S, C = series[SIN, k], series[COS, k]
    series[LONG, k], series[WIDE, k] = (
        body.core * first + body.edge * C,
        -body.shift * first - body.edge * S,
    )
    series[LEVER, k] = body.core * S - body.shift * C
    series[HEIGHT, k] = body.core * C + body.shift * S + body.edge * first
    series[MIX, k] = body.edge * S + body.ratio * series[WIDE, k]


@kernel
def evolute_along(series, body, k):
    """Return term k of (a - r C) o."""
    return body.core * series[ALONG, k]


@kernel
def radius_of(series, body, k, first):
    """Return term k of the radius of curvature r."""
    return body.edge * first


@kernel
def expand(series, body):
    """Expand a motion about the beginning of a panel, from the terms of order 0 of its first five rows.

    Parameters
    ----------
    series : float64[ROWS, TERMS], written
    body : kernels.bodies.shapes.Body

    Notes
    -----
    With dy = dtilt/C: S' = C^2, C' = -S C, s' = -A a f C, o' = o S - (I/A) s C - I b f C, where f = P/D, and
    kinetic' = l C + o (I s C - A o S + h v).
    """
    axial, transverse = body.axial, body.transverse
    for k in range(TERMS):
        first = 1.0 if k == 0 else 0.0
        describe(series, body, k, first)
        long, wide = product(series, LONG, LONG, k), product(series, WIDE, WIDE, k)
        series[SQUARES, k] = long + wide
        series[DETERMINANT, k] = axial * (transverse * first + wide) + transverse * long
        twist = evolute_along(series, body, k) - product(series, MIX, SPIN, k)
        for i in range(1, k + 1):
            twist -= series[DETERMINANT, i] * series[TWIST, k - i]
        series[TWIST, k] = twist / series[DETERMINANT, 0]
        series[_TWIST_COS, k] = product(series, TWIST, COS, k)
        series[SPEED, k] = product(series, LONG, SPIN, k) + product(series, WIDE, ALONG, k)
        series[_ALONG_SIN, k] = product(series, ALONG, SIN, k)
        series[_SPIN_COS, k] = product(series, SPIN, COS, k)
        series[_TORQUE, k] = (
            axial * series[_SPIN_COS, k]
            - transverse * series[_ALONG_SIN, k]
            + product(series, HEIGHT, SPEED, k)
        )
        if k + 1 == TERMS:
            break
        share = 1.0 / (k + 1)
        series[SIN, k + 1], series[COS, k + 1] = (
            share * product(series, COS, COS, k),
            -share * product(series, SIN, COS, k),
        )
        series[SPIN, k + 1] = -share * transverse * product(series, LONG, _TWIST_COS, k)
        turned = axial * product(series, WIDE, _TWIST_COS, k)
        series[ALONG, k + 1] = share * (series[_ALONG_SIN, k] - body.ratio * series[_SPIN_COS, k] - turned)
        pull = product(series, LEVER, COS, k) + product(series, ALONG, _TORQUE, k)
        series[KINETIC, k + 1] = share * pull


@kernel
def length_of(series):
    """Return the length of a panel, in y, over which the series are practically exact."""
    length = LONGEST
    for row in (SPIN, ALONG, KINETIC):
        size = abs(series[row, 0]) + LONGEST * abs(series[row, 1]) + LONGEST * LONGEST * abs(series[row, 2])
        for k in (TERMS - 2, TERMS - 1):
            last = abs(series[row, k])
            if last * length**k > _LEFT_OUT * size:
                length = (_LEFT_OUT * size / last) ** (1.0 / k)
    return length


@kernel
def go_on(series, h):
    """Put the state at t = h of a panel at the beginning of the next one."""
    for row in range(KINETIC + 1):
        value = 0.0
        for k in range(TERMS - 1, -1, -1):
            value = value * h + series[row, k]
        series[row, 0] = value
