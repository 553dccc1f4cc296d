"""Compare extreme tilts of many cells, their stated errors, refined boundaries and periods with the exact reduction.

    python scripts/audit_extremes.py errors [CELLS] [SEED]        stated against true errors, six kinds of random starts
    python scripts/audit_extremes.py separatrices [COUNT] [SEED]  starts beside separatrices: nothing wrong is bounded
    python scripts/audit_extremes.py tiny [CELLS] [SEED]          tilts and kicks below 1e-8: few steps
    python scripts/audit_extremes.py brackets [ROWS] [SEED]       refined boundaries: both ends of each bracket
    python scripts/audit_extremes.py periods [COUNT] [SEED]       periods and stated errors of the reduction, ten kinds

The reduction in double precision is itself compared with 50 digits (tests/turning_reference.py, which imports nothing
from the project): a sample of every kind, all cells that double precision leaves open, and all brackets. `periods`
compares it with quadruple precision (quadruple.py, COUNT cells of each kind, 4 ms each) and 50 digits (one, and one per
thousand of COUNT), or with 50 digits only where no compiler knows quadruple precision. Exit status 1 if a promise is
broken.
"""

import math
import sys
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import quadruple

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import disk_reduction
import kernel_runner
import referee
import turning_reference as digits

import sweep
from kernels.bodies.arrays import REDUCED
from kernels.disk.arrays import PARAMETERS, TILT_RATE
from kernels.disk.endings import BOUNDED, FELL, UNRESOLVED
from sweep.engine.compute import reach_and_scale
from sweep.engine.grid import completed, whole
from sweep.model.description import Starts
from sweep.model.quantity import STABLE, UNSTABLE, Array

FALL = math.radians(89.0)

#: Promised: share of cells whose true error is more than twice the stated one; median of stated / true error. The
#: nearly flat kind has the largest median, 33; for the others it is at most 7.
MOST_BEYOND, MOST_CAUTION = 1e-3, 50.0

#: Promised: share of random cells that may be unresolved; number of steps of a tiny start.
MOST_UNRESOLVED, MOST_STEPS = 1e-2, 1e5

#: Promised: relative error of a period of the reduction; share of the bounded cells of a kind that may have no period,
#: which are next to separatrices. Of 4,000 starts near 26 separatrices it was 0.52 to 0.77 (60 seeds), of 4,000 nearly
#: steady ones 0.07 to 0.09 (16 seeds).
PERIOD_ERROR, MOST_WITHOUT = 1e-9, {"beside separatrices": 0.9, "nearly steady": 0.12}

#: True errors below this [rad] are errors of the reference.
NOISE = 1e-13


def spread(rng: np.random.Generator, n: int, low: float, high: float) -> Array:
    """Return numbers of both signs, with magnitudes from 10^low to 10^high."""
    return rng.choice((-1.0, 1.0), n) * 10.0 ** rng.uniform(low, high, n)


def random_starts(kind: str, n: int, rng: np.random.Generator) -> Any:
    """Return scaled starts of one kind: radius and gravity are 1."""
    tilt, alpha = rng.uniform(-1.45, 1.45, n), rng.uniform(0.02, 1.0, n)
    some, most = rng.random(n) < 0.7, rng.random(n) < 0.9
    if kind == "six decades":
        rates = [spread(rng, n, -3, 3) * some, spread(rng, n, -3, 3) * most, spread(rng, n, -3, 3)]
    elif kind == "moderate":
        rates = [rng.normal(0, 3, n) for _ in range(3)]
    elif kind == "fast":
        rates = [spread(rng, n, 0, 3) for _ in range(3)]
    elif kind == "slow":
        rates = [rng.uniform(-1.5, 1.5, n) * some, rng.uniform(-3, 3, n) * most, rng.uniform(-3, 3, n)]
    elif kind == "nearly upright":
        tilt = spread(rng, n, -6, -1)
        rates = [spread(rng, n, -6, -1) * some, rng.normal(0, 1.5, n) * most, rng.normal(0, 1.5, n)]
    else:
        tilt = rng.choice((-1, 1), n) * (0.5 * np.pi - 10.0 ** rng.uniform(-1.6, -0.5, n))
        rates = [spread(rng, n, -3, 1), spread(rng, n, -2, 2), spread(rng, n, -2, 2)]
    names = ("tilt_rate", "precession_rate", "roll_rate")
    return referee.starts(
        tilt=tilt, alpha=alpha, radius=1.0, gravity=1.0, **dict(zip(names, rates, strict=True))
    )


