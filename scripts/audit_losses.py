"""Compare motions of disks with losses with independent integrations, closed forms and limits.

    python scripts/audit_losses.py mixtures [CELLS] [SEED]   random mixtures of laws against DOP853 with events
    python scripts/audit_losses.py tight [CELLS] [SEED]      the same with a tolerance of 1e-10
    python scripts/audit_losses.py single [CELLS] [SEED]     the same as single motions, in small steps
    python scripts/audit_losses.py breaches [CELLS] [SEED]   the same, with when a tilt was first exceeded
    python scripts/audit_losses.py variants [COUNT] [SEED]   the same, in kernels that have no more laws than the cells
    python scripts/audit_losses.py grazes [CELLS] [SEED]     slipping that only just begins, of the same cells
    python scripts/audit_losses.py passes [CELLS] [SEED]     few losses or none: maxima of the potential, passed slowly
    python scripts/audit_losses.py wobbles [TURNS]           times and exponents of steady wobbles: closed forms
    python scripts/audit_losses.py limits [CELLS] [SEED]     vanishing losses: extremes and verdicts of the disk without
    python scripts/audit_losses.py holding [CELLS] [SEED]    the tilt up to which rolling friction holds, both sides

The references (tests/lossy_referee.py) use other coordinates, another method and another treatment of events. Cells in
which they disagree with themselves are omitted and counted. Exit status 1 if a promise is broken.
"""

import itertools
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import lossy_cells
import lossy_referee
import lossy_runner
import lossy_wobble
import referee

from kernels.disk.arrays import PARAMETERS as DISK_PARAMETERS
from kernels.lossy_disk import arrays, endings, integrate
from sweep.model.quantity import PROMISED, Array

Run = Callable[..., Any]

#: Difference between references with 1e-12 and 1e-13 above which a cell is omitted; promised share of such cells.
DOUBT, MOST_LEFT_OUT = 1e-7, 0.05

#: Promised: relative error of final times; difference of tilts [rad] and losses [m g R], and relative difference of
#: heading and path, which accumulate the errors of the whole motion; imbalance of the energy; share of unresolved
#: cells.
TIME_ERROR, ERROR, IMBALANCE, MOST_UNRESOLVED = 1e-6, 1e-5, 1e-8, 0.01

#: Promised: relative error of the time at which a tilt is first exceeded.
BREACH_ERROR = 1e-5

#: Initial and final inclination, and promised relative error of the time between them.
WOBBLES = ((0.09, math.radians(0.1), 0.01), (0.03, math.radians(0.02), 0.001))

#: Promised error of the exponents; mass distributions.
EXPONENT_ERROR, ALPHAS = 0.01, (0.5, 0.62, 1.0)

COMPARED = (
    "tilt_min", "tilt_max", "end_tilt", "heading_turned", "path_length", "contact_x", "contact_y", *arrays.LOSSES,
)  # fmt: skip
#: Measures that are inaccurate for a motion that almost stops on its way and is late afterwards -> the measure that
#: states their error.
STATED = {"end_tilt": "tilt_error", "heading_turned": "heading_error", "path_length": "path_error"}
NAMES = {code: name for name, code in vars(endings).items() if isinstance(code, int)}


def apart(found: Any, other: Any, name: str) -> Array:
    """Return the difference of a measure, relative where it is larger than 1."""
    first, second = getattr(found, name), getattr(other, name)
    return np.asarray(np.abs(first - second) / np.maximum(1.0, np.abs(second)))


def relative(found: Array, true: Array) -> Array:
    """Return the relative difference of times: zero if both are missing, infinite if only one is."""
    apart = np.abs(found - true) / np.where(true > 0.0, true, 1.0)
    return np.where(np.isnan(apart), np.where(np.isnan(found) & np.isnan(true), 0.0, np.inf), apart)


