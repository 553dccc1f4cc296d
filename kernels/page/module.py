"""The entry points of the module of a page: the disk, with and without losses."""

from kernels.bodies.trajectory import trajectory
from kernels.lanes.binding import bind
from kernels.lossy_disk.integrate import LANE_MODEL
from kernels.lossy_disk.trajectory import trajectory as lossy_trajectory
from kernels.page.starts import complete
from kernels.reduction.cells import reduce
from kernels.reduction.contact_extremes import contact
from kernels.reduction.path import paths
from kernels.reduction.wells import wells

#: All laws; laws with zero coefficients have no effect.
_EVERY_LAW = LANE_MODEL._replace(
    name="lossy_disk_of_page",
    flags=dict.fromkeys(("DRY", "VISCOUS", "ROLLING", "PIVOTING", "FILM", "LAYER", "SLIPPING"), True),
)

#: Name in the module -> entry point.
ENTRIES = {
    "complete": complete,
    "reduce": reduce,
    "wells": wells,
    "contact": contact,
    "paths": paths,
    "trajectory": trajectory,
    "lossy_trajectory": lossy_trajectory,
    "lossy_integrate": bind(_EVERY_LAW),
}
