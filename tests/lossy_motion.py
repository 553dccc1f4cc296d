"""An independent motion with losses: angles, sines and cosines, DOP853; everything is scaled.

State: tilt, tilt rate w, precession rate P, roll rate f, scaled by sqrt(R/g). The losses do the virtual power F_w w +
F_f f + F_v v with v = P + f sin(tilt), so Lagrange's equations of tilt, heading and roll gain F_w, F_v and F_f + F_v
sin(tilt); `tests/kernels/lossy_disk/test_referee.py` checks them against five coordinates with multipliers.

Dry friction is set-valued. While a rate is not zero its friction has a sign or direction, which is constant or a smooth
function of the motion; where the rate vanishes, `decide` tries holding and both directions of sliding, and takes the
consistent one. Between such moments DOP853 (with SciPy's tableau) steps a smooth right-hand side. An event is a margin
that becomes negative: it is sought among interpolated samples within each step, and found by bisection with real steps.

All compiled functions are in this one file, because Numba checks only this file when it decides whether its cache is
valid.
"""

import math

import numpy as np
from numba import njit
from scipy.integrate import DOP853

#: Coefficients of a motion, scaled: alpha; arms of rolling, pivoting and contour friction; viscous contour friction;
#: the two air laws; the plane's friction coefficient.
ALPHA, ROLLING, PIVOTING, CONTOUR, DAMPING, MOFFATT, BILDSTEN, FRICTION = range(8)

#: After the four numbers of the motion the state has heading, path, the losses in the order of `arrays.LOSSES`, and the
#: contact point.
HEADING, PATH, LOSSES, PLACE, SIZE = 4, 5, 6, 11, 13

#: Signs of a mode: of the roll rate (0: held by contour friction), of the turn about the vertical (0: held by pivoting
#: friction), of the tilt rate (for rolling friction while the roll rate is held).
ROLL, TURN, LEAN = range(3)

#: Margins: flat; lift-off; slip; friction of roll and turn keeps its sign or holds; landing of both horizontal rates;
#: first breach.
FLAT, LIFT, SLIP, CONTOUR_KEEPS, PIVOT_KEEPS, LANDS, BREACH, MARGINS = range(8)

#: A rate has changed its sign when it is this far beyond zero; horizontal rates have landed below the second number.
BEYOND, LANDED = 1e-14, 1e-11

#: Endings of a motion.
RUNS_ON, FLAT_DOWN, AT_REST, TIME_OVER, LIFTS, SLIPS, UNDISTURBED, LOST = range(8)

_STAGES, _A, _B = DOP853.n_stages, DOP853.A.copy(), DOP853.B.copy()
_E3, _E5 = DOP853.E3.copy(), DOP853.E5.copy()
_SAMPLES, _MOST_STEPS = 8, 20_000_000

#: Longest step up to this scaled time.
_FIRST_STEPS, _AT_FIRST = 0.02, 1.0


