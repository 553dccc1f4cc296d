"""Compare the contact extremes of many cells with an integration in time that shares no code with the project.

    python scripts/audit_contact.py rolling [EVERY]         the preset, every so many cells; spinning, circling likewise
    python scripts/audit_contact.py random [COUNT] [SEED]   random starts over six decades of rates
    python scripts/audit_contact.py grazing [COUNT] [SEED]  random starts whose normal force nearly vanishes

Each motion is integrated by Taylor series of order 20 in time, in the tilt, its rate, the precession rate and the roll
rate, from its start forward and backward to the turning points, the fall, or the end of the duration. The forces are
Newton's: mass times acceleration of the centre, by differentiating its position. They are sampled 32 times per step,
and extremes between samples are found by golden sections. Mirror images and reversed motions are compared bit by bit.
Exit status 1 if the values are not within 1e-6 (1 + |x|), or too many are left unresolved.
"""

import math
import re
import sys
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from numba import njit, prange

from kernels.bodies.arrays import LIFTS_OFF, PRESSES, UNRESOLVED_FORCES
from kernels.disk.arrays import PARAMETERS
from kernels.disk.endings import BOUNDED, FELL, HORIZON
from sweep.engine.compute import compute
from sweep.engine.grid import Span, starts_of
from sweep.request.spec import SweepSpec

_ORDER, _SAMPLES, _MOST_STEPS = 20, 32, 200_000
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

#: Promised error divided by 1 + |value|; largest share of unresolved cells, for random cells and for a preset.
_PROMISED, _MOST_RANDOM, _MOST_OF_PRESET = 1e-6, 0.01, 0.001

#: The parts of the audit, and the number of cells in a batch.
_PRESETS, _RANDOM, _BATCH = ("rolling", "spinning", "circling"), ("random", "grazing"), 20_000

Array = npt.NDArray[np.float64]
Columns = dict[str, npt.NDArray[np.float64]]


@njit
def _expand(y, alpha):  # type: ignore[no-untyped-def]  # compiled
    """Compute the series of tilt, tilt rate, precession rate, roll rate (rows 0 to 3) in scaled time."""
    th, w, p, r, sin, cos, sec, tan, rw, pr, psin, pcos, tanw = y
    sin[0], cos[0] = math.sin(th[0]), math.cos(th[0])
    sec[0] = 1.0 / cos[0]
    for k in range(_ORDER):
        tan[k] = rw[k] = pr[k] = psin[k] = pcos[k] = 0.0
        for i in range(k + 1):
            tan[k] += sin[i] * sec[k - i]
            rw[k] += r[i] * w[k - i]
            pr[k] += p[i] * r[k - i]
            psin[k] += p[i] * sin[k - i]
            pcos[k] += p[i] * cos[k - i]
        tanw[k] = push = turn = down = up = spin_up = drag = out = 0.0
        for i in range(k + 1):
            tanw[k] += tan[i] * w[k - i]
        for i in range(k + 1):
            j = k - i
            push += psin[i] * pcos[j] + 2.0 * (1.0 + alpha) / (2.0 + alpha) * pr[i] * cos[j]
            turn += rw[i] * sec[j]
            up += cos[i] * w[j]
            down += sin[i] * w[j]
            spin_up += rw[i] * tan[j]
            drag += pcos[i] * w[j]
            out += sec[i] * tanw[j]
        q = 1.0 / (k + 1)
        th[k + 1] = q * w[k]
        w[k + 1] = q * (2.0 / (2.0 + alpha) * sin[k] + push)
        p[k + 1] = -2.0 * q * turn
        r[k + 1] = q * (2.0 * spin_up - (2.0 + alpha) / (1.0 + alpha) * drag)
        sin[k + 1], cos[k + 1], sec[k + 1] = q * up, -q * down, q * out


