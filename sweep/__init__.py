"""Stability atlases of a disk rolling without slip.

``sweep.run(spec)`` computes an atlas, ``sweep.SweepSpec`` says which; see `__all__` for the rest. Datasets have the
accessor ``dataset.eulerdisk``.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

import kernels
from sweep.foreign_settings import ignore_numba_file
from sweep.import_hook import when_imported
from sweep.version import __version__

if getattr(kernels, "MARK", None) != "eulerdisk":
    raise ImportError(
        f"`import kernels` found another distribution's package at {kernels.__file__}. eulerdisk owns the import "
        "names `sweep` and `kernels`: install it in an environment of its own."
    )

if TYPE_CHECKING:
    from sweep.atlas.dataset import run as run
    from sweep.atlas.reclassify import reclassify as reclassify
    from sweep.atlas.reclassify import refine as refine
    from sweep.checks.verify import verify as verify
    from sweep.errors import RequestError as RequestError
    from sweep.files.netcdf import save as save
    from sweep.files.reading import open_atlas as open_atlas
    from sweep.motion.request import TrajectorySpec as TrajectorySpec
    from sweep.motion.trajectory import simulate as simulate
    from sweep.request.axes import Range as Range
    from sweep.request.axes import Values as Values
    from sweep.request.criterion import Criterion as Criterion
    from sweep.request.spec import SweepSpec as SweepSpec
    from sweep.runs.run import run_to_file as run_to_file

# Loaded when first used: reading a request must not wait for numba and xarray.
_HOME = {
    "Criterion": "sweep.request.criterion",
    "Range": "sweep.request.axes",
    "RequestError": "sweep.errors",
    "SweepSpec": "sweep.request.spec",
    "TrajectorySpec": "sweep.motion.request",
    "Values": "sweep.request.axes",
    "open_atlas": "sweep.files.reading",
    "reclassify": "sweep.atlas.reclassify",
    "refine": "sweep.atlas.reclassify",
    "run": "sweep.atlas.dataset",
    "run_to_file": "sweep.runs.run",
    "save": "sweep.files.netcdf",
    "simulate": "sweep.motion.trajectory",
    "verify": "sweep.checks.verify",
}

__all__ = ["__version__", *_HOME]


# Before Numba is loaded, which no module of this package does when it is imported itself
ignore_numba_file()
# dataset.eulerdisk, as soon as there are datasets
when_imported("xarray", lambda: import_module("sweep.accessor"))


def __getattr__(name: str) -> Any:
    """Import a public name from its home."""
    if name in _HOME:
        # not above: there it would end the command line with a traceback, which `sweep.cli` can avoid
        import_module("sweep.platforms").check_system()
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'sweep' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
