"""Files that appear whole: created under a name that cannot be guessed, synchronised, and renamed.

Nothing else in `sweep` opens a file for writing, renames one or replaces one. What is opened here is always a new file:
a name that is taken is an error, and so is a symbolic link, which somebody else may have put there.
"""

import contextlib
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

#: Name of a temporary file or folder; no other program makes one that fits.
TEMPORARY = re.compile(r"\.eulerdisk-[0-9a-f]{16}\.tmp")

#: Bytes of a name that all file systems take.
_LONGEST_NAME = 255


def create(path: Path, mode: int = 0o666) -> int:
    """Create a file and return its handle; FileExistsError if the name is taken, by a symbolic link too."""
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, mode)


def open_or_create(path: Path) -> int:
    """Return the handle of a file that may be there; an OSError says that it is a symbolic link."""
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)


def create_temporary(folder: Path, mode: int = 0o666) -> Path:
    """Create an empty file in a folder, for a library that writes to a name, and return its path."""
    path = folder / _temporary_name()
    os.close(create(path, mode))
    return path


def create_temporary_folder(folder: Path) -> Path:
    """Create an empty folder in a folder and return its path."""
    path = folder / _temporary_name()
    path.mkdir()
    return path


@contextlib.contextmanager
def scratch_folder(folder: Path) -> Iterator[Path]:
    """Yield an empty folder in a folder, for files that are read at once; it is removed with all that it holds."""
    path = create_temporary_folder(folder)
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)


def publish(unfinished: Path, path: Path) -> None:
    """Rename a finished temporary file to its final name, such that a power cut leaves the old state or the new one."""
    handle = os.open(unfinished, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
    os.replace(unfinished, path)
    sync_folder(path.parent)


def publish_bytes(path: Path, content: bytes, mode: int = 0o666) -> None:
    """Write a file that is either absent or complete, also after a power cut; if that fails no temporary file stays."""
    # not the tempfile module: only the owner can read its files, and another account of the same group may have to go
    # on with a run
    unfinished = create_temporary(path.parent, mode)
    try:
        with open(unfinished, "rb+") as file:
            file.write(content)
        publish(unfinished, path)
    finally:
        unfinished.unlink(missing_ok=True)


def publish_folder(unfinished: Path, path: Path) -> None:
    """Rename a finished temporary folder to its final name, and remove the folder that had the name."""
    if os.path.lexists(path):
        before = path.with_name(_temporary_name())
        os.rename(path, before)
        os.replace(unfinished, path)
        if before.is_symlink():
            before.unlink()
        else:
            shutil.rmtree(before)
    else:
        os.replace(unfinished, path)
    sync_folder(path.parent)


def rename_aside(path: Path, ending: str) -> None:
    """Append an ending to the name of a file, which is kept for a person to look at."""
    path.rename(path.with_name(path.name + ending))


def try_publishing(path: Path, source: Path | None = None) -> None:
    """Create an empty file, rename it as `publish` would, and remove it; an OSError says what the file system refuses.

    The trial has a name of its own beside `path`, with the characters and the length of that of `path` as far as there
    is room for them. The file is created in the folder `source`, or in that of `path`.
    """
    begun = create_temporary(source or path.parent)
    name = os.fsencode(path.name)
    mark = os.fsencode(_temporary_name()) + b"-"
    trial = path.with_name(os.fsdecode(mark + name[max(0, len(mark) + len(name) - _LONGEST_NAME) :]))
    try:
        os.rename(begun, trial)
    finally:
        for left in (begun, trial):
            with contextlib.suppress(OSError):
                left.unlink()


def sync_folder(folder: Path) -> None:
    """Write the names in a folder to the disk, on file systems that can do so."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _temporary_name() -> str:
    return f".eulerdisk-{secrets.token_hex(8)}.tmp"
