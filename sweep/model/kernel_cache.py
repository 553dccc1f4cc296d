"""The files that keep compiled functions: checked before they are loaded, and compiled again where they are damaged.

What is loaded is a pickle with machine code, so whoever can write such a file decides what runs here. A folder or file
that others can write is not used. Numba's own cache has neither check: a damaged file of it ends the process.
"""

import hashlib
import os
import pickle
import re
import stat
import warnings
from pathlib import Path
from typing import Any

from sweep.atomic import publish_bytes

#: End of the name of a file, and how many bytes at its begin are the checksum of the rest.
ENDING, _CHECKSUM_BYTES = ".nbc", 32


class KernelCache:
    """The compiled forms of one function on disk, one file each; has the methods that a dispatcher of Numba calls.

    Parameters
    ----------
    function : function
        The Python function that is compiled.
    folder : Path
        Where the files are; see `usable_folder`.
    width : int
        Width of vectors [bits] that the function is compiled with, 0 if LLVM chooses.
    """

    def __init__(self, function: Any, folder: Path, width: int = 0) -> None:
        self._function, self._folder, self._width = function, folder, width

    @property
    def cache_path(self) -> str:
        """The folder of the files."""
        return str(self._folder)

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the compiled form for a signature and a target; None if there is none that is whole."""
        from numba.core.compiler import CompileResult

        target.refresh()
        key = self._key(signature, target.codegen())
        content = read_own(self._path(key))
        payload = content[_CHECKSUM_BYTES:]
        if content[:_CHECKSUM_BYTES] != _checksum(key, payload):
            return None
        return CompileResult._rebuild(target, *pickle.loads(payload))

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep a compiled form, if it can be kept; a file system that refuses costs the next compilation."""
        from numba.core.serialize import dumps

        if compiled.library.has_dynamic_globals or any(not each.can_cache for each in compiled.lifted):
            return
        key, payload = self._key(signature, compiled.codegen), dumps(compiled._reduce())
        try:
            # not by the umask alone: see `usable_folder`
            publish_bytes(self._path(key), _checksum(key, payload) + payload, mode=0o644)
        except OSError as problem:
            warnings.warn(
                f"A compiled kernel could not be kept in {self._folder}, and will be compiled again: {problem}. Set "
                "EULERDISK_CACHE_DIR to a folder that can be written.",
                RuntimeWarning,
                stacklevel=2,
            )

    def flush(self) -> None:
        """Forget nothing: a compiled form is kept under all that it depends on."""

    def _key(self, signature: Any, codegen: Any) -> str:
        """Return what a compiled form depends on beside the folder: types, target, width, bytecode."""
        code = self._function.__code__
        place = f"{self._function.__module__}.{self._function.__qualname__}:{code.co_firstlineno}"
        return "\0".join(
            [place, str(signature), *map(str, codegen.magic_tuple()), str(self._width), code.co_code.hex()]
        )

    def _path(self, key: str) -> Path:
        digest = hashlib.sha256(key.encode()).hexdigest()[:24]
        name = re.sub(r"\W+", "_", self._function.__qualname__)
        return self._folder / f"{name}-{digest}{ENDING}"


def usable_folder(root: Path, name: str) -> Path | None:
    """Return the folder `name` in the folder of all caches, made if it is not there; None if it must not be used.

    A warning says why others could write what would be executed here. A folder that cannot be made costs the
    compilation of this process, and nothing else.
    """
    folder = root / name
    try:
        root.parent.mkdir(parents=True, exist_ok=True)
        for each in (root, folder):
            # not by the umask alone: under 002, usual where each user has a group, every folder could be written by it
            each.mkdir(mode=0o755, exist_ok=True)
        # the root first: what is wrong with it is told once, not for every kernel
        place, problem = root, _problem(os.stat(root), sticky_is_safe=True)
        if not problem:
            place, problem = folder, _problem(os.lstat(folder))
    except OSError:
        return None
    if problem:
        warnings.warn(
            f"The cache of compiled kernels is not used, because it {problem}, and what is in it would be executed: "
            f"{place}. The kernels are compiled anew by each process. Run `chmod -R go-w` on a folder of your own, or "
            "set EULERDISK_CACHE_DIR to another one.",
            RuntimeWarning,
            stacklevel=2,
        )
        return None
    return folder if os.access(folder, os.W_OK | os.X_OK) or any(folder.glob(f"*{ENDING}")) else None


def _problem(status: os.stat_result, *, sticky_is_safe: bool = False) -> str:
    """Return who else could write a folder or file, as the end of a sentence; empty if nobody but this user and root.

    In a folder with the sticky bit, as ``/tmp`` has it, others can make files and not replace those of this user.
    """
    if status.st_uid not in (0, os.geteuid()):
        return f"belongs to another user (uid {status.st_uid})"
    sticky = sticky_is_safe and status.st_mode & stat.S_ISVTX
    return (
        f"can be written by others (mode {stat.S_IMODE(status.st_mode):o})"
        if status.st_mode & 0o022 and not sticky
        else ""
    )


def read_own(path: Path) -> bytes:
    """Return the content of a file that nobody else can write; empty if it is not there, or another thing."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError:
        return b""
    try:
        status = os.fstat(handle)
        if not stat.S_ISREG(status.st_mode) or _problem(status):
            return b""
        with open(handle, "rb", closefd=False) as file:
            return file.read()
    except OSError:
        return b""
    finally:
        os.close(handle)


def _checksum(key: str, payload: bytes) -> bytes:
    return hashlib.sha256(hashlib.sha256(key.encode()).digest() + payload).digest()
