"""The contact forces of a body as power series in the stretched tilt, on a panel of `kernels.bodies.pair`."""

from kernels.bodies.pair import (
    ALONG,
    COS,
    HEIGHT,
    KINETIC,
    LEVER,
    SIN,
    SPEED,
    SQUARES,
    TERMS,
    TWIST,
    product,
    radius_of,
)
from kernels.bodies.pair import ROWS as OF_THE_PAIR
from kernels.jit import kernel

#: Rows: 1/C, the tangent; 1/B, w^2, the slope of the kinetic energy of the tilt, r l, torque on the tilt, tilt
#: acceleration; r - h, o/C, the force across the track, the square of the twist, the slope of the squared friction.
SEC, TAN, _PER_INERTIA, RATE_SQUARED, _SLOPE, _BENT, PULL, ACCELERATION = range(OF_THE_PAIR, OF_THE_PAIR + 8)
_LOW, TURNING, _ACROSS, _TWIST_SQUARED, _FRICTION_RISE = range(OF_THE_PAIR + 8, OF_THE_PAIR + 13)
#: Normal force; squared friction; functions that vanish at extremes of the normal force and of friction over it.
NORMAL, FRICTION_SQUARED, NORMAL_SLOPE, FRICTION_SLOPE = range(OF_THE_PAIR + 13, OF_THE_PAIR + 17)
ROWS = OF_THE_PAIR + 17


@kernel
def expand_forces(series, body):
    """Expand the contact forces over m g on a panel whose motion is expanded.

    Parameters
    ----------
    series : float64[ROWS, TERMS], written
    body : kernels.bodies.shapes.Body

    Notes
    -----
    With W the tilt acceleration and P/D the twist of `kernels.bodies.equations`: the normal force is
    1 + (r - h) w^2 - l W, the friction h W - l w^2 - (o/C) v across the track and I A w P/D along it. W follows from
    the kinetic energy K = B w^2/2 of the tilt: B W = dK/dtilt + r l w^2.
    """
    coupled = body.axial * body.transverse
    series[SEC, 0], series[TAN, 0] = 1.0 / series[COS, 0], series[SIN, 0] / series[COS, 0]
    for k in range(TERMS):
        first = 1.0 if k == 0 else 0.0
        if k + 1 < TERMS:
            series[SEC, k + 1], series[TAN, k + 1] = series[TAN, k] / (k + 1), series[SEC, k] / (k + 1)
        inverse = first
        for i in range(1, k + 1):
            inverse -= series[SQUARES, i] * series[_PER_INERTIA, k - i]
        series[_PER_INERTIA, k] = inverse / (body.transverse + series[SQUARES, 0])
        series[RATE_SQUARED, k] = 2.0 * product(series, KINETIC, _PER_INERTIA, k)
        series[_SLOPE, k] = (k + 1) * series[KINETIC, k + 1] if k + 1 < TERMS else 0.0
        radius = radius_of(series, body, k, first)
        series[_LOW, k] = radius
        series[_BENT, k] = product(series, _LOW, LEVER, k)
        series[PULL, k] = product(series, SEC, _SLOPE, k) + product(series, _BENT, RATE_SQUARED, k)
        series[ACCELERATION, k] = product(series, PULL, _PER_INERTIA, k)
        series[TURNING, k] = product(series, ALONG, SEC, k)
        series[_TWIST_SQUARED, k] = product(series, TWIST, TWIST, k)
    for k in range(TERMS):
        series[_LOW, k] -= series[HEIGHT, k]
    for k in range(TERMS):
        normal = product(series, _LOW, RATE_SQUARED, k) - product(series, LEVER, ACCELERATION, k)
        series[NORMAL, k] = normal if k > 0 else 1.0 + normal
        tipping = product(series, HEIGHT, ACCELERATION, k) - product(series, LEVER, RATE_SQUARED, k)
        series[_ACROSS, k] = tipping - product(series, TURNING, SPEED, k)
        along = coupled * coupled * product(series, _TWIST_SQUARED, RATE_SQUARED, k)
        series[FRICTION_SQUARED, k] = product(series, _ACROSS, _ACROSS, k) + along
    for k in range(TERMS):
        after = k + 1 if k + 1 < TERMS else k
        share = float(k + 1) if k + 1 < TERMS else 0.0
        series[NORMAL_SLOPE, k] = share * series[NORMAL, after]
        series[_FRICTION_RISE, k] = share * series[FRICTION_SQUARED, after]
    for k in range(TERMS):
        rise, fall = (
            product(series, _FRICTION_RISE, NORMAL, k),
            product(series, FRICTION_SQUARED, NORMAL_SLOPE, k),
        )
        series[FRICTION_SLOPE, k] = rise - 2.0 * fall
