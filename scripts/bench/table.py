"""The measurements as a table for a terminal, and all records as the table in docs/speed.md."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from bench.record import CHECKOUT, plain_name

PAGE = CHECKOUT / "docs" / "speed.md"

_BLOCK = re.compile(r"(?<=<!-- benchmark -->\n).*?(?=<!-- end of benchmark -->)", re.DOTALL)


def text(found: dict[str, Any]) -> str:
    """Return all measurements as a table for a terminal."""
    return "\n".join(_lines(found))


def _lines(found: dict[str, Any]) -> Iterator[str]:
    held = found["machine"]
    yield f"{held['processor']} {held['vectors']}, {held['processors']} processors, {held['day']}"
    yield f"(load {held['load']:.1f} at the start: on a busy machine, wall times mean little)"
    yield ""
    yield f"Peak tilt of cells released at rest ({found['field']['task']}), one thread each:"
    yield f"{'':22}{'setting':>9}{'cells':>9}{'error':>10}{'us/cell':>12}{'times eulerdisk rk4':>28}"
    for row in found["field"]["contenders"]:
        ratio, cost = row["ratio"], row["us_per_cell"]["median"]
        yield (
            f"{row['name']:22}{row['setting']:9.1g}{row['cells']:9d}{row['error']:10.1e}{cost:12.4g}"
            f"{ratio['median']:12.3g} ({ratio['least']:.3g} to {ratio['greatest']:.3g})"
        )
    for kernel in found["kernel"]:
        ratio = kernel["ratio"]
        yield ""
        yield f"Equal RK4 steps, {kernel['steps_per_cell']:.0f} per cell, {kernel['threads']} thread(s):"
        yield f"  lane kernel {kernel['steps_per_s']:.3g} steps/s, plain prange loop {kernel['plain_steps_per_s']:.3g}"
        yield f"  ratio {ratio['median']:.1f} ({ratio['least']:.1f} to {ratio['greatest']:.1f})"
        yield (
            f"  {kernel['multiply_adds_per_step']} multiply-adds per step: {100 * kernel['share']:.0f} % of the "
            f"measured {kernel['multiply_adds_per_s']:.3g} per second"
        )
    yield ""
    yield "Time per cell in the kernel, rolling preset:"
    for row in found["scaling"]:
        yield f"  {row['cells']:9d} cells, {row['threads']:2d} threads{row['us_per_cell']:10.3f} us"
    if "cuda" in found:
        device = found["cuda"]
        rate, each = device["steps_per_s"], device["steps_per_cell"]
        yield f"{device['device']}: {rate:.3g} steps/s with transfers, {each:.0f} steps per cell"
    if "reduction" in found:
        exact = found["reduction"]
        yield (
            f"exact reduction, {exact['cells']} cells, {exact['threads']} threads: extremes "
            f"{exact['extremes_per_s']:.3g} cells/s, with the period {exact['with_period_per_s']:.3g}"
        )
        for name, row in exact.get("presets", {}).items():
            ratio = row["extremes_per_s"] / row["with_period_per_s"]
            yield f"  {name:10s} {row['cells']:9d} cells: with the period {ratio:.2f} times as long"
    yield from _losses_lines(found)
    yield from _bodies_lines(found)
    yield from _systems_lines(found)
    yield from _whole_lines(found)


def _losses_lines(found: dict[str, Any]) -> Iterator[str]:
    """Yield lines about the cost of the disk with losses, compared with the contenders in its task."""
    if "losses" not in found:
        return
    held, toys = found["losses"], found["losses"]["toys"]
    yield ""
    yield f"Time until toys are flat ({held['task']}), one thread each, relative error:"
    for row in held["contenders"]:
        line = f"{row['name']:22}{row['setting']:9.1g}{row['cells']:9d}{row['error']:10.1e}{row['us_per_cell']:12.4g}"
        steps = (
            f", {row['steps_per_cell']:.0f} steps of {row['ns_per_step']:.1f} ns"
            if row["steps_per_cell"]
            else ""
        )
        yield f"{line}{row['ratio']:12.3g}{steps}"
    each = held.get("steps", {})
    if each:
        yield f"A step without losses takes {each['none']:.2f} ns; with"
    for name, cost in each.items():
        if name != "none":
            yield f"  {name:36}{cost:6.2f} ns{cost / each['none']:6.2f} times as long"
    first, middle, last = toys["times"]
    yield (
        f"{toys['cells']} toys of {middle:.0f} s ({first:.0f} to {last:.0f}), {toys['threads']} thread(s): "
        f"{toys['seconds']:.1f} s, {toys['processor_seconds']:.1f} s of processor time"
    )
    yield (
        f"  {toys['steps_per_cell']:.0f} steps per cell and {toys['ns_per_step']:.1f} ns for each, including the "
        f"{100 * toys['repeated']:.0f} % of the cells that were repeated"
    )
    yield (
        f"  {100 * toys['share_of_threads']:.0f} % of the threads' time busy by the processor time of its chunks; time "
        f"with all lanes full {toys['share_of_lanes']:.2f} of it"
    )


def _bodies_lines(found: dict[str, Any]) -> Iterator[str]:
    """Yield lines about the cost of other bodies compared with the thin disk, and their errors."""
    if "bodies" not in found:
        return
    steps = found["bodies"]["ns_per_step"]
    yield ""
    yield f"Other bodies, one thread; a step of the thin disk takes {steps['disk']:.2f} ns:"
    for name, row in found["bodies"]["errors"].items():
        reduction = f"reduction {row['reduction_us']:.1f} us per cell"
        if name not in steps:
            yield f"  {name:8}{reduction}"
            continue
        yield f"  {name:8}{steps[name]:6.2f} ns{steps[name] / steps['disk']:6.2f} times as long; {reduction}"
        yield (
            f"  {'':8}of {row['cells']} random starts {row['other_endings']} end otherwise, extremes within "
            f"{row['largest_error']:.1e} rad, {100 * row['beyond_twice_stated']:.2g} % beyond twice their stated error"
        )


def _systems_lines(found: dict[str, Any]) -> Iterator[str]:
    """Yield lines about the cost of systems of ten lines at equal error, compared with the contenders."""
    if not found.get("systems"):
        return
    held, disk = found["systems"], found["systems"]["disk"]
    others = list(held["rows"][0]["us_per_cell"])[1:]
    yield ""
    yield f"Systems, 90 % of {held['cells']} cells within {held['target']:g}, one thread each, us (times one pass):"
    yield f"{'':16}{'one pass':>9}{'whole run':>10}" + "".join(f"{name:>23}" for name in others)
    for row in held["rows"]:
        cost, ratio = row["us_per_cell"], row["ratio"]
        theirs = "".join(f"{cost[name]:14.4g} ({ratio[name]:6.3g})" for name in others)
        yield f"{row['name']:16}{cost['eulerdisk']:9.3g}{row['whole_us_per_cell']:10.3g}{theirs}"
    yield f"The thin disk written as a system takes {disk['ratio']:.2f} times the time of its own kernels"
    compiled = [row["compiled_s"] for row in held["rows"]]
    yield f"  compiling one pass of a system: {min(compiled):.1f} to {max(compiled):.1f} s of processor time"
    first, changed = held["first_s"], held["changed_s"]
    yield f"  a run of 2,500 cells: {first:.1f} s for a new file, {changed:.1f} s with another parameter"


def _whole_lines(found: dict[str, Any]) -> Iterator[str]:
    """Yield lines about the time of whole commands: on many cells, on few, and compared with `plan`."""
    for name, row in found.get("whole", {}).items():
        least, file = row["least_possible"], f", file {row['file_MB']:.0f} MB" if "file_MB" in row else ""
        yield f"eulerdisk {name}, {row['cells']} cells: {row['seconds']:.2f} s, {row['memory_MB']:.0f} MB{file}"
        yield f"  {row['seconds'] / least:.2f} times kernels and reading, {least:.2f} s"
    if "start" in found:
        start = found["start"]
        yield f"Start-up: importing numpy and netCDF4 takes {start['bare']:.2f} s"
        for heat in ("warm", "cold"):
            times = ", ".join(f"{name} {seconds:.2f}" for name, seconds in start[heat].items())
            yield f"  {heat} [s]: {times}"
    for row in found.get("plan", ()):
        yield f"plan of {row['cells']} cells, {row['what']}: {row['planned']:.2f} s, took {row['took']:.2f} s"


def page_block(records: dict[str, dict[str, Any]]) -> str:
    """Return the page's table, with one column for each kind of processor."""
    names = [plain_name(found["machine"]) for found in records.values()]
    lines = [f"| | error (rad) | {' | '.join(names)} |", "|---|---|" + "---|" * len(names)]
    columns = [
        {row["name"]: row for row in _best_methods(found["field"]["contenders"])}
        for found in records.values()
    ]
    for name in dict.fromkeys(name for column in columns for name in column):
        rows = [column.get(name) for column in columns]
        error = max(row["error"] for row in rows if row)
        cells = " | ".join(_cost(row) if row else "" for row in rows)
        lines.append(f"| {name} | {f'{error:.0e}' if error else 'reference'} | {cells} |")
    lines += ["", *(_summary_line(found) for found in records.values()), ""]
    for found in records.values():
        lines += _systems_table(found)
    return "\n".join(lines).replace("e+0", "e").replace("e-0", "e-")


