"""Stability atlases of a disk rolling without slip.

``sweep.run(spec)`` computes an atlas, ``sweep.SweepSpec`` says which; see `__all__` for the rest. Datasets have the
accessor ``dataset.eulerdisk``.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

import kernels
from sweep.arrival import on_arrival

__version__ = "0.1.0"

if getattr(kernels, "MARK", None) != "eulerdisk":
    raise ImportError(
        f"`import kernels` found another distribution's package at {kernels.__file__}. eulerdisk owns the import "
        "names `sweep` and `kernels`: install it in an environment of its own."
    )

if TYPE_CHECKING:
    from sweep.atlas import run as run
    from sweep.audit import verify as verify
    from sweep.axes import Range as Range
    from sweep.axes import Values as Values
    from sweep.criterion import Criterion as Criterion
    from sweep.errors import RequestError as RequestError
    from sweep.running import run_to_file as run_to_file
    from sweep.spec import SweepSpec as SweepSpec
    from sweep.store import open_atlas as open_atlas
    from sweep.store import save as save
    from sweep.trajectory import simulate as simulate
    from sweep.trajectory_spec import TrajectorySpec as TrajectorySpec
    from sweep.verdicts import reclassify as reclassify
    from sweep.verdicts import refine as refine

# Loaded when first used: reading a request must not wait for numba and xarray.
_HOME = {
    "Criterion": "sweep.criterion",
    "Range": "sweep.axes",
    "RequestError": "sweep.errors",
    "SweepSpec": "sweep.spec",
    "TrajectorySpec": "sweep.trajectory_spec",
    "Values": "sweep.axes",
    "open_atlas": "sweep.store",
    "reclassify": "sweep.verdicts",
    "refine": "sweep.verdicts",
    "run": "sweep.atlas",
    "run_to_file": "sweep.running",
    "save": "sweep.store",
    "simulate": "sweep.trajectory",
    "verify": "sweep.audit",
}

__all__ = ["__version__", *_HOME]


# dataset.eulerdisk, as soon as there are datasets
on_arrival("xarray", lambda: import_module("sweep.accessor"))


def __getattr__(name: str) -> Any:
    """Import a public name from its home."""
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'sweep' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
