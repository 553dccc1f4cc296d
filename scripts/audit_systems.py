"""Compare motions of systems with heyoka's Taylor series, which shares no code with the project (extra `bench`).

    python scripts/audit_systems.py errors [COUNT] [SEED]   stated errors of ten systems: tolerances 1e-8 to 1e-13
    python scripts/audit_systems.py labels [COUNT] [SEED]   endings and labels of chaotic systems
    python scripts/audit_systems.py events [COUNT] [SEED]   excursions that barely pass a level

`errors`: COUNT random cells of each system; an event ends the motion of about one in four; one in four has parameters
up to three times as large or small. The truth is an integration in long double to 1e-20. Undecided cells are omitted,
and so are chaotic ones, for which a start 1e-8 away ends more than 1e-5 apart. `labels`: three magnets with damping
0.04 and 0.02, and the gaps of Hénon and Heiles. A decided cell is judged where heyoka agrees with itself at 1e-16 and
1e-18. `events`: the level lies 1e-2 to 1e-8 of the way below the greatest value of an orbit, or above it. Exit status 1
if a promise does not hold: stated errors below the true ones in at most 0.1 % of the values, and at most 25 times as
large in the median; at most 4 wrong labels of 100,000; no event missed or invented.
"""

import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from bench.ten_systems import RANGES, Heyoka, gaps, random_starts, slow_magnets

import sweep
from kernels.system.endings import DIFFERENT, FAILURES, FIRST_EVENT, RUNS_ON
from sweep.engine.compute import compute
from sweep.model.system.definition import Definition, Event, Operation, Symbol
from sweep.model.system.model import model_of
from sweep.systems import System

#: Promised: share of values whose true error exceeds the stated one, median of stated / true error, share of wrong
#: labels.
_MOST_EXCEEDED, _MOST_LARGE, _MOST_WRONG = 1e-3, 25.0, 4e-5

_TOLERANCES = tuple(10.0**-k for k in range(8, 14))

#: Distance by which a start is moved, and the factor by which motions that are not chaotic may separate at most.
_MOVED, _PARTED = 1e-8, 1e3

#: Distance of a level below an orbit's greatest value, relative to the rise from its start; negative for one above.
_SHORT = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8, -1e-4, -1e-8)

_PARTS = ("errors", "labels", "events")

Array = npt.NDArray[np.float64]
Columns = Mapping[str, Any]


def columns(definition: Definition, starts: Array, tolerance: float) -> Columns:
    """Return the columns that an atlas stores of cells."""
    model = model_of(definition)
    spec = sweep.SweepSpec(model=model).replace(tolerance=tolerance)
    return compute(spec, dict(zip(model.parameters, np.ascontiguousarray(starts), strict=True)))


def _ends(definition: Definition, found: Columns) -> Array:
    return np.array([found[f"{each.name}_end"] for each in definition.states])


def _level(definition: Definition) -> int:
    """Return the row of the starts that contains the level of the event."""
    names = [each.name for each in (*definition.states, *definition.parameters)]
    return names.index("level")


def cells_for_errors(chosen: System, count: int, rng: np.random.Generator) -> Array:
    """Return random starts, some of them with levels that are passed, and with unusual parameters."""
    definition = chosen.definition
    starts, states = random_starts(chosen, count, rng), len(definition.states)
    odd = rng.random(count) < 0.25
    level = _level(definition)
    for row, each in enumerate(definition.parameters, states):
        if row != level and each.name in RANGES[chosen]:
            starts[row] *= np.where(odd, 3.0 ** rng.uniform(-1.0, 1.0, count), 1.0)
    away = columns(definition, starts, 1e-8)["x_end"] - starts[0]
    passed = (rng.random(count) < 0.8) & (away > 0.1)
    starts[level] = np.where(passed, starts[0] + rng.random(count) * away, starts[level])
    return starts


def chaotic(definition: Definition, starts: Array) -> npt.NDArray[np.bool_]:
    """Return which cells separate from their neighbours."""
    moved = starts.copy()
    moved[1] += _MOVED
    one, other = (_ends(definition, columns(definition, each, 1e-12)) for each in (starts, moved))
    return np.asarray(~(np.abs(one - other).max(axis=0) <= _PARTED * _MOVED))


def audit_errors(count: int = 2000, seed: int = 1) -> int:
    """Audit the stated errors; return the exit status."""
    tally: dict[str, list[Array]] = {}
    left_out = 0
    for number, chosen in enumerate(RANGES):
        definition = chosen.definition
        starts = cells_for_errors(chosen, count, np.random.default_rng([seed, number]))
        ends, times, endings, tops = Heyoka(definition, 1e-20, np.longdouble).motions(starts)
        truth = {f"{each.name}_end": ends[:, row] for row, each in enumerate(definition.states)}
        truth |= {"end_time": times, "top": tops, "product": ends[:, 0] * ends[:, 1]}
        wild = chaotic(definition, starts)
        for tolerance in _TOLERANCES:
            found = columns(definition, starts, tolerance)
            decided = ~np.isin(found["ending"], (DIFFERENT, *FAILURES))
            same = np.where(endings >= 0, FIRST_EVENT, RUNS_ON) == found["ending"]
            left_out += int((decided & ~same).sum())
            judged = decided & same & ~wild
            for name, true in truth.items():
                kind = "states" if name.endswith("_end") else "times" if name == "end_time" else "measures"
                chosen_cells = judged & (endings >= 0) if kind == "times" else judged
                ratios = _ratios(found, name, true, chosen_cells)
                for key in (f"of {kind}", f"tolerance {tolerance:g}", definition.name, "all"):
                    tally.setdefault(key, []).append(ratios)
        print(f"audit: {definition.name}: chaotic {wild.mean():.2%}", file=sys.stderr)
    print(f"decided, but with another ending than the truth: {left_out}")
    # `all` is printed last
    every = tally.pop("all")
    for name, found_ratios in tally.items():
        _print_errors(name, np.concatenate(found_ratios))
    return _print_errors("all", np.concatenate(every))


