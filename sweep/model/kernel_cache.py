"""The files that keep compiled functions: checked before they are loaded, and compiled again where they are damaged.

What is loaded is machine code, so whoever can write such a file decides what runs here. A folder or file
that others can write is not used. Numba's own cache has neither check: a damaged file of it ends the process.
"""

import hashlib
import json
import os
import re
import stat
import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from sweep.atomic import publish_bytes
from sweep.errors import SurroundingsWarning
from sweep.platforms import check_numba, host_features, processor

#: The form in which kernels are loaded.
_MACHINE_CODE = "kernels.native.machine_code"

#: End of the name of a file, and how many bytes at its begin are the checksum of the rest.
ENDING, _CHECKSUM_BYTES = ".nbc", 32


#: Settings of Numba that change the code it makes.
_SETTINGS = (
    "CPU_NAME",
    "CPU_FEATURES",
    "ENABLE_AVX",
    "OPT",
    "LOOP_VECTORIZE",
    "SLP_VECTORIZE",
    "BOUNDSCHECK",
)


class KernelCache:
    """The machine code of entry points on disk, one file each.

    Parameters
    ----------
    folder : Path or None
        Where the files are, see `usable_folder`; None if nothing can be kept.
    width : callable, optional
        Returns the width of vectors [bits] that is preferred, 0 if LLVM chooses. Called when it is needed.
    announce : callable, optional
        Called before a function is compiled.
    """

    def __init__(
        self,
        folder: Path | None,
        width: Callable[[], int] = lambda: 0,
        announce: Callable[[], object] = lambda: None,
    ) -> None:
        self._folder, self._width, self._announce = folder, width, announce

    def machine_code(self, entry: Any) -> Any:
        """Return the `kernels.native.machine_code.MachineCode` of an entry point, kept or compiled."""
        width = self._width()
        key = _key(entry, width)
        found = self._kept(entry, key)
        if found is None:
            self._announce()
            found = _compiled(entry, width)
            self._keep(entry, key, found)
        return found

    def holds(self, entry: Any) -> bool:
        """Whether the machine code of an entry point is kept, whole, and can be loaded."""
        return self._kept(entry, _key(entry, self._width())) is not None

    def _kept(self, entry: Any, key: str) -> Any:
        """Return the machine code that is kept, None if there is none that is whole and can be loaded."""
        if self._folder is None:
            return None
        content = read_own(self._path(entry, key))
        payload = content[_CHECKSUM_BYTES:]
        if content[:_CHECKSUM_BYTES] != _checksum(key, payload):
            return None
        head, _, code = payload.partition(b"\n")
        name, results, needed = json.loads(head)
        found = import_module(_MACHINE_CODE).MachineCode(name, tuple(results), tuple(needed), code)
        return found if found.is_lasting() else None

    def _keep(self, entry: Any, key: str, found: Any) -> None:
        """Keep machine code, if it can be kept; a file system that refuses costs the next compilation."""
        if self._folder is None or not found.is_lasting():
            return
        payload = json.dumps([found.name, found.results, found.needed]).encode() + b"\n" + found.code
        try:
            # not by the umask alone: see `usable_folder`
            publish_bytes(self._path(entry, key), _checksum(key, payload) + payload, mode=0o644)
        except OSError as problem:
            warnings.warn(
                f"A compiled kernel could not be kept in {self._folder}, and will be compiled again: {problem}. Set "
                "EULERDISK_CACHE_DIR to a folder that can be written.",
                SurroundingsWarning,
                stacklevel=2,
            )

    def _path(self, entry: Any, key: str) -> Path:
        assert self._folder is not None
        digest = hashlib.sha256(key.encode()).hexdigest()[:24]
        name = re.sub(r"\W+", "_", entry.__qualname__)
        return self._folder / f"{name}-{digest}{ENDING}"


def _key(entry: Any, width: int) -> str:
    """Return what machine code depends on beside the folder: function, types, processor, settings, width of vectors."""
    from llvmlite import binding

    types = " ".join(f"{each.name}:{each.element}{each.dimensions}" for each in entry.arguments)
    settings = (f"{name}={os.environ.get(f'NUMBA_{name}')}" for name in _SETTINGS)
    target = binding.get_process_triple(), processor(), str(sorted(host_features().items()))
    return "\0".join([entry.__module__, entry.__qualname__, types, *target, *settings, str(width)])


def _compiled(entry: Any, width: int) -> Any:
    check_numba()
    with import_module("kernels.native.pipeline").preferring(width):
        return entry.compiled()


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
            SurroundingsWarning,
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
