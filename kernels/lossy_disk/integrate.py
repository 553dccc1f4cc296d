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

`integrate` has all laws. A variant leaves out what a request has no law for, and what it costs: `variant` says its
name, and it is made when the module is first asked for it. Rolling friction costs a root and a quotient in each stage
of a step, Bildsten's law a root.
"""

from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel
from kernels.lossy_disk import layout, loss_laws, simd_stages, step_size
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
)

_WITHOUT_ROLLING = (
    (loss_laws.rolling_friction, loss_laws.no_rolling_friction),
    (step_size.hurry_by_rolling_friction, step_size.no_hurry_by_rolling_friction),
    (simd_stages.goes_on_rolling, simd_stages.always_goes_on_rolling),
    (simd_stages.keep_rolled, simd_stages.keep_nothing),
)
_WITHOUT_PIVOTING = (
    (loss_laws.pivoting_friction, loss_laws.no_pivoting_friction),
    (simd_stages.goes_on_turning, simd_stages.always_goes_on_turning),
    (simd_stages.keep_pivoted, simd_stages.keep_nothing),
)
_WITHOUT_SLIP = ((simd_stages.grips, simd_stages.always_grips),)
_AIR = {
    NO_AIR: (
        (loss_laws.drag, loss_laws.no_drag),
        (loss_laws.viscosity, loss_laws.no_viscosity),
        (simd_stages.keep_blown, simd_stages.keep_nothing),
    ),
    MOFFATT: (
        (loss_laws.drag, loss_laws.film_drag),
        (loss_laws.viscosity, loss_laws.film_viscosity),
    ),
    BILDSTEN: (
        (loss_laws.drag, loss_laws.layer_drag),
        (loss_laws.viscosity, loss_laws.layer_viscosity),
    ),
}
_AIR_NAMES = {NO_AIR: "", MOFFATT: "_moffatt", BILDSTEN: "_bildsten"}


def variant(rolling, air_law, pivoting, slip):
    """Return the name of an entry point of this module.

    Parameters
    ----------
    rolling, pivoting : bool
        Whether any cell has rolling friction, and pivoting friction.
    air_law : int
        Law of the drag of air (`kernels.lossy_disk.arrays`).
    slip : bool
        Whether any cell has a finite friction coefficient.

    Returns
    -------
    str
    """
    more = ("_rolling" * rolling, _AIR_NAMES[air_law], "_pivoting" * pivoting, "_slip" * slip)
    return "integrate_contour" + "".join(more)


_VARIANTS = {
    variant(rolling, air_law, pivoting, slip): (rolling, air_law, pivoting, slip)
    for rolling in (False, True)
    for air_law in _AIR
    for pivoting in (False, True)
    for slip in (False, True)
}


def lane_model(name):
    """Return the `LaneModel` of a variant."""
    rolling, air_law, pivoting, slip = _VARIANTS[name]
    parts = _AIR[air_law]
    parts += () if rolling else _WITHOUT_ROLLING
    parts += () if pivoting else _WITHOUT_PIVOTING
    parts += () if slip else _WITHOUT_SLIP
    return LANE_MODEL._replace(name=name.replace("integrate", "lossy_disk"), parts=parts)


integrate = bind(LANE_MODEL)


def __getattr__(name):
    """Make a variant when it is first asked for."""
    if name not in _VARIANTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    made = globals()[name] = bind(lane_model(name))
    return made
