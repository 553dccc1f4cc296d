"""Systems and processors: what is supported is silent, what cannot work is refused, the rest is warned of once."""

import os
import platform
import subprocess
import sys
import warnings

import pytest
from llvmlite import binding

from sweep import platforms
from sweep.errors import SurroundingsWarning

#: A system whose Python has no module fcntl, as that of Windows.
_NO_LOCKS = "import sys; sys.modules['fcntl'] = None; "


@pytest.fixture
def machine(monkeypatch):
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
def test_supported_machines_are_silent(machine, system, architecture, features):
    """Linux and macOS on x86-64 with fused multiply-add, or on arm64, which always has it."""
    machine(system, architecture, features)
    assert said() == []


@pytest.mark.parametrize(
    ("system", "architecture", "features", "named"),
    [
        ("linux", "x86_64", {"fma": False, "avx": True}, "no fused multiply-add"),
        ("linux", "x86_64", {}, "no fused multiply-add"),
        ("linux", "x86_64", None, "no fused multiply-add"),
        ("linux", "ppc64le", {}, "ppc64le"),
        ("linux", "", {}, "unknown architecture"),
        ("freebsd14", "x86_64", {"fma": True}, "freebsd14"),
    ],
)
def test_other_machines_are_warned_of_once(machine, system, architecture, features, named):
    """One warning names what is not supported, what is, and what to expect of the atlas."""
    machine(system, architecture, features)
    (text,) = said()
    assert named in text
    assert "Linux and macOS on x86-64 and arm64" in text
    assert "last bits" in text


def test_the_warning_comes_with_the_first_kernel(machine):
    """A motion on an unknown processor is computed, and the warning comes when its kernel is loaded."""
    import sweep
    from sweep.model import kernel

    machine("linux", "riscv64")
    kernel._loaded.cache_clear()
    with pytest.warns(SurroundingsWarning, match="riscv64") as caught:
        motion = sweep.simulate(sweep.TrajectorySpec.from_words(["tilt=0.1", "duration=0.1"]))
    assert len(caught) == 1
    assert float(motion.tilt[0]) == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("quota", "threads"),
    [("max 100000", 8), ("150000 100000", 2), ("50000 100000", 1), ("9900000 100000", 8), ("nonsense", 8)],
)
def test_threads_follow_the_cpu_quota(monkeypatch, tmp_path, quota, threads):
    """A container's CPU quota counts, rounded up, besides the affinity."""
    file = tmp_path / "cpu.max"
    file.write_text(quota + "\n")
    monkeypatch.setattr(platforms.os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    monkeypatch.setattr(platforms, "open", lambda *_, **__: file.open(), raising=False)
    assert platforms.available_threads() == threads


def test_a_system_without_locks_is_refused_on_the_command_line():
    """Status 2 and one sentence with a hint, no traceback."""
    for words in ["--version", "run rolling -o a.nc"]:
        argv = f"sys.argv = ['eulerdisk', *{words.split()}]; "
        done = without_locks(f"{argv}from sweep.cli import main; main()")
        assert (done.returncode, done.stdout) == (2, "")
        assert len(done.stderr.splitlines()) == 1
        assert "Linux and macOS are supported" in done.stderr
        assert "WSL" in done.stderr


def test_a_system_without_locks_is_refused_in_python():
    """The first name that is taken from `sweep` raises an ImportError and RequestError that says the same."""
    for use in ["from sweep import run", "import sweep; sweep.SweepSpec"]:
        caught = "except ImportError as error: print(type(error).__mro__[1].__name__, error)"
        done = without_locks(f"\ntry: {use}\n{caught}")
        assert done.stdout.startswith("RequestError Linux and macOS are supported"), done.stderr
