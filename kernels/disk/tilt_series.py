"""A motion as power series in the stretched tilt, and its contact forces.

Along a motion s, o and the kinetic energy of the tilt are functions of the tilt (Chaplygin 1897), and therefore the
forces too. In the stretched tilt y, where dtilt = cos(tilt) dy, sin(tilt) = tanh y and tan(tilt) = sinh y, every
function here is analytic within pi/2 of the real axis: its series about any tilt, however near to 90 deg, converges
like (2t/pi)^k. The force of the plane divided by the normal force has poles; the series used here have none.
"""

import numpy as np

from kernels.jit import kernel

#: Length [1] of a panel in y, and number of terms of the series: the omitted terms are (1/4pi)^16 = 3e-18 times a few
#: hundred.
PANEL, TERMS = 0.125, 16

#: Rows of `series`. Sine, cosine, tangent of the tilt and the reciprocal of the cosine; the state s, o; kinetic
#: energy of the tilt and tilt acceleration times 1 + alpha/2, over m g R.
SIN, COS, TAN, SEC, AXIAL, DIAMETRAL, KINETIC, PULL = range(8)
#: Normal force; its derivative; squared horizontal force; derivative of the squared friction coefficient needed,
#: times the third power of the normal force. All over the weight.
NORMAL, NORMAL_SLOPE, FRICTION_SQUARED, FRICTION_SLOPE = range(8, 12)
#: Kinetic energy over t, if it vanishes at t = 0.
KINETIC_PER_STRETCH = 12
#: For the motion: o tan; (1+alpha) s - (alpha/2) o tan; and products.
_CLIMB, _TORQUE, _O_TORQUE, _PULL_COS, _COS_COS, _SIN_COS, _O_COS, _O_SIN, _S_COS = range(13, 22)
#: For the forces: products, roll rate, its factor across the track, w^2 + climb^2, horizontal force across the track.
_SIN_SIN, _PULL_SIN, _KINETIC_COS, _O_SEC, _O_O, _CLIMB_CLIMB = range(22, 28)
_ROLL, _FACTOR, _SQUARES, _SIN_SQUARES, _ROLL_FACTOR, _ALONG, _TURNED = range(28, 35)
_ACROSS, _ACROSS_ACROSS, _SQUARED_SLOPE, _UP, _DOWN = range(35, 40)
ROWS = 40

# A loop over a table of products: the compiler would unroll a separate loop for each product, five times as long. A
# row contains a factor, the other factor and the product; no product of a table is a factor in it.
_OF_O = np.array([[DIAMETRAL, TAN, _CLIMB]])
_OF_TORQUE = np.array([[DIAMETRAL, _TORQUE, _O_TORQUE]])
_OF_MOTION = np.array(
    [
        [PULL, COS, _PULL_COS],
        [COS, COS, _COS_COS],
        [SIN, COS, _SIN_COS],
        [DIAMETRAL, COS, _O_COS],
        [DIAMETRAL, SIN, _O_SIN],
        [AXIAL, COS, _S_COS],
    ]
)
_OF_FORCES = np.array(
    [
        [SIN, SIN, _SIN_SIN],
        [PULL, SIN, _PULL_SIN],
        [KINETIC, COS, _KINETIC_COS],
        [DIAMETRAL, SEC, _O_SEC],
        [DIAMETRAL, DIAMETRAL, _O_O],
        [_CLIMB, _CLIMB, _CLIMB_CLIMB],
    ]
)
_OF_SUMS = np.array([[SIN, _SQUARES, _SIN_SQUARES], [_ROLL, _FACTOR, _ROLL_FACTOR], [_O_O, KINETIC, _ALONG]])
_OF_TURN = np.array([[_ROLL_FACTOR, _O_SEC, _TURNED]])
_OF_ACROSS = np.array([[_ACROSS, _ACROSS, _ACROSS_ACROSS]])
_OF_SLOPES = np.array([[_SQUARED_SLOPE, NORMAL, _UP], [FRICTION_SQUARED, NORMAL_SLOPE, _DOWN]])


@kernel
def set_out(series, state, constants):
    """Put a scaled state (`kernels.disk.equations`) at the beginning of a panel."""
    S, C, T, w, o, s = state
    series[SIN, 0], series[COS, 0], series[TAN, 0], series[SEC, 0] = S, C, T, 1.0 / C
    series[AXIAL, 0], series[DIAMETRAL, 0], series[KINETIC, 0] = s, o, 0.5 * w * w / constants[0]


