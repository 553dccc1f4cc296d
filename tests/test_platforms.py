"""Systems and processors: supported ones give no message, impossible ones are refused, others warned about once."""

import math
import os
import platform
import pwd
import resource
import subprocess
import sys
import tempfile
import warnings
from collections import namedtuple

import pytest
from llvmlite import binding
from messages import assert_facts

from sweep import platforms
from sweep.errors import SurroundingsWarning
from sweep.platforms import free_bytes, processors

#: A system whose Python lacks the module fcntl, such as Windows.
_NO_LOCKS = "import sys; sys.modules['fcntl'] = None; "


@pytest.fixture
def simulated(monkeypatch):
    """Return a function that simulates a system, an architecture and the features of a processor."""

    def simulate(system, architecture, features=None):
        def host_features():
            if features is None:
                raise RuntimeError("unknown processor")
            return features

        monkeypatch.setattr(sys, "platform", system)
        monkeypatch.setattr(platform, "machine", lambda: architecture)
        monkeypatch.setattr(binding, "get_host_cpu_features", host_features)
        platforms.warn_of_processor.cache_clear()

    yield simulate
    platforms.warn_of_processor.cache_clear()


def said():
    """Return the warnings of two first uses of a kernel."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        platforms.warn_of_processor()
        platforms.warn_of_processor()
    return [str(each.message) for each in caught]


def without_locks(statement):
    """Run a statement in a Python without fcntl."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.run(
        [sys.executable, "-c", _NO_LOCKS + statement],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("system", ["linux", "darwin"])
@pytest.mark.parametrize(
    ("architecture", "features"),
    [("x86_64", {"fma": True}), ("AMD64", {"fma": True}), ("arm64", None), ("aarch64", None)],
)
def test_supported_machines_are_silent(simulated, system, architecture, features):
    """These are Linux and macOS on x86-64 with fused multiply-add, or on arm64, which always has it."""
    simulated(system, architecture, features)
    assert said() == []


@pytest.mark.parametrize(
    ("system", "architecture", "features", "named"),
    [
        ("linux", "x86_64", {"fma": False, "avx": True}, "x86_64"),
        ("linux", "x86_64", {}, "x86_64"),
        ("linux", "x86_64", None, "x86_64"),
        ("linux", "ppc64le", {}, "ppc64le"),
        ("linux", "", {}, "architecture"),
        ("freebsd14", "x86_64", {"fma": True}, "freebsd14"),
    ],
)
def test_other_machines_are_warned_of_once(simulated, system, architecture, features, named):
    """One warning names the unsupported part, the supported ones, and the consequences for the atlas."""
    simulated(system, architecture, features)
    (text,) = said()
    assert_facts(text, named, "Linux", "macOS", "x86-64", "arm64", "fused multiply-add", "bits")


def test_the_warning_comes_with_the_first_kernel(simulated):
    """A motion on an unknown processor is computed; the warning appears when its kernel is loaded."""
    import sweep
    from sweep.model import kernel

    simulated("linux", "riscv64")
    kernel._loaded.cache_clear()
    with pytest.warns(SurroundingsWarning) as caught:
        motion = sweep.simulate(sweep.TrajectorySpec.from_words(["tilt=0.1", "duration=0.1"]))
    (warning,) = caught
    assert_facts(str(warning.message), "riscv64")
    assert float(motion.tilt[0]) == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("text", "quota"),
    [("max 100000", math.inf), ("150000 100000", 1.5), ("50000 0", math.inf), ("nonsense", math.inf)],
)
def test_the_quota_of_a_control_group(monkeypatch, tmp_path, text, quota):
    """A container's CPU quota is a number of processors; an unreadable one sets no limit."""
    file = tmp_path / "cpu.max"
    file.write_text(text + "\n")
    monkeypatch.setattr(platforms, "open", lambda *_, **__: file.open(), raising=False)
    assert platforms.processor_quota() == quota


@pytest.mark.parametrize(
    ("quota", "asked", "available", "usual"),
    [(math.inf, "", 8, 8), (1.5, "", 2, 2), (0.5, "", 1, 1), (99.0, "", 8, 8), (6.2, "3", 7, 3)],
)
def test_threads_follow_the_quota(machine, monkeypatch, quota, asked, available, usual):
    """The quota, rounded up, limits threads like the affinity; NUMBA_NUM_THREADS limits only the kernels."""
    monkeypatch.setenv("NUMBA_NUM_THREADS", asked)
    machine(processors=8, processor_quota=quota)
    assert (platforms.available_threads(), platforms.usual_threads()) == (available, usual)


def test_processors_are_those_of_the_affinity(monkeypatch):
    """If the system has no affinity, all processors count."""
    monkeypatch.setattr(platforms, "processors", processors)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {1, 3, 5}, raising=False)
    assert platforms.processors() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert platforms.processors() == 6


def test_the_free_room_of_a_disk(monkeypatch, tmp_path):
    """It is the system's number, or unlimited if a file system has no size."""
    # The --pretend option may have replaced the function.
    monkeypatch.setattr(platforms, "free_bytes", free_bytes)
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(platforms.shutil, "disk_usage", lambda _: usage(10**12, 0, 31))
    assert platforms.free_bytes(tmp_path) == 31
    monkeypatch.setattr(platforms.shutil, "disk_usage", lambda _: usage(10**12, 10**12, 0))
    assert platforms.free_bytes(tmp_path) == 0
    monkeypatch.setattr(platforms.shutil, "disk_usage", lambda _: usage(0, 0, 0))
    assert platforms.free_bytes(tmp_path) == math.inf


def test_the_limit_of_addresses(monkeypatch):
    """It is the soft limit of `ulimit -v`, or infinite."""
    monkeypatch.setattr(resource, "getrlimit", lambda kind: (2**31, resource.RLIM_INFINITY))
    assert platforms.address_space() == 2**31
    monkeypatch.setattr(resource, "getrlimit", lambda kind: (resource.RLIM_INFINITY,) * 2)
    assert platforms.address_space() == math.inf


def test_a_user_without_a_home_has_a_cache(monkeypatch, tmp_path):
    """For a numeric user without HOME, as in a container, the cache is among the temporary files."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    if sys.platform == "linux":
        assert platforms.cache_home() == tmp_path / "xdg" / "eulerdisk"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert tmp_path in platforms.cache_home().parents
    monkeypatch.delenv("HOME")
    monkeypatch.setattr(pwd, "getpwuid", lambda number: {}[number])
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path))
    assert platforms.cache_home() == tmp_path / f"eulerdisk-{os.getuid()}"


def test_a_system_without_locks_is_refused_on_the_command_line():
    """It ends with status 2 and one sentence with a hint, without a traceback."""
    for words in ["--version", "run rolling -o a.nc"]:
        argv = f"sys.argv = ['eulerdisk', *{words.split()}]; "
        done = without_locks(f"{argv}from sweep.cli import main; main()")
        assert (done.returncode, done.stdout) == (2, "")
        assert len(done.stderr.splitlines()) == 1
        assert_facts(done.stderr, "Linux", "macOS", "WSL")


def test_a_system_without_locks_is_refused_in_python():
    """The first name used from `sweep` raises an error that is both ImportError and RequestError."""
    for use in ["from sweep import run", "import sweep; sweep.SweepSpec"]:
        caught = "except ImportError as error: print(type(error).__mro__[1].__name__, error)"
        done = without_locks(f"\ntry: {use}\n{caught}")
        assert done.stdout.startswith("RequestError "), done.stderr
        assert_facts(done.stdout, "Linux", "macOS", "WSL")