#: Columns of the table of systems: title, and the prefix of the contenders, of which the fastest counts.
_BESIDE = (("heyoka", "heyoka"), ("DOP853, compiled", "compiled"), ("SciPy DOP853", "SciPy"))


def _systems_table(found: dict[str, Any]) -> list[str]:
    """Return the page's table of systems of one processor: microseconds per cell, and multiples of one pass."""
    if not found.get("systems"):
        return []
    held = found["systems"]
    titles = [title for title, _ in _BESIDE]
    where = f"{plain_name(found['machine'])}, {held['day']}"
    lines = [
        f"Systems of ten lines on {where}, one thread: microseconds per cell where "
        f"90 % of {held['cells']:,} have an error of at most {held['target']:.0e}; in brackets, times one pass.",
        "",
        f"| | one pass | four passes, errors stated | {' | '.join(titles)} |",
        "|---|---|---|" + "---|" * len(titles),
    ]
    for row in held["rows"]:
        best = [_fastest(row, first) for _, first in _BESIDE]
        costs = " | ".join(
            f"{_two(row['us_per_cell'][name])} ({_two(row['ratio'][name])} ×)" for name in best
        )
        own, whole = row["us_per_cell"]["eulerdisk"], row["whole_us_per_cell"]
        lines.append(f"| {row['name'].replace('_', ' ')} | {_two(own)} | {_two(whole)} | {costs} |")
    times, first, changed = (
        _two(each) for each in (held["disk"]["ratio"], held["first_s"], held["changed_s"])
    )
    return [
        *lines,
        "",
        f"The thin disk written as a system takes {times} times as long as its own kernels. A run of 2,500 cells of a "
        f"new file takes {first} s of processor time, most of it to compile; with another parameter {changed} s.",
        "",
    ]


