"""The second method: steps of DOP853 on lanes, which share with the series only how a right-hand side is evaluated.

Its entry point takes `(starts, settings, measures, counts)`:

Parameters
----------
starts : float64[states + parameters + 1, n]
    States, parameters, and the time to which each cell is followed.
settings : float64[1]
    Tolerance: the error of a step over the size of the states.
measures : float64[states + extremes + 1, n], written
    The states at that time, the greatest values until then, NaN where it is not reached; the shortest step, infinite
    where nothing is watched.
counts : int32[1, n], written
    Steps tried.

Notes
-----
The method and its step control: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I (1993), II.5 and
II.10. A step that passes a summit of an expression is tried again with the length at which the rate of the expression
would vanish if it were linear. A step is bounded where a function may hide what it does later, as those of series are
(`kernels.system.hidden`): a method that judges by the rates that it has seen passes over a short push.
Never raises.
"""

import hashlib
import math

from kernels.jit import kernel
from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel
from kernels.lanes.layout import LANES
from kernels.system import lanes as system_lanes
from kernels.system.hidden import step_lines
from kernels.system.integrate import program_of
from kernels.system.series import SeriesSource
from kernels.system.source import Layout, call, compiled, constants_text, function, names_of, series_text

#: Steps that are tried at most.
MOST_STEPS = 50_000.0

#: Last order of the series: of the arguments that are watched. The compiler leaves out what a stage does not need.
_ORDER = 3

#: The first step, over the duration; how much longer and shorter than the last one a step may be.
FIRST, _LONGER, _SHORTER = 1e-4, 4.0, 0.2

#: A summit is reached where the rate is this share of the one before, or the step this share of what accuracy allows.
_FLAT, _SHORT = 1e-9, 1e-6

STATES: int = 0
EXTREMES: int = 0
Y: int = 0
TIME: int = 0
TOP: int = 0
SIZES: int = 0
COUNT: int = 0
STEP: int = 0
LONGEST: int = 0
SHORTEST: int = 0
END: int = 0
SCRATCH: int = 0


@kernel
def prepared_settings(settings):
    """The tolerance."""
    return (settings[0],)


@kernel
def constants(cell, lane, starts, lanes):
    """Write the constants of a cell into its lane; made from the right-hand side."""


