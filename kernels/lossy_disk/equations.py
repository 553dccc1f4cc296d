"""Equations of motion of the disk with losses, in a scaled form without trigonometry.

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


@simd
def slopes(state, i_spin, drag):
    """How a motion changes with its tilt without losses, and what accelerates the tilt.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, K, o and p = (1+alpha) s.
    i_spin, drag : float
        alpha/2 and 2/(1+alpha).

    Returns
    -------
    (dS, -dC, dK, do, -dp), acceleration
        As of `kernels.disk.equations.slopes`.
    """
    S, C, K, o, p = state
    T = S * K
    oT = o * T
    return (C, S, K * T, oT - drag * p, o), S + o * (p - i_spin * oT)


@simd
def forced(T, S, C, along, about, inverse_spin):
    """Rates of change of o and p by generalised forces on the roll rate and on the turning rate.

    Parameters
    ----------
    T, S, C : float
        Tangent, sine and cosine of the tilt.
    along, about : float
        Generalised forces on f and v, over m g R.
    inverse_spin : float
        2/alpha.

    Returns
    -------
    (do, dp)
        In scaled time.

    Notes
    -----
    The power along * f + about * v = M_b o + M_n s gives the torques about the diameter through the contact,
    M_b = about C - along T, and about the axis, M_n = about S + along; o' gains 2 M_b / alpha and p' gains M_n.
    """
    return inverse_spin * (about * C - along * T), about * S + along