@dataclass
class Audit:
    """The result of a comparison of cells: sentences about cells that break a promise, and counts."""

    broken: list[str] = field(default_factory=list)
    cells: int = 0
    left_out: int = 0
    unresolved: int = 0
    worst: dict[str, float] = field(default_factory=dict)
    endings: dict[str, int] = field(default_factory=dict)

    def note(self, name: str, values: Array) -> None:
        """Keep the worst of some values."""
        if values.size:
            self.worst[name] = max(self.worst.get(name, 0.0), float(values.max()))

    @property
    def fine(self) -> bool:
        """Whether every promise is kept."""
        few = self.left_out <= MOST_LEFT_OUT * self.cells
        return not self.broken and few and self.unresolved <= MOST_UNRESOLVED * self.cells


def describe_start(given: Array, air: str) -> str:
    """Return the parameters of one start that are not the defaults, as Python code."""
    defaults = lossy_referee.DEFAULTS
    words = (
        f"{name}={value!r}"
        for name, value in zip(arrays.PARAMETERS, map(float, given), strict=True)
        if value != defaults[name]
    )
    return f"air={air} " + ", ".join(words)


def compare(audit: Audit, run: Run, given: Array, air: str, *, slack: float = 1.0, **settings: Any) -> None:
    """Compare `run` with the reference in every cell; both get `settings`, except for the kernel's `tolerance`."""
    own = {key: value for key, value in settings.items() if key != "tolerance"}
    true = lossy_referee.run(given, air=air, rtol=1e-13, **own)
    coarse = lossy_referee.run(given, air=air, rtol=1e-12, **own)
    found = run(given, air=air, **settings)
    doubts = [apart(coarse, true, name) for name in COMPARED]
    doubts += [relative(getattr(coarse, name), getattr(true, name)) for name in ("end_time", "breach_time")]
    sure = (coarse.ending == true.ending) & (np.maximum.reduce(doubts) <= DOUBT)
    sure &= true.ending != endings.UNRESOLVED
    resolved = found.ending != endings.UNRESOLVED
    audit.cells += given.shape[1]
    audit.left_out += int((~sure).sum())
    audit.unresolved += int((~resolved & sure).sum())
    for code in np.unique(true.ending):
        name = NAMES[int(code)]
        audit.endings[name] = audit.endings.get(name, 0) + int((true.ending == code).sum())
    both = sure & resolved
    same = both & (found.ending == true.ending)
    measured = {"end_time": (relative(found.end_time, true.end_time), slack * TIME_ERROR)}
    measured |= {name: (apart(found, true, name), slack * ERROR) for name in COMPARED if hasattr(found, name)}
    if hasattr(found, "tilt_error"):
        # add the errors that a cell states itself to the promised ones
        for name, error in STATED.items():
            values, limit = measured[name]
            size = np.maximum(1.0, np.abs(getattr(true, name)))
            measured[name] = values, limit + PROMISED * np.nan_to_num(getattr(found, error) / size)
    if "limit" in settings:
        # a start at the limit exceeds it within rounding of time 0
        measured["breach_time"] = relative(found.breach_time, true.breach_time), slack * BREACH_ERROR
    if hasattr(found, "energy_imbalance"):
        measured["energy_imbalance"] = found.energy_imbalance, IMBALANCE
    wrong: dict[int, list[str]] = {int(cell): ["ending"] for cell in np.flatnonzero(both & ~same)}
    for name, (values, limit) in measured.items():
        audit.note(name, values[same])
        for cell in np.flatnonzero(same & ~(values <= limit)):
            wrong.setdefault(int(cell), []).append(f"{name} {values[cell]:.1e}")
    for place, words in wrong.items():
        ends = f"{NAMES[int(found.ending[place])]} {found.end_time[place]:.9g} s, referee "
        ends += f"{NAMES[int(true.ending[place])]} {true.end_time[place]:.9g} s after {true.switches[place]} switches"
        audit.broken.append(f"{'; '.join(words)}: {ends}: {describe_start(given[:, place], air)}")


def audit_mixtures(
    cells: int, rng: np.random.Generator, tolerance: float = 1e-8, slack: float = 1.0
) -> Audit:
    """Audit random mixtures of laws in every kind of motion, 30 s long."""
    audit = Audit()
    for air, given in lossy_cells.random_cells(cells, rng).items():
        compare(audit, lossy_runner.run, given, air, duration=30.0, tolerance=tolerance, slack=slack)
    return audit


