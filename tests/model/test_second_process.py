"""A second process compiles some entry points while this one compiles the others."""

import subprocess
import sys

import pytest

from kernels.native import machine_code
from sweep.model import kernel as kernel_module
from sweep.model import second_process, vector_width
from sweep.model.kernel import Kernel, compile_apart

CODE = """
from kernels.native.entry import entry

@entry(number="float64")
def double(number):
    return 2.0 * number

@entry(number="float64")
def half(number):
    return 0.5 * number

@entry(number="float64")
def square(number):
    return number * number

def all_three(number):
    return double(number), half(number), square(number)
"""


@pytest.fixture
def kernel(tmp_path, monkeypatch, request):
    """Return a kernel of three entry points, two of them for the second process, and those compiled by this one."""
    module = f"halves_{abs(hash(request.node.name))}"
    (tmp_path / f"{module}.py").write_text(CODE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(second_process, "usual_threads", lambda: 2)
    compiled, made_here = machine_code.compiled, []

    def counted(function, *others):
        made_here.append(function.__name__)
        return compiled(function, *others)

    monkeypatch.setattr(machine_code, "compiled", counted)
    names = tuple(f"{module}:{each}" for each in ("double", "half", "square"))
    return Kernel(module, "all_three", names, beside=names[1:]), made_here


def test_the_second_process_compiles_its_share(kernel):
    """What the other process made is loaded."""
    all_three, made_here = kernel[0].load(), kernel[1]
    assert all_three(3.0) == (6.0, 1.5, 9.0)
    assert made_here == ["double"]


def test_what_was_made_ready_is_not_compiled_when_it_is_called(kernel, monkeypatch):
    """Kernels that are called one after the other are compiled together before the first call."""
    halves, made_here = kernel
    halves.make_ready()
    assert made_here == ["double"]
    monkeypatch.setattr(machine_code, "load", None)
    assert halves.load()(3.0) == (6.0, 1.5, 9.0)


@pytest.mark.parametrize("executable", ["/bin/false", "/no/such/file", "", None])
def test_without_a_second_process_this_one_compiles_all(kernel, monkeypatch, executable):
    """Whatever keeps the other process from its work costs time and nothing else."""
    monkeypatch.setattr(sys, "executable", executable)
    all_three, made_here = kernel[0].load(), kernel[1]
    assert all_three(3.0) == (6.0, 1.5, 9.0)
    assert made_here == ["double", "half", "square"]


def test_one_processor_compiles_alone(kernel, monkeypatch):
    """Two processes on one processor would take longer than one."""
    monkeypatch.setattr(second_process, "usual_threads", lambda: 1)
    assert kernel[0].load()(3.0) == (6.0, 1.5, 9.0)
    assert kernel[1] == ["double", "half", "square"]


@pytest.fixture
def hanging(tmp_path, monkeypatch):
    """Let the other process never end."""
    sleeper = tmp_path / "sleeper"
    sleeper.write_text("#!/bin/sh\nexec sleep 600\n", encoding="utf-8")
    sleeper.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(sleeper))


@pytest.mark.usefixtures("hanging")
def test_a_process_that_does_not_end_is_given_up(kernel, monkeypatch):
    """The other process may hang; then it is ended."""
    monkeypatch.setattr(second_process, "_PATIENCE", 0.2)
    assert kernel[0].load()(3.0) == (6.0, 1.5, 9.0)
    assert kernel[1] == ["double", "half", "square"]


def test_none_is_started_for_what_this_process_compiles(kernel, monkeypatch):
    """Where only the share of the other process is missing, it would do the same as this one, at the same time."""
    halves, made_here = kernel
    halves.load()
    monkeypatch.setattr(subprocess, "Popen", None)
    half = sys.modules[halves.module].half
    assert half(3.0) == 1.5
    assert made_here == ["half"]


@pytest.fixture
def apart(kernel, monkeypatch):
    """Return the kernel of a process that does not compile."""
    monkeypatch.setattr(kernel_module, "_always_apart", False)
    compile_apart()
    return kernel


@pytest.mark.parametrize("processors", [1, 2])
def test_a_process_that_does_not_compile_loads_what_another_made(apart, monkeypatch, processors):
    """All entry points are made in one go, on one processor too; the next ones are there."""
    monkeypatch.setattr(second_process, "usual_threads", lambda: processors)
    started, ordinary = [], subprocess.Popen
    monkeypatch.setattr(
        subprocess, "Popen", lambda line, **more: started.append(line) or ordinary(line, **more)
    )
    all_three, made_here = apart[0].load(), apart[1]
    double = sys.modules[apart[0].module].double
    assert double(3.0) == 6.0
    assert all_three(3.0) == (6.0, 1.5, 9.0)
    assert made_here == []
    assert len(started) == 1


def test_a_process_that_does_not_compile_does_not_measure_either(apart, monkeypatch):
    """The other process finds out how wide vectors should be, and remembers it for this one."""
    monkeypatch.delenv("NUMBA_CPU_NAME", raising=False)
    monkeypatch.delenv("NUMBA_CPU_FEATURES", raising=False)
    monkeypatch.setattr(vector_width, "measured", None)
    vector_width._chosen.cache_clear()
    try:
        assert apart[0].load()(3.0) == (6.0, 1.5, 9.0)
    finally:
        vector_width._chosen.cache_clear()
    assert apart[1] == []


def test_without_another_process_it_compiles_all_the_same(apart, monkeypatch):
    """An answer that takes memory is better than none."""
    monkeypatch.setattr(sys, "executable", "/bin/false")
    assert apart[0].load()(3.0) == (6.0, 1.5, 9.0)
    assert apart[1] == ["double", "half", "square"]


def test_without_a_cache_it_compiles_at_once(apart, monkeypatch, tmp_path):
    """Another process could not hand over what it makes."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(subprocess, "Popen", None)
    assert apart[0].load()(3.0) == (6.0, 1.5, 9.0)
    assert apart[1] == ["double", "half", "square"]


@pytest.mark.usefixtures("hanging")
def test_a_process_that_does_not_compile_waits_longer(apart, monkeypatch):
    """On a busy machine another process may take minutes; one that never ends is given up all the same."""
    monkeypatch.setattr(second_process, "_PATIENCE", 600.0)
    monkeypatch.setattr(second_process, "_MORE_PATIENCE", 0.2)
    assert apart[0].load()(3.0) == (6.0, 1.5, 9.0)
    assert apart[1] == ["double", "half", "square"]