def _fastest(row: dict[str, Any], first: str) -> str:
    names: list[str] = [name for name in row["us_per_cell"] if name.startswith(first)]
    return min(names, key=lambda name: float(row["ratio"][name]))


def _cost(row: dict[str, Any]) -> str:
    # compared with itself, it would show the noise of the pairs, which the terminal's table contains
    ratio = 1.0 if row["name"] == "eulerdisk rk4" else row["ratio"]["median"]
    return f"{_two(row['us_per_cell']['median'])} µs ({_two(ratio)} ×)"


def _summary_line(found: dict[str, Any]) -> str:
    """Return the kernel's speed relative to a plain loop and to the machine's rate, in one line."""
    held, (kernel, long) = found["machine"], found["kernel"][:2]
    # records from before whole commands were measured contain only a run
    run = found.get("whole", {}).get("run") or found["run"]
    return (
        f"- {plain_name(held)}, {held['vectors']}, {held['day']}: at equal steps {kernel['ratio']['median']:.0f} × as "
        f"fast as a plain `prange` loop with {kernel['steps_per_cell']:.0f} steps per cell, "
        f"{long['ratio']['median']:.0f} × with {long['steps_per_cell']:.0f}, {100 * kernel['share']:.0f} % and "
        f"{100 * long['share']:.0f} % of the measured rate of multiply-adds; {run['cells']:,} cells from start to file "
        f"in {run['seconds']:.1f} s on {held['processors']} processors."
    )


def _best_methods(rows: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the rows in order; of a library with many methods, only the fastest."""
    for row in rows:
        library = row["name"].split()[0]
        rivals = [each for each in rows if each["name"].startswith(library)]
        if library not in ("SciPy", "diffrax") or row == min(
            rivals, key=lambda each: float(each["us_per_cell"]["median"])
        ):
            yield row


def _two(value: float) -> str:
    """Return a number with two significant digits, written out."""
    return f"{float(f'{value:.2g}'):,.10g}"


def write_page(records: dict[str, dict[str, Any]], path: Path = PAGE) -> None:
    """Put the table between the markers of the page."""
    before = path.read_text(encoding="utf-8")
    path.write_text(_BLOCK.sub(lambda _: page_block(records), before), encoding="utf-8")


def block_in(path: Path = PAGE) -> str:
    """Return the text between the markers of the page."""
    found = _BLOCK.search(path.read_text(encoding="utf-8"))
    return found[0] if found else ""