@njit(cache=True)
def slopes(y, mode, par, out):
    """Write the time derivative of y; return normal force, forces across and along, holding forces of roll and turn."""
    tilt, w, P, f = y[0], y[1], y[2], y[3]
    S, C, alpha = math.sin(tilt), math.cos(tilt), par[ALPHA]
    inertia = 1.0 + 0.5 * alpha
    push = S + inertia * P * P * S * C + (1.0 + alpha) * f * P * C
    # Rolling friction opposes (w, C f); the normal force depends on the tilt acceleration, which depends on the
    # friction.
    across, along = mode[LEAN], 0.0
    if mode[ROLL] != 0.0:
        size = math.hypot(w, C * f)
        across, along = (w / size, C * f / size) if size > 0.0 else (0.0, 0.0)
    n = (1.0 - S * push / inertia - w * w * C) / (1.0 - S * par[ROLLING] * across / inertia)
    lean = (push - par[ROLLING] * n * across) / inertia
    v = P + f * S
    on_roll = -(par[DAMPING] + par[MOFFATT] / C + par[BILDSTEN] * math.sqrt(abs(f))) * f
    on_roll -= n * (par[ROLLING] * C * along + par[CONTOUR] * mode[ROLL])
    on_turn = -par[PIVOTING] * n * mode[TURN]
    # Accelerations per unit force on the roll (r) and on the turn (t); v' gains as much from r as f' from t.
    roll_r, turn_t = (
        1.0 / (1.0 + alpha) + 2.0 * (S / C) ** 2 / alpha,
        2.0 * C * C / alpha + S * S / (1.0 + alpha),
    )
    both, heading_r, heading_t = S / (1.0 + alpha) - 2.0 * S / alpha, -2.0 * S / (alpha * C * C), 2.0 / alpha
    dP = -2.0 * f * w / C + heading_r * on_roll + heading_t * on_turn
    df = w * (2.0 * f * S - (2.0 + alpha) / (1.0 + alpha) * P * C * C) / C + roll_r * on_roll + both * on_turn
    dv = dP + S * df + C * w * f
    hold_roll = hold_turn = 0.0
    holds_turn = par[PIVOTING] > 0.0 and mode[TURN] == 0.0
    if mode[ROLL] == 0.0 and holds_turn:
        det = roll_r * turn_t - both * both
        hold_roll, hold_turn = (both * dv - turn_t * df) / det, (both * df - roll_r * dv) / det
    elif mode[ROLL] == 0.0:
        hold_roll = -df / roll_r
    elif holds_turn:
        hold_turn = -dv / turn_t
    dP += heading_r * hold_roll + heading_t * hold_turn
    df += roll_r * hold_roll + both * hold_turn
    if mode[ROLL] == 0.0:
        df = 0.0
    out[0], out[1], out[2], out[3], out[HEADING], out[PATH] = w, lean, dP, df, P, abs(f)
    out[LOSSES] = par[ROLLING] * n * (across * w + along * C * f)
    out[LOSSES + 1] = par[PIVOTING] * n * abs(v) * abs(mode[TURN])
    out[LOSSES + 2] = par[CONTOUR] * n * abs(f)
    out[LOSSES + 3] = par[DAMPING] * f * f
    out[LOSSES + 4] = (par[MOFFATT] / C + par[BILDSTEN] * math.sqrt(abs(f))) * f * f
    # Along the rim, which touches the plane toward (-sin heading, cos heading).
    out[PLACE], out[PLACE + 1] = -f * math.sin(y[HEADING]), f * math.cos(y[HEADING])
    # The acceleration of the center, S across and C above the contact, which moves along the track at f.
    across = C * lean - S * w * w - P * (f + S * P)
    along = df + S * dP + 2.0 * C * w * P
    return n, across, along, hold_roll, hold_turn


@njit(cache=True)
def energy(y, alpha):
    """Return the kinetic energy of center and rotation plus the potential energy, over m g R."""
    tilt, w, P, f = y[0], y[1], y[2], y[3]
    axial, C = f + P * math.sin(tilt), math.cos(tilt)
    return 0.5 * (axial**2 + w**2 + alpha * axial**2 + 0.5 * alpha * (w**2 + (P * C) ** 2)) + C


@njit(cache=True)
def held_fast(y, par, turn):
    """Return whether rolling and contour friction hold a disk that only turns (normal force 1)."""
    S, C, P, alpha = math.sin(y[0]), math.cos(y[0]), y[2], par[ALPHA]
    lean = abs(S) * (1.0 + (1.0 + 0.5 * alpha) * P * P * C)
    if lean > par[ROLLING]:
        return False
    roll = (
        par[PIVOTING]
        * abs(turn)
        * abs(S)
        * C
        * C
        * (1.0 + 0.5 * alpha)
        / ((1.0 + alpha) * S * S + 0.5 * alpha * C * C)
    )
    return roll <= par[CONTOUR] + C * math.sqrt(par[ROLLING] ** 2 - lean**2)


