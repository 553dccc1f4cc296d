"""Roll rate and turning rate, which losses oppose, in the scaled equations without trigonometry.

The scaled form of `kernels.disk.equations`, with two differences. The state contains K = 1/C in place of T =
tan(tilt) = S K, because precession rate, drag and friction need K near flat, where losses matter most. And torques
act, given as generalised forces (over m g R) on the three rates that losses oppose: the tilt rate w, the roll rate f
= s - o T, and the turning rate about the vertical v = o C + s S. At these rates the contact moves across its track,
along it, and turns on the spot.
"""

from kernels.jit import simd


@simd
def roll_rate(state, i_inverse):
    """Return the scaled roll rate f = s - o T of a state (S, C, K, w, o, p).

    p = (1+alpha) s, and `i_inverse` is 1/(1+alpha).
    """
    S, _, K, _, o, p = state
    return i_inverse * p - o * (S * K)


@simd
def turning_rate(state, i_inverse):
    """Return the scaled turning rate about the vertical, v = o C + s S; arguments as for `roll_rate`."""
    S, C, _, _, o, p = state
    return o * C + i_inverse * p * S
