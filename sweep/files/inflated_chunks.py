"""Chunks of an atlas's file, inflated without netCDF: half the time, and other threads go on meanwhile.

A variable is read so only if its file stores it as this program writes it: shuffled and deflated, in given chunks.
Any other variable, and any chunk that cannot be read so, is left to netCDF, which says what is wrong with it.
"""

from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

#: HDF5's numbers of its filters, in the order in which netCDF applies them.
_SHUFFLE, _DEFLATE = 2, 1

#: Bytes by which the stored form of a chunk may be larger than its values, which deflate cannot pack.
_MOST_ADDED = 2**16


class InflatedChunks:
    """A file that is read chunk by chunk; a context manager.

    Parameters
    ----------
    path : Path
        A netCDF-4 file. It may be open in netCDF4 at the same time, for reading.
    """

    def __init__(self, path: Path) -> None:
        import h5py
        from xarray.backends.locks import HDF5_LOCK

        # where h5py and netCDF4 share one HDF5, only one thread may be in it at a time
        self._lock = HDF5_LOCK
        with self._lock:
            self._file = h5py.File(path, "r")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._lock:
            self._file.close()

    def fits(self, name: str, chunk: tuple[int, ...], dtype: npt.DTypeLike) -> bool:
        """Return whether a variable is stored in such chunks, of such a type, shuffled and deflated."""
        try:
            with self._lock:
                variable: Any = self._file[name]
                plan = variable.id.get_create_plist()
                filters = [plan.get_filter(number)[0] for number in range(plan.get_nfilters())]
                given = variable.chunks == chunk and variable.dtype == dtype
        except Exception:
            # only the library works here, and of a damaged file it raises all kinds of errors
            return False
        return given and (
            filters == [_SHUFFLE, _DEFLATE] or (filters == [_DEFLATE] and np.dtype(dtype).itemsize == 1)
        )

    def read(self, name: str, place: tuple[int, ...], out: npt.NDArray[Any]) -> bool:
        """Write the values of a whole chunk, as they are stored, to an array; return whether that could be done.

        Parameters
        ----------
        name : str
            A variable that `fits`.
        place : tuple of int
            Indices of the first cell of the chunk.
        out : array, shape (cells of a chunk,), written
            Contiguous, of the type of the variable.
        """
        from isal import isal_zlib

        try:
            with self._lock:
                stored = self._file[name].id
                # of a chunk that is not there, or in a damaged file, HDF5 may ask for endless memory
                found = stored.get_chunk_info_by_coord(place)
                if found.byte_offset is None or found.filter_mask or found.size > out.nbytes + _MOST_ADDED:
                    return False
                packed = stored.read_direct_chunk(place)[1]
            raw = isal_zlib.decompress(packed, bufsize=out.nbytes)
        except Exception:
            return False
        if len(raw) != out.nbytes:
            return False
        # shuffled: the first bytes of all values, then the second ones, and so on
        values = out.view(np.uint8).reshape(out.size, out.itemsize)
        # two thirds of the time of a transposed copy
        for number, each in enumerate(np.frombuffer(raw, np.uint8).reshape(out.itemsize, out.size)):
            values[:, number] = each
        return True
