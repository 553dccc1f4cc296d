"""A piece of a motion on one panel, as power series of the distance from the beginning of the piece.

On each piece the kinetic energy of the tilt, E - V, is expanded about a point at which it is known: the start, or the
end at which the motion enters the panel. There E - V = K - t (F + t q(t)), where the polynomial q follows from
dividing the climb of the potential twice. So no numbers of the size of V are subtracted, and a start 1e-9 rad from
upright turns as accurately as one at 1 rad.
"""

import math

from kernels.jit import kernel
from kernels.reduction.panels import HALF, NUMBERS, ONE, PP, SP, SS, TERMS, need_panel

#: Numbers of a piece: side and number of its panel; sign of the tilts there; centre of the panel and half its length;
#: the lowest and the highest y of the motion on it, measured from the start towards the side of the start; |y| where
#: the piece begins; the same, measured as those two; K and F there (F per half length, outward); (s, p) at the centre
#: of the panel; whether q has been formed; the second derivative of the potential where the piece begins, per half
#: length squared; the coefficients of q.
(
    SIDE, PANEL, SIGN, CENTRE, LENGTH, LOW, HIGH, FROM, AWAY, KINETIC, SLOPE, S_CENTRE, P_CENTRE, FORMED, BEND,
    QUOTIENT,
) = range(16)  # fmt: skip
PIECE = QUOTIENT + TERMS - 1

#: Highest power of q: an even one.
_LAST = TERMS - 2


@kernel
def begin_piece(table, piece, side, k, sign, y):
    """Begin a piece at |y| on a panel."""
    need_panel(table, side, k)
    piece[SIDE], piece[PANEL], piece[SIGN], piece[FROM], piece[AWAY], piece[FORMED] = (
        side,
        k,
        sign,
        y,
        0.0,
        0.0,
    )
    piece[LENGTH] = table.panels[side, k, NUMBERS, HALF]
    piece[CENTRE] = table.edges[k] + piece[LENGTH]


@kernel
def form_quotient(table, piece):
    """Divide the climb of the potential twice by the distance from the beginning of a piece, unless done before."""
    if piece[FORMED] != 0.0:
        return
    panel = table.panels[int(piece[SIDE]), int(piece[PANEL])]
    s, p = piece[S_CENTRE], piece[P_CENTRE]
    ss, sp, pp, x = s * s, s * p, p * p, (piece[FROM] - piece[CENTRE]) / piece[LENGTH]
    once = twice = thrice = 0.0
    for n in range(TERMS - 1, 0, -1):
        climb = ss * panel[SS, n] + sp * panel[SP, n] + pp * panel[PP, n] + panel[ONE, n]
        once = climb + x * once
        twice = once + x * twice
        thrice = twice + x * thrice
        piece[QUOTIENT + n - 1] = twice
    piece[FORMED], piece[BEND] = 1.0, 2.0 * thrice


@kernel
def kinetic_at(piece, t):
    """Return the kinetic energy of the tilt at the distance t outward, in half lengths."""
    x = (piece[FROM] - piece[CENTRE]) / piece[LENGTH] + t
    square, even, odd = x * x, 0.0, 0.0
    # even and odd powers separately: two short chains take less time than a long one
    for n in range(_LAST, -1, -2):
        even = even * square + piece[QUOTIENT + n]
    for n in range(_LAST - 1, -1, -2):
        odd = odd * square + piece[QUOTIENT + n]
    return piece[KINETIC] - t * (piece[SLOPE] + t * (even + x * odd))


@kernel
def look_along(piece, t):
    """Return kinetic energy and both derivatives of the potential at the distance t outward, in half lengths."""
    x = (piece[FROM] - piece[CENTRE]) / piece[LENGTH] + t
    square, even, odd = x * x, 0.0, 0.0
    even_slope = odd_slope = even_bend = odd_bend = 0.0
    for n in range(_LAST, -1, -2):
        even_bend = even_bend * square + even_slope
        even_slope = even_slope * square + even
        even = even * square + piece[QUOTIENT + n]
    for n in range(_LAST - 1, -1, -2):
        odd_bend = odd_bend * square + odd_slope
        odd_slope = odd_slope * square + odd
        odd = odd * square + piece[QUOTIENT + n]
    q, first = even + x * odd, odd + 2.0 * x * (even_slope + x * odd_slope)
    second = even_slope + 3.0 * x * odd_slope + 4.0 * square * (even_bend + x * odd_bend)
    slope = piece[SLOPE]
    return (
        piece[KINETIC] - t * (slope + t * q), slope + t * (2.0 * q + t * first),
        2.0 * (q + t * (2.0 * first + t * second)),
    )  # fmt: skip


@kernel
def find_change(piece, low, high, sign, order):
    """Return where, between two distances, the slope (order 1) or its derivative (order 2) changes from `sign`."""
    t = 0.5 * (low + high)
    for _ in range(60):
        _, slope, bend = look_along(piece, t)
        if (slope if order == 1 else bend) * sign > 0.0:
            low = t
        else:
            high = t
        new = t - slope / bend if order == 1 else low
        new = new if (new - low) * (new - high) < 0.0 else 0.5 * (low + high)
        # the value is stationary there, so half of the digits suffice
        if abs(new - t) <= (1e-8 if order == 1 else 1e-4):
            return new
        t = new
    return t


@kernel
def find_root(piece, sense, low, high, bend):
    """Find the first distance at which the kinetic energy is zero, by Halley's method.

    It is positive at `low`, and not at `high`; `bend` is the derivative of the slope where the piece begins.

    Returns
    -------
    (t, slope, bend)
        The distance in `sense`, and both derivatives of the potential there.
    """
    kinetic, slope, rest = piece[KINETIC], sense * piece[SLOPE], piece[KINETIC] == 0.0
    square, t = slope * slope + 2.0 * kinetic * bend, high
    if rest:
        t = -2.0 * slope / bend
    elif square >= 0.0:
        root = math.sqrt(square)
        t = 2.0 * kinetic / (slope + root) if slope > 0.0 else (root - slope) / bend
    t = t if low < t < high else 0.5 * (low + high)
    for _ in range(100):
        value, slope, bend = look_along(piece, sense * t)
        if value > 0.0:
            low = t
        else:
            high = t
        first, second = -sense * slope, -bend
        if rest:
            # the zero at t = 0 is divided out
            value /= t
            first = (first - value) / t
            second = (second - 2.0 * first) / t
        new = t - 2.0 * value * first / (2.0 * first * first - value * second)
        new = new if low <= new <= high else 0.5 * (low + high)
        if abs(new - t) <= 1e-6 * new or high - low <= 2.0**-52 * high:
            return new, slope, bend
        t = new
    return t, slope, bend
