"""Integration and sampling of one motion of a body with losses, as for the disk, plus its stated errors."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.disk.arrays import STATE
from kernels.lossy_disk.arrays import LOSSES, SAMPLES
from kernels.lossy_disk.endings import HORIZON, UNRESOLVED
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array
from sweep.motion.body_path import check_edge
from sweep.motion.lossy_body_tables import ERRORS, LOSSY_BODY_MOTION
from sweep.motion.lossy_path import Sampled, later, once, sampled, variables
from sweep.motion.request import MotionRequest
from sweep.motion.stated_errors import Found, in_si, settled

_TRAJECTORY = Kernel(LOSSY_BODY_MOTION.kernels, "trajectory", seconds=12.0)

#: The kernels that `follow` calls.
KERNELS = (_TRAJECTORY,)


def follow(spec: MotionRequest, start: Array) -> tuple[Array, dict[str, npt.NDArray[Any]]]:
    """Return the times of the samples [s], shape (n,), and the variables of the file; see `sweep.motion.lossy_path`.

    Raises
    ------
    RequestError
        If the motion is too fast to be resolved, or ends where it begins.
    """
    check_edge(spec)
    found = sampled(spec, start, _TRAJECTORY)
    if found.end == 0.0:
        # a body at rest needs no integration
        zeros = dict.fromkeys(ERRORS, np.zeros(found.times.size, np.float32))
        return found.times, variables(spec, start, found) | zeros
    found, errors = _with_errors(spec, start, found)
    return found.times, variables(spec, start, found) | errors


def _with_errors(
    spec: MotionRequest, start: Array, rough: Sampled
) -> tuple[Sampled, dict[str, npt.NDArray[Any]]]:
    """Return a motion at the same times with shorter steps, and its errors from two steps."""
    times = later(rough.times, rough.ending)

    def again(refinement: int) -> Found | None:
        ending, moments, samples = once(spec, start, times, _TRAJECTORY, rough.refinement + refinement)
        return None if ending == UNRESOLVED else Found(SAMPLES, moments, samples, ending)

    found, errors = settled(spec, again, (*LOSSES, "energy"))
    found.samples[: len(STATE), 0] = start[: len(STATE)]
    end = math.nan if found.ending == HORIZON else float(found.times[-1])
    mass = float(start[list(spec.kind.model.parameters).index("mass")])
    return Sampled(found.times, found.samples, found.ending, end, rough.refinement), in_si(spec, errors, mass)
