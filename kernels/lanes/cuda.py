"""Any model on an NVIDIA device: one cell per thread, from the same functions as on the CPU.

The functions of a model, and all that they call, are compiled a second time for the device. A thread holds the same
numbers as a lane on the CPU and a block of one cell, and runs the same stages to the same endings. Only the loop
differs: a thread steps its single cell until an event, without waiting for others.
"""

import math

import numpy as np
from numba import cuda

from kernels.lanes.binding import copied, rebound_for, replacements
from kernels.lanes.interface import (
    FURTHER_STEPS,
    RETURNED,
    STEPPING,
    STEPS,
    advance,
    finish_leg,
    further_step,
    go_on,
    land,
    needs_integration,
    prepare,
    read_start,
    set_off,
)
from kernels.lanes.layout import LANES

#: Threads of a block. An H200 is equally fast with 32 to 256; in a small block, threads whose cells end early wait
#: less.
THREADS = 64

#: Numbers of a thread: the stepping numbers of a lane, then the block of its cell; `bind` replaces it.
TOTAL = None


def _begin(cell, starts, run, own, measures, counts):
    """Read, prepare and set off a cell; return whether it has to be stepped."""
    if not read_start(cell, 0, starts, run, own, measures, counts):
        return False
    prepare(0, run, own)
    if not needs_integration(cell, 0, run, own, measures, counts):
        return False
    set_off(0, run, own)
    return True


def _step_to_event(run, memory):
    """Step until an event ends the leg."""
    for row in range(0, STEPPING, LANES):
        memory[row] = memory[STEPPING + row]
    steps = 0
    while True:
        steps += 1
        event = advance(0, run, memory)
        for n in range(FURTHER_STEPS.size):
            further_step(0, FURTHER_STEPS[n], run, memory)
        if event:
            if not go_on(0, STEPPING, run, memory):
                break
            # the lane rested in the step that found the event
            steps -= 1
    for row in range(0, RETURNED, LANES):
        memory[STEPPING + row] = memory[row]
    memory[STEPPING + STEPS] = steps


def _integrate(starts, run, measures, counts):
    """Integrate one cell per thread."""
    # laid out as lane 0 of the model's layout, so that the functions of the model can be used unchanged
    memory = cuda.local.array(TOTAL, np.float64)
    cell = cuda.grid(1)
    for row in range(0, STEPPING, LANES):
        memory[row] = 0.0
    block = memory[STEPPING:]
    if cell < starts.shape[1] and _begin(cell, starts, run, block, measures, counts):
        going = True
        while going:
            _step_to_event(run, memory)
            land(0, run, block)
            going = finish_leg(cell, 0, run, block, measures, counts)


def _recompiled(name, kernel, different):
    # Numba would compile called kernels for the device by itself, but with the options of the CPU, and its CUDA
    # target turns any `fastmath` into all of it: a NaN would pass unnoticed. The device contracts a*b + c by default.
    return cuda.jit(device=kernel is not _integrate)(copied(name, kernel, different))


def problem():
    """Return why no device can compute, without a period; empty if one can, as it does here with a tiny kernel."""
    if not cuda.is_available():
        return "no device with a driver was found"
    numbers = np.zeros(1)
    try:
        cuda.jit(_count)[1, 1](numbers)
    except Exception as error:
        # whatever it is: the compiler, the driver, or versions that do not fit together
        return f"a first kernel failed with {type(error).__name__}: {error}"
    return "" if numbers[0] == 1.0 else "a first kernel computed a wrong number"


def _count(numbers):
    numbers[0] += 1.0


def bind(model):
    """Return the entry point of a model on the device.

    Parameters
    ----------
    model : kernels.lanes.interface.LaneModel

    Returns
    -------
    callable
        Arguments and results as in `kernels.lanes.schedule.integrate`. The bits of a cell depend only on the cell, as
        on the CPU, but differ from the CPU's: the device has other library functions (a few sines, powers) and
        contracts other pairs of multiplication and addition into one instruction.

    Raises
    ------
    ValueError
        If the model has flags that no function uses.
    """
    kernel = rebound_for(model.name, _integrate, replacements(model), model.flags or {}, _recompiled)

    def integrate(starts, settings, measures, counts):
        n = starts.shape[1]
        if n == 0:
            return
        device_measures = cuda.device_array(measures.shape, np.float64)
        device_counts = cuda.device_array(counts.shape, np.int32)
        kernel[math.ceil(n / THREADS), THREADS](
            cuda.to_device(starts), model.prepared_settings(settings), device_measures, device_counts
        )
        device_measures.copy_to_host(measures)
        device_counts.copy_to_host(counts)

    return integrate