def audit_breaches(cells: int, rng: np.random.Generator, slack: float = 1.0) -> Audit:
    """Audit when the tilt of the same cells first exceeds a limit, from upright or from the start."""
    audit = Audit()
    for air, given in lossy_cells.random_cells(cells, rng).items():
        for from_start in (False, True):
            half, limit = np.ascontiguousarray(given[:, from_start::2]), rng.uniform(0.05, 1.2)
            compare(
                audit,
                lossy_runner.run,
                half,
                air,
                duration=30.0,
                slack=slack,
                limit=limit,
                from_start=from_start,
            )
    return audit


#: Meaning of the arguments of `kernels.lossy_disk.integrate.variant`, except the law of the air.
_ROWS = ("contour_friction", "contour_damping", "rolling_friction", "pivoting_friction", "friction")


def laws_of_variants() -> dict[str, tuple[str, tuple[str, ...]]]:
    """Return the law of the air, and the parameters without effect, of every variant of the integration."""
    found: dict[str, tuple[str, tuple[str, ...]]] = {}
    for there in itertools.product((True, False), repeat=len(_ROWS)):
        contour, damping, rolling, pivoting, slips = there
        missing = tuple(row for row, has in zip(_ROWS, there, strict=True) if not has)
        for code, air in enumerate(lossy_cells.AIR_LAWS):
            name = integrate.variant(contour, damping, rolling, pivoting, code, slips)
            # where two sets share a variant, the first of them has more laws
            found.setdefault(name, (air, missing))
    return found


def audit_variants(
    count: int,
    rng: np.random.Generator,
    cells: int = 60,
    slack: float = 1.0,
    names: Sequence[str] | None = None,
) -> Audit:
    """Audit some variants, random ones unless named, each with random mixtures of its own laws.

    Many of these cells lose nothing, so that after hundreds of nutations their final state is less accurate.
    """
    audit, laws = Audit(), laws_of_variants()
    for name in names or map(str, rng.choice(sorted(laws), min(count, len(laws)), replace=False)):
        air, missing = laws[name]
        given = lossy_cells.without(lossy_cells.random_cells(3 * cells, rng)[air], missing)
        broken = len(audit.broken)
        compare(audit, partial(lossy_runner.run, variant=name), given, air, duration=30.0, slack=slack)
        audit.broken[broken:] = [f"{name}: {sentence}" for sentence in audit.broken[broken:]]
    return audit


def audit_single(cells: int, rng: np.random.Generator, slack: float = 1.0) -> Audit:
    """Audit the same cells as single motions, with a quarter of the usual step."""
    audit = Audit()
    for air, given in lossy_cells.random_cells(cells, rng).items():
        compare(audit, run_finely, given, air, duration=30.0, slack=slack)
    return audit


def run_finely(given: Array, **settings: Any) -> Any:
    """Run single motions with small steps; the default steps are made for films."""
    return lossy_runner.run_single(given, relative_step=0.0125, **settings)


def audit_grazes(cells: int, rng: np.random.Generator, slack: float = 100.0) -> Audit:
    """Audit disks that slip where they need most friction, by so little that slipping may be missed.

    The moment of slipping is the root of a parabola near its top, and thus less accurate than others.
    """
    audit = Audit()
    for air, given in lossy_cells.random_cells(cells, rng).items():
        needed = partial(lossy_runner.needed_friction, air=air)
        grazing = lossy_cells.barely_slipping(given, needed, rng)
        compare(audit, lossy_runner.run, grazing, air, duration=20.0, slack=slack)
        compare(audit, run_finely, grazing, air, duration=20.0, slack=slack)
    return audit


#: The parameters that determine how much a motion loses.
STRENGTHS = (*_ROWS[:4], "air_viscosity")