@kernel
def go_on(series, h):
    """Put the state at t = h of a panel at the beginning of the next one."""
    for row in range(PULL):
        value = 0.0
        for k in range(TERMS - 1, -1, -1):
            value = value * h + series[row, k]
        series[row, 0] = value


@kernel
def _multiply(series, products, first, stop):
    """Compute terms `first` to `stop` - 1 of products of rows."""
    for product in range(products.shape[0]):
        one, other, into = products[product, 0], products[product, 1], products[product, 2]
        for k in range(first, stop):
            total = 0.0
            for i in range(k + 1):
                total += series[one, i] * series[other, k - i]
            series[into, k] = total


@kernel
def expand_motion(series, constants):
    """Expand a motion about the beginning of a panel, from the terms of order 0 there.

    Notes
    -----
    With dy = dtilt/cos: sin' = cos^2, cos' = -sin cos, tan' = 1/cos, (1/cos)' = tan, s' = -o cos/(1+alpha),
    o' = o sin - 2 s cos, kinetic' = pull cos with pull = sin + o ((1+alpha) s - (alpha/2) o tan).
    """
    for k in range(TERMS):
        _multiply(series, _OF_O, k, k + 1)
        series[_TORQUE, k] = constants[1] * series[AXIAL, k] - constants[2] * series[_CLIMB, k]
        _multiply(series, _OF_TORQUE, k, k + 1)
        series[PULL, k] = series[SIN, k] + series[_O_TORQUE, k]
        _multiply(series, _OF_MOTION, k, k + 1)
        if k + 1 == TERMS:
            break
        share = 1.0 / (k + 1)
        series[KINETIC, k + 1] = share * series[_PULL_COS, k]
        series[SIN, k + 1], series[COS, k + 1] = share * series[_COS_COS, k], -share * series[_SIN_COS, k]
        series[TAN, k + 1], series[SEC, k + 1] = share * series[SEC, k], share * series[TAN, k]
        series[AXIAL, k + 1] = -share * constants[3] * series[_O_COS, k]
        series[DIAMETRAL, k + 1] = share * (series[_O_SIN, k] - 2.0 * series[_S_COS, k])


@kernel
def expand_forces(series, constants, alpha):
    """Expand the contact forces, as in `kernels.bodies.trajectory.forces`, but from w^2 and not from w."""
    twice = 2.0 * constants[0]
    _multiply(series, _OF_FORCES, 0, TERMS)
    for k in range(TERMS):
        series[NORMAL, k] = -constants[0] * series[_PULL_SIN, k] - twice * series[_KINETIC_COS, k]
        series[_SQUARES, k] = twice * series[KINETIC, k] + series[_CLIMB_CLIMB, k]
        series[_ROLL, k] = series[AXIAL, k] - series[_CLIMB, k]
        series[_FACTOR, k] = -2.0 * (1.0 + alpha) * series[_SIN_SIN, k]
    series[NORMAL, 0] += 1.0
    series[_FACTOR, 0] += alpha
    _multiply(series, _OF_SUMS, 0, TERMS)
    _multiply(series, _OF_TURN, 0, TERMS)
    for k in range(TERMS):
        across = 2.0 * series[_SIN_COS, k] - (2.0 + alpha) * series[_SIN_SQUARES, k] + series[_TURNED, k]
        series[_ACROSS, k] = across / (2.0 + alpha)
    _multiply(series, _OF_ACROSS, 0, TERMS)
    along = twice * (alpha / (1.0 + alpha)) ** 2
    for k in range(TERMS):
        series[FRICTION_SQUARED, k] = series[_ACROSS_ACROSS, k] + along * series[_ALONG, k]
    _differentiate(series)


@kernel
def _differentiate(series):
    last = TERMS - 1
    for k in range(last):
        series[NORMAL_SLOPE, k] = (k + 1) * series[NORMAL, k + 1]
        series[_SQUARED_SLOPE, k] = (k + 1) * series[FRICTION_SQUARED, k + 1]
    series[NORMAL_SLOPE, last] = series[_SQUARED_SLOPE, last] = 0.0
    _multiply(series, _OF_SLOPES, 0, TERMS)
    for k in range(TERMS):
        series[FRICTION_SLOPE, k] = series[_UP, k] - 2.0 * series[_DOWN, k]
