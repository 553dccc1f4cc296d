"""The lane kernel's arithmetic on an NVIDIA device: one cell per thread, from the same source as on the CPU.

Nothing of the physics stands here. The kernels of `kernels.disk.leg_control`, `kernels.disk.simd_stages` and `kernels.disk.rk4`, and all that
they call, are compiled a second time for the device; a thread owns what a lane owns on the CPU and runs it to the same
endings through the same finishing steps. Only the loop differs: a thread keeps its state in registers until an event.
"""

import math

import numpy as np
from numba import cuda

from kernels.disk import layout as at
from kernels.disk import leg_control as cell
from kernels.disk import rk4
from kernels.disk import simd_stages as columns
from kernels.disk.step_size import COS_FALL, DURATION, PACE, STEP, prepared

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


_read, _moves, _goes_on = on_device(cell.read), on_device(cell.moves), on_device(cell.goes_on)
_prepare, _set_off, _land = on_device(columns.prepare), on_device(columns.set_off), on_device(columns.land)
_lane_step = on_device(rk4.lane_step)

# A thread's numbers lie as in lane 0 of `kernels.disk.layout`, so that the kernels of a cell read them where they always do.
_SIZE, _STEPS = at.SIZE, at.STEPS
_S, _C, _T, _W, _O, _P, _TIME = at.S, at.C, at.T, at.W, at.O_RATE, at.P, at.TIME
_I_TILT, _I_SPIN, _DRAG = at.I_TILT, at.I_SPIN, at.DRAG
_UNIFORM, _GRADED, _HEADING, _END = at.HALF_UNIFORM, at.HALF_GRADED, at.HEADING, at.END


@cuda.jit(device=True)
def _begin(number, starts, settings, own, measures, counts):
    """Read and prepare a cell: whether it moves; if not, it is written."""
    if not _read(number, 0, starts, settings, own, measures, counts):
        return False
    _prepare(0, settings[STEP], settings[PACE], own)
    if not _moves(number, 0, settings, own, measures, counts):
        return False
    _set_off(0, settings[STEP], settings[DURATION], own)
    return True


@cuda.jit(device=True)
def _advance(own, lowest):
    """Step until something occurs (the condition of `kernels.lanes.schedule`)."""
    S, C, T, w, o, p, t = own[_S], own[_C], own[_T], own[_W], own[_O], own[_P], own[_TIME]
    i_tilt, i_spin, drag = own[_I_TILT], own[_I_SPIN], own[_DRAG]
    uniform, graded, heading, end = own[_UNIFORM], own[_GRADED], own[_HEADING], own[_END]
    steps = 0
    while True:
        half = uniform + graded * C
        S, C, T, w, o, p = _lane_step(S, C, T, w, o, p, i_tilt, i_spin, drag, half)
        t += half + half
        steps += 1
        if heading * w < 0.0 or not (C >= lowest) or t >= end:
            break
    own[_S], own[_C], own[_T], own[_W], own[_O], own[_P], own[_TIME] = S, C, T, w, o, p, t
    own[_STEPS] = steps


@cuda.jit
def _integrate(starts, settings, measures, counts):
    own = cuda.local.array(_SIZE, np.float64)
    number = cuda.grid(1)
    if number < starts.shape[1] and _begin(number, starts, settings, own, measures, counts):
        goes_on = True
        while goes_on:
            _advance(own, settings[COS_FALL])
            _land(0, settings[COS_FALL], own)
            goes_on = _goes_on(number, 0, settings, own, measures, counts)


def integrate(starts, settings, measures, counts):
    """Integrate every cell on the device; arguments and results as in `kernels.lanes.schedule.integrate`.

    The bits of a cell depend on the cell alone, as on the CPU, but are not the CPU's: library functions (a few sines,
    powers) and the places where a multiplication and an addition become one instruction differ. Extreme tilts agree
    within the tolerance.
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
