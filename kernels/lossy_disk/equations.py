"""The rates that losses oppose, in the scaled form of the equations without trigonometry.

As in `kernels.disk.equations`, with two differences. K = 1/C is carried in place of T = tan(tilt) = S K: near flat,
where everything happens, precession rate, drag and friction need it. And torques act, given as generalised forces
(over m g R) on the three rates that losses oppose: the tilt rate w, the roll rate f = s - o T, and the turning rate
about the vertical v = o C + s S. They are the rates at which the contact moves across, along and about itself.
"""

from kernels.jit import simd


@simd
def roll_rate(state, i_inverse):
    """Roll rate f = s - o T (scaled) of a state (S, C, K, w, o, p) with p = (1+alpha) s; `i_inverse` is 1/(1+alpha)."""
    S, _, K, _, o, p = state
    return i_inverse * p - o * (S * K)


@simd
def turning_rate(state, i_inverse):
    """Turning rate about the vertical v = o C + s S (scaled); arguments as of `roll_rate`."""
    S, C, _, _, o, p = state
    return o * C + i_inverse * p * S
