"""Limits on steps in which a function could grow from nothing without showing in its series.

The last terms of the series set the length of a step. That fails if a function is far below the rounding error of the
number to which it is added: ``exp(-((t - 50)/0.5)**2)`` at t = 0, ``tanh(x/0.01)`` far from x = 0, ``1/(1 + u**8)``
at large u. The series of its argument is still reliable. So a step ends before the argument can have changed the
function by more than a factor of ``exp(CHANGE)``: within this range the omitted terms are about as large as the last
ones.

After a time s <= h the argument has changed by at most ``a_1 s + R s^2``, where ``R`` is the sum of
``abs(a_k) h^(k - 2)`` over k >= 2.
"""

import math

#: Power of e by which an exponential may grow in a step, or a divisor, a root or a logarithm shrink.
CHANGE = 6.0

#: Argument below which an exponential counts as zero (1e-200).
NOTHING = -460.0

#: Argument above which tanh is 1 to the last bit.
SATURATED = 18.5

#: Powers above this exponent are watched; lower powers cannot grow unseen.
HIGH = 8.0

#: Shortest step, over the whole duration. If a divisor asks for a shorter one, the step is not changed, because a
#: divisor may pass through zero together with its dividend, such as in a body that rolls end over end through its
#: pole.
SHORTEST = 1e-13


def watch_lines(way, exponent, names):
    """Return the lines that set `hides` if something may hide in a step `h`, by a cheap and possibly loose bound.

    Parameters
    ----------
    way : {"exp", "tanh", "grows", "shrinks"}
        How the function depends on the argument: one of these two functions, a high power, or singular or sharp at
        zero.
    exponent : float
        The exponent of the power; for ``shrinks``, of the argument in the divisor.
    names : list of str
        The coefficients of the argument; an empty text means zero.
    """
    lines, slope = _allowed(way, exponent, names)
    return [*lines, f"hides = hides | (h * ({slope} + h * ({_sum_of_sizes(names, 'h')})) > m)"]


def step_lines(way, exponent, names):
    """Return the lines that shorten a step `h` so that nothing can hide in it.

    They use the names `left`, the time to the end, and `end`, the time of the end. Parameters as for `watch_lines`.
    """
    lines, slope = _allowed(way, exponent, names)
    lines.append("w = a = left if h > left else h")
    last = [k for k in range(3, len(names)) if names[k]][-2:]
    if last:
        # beyond the step that its last terms allow, a series says nothing, and the sum of its terms would be far too
        # large
        lines += ["e = 1000.0", "z = rough_log2(m) + 10.0"]
        for k in last:
            lines.append(f"b = (z - rough_log2(abs({names[k]}) + 1e-300)) * {1.0 / k!r}")
            lines.append("e = b if b < e else e")
        lines += ["b = rough_exp2(e)", "w = b if b < w else w"]
    # divided by m, because their squares may overflow
    lines += ["m = 1.0 / m", f"s = m * ({slope})", "w = 1.0 / s if s * w > 1.0 else w"]
    lines += [f"b = s + math.sqrt(s * s + 4.0 * (m * ({_sum_of_sizes(names, 'w')})))"]
    lines += ["w = 2.0 / b if b * w > 2.0 else w", f"e = {SHORTEST!r} * end"]
    shortest = "h" if way == "shrinks" else "e"
    return [*lines, f"w = {shortest} if w < e else w", "h = w if w < a else h"]


def _allowed(way, exponent, names):
    """Return the lines that set m, the allowed change of the argument, and the text of its rate of change."""
    value, slope = names[0] or "0.0", names[1] or "0.0"
    if way == "exp":
        lines = [f"m = {NOTHING!r} - {value}", f"z = {CHANGE!r}"]
    elif way == "grows":
        least = math.exp(NOTHING / exponent)
        lines = [f"m = {least!r} - abs({value})", f"z = {math.expm1(CHANGE / exponent)!r} * abs({value})"]
        slope = f"abs({slope})"
    else:
        if way == "tanh":
            lines = [f"m = abs({value}) - {SATURATED!r}", f"z = {0.5 * CHANGE!r}"]
        else:
            lines = ["m = 0.0", f"z = {-math.expm1(-CHANGE / exponent)!r} * abs({value})"]
        # towards zero
        slope = f"(-({slope}) if {value} > 0.0 else {slope})"
    return [*lines, "m = m if m > z else z"], slope


def _sum_of_sizes(names, step):
    """Return Horner's scheme for R: the sum of the magnitudes of all terms from order 2 on, over step^2."""
    text = ""
    for name in reversed(names[2:]):
        size = f"abs({name})" if name else "0.0"
        text = f"{size} + {step} * ({text})" if text else size
    return text or "0.0"
