"""A cell's bits depend only on the cell: not on threads, blocks, the surrounding grid, or the process."""

import hashlib

import numpy as np
import pytest
from processes import CHECKOUT, python

from sweep.model.disk.tables import VARIABLES
from sweep.request.spec import SweepSpec
from sweep.runs.in_memory import run

pytestmark = pytest.mark.compiled

#: More cells than a kernel's chunk, with falls, refinements and a computed roll rate; every kind of axis.
GRIDS = {
    "rolling": SweepSpec.preset("rolling").replace(roll_rate="0.5:4:61", tilt="0.001deg:60deg:41:log"),
    "spinning": SweepSpec.preset("spinning").replace(precession_rate="-6:6:61", tilt="0.001deg:60deg:41:log"),
    "circling": SweepSpec.preset("circling").replace(
        tilt="0.25deg:30deg:17", precession_rate="-1:5:31", alpha="0.3,0.5,1"
    ),
}


def bits(atlas):
    """Return the bytes of every variable of an atlas, including boundaries and coordinates."""
    return {name: variable.values.tobytes() for name, variable in atlas.variables.items()}


@pytest.mark.usefixtures("two_threads")
@pytest.mark.parametrize("preset", GRIDS)
def test_threads_and_blocks_change_no_bit(preset):
    """All variables are bit-identical, also in a second run of the process."""
    spec = GRIDS[preset]
    atlas = run(spec, threads=1, block_cells=10**6)
    assert set(np.unique(atlas["ending"])) > {1}
    for threads, block_cells in ((1, 10**6), (1, 64), (2, 7), (2, 2500), (2, 10**6)):
        found = run(spec, threads=threads, block_cells=block_cells)
        assert bits(found) == bits(atlas), (threads, block_cells)


def test_a_part_of_a_grid_has_the_bits_of_the_whole():
    """Cells picked from a grid, run as their own grid, give the same bits."""
    for spec in GRIDS.values():
        whole = run(spec)
        picked = {name: slice(2, None, 3) if len(whole[name]) > 5 else slice(1, 2) for name in spec.axes}
        part = run(spec.replace(**{name: whole[name].values[pick].tolist() for name, pick in picked.items()}))
        for name in VARIABLES:
            assert part[name].values.tobytes() == whole[name].isel(picked).values.tobytes(), (
                spec.title,
                name,
            )


def test_another_order_of_axes_has_the_same_bits():
    """The order of the axes only transposes the atlas."""
    spec = GRIDS["rolling"]
    atlas, other = run(spec), run(spec.replace(axes=spec.axes[::-1]))
    assert other["tilt_max"].dims == spec.axes[::-1]
    for name in VARIABLES:
        assert np.array_equal(other[name].values.T, atlas[name].values, equal_nan=True), name


_DIGEST = """
import hashlib, sys
from sweep import SweepSpec, run
atlas = run(SweepSpec.from_canonical(sys.argv[1]), threads=int(sys.argv[2]))
print(hashlib.sha256(b"".join(atlas[name].values.tobytes() for name in sorted(atlas.variables))).hexdigest())
"""


#: Two threads anywhere; the C library of Linux returns memory to the system at once, and fills new and freed
#: memory.
STRICT = {"NUMBA_NUM_THREADS": "2", "MALLOC_MMAP_THRESHOLD_": "65536", "MALLOC_PERTURB_": "165"}


@pytest.mark.slow_lane
def test_another_process_has_the_same_bits():
    """A separate process that loads the kernels from the cache agrees bit by bit.

    Filled memory shows that the kernels use none too early or too late.
    """
    spec = GRIDS["circling"]
    atlas = run(spec)
    expected = hashlib.sha256(
        b"".join(atlas[name].values.tobytes() for name in sorted(atlas.variables))
    ).hexdigest()
    found = python("-c", _DIGEST, spec.canonical(), "2", folder=CHECKOUT, environment=STRICT)
    assert found.stdout.strip() == expected
