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
    _check(os.stat(path), most)
    # without waiting: the name may have become that of a pipe since
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        _check(os.fstat(file.fileno()), most)
        # what /proc shows as empty may have content
        content = file.read(most + 1)
    if len(content) > most:
        raise _too_large(len(content), most)
    return content


def _check(found: os.stat_result, most: int) -> None:
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "It is not a regular file")
    if found.st_size > most:
        raise _too_large(found.st_size, most)


def _too_large(size: int, most: int) -> OSError:
    return OSError(errno.EFBIG, f"It has {size} bytes or more, of at most {most}")