@njit
def _evaluate(y, row, t):  # type: ignore[no-untyped-def]  # compiled
    value = 0.0
    for k in range(_ORDER, -1, -1):
        value = value * t + y[row, k]
    return value


@njit
def _forces(y, t, alpha):  # type: ignore[no-untyped-def]  # compiled
    """Return normal force / weight, and the needed friction coefficient (infinite where the force is not positive)."""
    th, w, p, r = _evaluate(y, 0, t), _evaluate(y, 1, t), _evaluate(y, 2, t), _evaluate(y, 3, t)
    sin, cos = math.sin(th), math.cos(th)
    w1 = 2.0 / (2.0 + alpha) * sin + p * p * sin * cos + 2.0 * (1.0 + alpha) / (2.0 + alpha) * p * r * cos
    p1 = -2.0 * r * w / cos
    r1 = w * (2.0 * r * sin / cos - (2.0 + alpha) / (1.0 + alpha) * p * cos)
    normal = 1.0 - (w1 * sin + w * w * cos)
    across = -r * p + (cos * w1 - sin * w * w) - sin * p * p
    along = r1 + 2.0 * cos * w * p + sin * p1
    return normal, (math.hypot(across, along) / normal if normal > 0.0 else math.inf)


@njit
def _golden(y, low, high, alpha, which):  # type: ignore[no-untyped-def]  # compiled
    """Return the time between two others with the least normal force (which = 0) or the largest coefficient (1)."""
    a, b = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    sign = 1.0 if which == 0 else -1.0
    at_a, at_b = sign * _forces(y, a, alpha)[which], sign * _forces(y, b, alpha)[which]
    for _ in range(60):
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - _GOLDEN * (high - low)
            at_a = sign * _forces(y, a, alpha)[which]
        else:
            low, a, at_a = a, b, at_b
            b = low + _GOLDEN * (high - low)
            at_b = sign * _forces(y, b, alpha)[which]
    return 0.5 * (low + high)


@njit
def _search(y, first, end, count, alpha, best):  # type: ignore[no-untyped-def]  # compiled
    """Find the extremes of the forces between two times of a step: samples, and golden sections between them."""
    d = (end - first) / count
    n2 = n1 = f2 = f1 = math.nan
    for i in range(count + 1):
        t = first + i * d
        n, f = _forces(y, t, alpha)
        best[0], best[1] = min(best[0], n), max(best[1], f)
        if i > 1 and n1 <= n2 and n1 <= n:
            low = _golden(y, t - 2.0 * d, t, alpha, 0)
            least, needed = _forces(y, low, alpha)
            best[0], best[1] = min(best[0], least), max(best[1], needed)
            if least > 0.0:
                # a peak that is narrower than the distance of the samples is next to the least normal force
                for width in (d, 0.03 * d, 0.001 * d):
                    peak = _golden(y, max(first, low - width), min(end, low + width), alpha, 1)
                    best[1] = max(best[1], _forces(y, peak, alpha)[1])
        if i > 1 and f1 >= f2 and f1 >= f and f1 < math.inf:
            peak = _golden(y, t - 2.0 * d, t, alpha, 1)
            best[1] = max(best[1], _forces(y, peak, alpha)[1])
        n2, n1, f2, f1 = n1, n, f1, f
    # an extreme between the last two samples at either end has no sample beyond it
    for low in (first, end - d):
        for which in range(2):
            n, f = _forces(y, _golden(y, low, low + d, alpha, which), alpha)
            best[0], best[1] = min(best[0], n), max(best[1], f)


@njit
def _crossing(y, row, level, low, high, sign):  # type: ignore[no-untyped-def]  # compiled
    """Return the time at which a row passes a level: sign (row - level) is positive at `low`, not at `high`."""
    for _ in range(60):
        t = 0.5 * (low + high)
        if sign * (_evaluate(y, row, t) - level) > 0.0:
            low = t
        else:
            high = t
    return 0.5 * (low + high)