@njit(cache=True)
def margins(y, mode, par, flat, center, limit, work, out):
    """Write all margins of a state."""
    n, across, along, hold_roll, hold_turn = slopes(y, mode, par, work)
    out[:] = 1.0
    out[FLAT] = flat - abs(y[0])
    out[LIFT] = n
    if par[FRICTION] < np.inf:
        out[SLIP] = par[FRICTION] * n - math.hypot(across, along)
    if mode[ROLL] != 0.0:
        out[CONTOUR_KEEPS] = mode[ROLL] * y[3] + BEYOND
    else:
        out[CONTOUR_KEEPS] = par[CONTOUR] * n - abs(hold_roll) + BEYOND
    if par[PIVOTING] > 0.0:
        if mode[TURN] != 0.0:
            out[PIVOT_KEEPS] = mode[TURN] * (y[2] + y[3] * math.sin(y[0])) + BEYOND
        else:
            out[PIVOT_KEEPS] = par[PIVOTING] * n - abs(hold_turn) + BEYOND
    if par[ROLLING] > 0.0:
        if mode[ROLL] == 0.0:
            out[LANDS] = mode[LEAN] * y[1] + BEYOND
        elif held_fast(y, par, mode[TURN]):
            out[LANDS] = math.hypot(y[1], math.cos(y[0]) * y[3]) - LANDED
    out[BREACH] = limit - abs(y[0] - center)


@njit(cache=True)
def step(y, h, mode, par, k, new):
    """Write y after h, given the initial slopes in k[0]; the final slopes go to k[-1]."""
    for stage in range(1, _STAGES):
        new[:] = y
        for i in range(stage):
            if _A[stage, i] != 0.0:
                new += h * _A[stage, i] * k[i]
        slopes(new, mode, par, k[stage])
    new[:] = y
    for i in range(_STAGES):
        new += h * _B[i] * k[i]
    slopes(new, mode, par, k[_STAGES])


@njit(cache=True)
def error_norm(y, new, h, k, rtol, atol):
    """Return the error of a step over the tolerance, as SciPy's DOP853 estimates it."""
    five = three = 0.0
    for j in range(y.size):
        scale = atol + rtol * max(abs(y[j]), abs(new[j]))
        e5 = e3 = 0.0
        for i in range(_STAGES + 1):
            e5 += k[i, j] * _E5[i]
            e3 += k[i, j] * _E3[i]
        five += (e5 / scale) ** 2
        three += (e3 / scale) ** 2
    if five == 0.0 and three == 0.0:
        return 0.0
    return abs(h) * five / math.sqrt((five + 0.01 * three) * y.size)


@njit(cache=True)
def sign(x):
    """Return -1, 0 or 1."""
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)


@njit(cache=True)
def decide(y, turn_zero, par, mode, work):
    """Write the mode in which a motion continues from y; return the time spent: zero or a first moment.

    It is infinite if rolling friction holds the disk completely.
    """
    P, f = y[2], y[3]
    if P == 0.0 and f == 0.0:
        # A fall in the plane: roll and heading stay zero, whatever holds them.
        if y[1] == 0.0 and held_fast(y, par, 0.0):
            return np.inf
        mode[ROLL], mode[TURN], mode[LEAN] = 0.0, 0.0, sign(y[1] if y[1] != 0.0 else y[0])
        return 0.0
    if par[ROLLING] > 0.0 and y[1] == 0.0 and f == 0.0:
        if held_fast(y, par, 1.0):
            return np.inf
        return break_away(y, par, mode, work)
    v = P + f * math.sin(y[0])
    best = np.inf
    found_roll = found_turn = 0.0
    mode[LEAN] = sign(y[1])
    for roll in (0.0, 1.0, -1.0):
        if (f != 0.0 and roll != sign(f)) or (f == 0.0 and roll == 0.0 and par[CONTOUR] == 0.0):
            continue
        for turn in (0.0, 1.0, -1.0):
            if (par[PIVOTING] == 0.0 and turn != 1.0) or (
                par[PIVOTING] > 0.0 and not turn_zero and turn != sign(v)
            ):
                continue
            mode[ROLL], mode[TURN] = roll, turn
            n, _, _, hold_roll, hold_turn = slopes(y, mode, par, work)
            wrong = 0.0
            if roll == 0.0:
                wrong += max(0.0, abs(hold_roll) - par[CONTOUR] * n)
            elif f == 0.0:
                # If it starts to roll without acceleration, tilting will turn it.
                wrong += max(0.0, -roll * (work[3] if y[1] != 0.0 or work[3] != 0.0 else -P * work[1]))
            if turn == 0.0:
                wrong += max(0.0, abs(hold_turn) - par[PIVOTING] * n)
            elif turn_zero and par[PIVOTING] > 0.0:
                wrong += max(0.0, -turn * (work[2] + math.sin(y[0]) * work[3] + math.cos(y[0]) * y[1] * f))
            if wrong < best:
                best, found_roll, found_turn = wrong, roll, turn
    mode[ROLL], mode[TURN] = found_roll, found_turn
    return 0.0


