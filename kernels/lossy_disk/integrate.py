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
Never raises. The bits of a cell depend only on the cell and the settings.

Each set of laws has its own variant, without the cost of the other laws. `variant` returns its name, and the variant
is made on first use. `integrate` has both contour frictions and no other law. A variant ignores the coefficients of
the laws that it omits, and reports no loss to them. The caller has to ensure that they are zero in all cells;
`sweep.model.lossy_disk.model` does so by calling `variant`.
"""

from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel
from kernels.lossy_disk import layout, simd_stages, step_control, step_size
from kernels.lossy_disk.arrays import AIR_LAWS
from kernels.lossy_disk.leg_control import fill_idle, finish_leg, needs_integration, read_start
from kernels.lossy_disk.loss_laws import FLAG_OF_LAW

#: The functions of the disk with all losses for `kernels.lanes`.
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
    further_step=simd_stages.further_step,
    further_steps=simd_stages.BOOLE,
    go_on=step_control.go_on,
)

# Parts of a variant's name -> their flags: dry and viscous contour friction; the flag of the drag of air
_CONTOUR = {"": (True, True), "_dry": (True, False), "_viscous": (False, True), "_bare": (False, False)}
_AIR_NAMES = {law: f"_{AIR_LAWS[law]}" if flag else "" for law, flag in FLAG_OF_LAW.items()}
_AIR = {_AIR_NAMES[law]: flag for law, flag in FLAG_OF_LAW.items()}


def variant(contour, damping, rolling, pivoting, air_law, slips):
    """Return the name of the entry point that has only the laws of a request.

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


#: Name of each variant -> its flags, named as in `kernels.lossy_disk.loss_laws`.
VARIANTS = {
    f"integrate{contour}{rolling}{pivoting}{air}{slipping}": {
        "DRY": _CONTOUR[contour][0],
        "VISCOUS": _CONTOUR[contour][1],
        "ROLLING": bool(rolling),
        "PIVOTING": bool(pivoting),
        **{flag: flag == _AIR[air] for flag in FLAG_OF_LAW.values() if flag},
        "AIR": bool(air),
        "SLIPPING": bool(slipping),
    }
    for contour in _CONTOUR
    for rolling in ("", "_rolling")
    for pivoting in ("", "_pivoting")
    for air in _AIR
    for slipping in ("", "_slipping")
}


def __getattr__(name):
    """Make a variant on first use, because making all of them takes longer than a small run."""
    if name not in VARIANTS:
        # raises AttributeError, as in any module
        return getattr(None, name)
    model = LANE_MODEL._replace(name=name.replace("integrate", "lossy_disk"), flags=VARIANTS[name])
    made = globals()[name] = bind(model)
    return made
