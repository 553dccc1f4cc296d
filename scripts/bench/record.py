"""What was measured, as a file, as a table, as the README's block, and against an earlier record."""

import json
import os
import platform
import re
import sys
import time
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

CHECKOUT = Path(__file__).resolve().parents[2]
RECORD = CHECKOUT / "docs" / "benchmark.json"
README = CHECKOUT / "README.md"

_BLOCK = re.compile(r"(?<=<!-- benchmark -->\n).*?(?=<!-- end of benchmark -->)", re.DOTALL)
#: What may be lost before a ratio counts as worse.
_LOSS = 0.2


def machine() -> dict[str, Any]:
    """Return the processor, the versions and the day."""
    processor = platform.processor() or platform.machine()
    try:
        found = re.search(r"model name\s*:\s*(.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
        processor = found[1] if found else processor
    except OSError:
        pass
    versions = {}
    for name in ("numba", "numpy", "scipy", "heyoka", "jax", "diffrax"):
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return {
        "processor": processor,
        "vectors": "AVX-512" if "avx512f" in _flags() else "AVX2" if "avx2" in _flags() else "",
        "processors": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "load": os.getloadavg()[0],
        "python": platform.python_version(),
        "versions": versions,
        "day": time.strftime("%Y-%m-%d", time.gmtime()),
    }


def _flags() -> set[str]:
    try:
        found = re.search(r"^flags\s*:\s*(.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.M)
    except OSError:
        return set()
    return set(found[1].split()) if found else set()


def text(found: dict[str, Any]) -> str:
    """Return all of it as a table for a terminal."""
    return "\n".join(_lines(found))


def _lines(found: dict[str, Any]) -> Iterator[str]:
    held = found["machine"]
    yield f"{held['processor']} {held['vectors']}, {held['processors']} processors, {held['day']}"
    yield f"(load {held['load']:.1f} before it began: by the clock, seconds of a busy machine mean little)"
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
        yield (
            f"eulerdisk verify, {exact['cells']} cells: {exact['command_seconds']:.2f} s from start to verdict, "
            f"sweep.verify {exact['verify_seconds']:.2f} s"
        )
    run = found["run"]
    yield (
        f"eulerdisk run, {run['cells']} cells: {run['seconds']:.2f} s (least {run['least']:.2f}) from start to file, "
        f"{run['memory_MB']:.0f} MB, file {run['file_MB']:.0f} MB"
    )


def readme_block(found: dict[str, Any]) -> str:
    """Return the README's table."""
    held, run, (kernel, long) = found["machine"], found["run"], found["kernel"][:2]
    lines = ["| | error (rad) | time per cell | against `rk4` |", "|---|---|---|---|"]
    for row in _best_methods(found["field"]["contenders"]):
        cost, ratio = _two(row["us_per_cell"]["median"]), _two(row["ratio"]["median"])
        error = f"{row['error']:.0e}" if row["error"] else "reference"
        lines.append(f"| {row['name']} | {error} | {cost} µs | {ratio} × |")
    vectors = f", {held['vectors']}" if held["vectors"] else ""
    lines += [
        "",
        f"{held['processor']}{vectors}, {held['day']}. At equal steps the lane kernel is "
        f"{kernel['ratio']['median']:.0f} times as fast as a plain `prange` loop with",
        f"{kernel['steps_per_cell']:.0f} steps per cell, {long['ratio']['median']:.0f} times with "
        f"{long['steps_per_cell']:.0f}: {100 * kernel['share']:.0f} % and {100 * long['share']:.0f} % of "
        "the measured rate of multiply-adds.",
        f"`eulerdisk run` takes {run['seconds']:.1f} s from start to file for {run['cells']:,} cells on "
        f"{held['processors']} processors.",
        "",
    ]
    return "\n".join(lines).replace("e+0", "e").replace("e-0", "e-")


def _best_methods(rows: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the rows in their order, of a library of many methods only the fastest."""
    for row in rows:
        library = row["name"].split()[0]
        rivals = [each for each in rows if each["name"].startswith(library)]
        if library not in ("SciPy", "diffrax") or row == min(
            rivals, key=lambda each: float(each["us_per_cell"]["median"])
        ):
            yield row


def _two(value: float) -> str:
    """Return two significant digits, written out."""
    return f"{float(f'{value:.2g}'):,.10g}"


def read(path: Path = RECORD) -> dict[str, Any]:
    """Return a record."""
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def write(found: dict[str, Any], path: Path) -> None:
    """Write a record."""
    path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def write_readme(found: dict[str, Any], path: Path = README) -> None:
    """Put the table between the markers of the README."""
    before = path.read_text(encoding="utf-8")
    path.write_text(_BLOCK.sub(lambda _: readme_block(found), before), encoding="utf-8")


def block_in(path: Path = README) -> str:
    """Return what stands between the markers of the README."""
    found = _BLOCK.search(path.read_text(encoding="utf-8"))
    return found[0] if found else ""


def ratios(found: dict[str, Any]) -> dict[str, float]:
    """Return everything that is a ratio of two times of one run, the larger the better for this engine."""
    named = {
        f"{row['name']} / eulerdisk rk4": row["ratio"]["median"]
        for row in found["field"]["contenders"]
        if row["name"] not in ("eulerdisk rk4", "eulerdisk exact")
    }
    for row in found["field"]["contenders"]:
        if row["name"] == "eulerdisk exact":
            named["eulerdisk rk4 / exact"] = 1.0 / row["ratio"]["median"]
    # one thread: several wait for whatever else the machine is doing
    for kernel, words in zip(found["kernel"][:2], ("own steps", "short steps"), strict=True):
        named[f"plain loop / lane kernel, {words}"] = kernel["ratio"]["median"]
        named[f"share of the multiply-adds, {words}"] = kernel["share"]
    return named


def losses(found: dict[str, Any], recorded: dict[str, Any]) -> list[str]:
    """Return a line for every ratio that is worse than the recorded one by more than a fifth."""
    now, then = ratios(found), ratios(recorded)
    return [
        f"{name}: {now[name]:.3g}, recorded {then[name]:.3g}"
        for name in then
        if name in now and now[name] < (1.0 - _LOSS) * then[name]
    ]


def report_losses(found: dict[str, Any], recorded: dict[str, Any]) -> int:
    """Print the losses; return the exit status."""
    worse = losses(found, recorded)
    for line in worse:
        print(f"benchmark: lost more than {100 * _LOSS:.0f} %: {line}", file=sys.stderr)
    if not worse:
        compared = len(ratios(found).keys() & ratios(recorded).keys())
        print(f"benchmark: {compared} ratios, none lost more than {100 * _LOSS:.0f} %", file=sys.stderr)
    return 1 if worse else 0
