"""How long a step may be, so that no function in it changes from nothing to something without its series knowing.

The step follows from the last terms of series beside the first ones. Where a function is far below the rounding of
what it is added to, its terms say nothing of what it does later: ``exp(-((t - 50)/0.5)**2)`` at t = 0, ``tanh(x/0.01)``
far from x = 0, ``1/(1 + u**8)`` where u is large. The argument has a series that can be relied on. So the step is
bounded by the least time in which the argument can have changed by what the function may do unseen: by a factor of
``exp(CHANGE)``, after which the terms that are left out are about as large as the last ones, which are looked at.

The change of an argument after s <= h is at most ``a_1 s + R s^2`` with ``R`` the sum of ``abs(a_k) h^(k - 2)`` over
k >= 2: where this reaches what is allowed, the step ends.
"""

import math

#: By what power of e an exponential may grow in one step, and a divisor and the like may shrink.
CHANGE = 6.0

#: Below this natural logarithm an exponential is nothing, as a state or a rate of 1e-200 is.
NOTHING = -460.0

#: From this argument on tanh is 1 to the last bit.
SATURATED = 18.5


#: A power above this one may grow unseen.
HIGH = 8.0


def test_lines(way, exponent, names):
    """Return the lines that add to `hides` whether something may hide in a step `h`: a bound that may be far off.

    Parameters
    ----------
    way : {"exp", "tanh", "grows", "shrinks"}
        What is made of the argument: one of these functions, a high power, or what is sharp or singular at zero.
    exponent : float
        Of the power, and of what one over the argument stands for.
    names : list of str
        The coefficients of the argument; an empty text is zero.
    """
    lines, slope = _allowed(way, exponent, names)
    return [*lines, f"hides = hides | (h * ({slope} + h * ({_sum_of_sizes(names, 'h')})) > m)"]


def step_lines(way, exponent, names):
    """Return the lines that shorten a step `h`, of which `left` is left, so that nothing hides in it.

    The parameters are those of `test_lines`.
    """
    lines, slope = _allowed(way, exponent, names)
    lines.append("w = a = left if h > left else h")
    last = [k for k in range(3, len(names)) if names[k]][-2:]
    if last:
        # beyond what its last terms allow a series says nothing, and the sum of its terms would be far off
        lines += ["e = 1000.0", "z = rough_log2(m) + 10.0"]
        for k in last:
            lines.append(f"b = (z - rough_log2(abs({names[k]}) + 1e-300)) * {1.0 / k!r}")
            lines.append("e = b if b < e else e")
        lines += ["b = rough_exp2(e)", "w = b if b < w else w"]
    # over m, as a square of these may be beyond all numbers
    lines += ["m = 1.0 / m", f"s = m * ({slope})", "w = 1.0 / s if s * w > 1.0 else w"]
    lines += [f"b = s + math.sqrt(s * s + 4.0 * (m * ({_sum_of_sizes(names, 'w')})))"]
    return [*lines, "w = 2.0 / b if b * w > 2.0 else w", "h = w if w < a else h"]


def _allowed(way, exponent, names):
    """Return the lines with what an argument may change by, m, and how fast it changes that way."""
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
    """Return the sum of the sizes of all terms from the second power on, over its square, as Horner's scheme."""
    text = ""
    for name in reversed(names[2:]):
        size = f"abs({name})" if name else "0.0"
        text = f"{size} + {step} * ({text})" if text else size
    return text or "0.0"
