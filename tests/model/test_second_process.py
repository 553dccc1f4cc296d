"""A second process compiles some entry points while this one compiles the others."""

import subprocess
import sys

import pytest

from kernels.native import machine_code
from sweep.model import second_process
from sweep.model.kernel import Kernel

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


def test_a_process_that_does_not_end_is_given_up(kernel, monkeypatch, tmp_path):
    """The other process may hang; then it is ended."""
    sleeper = tmp_path / "sleeper"
    sleeper.write_text("#!/bin/sh\nexec sleep 600\n", encoding="utf-8")
    sleeper.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(sleeper))
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
