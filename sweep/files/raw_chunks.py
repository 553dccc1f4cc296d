"""The stored chunks of a netCDF file, written and read as they are, past the filters of HDF5."""

import contextlib
import os
import re
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

#: Where HDF5 tells the error of the system in its message.
_NUMBER = re.compile(r"errno = (\d+)")


class RawChunks:
    """The chunks of the variables of a netCDF file that is there and nowhere else open; a context manager.

    Parameters
    ----------
    path : Path
    mode : {"r", "r+"}
        To read, or to write too.

    Raises
    ------
    OSError
        From every method: if HDF5 refuses; with the number of the system's error where HDF5 tells it.
    """

    def __init__(self, path: Path, mode: Literal["r", "r+"]) -> None:
        # not at the top: a request that is refused before any file is opened need not wait for this import
        import h5py

        with _os_errors():
            self._file = h5py.File(path, mode)
        self._path = path
        self._variables: dict[str, Any] = {}

    def write(self, name: str, offset: tuple[int, ...], content: bytes) -> None:
        """Store the chunk of a variable that begins at some place of its grid."""
        with _os_errors():
            self._identifier(name).write_direct_chunk(offset, content)

    def stored(self, name: str) -> Iterator[bytes]:
        """Yield the stored form of each chunk of a variable that passed all filters, in C order.

        The bytes are read from the file itself, wherever its index says that they are.
        """
        # one walk through the index: to look one chunk up by its place HDF5 walks through the index from its begin, and
        # to read one that is not there it asks for endless memory
        index: list[Any] = []
        with _os_errors():
            self._identifier(name).chunk_iter(index.append)
        with open(self._path, "rb") as file:
            for chunk in index:
                if not chunk.filter_mask:
                    yield os.pread(file.fileno(), chunk.size, chunk.byte_offset)

    def _identifier(self, name: str) -> Any:
        if name not in self._variables:
            self._variables[name] = self._file[name].id
        return self._variables[name]

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
