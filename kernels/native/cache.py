"""The files that keep compiled kernels and modules of pages: checked before they are loaded, made again if not whole.

Who can write such a file decides what runs here, as what is loaded is machine code: a file that others can write is not
used. Numba's own cache has neither check: a damaged file of it ends the process.
"""

import fcntl
import hashlib
import json
import os
import re
import stat
from contextlib import contextmanager, nullcontext, suppress

from kernels.native.machine_code import MachineCode, vector_bits

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


#: One entry while something is compiled: compilers never ask for signals.
compiling = []


class KernelCache:
    """The machine code of entry points on disk, one file each.

    Parameters
    ----------
    folder : Path or None
        Where the files are; None if nothing can be kept.
    publish : callable
        Called with the path of a file and its content, to write it.
    announce : callable
        Called before a function is compiled.
    """

    def __init__(self, folder, publish, announce):
        self._folder, self._publish, self._announce = folder, publish, announce

    def machine_code(self, entry):
        """Return the `MachineCode` of a `kernels.native.entry.Entry`, kept or compiled."""
        made = []

        def compiled():
            made.append(entry.compiled())
            (found,) = made
            head = json.dumps([found.name, found.results, found.needed]).encode()
            return head + b"\n" + found.code if found.is_lasting() else b""

        payload = self.bytes_of(entry.__qualname__, _key(entry), compiled, _is_lasting)
        return made[0] if made else _machine_code(payload)

    def bytes_of(self, name, key, make, is_usable=bool):
        """Return bytes, kept or made.

        Parameters
        ----------
        name : str
            That of the file begins with it.
        key : str
            What the bytes depend on beside the folder.
        make : callable
            Makes them; empty ones are not kept.
        is_usable : callable, optional
            Called with bytes that are kept: whether they can be used here.
        """
        path = None
        if self._folder is not None:
            told, digest = re.sub(r"\W+", "_", name), hashlib.sha256(key.encode()).hexdigest()
            path = self._folder / f"{told}-{digest[:24]}{ENDING}"
        found = _kept(path, key) if path else b""
        if not found or not is_usable(found):
            self._announce()
            # processes that begin together, as tests and the jobs of an array, would each compile the same
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
    """Wait until no other process makes this file; one that is ended lets go of it, and without locks nobody waits."""
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
    """Return the bytes that a file keeps; empty if it is not whole."""
    content = _read_own(path)
    payload = content[_CHECKSUM_BYTES:]
    return payload if content[:_CHECKSUM_BYTES] == _checksum(key, payload) else b""


def _machine_code(payload):
    """Return the `MachineCode` that `KernelCache.machine_code` has kept."""
    head, _, code = payload.partition(b"\n")
    name, results, needed = json.loads(head)
    return MachineCode(name, tuple(results), tuple(needed), code)


def _is_lasting(payload):
    return _machine_code(payload).is_lasting()


def _key(entry):
    """What machine code depends on beside the folder: function, types, processor, settings, width of vectors."""
    from llvmlite import binding

    types = " ".join(f"{each.name}:{each.element}{each.dimensions}" for each in entry.arguments)
    settings = (f"{name}={os.environ.get(f'NUMBA_{name}')}" for name in _SETTINGS)
    target, features = (binding.get_process_triple(), binding.get_host_cpu_name()), ""
    # of a processor that LLVM does not know
    with suppress(RuntimeError):
        features = binding.get_host_cpu_features().flatten()
    return "\0".join(
        [entry.__module__, entry.__qualname__, types, *target, features, *settings, str(vector_bits())]
    )


def problem_of(status, *, sticky_is_safe=False):
    """Return who else could write a folder or file, as the end of a sentence; empty if only this user and root.

    In a folder with the sticky bit, as ``/tmp`` has it, others can make files and not replace those of this user.

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
    """Return the content of a file that no other user can write; empty if it is not there, or another thing."""

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
