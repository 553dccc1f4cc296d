"""The compiled entry point of balls and spheroids with losses: many cells, each followed until its ending is known.

`integrate(starts, settings, measures, counts)`, with the rows of `kernels.lossy_bodies.arrays`; it knows all laws but
those of the air, and flat_tilt is not read. Events, switches of friction and endings are those of the disk with losses,
in whose functions the names of `DIFFERENT` mean those of a body that rolls through its poles.
"""

from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel
from kernels.lossy_bodies.poles import cell, creeping, dry_friction, equations, follow, layout

#: Steps after which a motion is abandoned, of which each takes a microsecond.
_MOST_STEPS = 1.0e6

#: Names of the modules of the disk with losses -> what stands for them here.
DIFFERENT = {
    "MOST_STEPS": _MOST_STEPS,
    "decided": dry_friction.decided,
    "next_state": follow.next_state,
    "step_length": follow.step_length,
    "_margins": follow.margins,
    "_heading": follow.heading,
    "_contact_rests": follow.contact_rests,
    "inertia_of_turning": follow.inertia_of_turning,
    "still_held": follow.still_held,
    "turned_by": follow.turned_by,
    **{
        name: getattr(equations, name)
        for name in (
            "contact_forces", "contact_rates", "energy_of", "horizontal_rate", "is_above", "moved", "tilt_of",
            "tilting_of", "time_scale", "turning_of",
        )
    },
    **{
        name: getattr(creeping, name)
        for name in ("accelerations", "along", "creeps", "growing", "parted", "placed", "stiffness_at")
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