def audit_passes(cells: int, rng: np.random.Generator, slack: float = 10.0) -> Audit:
    """Audit motions that often pass the maximum of their potential.

    Their losses are reduced up to ten-thousandfold, or to none.
    """
    audit, kinds = Audit(), ("nearly upright", "tumbling", "slow", "nutating")
    for air, given in lossy_cells.random_cells(cells, rng, kinds).items():
        less = 10.0 ** rng.uniform(-4, 0, given.shape[1]) * (rng.random(given.shape[1]) < 0.7)
        for name in STRENGTHS:
            given[arrays.PARAMETERS.index(name)] *= less
        given = lossy_cells.without(given, ("friction",))
        compare(audit, lossy_runner.run, given, air, duration=30.0, slack=slack)
    return audit


def audit_wobbles(turns: int, laws: tuple[str, ...] = lossy_wobble.LAWS) -> Audit:
    """Compare times between inclinations, and exponents, with closed forms."""
    audit, run = Audit(), lossy_runner.run
    for law in laws:
        for alpha in ALPHAS:
            for first, last, limit in WOBBLES:
                off = abs(lossy_wobble.time_between(run, law, turns, alpha, first, last) - 1.0)
                audit.note(f"{law} from {first}", np.array(off))
                if not off <= limit:
                    audit.broken.append(
                        f"{law}, alpha {alpha}: time from {first} to {last:.2g} differs by {off:.2%}"
                    )
            off = abs(
                lossy_wobble.exponent(run, law, turns, alpha, 0.04, 0.008) - lossy_wobble.EXPONENTS[law]
            )
            audit.note(f"{law} exponent", np.array(off))
            if not off <= EXPONENT_ERROR:
                audit.broken.append(f"{law}, alpha {alpha}: exponent differs by {off:.3f}")
            audit.cells += 1
    return audit


def vanishing(n: int, law: str, rng: np.random.Generator) -> tuple[Array, str]:
    """Return starts that do not fall without losses, with a coefficient of one law of about 1e-4."""
    alpha = rng.uniform(0.3, 1.0, n)
    tilt, *rates = lossy_cells.motions("tumbling", n, alpha, rng)
    rates[1:] = 2.0 * np.array(rates[1:])
    size = 10.0 ** rng.uniform(-4.3, -3.7, n)
    names = {"moffatt": "air_viscosity", "bildsten": "air_viscosity"}
    given = lossy_referee.starts(
        tilt=tilt, tilt_rate=rates[0], precession_rate=rates[1], roll_rate=rates[2], alpha=alpha, air_density=1.0,
        **{names.get(law, law): size**2 if law == "bildsten" else size},
    )  # fmt: skip
    return given, law if law in names else "none"


def audit_limits(cells: int, rng: np.random.Generator) -> Audit:
    """Halve the coefficients twice: the extremes must tend to those without losses, proportionally for smooth laws."""
    audit = Audit()
    smooth = {"contour_damping": 2.0, "moffatt": 2.0, "bildsten": 2.0}
    for law in (*smooth, "contour_friction", "pivoting_friction"):
        given, air = vanishing(cells, law, rng)
        free = referee.extremes(given[: len(DISK_PARAMETERS)], lossy_referee.FLAT_TILT)
        differences = []
        for factor in (1.0, 0.5, 0.25):
            less = given.copy()
            row = arrays.AIR_VISCOSITY if air != "none" else arrays.PARAMETERS.index(law)
            less[row] *= factor**2 if law == "bildsten" else factor
            found = lossy_runner.run(less, air=air, duration=60.0)
            reached = found.ending == endings.HORIZON
            differences.append(
                np.maximum(np.abs(found.tilt_min - free.least), np.abs(found.tilt_max - free.greatest))
            )
            limit = 0.6
            verdict = np.maximum(np.abs(found.tilt_min), np.abs(found.tilt_max)) > limit
            beside = np.abs(free.peak - limit) <= differences[-1]
            audit.broken += [
                f"{law}: verdict of {describe_start(less[:, cell], air)}"
                for cell in np.flatnonzero(reached & ~free.fell & ~beside & (verdict != (free.peak > limit)))
            ]
        judged = reached & ~free.fell & (differences[0] > 1e-6) & (differences[0] < 1e-2)
        ratios = differences[1][judged] / differences[2][judged]
        low, middle, high = np.quantile(ratios, (0.1, 0.5, 0.9))
        print(
            f"{law:18s} {judged.sum():5d} cells: halving divides the difference by {low:.3f} {middle:.3f} {high:.3f}"
        )
        audit.cells += int(judged.sum())
        if law in smooth and not (abs(middle - 2.0) < 0.05 and low > 1.7):
            audit.broken.append(f"{law}: not proportional")
        if not np.quantile(differences[2][judged] / differences[0][judged], 0.9) < 0.6:
            audit.broken.append(f"{law}: does not tend to the disk without losses")
    return audit


