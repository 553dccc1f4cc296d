"""The compiled entry points of the disk with losses: many cells, each integrated with RK4 until its ending is known.

Each takes `(starts, settings, measures, counts)`, with the rows of `kernels.lossy_disk.arrays`:

Parameters
----------
starts : float64[len(PARAMETERS), n]
settings : float64[len(SETTINGS)]
measures : float64[len(MEASURES), n], written
counts : int32[len(COUNTS), n], written

Notes
-----
Never raises. A cell's bits depend on the cell and the settings alone.

There is a variant for each set of laws, which leaves out what the others would cost: `variant` says its name, and it is
made when the module is first asked for it. `integrate` has both contour frictions and no other law. A variant takes no
notice of the coefficients of a law that it leaves out, and reports no loss to it: whoever calls one must know that they
are zero in all cells, as `sweep.model.lossy_disk.model` does by `variant`.
"""

from typing import Any

from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel
from kernels.lossy_disk import lane_step, layout, loss_laws, simd_stages, step_control, step_size
from kernels.lossy_disk.arrays import BILDSTEN, MOFFATT, NO_AIR
from kernels.lossy_disk.leg_control import fill_idle, finish_leg, needs_integration, read_start

#: The functions of the disk with all losses for the machinery of `kernels.lanes`.
LANE_MODEL = LaneModel(
    name="lossy_disk",
    layout=layout,
    prepared_settings=step_size.prepared_settings,
    read_start=read_start,
    fill_idle=fill_idle,
    prepare=simd_stages.prepare,
    needs_integration=needs_integration,
    set_off=simd_stages.set_off,
    advance=simd_stages.advance,
    land=simd_stages.land,
    finish_leg=finish_leg,
    coast=simd_stages.coast,
    coasts=simd_stages.BOOLE,
    go_on=step_control.go_on,
)

_DRY = (
    (loss_laws.rub_force, loss_laws.dry_rub_force),
    (simd_stages.keep_damped, simd_stages.keep_nothing),
)
_VISCOUS = (
    (loss_laws.dry_force, loss_laws.no_dry_force),
    (simd_stages.goes_on_sliding, simd_stages.goes_on_rolling_along),
    (loss_laws.rub_force, loss_laws.viscous_rub_force),
    (simd_stages.keep_rubbed, simd_stages.keep_nothing),
)
_BARE = (
    (loss_laws.dry_force, loss_laws.no_dry_force),
    (simd_stages.goes_on_sliding, simd_stages.goes_on_rolling_along),
    (loss_laws.rub_force, loss_laws.no_rub_force),
    (simd_stages.keep_rubbed, simd_stages.keep_nothing),
    (simd_stages.keep_damped, simd_stages.keep_nothing),
)
_WITHOUT_ROLLING = (
    (loss_laws.horizontal_rate, loss_laws.no_horizontal_rate),
    (loss_laws.horizontal_rate_near, loss_laws.no_horizontal_rate_near),
    (loss_laws.rolling_friction, loss_laws.no_rolling_friction),
    (loss_laws.rolling_friction_near, loss_laws.no_rolling_friction_near),
    (step_size.hurry_by_rolling_friction, step_size.no_hurry_by_rolling_friction),
    (simd_stages.goes_on_rolling, simd_stages.always_goes_on_rolling),
    (simd_stages.keep_rolled, simd_stages.keep_nothing),
    (simd_stages.keep_rate, simd_stages.keep_nothing),
)
_ROLLING = ((lane_step.tangent, lane_step.corrected_tangent),)
_WITHOUT_PIVOTING = (
    (loss_laws.pivoting_force, loss_laws.no_pivoting_force),
    (loss_laws.pivoting_friction, loss_laws.no_pivoting_friction),
    (lane_step.with_pivoting, lane_step.without_pivoting),
    (simd_stages.goes_on_turning, simd_stages.always_goes_on_turning),
    (simd_stages.keep_pivoted, simd_stages.keep_nothing),
)
_WITHOUT_AIR = (
    (loss_laws.drag, loss_laws.no_drag),
    (loss_laws.drag_near, loss_laws.no_drag_near),
    (simd_stages.keep_root, simd_stages.keep_nothing),
    (loss_laws.viscosity, loss_laws.no_viscosity),
    (simd_stages.keep_blown, simd_stages.keep_nothing),
)
_MOFFATT = (
    (loss_laws.drag, loss_laws.film_drag),
    (loss_laws.drag_near, loss_laws.film_drag_near),
    (simd_stages.keep_root, simd_stages.keep_nothing),
    (loss_laws.viscosity, loss_laws.film_viscosity),
)
_BILDSTEN = (
    (loss_laws.drag, loss_laws.layer_drag),
    (loss_laws.drag_near, loss_laws.layer_drag_near),
    (loss_laws.viscosity, loss_laws.layer_viscosity),
    (lane_step.tangent, lane_step.corrected_tangent),
)
_WITHOUT_SLIP = ((simd_stages.grips, simd_stages.always_grips),)

# What each part of a variant's name stands for, group by group
_GROUPS: tuple[dict[str, tuple[Any, ...]], ...] = (
    {"": (), "_dry": _DRY, "_viscous": _VISCOUS, "_bare": _BARE},
    {"": _WITHOUT_ROLLING, "_rolling": _ROLLING},
    {"": _WITHOUT_PIVOTING, "_pivoting": ()},
    {"": _WITHOUT_AIR, "_moffatt": _MOFFATT, "_bildsten": _BILDSTEN},
    {"": _WITHOUT_SLIP, "_slipping": ()},
)
_AIR_NAMES = {NO_AIR: "", MOFFATT: "_moffatt", BILDSTEN: "_bildsten"}


def variant(contour, damping, rolling, pivoting, air_law, slips):
    """Return the name of the entry point of this module that has no more than the laws of a request.

    Parameters
    ----------
    contour, damping, rolling, pivoting : bool
        Whether any cell has dry contour friction, viscous contour friction, rolling friction, pivoting friction.
    air_law : int
        Law of the drag of air (`kernels.lossy_disk.arrays`).
    slips : bool
        Whether any cell has a finite friction coefficient.

    Returns
    -------
    str
    """
    rubbing = ("" if contour else "_viscous") if damping else ("_dry" if contour else "_bare")
    return "integrate" + "".join(
        (rubbing, "_rolling" * rolling, "_pivoting" * pivoting, _AIR_NAMES[air_law], "_slipping" * slips)
    )


def _variants(groups):
    """Return the parts of all variants by the ends of their names."""
    if not groups:
        return {"": ()}
    others = _variants(groups[1:])
    return {name + end: parts + more for name, parts in groups[0].items() for end, more in others.items()}


def _without_viscosity(end):
    """Return the parts of a variant, by the end of its name, in which no force on the roll rate grows with it."""
    rigid = end.startswith(("_dry", "_bare")) and not any(air in end for air in ("_moffatt", "_bildsten"))
    return ((step_size.hurry_by_viscosity, step_size.no_hurry_by_viscosity),) if rigid else ()


#: Name of each variant -> its parts.
VARIANTS = {"integrate" + end: parts + _without_viscosity(end) for end, parts in _variants(_GROUPS).items()}


def __getattr__(name):
    """Make a variant when it is first asked for: to make all takes longer than a small run."""
    if name not in VARIANTS:
        # an AttributeError, as for any module
        return getattr(None, name)
    model = LANE_MODEL._replace(name=name.replace("integrate", "lossy_disk"), parts=VARIANTS[name])
    made = globals()[name] = bind(model)
    return made