def _ratios(found: Columns, name: str, true: Any, judged: npt.NDArray[np.bool_]) -> Array:
    """Return stated / true errors of a value; infinity where the true error is below the rounding of the value."""
    off = np.abs(found[name].astype(np.longdouble) - true)[judged].astype(np.float64)
    tiny = off <= np.finfo(np.float64).eps * np.abs(found[name][judged])
    with np.errstate(divide="ignore"):
        return np.asarray(np.where(tiny, np.inf, found[f"{name}_error"][judged] / off))


def _print_errors(name: str, ratios: Array) -> int:
    """Print a line; return 1 if a promise is broken."""
    exceeded, large = float((ratios < 1.0).mean()), float(np.median(ratios[np.isfinite(ratios)]))
    print(
        f"{name:18} {ratios.size:8d} values: true above stated {exceeded:.3%}, stated / true {large:.1f} in the median"
    )
    return int(exceeded > _MOST_EXCEEDED or large > _MOST_LARGE)


def audit_labels(count: int = 20_000, seed: int = 1) -> int:
    """Audit endings and labels; return the exit status."""
    status = 0
    for name, definition, starts in _sensitive(count, np.random.default_rng(seed)):
        found = columns(definition, starts, 1e-11)
        decided = (found["label"] > 0) if definition.labels else found["ending"] != DIFFERENT
        decided &= ~np.isin(found["ending"], FAILURES)
        one, other = (_outcome(definition, starts, tolerance) for tolerance in (1e-16, 1e-18))
        agreed = (one[0] == other[0]) & (np.abs(one[1:] - other[1:]).max(axis=0) < 0.01)
        said = found["label"] if definition.labels else found["ending"]
        wrong = int((decided & agreed & (said != other[0])).sum())
        print(
            f"{name}: {count} cells, undecided {1.0 - decided.mean():.1%}; heyoka agrees with itself in "
            f"{agreed.mean():.1%}; wrong {wrong}; decided where heyoka does not agree {int((decided & ~agreed).sum())}"
        )
        status = max(status, int(wrong > _MOST_WRONG * count))
    return status


def _sensitive(count: int, rng: np.random.Generator) -> Iterator[tuple[str, Definition, Array]]:
    definition = slow_magnets.definition
    for damping, duration in ((0.04, 150.0), (0.02, 300.0)):
        starts = np.zeros((7, count))
        starts[:2] = rng.uniform(-1.5, 1.5, (2, count))
        starts[4:] = np.array([[0.5], [damping], [0.25]])
        yield f"magnets, damping {damping:g}", replace(definition, duration=duration), starts
    # energies of 1/6 and more leave through the gaps
    yield "Hénon and Heiles", gaps.definition, rng.uniform(-0.45, 0.45, (4, count))


def _outcome(definition: Definition, starts: Array, tolerance: float) -> Array:
    """Return code, end time and states of cells from heyoka."""
    if definition.labels:
        ends = Heyoka(definition, tolerance, float, 8).ends(starts)
        code = np.select([ends[0] > 0.5, ends[1] > 0.4, ends[1] < -0.4], [1, 2, 3], 0)
        return np.vstack([code, np.zeros(code.size), ends])
    ends, times, endings, _ = Heyoka(definition, tolerance).motions(starts)
    return np.vstack([np.where(endings >= 0, FIRST_EVENT + endings, RUNS_ON), times, ends.T])


def audit_events(count: int = 1000, seed: int = 1) -> int:
    """Audit excursions past levels; return the exit status."""
    missed = invented = counted = undecided = cells = 0
    for number, chosen in enumerate(RANGES):
        passed = Event("above", (Operation("-", (Symbol("y"), Symbol("level"))),))
        definition = replace(chosen.definition, ends=(passed,))
        starts = random_starts(chosen, count, np.random.default_rng([seed, number]))
        tops = Heyoka(definition, 1e-20, np.longdouble).motions(starts)[3].astype(np.float64)
        rising = tops > starts[1]
        for short in _SHORT:
            given = starts[:, rising].copy()
            given[_level(definition)] = tops[rising] - short * (tops[rising] - given[1])
            found = columns(definition, given, 1e-11)
            over, quiet = found["ending"] == RUNS_ON, found["unproved"] == 0
            cells += over.size
            undecided += int((found["ending"] == DIFFERENT).sum())
            missed += int((over & quiet).sum()) if short > 0.0 else 0
            counted += int((over & ~quiet).sum()) if short > 0.0 else 0
            invented += int((found["ending"] == FIRST_EVENT).sum()) if short < 0.0 else 0
        print(f"audit: {definition.name}: missed {missed}, invented {invented} so far", file=sys.stderr)
    print(
        f"{cells} cells: missed {missed}, missed but counted {counted}, invented {invented}, undecided {undecided}"
    )
    return int(missed > 0 or invented > 0)


def main(words: list[str]) -> int:
    """Run the requested part, or print which parts there are; return the exit status."""
    if words and words[0] in ("-h", "--help"):
        print(__doc__)
        return 0
    part, *rest = words or [""]
    numbers = [int(word) for word in rest if re.fullmatch("[0-9]{1,18}", word)]
    if part not in _PARTS or len(numbers) < len(rest) or len(rest) > 2 or 0 in numbers[:1]:
        print(__doc__, file=sys.stderr)
        return 2
    return {"errors": audit_errors, "labels": audit_labels, "events": audit_events}[part](*numbers)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
