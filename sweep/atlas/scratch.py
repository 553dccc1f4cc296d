"""Numbers that may be too many for memory: appended to a file without a name, and read again in parts."""

import contextlib
import errno
import os
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from sweep.atomic import open_scratch

#: Bytes of a column up to which it needs no file, and which a longer one gathers before it writes them.
_MOST_HELD = 2**21


class Scratch:
    """A place for columns; what they hold on disk is gone when it is closed.

    Parameters
    ----------
    folder : Path, optional
        Where the files are; the system's folder for temporary files (``$TMPDIR``) if not given.

    Attributes
    ----------
    folder : Path or None
        Where they are; None as long as there is none and none was given.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder, self._files = folder, contextlib.ExitStack()

    def column(self, dtype: str) -> "Column":
        """Return a new column of a type."""
        return Column(self, dtype)

    def open_file(self) -> int:
        """Return the handle of a new file, which is closed with the others."""
        if self.folder is None:
            # not at the top: hardly any boundary needs it
            import tempfile

            try:
                self.folder = Path(tempfile.gettempdir())
            except FileNotFoundError as problem:
                # where no folder takes a file: also if all disks are full
                raise OSError(errno.EACCES, problem.strerror) from problem
        return self._files.enter_context(open_scratch(self.folder)).fileno()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, where: TracebackType | None
    ) -> None:
        self._files.close()


class Column:
    """Numbers of one type in the order in which they were appended; see `Scratch.column`.

    Its methods raise OSError if the file system refuses.
    """

    def __init__(self, scratch: Scratch, dtype: str) -> None:
        self._scratch, self._dtype = scratch, np.dtype(dtype)
        self._held, self._written, self._file = bytearray(), 0, -1

    def __len__(self) -> int:
        """Return how many numbers it has."""
        return (self._written + len(self._held)) // self._dtype.itemsize

    def append(self, values: npt.NDArray[Any]) -> None:
        """Add numbers at the end."""
        self._held += values.astype(self._dtype, copy=False).tobytes()
        if len(self._held) > _MOST_HELD:
            if self._file < 0:
                self._file = self._scratch.open_file()
            self._put(self._written, self._held)
            self._written += len(self._held)
            self._held.clear()

    def content(self, start: int, stop: int) -> bytes:
        """Return the bytes of some numbers, or of as many as there are."""
        begin, end = start * self._dtype.itemsize, stop * self._dtype.itemsize
        if begin >= self._written:
            return bytes(self._held[begin - self._written : end - self._written])
        if end > self._written:
            return self._stored(begin, self._written) + self._held[: end - self._written]
        return self._stored(begin, end)

    def _stored(self, begin: int, end: int) -> bytes:
        found = os.pread(self._file, end - begin, begin)
        while len(found) < end - begin:
            part = os.pread(self._file, end - begin - len(found), begin + len(found))
            if not part:
                raise OSError(errno.EIO, "a temporary file has become shorter")
            found += part
        return found

    def read(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Return some numbers, or as many of them as there are."""
        return np.frombuffer(self.content(start, stop), self._dtype)

    def replace(self, start: int, content: bytes | bytearray) -> None:
        """Put other bytes in the place of some that are there."""
        begin = start * self._dtype.itemsize
        there = max(min(len(content), self._written - begin), 0)
        self._put(begin, content[:there])
        at = begin + there - self._written
        if there < len(content):
            self._held[at : at + len(content) - there] = content[there:]

    def _put(self, begin: int, content: bytes | bytearray) -> None:
        done = 0
        while done < len(content):
            try:
                done += os.pwrite(self._file, memoryview(content)[done:], begin + done)
            except OSError as problem:
                # the system names no file that has no name, and the disk may be another than that of the atlas
                raise OSError(problem.errno, problem.strerror, str(self._scratch.folder)) from problem
