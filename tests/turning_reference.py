"""Turning points to 40 digits from hypergeometric functions; writes the table of test_extremes_digits.py.

Nothing of the project is imported. Along a motion s = c1 E + c2 O, where E and O are the even and the odd solution of
Legendre's equation (1-u^2) s'' - 2u s' - 2s/(1+alpha) = 0, u = sin(tilt); o = -(1+alpha) cos(tilt) ds/du. The extreme
tilts are the zeros of V - h next to the start, separated by the zeros of V'.

    python tests/turning_reference.py          (a few minutes; the seed is fixed)

Columns: kind, the start's seven parameters as hexadecimal floats, least and greatest tilt, how far each moves if every
parameter changes by its own size (the sum of |x dtilt/dx|), wells, saddle of V minus h (scaled), period in s (nan if
not computed).
"""

import random
from functools import lru_cache
from pathlib import Path

from mpmath import (
    asin,
    asinh,
    atan,
    cos,
    gamma,
    hyp2f1,
    log,
    mp,
    mpf,
    nan,
    nstr,
    pi,
    psi,
    quad,
    re,
    sech,
    sin,
    sinh,
    sqrt,
    tan,
)  # fmt: skip

mp.dps = 40
TABLE = Path(__file__).with_name("turning_reference.csv")
ALPHAS = (0.001, 0.05, 0.2, 0.4, 0.5, 0.65, 0.8, 0.9, 1.0)
LAST = mpf("1.5672")  # 89.79 degrees


@lru_cache(maxsize=1000)
def constants(a, b, _digits):
    """Return factor and digammas of the logarithmic series."""
    return gamma(a + b) / (gamma(a) * gamma(b)), 2 * psi(0, 1) - psi(0, a) - psi(0, b)


def toward_one(a, b, y):
    """Return 2F1(a, b; a+b; 1-y) and its derivative, from the logarithmic series (Abramowitz-Stegun 15.3.10)."""
    front, digammas = constants(a, b, mp.dps)
    factor, bracket = mpf(1), digammas - log(y)
    value = slope = mpf(0)
    for n in range(400):
        value += factor * bracket
        slope -= factor * (n * bracket - 1) / y
        if abs(factor) < mpf(10) ** (-mp.dps - 5):
            break
        bracket += mpf(2) / (n + 1) - 1 / (a + n) - 1 / (b + n)
        factor *= (a + n) * (b + n) / mpf(n + 1) ** 2 * y
    return re(front * value), re(front * slope)


def series(a, b, c, z, y):
    """Return 2F1(a, b; c; z), c = a + b, and its derivative; y = 1-z."""
    if z > mpf(1) / 2:
        return toward_one(a, b, y)
    return re(hyp2f1(a, b, c, z)), re(a * b / c * hyp2f1(a + 1, b + 1, c + 1, z))


@lru_cache(maxsize=400000)
def basis(alpha, tilt):
    """Return (E, o_E, O, o_O) of the even and the odd solution, (s, o) = (1, 0) and (0, 1) at upright."""
    u, c, half = sin(tilt), cos(tilt), mpf(1) / 2
    mu = sqrt(2 / (1 + alpha) - mpf(1) / 4)
    a, b = mpf(1) / 4 - 1j * mu / 2, mpf(1) / 4 + 1j * mu / 2
    even, even_slope = series(a, b, half, u * u, c * c)
    odd, odd_slope = series(a + half, b + half, 3 * half, u * u, c * c)
    scale = -(1 + alpha) * c
    return even, scale * 2 * u * even_slope, -u * odd / (1 + alpha), c * (odd + 2 * u * u * odd_slope)


def rates(motion, tilt):
    """Return (s, o) of a motion at a tilt."""
    alpha, c1, c2 = motion[:3]
    even, o_even, odd, o_odd = basis(alpha, tilt)
    return c1 * even + c2 * odd, c1 * o_even + c2 * o_odd


def potential(motion, tilt):
    """Return V of a motion at a tilt."""
    alpha = motion[0]
    s, o = rates(motion, tilt)
    return (1 + alpha) / 2 * s * s + alpha / 4 * o * o + cos(tilt)