@njit(cache=True)
def break_away(y, par, mode, work):
    """Start a spinning disk that rolling friction cannot hold: write mode and state after a first moment."""
    mode[TURN], mode[LEAN] = sign(y[2]), sign(y[0])
    mode[ROLL] = 0.0
    n, _, _, hold_roll, _ = slopes(y, mode, par, work)
    if mode[LEAN] * work[1] > 0.0 and abs(hold_roll) <= par[CONTOUR] * n:
        if par[CONTOUR] > 0.0:
            return 0.0
        mode[ROLL] = -sign(work[1] * y[2])
    else:
        # Friction is along the direction d of acceleration: d turns until both agree.
        mode[ROLL] = -sign(hold_roll)
        C = math.cos(y[0])
        low, high = 0.0, 0.5 * math.pi
        for _ in range(100):
            angle = 0.5 * (low + high)
            y[1], y[3] = mode[LEAN] * math.cos(angle) * 1e-150, mode[ROLL] * math.sin(angle) * 1e-150 / C
            slopes(y, mode, par, work)
            ahead = mode[ROLL] * C * work[3] * math.cos(angle) - mode[LEAN] * work[1] * math.sin(angle)
            low, high = (angle, high) if ahead > 0.0 else (low, angle)
    # Long enough that the rates are not noise, short enough that nothing else has changed.
    first = min(1e-4, 1e-6 / math.hypot(work[1], work[3]))
    y[0] += 0.5 * first**2 * work[1]
    y[1], y[2], y[3] = first * work[1], y[2] + first * work[2], first * work[3]
    y[LOSSES + 1] += first * work[LOSSES + 1]
    y[HEADING] += first * y[2]
    return first


@njit(cache=True)
def rest_of_held(y, t, horizon, par):
    """Follow a disk held by rolling friction until it rests or time is over; return time and ending."""
    S, C, P, alpha = math.sin(y[0]), math.cos(y[0]), y[2], par[ALPHA]
    if P * P * abs(S) > par[FRICTION]:
        return t, SLIPS
    slowing = par[PIVOTING] / ((1.0 + alpha) * S * S + 0.5 * alpha * C * C)
    left, ending = horizon - t, TIME_OVER
    if P == 0.0 or (slowing > 0.0 and abs(P) / slowing <= left):
        left, ending = (abs(P) / slowing if P != 0.0 else 0.0), AT_REST
    turned = left * (P - 0.5 * sign(P) * slowing * left)
    y[2] = P - sign(P) * slowing * left if ending == TIME_OVER else 0.0
    y[HEADING] += turned
    y[LOSSES + 1] += par[PIVOTING] * abs(turned)
    return t + left, ending


@njit(cache=True)
def least_margin(y, h, k0, rules, space):
    """Return the least margin after a real step h from y with slopes k0; state and margins stay in `space`."""
    scratch, k, trial, margin = space
    k[0] = k0
    step(y, h, rules[0], rules[1], k, trial)
    margins(trial, *rules, scratch, margin)
    return margin.min()


