"""The chunks of a netCDF file in the stored form of HDF5, filtered here and written past the filters of HDF5.

netCDF and HDF5 filter with zlib, in the only thread that may call them: 5 s of processor time for 1e7 cells. Here any
thread can filter with ISA-L, whose streams every zlib can inflate: 1.2 s at level 3 for a file that is 2 % larger
(0.6 s at level 1, 18 % larger), and 0.9 s to inflate it again (zlib: 1.5 s). The stream for the same values may depend
on the version of ISA-L and on the processor's vector instructions.
"""

import contextlib
import errno
import os
import re
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt
from isal import isal_zlib

#: The number of the system error in a message of HDF5.
_NUMBER = re.compile(r"errno = (\d+)")


class RawChunks:
    """The chunks of an existing netCDF file that is not open elsewhere; a context manager.

    Parameters
    ----------
    path : Path

    Raises
    ------
    OSError
        From every method, if HDF5 fails; with the number of the system error if HDF5 reports it.
    """

    def __init__(self, path: Path) -> None:
        # not at the top, so that a request refused before any file is opened does not wait for this import
        import h5py

        with _os_errors():
            self._file = h5py.File(path, "r+")
        self._variables: dict[str, Any] = {}

    def write(self, name: str, offset: tuple[int, ...], content: bytes) -> None:
        """Store the chunk of a variable that begins at `offset` in its grid."""
        with _os_errors():
            if name not in self._variables:
                self._variables[name] = self._file[name].id
            self._variables[name].write_direct_chunk(offset, content)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._variables.clear()
        # after a failed write, closing fails too; report only the first error
        with contextlib.suppress(OSError) if kind else contextlib.nullcontext(), _os_errors():
            self._file.close()


@contextlib.contextmanager
def _os_errors() -> Iterator[None]:
    """Raise the errors of h5py as OSErrors, with the system's message if HDF5 reports the error number."""
    try:
        yield
    except (OSError, RuntimeError, KeyError, ValueError) as problem:
        number = _NUMBER.search(str(problem))
        code = int(number[1]) if number else getattr(problem, "errno", None)
        # the message of HDF5 has several lines with handles, times and addresses
        found = OSError(code, os.strerror(code)) if code else OSError(f"HDF5: {problem}")
        raise found from problem


#: Compression level of ISA-L.
_LEVEL = 3


def packed(values: npt.NDArray[Any], cells: int) -> bytes:
    """Return the stored form of one chunk of a variable: shuffled, then deflated.

    Parameters
    ----------
    values : array, shape (n,)
        The values of the chunk in C order; fewer than `cells` at the edge of a grid.
    cells : int
        Number of values in a whole chunk. HDF5 stores only whole chunks; values outside the grid are zeros.

    Raises
    ------
    OSError
        If inflating the stored form does not give the original bytes.
    """
    content = _shuffled(values, cells)
    stored: bytes = isal_zlib.compress(content, _LEVEL)
    if not np.array_equal(
        np.frombuffer(isal_zlib.decompress(stored, bufsize=content.size), np.uint8), content
    ):
        raise OSError(errno.EIO, "a compressed chunk does not inflate to the original bytes; test the memory")
    return stored


def _shuffled(values: npt.NDArray[Any], cells: int) -> npt.NDArray[np.uint8]:
    """Return the first bytes of all values, then the second bytes, and so on, as HDF5's filter `shuffle`."""
    whole = values
    if values.size < cells:
        whole = np.zeros(cells, values.dtype)
        whole[: values.size] = values
    # types of one byte stay unchanged, as in HDF5
    return np.ascontiguousarray(whole.view(np.uint8).reshape(cells, -1).T).reshape(-1)
