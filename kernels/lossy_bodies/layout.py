"""The rows of a cell in the flat array of LANES cells; names as in `kernels.lossy_disk.layout`."""

from kernels.lanes.layout import place_rows
from kernels.lossy_disk import layout as disk

#: `kernels.lossy_bodies.equations.Rolling`.
_BODY = "CORE SHIFT EDGE AXIAL TRANSVERSE RATIO INVERSE_SPIN SIDE"

globals().update(
    place_rows(
        (disk.CHANGED, disk.CALL, disk.STAGE, _BODY, disk.READ),
        (disk.START, disk.UNITS, disk.CRITERION, disk.NEXT_LEG, disk.FOUND, disk.CONTROL, disk.PASS),
        returned="TAKEN",
    )
)