@njit(cache=True)
def sampled(y, h, k0, new, k1, rules, scratch, trial, seen):
    """Write the margins at equal intervals within a step, with states interpolated by cubics."""
    for j in range(_SAMPLES + 1):
        u = j / _SAMPLES
        a, b, c = u * u * (3.0 - 2.0 * u), h * u * (1.0 - u) ** 2, h * u * u * (u - 1.0)
        for i in range(4):
            trial[i] = y[i] + a * (new[i] - y[i]) + b * k0[i] + c * k1[i]
        margins(trial, *rules, scratch, seen[j])


@njit(cache=True)
def dip(seen, j):
    """Return where (in sample intervals) a margin may be negative between samples j-1 and j, or j if nowhere."""
    for which in range(MARGINS):
        for middle in (max(j - 1, 1), min(j, _SAMPLES - 1)):
            left, here, right = seen[middle - 1, which], seen[middle, which], seen[middle + 1, which]
            bend, slope = right - 2.0 * here + left, 0.5 * (right - left)
            if bend > 0.0:
                place = middle - slope / bend
                least = here - 0.5 * slope * slope / bend
                if j - 1 < place < j and least < 1e-3 * (left + right):
                    return place
    return float(j)


@njit(cache=True)
def first_event(y, h, k0, new, rules, space, seen):
    """Return how far of a step h from y (to `new`, with slopes in k[-1]) no margin is negative, and the event.

    After an event the state just beyond it is in `space`; without one (-1) all of h is free.
    """
    scratch, k, trial, margin = space
    k1 = k[_STAGES].copy()
    sampled(y, h, k0, new, k1, rules, scratch, trial, seen)
    low = 0.0
    for j in range(1, _SAMPLES + 1):
        place = dip(seen, j)
        high = place / _SAMPLES * h
        if place == j or least_margin(y, high, k0, rules, space) >= 0.0:
            high = j / _SAMPLES * h
            if seen[j].min() >= 0.0 or least_margin(y, high, k0, rules, space) >= 0.0:
                low = high
                continue
        # Interpolation may have missed it before an earlier sample.
        while low > 0.0 and least_margin(y, low, k0, rules, space) < 0.0:
            low, high = max(0.0, low - h / _SAMPLES), low
        while low < 0.5 * (low + high) < high:
            middle = 0.5 * (low + high)
            if least_margin(y, middle, k0, rules, space) < 0.0:
                high = middle
            else:
                low = middle
        least_margin(y, high, k0, rules, space)
        return high, int(margin.argmin())
    k[_STAGES] = k1
    return h, -1


@njit(cache=True)
def turning_point(y, h, new, k0, mode, par, k, trial):
    """Return the tilt where the tilt rate vanishes within a step, by Newton's iteration with real steps."""
    at = h * y[1] / (y[1] - new[1])
    for _ in range(5):
        k[0] = k0
        step(y, at, mode, par, k, trial)
        at = min(max(at - trial[1] / k[_STAGES, 1], 0.0), h)
    return trial[0]


