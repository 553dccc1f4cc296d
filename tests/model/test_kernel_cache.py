"""The cache of compiled kernels: what is damaged is compiled again, and what others can write is not loaded."""

import os
import stat
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from kernels.native.entry import entry
from sweep.errors import SurroundingsWarning
from sweep.model import kernel_cache
from sweep.model.kernel_cache import KernelCache, usable_folder

pytestmark = pytest.mark.compiled


@entry(numbers="float64[::1]")
def double(numbers):
    """Replace numbers by others that no other kernel makes of them."""
    for i in range(numbers.size):
        numbers[i] = 2.0 * numbers[i] + 0.5


@entry(numbers="float64[::1]")
def triple(numbers):
    """Replace numbers by others."""
    for i in range(numbers.size):
        numbers[i] = 3.0 * numbers[i] + 0.5


#: So large that compiled code has its address, and not its 1.6 MB.
LARGE = np.arange(200_000.0)
#: Not contiguous, so that compiled code has its address too.
SCATTERED = np.arange(10.0)[::2]


@entry(numbers="float64[::1]")
def from_large(numbers):
    """Add numbers of a large array."""
    for i in range(numbers.size):
        numbers[i] += LARGE[199_990 + i]


@entry(numbers="float64[::1]")
def from_scattered(numbers):
    """Add numbers of an array that is not contiguous."""
    for i in range(numbers.size):
        numbers[i] += SCATTERED[i]


