"""Small files that a request or a run consists of: read whole, and only if they are files and not too large."""

import errno
import os
import stat
from pathlib import Path


def read_regular(path: Path, most: int) -> bytes:
    """Return the content of a regular file.

    Parameters
    ----------
    path : Path
    most : int
        Bytes that such a file may have. A pipe would be waited for without end, and a device read without end.

    Raises
    ------
    OSError
        If it cannot be read, is no regular file, or has more bytes; `strerror` says which.
    """
    # without waiting: it may be a pipe to which no process writes
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        found = os.fstat(descriptor)
        if stat.S_ISDIR(found.st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "It is not a regular file")
        size, content = found.st_size, b""
        if size <= most:
            with open(descriptor, "rb", closefd=False) as file:
                # what /proc shows as empty may have content
                content = file.read(most + 1)
        if max(size, len(content)) > most:
            raise OSError(errno.EFBIG, f"It has {max(size, len(content))} bytes or more, of at most {most}")
        return content
    finally:
        os.close(descriptor)