def slope(motion, tilt):
    """Return dV/dtilt of a motion at a tilt."""
    alpha = motion[0]
    s, o = rates(motion, tilt)
    return -sin(tilt) - (1 + alpha) * s * o + alpha / 2 * o * o * sin(tilt) / cos(tilt)


def reduce(start):
    """Return the motion (alpha, c1, c2, h) and scaled tilt rate of a start of seven numbers."""
    tilt, rate, precession, roll, alpha, radius, gravity = map(mpf, start)
    unit = sqrt(radius / gravity)
    s, o = unit * (roll + precession * sin(tilt)), unit * precession * cos(tilt)
    even, o_even, odd, o_odd = basis(alpha, tilt)
    determinant = even * o_odd - odd * o_even
    c1, c2 = (s * o_odd - o * odd) / determinant, (even * o - o_even * s) / determinant
    w = rate * unit
    motion = (alpha, c1, c2)
    return (*motion, (1 + alpha / 2) / 2 * w * w + potential(motion, tilt)), w


def bisected(function, low, high):
    """Return the zero of a function with opposite signs at the ends, by regula falsi (Illinois)."""
    f_low, f_high = function(low), function(high)
    side = 0
    for _ in range(400):
        x = (low * f_high - high * f_low) / (f_high - f_low)
        f = function(x)
        if f == 0 or abs(high - low) < mpf(10) ** -36 or abs(f) < mpf(10) ** -39:
            return x
        if f * f_high > 0:
            high, f_high = x, f
            f_low = f_low / 2 if side == 1 else f_low
            side = 1
        else:
            low, f_low = x, f
            f_high = f_high / 2 if side == -1 else f_high
            side = -1
    raise ArithmeticError("no convergence")


def grid():
    """Return tilts that separate the zeros of V': dense near upright and toward flat."""
    coarse = [atan(sinh(mpf(i) / 16)) for i in range(1, 106)]
    fine = [mpf(10) ** (mpf(i) / 5) for i in range(-35, -6)]
    positive = sorted(t for t in [*coarse, *fine, LAST] if t <= LAST)
    return [*(-t for t in reversed(positive)), mpf(0), *positive]


GRID = grid()


def critical(motion, tilt):
    """Return the zeros of V' between -LAST and LAST as (tilt, is a maximum)."""
    points = sorted({*GRID, tilt})
    slopes = [slope(motion, t) for t in points]
    found = []
    for i in range(len(points) - 1):
        if slopes[i] == 0:
            found.append((points[i], i > 0 and slopes[i - 1] > 0))
        elif slopes[i] * slopes[i + 1] < 0:
            root = bisected(lambda t: slope(motion, t), points[i], points[i + 1])
            found.append((root, slopes[i] > 0))
    return found


def turn(motion, w, tilt, side, stationary):
    """Return the turning point on one side, or None if there is none before LAST."""
    h = motion[3]
    if w == 0 and side * slope(motion, tilt) > 0:
        return tilt
    before = tilt
    for point in sorted(
        (t for t in [*stationary, side * LAST] if side * (t - tilt) > 0), key=lambda t: side * t
    ):
        if potential(motion, point) > h:
            return bisected(lambda t: potential(motion, t) - h, before, point)
        before = point
    return None


def first_turn(motion, w, tilt, side, last, growth="1.35", longest="0.02"):
    """Return the turning point on one side, or None before `last`; for any start, but slower than `turn`.

    The scan starts 1e-9 rad from the start, so it finds saddles next to steady motions and starts next to their own
    turning points, and continues in steps of at most `longest`. Between two scanned tilts a minimum of the kinetic
    energy is found from its slope.
    """
    if w == 0 and side * slope(motion, tilt) > 0:
        return tilt
    h, distance, growth, longest = motion[3], mpf(10) ** -9, mpf(growth), mpf(longest)
    before, falling = tilt, side * slope(motion, tilt) > 0
    while side * before < last:
        point = side * min(side * tilt + distance, last)
        rising = side * slope(motion, point) < 0
        if falling and rising and potential(motion, point) <= h:
            top = bisected(lambda t: slope(motion, t), before, point)
            if potential(motion, top) > h:
                point = top
        if potential(motion, point) > h:
            return bisected(lambda t: potential(motion, t) - h, before, point)
        before, falling = point, not rising
        distance = min(growth * distance, distance + longest)
    return None


