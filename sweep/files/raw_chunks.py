"""The chunks of a netCDF file as HDF5 stores them, filtered here and written past the filters of HDF5.

netCDF and HDF5 filter in the one thread that may call them, with zlib: 5 s of processor time for 1e7 cells. Here any
thread filters, with ISA-L, whose streams every zlib inflates: 1.2 s at level 3 for a file that is 2 % larger (0.6 s at
level 1, 18 % larger), and 0.9 s to inflate it again (zlib: 1.5 s). Of equal values ISA-L may make other streams with
another version, or on a processor with other vectors.
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

#: Where HDF5 tells the error of the system in its message.
_NUMBER = re.compile(r"errno = (\d+)")


class RawChunks:
    """The chunks of the variables of a netCDF file that is there and nowhere else open; a context manager.

    Parameters
    ----------
    path : Path

    Raises
    ------
    OSError
        From every method: if HDF5 refuses; with the number of the system's error where HDF5 tells it.
    """

    def __init__(self, path: Path) -> None:
        # not at the top: a request that is refused before any file is opened need not wait for this import
        import h5py

        with _os_errors():
            self._file = h5py.File(path, "r+")
        self._variables: dict[str, Any] = {}

    def write(self, name: str, offset: tuple[int, ...], content: bytes) -> None:
        """Store the chunk of a variable that begins at some place of its grid."""
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
        # after a refused write closing fails too, and the first error is the one to tell
        with contextlib.suppress(OSError) if kind else contextlib.nullcontext(), _os_errors():
            self._file.close()


@contextlib.contextmanager
def _os_errors() -> Iterator[None]:
    """Raise the errors of h5py as OSErrors: in the words of the system where HDF5 tells the number of its error."""
    try:
        yield
    except (OSError, RuntimeError, KeyError, ValueError) as problem:
        number = _NUMBER.search(str(problem))
        code = int(number[1]) if number else getattr(problem, "errno", None)
        # the text of HDF5 names handles, times and addresses, over several lines
        found = OSError(code, os.strerror(code)) if code else OSError(f"HDF5: {problem}")
        raise found from problem


#: ISA-L's level of compression.
_LEVEL = 3


def packed(values: npt.NDArray[Any], cells: int) -> bytes:
    """Return the stored form of one chunk of a variable: shuffled, then deflated.

    Parameters
    ----------
    values : array, shape (n,)
        The values of the chunk in C order; at the edge of a grid fewer than the chunk has.
    cells : int
        Values of a whole chunk. HDF5 stores every chunk whole; the values that no cell has are zeros.

    Raises
    ------
    OSError
        If the stored form does not inflate to what was deflated.
    """
    content = _shuffled(values, cells)
    stored: bytes = isal_zlib.compress(content, _LEVEL)
    if not np.array_equal(
        np.frombuffer(isal_zlib.decompress(stored, bufsize=content.size), np.uint8), content
    ):
        raise OSError(errno.EIO, "a chunk does not inflate to what was deflated; test the memory")
    return stored


def _shuffled(values: npt.NDArray[Any], cells: int) -> npt.NDArray[np.uint8]:
    """Return the first bytes of all values, then all second bytes, and so on: HDF5's filter `shuffle`."""
    whole = values
    if values.size < cells:
        whole = np.zeros(cells, values.dtype)
        whole[: values.size] = values
    # types of one byte have nothing to shuffle: HDF5 leaves them as they are, and so does this
    return np.ascontiguousarray(whole.view(np.uint8).reshape(cells, -1).T).reshape(-1)
