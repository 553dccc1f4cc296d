"""The measurements as a file for each kind of processor, and their comparison with earlier records."""

import json
import os
import platform
import re
import sys
import time
from importlib import metadata
from pathlib import Path
from typing import Any

CHECKOUT = Path(__file__).resolve().parents[2]
#: Folder with one record for each kind of processor, `KIND.json`.
RECORDS = CHECKOUT / "docs" / "benchmark"

#: Share by which a ratio may be worse: compared with the record of the same kind of processor, and, if there is none,
#: compared with the least of all records.
_LOSS, _LOSS_ELSEWHERE = 0.2, 0.5


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


def plain_name(held: dict[str, Any]) -> str:
    """Return a processor's name from the result of `machine`, without trademarks, clock rate and core count."""
    name = re.sub(r"\((?:R|TM)\)|@.*|\b\d+-Core\b|\b(?:CPU|Processor)\b", " ", str(held["processor"]))
    return " ".join(name.split())


def kind(held: dict[str, Any]) -> str:
    """Return the name of a processor's record, from the result of `machine`."""
    return re.sub(r"[^a-z0-9]+", "-", f"{plain_name(held)} {held['vectors']}".lower()).strip("-")


def read_all(folder: Path = RECORDS) -> dict[str, dict[str, Any]]:
    """Return the records by kind."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}


def write(found: dict[str, Any], folder: Path = RECORDS) -> Path:
    """Write the record of this kind of processor into a folder; return its path."""
    path = folder / f"{kind(found['machine'])}.json"
    path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return path


def ratios(found: dict[str, Any]) -> dict[str, float]:
    """Return all ratios of two times of one run; larger ones are better for this engine."""
    named = {
        f"{row['name']} / eulerdisk rk4": row["ratio"]["median"]
        for row in found["field"]["contenders"]
        if row["name"] not in ("eulerdisk rk4", "eulerdisk exact")
    }
    for row in found["field"]["contenders"]:
        if row["name"] == "eulerdisk exact":
            named["eulerdisk rk4 / exact"] = 1.0 / row["ratio"]["median"]
    # only one thread, because several wait for other work of the machine
    for kernel, words in zip(found["kernel"][:2], ("own steps", "short steps"), strict=True):
        named[f"plain loop / lane kernel, {words}"] = kernel["ratio"]["median"]
        named[f"share of the multiply-adds, {words}"] = kernel["share"]
    for row in found.get("losses", {}).get("contenders", [])[1:]:
        named[f"{row['name']} / eulerdisk rk4, with losses"] = row["ratio"]
    steps = found.get("losses", {}).get("steps", {})
    for law in sorted(steps.keys() - {"none"}):
        named[f"step without losses / with {law}"] = steps["none"] / steps[law]
    bodies = found.get("bodies", {}).get("ns_per_step", {})
    for name in bodies.keys() - {"disk"}:
        named[f"step of the thin disk / {name}"] = bodies["disk"] / bodies[name]
    systems = found.get("systems") or {}
    for row in systems.get("rows", ()):
        for name in row["ratio"].keys() - {"eulerdisk"}:
            named[f"{name} / one pass, {row['name']}"] = row["ratio"][name]
    if systems:
        named["own kernels / the disk as a system"] = 1.0 / systems["disk"]["ratio"]
    reduction = found.get("reduction", {})
    if reduction:
        named["exact with the period / extremes alone"] = (
            reduction["with_period_per_s"] / reduction["extremes_per_s"]
        )
    for name, row in reduction.get("presets", {}).items():
        named[f"exact with the period / extremes alone, {name}"] = (
            row["with_period_per_s"] / row["extremes_per_s"]
        )
    for name, seconds in found.get("start", {}).get("warm", {}).items():
        named[f"bare imports / {name}"] = found["start"]["bare"] / seconds
    for name, row in found.get("whole", {}).items():
        named[f"kernels and reading / {name} of {row['cells']} cells"] = (
            row["least_possible"] / row["seconds"]
        )
    return named


def losses(found: dict[str, Any], recorded: dict[str, float], most: float = _LOSS) -> list[str]:
    """Return a line for every ratio that is worse than a recorded one by more than a share `most`."""
    now = ratios(found)
    return [
        f"{name}: {now[name]:.3g}, recorded {then:.3g}"
        for name, then in recorded.items()
        if name in now and now[name] < (1.0 - most) * then
    ]


def report_losses(found: dict[str, Any], records: dict[str, dict[str, Any]]) -> int:
    """Print the ratios that became worse than in the record of the same kind, or in all; return the exit status."""
    same = records.get(kind(found["machine"]))
    most = _LOSS if same else _LOSS_ELSEWHERE
    recorded = ratios(same) if same else _least(records)
    worse = losses(found, recorded, most)
    against = "the record of this kind of processor" if same else "the least of all records"
    for line in worse:
        print(f"benchmark: lost more than {100 * most:.0f} %: {line}", file=sys.stderr)
    if not worse:
        compared = len(ratios(found).keys() & recorded.keys())
        print(
            f"benchmark: {compared} ratios, none lost more than {100 * most:.0f} % against {against}",
            file=sys.stderr,
        )
    return 1 if worse else 0


def _least(records: dict[str, dict[str, Any]]) -> dict[str, float]:
    found: dict[str, float] = {}
    for record in records.values():
        for name, ratio in ratios(record).items():
            found[name] = min(ratio, found.get(name, ratio))
    return found
