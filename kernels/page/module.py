"""The entry points of the module of a page: the disk, with and without losses."""

import numpy as np

from kernels.disk.contact_extremes import contact_extremes
from kernels.disk.exact.chunk_periods import periods
from kernels.disk.exact.extremes import CHUNK, TABLES, reduce
from kernels.disk.exact.legendre import COLUMNS, NODES, PANELS, ROWS, TERMS, build_tables
from kernels.disk.exact.wide_panels import CENTRES, WIDE_ROWS, WIDE_TERMS, build_wide_panels
from kernels.disk.trajectory import derived, trajectory
from kernels.lanes.binding import bind
from kernels.lossy_disk.integrate import LANE_MODEL
from kernels.lossy_disk.trajectory import trajectory as lossy_trajectory
from kernels.page.starts import complete
from kernels.reduction.path import paths

#: All laws: those whose coefficients are zero take nothing.
_EVERY_LAW = LANE_MODEL._replace(
    name="lossy_disk_of_page",
    flags=dict.fromkeys(("DRY", "VISCOUS", "ROLLING", "PIVOTING", "FILM", "LAYER", "SLIPPING"), True),
)

#: Name in the module -> entry point.
ENTRIES = {
    "complete": complete,
    "build_tables": build_tables,
    "build_wide_panels": build_wide_panels,
    "reduce": reduce,
    "periods": periods,
    "contact_extremes": contact_extremes,
    "paths": paths,
    "trajectory": trajectory,
    "derived": derived,
    "lossy_trajectory": lossy_trajectory,
    "lossy_integrate": bind(_EVERY_LAW),
}


def sizes():
    """Return the sizes that a page has to know to call the entry points: a dict that JSON can hold.

    Returns
    -------
    dict
        ``memory``, the shapes of the arrays that each parallel entry point is called with last; ``panels``, ``nodes``
        and ``wide``, those of the tables of one alpha; ``chunk``, cells that `reduce` treats at a time; ``tables``, how
        many tables of different alphas one call has at most.
    """
    memory = {
        "reduce": reduce.memory(np.empty((1, CHUNK)), 0.0, 0, np.ones(TABLES)),
        "contact_extremes": contact_extremes.memory(),
        "paths": paths.memory(),
        "lossy_integrate": ENTRIES["lossy_integrate"].memory(),
    }
    return {
        "memory": {name: [each.shape for each in arrays] for name, arrays in memory.items()},
        "panels": (PANELS, ROWS, TERMS),
        "nodes": (NODES, COLUMNS),
        "wide": (CENTRES, WIDE_ROWS, WIDE_TERMS),
        "chunk": CHUNK,
        "tables": TABLES,
    }
