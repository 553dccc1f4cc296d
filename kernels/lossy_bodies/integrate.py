"""The compiled entry points of bodies with losses: many cells, each integrated with RK4 until its ending is known.

As in `kernels.lossy_disk.integrate`, with the same names of variants and the rows of `kernels.lossy_bodies.arrays`.
Legs, steps, events, dry friction, ledger and errors are the same as for the disk: copies of its functions in which
the names in `DIFFERENT` refer to the functions of a body.
"""

from kernels.bodies.equations import per_inertia
from kernels.lanes.binding import bind
from kernels.lossy_bodies import arrays, equations, lane_step, layout, stages
from kernels.lossy_disk import integrate as disk

#: Names of the modules of the disk -> their replacements, also used by a single motion in time
#: (`kernels.lossy_bodies.trajectory`).
MECHANICS = {
    "EDGED": True,
    "loss_row": arrays,
    "per_inertia": per_inertia,
    **{
        name: getattr(equations, name)
        for name in (
            "beginning_roll", "circle", "compliance", "contact_forces", "energy_of", "lever", "losses_here",
            "pull_at_rest", "time_scale", "turning_inertia", "unforced",
        )
    },
}  # fmt: skip

#: The same for cells.
DIFFERENT = MECHANICS | {
    "at": layout,
    "inertia_of": stages.inertia_of,
    "_excess": stages.energy_won,
    "sliding_step": lane_step.lane_step,
    **{name: getattr(lane_step, name) for name in ("changes", "changes_near", "fastest_rate", "grips")},
}

#: The functions of a body with all losses for `kernels.lanes`.
LANE_MODEL = disk.LANE_MODEL._replace(
    name="lossy_bodies",
    layout=layout,
    prepared_settings=stages.prepared_settings,
    read_start=stages.read_start,
    fill_idle=stages.fill_idle,
    prepare=stages.prepare,
    flags=DIFFERENT,
)


def __getattr__(name):
    """Make a variant on first use."""
    if name not in disk.VARIANTS:
        # raises AttributeError, as in any module
        return getattr(None, name)
    flags = DIFFERENT | disk.VARIANTS[name]
    model = LANE_MODEL._replace(name=name.replace("integrate", "lossy_bodies"), flags=flags)
    made = globals()[name] = bind(model)
    return made
