"""A motion as power series in the stretched tilt, and with it the contact forces.

Along a motion s, o and the kinetic energy of the tilt are functions of the tilt alone (Chaplygin 1897), and so are the
forces. In the stretched tilt y, where dtilt = cos(tilt) dy, sin(tilt) = tanh y and tan(tilt) = sinh y, every function
here is analytic within pi/2 of the real axis: its series about any tilt, however near to 90 deg, converges like
(2t/pi)^k. The force of the plane divided by the normal force has poles; the series that stand here have none.
"""

from kernels.jit import internal

#: Length [1] of a panel in y, and terms of the series: what is left out is (1/4pi)^16 = 3e-18 times a few hundred.
PANEL, TERMS = 0.125, 16

#: Rows of `series`. Sine, cosine, tangent of the tilt and one over the cosine; the state s, o; kinetic energy of the
#: tilt and the acceleration of the tilt times 1 + alpha/2, over m g R.
SIN, COS, TAN, SEC, AXIAL, DIAMETRAL, KINETIC, PULL = range(8)
#: Normal force; its derivative; squared horizontal force; and the derivative of the squared friction coefficient that
#: is needed, times the third power of the normal force. All over the weight.
NORMAL, NORMAL_SLOPE, FRICTION_SQUARED, FRICTION_SLOPE = range(8, 12)
#: Kinetic energy over t, where it vanishes at t = 0.
KINETIC_PER_STRETCH = 12
_ACROSS, _PART, _MORE, _REST, _SINE_SQUARED = range(13, 18)
ROWS = 18


@internal
def set_out(series, state, constants):
    """Put a scaled state (`kernels.disk.equations`) at the beginning of a panel."""
    S, C, T, w, o, s = state
    series[SIN, 0], series[COS, 0], series[TAN, 0], series[SEC, 0] = S, C, T, 1.0 / C
    series[AXIAL, 0], series[DIAMETRAL, 0], series[KINETIC, 0] = s, o, 0.5 * w * w / constants[0]


@internal
def go_on(series, h):
    """Put the state at t = h of a panel at the beginning of the next one."""
    for row in range(PULL):
        value = 0.0
        for k in range(TERMS - 1, -1, -1):
            value = value * h + series[row, k]
        series[row, 0] = value


@internal
def _term(series, a, b, k):
    """Term k of the product of two rows."""
    total = 0.0
    for i in range(k + 1):
        total += series[a, i] * series[b, k - i]
    return total


@internal
def _multiply(series, a, b, into):
    for k in range(TERMS):
        series[into, k] = _term(series, a, b, k)


@internal
def expand_motion(series, constants):
    """Expand a motion about the beginning of a panel, from the terms of order 0 there.

    Notes
    -----
    With dy = dtilt/cos: sin' = cos^2, cos' = -sin cos, tan' = 1/cos, (1/cos)' = tan, s' = -o cos/(1+alpha),
    o' = o sin - 2 s cos, kinetic' = pull cos with pull = sin + o ((1+alpha) s - (alpha/2) o tan).
    """
    for k in range(TERMS - 1):
        share = 1.0 / (k + 1)
        series[_PART, k] = _term(series, DIAMETRAL, TAN, k)
        series[_MORE, k] = constants[1] * series[AXIAL, k] - constants[2] * series[_PART, k]
        series[PULL, k] = series[SIN, k] + _term(series, DIAMETRAL, _MORE, k)
        series[KINETIC, k + 1] = share * _term(series, PULL, COS, k)
        series[SIN, k + 1] = share * _term(series, COS, COS, k)
        series[COS, k + 1] = -share * _term(series, SIN, COS, k)
        series[TAN, k + 1], series[SEC, k + 1] = share * series[SEC, k], share * series[TAN, k]
        series[AXIAL, k + 1] = -share * constants[3] * _term(series, DIAMETRAL, COS, k)
        turned = _term(series, DIAMETRAL, SIN, k) - 2.0 * _term(series, AXIAL, COS, k)
        series[DIAMETRAL, k + 1] = share * turned
    last = TERMS - 1
    series[_PART, last] = _term(series, DIAMETRAL, TAN, last)
    series[_MORE, last] = constants[1] * series[AXIAL, last] - constants[2] * series[_PART, last]
    series[PULL, last] = series[SIN, last] + _term(series, DIAMETRAL, _MORE, last)


@internal
def expand_forces(series, constants, alpha):
    """Expand the contact forces, from the motion: as `kernels.disk.contact.contact_forces`, from w^2 and not from w."""
    twice = 2.0 * constants[0]
    _multiply(series, SIN, SIN, _SINE_SQUARED)
    _multiply(series, DIAMETRAL, TAN, _PART)
    _multiply(series, _PART, _PART, _MORE)
    for k in range(TERMS):
        # w^2 + climb^2
        series[_MORE, k] += twice * series[KINETIC, k]
        pressed = constants[0] * _term(series, PULL, SIN, k) + twice * _term(series, KINETIC, COS, k)
        series[NORMAL, k] = (1.0 if k == 0 else 0.0) - pressed
        series[_ACROSS, k] = 2.0 * _term(series, SIN, COS, k) - (2.0 + alpha) * _term(series, SIN, _MORE, k)
    for k in range(TERMS):
        # the roll rate, and how it counts across the track
        series[_PART, k] = series[AXIAL, k] - series[_PART, k]
        series[_MORE, k] = (alpha if k == 0 else 0.0) - 2.0 * (1.0 + alpha) * series[_SINE_SQUARED, k]
    _multiply(series, _PART, _MORE, _REST)
    _multiply(series, DIAMETRAL, SEC, _PART)
    _multiply(series, DIAMETRAL, DIAMETRAL, _MORE)
    along = twice * (alpha / (1.0 + alpha)) ** 2
    for k in range(TERMS):
        series[_ACROSS, k] = (series[_ACROSS, k] + _term(series, _REST, _PART, k)) / (2.0 + alpha)
    for k in range(TERMS):
        squared = _term(series, _ACROSS, _ACROSS, k) + along * _term(series, _MORE, KINETIC, k)
        series[FRICTION_SQUARED, k] = squared
    _differentiate(series)


@internal
def _differentiate(series):
    last = TERMS - 1
    for k in range(last):
        series[NORMAL_SLOPE, k] = (k + 1) * series[NORMAL, k + 1]
        series[_PART, k] = (k + 1) * series[FRICTION_SQUARED, k + 1]
    series[NORMAL_SLOPE, last] = series[_PART, last] = 0.0
    for k in range(TERMS):
        steeper = _term(series, _PART, NORMAL, k) - 2.0 * _term(series, FRICTION_SQUARED, NORMAL_SLOPE, k)
        series[FRICTION_SLOPE, k] = steeper
