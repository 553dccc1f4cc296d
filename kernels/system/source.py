"""Source code of the lane functions that differ between systems: constants, series and step.

The text consists only of numbers and of names chosen here; Numba compiles it.
"""

import math

from kernels import elementary
from kernels.jit import kernel, simd
from kernels.lanes.layout import LANES
from kernels.system import lanes as system_lanes
from kernels.system import polynomials
from kernels.system.endings import FIRST, GREATEST
from kernels.system.hidden import step_lines, watch_lines
from kernels.system.lanes import JUMP, LEAST_CHANGE, LEAST_JUMP, NOISE
from kernels.system.moments import COUNTED, LEVEL, NUMBERS, WHEN
from kernels.system.polynomials import ORDER
from kernels.system.series import SeriesSource

#: A step that is not proved to be free of events is tried with these shares of its length.
_SHARES = (1.0, 1.0 / 3.0, 1.0 / 9.0, 1.0 / 27.0)


class Layout:
    """The rows of lanes of a system, under the names used in `kernels.system.lanes`.

    Parameters
    ----------
    states, extremes, constants, series, moments, watched : int
        Number of rows of each kind; `series` counts all series written into the scratch of a block, and `watched` those
        of the moments.
    """

    def __init__(self, states, extremes, constants, series, moments, watched):
        rows, at = {}, 0
        for name, count in (
            ("Y", states), ("TIME", 1), ("TOP", extremes), ("SIZES", states), ("COUNT", 1), ("UNPROVED", 1),
            ("WATCH", moments * NUMBERS), ("SIDE", watched), ("STEP", 1), ("CONSTANT", constants),
            ("SLOPE", states), ("BEFORE", 1), ("END", 1),
            ("LOG_TOLERANCE", 1), ("LONGEST", 1),
            ("START", states), ("LEG", 1), ("STEPS", 1), ("SCRATCH", 0),
        ):  # fmt: skip
            rows[name] = at * LANES
            at += count
        # after the series and the magnitudes of the rates, working memory (`kernels.system.roots`)
        rows["WORK"] = series * (ORDER + 1) + states
        scratch = -(-(rows["WORK"] + (2 if moments else 1) * (ORDER + 1)) // LANES) * LANES
        rows |= {"RETURNED": rows["CONSTANT"], "STEPPING": rows["START"], "SIZE": rows["SCRATCH"] + scratch}
        vars(self).update(rows)


def functions_of(program, rates, extremes, events, integrals, moments):
    """Return the layout and the four functions of a system given as a program (`kernels.system.series`).

    Parameters
    ----------
    program : tuple
    rates, extremes, events : tuple of int
        The instructions of the rates of the states, of the expressions whose greatest value is computed, and of the
        expressions that end a motion when they are positive.
    integrals : int
        The number of the last states that begin at 0, and have no row in `starts`.
    moments : tuple of tuple of int
        See `kernels.system.integrate.entry_point`.

    Returns
    -------
    layout : Layout
    made : dict
        ``advance``, ``coefficients``, ``constants`` and ``safe_step``.
    text : str
        Their source.
    """
    watched = tuple(number for _, _, *numbers in moments for number in numbers)
    source = SeriesSource(program, rates, (*extremes, *events, *watched), ORDER)
    names, series = names_of(source), len(rates) + len(extremes) + len(events) + len(watched)
    layout = Layout(len(rates), len(extremes), len(names), series, len(moments), len(watched))
    text = "\n\n\n".join([
        constants_text(source, layout, len(rates) - integrals), series_text(source, len(rates), names),
        _coefficients(source, layout, len(rates), names), _safe_step(source, layout, len(rates), names),
        _advance(source, layout, len(rates), len(extremes), names, len(events), moments),
    ])  # fmt: skip
    more = {name: getattr(polynomials, name) for name in ("value", "upper_bound", "greatest")}
    more["MOST_STEPS"] = system_lanes.MOST_STEPS
    return layout, compiled(text, ("advance", "coefficients", "constants", "safe_step"), more), text


def compiled(text, names, more):
    """Return the functions of a text by their names; it may call functions of `kernels.elementary`, and `more`."""
    space = {
        "math": math, "kernel": kernel, "simd": simd,
        **{name: getattr(elementary, name) for name in (
            "sine_cosine", "exponential", "logarithm", "hyperbolic_tangent", "arc_tangent", "rough_log2",
            "rough_exp2")},
        **more, "__name__": f"{__name__}.made",
    }  # fmt: skip
    exec(compile(text, "<system>", "exec"), space)
    return {name: space[name] for name in names}


def names_of(source):
    """Return the names of the constants of a cell, in the order of their rows."""
    return list(source.constants.names.values())


def function(decorator, head, lines):
    """Return the source of a function."""
    return "\n".join([f"@{decorator}", f"def {head}:", *(f"    {line}" for line in lines)])


def constants_text(source, layout, states):
    """Return the source that computes the constants of a cell from its parameters, the rows after its states."""
    texts, lines = source.constants.names.items(), source.constants.lines()
    body = [f"lanes[{layout.CONSTANT + i * LANES} + lane] = {text}" for i, (text, _) in enumerate(texts)]
    used = "\n".join([*lines, *body])
    parameters = [f"p{i} = starts[{states + i}, cell]" for i in range(100) if f"p{i}" in _words(used)]
    return function("kernel", "constants(cell, lane, starts, lanes)", [*parameters, *lines, *body, "return"])


def _words(text):
    for sign in "()*+-/,=[]\n":
        text = text.replace(sign, " ")
    return set(text.split())


def series_text(source, states, names):
    """Return the source of the function that computes all coefficients from states, time and constants."""
    given = ", ".join([*(f"y{i}" for i in range(states)), "t", *names])
    watched = [texts for _, _, texts in source.watched]
    found = [
        text or "0.0" for row in (*source.states, *source.wanted, source.rounding, *watched) for text in row
    ]
    # a homogeneous tuple: every entry is a float, even a state that is passed through
    return function("simd", f"series({given})", [*source.lines, f"return ({', '.join(found)},)"])


def call(source, layout, states, names):
    """Return the lines that load a lane and compute its series, and the names of the coefficients.

    Returns
    -------
    lines : list of str
    rows : list of list of str
        The coefficients of the states and of the wanted expressions.
    rounding : list of str
        The magnitudes of the rates.
    watched : list of list of str
        The coefficients of the watched arguments; an empty text is zero.
    """
    load = [f"y{i} = lanes[{layout.Y + i * LANES} + lane]" for i in range(states)]
    load += [f"t = lanes[{layout.TIME} + lane]"]
    load += [f"{name} = lanes[{layout.CONSTANT + i * LANES} + lane]" for i, name in enumerate(names)]
    rows = (*source.states, *source.wanted)
    found = [[f"a{row}_{k}" for k in range(len(each))] for row, each in enumerate(rows)]
    rounding = [f"b{i}" for i in range(states)]
    arguments = [[f"g{row}_{k}" for k in range(len(texts))] for row, (*_, texts) in enumerate(source.watched)]
    unpacked = ", ".join(name for row in (*found, rounding, *arguments) for name in row)
    given = ", ".join([*(f"y{i}" for i in range(states)), "t", *names])
    watched = [
        [name if text else "" for name, text in zip(row, texts, strict=True)]
        for row, (*_, texts) in zip(arguments, source.watched, strict=True)
    ]
    return [*load, f"({unpacked},) = series({given})"], found, rounding, watched


def _coefficients(source, layout, states, names):
    lines, found, rounding, _ = call(source, layout, states, names)
    values = [*(name for row in found for name in row), *rounding]
    lines += [f"lanes[scratch + {place}] = {name}" for place, name in enumerate(values)]
    return function("kernel", "coefficients(lane, scratch, lanes)", lines)


def _safe_step(source, layout, states, names):
    """Return the source of the largest step of one lane, up to h, in which nothing can hide."""
    lines, _, _, watched = call(source, layout, states, names)
    lines = [*lines, f"end = lanes[{layout.END} + lane]", "left = end - t"] if source.watched else []
    for (way, exponent, _), row in zip(source.watched, watched, strict=True):
        lines += step_lines(way, exponent, row)
    return function("kernel", "safe_step(lane, h, lanes)", [*lines, "return h"])


def _radius(texts, row, names):
    """Return the lines with the binary logarithm of the step that a series allows, and its name.

    The last two terms of the series have to be smaller than one of its first three, by the tolerance. This rule is
    independent of units and needs no typical size of a state. If both terms are zero, as for ``cos(t**2)`` at t = 0,
    the two terms before them are used.
    """
    last = [k for k in (ORDER, ORDER - 1) if texts[k]]
    if not last:
        return [], None
    before = {k: k - 2 for k in last if texts[k - 2]}
    lines = []
    if before:
        lines.append(f"gap = {' + '.join(f'abs({names[k]})' for k in last)} < 1e-300")
    for k in last:
        size = f"(abs({names[before[k]]}) if gap else abs({names[k]}))" if k in before else f"abs({names[k]})"
        lines.append(f"e{k} = rough_log2({size} + 1e-300)")
    for k in range(3):
        if texts[k]:
            lines.append(f"b = lt + rough_log2(abs({names[k]}) + 1e-200)")
            for number, at in enumerate(last):
                share = repr(1.0 / (at - k))
                share = f"({1.0 / (at - 2 - k)!r} if gap else {share})" if at in before else share
                lines.append(f"{'z' if number else f'q{k}'} = (b - e{at}) * {share}")
            if len(last) > 1:
                lines.append(f"q{k} = z if z < q{k} else q{k}")
    known = [f"q{k}" for k in range(3) if texts[k]]
    lines.append(f"r{row} = {known[0]}")
    lines += [f"r{row} = {each} if {each} > r{row} else r{row}" for each in known[1:]]
    return lines, f"r{row}"


def _advance(source, layout, states, extremes, names, count, moments):
    """Return the source of one step of one lane; `count` is the number of events."""
    lines, found, rounding, watched = call(source, layout, states, names)
    lines += [f"lt = lanes[{layout.LOG_TOLERANCE} + lane]", "longest = 1000.0"]
    seen = {""}
    for row, texts in enumerate((*source.states, *source.wanted)):
        # an expression that differs from a state by a number has the same terms
        if texts[ORDER] not in seen or row < states:
            more, radius = _radius(texts, row, found[row])
            lines += more + ([f"longest = {radius} if {radius} < longest else longest"] if radius else [])
        seen.add(texts[ORDER])
    lines += [
        f"left = lanes[{layout.END} + lane] - t",
        # a margin for the rough logarithms and for the omitted terms
        "h = rough_exp2(longest - 0.2)",
        f"cap = lanes[{layout.LONGEST} + lane]",
        "h = cap if h > cap else h",
    ]
    events, timed = found[states + extremes :][:count], found[states + extremes + count :]
    lines += _proved(events) or ["h = left if h > left else h"]
    at = {
        name: getattr(layout, name)
        for name in ("COUNT", "TIME", "TOP", "STEP", "Y", "SIZES", "SLOPE", "BEFORE")
    }
    lines += [
        "over = h >= left",
        f"count = lanes[{at['COUNT']} + lane] + 1.0",
    ]
    lines += [f"n{i} = value(h, {', '.join(found[i])})" for i in range(states)]
    lines += [f"last = lanes[{at['BEFORE']} + lane]", "jump = False"]
    for i in range(states):
        # the rate at the end of the last step has to agree with its series; NaN before the first step. All reads come
        # before all writes: otherwise the loop over lanes is not vectorised and seven times as slow
        lines.append(f"d{i} = lanes[{at['SLOPE'] + i * LANES} + lane]")
        lines.append(f"apart = abs({found[i][1]} - d{i}) * last")
        size = f"lanes[{at['SIZES'] + i * LANES} + lane]"
        lines.append(
            f"room = (rough_exp2(lt + {math.log2(JUMP)!r}) + {LEAST_JUMP!r}) * {size} + {LEAST_CHANGE!r}"
        )
        noise = f"{NOISE!r} * {rounding[i]} * last"
        lines.append(f"jump = jump | ((apart > room) & (apart > {noise}))")
    lines += [f"w{i} = value(h, {', '.join(each)})" for i, each in enumerate(found[states:])]
    finite = " + ".join([
        *(f"0.0 * n{i}" for i in range(states)), *(f"0.0 * w{i}" for i in range(len(found) - states))
    ])  # fmt: skip
    lines.append(f"hides = {'unsure' if events else 'False'}")
    for (way, exponent, _), row in zip(source.watched, watched, strict=True):
        lines += watch_lines(way, exponent, row)
    lines.append("unsure = hides")
    for i in range(extremes):
        # steps with several maxima, one of which may be the greatest value so far, are handled in scalar code
        lines.append(f"v{i}, most, proved = greatest(h, w{i}, {', '.join(found[states + i])})")
        lines.append(f"unsure = unsure | ((most > lanes[{at['TOP'] + i * LANES} + lane]) & (not proved))")
    more, levels = _watch_lines(moments, timed, layout)
    lines += more
    lines += [
        # not finite, or too short to advance the time
        f"lost = (not (t + h > t)) | (count > MOST_STEPS) | (not ({finite} == 0.0)) | jump",
        "done = over | lost | unsure",
    ]
    for i in range(states):
        lines.append(f"lanes[{at['Y'] + i * LANES} + lane] = y{i} if done else n{i}")
        lines.append(f"before = lanes[{at['SIZES'] + i * LANES} + lane]")
        lines.append(
            f"lanes[{at['SIZES'] + i * LANES} + lane] = before if done | (abs(n{i}) < before) else abs(n{i})"
        )
        slopes = ", ".join([found[i][1], *(f"{k}.0 * {found[i][k]}" for k in range(2, ORDER + 1)), "0.0"])
        lines.append(f"slope = value(h, {slopes})")
        row = at["SLOPE"] + i * LANES
        lines.append(f"lanes[{row} + lane] = d{i} if done else slope")
    lines.append(f"lanes[{at['BEFORE']} + lane] = last if done else h")
    for i in range(extremes):
        lines.append(f"before = lanes[{at['TOP'] + i * LANES} + lane]")
        lines.append(f"kept = done | (v{i} < before)")
        lines.append(f"lanes[{at['TOP'] + i * LANES} + lane] = before if kept else v{i}")
    for row, level in levels:
        lines.append(f"lanes[{row} + lane] = lanes[{row} + lane] if done else {level}")
    lines += [
        f"lanes[{at['TIME']} + lane] = t if done else t + h",
        f"lanes[{at['COUNT']} + lane] = count - 1.0 if done & (not lost) else count",
        f"lanes[{at['STEP']} + lane] = math.nan if lost else h",
    ]
    return function("simd", "advance(lane, run, lanes)", [*lines, "return done"])


def _proved(events):
    """Return the lines that shorten a step until it is proved free of events, and detect whether it ends after one."""
    if not events:
        return []
    lines = []
    for number, share in enumerate(_SHARES):
        # a share of the step, not of the rest: otherwise a motion that touches an event at its end would never reach it
        lines.append(f"h{number} = {share!r} * h")
        lines.append(f"h{number} = left if h{number} > left else h{number}")
        tests = []
        for j, each in enumerate(events):
            lines.append(f"f{number}_{j} = upper_bound(h{number}, {', '.join(each)})")
            tests.append(f"(f{number}_{j} < 0.0) & ({each[0]} <= 0.0)")
        lines.append(f"o{number} = {' & '.join(tests)}")
    lines.append("h = h0 if o0 else (h1 if o1 else (h2 if o2 else h3))")
    lines.append("proved = o0 | o1 | o2 | o3")
    crossed = " | ".join(f"(value(h, {', '.join(each)}) > 0.0) | ({each[0]} > 0.0)" for each in events)
    return [*lines, f"unsure = (not proved) | {crossed}"]


def _watch_lines(moments, rows, layout):
    """Return the lines that detect steps in which a moment may happen, and the new levels with their rows.

    Scalar code handles these steps (`kernels.system.moments.watch`). In other steps all conditions keep their side, at
    a distance that updates the level.
    """
    lines, levels, at = [], [], 0
    for m, (kind, _, _, *expressions) in enumerate(moments):
        numbers, near = layout.WATCH + m * NUMBERS * LANES, f"level{m}"
        if kind != GREATEST:
            lines.append(f"{near} = lanes[{numbers + LEVEL} + lane]")
            levels.append((numbers + LEVEL, near))
        for i in range(len(expressions)):
            each = rows[at + 1 + i]
            lines.append(f"under = upper_bound(h, {', '.join(each)})")
            if kind == GREATEST:
                # the second-greatest maximum has to be known too
                lines.append(f"unsure = unsure | (not (under <= lanes[{numbers + COUNTED} + lane]))")
                continue
            lines.append(f"beyond = upper_bound(h, {', '.join(f'-{name}' for name in each)})")
            lines.append(f"side = lanes[{layout.SIDE + (at + i) * LANES} + lane]")
            lines.append("apart = under if side < 0.0 else (beyond if side > 0.0 else 1.0)")
            if kind == FIRST:
                # not a number before the moment
                lines.append(f"seen = lanes[{numbers + WHEN} + lane] >= 0.0")
                lines.append("apart = -math.inf if seen else apart")
            lines.append("unsure = unsure | (not (apart < 0.0))")
            lines.append(f"{near} = -apart if -apart < {near} else {near}")
        at += 1 + len(expressions)
    return lines, levels
