"""Growth rates and frequencies of small disturbances of steady motions, measured with RK4."""

import math

from kernels.disk.arrays import ALPHA, GRAVITY, PRECESSION_RATE, RADIUS, ROLL_RATE, TILT
from kernels.disk.equations import inertia, scaled_state
from kernels.disk.rk4 import step
from kernels.jit import kernel
from kernels.native.entry import parallel

#: Kick [1] over the fastest rate of the cell; the odd part of the response is linear in the kick up to its square.
_KICK = 1e-5
#: RK4 steps for one unit of time, the time scale of the fastest rate.
_STEPS = 64
#: Number of cells that a thread takes at a time.
_CHUNK = 256


@kernel
def _deviation(state, S0, C0, constants, h):
    """Return the sine of the tilt's distance from the start after one and after two units of time."""
    for _ in range(_STEPS):
        state = step(state, constants, h)
    once = state[0] * C0 - state[1] * S0
    for _ in range(_STEPS):
        state = step(state, constants, h)
    return once, state[0] * C0 - state[1] * S0


@kernel
def _coefficient(starts, cell):
    unit = math.sqrt(starts[RADIUS, cell] / starts[GRAVITY, cell])
    S, C, T, w, o, s = scaled_state(
        starts[TILT, cell], 0.0, starts[PRECESSION_RATE, cell], starts[ROLL_RATE, cell], unit
    )
    fastest = 1.0 + abs(o) + abs(s) + abs(o * T)
    kick, constants, h = _KICK * fastest, inertia(starts[ALPHA, cell]), 1.0 / (fastest * _STEPS)
    up = _deviation((S, C, T, kick, o, s), S, C, constants, h)
    down = _deviation((S, C, T, -kick, o, s), S, C, constants, h)
    # sinh(2 g t) = 2 sinh(g t) cosh(g t) and sin(2 f t) = 2 sin(f t) cos(f t): half the ratio is cosh(g t) or cos(f t)
    cosine = 0.5 * (up[1] - down[1]) / (up[0] - down[0])
    rate = math.acosh(cosine) if cosine > 1.0 else math.acos(cosine)
    rate *= fastest / unit
    return -rate * rate if cosine > 1.0 else rate * rate


@parallel(_CHUNK, starts="float64[:, ::1]", found="float64[::1], written")
def coefficients(start, stop, starts, found):
    """Measure the coefficient k of small oscillations d'' + k d = 0 about steady motions.

    Python calls it without `start` and `stop`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts : float64[len(PARAMETERS), n]
        Each one a steady motion, whose tilt rate is not read.
    found : float64[n], written
        k [rad^2/s^2], negative if a kick grows; NaN if a start is not a steady motion.

    Notes
    -----
    Each motion is kicked up and down and integrated over the times t and 2t. Half the difference d of the two motions
    is linear in the kick up to its square. d(2t)/(2 d(t)) is cos(sqrt(k) t) or cosh(sqrt(-k) t), which depends
    neither on the size of the kick nor on a theory of k.
    """
    for cell in range(start, stop):
        found[cell] = _coefficient(starts, cell)
