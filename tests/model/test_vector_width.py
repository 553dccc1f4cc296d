"""The width of vectors: measured where it is in doubt, and remembered for the processor."""

import os

import pytest

from kernels.rounding import probe
from sweep.model import vector_width
from sweep.model.kernel_cache import _key
from sweep.model.vector_width import FULL, HALF, bits, faster, measured

pytestmark = pytest.mark.compiled


@pytest.fixture
def processor(monkeypatch):
    """Pretend a processor with AVX-512 on which the multiply-adds of both widths have the rates that are given."""
    vector_width._chosen.cache_clear()
    monkeypatch.delenv("NUMBA_CPU_NAME", raising=False)
    monkeypatch.delenv("NUMBA_CPU_FEATURES", raising=False)
    counted = []

    def with_rates(half, full, **features):
        def rates():
            counted.append(1)
            return {HALF: half, FULL: full}

        monkeypatch.setattr(vector_width, "host_features", lambda: {"avx512f": True, **features})
        monkeypatch.setattr(vector_width, "measured", rates)
        return counted

    yield with_rates
    vector_width._chosen.cache_clear()


@pytest.mark.parametrize(
    ("full", "expected"), [(0.5, HALF), (0.8, HALF), (0.9, 0), (1.0, 0), (1.1, 0), (1.2, FULL), (2.0, FULL)]
)
def test_full_width_is_chosen_where_it_is_faster(processor, full, expected):
    """A tenth is not enough: some processors lower their clock for wide vectors."""
    processor(1.0, full)
    assert bits(None) == expected


def test_a_processor_without_wide_vectors_is_not_measured(processor):
    """There is nothing to choose."""
    counted = processor(1.0, 2.0, avx512f=False)
    assert bits(None) == 0
    assert not counted


@pytest.mark.parametrize("name", ["NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"])
def test_a_target_of_the_environment_is_left_to_llvm(processor, monkeypatch, name):
    """Whoever names a target gets the code that LLVM makes for it."""
    processor(1.0, 2.0)
    monkeypatch.setenv(name, "")
    assert bits(None) == 0


def test_the_choice_is_remembered_for_the_processor(processor, tmp_path):
    """One file for each kind of processor; the next process reads it."""
    counted = processor(1.0, 2.0)
    assert bits(tmp_path) == FULL
    vector_width._chosen.cache_clear()
    assert bits(tmp_path) == FULL
    assert len(counted) == 1
    # another processor, which finds the same folder on a network drive
    vector_width._chosen.cache_clear()
    processor(1.0, 1.0, avx512vnni=True)
    assert bits(tmp_path) == 0
    vector_width._chosen.cache_clear()
    assert bits(tmp_path) == 0
    assert len(counted) == 2
    assert len(list(tmp_path.iterdir())) == 2


def test_the_order_of_features_does_not_matter(processor, tmp_path):
    """Another version of LLVM may list them in another order."""
    counted = processor(1.0, 2.0, fma=True, avx2=True)
    bits(tmp_path)
    vector_width._chosen.cache_clear()
    processor(1.0, 2.0, avx2=True, fma=True)
    bits(tmp_path)
    assert len(counted) == 1


@pytest.mark.parametrize("content", [b"", b"51", b"512", b"1024\n", b"\xff" * 50])
def test_a_damaged_choice_is_measured_again(processor, tmp_path, content):
    """What is not a width is not believed, and replaced."""
    counted = processor(1.0, 2.0)
    bits(tmp_path)
    (place,) = tmp_path.iterdir()
    place.write_bytes(content)
    vector_width._chosen.cache_clear()
    assert bits(tmp_path) == FULL
    assert len(counted) == 2
    assert place.read_bytes() == b"512\n"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written_costs_a_measurement(processor, tmp_path):
    """A refusal of the file system ends nothing."""
    counted = processor(1.0, 2.0)
    tmp_path.chmod(0o500)
    assert bits(tmp_path) == FULL
    vector_width._chosen.cache_clear()
    assert bits(tmp_path) == FULL
    assert len(counted) == 2


def test_a_folder_that_is_not_there_costs_a_measurement(processor, tmp_path):
    """Neither does a folder that has vanished."""
    processor(1.0, 2.0)
    assert bits(tmp_path / "missing") == FULL


def test_the_measurement_counts_multiply_adds():
    """By a clock that counts its calls, each measurement takes a second."""
    ticks = iter(range(10**6))
    rates = measured(lambda: float(next(ticks)))
    assert rates[HALF] == rates[FULL] == 512 * 8000 * 16
    assert faster(rates) == 0


def test_compiled_forms_of_other_widths_are_kept_apart():
    """The cache does not hand out code of another width."""
    assert len({_key(probe, width) for width in (0, HALF, FULL)}) == 3
