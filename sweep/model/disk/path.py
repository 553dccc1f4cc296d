"""The path of the contact point over a nutation: the variables of an atlas with ``path=yes``, for all bodies."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.bodies import arrays, shapes
from sweep.model.description import Columns, Starts
from sweep.model.kernel import Kernel
from sweep.model.quantity import DECISION, STEP_COUNT, Array, Quantity, Tolerance, Word, table

#: The option of a request.
PATH = Word(
    "path",
    "whether the path of the contact point is recorded: yes or no",
    "no",
    ("no", "yes"),
    decides=False,
)

#: The paths of all bodies, the thin disk included.
PATHS = Kernel("kernels.reduction.path", "paths", seconds=12.0)

#: A path is called closed if it comes back after at most this many nutations.
MOST_NUTATIONS = 12

#: Largest difference [rad] of the heading of a closed path from whole turns, over 1 plus the heading gained: its error.
_CLOSED = 1e-8

#: A code of `path_class`, after the codes of the kernel.
CLOSED_PATH = 3

_GAINED = Tolerance(1e-8, 1e-8, "it is a quadrature over the tilt that has converged to 1e-10")
_TURNED = Tolerance(
    12e-8, 12e-8, "it is up to twelve times the heading of a nutation, a quadrature converged to 1e-10"
)
_NO_NUTATION = "missing where ending is not bounded, or next to a separatrix"
_NO_RING = f"{_NO_NUTATION}, or path_class is unbounded"
_NO_COUNT = "0 where path_class is unknown"

# fmt: off
PATH_VARIABLES: Mapping[str, Quantity] = table(
    Quantity("heading_per_nutation", r"\Delta\psi", "rad", "angle that the heading gains over a nutation", _GAINED,
             _NO_NUTATION),
    Quantity("path_drift", "d", "m", "distance between the contact points at two successive smallest tilts",
             _GAINED, _NO_NUTATION),
    Quantity("ring_inner", r"R_1", "m", "smallest distance of the contact point from the centre of its ring", _GAINED,
             _NO_RING),
    Quantity("ring_outer", r"R_2", "m", "largest distance of the contact point from the centre of its ring", _GAINED,
             _NO_RING),
    *(Quantity(f"ring_{axis}", f"{axis}_c", "m",
               f"{axis} of the centre of the ring, from the contact point of the start, in the axes of motions",
               _GAINED, _NO_RING)
      for axis in "xy"),
    Quantity("closing_nutations", "q", "1",
             f"number of nutations, up to {MOST_NUTATIONS}, after which the heading is nearest to whole turns",
             STEP_COUNT, _NO_COUNT, "i4"),
    Quantity("closing_turns", "p", "1", "whole turns nearest to the heading after closing_nutations",
             STEP_COUNT, f"positive: to the left; {_NO_COUNT}", "i4"),
    Quantity("closing_angle", r"|q\Delta\psi - 2\pi p|", "rad",
             "difference of the heading from closing_turns after closing_nutations; 0 for a closed path",
             _TURNED, _NO_NUTATION),
    Quantity("path_class", "", "1", "shape of the path of the contact point", DECISION,
             "annular: it stays on a ring about a fixed centre; closed: annular, and it returns after "
             "closing_nutations, to within a closing_angle of 1e-8 of the heading gained plus 1 rad; unbounded: a "
             "nutation gains whole turns of the heading, to within 1e-8 of it, and the path drifts without limit", "i1",
             {arrays.UNKNOWN_PATH: "unknown", arrays.ANNULAR_PATH: "annular", arrays.UNBOUNDED_PATH: "unbounded",
              CLOSED_PATH: "closed"}),
)
# fmt: on


def path_columns(rows: Array, kind: int, fall_tilt: float) -> Columns:
    """Return the variables of the paths of the contact points of cells.

    Parameters
    ----------
    rows : array, shape (len(kernels.bodies.arrays.PARAMETERS), n)
    kind : int
        Number of the body (`kernels.bodies.shapes`).
    fall_tilt : float
        Tilt [rad] at which motions end.

    Returns
    -------
    mapping of str to array, shape (n,)
        `PATH_VARIABLES`.
    """
    measures, classes = np.empty((len(arrays.PATH), rows.shape[1])), np.empty(rows.shape[1], np.int64)
    call_by_body(PATHS, rows, (float(kind), float(fall_tilt)), (measures, classes))
    columns = dict(zip(arrays.PATH, measures, strict=True))
    closing = _closing(columns["heading_per_nutation"])
    closes = closing["closing_angle"] <= _CLOSED * (
        1.0 + np.abs(closing["closing_nutations"] * columns["heading_per_nutation"])
    )
    shape = np.where(closes & (classes == arrays.ANNULAR_PATH), CLOSED_PATH, classes)
    return {**columns, **closing, "path_class": shape}


def call_by_body(
    kernel: Kernel, rows: Array, settings: tuple[float, ...], results: tuple[npt.NDArray[Any], ...]
) -> None:
    """Call a kernel of `kernels.reduction` with cells sorted by body: neighbors with the same body share its panels.

    Parameters
    ----------
    kernel : Kernel
    rows : array, shape (len(kernels.bodies.arrays.PARAMETERS), n)
    settings : tuple of float
        Its other arguments.
    results : tuple of array, shape (..., n)
        The arrays that the kernel writes, in the order of `rows`.
    """
    bodies = rows[arrays.TUBE : arrays.TRANSVERSE_MOMENT + 1]
    varied = bodies[(bodies != bodies[:, :1]).any(axis=1)]
    if not varied.size:
        kernel.load()(rows, *settings, *results)
        return
    order = np.lexsort(varied)
    sorted_results = tuple(np.empty_like(result) for result in results)
    kernel.load()(np.ascontiguousarray(rows[:, order]), *settings, *sorted_results)
    for result, values in zip(results, sorted_results, strict=True):
        result[..., order] = values


def rows_of_disk(starts: Starts) -> Array:
    """Return the rows of `kernels.bodies.arrays.PARAMETERS` for thin disks, which are tori without a tube."""
    alpha = starts["alpha"]
    # the mass of a disk cannot be further out than that of a hoop
    across = np.where(alpha <= 1.0, 0.5 * alpha, np.nan)
    known = {**starts, "axial_moment": alpha, "transverse_moment": across}
    return np.stack([known.get(name, np.zeros_like(alpha)) for name in arrays.PARAMETERS])


def path_of_disk(starts: Starts, fall_tilt: float) -> Columns:
    """Return the variables of the paths of thin disks, which are tori without a tube.

    Parameters
    ----------
    starts : mapping of str to array, shape (n,)
    fall_tilt : float
        Tilt [rad] at which motions end.

    Returns
    -------
    mapping of str to array, shape (n,)
        `PATH_VARIABLES`.
    """
    return path_columns(rows_of_disk(starts), shapes.TORUS, fall_tilt)


def _closing(gained: Array) -> dict[str, Array]:
    """Return after how many nutations the heading is nearest to whole turns, from the angle gained per nutation."""
    counts = np.arange(1, MOST_NUTATIONS + 1)[:, None]
    headings = counts * gained
    with np.errstate(invalid="ignore"):
        turns = np.rint(headings / (2.0 * np.pi))
        angles = np.abs(headings - 2.0 * np.pi * turns)
        # a path that closes after 2 nutations also closes after 4: argmin finds the first
        first = np.where(angles <= _CLOSED * (1.0 + np.abs(headings)), 0.0, angles)
    known = np.isfinite(gained)
    nearest = np.where(known, first, 0.0).argmin(axis=0)
    cells = np.arange(gained.size)
    return {
        "closing_nutations": np.where(known, nearest + 1, 0),
        "closing_turns": np.where(known, turns[nearest, cells], 0.0).astype(np.int64),
        "closing_angle": angles[nearest, cells],
    }
