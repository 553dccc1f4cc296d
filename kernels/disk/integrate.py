"""The compiled entry point of the disk: many cells, each integrated with RK4 until its ending is known.

`integrate(starts, settings, measures, counts)`, with the rows of `kernels.disk.arrays`:

Parameters
----------
starts : float64[len(PARAMETERS), n]
settings : float64[len(SETTINGS)]
measures : float64[len(MEASURES), n], written
counts : int32[len(COUNTS), n], written

Notes
-----
Never raises. The bits of a cell depend only on the cell and the settings.
"""

from kernels.disk import layout
from kernels.disk.leg_control import fill_idle, finish_leg, needs_integration, read_start
from kernels.disk.simd_stages import advance, land, prepare, set_off
from kernels.disk.step_size import prepared_settings
from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel

#: The functions of the disk for `kernels.lanes`.
LANE_MODEL = LaneModel(
    name="disk",
    layout=layout,
    prepared_settings=prepared_settings,
    read_start=read_start,
    fill_idle=fill_idle,
    prepare=prepare,
    needs_integration=needs_integration,
    set_off=set_off,
    advance=advance,
    land=land,
    finish_leg=finish_leg,
)

integrate = bind(LANE_MODEL)
