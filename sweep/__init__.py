"""Stability atlases of rolling disks and other bodies, and of your own systems.

``sweep.run(spec)`` computes the atlas that a ``sweep.SweepSpec`` describes; datasets have the accessor
``dataset.eulerdisk``. The names in ``__all__`` are public: docs/api.md lists them with their arguments, and states how
they may change.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

import kernels
from sweep.import_hook import when_imported
from sweep.version import __version__

if getattr(kernels, "MARK", None) != "eulerdisk":
    raise ImportError(
        f"`import kernels` found the package of another distribution at {kernels.__file__}. eulerdisk needs the "
        "import names `sweep` and `kernels`: install it in its own environment."
    )

if TYPE_CHECKING:
    from sweep.accessor import Eulerdisk as Eulerdisk
    from sweep.atlas.reclassify import reclassify as reclassify
    from sweep.atlas.reclassify import refine as refine
    from sweep.checks.compare import Comparison as Comparison
    from sweep.checks.compare import compare as compare
    from sweep.checks.findings import Findings as Findings
    from sweep.checks.verify import findings as findings
    from sweep.checks.verify import verify as verify
    from sweep.errors import LeftOutWarning as LeftOutWarning
    from sweep.errors import RequestError as RequestError
    from sweep.errors import StoppedError as StoppedError
    from sweep.errors import StorageError as StorageError
    from sweep.errors import SurroundingsWarning as SurroundingsWarning
    from sweep.explorer.explorer import Explorer as Explorer
    from sweep.explorer.explorer import explore as explore
    from sweep.files.netcdf import save as save
    from sweep.files.reading import open_atlas as open_atlas
    from sweep.motion.request import TrajectorySpec as TrajectorySpec
    from sweep.motion.trajectory import simulate as simulate
    from sweep.progress.timetable import Status as Status
    from sweep.request.criterion import Criterion as Criterion
    from sweep.request.sources import Range as Range
    from sweep.request.sources import Values as Values
    from sweep.request.spec import SweepSpec as SweepSpec
    from sweep.runs.in_memory import run as run
    from sweep.runs.run import Failures as Failures
    from sweep.runs.run import run_to_file as run_to_file

# Modules are loaded on first use: reading a request must not wait for numba and xarray.
_HOME = {
    "Comparison": "sweep.checks.compare",
    "Criterion": "sweep.request.criterion",
    "Eulerdisk": "sweep.accessor",
    "Explorer": "sweep.explorer.explorer",
    "Failures": "sweep.runs.run",
    "Findings": "sweep.checks.findings",
    "LeftOutWarning": "sweep.errors",
    "Range": "sweep.request.sources",
    "RequestError": "sweep.errors",
    "Status": "sweep.progress.timetable",
    "StoppedError": "sweep.errors",
    "StorageError": "sweep.errors",
    "SurroundingsWarning": "sweep.errors",
    "SweepSpec": "sweep.request.spec",
    "TrajectorySpec": "sweep.motion.request",
    "Values": "sweep.request.sources",
    "compare": "sweep.checks.compare",
    "explore": "sweep.explorer.explorer",
    "findings": "sweep.checks.verify",
    "open_atlas": "sweep.files.reading",
    "reclassify": "sweep.atlas.reclassify",
    "refine": "sweep.atlas.reclassify",
    "run": "sweep.runs.in_memory",
    "run_to_file": "sweep.runs.run",
    "save": "sweep.files.netcdf",
    "simulate": "sweep.motion.trajectory",
    "verify": "sweep.checks.verify",
}

# Written out for type checkers; docs/api.md describes each name, and how it may change.
__all__ = [
    "Comparison",
    "Criterion",
    "Eulerdisk",
    "Explorer",
    "Failures",
    "Findings",
    "LeftOutWarning",
    "Range",
    "RequestError",
    "Status",
    "StoppedError",
    "StorageError",
    "SurroundingsWarning",
    "SweepSpec",
    "TrajectorySpec",
    "Values",
    "__version__",
    "compare",
    "explore",
    "findings",
    "open_atlas",
    "reclassify",
    "refine",
    "run",
    "run_to_file",
    "save",
    "simulate",
    "verify",
]


# registers dataset.eulerdisk as soon as xarray is imported
when_imported("xarray", lambda: import_module("sweep.accessor"))


if not TYPE_CHECKING:
    # hidden from type checkers, which would otherwise accept any name
    def __getattr__(name: str) -> Any:
        """Import a public name from its module."""
        if name in _HOME:
            # not at import: `sweep.cli` reports the error without a traceback
            import_module("sweep.platforms").check_system()
            return getattr(import_module(_HOME[name]), name)
        raise AttributeError(f"module 'sweep' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
