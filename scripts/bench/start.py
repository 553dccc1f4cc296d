"""The time of commands on few cells: their start, with and without kernels in the cache."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

_BARE = (sys.executable, "-c", "import numpy, netCDF4")
_GRID = ("roll_rate=2:4:50", "tilt=0.001deg:5deg:50:log")


def measure(repeats: int) -> dict[str, Any]:
    """Return the least seconds of each command on 2,500 cells, and of bare imports of the same libraries.

    `warm` has all kernels in the cache; `cold` starts with an empty cache, so that a command compiles everything it
    needs.
    """
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        commands = _commands(place)
        cold = {}
        for name in ("run", "verify", "explain"):
            environment = os.environ | {"EULERDISK_CACHE_DIR": str(place / f"cache-{name}")}
            if name == "run":
                cold[name] = _seconds(commands[name], environment)
                continue
            # the atlas that the command reads is created before
            _seconds(commands["run"], os.environ)
            cold[name] = _seconds(commands[name], environment)
        for command in commands.values():
            _seconds(command, os.environ)
        # by turns, so that a busy minute affects all of them
        taken: dict[str, list[float]] = {name: [] for name in ("bare", *commands)}
        for _ in range(repeats):
            for name, seconds in taken.items():
                seconds.append(_seconds(_BARE if name == "bare" else commands[name], os.environ))
    least = {name: min(seconds) for name, seconds in taken.items()}
    print("benchmark: commands started", file=sys.stderr)
    return {"bare": least.pop("bare"), "warm": least, "cold": cold}


def _commands(place: Path) -> dict[str, Sequence[str]]:
    program, atlas = (sys.executable, "-m", "sweep"), str(place / "atlas.nc")
    return {
        "help": (*program, "--help"),
        "run": (*program, "run", "rolling", *_GRID, "-o", atlas, "--overwrite"),
        "info": (*program, "info", atlas),
        "boundary": (*program, "boundary", atlas),
        "plan": (*program, "plan", "rolling"),
        "plot": (*program, "plot", atlas, "-o", str(place / "atlas.png")),
        "explain": (*program, "explain", atlas, "roll_rate=2.5", "tilt=1deg"),
        "verify": (*program, "verify", atlas),
    }


def _seconds(command: Sequence[str], environment: Mapping[str, str]) -> float:
    began = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True, env=environment)
    return time.perf_counter() - began
