"""The entry point of the disk on an NVIDIA device; arguments and results as in `kernels.disk.integrate`."""

from kernels.disk.integrate import LANE_MODEL
from kernels.lanes.cuda import bind

integrate = bind(LANE_MODEL)