def compiled(folder, kernel=double):
    """Call a kernel as a new process does, with a cache in a folder; returns whether it was found there."""
    announced = []
    fresh = kernel.copied(kernel.py_func)
    fresh.source = KernelCache(folder, announce=lambda: announced.append(1)).machine_code
    found, expected = np.arange(4.0), np.arange(4.0)
    fresh(found)
    kernel.py_func(expected)
    assert list(found) == list(expected)
    return not announced


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the path of the only file of a cache, and its content."""
    folder = tmp_path_factory.mktemp("cache")
    compiled(folder)
    (path,) = folder.iterdir()
    return path, path.read_bytes()


def flipped(content, place):
    """Return a content with one bit of another value."""
    return content[:place] + bytes([content[place] ^ 4]) + content[place + 1 :]


DAMAGES = {
    "empty": lambda content: b"",
    "cut in the checksum": lambda content: content[:20],
    "cut": lambda content: content[: len(content) // 2],
    "last byte lost": lambda content: content[:-1],
    "zeros": lambda content: bytes(len(content)),
    "a bit of the checksum": lambda content: flipped(content, 3),
    "a bit of the head": lambda content: flipped(content, 40),
    "a bit of the machine code": lambda content: flipped(content, len(content) // 2),
    "longer": lambda content: content + b"\0",
    "another program's": lambda content: b"a cache of another program" + content,
}


@pytest.mark.parametrize("kind", DAMAGES)
def test_a_damaged_file_is_compiled_again(whole, kind):
    """Whatever happened to it, it is not loaded, the answer is right, and the next process finds it whole again."""
    path, content = whole
    path.write_bytes(DAMAGES[kind](content))
    assert compiled(path.parent) is False
    assert compiled(path.parent) is True
    assert len(list(path.parent.iterdir())) == 1


@pytest.mark.parametrize(
    "setting",
    ["CPU_NAME", "CPU_FEATURES", "ENABLE_AVX", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK"],
)
def test_code_of_other_settings_of_numba_is_kept_apart(tmp_path, monkeypatch, setting):
    """Numba would make other code: what was made before is not taken for it, and found again without the setting."""
    monkeypatch.delenv(f"NUMBA_{setting}", raising=False)
    compiled(tmp_path)
    keys = {kernel_cache._key(double, 0)}
    # Numba has read its settings already, so any value will do
    for value in ("0", "1"):
        monkeypatch.setenv(f"NUMBA_{setting}", value)
        keys.add(kernel_cache._key(double, 0))
        assert compiled(tmp_path) is False
    assert len(keys) == len(list(tmp_path.iterdir())) == 3
    monkeypatch.delenv(f"NUMBA_{setting}")
    assert compiled(tmp_path) is True


def test_code_of_another_processor_is_kept_apart(tmp_path, monkeypatch):
    """One with another name, or another feature, that finds the same folder on a network drive."""
    features = dict(kernel_cache.host_features())
    compiled(tmp_path)
    monkeypatch.setattr(kernel_cache, "host_features", lambda: dict(reversed(features.items())))
    assert compiled(tmp_path) is True
    monkeypatch.setattr(kernel_cache, "host_features", lambda: {**features, "fma": not features.get("fma")})
    assert compiled(tmp_path) is False
    monkeypatch.setattr(kernel_cache, "processor", lambda: "another")
    assert compiled(tmp_path) is False
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize("kernel", [from_large, from_scattered])
def test_code_with_an_address_of_this_process_is_not_kept(tmp_path, kernel):
    """Another process would read memory that is not there, or other numbers: it compiles the kernel again."""
    assert compiled(tmp_path, kernel) is False
    assert not list(tmp_path.iterdir())
    assert compiled(tmp_path, kernel) is False


_READS_A_LARGE_ARRAY = """
import sys, numpy as np
from pathlib import Path
from tests.model.test_kernel_cache import LARGE, KernelCache, from_large
# memory lies elsewhere in each process
held = [np.arange(100_000.0 * int(sys.argv[2]))]
from_large.source = KernelCache(Path(sys.argv[1])).machine_code
numbers = np.zeros(4)
from_large(numbers)
print(list(numbers) == list(LARGE[199_990:199_994]))
"""


def test_a_second_process_reads_its_own_large_array(tmp_path):
    """What the first process leaves on disk neither ends the second one nor lets it read other numbers."""
    for number in range(1, 3):
        done = subprocess.run(
            [sys.executable, "-c", _READS_A_LARGE_ARRAY, str(tmp_path), str(number)],
            env={**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[2]), *sys.path])},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.stdout.split() == ["True"], (done.returncode, done.stderr)


@pytest.mark.parametrize("kind", ["folder", "pipe", "link", "another's key"])
def test_another_thing_in_its_place_is_not_loaded(whole, tmp_path, kind):
    """A folder, a pipe, a link or the file of another function costs the compilation, and no more than a warning."""
    path, content = whole
    copy = tmp_path / "cache" / path.name
    copy.parent.mkdir()
    if kind == "folder":
        copy.mkdir()
    elif kind == "pipe":
        os.mkfifo(copy)
    elif kind == "link":
        copy.symlink_to(path)
    else:
        path.write_bytes(content)
        other = tmp_path / "other"
        other.mkdir()
        compiled(other, triple)
        copy.write_bytes(next(other.iterdir()).read_bytes())
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert compiled(copy.parent) is False
    assert ["could not be kept" in str(each.message) for each in told] == [True] * (kind == "folder")
    assert kind == "folder" or compiled(copy.parent) is True


def test_a_full_disk_costs_the_next_compilation(tmp_path, monkeypatch):
    """Where the compiled kernel cannot be kept, it is used all the same, and a warning names the folder."""

    def refuse(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(kernel_cache, "publish_bytes", refuse)
    with pytest.warns(SurroundingsWarning, match=r"No space left.*EULERDISK_CACHE_DIR"):
        compiled(tmp_path)


@pytest.mark.parametrize(
    ("root", "folder", "expected"),
    [
        (0o755, 0o755, ""),
        (0o700, 0o700, ""),
        (0o1777, 0o755, ""),
        (0o777, 0o755, "can be written by others .mode 777."),
        (0o775, 0o755, "can be written by others .mode 775."),
        (0o755, 0o775, "can be written by others"),
        (0o755, 0o1777, "can be written by others"),
    ],
)
def test_a_folder_that_others_can_write_is_not_used(tmp_path, root, folder, expected):
    """Others who can write to it could have anything executed here; a warning says why, and the hint what to do."""
    path = tmp_path / "root" / "key"
    path.mkdir(parents=True)
    path.chmod(folder)
    path.parent.chmod(root)
    if expected:
        with pytest.warns(SurroundingsWarning, match=rf"{expected}.*chmod -R go-w.*EULERDISK_CACHE_DIR"):
            assert usable_folder(path.parent, "key") is None
    else:
        assert usable_folder(path.parent, "key") == path


def test_a_folder_of_another_user_is_not_used(tmp_path):
    """The owner of a folder can write to it: it must be this user, or root."""
    mode, *rest = os.stat(tmp_path)
    for owner, problem in [(os.geteuid(), ""), (0, ""), (4711, "belongs to another user (uid 4711)")]:
        status = os.stat_result((mode & ~0o022, *rest[:3], owner, *rest[4:]))
        assert kernel_cache._problem(status) == problem


def test_a_file_that_others_can_write_is_not_loaded(whole):
    """The file is asked too, when it is open: what others can write is compiled again, and replaced."""
    path, content = whole
    path.write_bytes(content)
    path.chmod(0o666)
    assert compiled(path.parent) is False
    assert stat.S_IMODE(path.stat().st_mode) == 0o644
    assert compiled(path.parent) is True


def test_what_is_made_can_be_used_under_every_umask(tmp_path):
    """Folders and files can be written by their owner alone, also where new files belong to a group, umask 002."""
    before = os.umask(0o002)
    try:
        folder = usable_folder(tmp_path / "a" / "root", "key")
        compiled(folder)
        assert compiled(folder) is True
    finally:
        os.umask(before)
    modes = [stat.S_IMODE(path.stat().st_mode) for path in (folder.parent, folder, *folder.iterdir())]
    assert modes == [0o755, 0o755, 0o644]