def extremes(start, last):
    """Return the extreme tilts of a start, None on a side where +-`last` comes first."""
    motion, w = reduce(start)
    return tuple(first_turn(motion, w, mpf(start[0]), side, mpf(last)) for side in (-1, 1))


def sensitivity(start, motion, root):
    """Return the sum of |x dtilt/dx| over the parameters of the start."""
    steep, small, total = slope(motion, root), mpf(10) ** -14, mpf(0)
    for i in range(7):
        other = list(map(mpf, start))
        other[i] *= 1 + small
        moved, _ = reduce(other)
        total += abs((potential(moved, root) - moved[3]) / small / steep)
    return total


def nutation_period(start, motion, low, high, summit):
    """Return 2 int dtilt/w over an angle that removes the square roots, nan if it does not converge."""
    middle, half, h = (low + high) / 2, (high - low) / 2, motion[3]

    def integrand(a):
        tilt = middle + half * sin(a)
        return re(half * cos(a) / sqrt(h - potential(motion, tilt)))

    cuts, method, degree = [-pi / 2, pi / 2], "gauss-legendre", 6
    if summit is not None:
        method, degree = "tanh-sinh", 7
        if low < summit < high:
            cuts.insert(1, asin((summit - middle) / half))
    value, error = quad(integrand, cuts, maxdegree=degree, method=method, error=True)
    if error > 1e-13 * value:
        return nan
    return sqrt(2 + motion[0]) * value * sqrt(mpf(start[5]) / mpf(start[6]))


def graded(place, width):
    """Return angles around a place where an integrand varies over `width`: their distances triple."""
    cuts = [place]
    while width < 2:
        cuts += [place - width, place + width]
        width *= 3
    return [cut for cut in cuts if abs(cut) < pi / 2]


def period(start, last):
    """Return the period [s] of a start that turns before `last` on both sides, and the relative quadrature error.

    It works for any start, but slower than `nutation_period`: the pieces of the quadrature are graded toward the
    saddles and placed in y = asinh(tan(tilt)), in which nothing is steep near flat.
    """
    motion, w = reduce(start)
    low, high = (first_turn(motion, w, mpf(start[0]), side, mpf(last)) for side in (-1, 1))
    least, most = asinh(tan(low)), asinh(tan(high))
    middle, half = (least + most) / 2, (most - least) / 2

    def integrand(a):
        y = middle + half * sin(a)
        return half * cos(a) * sech(y) / sqrt(motion[3] - potential(motion, atan(sinh(y))))

    pieces, small = max(1, int(2 * half)), mpf(10) ** -8
    cuts = {-pi / 2 + pi * n / pieces for n in range(pieces + 1)}
    for top in (tilt for tilt, is_top in critical(motion, mpf(start[0])) if is_top):
        near = min(max(top, low), high)
        bend = abs(slope(motion, top + small) - slope(motion, top - small)) / (2 * small)
        width = max(sqrt(2 * abs(potential(motion, top) - motion[3]) / bend), abs(near - top)) / half
        place = re(asin((asinh(tan(near)) - middle) / half))
        # Near a turning point the tilt is quadratic in the angle.
        cuts.update(graded(place, width if low < top < high else sqrt(width)))
    value, error = quad(integrand, sorted(cuts), maxdegree=4, method="gauss-legendre", error=True)
    unit = sqrt(mpf(start[5]) / mpf(start[6]))
    return sqrt(2 + motion[0]) * re(value) * unit, abs(error / value)


