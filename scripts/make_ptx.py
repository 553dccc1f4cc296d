"""Compile every model for an NVIDIA device, on a machine that has none: PTX for compute capability 9.0.

    python scripts/make_ptx.py [MODEL ...]      disk, bodies, lossy, or the preset of a system; by default all but lossy

It needs the extra `cuda`. One line for each model: seconds, size of the text, bytes of a thread's memory outside
registers, and the instructions that load from there. Exit status 1 if a model does not compile.
"""

import re
import sys
import time
import traceback
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
from numba import cuda, float64, int32
from numba.cuda import dispatcher

from kernels.bodies.integrate import LANE_MODEL as BODIES
from kernels.disk.integrate import LANE_MODEL as DISK
from kernels.lanes import cuda as device
from kernels.lanes.binding import copied, rebound_for, replacements
from kernels.lossy_disk import integrate as lossy_disk
from kernels.system import integrate as system
from sweep.request.spec import SweepSpec

_CAPABILITY = (9, 0)

_SYSTEMS = ("kapitza", "thomas")


def lane_model(name: str) -> tuple[Any, list[float]]:
    """Return the lane model of a name, and settings of a run, whose values do not matter."""
    if name in ("disk", "bodies"):
        return (DISK, [300.0, 0.0, 1.5, 1e-8]) if name == "disk" else (BODIES, [300.0, 0.0, 1.5, 1e-8, 0.0])
    if name == "lossy":
        return lossy_disk.integrate_dry.lane_model, [300.0, 0.0, 1.5, 1e-8, 0.0, 0.0, 0.0, 0.0]
    kernel = SweepSpec.preset(name).model.integrate
    return getattr(system, kernel.function).lane_model, [100.0, 0.0, 1e-10]


def make_ptx(model: Any, settings: list[float]) -> str:
    """Return the PTX of a model's kernel."""

    def recompiled(name: str, kernel: Any, different: dict[str, Any]) -> Any:
        copy = copied(name, kernel, different)
        return copy if kernel is device._integrate else cuda.jit(device=True)(copy)

    kernel = rebound_for(model.name, device._integrate, replacements(model), model.flags or {}, recompiled)
    run = numba.typeof(model.prepared_settings(np.array(settings)))
    types = (float64[:, ::1], run, float64[:, ::1], int32[:, ::1])
    text: str = cuda.compile_ptx(kernel, types, cc=_CAPABILITY)[0]
    return text


def main(names: list[str]) -> int:
    """Compile models; return 1 if one fails."""
    # the compiler asks the device that it does not need for its capability
    dispatcher.get_current_device = lambda: SimpleNamespace(compute_capability=_CAPABILITY)
    failed = 0
    for name in names or ["disk", "bodies", *_SYSTEMS]:
        began = time.perf_counter()
        try:
            text = make_ptx(*lane_model(name))
        except Exception:
            traceback.print_exc()
            failed = 1
            continue
        local = sum(map(int, re.findall(r"__local_depot\d+\[(\d+)\]", text)))
        seconds, loads = time.perf_counter() - began, text.count("ld.local")
        print(f"{name:<10} {seconds:5.1f} s  {len(text):>8} characters  {local:>6} bytes  {loads} loads")
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