@njit
def _step(y):  # type: ignore[no-untyped-def]  # compiled
    """Return the length of a step, for which the last term of each series is 1e-17 of the first ones."""
    rates = max(1e-3, abs(y[1, 0]), abs(y[2, 0]), abs(y[3, 0]))
    steepest = 0.0
    for row in range(4):
        size = rates if row > 0 else 1.0
        for k in (_ORDER - 1, _ORDER):
            steepest = max(steepest, (abs(y[row, k]) / (1e-17 * size)) ** (1.0 / k))
    return min(1.0, 1.0 / steepest) if steepest > 0.0 else 1.0


@njit
def _leg(start, alpha, fall, most, y, best):  # type: ignore[no-untyped-def]  # compiled
    """Follow a start until it turns, falls or reaches the time `most`; return (ending, tilt there, time)."""
    for row in range(4):
        y[row, 0] = start[row]
    t, heading = 0.0, 0.0
    for number in range(_MOST_STEPS):
        _expand(y, alpha)
        h = min(_step(y), most - t)
        if heading == 0.0:
            heading = math.copysign(1.0, y[1, 0]) if y[1, 0] != 0.0 else math.copysign(1.0, y[1, 1])
        ending, end, d = 0, h, h / _SAMPLES
        for i in range(1, _SAMPLES + 1):
            there = min(h, i * d)
            if heading * _evaluate(y, 1, there) < 0.0:
                ending, end = BOUNDED, _crossing(y, 1, 0.0, there - d, there, heading)
            if abs(_evaluate(y, 0, end if ending else there)) >= fall:
                sign = math.copysign(1.0, _evaluate(y, 0, there))
                ending, end = FELL, _crossing(y, 0, sign * fall, there - d, there, -sign)
            if ending:
                break
        first = 0.0 if number == 0 else -d
        last = end if ending else h
        _search(y, first, last, max(3, math.ceil((last - first) / d)), alpha, best)
        if ending:
            return ending, _evaluate(y, 0, end), t + end
        t += h
        if t >= most:
            return HORIZON, _evaluate(y, 0, h), t
        for row in range(4):
            y[row, 0] = _evaluate(y, row, h)
    return 0, math.nan, t


@njit(parallel=True)
def _refer(starts, units, alphas, fall, duration, results):  # type: ignore[no-untyped-def]  # compiled
    """Write ending, extreme tilts, least normal force and largest coefficient of every cell."""
    for cell in prange(alphas.size):
        y, best, alpha = np.zeros((13, _ORDER + 1)), np.array([math.inf, 0.0]), alphas[cell]
        start, most = starts[:, cell].copy(), duration / units[cell]
        ending, first, t = _leg(start, alpha, fall, most, y, best)
        second = start[0]
        if ending == BOUNDED and start[1] != 0.0:
            # backward in time, all rates change their signs
            start[1], start[2], start[3] = -start[1], -start[2], -start[3]
            if most > 2.0 * t:
                ending, second, _ = _leg(start, alpha, fall, most - 2.0 * t, y, best)
            else:
                ending = HORIZON
        results[0, cell] = ending
        results[1, cell], results[2, cell] = (
            min(first, second, starts[0, cell]),
            max(first, second, starts[0, cell]),
        )
        results[3, cell], results[4, cell] = best[0], best[1]


def random_starts(count: int, rng: np.random.Generator) -> Columns:
    """Return random starts for every kind of disk and gravity, with rates over six decades, some of them zero."""
    radius, gravity = 10.0 ** rng.uniform(-3, 2, count), 10.0 ** rng.uniform(-1, 1.5, count)
    unit = np.sqrt(radius / gravity)

    def rate() -> Array:
        found = rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-3, 3, count) / unit
        return np.where(rng.random(count) < 0.1, 0.0, found)

    return {
        "tilt": np.where(rng.random(count) < 0.2, 10.0 ** rng.uniform(-8, -1, count), rng.uniform(-1.45, 1.45, count)),
        "tilt_rate": rate(),
        "precession_rate": rate(),
        "roll_rate": rate(),
        "alpha": rng.uniform(0.02, 1.0, count),
        "radius": radius,
        "gravity": gravity,
    }  # fmt: skip


