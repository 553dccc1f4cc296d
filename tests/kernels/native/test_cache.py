"""The cache of compiled kernels: damaged files are recompiled, and files writable by others are not loaded."""

import errno
import os
import stat
import subprocess
import sys

import numpy as np
import pytest
from llvmlite import binding

from kernels.native import cache
from kernels.native.cache import KernelCache
from kernels.native.entry import entry
from sweep.atomic import publish_bytes

pytestmark = pytest.mark.compiled


@entry(numbers="float64[::1]")
def double(numbers):
    """Double numbers; no other kernel has this result."""
    for i in range(numbers.size):
        numbers[i] = 2.0 * numbers[i] + 0.5


@entry(numbers="float64[::1]")
def triple(numbers):
    """Triple numbers."""
    for i in range(numbers.size):
        numbers[i] = 3.0 * numbers[i] + 0.5


#: Arrays that compiled code refers to by address: one too large to embed its 1.6 MB, one not contiguous.
LARGE, SCATTERED = np.arange(200_000.0), np.arange(10.0)[::2]


@entry(numbers="float64[::1]")
def from_large(numbers):
    """Add numbers of a large array."""
    for i in range(numbers.size):
        numbers[i] += LARGE[199_990 + i]


@entry(numbers="float64[::1]")
def from_scattered(numbers):
    """Add numbers of a noncontiguous array."""
    for i in range(numbers.size):
        numbers[i] += SCATTERED[i]


def found_in(folder, kernel=double):
    """Call a kernel as a new process with a cache folder; return True if it was loaded from there."""
    announced = []
    fresh = kernel.copied(kernel.py_func)

    def publish(path, content):
        publish_bytes(path, content, mode=0o644)

    fresh.source = KernelCache(folder, publish, lambda: announced.append(1)).machine_code
    found, expected = np.arange(4.0), np.arange(4.0)
    fresh(found)
    kernel.py_func(expected)
    assert list(found) == list(expected)
    return not announced


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the path and content of the only file of a cache."""
    folder = tmp_path_factory.mktemp("cache")
    found_in(folder)
    (path,) = folder.iterdir()
    return path, path.read_bytes()


def flipped(content, place):
    """Return the content with one bit flipped."""
    return content[:place] + bytes([content[place] ^ 4]) + content[place + 1 :]


DAMAGES = {
    "empty": lambda content: b"",
    "cut in the checksum": lambda content: content[:20],
    "last byte lost": lambda content: content[:-1],
    "zeros": lambda content: bytes(len(content)),
    "a bit of the checksum": lambda content: flipped(content, 3),
    "a bit of the head": lambda content: flipped(content, 40),
    "a bit of the machine code": lambda content: flipped(content, len(content) // 2),
    "longer": lambda content: content + b"\0",
    "another program's": lambda content: b"a cache of another program" + content,
}


def test_a_damaged_file_is_compiled_again(whole):
    """A damaged file is not loaded, the result is right, and the next process finds a valid file."""
    path, content = whole
    for kind, damaged in DAMAGES.items():
        path.write_bytes(damaged(content))
        assert not found_in(path.parent), kind
        assert found_in(path.parent), kind
        assert len(list(path.parent.iterdir())) == 1


def test_another_thing_in_its_place_is_not_loaded(whole, tmp_path):
    """A pipe, a link, another function's file and one writable by others are each recompiled and replaced."""
    path, content = whole
    path.write_bytes(content)
    copy = tmp_path / path.name
    found_in(tmp_path, triple)
    (other,) = tmp_path.iterdir()
    replacements = {
        "pipe": lambda: os.mkfifo(copy),
        "link": lambda: copy.symlink_to(path),
        "another's key": lambda: copy.write_bytes(other.read_bytes()),
        "written by others": lambda: (copy.write_bytes(content), copy.chmod(0o666)),
    }
    for kind, replace in replacements.items():
        copy.unlink(missing_ok=True)
        replace()
        assert not found_in(tmp_path), kind
        assert found_in(tmp_path), kind
        assert stat.S_IMODE(copy.lstat().st_mode) == 0o644, kind


def test_other_code_is_kept_apart(tmp_path, monkeypatch):
    """Code for other settings or processors, as in a shared folder, has its own file and is found again."""
    settings = [f"NUMBA_{name}" for name in cache._SETTINGS]
    for name in settings:
        monkeypatch.delenv(name, raising=False)
    assert not found_in(tmp_path)
    # Numba has already read its settings, so any value will do
    for name in (*settings, "EULERDISK_VECTOR_BITS"):
        with monkeypatch.context() as context:
            context.setenv(name, "256" if name.startswith("EULERDISK") else "1")
            assert not found_in(tmp_path), name
            assert found_in(tmp_path), name
    features = binding.get_host_cpu_features()
    features["fma"] = not features.get("fma")
    for name, value in (("get_host_cpu_name", "another"), ("get_host_cpu_features", features)):
        with monkeypatch.context() as context:
            context.setattr(binding, name, lambda value=value: value)
            assert not found_in(tmp_path), name
    assert len(list(tmp_path.iterdir())) == 1 + len(settings) + 1 + 2
    assert found_in(tmp_path)


def test_code_with_an_address_of_this_process_is_not_kept(tmp_path):
    """Code with an address in this process is not cached, because it would be invalid in another."""
    for kernel in (from_large, from_scattered):
        assert not found_in(tmp_path, kernel)
        assert not list(tmp_path.iterdir())


def test_the_owner_of_a_file_is_this_user_or_root(tmp_path):
    """A file of another owner is refused, because the owner can write to it."""
    mode, *rest = os.stat(tmp_path)
    for owner, problem in [(os.geteuid(), ""), (0, ""), (4711, "belongs to another user (uid 4711)")]:
        status = os.stat_result((mode & ~0o022, *rest[:3], owner, *rest[4:]))
        assert cache.problem_of(status) == problem


_BESIDE = """
import sys, time, pathlib
from kernels.native.cache import KernelCache
from sweep.atomic import publish_bytes
def make():
    print("made", flush=True)
    time.sleep(0.5)
    return b"code"
print(KernelCache(pathlib.Path(sys.argv[1]), publish_bytes, lambda: None).bytes_of("a", "key", make))
"""


def test_processes_that_begin_together_compile_once(tmp_path):
    """The others wait for the first process and use its result; no lock file is left."""
    begun = [
        subprocess.Popen(
            [sys.executable, "-c", _BESIDE, str(tmp_path)],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(3)
    ]
    told = [each.communicate()[0].split() for each in begun]
    assert sorted(told) == [["b'code'"], ["b'code'"], ["made", "b'code'"]]
    assert [each.suffix for each in tmp_path.iterdir()] == [cache.ENDING]


def test_where_nothing_can_be_locked_everybody_compiles(tmp_path, monkeypatch):
    """Without file locks, as on some network mounts, every process compiles."""

    def refuse(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(cache.fcntl, "flock", refuse)
    assert not found_in(tmp_path)
    assert found_in(tmp_path)
