"""The compiled entry point of balls and spheroids with losses: many cells, each followed until its ending is known.

`integrate(starts, settings, measures, counts)`, with the rows of `kernels.lossy_bodies.arrays`; it knows all laws but
those of the air, and flat_tilt is not read. Events, switches of friction and endings are those of the disk with losses,
in whose functions the names of `DIFFERENT` mean those of a body that rolls through its poles. Each motion is followed
in scalar code, none in lanes.
"""

from kernels.lanes.binding import variant
from kernels.lossy_bodies.poles import creeping, dry_friction, equations, follow
from kernels.lossy_bodies.poles.cell import prepared_settings, treat
from kernels.native.entry import parallel

#: Cells that a thread takes at a time: each takes milliseconds.
_CHUNK = 16

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


@parallel(
    _CHUNK, starts="float64[:, ::1]", settings="float64[::1]", measures="float64[:, ::1], written",
    counts="int32[:, ::1], written",
)  # fmt: skip
def _integrate(start, stop, starts, settings, measures, counts):
    """Follow every cell until its ending is known.

    Parameters
    ----------
    starts : float64[len(PARAMETERS), n]
    settings : float64[len(SETTINGS)]
    measures : float64[len(MEASURES), n], written
    counts : int32[len(COUNTS), n], written

    Notes
    -----
    Never raises. A cell's bits depend on the cell and the settings alone.
    """
    run = prepared_settings(settings)
    for cell in range(start, stop):
        treat(cell, starts, run, measures, counts)


integrate = variant(_integrate, "lossy_poles", DIFFERENT)
