"""Files that appear complete or not at all: created with an unguessable name, synced, and renamed.

No other module of `sweep` opens a file for writing, renames or replaces one. An existing name
is an error, except in `open_or_create`. Symbolic links are always refused, because somebody else may have planted them.
"""

import contextlib
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from pathlib import Path

#: Name of a temporary file or folder; no other program makes such names.
TEMPORARY = re.compile(r"\.eulerdisk-[0-9a-f]{16}\.tmp")

#: Length of the longest name that all file systems accept [bytes].
_LONGEST_NAME = 255


def create(path: Path, mode: int = 0o666) -> int:
    """Create a file and return its handle; FileExistsError if the name exists, even as a symbolic link."""
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, mode)


def open_or_create(path: Path) -> int:
    """Return the handle of a file, created if missing; OSError if it is a symbolic link."""
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)


def create_temporary(folder: Path, mode: int = 0o666) -> Path:
    """Create an empty file in a folder, for a library that writes to a path, and return its path."""
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
    """Yield an empty folder in a folder, for short-lived files; remove it with its contents at the end."""
    path = create_temporary_folder(folder)
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)


def publish(unfinished: Path, path: Path) -> None:
    """Rename a finished temporary file to its final name; after a power cut, the old or the new file exists."""
    handle = os.open(unfinished, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
    os.replace(unfinished, path)
    sync_folder(path.parent)


def publish_bytes(path: Path, content: bytes, mode: int = 0o666) -> None:
    """Write a file so that it is complete or absent even after a power cut; remove the temporary file on failure."""
    # not the tempfile module: only the owner can read its files, but another account of the same group may resume a run
    unfinished = create_temporary(path.parent, mode)
    try:
        with open(unfinished, "rb+") as file:
            file.write(content)
        publish(unfinished, path)
    finally:
        unfinished.unlink(missing_ok=True)


def publish_folder(unfinished: Path, path: Path) -> None:
    """Rename a finished temporary folder to its final name, and remove the folder that had this name."""
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
    """Append an ending to the name of a file, so that a person can inspect it later."""
    path.rename(path.with_name(path.name + ending))


def try_publishing(path: Path, source: Path | None = None) -> None:
    """Create an empty file, rename it as `publish` would, and remove it; OSError if the file system refuses.

    The trial file lies next to `path`. Its name contains the name of `path`, cut to the longest allowed length. The
    file is created in the folder `source`, or in the folder of `path`.
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
    """Sync the names in a folder to the disk, on file systems that support it."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _temporary_name() -> str:
    return f".eulerdisk-{secrets.token_hex(8)}.tmp"
