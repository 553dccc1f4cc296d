"""The time that `plan` predicts for a run, and the time that the run takes."""

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from bench.scaling import grid

#: Kinds of planned atlases: name -> additional words.
_KINDS = {
    "plain": (),
    "exact": ("method=exact",),
    "contact": ("contact=yes",),
    "refined": ("boundary=refined",),
}


def measure(quick: bool) -> list[dict[str, Any]]:
    """Return, for each kind of atlas and number of cells, the seconds that `plan` predicts and that `run` takes."""
    rows: list[dict[str, Any]] = []
    for count in (10**5, 10**6) if quick else (10**5, 10**6, 10**7):
        for what, words in _KINDS.items():
            with tempfile.TemporaryDirectory() as folder:
                asked = ["rolling", *grid(count), *words, "-o", str(Path(folder) / "atlas.nc")]
                said = subprocess.run(
                    [sys.executable, "-m", "sweep", "plan", *asked],
                    check=True,
                    capture_output=True,
                    text=True,
                ).stdout
                began = time.perf_counter()
                subprocess.run(
                    [sys.executable, "-m", "sweep", "run", *asked], check=True, capture_output=True
                )
                took = time.perf_counter() - began
            rows.append({"what": what, "cells": count, "planned": _seconds(said), "took": took})
            print(f"benchmark: {count} cells planned and run, {what}", file=sys.stderr)
    return rows


def _seconds(said: str) -> float:
    """Return the seconds in the time line of `plan`."""
    found = re.search(r"time +about ([0-9.]+) (s|min|h)\b", said)
    assert found, said
    return float(found[1]) * {"s": 1.0, "min": 60.0, "h": 3600.0}[found[2]]
