import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

import kernels
from sweep.engine import compiled

CHECKOUT = Path(kernels.__file__).parents[1]

_ONE_CELL = """
import numpy as np
from sweep.engine.compiled import cache_folder, integrate, kernel_hash
starts = np.array([[0.3], [0.2], [0.0], [4.0], [0.5], [0.5], [9.81]])
measures, counts = np.zeros((6, 1)), np.zeros((3, 1), np.int32)
kernel = integrate()
kernel(starts, np.array([300.0, 0.0, 1.48, 1e-8]), measures, counts)
stats = kernel.stats
print(kernel_hash(), cache_folder(), repr(float(measures[1, 0])), sum(stats.cache_hits.values()), sep="\\n")
"""


def one_cell(tree, cache):
    """Run one cell in a process of its own: (hash, cache folder, largest tilt, hits of the cache)."""
    env = os.environ | {"EULERDISK_CACHE_DIR": str(cache), "PYTHONPATH": str(tree)}
    run = subprocess.run(
        [sys.executable, "-c", _ONE_CELL], cwd=tree, env=env, capture_output=True, text=True, check=True
    )
    digest, folder, tilt, hits = run.stdout.split("\n")[:4]
    return digest, folder, float(tilt), int(hits)


def copy_of_the_project(tmp_path):
    """Return a copy of both packages."""
    for package in ("kernels", "sweep"):
        shutil.copytree(CHECKOUT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


@pytest.mark.compiled
def test_an_edited_kernel_is_compiled_anew(tmp_path):
    """An edit in a file that the entry point only imports gives a new answer, though the cache folder is shared."""
    cache = os.environ["EULERDISK_CACHE_DIR"]
    before = one_cell(CHECKOUT, cache)
    tree = copy_of_the_project(tmp_path / "copy")
    disk = tree / "kernels" / "disk.py"
    source = disk.read_text()
    disk.write_text(source.replace("unit * tilt_rate,", "3.0 * unit * tilt_rate,"))
    after = one_cell(tree, cache)
    shutil.rmtree(after[1])
    assert after[0] != before[0]
    assert Path(after[1]).parent == Path(before[1]).parent
    assert after[1] != before[1]
    assert after[2] > before[2] + 1e-3
    assert after[3] == 0
    # the first answer is still there, and found without compiling
    assert one_cell(CHECKOUT, cache) == (*before[:3], 1)


def test_every_source_counts(tmp_path, monkeypatch):
    """The hash changes with each single file of the kernels, with its name, and with nothing else."""
    tree = copy_of_the_project(tmp_path)

    original = compiled.kernel_hash()

    def digest():
        compiled.kernel_hash.cache_clear()
        return compiled.kernel_hash()

    monkeypatch.setattr(kernels, "__file__", str(tree / "kernels" / "__init__.py"))
    try:
        whole = digest()
        assert whole == original
        assert re.fullmatch("[0-9a-f]{64}", whole)
        seen = {whole}
        for path in sorted((tree / "kernels").rglob("*.py")):
            source = path.read_bytes()
            path.write_bytes(source + b"#\n")
            seen.add(digest())
            path.write_bytes(source)
        assert len(seen) == 1 + len(list((tree / "kernels").rglob("*.py")))
        (tree / "kernels" / "disk.py").rename(tree / "kernels" / "dish.py")
        assert digest() not in seen
        (tree / "kernels" / "dish.py").rename(tree / "kernels" / "disk.py")
        (tree / "kernels" / "notes.txt").write_text("not a source")
        assert digest() == whole
    finally:
        compiled.kernel_hash.cache_clear()


def test_the_cache_folder_is_named_after_all_that_matters(tmp_path, monkeypatch):
    """The folder is the wanted one and holds the hash of the sources and the versions of the compilers."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    folder = compiled.cache_folder()
    assert folder.parent == tmp_path
    assert folder.name.startswith(compiled.kernel_hash()[:16])
    assert f"numba{numba.__version__}-llvmlite" in folder.name
    monkeypatch.delenv("EULERDISK_CACHE_DIR")
    assert "eulerdisk" in str(compiled.cache_folder())


class Kernel:
    """Stands for a compiled kernel: remembers where its cache was to be."""

    def __init__(self, problem=None):
        self.problem = problem
        self.folder = None

    def enable_caching(self):
        """Do as numba's dispatcher does: read the folder from its configuration."""
        if self.problem:
            raise self.problem
        self.folder = numba.config.CACHE_DIR


@pytest.mark.parametrize("problem", [None, RuntimeError("no locator available"), PermissionError("denied")])
def test_numbas_own_cache_setting_is_left_as_it_was(tmp_path, monkeypatch, problem):
    """The folder is set for this one kernel only, whether caching works or not, and a failure is no error."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(numba.config, "CACHE_DIR", "as it was")
    monkeypatch.setattr(numba.config, "DISABLE_JIT", 0)
    kernel = Kernel(problem)
    compiled._cache_on_disk(kernel)
    assert numba.config.CACHE_DIR == "as it was"
    assert kernel.folder == (None if problem else str(compiled.cache_folder()))


@pytest.mark.compiled
def test_without_a_cache_the_kernel_is_compiled(tmp_path):
    """A cache folder that cannot be made costs the compilation and nothing else: same answer, no complaint."""
    occupied = tmp_path / "file"
    occupied.write_text("a file where the folder should be")
    found = one_cell(CHECKOUT, occupied / "cache")
    assert found[2:] == (one_cell(CHECKOUT, os.environ["EULERDISK_CACHE_DIR"])[2], 0)
    assert not found[1].startswith(os.environ["EULERDISK_CACHE_DIR"])
    assert occupied.read_text() == "a file where the folder should be"