@kernel
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Read states, constants and the time at the end."""
    for i in range(STATES):
        lanes[Y + i * LANES + lane] = starts[i, cell]
        lanes[SIZES + i * LANES + lane] = abs(starts[i, cell])
    constants(cell, lane, starts, lanes)
    for i in range(EXTREMES):
        lanes[TOP + i * LANES + lane] = -math.inf
    lanes[END + lane] = end = starts[starts.shape[0] - 1, cell]
    lanes[TIME + lane], lanes[COUNT + lane] = 0.0, 0.0
    lanes[STEP + lane], lanes[LONGEST + lane], lanes[SHORTEST + lane] = FIRST * end, FIRST * end, math.inf
    return True


@kernel
def fill_idle(lane, lanes):
    """Fill an idle lane with ones."""
    for row in range(0, SCRATCH, LANES):
        lanes[row + lane] = 1.0


@kernel
def finish_leg(cell, lane, run, lanes, measures, counts):
    """Write the results of a cell."""
    known = lanes[TIME + lane] >= lanes[END + lane]
    for i in range(STATES):
        measures[i, cell] = lanes[Y + i * LANES + lane] if known else math.nan
    for i in range(EXTREMES):
        measures[STATES + i, cell] = lanes[TOP + i * LANES + lane] if known else math.nan
    measures[STATES + EXTREMES, cell] = lanes[SHORTEST + lane]
    counts[0, cell] = int(lanes[COUNT + lane])
    return False


def entry_point(program, rates, wanted):
    """Return the entry point of the second method of a system (`kernels.native.entry.ParallelEntry`).

    Parameters
    ----------
    program : tuple
        See `kernels.system.series`.
    rates, wanted : tuple of int
        The instructions with the rates of the states, and with what the greatest value is sought of.
    """
    source = SeriesSource(program, rates, wanted, _ORDER)
    names = names_of(source)
    layout = Layout(len(rates), len(wanted), len(names), 0)
    # no step is held against the one before, so its row is free
    layout.SHORTEST = layout.BEFORE
    text = "\n\n\n".join([
        constants_text(source, layout, len(rates)), series_text(source, len(rates), names),
        _advance(source, layout, len(rates), names),
    ])  # fmt: skip
    made = compiled(text, ("advance", "constants"), {"MOST_STEPS": MOST_STEPS})
    numbers = {"STATES": len(rates), "EXTREMES": len(wanted), "constants": made["constants"]}
    numbers |= {name: at for name, at in vars(layout).items() if name in globals()}
    nothing = system_lanes.prepare
    return bind(
        LaneModel(
            name=f"second_{hashlib.sha256(text.encode()).hexdigest()[:24]}", layout=layout,
            prepared_settings=prepared_settings, read_start=read_start, fill_idle=fill_idle, prepare=nothing,
            needs_integration=system_lanes.needs_integration, set_off=nothing, advance=made["advance"], land=nothing,
            finish_leg=finish_leg, flags=numbers,
        )
    )  # fmt: skip


def __getattr__(name):
    """Make the entry point whose name is a program in JSON, as `kernels.system.integrate` does."""
    if not name.startswith("["):
        return getattr(None, name)
    program, rates, extremes, events, _ = program_of(name)
    made = globals()[name] = entry_point(program, rates, (*extremes, *events))
    return made


def _step(source, layout, states, names):
    """Return the lines of one step of length h, the expressions and rates at its start, and the errors of each state.

    The states at its end are n0, n1 ..., the expressions and their rates there g0, ... and d0, ...
    """
    # its tables are SciPy's: the kernels of a run need neither
    from scipy.integrate import DOP853

    load, found, _, watched = call(source, layout, states, names)
    unused = "_" * (_ORDER - 1), "_" * (states + sum(map(len, watched)))

    def slopes(stage, at, time):
        """Return the line that calls the series: each stage keeps its rates, the last one its expressions too."""
        kept = [name for i in range(states) for name in ("_", f"k{stage}_{i}", *unused[0])]
        last = stage == DOP853.n_stages
        for j in range(len(source.wanted)):
            kept += [*((f"g{j}", f"d{j}") if last else "__"), *unused[0]]
        return f"({', '.join([*kept, *unused[1]])},) = series({', '.join([*at, time, *names])})"

    def terms(row, i):
        return " + ".join(f"{float(c)!r} * k{j}_{i}" for j, c in enumerate(row) if c)

    lines = [*load, *(f"k0_{i} = {found[i][1]}" for i in range(states))]
    for (way, exponent, _), texts in zip(source.watched, watched, strict=True):
        lines += step_lines(way, exponent, texts)
    for stage in range(1, DOP853.n_stages):
        at = [f"y{i} + h * ({terms(DOP853.A[stage, :stage], i)})" for i in range(states)]
        lines.append(slopes(stage, at, f"t + {float(DOP853.C[stage])!r} * h"))
    lines += [f"n{i} = y{i} + h * ({terms(DOP853.B, i)})" for i in range(states)]
    lines.append(slopes(DOP853.n_stages, [f"n{i}" for i in range(states)], "t + h"))
    return lines, found[states:], [(terms(DOP853.E5, i), terms(DOP853.E3, i)) for i in range(states)]


def _advance(source, layout, states, names):
    """Source of one step of one lane, which rests where it has reached its end."""

    def row(name, i=0):
        return f"lanes[{getattr(layout, name) + i * LANES} + lane]"

    step, expressions, errors = _step(source, layout, states, names)
    lines = [
        f"end, h, longest = {row('END')}, {row('STEP')}, {row('LONGEST')}",
        f"left = end - {row('TIME')}",
    ]
    lines += ["h = left if h > left else h", *step, f"count = {row('COUNT')} + 1.0"]
    for i in range(states):
        lines += [f"b{i} = {row('SIZES', i)}", f"s{i} = abs(n{i}) if abs(n{i}) > b{i} else b{i}"]
    lines.append(f"floor = 1e-4 * ({' + '.join(f's{i}' for i in range(states))}) + 1e-300")
    for i, (five, three) in enumerate(errors):
        lines += [f"w = 1.0 / (run[0] * (s{i} + floor))", f"f{i} = ({five}) * w", f"e{i} = ({three}) * w"]
    lines += [f"{name} = {' + '.join(f'{name}{i} * {name}{i}' for i in range(states))}" for name in "fe"]
    lines += [
        f"below = (f + 0.01 * e) * {float(states)!r}",
        "error = h * f / math.sqrt(below) if below > 0.0 else 0.0",
        "right = error <= 1.0",
        # error^(-1/8)
        "factor = 0.9 / math.sqrt(math.sqrt(math.sqrt(error + 1e-20)))",
        f"factor = {_LONGER} if factor > {_LONGER} else (factor if factor > {_SHORTER} else {_SHORTER})",
        "there = left <= 0.0",
        "lost = (not there) & ((not (t + h > t)) | (count > MOST_STEPS) | (not (error < 1e300)))",
        "part = 1.0",
    ]
    for j, (_, rate, *_) in enumerate(expressions):
        lines += [
            f"passed = ({rate} > 0.0) & (-d{j} > {_FLAT} * {rate}) & (h > {_SHORT} * longest)",
            f"z = {rate} / ({rate} - d{j})",
            "part = z if passed & (z < part) else part",
        ]
    lines += ["taken = right & (part == 1.0) & (not (there | lost))"]
    tops = [f"o{j}" for j in range(len(expressions))]
    for j, (value, *_) in enumerate(expressions):
        lines += [
            f"o{j} = {row('TOP', j)}",
            f"o{j} = {value} if {value} > o{j} else o{j}",
            f"o{j} = g{j} if taken & (g{j} > o{j}) else o{j}",
        ]
    lines += [f"{row('TOP', j)} = {name}" for j, name in enumerate(tops)]
    for i in range(states):
        lines += [f"{row('SIZES', i)} = s{i} if taken else b{i}", f"{row('Y', i)} = n{i} if taken else y{i}"]
    lines += [
        "grown = h * factor if (not right) | (h >= longest) else longest",
        f"short = {_SHORT} * longest",
        "nearer = 0.999 * part * h",
        "nearer = nearer if nearer > short else short",
        f"{row('LONGEST')} = grown if taken | (not right) else longest",
        f"{row('STEP')} = nearer if right & (part < 1.0) else grown",
        f"{row('TIME')} = (end if h >= left else t + h) if taken else t",
        f"{row('COUNT')} = count",
    ]
    if source.watched:
        shortest = row("SHORTEST")
        lines.append(f"{shortest} = h if taken & (h < left) & (h < {shortest}) else {shortest}")
    return function("simd", "advance(lane, run, lanes)", [*lines, "return there | lost"])