KINDS = ("six decades", "moderate", "fast", "slow", "nearly upright", "nearly flat")


def exact(given: Array, fall: float = FALL, with_period: bool = False) -> dict[str, Any]:
    """Return measures and counts of the exact reduction by name."""
    measures, counts = disk_reduction.extremes(given, fall, with_period)
    return dict(zip((*REDUCED, "ending", "wells"), (*measures, *counts), strict=True))


def true_errors(found: Any, low: Array, high: Array) -> Array:
    """Return the larger difference of the two extremes [rad]."""
    return np.asarray(np.maximum(np.abs(found.least - low), np.abs(found.greatest - high)))


def fifty_digits(given: Array, cells: Iterable[int], fall: float = FALL) -> Array:
    """Return extreme tilts of some cells from 50 digits, rounded to doubles; fall_tilt where the disk falls."""
    digits.mp.dps = 50
    ends = []
    for cell in cells:
        low, high = digits.extremes([float(x) for x in given[:, cell]], fall)
        ends.append((-fall if low is None else float(low), fall if high is None else float(high)))
    return np.array(ends).reshape(-1, 2).T


def audit_errors(cells: int, rng: np.random.Generator) -> bool:
    """Print the distribution of stated over true errors for every kind of start; return whether every promise holds."""
    fine = True
    print(
        "kind               cells bounded  beyond 2x  99.9 % of true/stated  median stated/true  worst of 50 digits"
    )
    for kind in KINDS:
        given = random_starts(kind, cells // len(KINDS), rng)
        found, truth = kernel_runner.run(given, duration=1e4, fall_tilt=FALL), exact(given)
        both = (found.ending == BOUNDED) & (truth["ending"] == BOUNDED)
        wrong = true_errors(found, truth["tilt_min"], truth["tilt_max"])
        beyond = both & (wrong > 2.0 * (found.tilt_error + truth["tilt_error"]))
        share = np.maximum(0.0, wrong - 2.0 * truth["tilt_error"])[both] / found.tilt_error[both]
        seen = both & (wrong > NOISE)
        caution = np.median(found.tilt_error[seen] / wrong[seen])
        sample = rng.choice(np.flatnonzero(both), min(20, 1 + cells // 50_000), replace=False)
        low, high = fifty_digits(given, sample)
        with np.errstate(invalid="ignore"):
            ratio = np.maximum(np.abs(found.least[sample] - low), np.abs(found.greatest[sample] - high))
        ratio = (ratio - 1e-15) / found.tilt_error[sample]
        bad = beyond.sum() / both.sum()
        fine &= bool(bad <= MOST_BEYOND and caution <= MOST_CAUTION and ratio.max() <= 2.0)
        print(
            f"{kind:15s} {given.shape[1]:9d} {both.sum():7d} {bad:10.6f} {np.quantile(share, 0.999):22.2f} "
            f"{caution:19.1f} {ratio.max():19.2f}"
        )
    return fine


def separatrices(count: int, rng: np.random.Generator) -> Array:
    """Return starts whose energy equals the maximum of their potential, except for a share of 1e-15 to 1e-2."""
    made: list[tuple[Array, float]] = []
    while len(made) < count:
        n = 4000
        given = referee.starts(
            tilt=spread(rng, n, -3, -0.2), tilt_rate=1e-6,
            precession_rate=rng.normal(0, 0.6, n) * (rng.random(n) < 0.7),
            roll_rate=rng.normal(0, 0.5, n) * (rng.random(n) < 0.8),
            alpha=rng.uniform(0.02, 1.0, n), radius=1.0, gravity=1.0,
        )  # fmt: skip
        behind = np.flatnonzero(exact(given)["separatrix"] > 1e-5)
        rates = disk_reduction.rates_to_maxima(given[:, behind], FALL)
        made += [(given[:, i], w) for i, w in zip(behind, rates, strict=True)]
    shares = np.concatenate([sign * 10.0 ** rng.uniform(-15, -2, 40) for sign in (-1.0, 1.0)])
    crowd = []
    for start, rate in made[:count]:
        for side in (-1.0, 1.0):
            group = np.repeat(start[:, None], shares.size, 1)
            group[TILT_RATE] = side * rate * (1.0 + shares)
            crowd.append(group)
    return np.concatenate(crowd, axis=1)


def audit_separatrices(
    count: int, rng: np.random.Generator, most_unresolved: float = MOST_UNRESOLVED
) -> bool:
    """Check that no bounded cell near a separatrix is wrong by more than twice its stated error."""
    given = separatrices(count, rng)
    found, truth = kernel_runner.run(given, duration=1e4, fall_tilt=FALL), exact(given)
    sure = (truth["ending"] == FELL) | ((truth["ending"] == BOUNDED) & (truth["tilt_error"] < 1e-9))
    wrong = true_errors(found, truth["tilt_min"], truth["tilt_max"])
    bounded = found.ending == BOUNDED
    beyond = bounded & sure & (wrong > 2.0 * (found.tilt_error + np.nan_to_num(truth["tilt_error"])))
    open_ = np.flatnonzero(bounded & ~sure)
    low, high = fifty_digits(given, open_)
    apart = np.maximum(np.abs(found.least[open_] - low), np.abs(found.greatest[open_] - high))
    late = apart > 2.0 * found.tilt_error[open_]
    falls = ((found.ending == FELL) != (truth["ending"] == FELL)) & (found.ending != UNRESOLVED) & sure
    unresolved = np.mean(found.ending == UNRESOLVED)
    print(
        f"{given.shape[1]} starts beside {count} separatrices: {beyond.sum() + late.sum()} bounded cells beyond "
        f"twice their error ({open_.size} of them judged by 50 digits), {falls.sum()} wrong falls, "
        f"{unresolved:.4%} unresolved, at most {found.steps.max()} steps"
    )
    return not (beyond.any() or late.any() or falls.any()) and unresolved <= most_unresolved


def audit_tiny(cells: int, rng: np.random.Generator) -> bool:
    """Check that tiny starts are computed correctly in few steps."""
    still = rng.random((4, cells)) < 0.7
    given = referee.starts(
        tilt=spread(rng, cells, -20, -8) * still[0], tilt_rate=spread(rng, cells, -20, -8) * still[1],
        precession_rate=rng.normal(0, 1.5, cells) * still[2], roll_rate=rng.normal(0, 1.5, cells) * still[3],
        alpha=rng.uniform(0.02, 1.0, cells), radius=1.0, gravity=1.0,
    )  # fmt: skip
    began = time.perf_counter()
    found, truth = kernel_runner.run(given, duration=1e4, fall_tilt=FALL), exact(given)
    seconds = time.perf_counter() - began
    both = (found.ending == BOUNDED) & (truth["ending"] == BOUNDED)
    wrong = true_errors(found, truth["tilt_min"], truth["tilt_max"])
    beyond = both & (wrong > 2.0 * (found.tilt_error + truth["tilt_error"]))
    unresolved = np.mean(found.ending == UNRESOLVED)
    print(
        f"{cells} tiny starts: at most {found.steps.max()} steps, {unresolved:.4%} unresolved, "
        f"{beyond.sum()} beyond twice their error, {seconds:.1f} s"
    )
    return found.steps.max() <= MOST_STEPS and unresolved <= MOST_UNRESOLVED and not beyond.any()


def random_request(rng: np.random.Generator) -> tuple[sweep.SweepSpec, str]:
    """Return a small atlas of a random preset, criterion, tolerance and bracket width, and a description of it."""
    kind = rng.choice(("rolling", "spinning", "circling"))
    kicked = kind != "circling" and rng.random() < 0.5
    rate = "roll_rate" if kind == "rolling" else "precession_rate"
    words = [f"alpha={rng.uniform(0.02, 1.0)}", f"tolerance=1e-{rng.integers(4, 11)}", "duration=3000s"]
    words.append("boundary=refined" + rng.choice(("", ":1e-12", ":1e-10", ":1e-7")))
    criterion = (f"departure:{rng.uniform(1, 50):g}deg", f"amplification:{rng.uniform(4, 40):g}")
    words.append("criterion=" + rng.choice(criterion))
    words.append(f"{rate}={'0.3:8:40' if kind == 'circling' else '0.5:12:80'}")
    if kicked:
        words += ["tilt=0", f"tilt_rate={10 ** rng.uniform(-4, -2)}:{10 ** rng.uniform(-1.9, 0)}:12:log"]
    else:
        words.append(f"tilt={10 ** rng.uniform(-4, -2)}:{10 ** rng.uniform(-1.9, -0.5)}:12:log")
    return sweep.SweepSpec.from_words(str(kind), words), rate


def exact_verdicts(spec: sweep.SweepSpec, starts: Starts) -> Any:
    """Return the verdicts of the criterion on extremes from 50 digits."""
    starts = completed(spec, starts)
    given = np.stack([starts[name] for name in PARAMETERS])
    low, high = fifty_digits(given, range(given.shape[1]), spec.fall_tilt)
    fell = (low <= -spec.fall_tilt) | (high >= spec.fall_tilt)
    measured = {"tilt_min": low, "tilt_max": high, "ending": np.where(fell, FELL, BOUNDED)}
    reach, scale = reach_and_scale(spec, starts, measured)
    measured |= {"peak_tilt": np.maximum(np.abs(low), np.abs(high)), "amplification": reach / scale}
    return spec.criterion.verdict(spec.model.endings, measured, reach, scale)


def audit_brackets(rows: int, rng: np.random.Generator) -> bool:
    """Check that both ends of every bracket have the verdicts that the atlas states."""
    seen = missed = 0
    while seen < rows:
        spec, rate = random_request(rng)
        atlas = sweep.run(spec)
        for name, inside, outside in (
            (f"boundary_{rate}", -1.0, 1.0),
            (f"boundary_lower_{rate}", 1.0, -1.0),
        ):
            if name not in atlas:
                continue
            middle, half = atlas[name].values, atlas[f"{name}_halfwidth"].values
            found = np.flatnonzero(np.isfinite(middle))
            starts = {key: each[found] for key, each in whole(spec.replace(**{rate: 1.0})).items()}
            ends = (
                exact_verdicts(spec, {**starts, rate: middle[found] + s * half[found]})
                for s in (inside, outside)
            )
            good = np.logical_and(
                *(verdict == code for verdict, code in zip(ends, (UNSTABLE, STABLE), strict=True))
            )
            for row in found[~good]:
                print(f"missed: {spec}, {name}, row {row}")
            seen, missed = seen + found.size, missed + int(np.count_nonzero(~good))
    print(f"{seen} refined rows: {missed} brackets without the true edge")
    return missed == 0


def nearly_steady(n: int, rng: np.random.Generator) -> Array:
    """Return starts next to steady motions at any tilt: the roll rate differs by a share of 1e-15 to 1e-1."""
    tilt, alpha, precession = spread(rng, n, -3, 0.16), rng.uniform(0.02, 1.0, n), spread(rng, n, -1.5, 2)
    sin, cos = np.sin(tilt), np.cos(tilt)
    rolling = (0.5 * alpha * precession**2 * cos - 1.0) * sin / ((1.0 + alpha) * precession * cos)
    still = rng.random((2, n)) < 0.5
    return np.asarray(referee.starts(
        tilt=tilt, tilt_rate=spread(rng, n, -12, -1) * still[0], alpha=alpha, precession_rate=precession,
        roll_rate=(rolling - precession * sin) * (1.0 + spread(rng, n, -15, -1) * still[1]),
        radius=1.0, gravity=1.0,
    ))  # fmt: skip


def far_outside(n: int, rng: np.random.Generator) -> Array:
    """Return starts over 24 decades of rates, and twelve of sizes and gravities."""
    radius, gravity = np.abs(spread(rng, n, -6, 6)), np.abs(spread(rng, n, -6, 6))
    unit, still = np.sqrt(gravity / radius), rng.random((3, n)) < 0.8
    return np.asarray(referee.starts(
        tilt=rng.uniform(-1.55, 1.55, n), tilt_rate=unit * spread(rng, n, -12, 12) * still[0],
        precession_rate=unit * spread(rng, n, -12, 12) * still[1],
        roll_rate=unit * spread(rng, n, -12, 12) * still[2],
        alpha=10.0 ** rng.uniform(-6, 0, n), radius=radius, gravity=gravity,
    ))  # fmt: skip


def nearly_massless(n: int, rng: np.random.Generator) -> Array:
    """Return starts of disks whose rim has almost no mass."""
    still = rng.random((3, n)) < 0.5
    return np.asarray(referee.starts(
        tilt=spread(rng, n, -9, 0), tilt_rate=spread(rng, n, -9, 0) * still[0], alpha=10.0 ** rng.uniform(-6, -3, n),
        precession_rate=spread(rng, n, -3, 1) * still[1], roll_rate=spread(rng, n, -3, 1) * still[2],
        radius=1.0, gravity=1.0,
    ))  # fmt: skip


PERIOD_KINDS: dict[str, Callable[[int, np.random.Generator], Array]] = {
    **{kind: partial(random_starts, kind) for kind in KINDS},
    "small alpha": nearly_massless,
    "beside separatrices": lambda n, rng: separatrices(1 + n // 160, rng),
    "nearly steady": nearly_steady,
    "far outside": far_outside,
}


def true_swings(given: Array, digits_only: bool) -> Array:
    """Return periods, their doubts and extreme tilts as `quadruple.swings` does; from 50 digits, only the periods."""
    if not digits_only:
        return quadruple.swings(given, FALL)
    digits.mp.dps = 50
    found = np.full((4, given.shape[1]), np.nan)
    for cell, start in enumerate(given.T):
        found[:2, cell] = digits.period([float(x) for x in start], FALL)
    return found


def audit_periods(count: int, rng: np.random.Generator) -> bool:
    """Check that periods of the reduction are correct or missing, and that its stated tilt errors suffice."""
    fine, quick = True, quadruple.available()
    print(
        "kind                  bounded  without period    held  worst relative error  true/stated tilt error"
    )
    for kind, made in PERIOD_KINDS.items():
        given = made(max(4_000, 3 * count), rng)
        found = exact(given, with_period=True)
        bounded, periods = found["ending"] == BOUNDED, found["nutation_period"]
        without = np.isnan(periods[bounded]).mean()
        known = rng.permutation(np.flatnonzero(np.isfinite(periods)))[:count]
        # narrower swings are below the first step of the search for turning points with 50 digits
        few = known[found["tilt_max"][known] - found["tilt_min"][known] > 1e-8][: 1 + count // 1000]
        worst, caution, held = 0.0, 0.0, 0
        for cells in (few, known) if quick else (few,):
            truth, doubt, least, greatest = true_swings(given[:, cells], cells is few)
            sure = doubt < 0.1 * PERIOD_ERROR
            apart = np.maximum(
                np.abs(found["tilt_min"][cells] - least), np.abs(found["tilt_max"][cells] - greatest)
            )
            worst = max(worst, np.max(np.abs(periods[cells] / truth - 1.0), initial=0.0, where=sure))
            held += int(np.count_nonzero(sure))
            caution = np.max(apart / found["tilt_error"][cells], initial=caution, where=np.isfinite(apart))
        fine &= worst <= PERIOD_ERROR and caution <= 1.0 and without <= MOST_WITHOUT.get(kind, 1e-3)
        share = f"{caution:.2f}" if quick else "not known"
        print(f"{kind:20s} {bounded.sum():8d} {without:15.4%} {held:7d} {worst:21.1e} {share:>23s}")
    return bool(fine)


PARTS: dict[str, tuple[Callable[[int, np.random.Generator], bool], int]] = {
    "errors": (audit_errors, 1_000_000),
    "separatrices": (audit_separatrices, 400),
    "tiny": (audit_tiny, 20_000),
    "brackets": (audit_brackets, 500),
    "periods": (audit_periods, 400),
}


def main() -> None:
    """Run the requested part."""
    if len(sys.argv) < 2 or sys.argv[1] not in PARTS:
        sys.exit(__doc__)
    audit, count = PARTS[sys.argv[1]]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else count
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else time.time_ns() % 2**32
    print(f"seed {seed}")
    sys.exit(0 if audit(count, np.random.default_rng(seed)) else 1)


if __name__ == "__main__":
    main()
