"""The tables of bodies with losses: the tables of bodies, plus the losses and measures of the disk with losses."""

from collections.abc import Mapping
from dataclasses import replace

from kernels.bodies.shapes import FIRST_WITH_POLES, NAMES
from kernels.lossy_bodies import arrays
from kernels.lossy_disk import endings as code
from sweep.model.bodies import tables as bodies
from sweep.model.lossy_disk import tables as disk
from sweep.model.quantity import OPEN, Ending, Endings, Input, Quantity, Word, table

#: Bodies that end up lying flat: the model has no losses for bodies that roll on through their poles.
BODIES = NAMES[:FIRST_WITH_POLES]

#: The body of a request that names none; bodies with a flat face, under which there is air.
DEFAULT, FACED = "torus", ("rounded", "rim")

#: Lengths that default to 0. A torus without a tube is a hoop.
OPTIONAL = (*bodies.OPTIONAL, "tube")


PARAMETERS: Mapping[str, Input] = table(
    *bodies.PARAMETERS.values(),
    *(
        row
        for name, row in disk.PARAMETERS.items()
        if name in arrays.PARAMETERS and name not in bodies.PARAMETERS
    ),
)

SUBSTITUTES = bodies.SUBSTITUTES

SETTINGS = disk.SETTINGS

OPTIONS: Mapping[str, Word] = table(
    replace(
        bodies.OPTIONS["body"],
        default=DEFAULT,
        choices=BODIES,
        remark="leave body out for the thin disk",
    ),
    bodies.OPTIONS["filling"],
    *disk.OPTIONS.values(),
)

ENDINGS = Endings(
    *disk.ENDINGS,
    Ending(
        code.EDGE_CHANGE,
        "edge_change",
        "the tilt reached 0: a disk with a rim stands on both of its edges",
        OPEN,
        "the tilt reached 0, where the other edge hits the plane: this model does not include that impact",
    ),
    lost_time="end_time",
)

_CHANGED: Mapping[str, Mapping[str, str]] = {
    "amplification": {"description": disk.describe_amplification(bodies.AMPLIFICATION_SCALE)},
    "path_length": {
        "long_name": "path length of the contact point along its circle on the body",
        "description": "without the motion across that circle when a rounded edge rolls to and fro; "
        + disk.VARIABLES["path_length"].description,
    },
}

VARIABLES: Mapping[str, Quantity] = table(
    ENDINGS.quantity,
    *(
        replace(row, **_CHANGED.get(name, {}))  # type: ignore[arg-type]
        for name, row in disk.VARIABLES.items()
        if name != "ending"
    ),
)
assert tuple(PARAMETERS) == arrays.PARAMETERS
