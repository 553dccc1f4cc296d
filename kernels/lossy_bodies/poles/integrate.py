"""The compiled entry point of balls and spheroids with losses: many cells, each followed until its ending is known.

`integrate(starts, settings, measures, counts)`, with the rows of `kernels.lossy_bodies.arrays`; it knows all laws but
those of the air, and flat_tilt is not read. Events, switches of friction and endings are those of the disk with losses,
in whose functions the names of `DIFFERENT` mean those of a body that rolls through its poles.
"""

from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel
from kernels.lossy_bodies.poles import cell, dry_friction, equations, follow, layout

#: Names of the modules of the disk with losses -> what stands for them here.
DIFFERENT = {
    "decided": dry_friction.decided,
    "step_length": follow.step_length,
    "_margins": follow.margins,
    "_heading": follow.heading,
    "_contact_rests": follow.contact_rests,
    "_turned": follow.turned,
    **{
        name: getattr(equations, name)
        for name in (
            "contact_forces", "contact_rates", "energy_of", "horizontal_rate", "is_above", "moved", "next_state",
            "tilt_of", "tilting_of", "turning_of",
        )
    },
}  # fmt: skip

#: The functions of a ball or a spheroid for the machinery of `kernels.lanes`, whose lanes do not step.
LANE_MODEL = LaneModel(
    name="lossy_poles",
    layout=layout,
    prepared_settings=cell.prepared_settings,
    read_start=cell.read_start,
    fill_idle=cell.fill_idle,
    prepare=cell.prepare,
    needs_integration=cell.needs_integration,
    set_off=cell.set_off,
    advance=cell.advance,
    land=cell.land,
    finish_leg=cell.finish_leg,
    flags=DIFFERENT,
)

integrate = bind(LANE_MODEL)