@njit(cache=True)
def follow(y, par, horizon, flat, center, limit, rtol, measures):
    """Follow a motion from y to its ending and return its code; everything is scaled.

    Written to measures: extreme tilts, time, first breach, largest energy imbalance, steps, switches.
    """
    n = y.size
    k, new, trial = np.zeros((_STAGES + 1, n)), np.zeros(n), np.zeros(n)
    scratch, k0, mode, margin = np.zeros(n), np.zeros(n), np.zeros(3), np.zeros(MARGINS)
    space, seen = (scratch, k, trial, margin), np.zeros((_SAMPLES + 1, MARGINS))
    atol = rtol * min(1.0, max(abs(y[0]) + abs(y[1]), 1e-8))
    t, h, total, steps, switches = 0.0, 1e-3, energy(y, par[ALPHA]), 0, 0
    measures[0], measures[1], measures[2:] = y[0], y[0], 0.0
    measures[3] = np.nan
    ending, deciding, turn_zero, halved = RUNS_ON, True, False, False
    if y[0] == 0.0 and y[1] == 0.0 and y[2] * y[3] == 0.0:
        return UNDISTURBED
    while ending == RUNS_ON:
        if deciding:
            deciding = False
            passed, turn_zero = decide(y, turn_zero, par, mode, scratch), False
            if passed == np.inf:
                t, ending = rest_of_held(y, t, horizon, par)
                break
            margins(y, mode, par, flat, center, limit, scratch, margin)
            if margin[LIFT] <= 0.0 or margin[SLIP] < 0.0 or margin[FLAT] < 0.0:
                ending = LIFTS if margin[LIFT] <= 0.0 else (SLIPS if margin[SLIP] < 0.0 else FLAT_DOWN)
                break
            t += passed
        slopes(y, mode, par, k0)
        h = min(h, horizon - t)
        k[0] = k0
        step(y, h, mode, par, k, new)
        error = error_norm(y, new, h, k, rtol, atol)
        if not error < 1.0:
            h *= max(0.2, 0.9 * error**-0.125) if error < np.inf else 0.2
            halved = True
            if h < 1e-15 * max(t, 1e-6):
                return LOST
            continue
        steps += 1
        if steps > _MOST_STEPS:
            return LOST
        free, event = first_event(y, h, k0, new, (mode, par, flat, center, limit), space, seen)
        if event != -1:
            new[:] = trial
        if y[1] * new[1] < 0.0:
            peak = turning_point(y, free, new, k0, mode, par, k, trial)
            measures[0], measures[1] = min(measures[0], peak), max(measures[1], peak)
        t += free
        y[:] = new
        if par[PIVOTING] > 0.0 and mode[TURN] == 0.0:
            # Step errors must not make a held rate drift.
            y[2] = -y[3] * math.sin(y[0])
        measures[0], measures[1] = min(measures[0], y[0]), max(measures[1], y[0])
        lost = y[LOSSES:PLACE].sum()
        measures[4] = max(measures[4], abs(energy(y, par[ALPHA]) + lost - total))
        if event == -1:
            growth = 10.0 if error == 0.0 else min(10.0, 0.9 * error**-0.125)
            h *= min(growth, 1.0) if halved else growth
            halved = False
            # A tilt almost at rest at the start may turn twice within a long step, unnoticed.
            h = min(h, _FIRST_STEPS) if t < _AT_FIRST else h
            ending = TIME_OVER if t >= horizon else ending
        elif event == FLAT:
            ending = FLAT_DOWN
        elif event == LIFT:
            ending = LIFTS
        elif event == SLIP:
            ending = SLIPS
        elif event == BREACH:
            measures[3], limit = t, np.inf
        else:
            switches += event != CONTOUR_KEEPS or par[CONTOUR] > 0.0
            deciding, turn_zero = switch(event, y, mode, par, scratch)
            h *= 0.1
    measures[2], measures[5], measures[6] = t, steps, switches
    return ending


@njit(cache=True)
def switch(event, y, mode, par, work):
    """Change the mode at a release, or zero the vanished rate; return whether to decide, and whether v is zero."""
    _, _, _, hold_roll, hold_turn = slopes(y, mode, par, work)
    if event == CONTOUR_KEEPS and mode[ROLL] == 0.0:
        # The held coordinate moves against the force that held it.
        mode[ROLL] = -sign(hold_roll)
        return False, False
    if event == PIVOT_KEEPS and mode[TURN] == 0.0:
        mode[TURN] = -sign(hold_turn)
        return False, False
    if event == PIVOT_KEEPS:
        y[2] = -y[3] * math.sin(y[0])
        return True, True
    if event == CONTOUR_KEEPS:
        y[3] = 0.0
    elif event == LANDS:
        y[1], y[3] = 0.0, 0.0
        if mode[TURN] == 0.0 and par[PIVOTING] > 0.0:
            y[2] = 0.0
    return True, par[PIVOTING] > 0.0 and mode[TURN] == 0.0