def grazing_starts(count: int, rng: np.random.Generator, spec: SweepSpec) -> Columns:
    """Return random starts whose rates are scaled so that the least normal force is positive and almost zero."""
    fast = random_starts(8 * count, rng)
    rates = PARAMETERS[1:4]
    slow = {name: values * (1e-3 if name in rates else 1.0) for name, values in fast.items()}
    lifts, presses = (compute(spec, each)["least_normal_force"] for each in (fast, slow))
    chosen = np.flatnonzero((lifts < 0.0) & (presses > 0.0))[:count]
    fast = {name: values[chosen] for name, values in fast.items()}
    low, high, halvings = np.full(chosen.size, 1e-3), np.ones(chosen.size), rng.integers(5, 48, chosen.size)
    for number in range(halvings.max(initial=0)):
        middle = 0.5 * (low + high)
        force = compute(spec, _scale_rates(fast, middle))["least_normal_force"]
        low = np.where((number < halvings) & (force > 0.0), middle, low)
        high = np.where((number < halvings) & ~(force > 0.0), middle, high)
    return _scale_rates(fast, low)


def _scale_rates(starts: Columns, factor: Array) -> Columns:
    return {name: values * (factor if name in PARAMETERS[1:4] else 1.0) for name, values in starts.items()}


def reference(starts: Columns, spec: SweepSpec) -> Array:
    """Return ending, extreme tilts [rad], least normal force and needed friction from the integration in time."""
    unit = np.sqrt(starts["radius"] / starts["gravity"])
    rows = np.stack([starts["tilt"], *(starts[name] * unit for name in PARAMETERS[1:4])])
    results = np.empty((5, unit.size))
    _refer(rows, unit, starts["alpha"], float(spec.fall_tilt), float(spec.duration), results)
    return results


def images(starts: Columns) -> Iterator[Columns]:
    """Yield the two mirror images of starts, and the reversed motions, which pass the same tilts backward."""
    yield {
        **starts,
        "tilt": -starts["tilt"],
        "tilt_rate": -starts["tilt_rate"],
        "roll_rate": -starts["roll_rate"],
    }
    yield {**starts, "precession_rate": -starts["precession_rate"], "roll_rate": -starts["roll_rate"]}
    yield {**starts, "tilt_rate": -starts["tilt_rate"]}


