"""Whole commands on many cells, compared with the unavoidable time: the kernels' own time, and reading the file."""

import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

import sweep
from bench.problem import reduce_disks
from bench.scaling import grid, kernel_seconds
from sweep.engine.grid import blocks, chunks, starts_of
from sweep.platforms import most_threads

#: Starts a command and prints its peak memory [kB]; needed because the peak of a child is not reported separately.
_RUNNER = (
    "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL); "
    "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
)


def measure(quick: bool) -> dict[str, dict[str, Any]]:
    """Return seconds, memory and the least possible seconds of `run`, `verify` and `compare`, with all threads."""
    # a few cells first, because `bench.start` measures the cost of an empty cache
    _measure(10**4)
    found = _measure(10**6 if quick else 10**7)
    print(f"benchmark: {found['run']['cells']} cells run, verified and compared", file=sys.stderr)
    return found


def _measure(count: int) -> dict[str, dict[str, Any]]:
    spec = sweep.SweepSpec.from_words("rolling", grid(count))
    threads = most_threads()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "atlas.nc"
        program = (sys.executable, "-m", "sweep")
        run = _command((*program, "run", "rolling", *grid(count), "-o", str(path)))
        found = {"run": run | {"least_possible": kernel_seconds(count, threads)}}
        found["run"]["file_MB"] = path.stat().st_size / 1e6
        reading = _reading_seconds(path, spec)
        found["verify"] = _command((*program, "verify", str(path)))
        found["verify"]["least_possible"] = reading + _exact_seconds(spec)
        found["compare"] = _command((*program, "compare", str(path), str(path)))
        found["compare"]["least_possible"] = 2.0 * reading
    for row in found.values():
        row["cells"] = spec.size
    return found


def _command(words: Sequence[str]) -> dict[str, Any]:
    began = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", _RUNNER, *words], check=True, capture_output=True, text=True)
    return {"seconds": time.perf_counter() - began, "memory_MB": int(done.stdout) / 1024}


def _reading_seconds(path: Path, spec: sweep.SweepSpec) -> float:
    """Return the seconds in which netCDF4 reads all variables of the cells, chunk by chunk."""
    began = time.perf_counter()
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        cells = [variable for variable in file.variables.values() if variable.shape == spec.shape]
        for _, slices in chunks(spec.shape):
            for variable in cells:
                variable[slices]
    return time.perf_counter() - began


def _exact_seconds(spec: sweep.SweepSpec) -> float:
    """Return the seconds of the exact reduction with the period, block by block."""
    taken = 0.0
    for span in blocks(spec.size):
        starts = np.stack(list(starts_of(spec, span).values()))
        began = time.perf_counter()
        reduce_disks(starts, True)
        taken += time.perf_counter() - began
    return taken
