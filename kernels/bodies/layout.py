"""The rows of a cell of a body in the flat array of LANES cells; names as in `kernels.disk.layout`."""

from kernels.disk import layout as disk
from kernels.lanes.layout import place_rows

#: The constants of a body (`kernels.bodies.shapes.Body`); the sign of the tilts on the edge that it rolls on, 0 if it
#: has no other edge.
_BODY, _EDGE = "CORE SHIFT EDGE ALPHA TRANSVERSE RATIO", "SIDE"

globals().update(
    place_rows(
        (disk.CHANGED, _BODY, disk.READ, _EDGE),
        (
            disk.START,
            disk.UNIT_ROW,
            disk.STEADINESS,
            disk.REFINEMENT,
            disk.FIRST_LEG,
            disk.FOUND,
            disk.LEG_END,
        ),
        returned="HALF",
    )
)