def row(kind, start, with_period):
    """Return the table's line of a start, or None if it does not turn before LAST."""
    motion, w = reduce(start)
    tilt = mpf(start[0])
    found = critical(motion, tilt)
    stationary, summits = [t for t, _ in found], [t for t, top in found if top]
    low, high = (turn(motion, w, tilt, side, stationary) for side in (-1, 1))
    if low is None or high is None or not low < high or len(summits) > 1:
        return None
    summit = summits[0] if summits else None
    height = nan if summit is None else potential(motion, summit) - motion[3]
    duration = nutation_period(start, motion, low, high, summit) if with_period else nan
    moves = [sensitivity(start, motion, root) for root in (low, high)]
    numbers = [low, high, *moves, 1 + len(summits), height, duration]
    return ",".join([kind, *(float(x).hex() for x in start), *(nstr(x, 22) for x in numbers)])


# --- the starts -----------------------------------------------------------------------------------------------------


def anywhere(rng):
    """Return a start with random state variables."""
    rates_ = [rng.gauss(0, 3) for _ in range(3)]
    return [
        rng.uniform(-1.45, 1.45),
        *rates_,
        rng.choice(ALPHAS),
        rng.choice((0.1, 0.5, 2.0)),
        rng.choice((1.62, 9.81)),
    ]


def upright(rng):
    """Return a start near the critical rates, disturbed by as little as 1e-6."""
    alpha, kind = rng.choice(ALPHAS), rng.randrange(4)
    away = 1 + rng.choice((-1, 1)) * 10 ** rng.uniform(-5, -0.5)
    small = 10 ** rng.uniform(-6, -1.5)
    rolling = (9.81 / (2 * (1 + alpha) * 0.5)) ** 0.5 * away
    spinning = (2 * 9.81 / ((2 + alpha) * 0.5)) ** 0.5 * away
    tilt, rate = (small, 0.0) if kind % 2 else (0.0, small)
    return [tilt, rate, *((0.0, rolling) if kind < 2 else (spinning, 0.0)), alpha, 0.5, 9.81]


def circling(rng):
    """Return a start near a steady motion."""
    alpha, tilt, p = rng.choice(ALPHAS), rng.uniform(0.02, 1.2), rng.uniform(0.3, 6.0)
    push = 4 * 9.81 * float(sin(tilt)) + (2 + alpha) * 0.5 * p * p * float(sin(2 * tilt))
    return [
        tilt,
        10 ** rng.uniform(-8, -2),
        p,
        -push / (4 * (1 + alpha) * 0.5 * p * float(cos(tilt))),
        alpha,
        0.5,
        9.81,
    ]


def flat(rng):
    """Return a start within 0.3 to 11 degrees of flat."""
    start = anywhere(rng)
    start[0] = rng.choice((-1, 1)) * (1.5707 - 10 ** rng.uniform(-2.3, -0.7))
    start[1] *= 0.3
    return start


def separatrix(rng):
    """Return a start whose energy is within 1e-2 to 1e-11 of the saddle."""
    alpha = rng.choice(ALPHAS)
    start = [rng.uniform(-0.5, 0.5), 1.0, rng.gauss(0, 0.6), rng.gauss(0, 0.6), alpha, 0.5, 9.81]
    motion, _ = reduce(start)
    tops = [t for t, top in critical(motion, mpf(start[0])) if top]
    if not tops:
        return None
    gap = 10 ** mpf(rng.uniform(-11, -2)) * rng.choice((-1, 1))
    excess = potential(motion, tops[0]) * (1 + gap) - potential(motion, mpf(start[0]))
    if excess <= 0:
        return None
    start[1] = rng.choice((-1, 1)) * float(sqrt(2 * excess / (1 + mpf(alpha) / 2) * mpf(9.81) / mpf(0.5)))
    return start


def main():
    """Write the table."""
    rng, lines = random.Random(20051), []
    for kind, count in ((anywhere, 90), (upright, 50), (circling, 40), (flat, 30), (separatrix, 50)):
        made = 0
        while made < count:
            start = kind(rng)
            line = row(kind.__name__, start, made % 3 == 0) if start else None
            if line:
                lines.append(line)
                made += 1
    TABLE.write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()
