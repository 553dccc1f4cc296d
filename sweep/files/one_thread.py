"""One thread at a time calls netCDF: neither it nor HDF5 is safe to call in two, and a crash ends the process."""

import contextlib
import sys
import threading
from collections.abc import Iterator

_OWN = threading.Lock()


@contextlib.contextmanager
def netcdf_to_itself(*, by_xarray: bool = False) -> Iterator[None]:
    """Call netCDF alone.

    xarray has a lock for most of its own calls. It also heeds it when it closes a file that nothing refers to any more,
    in whatever thread Python collects garbage: a notebook has several, and so has a server.

    Parameters
    ----------
    by_xarray : bool
        Whether it is xarray that calls: it takes its lock itself.
    """
    with _OWN:
        # not imported here: a run does not need xarray otherwise, and would wait for it half a second
        xarray = None if by_xarray else sys.modules.get("xarray.backends.netCDF4_")
        with contextlib.nullcontext() if xarray is None else xarray.NETCDF4_PYTHON_LOCK:
            yield