class Tally:
    """The counts of the audit."""

    def __init__(self) -> None:
        self.cells = self.moving = self.unresolved = self.other = self.wrong = self.unlike = 0
        self.largest = {"least_normal_force": 0.0, "friction_needed": 0.0}
        self.worst: list[tuple[float, str]] = []

    def add(self, spec: SweepSpec, starts: Columns) -> None:
        """Compare some cells with the reference, and their images with the cells."""
        found, expected = compute(spec, starts), reference(starts, spec)
        state, moves = found["contact_state"], np.isin(found["ending"], (BOUNDED, HORIZON, FELL))
        self.cells += moves.size
        self.moving += int(moves.sum())
        self.unresolved += int((state[moves] == UNRESOLVED_FORCES).sum())
        same = moves & (expected[0] == found["ending"])
        for row, name in ((1, "tilt_min"), (2, "tilt_max")):
            same &= ~(np.abs(expected[row] - found[name]) > 1e-6)
        self.other += int((moves & ~same).sum())
        checked = same & ((state == PRESSES) | (state == LIFTS_OFF))
        wrong = checked & ((state == PRESSES) != (expected[3] > 0.0)) & (np.abs(expected[3]) > _PROMISED)
        for name, true in (("least_normal_force", expected[3]), ("friction_needed", expected[4])):
            known = checked & ~wrong & np.isfinite(found[name])
            off = np.abs(found[name] - true) / (1.0 + np.abs(true))
            self.largest[name] = max(self.largest[name], float(off[known].max(initial=0.0)))
            wrong |= known & ~(off <= _PROMISED)
            for cell in np.flatnonzero(known & ~(off <= _PROMISED))[:5]:
                words = " ".join(f"{key}={float(values[cell])!r}" for key, values in starts.items())
                self.worst.append(
                    (float(off[cell]), f"{name} {found[name][cell]:.9g}, true {true[cell]:.9g}: {words}")
                )
        self.wrong += int(wrong.sum())
        for number, image in enumerate(images(starts)):
            other = compute(spec, image)
            # a reversed motion that falls or reaches the time limit is a different motion
            alike = moves & ((found["ending"] == BOUNDED) & (other["ending"] == BOUNDED) | (number < 2))
            for name in (*self.largest, "contact_state"):
                unlike = (
                    alike & (other[name] != found[name]) & ~(np.isnan(other[name]) & np.isnan(found[name]))
                )
                self.unlike += int(unlike.sum())

    def status(self, most: float) -> int:
        """Print the counts; return 0 if the promises hold and at most the share `most` of the cells is unresolved."""
        print(self.report())
        return int(self.wrong > 0 or self.unlike > 0 or self.unresolved > most * self.moving)

    def report(self) -> str:
        """Return the counts as text."""
        lines = [
            f"cells                     {self.cells}, with a motion {self.moving}",
            f"unresolved                {self.unresolved} ({self.unresolved / max(1, self.moving):.4%})",
            f"tilts that differ from the reference (not judged) {self.other}",
            *(
                f"largest error of {name}, divided by 1 + |x|: {off:.2e}"
                for name, off in self.largest.items()
            ),
            f"errors above {_PROMISED:g} (1 + |x|)       {self.wrong}",
            f"images that differ in a bit            {self.unlike}",
            *(text for _, text in sorted(self.worst, reverse=True)[:8]),
        ]
        return "\n".join(lines)


def audit_preset(name: str, every: int = 1) -> int:
    """Audit every n-th cell of a preset; return the exit status."""
    tally, spec = Tally(), SweepSpec.preset(name).replace(contact="yes")
    for begin in range(0, spec.size, _BATCH * every):
        span = Span(begin, min(spec.size, begin + _BATCH * every))
        tally.add(spec, {key: values[::every] for key, values in starts_of(spec, span).items()})
    return tally.status(_MOST_OF_PRESET)


def audit_random(part: str, count: int = _BATCH, seed: int = 1) -> int:
    """Audit random or grazing starts; return the exit status."""
    tally, spec = Tally(), SweepSpec().replace(contact="yes", duration=3600.0)
    rng = np.random.default_rng(seed)
    for begin in range(0, count, _BATCH):
        batch = min(count - begin, _BATCH)
        tally.add(spec, grazing_starts(batch, rng, spec) if part == "grazing" else random_starts(batch, rng))
    # grazing starts are chosen so that coefficients are hard to find
    return tally.status(1.0 if part == "grazing" else _MOST_RANDOM)


def main(words: list[str]) -> int:
    """Run the requested part, or print which parts there are; return the exit status."""
    if words and words[0] in ("-h", "--help"):
        print(__doc__)
        return 0
    part, *rest = words or [""]
    audit = audit_preset if part in _PRESETS else audit_random if part in _RANDOM else None
    numbers = [int(word) for word in rest if re.fullmatch("[0-9]{1,18}", word)]
    if (
        audit is None
        or len(numbers) < len(rest)
        or len(rest) > (1 if part in _PRESETS else 2)
        or 0 in numbers[:1]
    ):
        print(__doc__, file=sys.stderr)
        return 2
    return audit(part, *numbers)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
