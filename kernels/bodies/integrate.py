"""The compiled entry point of bodies of revolution: many cells, each integrated with RK4 until its ending is known.

`integrate(starts, settings, measures, counts)`, as in `kernels.disk.integrate`, with the rows of
`kernels.bodies.arrays`.

Step control, landings, legs, errors and endings are the same as for the disk: copies of its functions in which the
names in `DIFFERENT` refer to the functions of a body.
"""

import math

from kernels.bodies import equations, layout, stages
from kernels.disk import integrate as disk
from kernels.lanes.binding import bind

#: Names of the modules of the disk -> their replacements.
DIFFERENT = {
    "at": layout,
    "EDGED": True,
    # a body may have maxima of the potential at any tilt
    "_LARGEST_TILT": math.pi,
    # with 1.0, the true error exceeded twice the stated one in 1 % of 36,000 random tori and balls
    "_UNSEEN": 2.5,
    "new_constants": stages.constants_of,
    **{name: getattr(stages, name) for name in ("constants_of", "keep_constants", "kept_spin", "state_of")},
    **{
        name: getattr(equations, name)
        for name in (
            "carried", "energy_gained", "fall_along", "fastest_square", "force", "height", "inlined_step", "is_steady",
            "per_inertia", "potential", "pull_and_terms", "slopes_along", "tilt_acceleration", "whole_energy",
        )
    },
}  # fmt: skip

LANE_MODEL = disk.LANE_MODEL._replace(
    name="bodies",
    layout=layout,
    prepared_settings=stages.prepared_settings,
    read_start=stages.read_start,
    fill_idle=stages.fill_idle,
    advance=stages.advance,
    flags=DIFFERENT,
)

integrate = bind(LANE_MODEL)