def holding_tilt(alpha: float, arm: float, precession: float) -> float:
    """Return the tilt up to which rolling friction holds a disk that turns at a scaled rate.

    It solves S [1 + (1 + alpha/2) P^2 C] = arm.
    """
    low, high = 0.0, 0.5
    for _ in range(100):
        tilt = 0.5 * (low + high)
        need = math.sin(tilt) * (1.0 + (1.0 + 0.5 * alpha) * precession**2 * math.cos(tilt))
        low, high = (tilt, high) if need <= arm else (low, tilt)
    return low


def audit_holding(cells: int, rng: np.random.Generator) -> Audit:
    """Check disks just within and just beyond the holding tilt.

    A disk a billionth within it must stay, except for rounding; one a thousandth beyond it must move.
    """
    audit = Audit()
    alpha, arm = rng.uniform(0.1, 1.0, cells), 10.0 ** rng.uniform(-5, -1, cells)
    precession = rng.normal(0, 1, cells) * (rng.random(cells) < 0.7)
    edge = np.array([holding_tilt(*each) for each in zip(alpha, arm, precession, strict=True)])
    side = rng.choice((-1.0, 1.0), cells)
    for factor, stays in ((1.0 - 1e-9, True), (1.0 + 1e-3, False)):
        given = lossy_referee.starts(
            tilt=side * edge * factor, alpha=alpha, precession_rate=precession, rolling_friction=arm
        )
        # where it moves, the driving moment grows as fast as a pendulum falls
        found = lossy_runner.run(given, duration=1e4 if stays else 60.0)
        moved = [np.abs(getattr(found, name) - given[0]) for name in ("tilt_min", "tilt_max", "end_tilt")]
        kept = np.max(moved, axis=0) <= 2.0 * np.spacing(np.abs(given[0]))
        ending = np.where(precession == 0.0, endings.REST, endings.HORIZON)
        right = kept & (found.ending == ending) if stays else ~kept
        audit.cells += cells
        audit.broken += [
            f"{NAMES[int(found.ending[cell])]}, should {'stay' if stays else 'go'}: "
            f"{describe_start(given[:, cell], 'none')}"
            for cell in np.flatnonzero(~right)
        ]
    return audit


PARTS: dict[str, tuple[Callable[..., Audit], int]] = {
    "mixtures": (audit_mixtures, 600),
    "tight": (lambda cells, rng: audit_mixtures(cells, rng, 1e-10, 0.1), 600),
    "single": (audit_single, 300),
    "breaches": (audit_breaches, 300),
    "variants": (lambda count, rng: audit_variants(count, rng, slack=10.0), 6),
    "grazes": (audit_grazes, 300),
    "passes": (audit_passes, 300),
    "wobbles": (lambda turns, rng: audit_wobbles(turns), 500),
    "limits": (audit_limits, 400),
    "holding": (audit_holding, 2000),
}


def main() -> None:
    """Run the requested part."""
    if len(sys.argv) < 2 or sys.argv[1] not in PARTS:
        sys.exit(__doc__)
    part, count = PARTS[sys.argv[1]]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else count
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else time.time_ns() % 2**32
    print(f"seed {seed}")
    audit = part(count, np.random.default_rng(seed))
    for sentence in audit.broken:
        print(sentence)
    print(
        f"{audit.cells} cells, {audit.left_out} left out, {audit.unresolved} unresolved, {len(audit.broken)} broken"
    )
    print("endings:", ", ".join(f"{name} {count}" for name, count in audit.endings.items()))
    print("worst:", ", ".join(f"{name} {value:.1e}" for name, value in audit.worst.items()))
    sys.exit(0 if audit.fine else 1)


if __name__ == "__main__":
    main()
