"""Vectors of the full width, for these kernels alone."""

import re
import threading
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module

import numpy as np
import pytest
from numba import njit

from kernels.multiply_add import LINKS, multiply_add
from kernels.native import pipeline
from kernels.native.entry import entry, parallel

pytestmark = pytest.mark.compiled


@pytest.fixture
def compiled():
    """Return a function that compiles `multiply_add` with a preferred width [bits]."""

    def with_width(bits):
        found = multiply_add.copied(multiply_add.py_func).compiled
        with pipeline.preferring(bits):
            found(np.zeros(8), 1, 0.5, 0.25)
        return found

    return with_width


@entry(numbers="float64[::1]")
def straight(numbers):
    """Change numbers of which several fit into a vector."""
    for i in range(numbers.size):
        numbers[i] = 0.5 * numbers[i] + 0.25


@parallel(64, lambda *_: (np.empty(64),), rows="float64[:, ::1]", memory="float64[::1]")
def in_chunks(start, stop, rows, memory):
    """Change numbers by way of the memory of a thread."""
    for i in range(start, stop):
        memory[i - start] = rows[0, i]
    for i in range(memory.size):
        memory[i] = 0.5 * memory[i] + 0.25
    for i in range(start, stop):
        rows[0, i] = memory[i - start]


@pytest.fixture
def code_of(monkeypatch):
    """Return a function that compiles an entry point with a preferred width; returns its LLVM and assembly code."""
    texts, object_code = [], pipeline._PartLibrary.object_code

    def seen(self):
        module, code = object_code(self)
        texts.append((str(module), self._codegen._tm.emit_assembly(module)))
        return module, code

    def with_width(entry_point, bits):
        with pipeline.preferring(bits):
            entry_point.compiled()
        return texts.pop()

    monkeypatch.setattr(pipeline._PartLibrary, "object_code", seen)
    return with_width


@pytest.mark.parametrize("entry_point", [straight, in_chunks])
@pytest.mark.parametrize("bits", [0, 256, 512])
def test_every_function_of_an_entry_point_prefers_the_width(code_of, entry_point, bits):
    """What is left of an entry point when all that it calls is part of it: LLVM knows the width for each function."""
    module, _ = code_of(entry_point, bits)
    groups = dict(re.findall(r"^attributes #(\d+) = \{(.*)\}$", module, re.MULTILINE))
    functions = re.findall(r"^define [^\n]* #(\d+) ", module, re.MULTILINE)
    assert functions
    expected = [f'"{bits}"'] if bits else []
    for each in functions:
        assert re.findall(r'"prefer-vector-width"=(\S+)', groups[each]) == expected


def test_threads_that_compile_at_once_get_their_own_widths(monkeypatch):
    """Code of another width would be kept as code of this one."""
    widths, object_code = {}, pipeline._PartLibrary.object_code

    def seen(self):
        module, code = object_code(self)
        (widths[threading.get_ident()],) = re.findall(r'"prefer-vector-width"="(\d+)"', str(module))
        return module, code

    def compile_with(bits):
        together.wait()
        with pipeline.preferring(bits):
            straight.compiled()
        return bits, int(widths[threading.get_ident()])

    monkeypatch.setattr(pipeline._PartLibrary, "object_code", seen)
    together = threading.Barrier(8)
    with ThreadPoolExecutor(8) as pool:
        for asked, given in pool.map(compile_with, 4 * [256, 512]):
            assert asked == given
    assert pipeline._preferred == 0


@pytest.mark.parametrize("entry_point", [straight, in_chunks])
def test_the_machine_code_of_an_entry_point_has_vectors_of_the_width(code_of, entry_point):
    """The registers are those of the width: that is what the program computes with."""
    from sweep.platforms import host_features

    if not host_features().get("avx512f"):
        pytest.skip("a processor without AVX-512")
    wide, narrow = (code_of(entry_point, bits)[1] for bits in (512, 256))
    assert "zmm" in wide
    assert "zmm" not in narrow
    assert "ymm" in narrow


def llvm(function):
    """Return what Numba hands to LLVM for the only compiled form."""
    return next(iter(function.inspect_llvm().values()))


@pytest.mark.parametrize("bits", [256, 512])
def test_a_kernel_prefers_the_width_that_was_asked_for(compiled, bits):
    """LLVM is told the width with the function."""
    assert f'"prefer-vector-width"="{bits}"' in llvm(compiled(bits))


def test_without_a_width_the_choice_is_left_to_llvm(compiled):
    """Nothing is said of a width then."""
    assert "prefer-vector-width" not in llvm(compiled(0))


def test_code_of_other_packages_is_compiled_as_ever(compiled):
    """Numba's own settings stay as they are for whatever else a program compiles."""
    compiled(512)

    @njit
    def others(numbers):
        total = 0.0
        for number in numbers:
            total += number
        return total

    others(np.zeros(8))
    assert "prefer-vector-width" not in llvm(others)


def test_the_width_of_the_machine_code_is_the_preferred_one(compiled):
    """The registers of the machine code are those of the width."""
    from sweep.platforms import host_features

    if not host_features().get("avx512f"):
        pytest.skip("a processor without AVX-512")
    wide, narrow = (next(iter(compiled(bits).inspect_asm().values())) for bits in (512, 256))
    assert "zmm" in wide
    assert "zmm" not in narrow
    assert "ymm" in narrow


def test_the_width_changes_no_bit(compiled):
    """Lanes never exchange a number; the referee is the closed form of the sum."""
    numbers = np.random.default_rng().random(1000)
    results = []
    for bits in (0, 256, 512):
        results.append(numbers.copy())
        compiled(bits)(results[-1], 3, 0.7, 0.3)
    assert results[0].tobytes() == results[1].tobytes() == results[2].tobytes()
    # a geometric sum: x -> a x + b, 3 LINKS times
    n = 3 * LINKS
    expected = 0.7**n * numbers + 0.3 * (1.0 - 0.7**n) / (1.0 - 0.7)
    np.testing.assert_allclose(results[0], expected, rtol=1e-14)


@pytest.mark.parametrize(
    "place",
    ["disk.integrate:integrate", "lossy_disk.integrate:integrate_rolling_pivoting_moffatt_slipping"],
)
def test_the_loops_over_lanes_are_vector_code(code_of, place):
    """Lane by lane goes what LLVM cannot do in vectors: then there is a call, or an operation on one number."""
    from sweep.platforms import host_features

    if not host_features().get("avx512f"):
        pytest.skip("a processor without AVX-512")
    module, _, name = place.partition(":")
    assembly = code_of(getattr(import_module(f"kernels.{module}"), name), 512)[1]
    functions = re.findall(r"\n(\w+):\s*\n(.*?)\n\.Lfunc_end", assembly, re.DOTALL)
    loops = [code for label, code in functions if re.search("advance_to_event_of|prepare_all_of", label)]
    assert len(loops) == 2
    for code in loops:
        assert re.findall(r"\n\tcall\w*\t.*", code) == []
        assert re.findall(r"\n\tvf\w+sd\t.*", code) == []
        assert re.search(r"\n\tvf\w+pd\t[^\n]*zmm", code)
