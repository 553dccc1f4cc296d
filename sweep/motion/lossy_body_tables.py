"""The kind of motions of bodies of revolution with losses: words and variables (`sweep.motion.tables`)."""

from collections.abc import Mapping
from dataclasses import replace

from kernels.lossy_disk.endings import EDGE_CHANGE
from sweep.model.lossy_bodies import tables as lossy
from sweep.model.lossy_bodies.model import LOSSY_BODIES
from sweep.model.quantity import Input, Quantity, Tolerance, Word, table
from sweep.motion import body_tables
from sweep.motion.body_tables import error_of, of_a_body
from sweep.motion.tables import LAWS, LOSSY_INPUTS, LOSSY_MOTION, LOSSY_TRAJECTORY, LOSSY_WORDS

_INPUTS: Mapping[str, Input] = table(
    *lossy.PARAMETERS.values(),
    *(of_a_body(LOSSY_INPUTS[name]) for name in ("duration", "interval", "step", "flat_tilt")),
)

_WORDS: Mapping[str, Word] = table(
    LOSSY_WORDS["title"],
    LOSSY_WORDS["method"],
    *(lossy.OPTIONS[name] for name in ("body", "filling", "air_law")),
)

#: Stated error -> its unit and its description.
ERRORS: Mapping[str, tuple[str, str]] = {
    **body_tables.ERRORS,
    "energy_error": ("J", "stated error of the energy and of each loss"),
}

_ENERGIES = (*LAWS, "energy")
_CHANGED: Mapping[str, Mapping[str, object]] = {
    "inclination": {"long_name": "angle between the axis of the body and the vertical"},
    "held": {
        "description": LOSSY_TRAJECTORY["held"].description.replace("at the rim", "where the contact runs")
    },
}


def _variable(row: Quantity) -> Quantity:
    if row.name in _ENERGIES:
        row = replace(
            row, tolerance=Tolerance(1e-9, 1e-9, "each value is within its stated error", "energy_error")
        )
    return replace(body_tables.variable(row), **_CHANGED.get(row.name, {}))  # type: ignore[arg-type]


def _ending(row: Quantity) -> Quantity:
    return replace(
        row,
        description=f"{row.description}; edge_change: the tilt reached 0, where the other edge of a disk with a rim "
        "hits the plane",
        flags={**(row.flags or {}), EDGE_CHANGE: "edge_change"},
    )


#: The variables of the file of one motion; all but the last two have the dimension elapsed_time.
VARIABLES: Mapping[str, Quantity] = table(
    *(_variable(row) for name, row in LOSSY_TRAJECTORY.items() if name not in ("ending", "end_time")),
    *(error_of(name, *row) for name, row in ERRORS.items()),
    _ending(LOSSY_TRAJECTORY["ending"]),
    LOSSY_TRAJECTORY["end_time"],
)

LOSSY_BODY_MOTION = replace(
    LOSSY_MOTION,
    model=LOSSY_BODIES,
    inputs=_INPUTS,
    words=_WORDS,
    variables=VARIABLES,
    fixed=(*(name for name in lossy.PARAMETERS if name not in VARIABLES),),
    endings={**LOSSY_MOTION.endings, "edge change": body_tables.BODY_MOTION.endings["edge change"]},
    headline="Motion of a body of revolution that loses energy",
    summary="One motion of a body of revolution that rolls without slipping on a horizontal plane and loses energy to "
    "friction and air: tilt and rates, path of contact point and centre of mass, energy, the energy that each law has "
    "taken, and contact forces, with stated errors.",
    path="sweep.motion.lossy_body_path",
    kernels="kernels.lossy_bodies.trajectory",
    turning=body_tables.BODY_MOTION.turning,
    keywords="rolling body of revolution, torus, Euler's disk, dissipation, dry friction, trajectory, contact forces",
    sample_size=300,
    called="body",
)
