"""A lock for netCDF: neither netCDF nor HDF5 is thread-safe, and a crash ends the process."""

import contextlib
import sys
import threading
from collections.abc import Iterator

_OWN = threading.Lock()


@contextlib.contextmanager
def netcdf_to_itself(*, by_xarray: bool = False) -> Iterator[None]:
    """Hold the lock of netCDF, so that no other thread calls it.

    xarray has its own lock for most of its calls. It also takes that lock when garbage collection closes a file, which
    may happen in any thread of a notebook or a server.

    Parameters
    ----------
    by_xarray : bool
        Whether xarray makes the calls; it takes its own lock itself.
    """
    with _OWN:
        # not imported here: a run does not need xarray, whose import takes half a second
        xarray = None if by_xarray else sys.modules.get("xarray.backends.netCDF4_")
        with contextlib.nullcontext() if xarray is None else xarray.NETCDF4_PYTHON_LOCK:
            yield
