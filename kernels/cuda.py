"""The lane kernel's arithmetic on an NVIDIA device: one cell per thread, from the same source as on the CPU.

Nothing of the physics stands here. The kernels of `kernels.cell` and `kernels.rk4`, and all that they call, are
compiled a second time for the device; a thread owns what a lane owns on the CPU and runs it to the same endings
through the same finishing steps. Only the loop differs: a thread keeps its state in registers until an event.
"""

import math

import numpy as np
from numba import cuda

from kernels import rows as at
from kernels.cell import AFRESH, BEGUN
from kernels.cell import begin as begin_on_cpu
from kernels.cell import examine as examine_on_cpu
from kernels.pace import prepared
from kernels.rk4 import lane_step as lane_step_on_cpu

#: Threads of a block: 32 to 256 keep an H200 equally busy, and few leave little to wait for where cells end apart.
THREADS = 64

_compiled = {}


def on_device(kernel):
    """Compile a kernel of this package, and every kernel that it calls, for the device.

    Numba would do this by itself at the first call, but with the CPU's options, and its CUDA target takes any
    `fastmath` for all of it: a NaN would pass unnoticed. Contraction is what the device does unasked.
    """
    source = getattr(kernel, "py_func", kernel)
    if source not in _compiled:
        called = {
            name: on_device(value)
            for name, value in source.__globals__.items()
            if name in source.__code__.co_names and _is_kernel(value)
        }
        copy = type(source)(source.__code__, source.__globals__ | called, source.__name__)
        _compiled[source] = cuda.jit(device=True)(copy)
    return _compiled[source]


def _is_kernel(value):
    source = getattr(value, "py_func", value)
    return hasattr(source, "__code__") and source.__module__.startswith("kernels.")


begin, examine, lane_step = (on_device(kernel) for kernel in (begin_on_cpu, examine_on_cpu, lane_step_on_cpu))

# A thread's numbers lie as in lane 0 of `kernels.rows`, so that the kernels of a cell read them where they always do.
_SIZE = at.SIZE
_S, _C, _T, _W, _O, _R, _TIME = at.S, at.C, at.T, at.W, at.O_RATE, at.S_RATE, at.TIME
_I_TILT, _I_ROLL, _I_SPIN, _I_INVERSE = at.I_TILT, at.I_ROLL, at.I_SPIN, at.I_INVERSE
_UNIFORM, _GRADED, _HEADING, _LEAST_C, _END = at.STEP_UNIFORM, at.STEP_GRADED, at.HEADING, at.LEAST_C, at.END


@cuda.jit(device=True)
def _advance(own):
    """Step until something occurs (the condition of `kernels.lanes`); returns the steps."""
    S, C, T, w, o, s, t = own[_S], own[_C], own[_T], own[_W], own[_O], own[_R], own[_TIME]
    i_tilt, i_roll, i_spin, i_inverse = own[_I_TILT], own[_I_ROLL], own[_I_SPIN], own[_I_INVERSE]
    uniform, graded, heading = own[_UNIFORM], own[_GRADED], own[_HEADING]
    lowest, end = own[_LEAST_C], own[_END]
    steps = 0
    while True:
        h = uniform + graded * C
        S, C, T, w, o, s = lane_step(S, C, T, w, o, s, i_tilt, i_roll, i_spin, i_inverse, h)
        t += h
        steps += 1
        if heading * w < 0.0 or not (C >= lowest) or t >= end:
            break
    own[_S], own[_C], own[_T], own[_W], own[_O], own[_R], own[_TIME] = S, C, T, w, o, s, t
    return steps


@cuda.jit
def _integrate(starts, settings, measures, counts):
    own = cuda.local.array(_SIZE, np.float64)
    cell = cuda.grid(1)
    if cell < starts.shape[1] and begin(cell, 0, starts, settings, own, measures, counts) == BEGUN:
        outcome = AFRESH
        while outcome == AFRESH:
            steps = _advance(own)
            outcome = examine(cell, 0, steps, starts, settings, own, measures, counts)


def integrate(starts, settings, measures, counts):
    """Integrate every cell on the device; arguments and results as in `kernels.lanes.integrate`.

    The bits of a cell depend on the cell alone, as on the CPU, but are not the CPU's: sines, cosines and the places
    where a multiplication and an addition become one instruction differ. Extreme tilts agree within the tolerance.
    """
    n = starts.shape[1]
    if n == 0:
        return
    found, said = cuda.device_array(measures.shape, np.float64), cuda.device_array(counts.shape, np.int32)
    _integrate[math.ceil(n / THREADS), THREADS](
        cuda.to_device(starts), cuda.to_device(prepared(settings)), found, said
    )
    found.copy_to_host(measures)
    said.copy_to_host(counts)
