"""The cache files of compiled kernels and of WebAssembly modules: checked before use, made again if damaged.

These files contain machine code, so anyone who can write them can run code here. A file that others can write is not
used. Numba's own cache has neither check: a damaged file in it crashes the process.
"""

import fcntl
import hashlib
import json
import os
import re
import stat
from contextlib import contextmanager, nullcontext, suppress

from kernels.native.machine_code import MachineCode, vector_bits

#: End of a file name, and length of the checksum at the beginning of a file.
ENDING, _CHECKSUM_BYTES = ".nbc", 32

#: Settings of Numba that change its code.
_SETTINGS = (
    "CPU_NAME",
    "CPU_FEATURES",
    "ENABLE_AVX",
    "OPT",
    "LOOP_VECTORIZE",
    "SLP_VECTORIZE",
    "BOUNDSCHECK",
)


#: One entry during each compilation, because compilers never check for signals.
compiling = []


class KernelCache:
    """The machine code of entry points on disk, one file each.

    Parameters
    ----------
    folder : Path or None
        Folder of the files; None disables the cache.
    publish : callable
        Called with the path of a file and its content, to write it.
    announce : callable
        Called before a function is compiled.
    """

    def __init__(self, folder, publish, announce):
        self._folder, self._publish, self._announce = folder, publish, announce

    def machine_code(self, entry):
        """Return the `MachineCode` of a `kernels.native.entry.Entry`, from the cache or compiled."""
        made = []

        def compiled():
            made.append(entry.compiled())
            (found,) = made
            head = json.dumps([found.name, found.results, found.needed]).encode()
            return head + b"\n" + found.code if found.is_lasting() else b""

        payload = self.bytes_of(entry.__qualname__, _key(entry), compiled, _is_lasting)
        return made[0] if made else _machine_code(payload)

    def bytes_of(self, name, key, make, is_usable=bool):
        """Return bytes, from the cache or made.

        Parameters
        ----------
        name : str
            Beginning of the file name.
        key : str
            Everything that the bytes depend on besides the folder.
        make : callable
            Makes the bytes; empty bytes are not stored.
        is_usable : callable, optional
            Called with cached bytes; returns whether they can be used here.
        """
        path = None
        if self._folder is not None:
            told, digest = re.sub(r"\W+", "_", name), hashlib.sha256(key.encode()).hexdigest()
            path = self._folder / f"{told}-{digest[:24]}{ENDING}"
        found = _kept(path, key) if path else b""
        if not found or not is_usable(found):
            self._announce()
            # processes that start together, such as tests or jobs of an array, would otherwise each compile the same
            with _one_at_a_time(path) if path else nullcontext():
                found = _kept(path, key) if path else b""
                if not found or not is_usable(found):
                    compiling.append(name)
                    try:
                        found = make()
                    finally:
                        compiling.remove(name)
                    if path and found:
                        self._publish(path, _checksum(key, found) + found)
        return found


@contextmanager
def _one_at_a_time(path):
    """Wait while another process makes this file; a killed process releases its lock, without locks nobody waits."""
    lock = path.with_suffix(".lock")
    try:
        handle = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o644)
    except OSError:
        yield
        return
    try:
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        lock.unlink(missing_ok=True)
        os.close(handle)


def _kept(path, key):
    """Return the bytes stored in a file; empty if it is damaged."""
    content = _read_own(path)
    payload = content[_CHECKSUM_BYTES:]
    return payload if content[:_CHECKSUM_BYTES] == _checksum(key, payload) else b""


def _machine_code(payload):
    """Return the `MachineCode` stored by `KernelCache.machine_code`."""
    head, _, code = payload.partition(b"\n")
    name, results, needed = json.loads(head)
    return MachineCode(name, tuple(results), tuple(needed), code)


def _is_lasting(payload):
    return _machine_code(payload).is_lasting()


def _key(entry):
    """Return everything that machine code depends on: function, types, processor, settings, width of vectors."""
    from llvmlite import binding

    types = " ".join(f"{each.name}:{each.element}{each.dimensions}" for each in entry.arguments)
    settings = (f"{name}={os.environ.get(f'NUMBA_{name}')}" for name in _SETTINGS)
    target, features = (binding.get_process_triple(), binding.get_host_cpu_name()), ""
    # LLVM may not know the processor
    with suppress(RuntimeError):
        features = binding.get_host_cpu_features().flatten()
    return "\0".join(
        [entry.__module__, entry.__qualname__, types, *target, features, *settings, str(vector_bits())]
    )


def problem_of(status, *, sticky_is_safe=False):
    """Return who else could write a folder or file, as the end of a sentence; empty if only this user and root can.

    In a folder with the sticky bit, such as ``/tmp``, others can create files but not replace the files of this user.

    Parameters
    ----------
    status : os.stat_result
    sticky_is_safe : bool
    """
    if status.st_uid not in (0, os.geteuid()):
        return f"belongs to another user (uid {status.st_uid})"
    sticky = sticky_is_safe and status.st_mode & stat.S_ISVTX
    return (
        f"can be written by others (mode {stat.S_IMODE(status.st_mode):o})"
        if status.st_mode & 0o022 and not sticky
        else ""
    )


def _read_own(path):
    """Return the content of a file that no other user can write; empty if it is missing or not a regular file."""

    def opened(name, flags):
        return os.open(name, flags | os.O_NOFOLLOW | os.O_NONBLOCK)

    try:
        with open(path, "rb", opener=opened) as file:
            status = os.fstat(file.fileno())
            return file.read() if stat.S_ISREG(status.st_mode) and not problem_of(status) else b""
    except OSError:
        return b""


def _checksum(key, payload):
    return hashlib.sha256(hashlib.sha256(key.encode()).digest() + payload).digest()
