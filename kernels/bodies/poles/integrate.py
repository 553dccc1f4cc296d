"""The compiled entry point of balls and spheroids: many cells, each integrated with RK4 until its ending is known.

`integrate(starts, settings, measures, counts)`, as `kernels.bodies.integrate`; fall_tilt is not read. Legs, landings
and endings are those of the disk, in which the names of `DIFFERENT` mean the functions of a motion through the poles.
"""

from kernels.bodies import ellipse
from kernels.bodies import equations as of_bodies
from kernels.bodies import stages as of_stages
from kernels.bodies.poles import equations, error_estimate, layout, stages
from kernels.disk import integrate as disk
from kernels.lanes.binding import bind

#: Names of the modules of the disk -> what stands for them here.
DIFFERENT = {
    "at": layout,
    "GRADED": False,
    "new_constants": stages.constants_of,
    "keep_constants": of_stages.keep_constants,
    "_allowed": stages.allowed_error,
    "_passed_in_doubt": stages.passed_in_doubt,
    **{name: getattr(stages, name) for name in ("constants_of", "state_of", "scale_of", "longest", "set_off")},
    **{name: getattr(equations, name) for name in ("carried", "fastest_square", "inlined_step", "tilt_acceleration")},
    **{name: getattr(error_estimate, name) for name in ("drift", "estimated_error", "uncertain_energy")},
    # of the state in tilt and rates: starts, and the search for maxima of the potential
    **{
        name: getattr(of_bodies, name)
        for name in (
            "fall_along", "force", "is_steady", "per_inertia", "potential", "slopes_along", "whole_energy",
        )
    },
    **ellipse.FUNCTIONS,
}  # fmt: skip

LANE_MODEL = disk.LANE_MODEL._replace(
    name="poles",
    layout=layout,
    prepared_settings=stages.prepared_settings,
    read_start=stages.read_start,
    fill_idle=stages.fill_idle,
    set_off=stages.set_off,
    advance=stages.advance,
    flags=DIFFERENT,
)

integrate = bind(LANE_MODEL)
