"""Compiled functions: which parts of their code count, and their cache folder on disk."""

import json
import os
import re
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from messages import assert_facts, refused

import kernels
from sweep.errors import RequestError, SurroundingsWarning
from sweep.model import kernel
from sweep.model.disk.exact import REDUCE
from sweep.model.disk.model import DISK
from sweep.model.kernel import Kernel, cache_folder, check_cache, closure, code_hash
from sweep.model.lossy_disk.model import integrator
from sweep.notices import listen

CHECKOUT = Path(kernels.__file__).parents[1]
INTEGRATE = "kernels.disk.integrate"


def python(program, *words, folder=CHECKOUT):
    """Run Python in a separate process that imports from `folder` first; return its output."""
    done = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", "-c", program, *map(str, words)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), str(CHECKOUT)])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_notice_of_compiling_says_which_laws(tmp_path, monkeypatch):
    """Kernels of one module are distinguished: two sets of losses are compiled separately."""
    told = []
    monkeypatch.delenv("EULERDISK_NOTICES", raising=False)
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    listen(told.append)
    laws = {"contour": True, "damping": False, "pivoting": False, "air": "none", "slips": False}
    try:
        for each in (*(integrator(rolling=rolling, **laws) for rolling in (False, True)), DISK.integrate):
            kernel._announce(each)
    finally:
        listen(None)
    assert [each.split()[1].rpartition(".")[2] for each in told] == [
        "integrate_dry",
        "integrate_dry_rolling",
        "integrate",
    ]


CODE = '''"""About."""

from math import sin  # a library


def f(x):  # why
    """What."""
    return 0.5 * x + sin(x)  # "no text"


def g():
    return """# no docstring"""
'''


def test_code_counts_and_its_explanation_does_not(tmp_path, monkeypatch):
    """Comments, docstrings and empty lines may change; numbers, operators and strings may not."""
    module = tmp_path / "counted.py"
    monkeypatch.syspath_prepend(tmp_path)

    def hashes(source):
        module.write_text(source)
        return code_hash(["counted"]), code_hash([f])

    def f():
        """Replace the function of the module."""

    f.__module__, f.__qualname__ = "counted", "f"
    before = hashes(CODE)
    others = (
        ("About.", "Other words:\n\n    of # more lines\n"),
        ("# why", "# x = 2"),
        ("What.", "Other"),
        ("\n\n\n", "\n"),
    )
    for old, new in others:
        assert hashes(CODE.replace(old, new)) == before, old
    edits = (
        ("0.5", "0.50000001"),
        ("+", "-"),
        ("sin(x)", "sin(-x)"),
        ("    return 0", "    y = 0\n    return 0"),
    )
    for old, new in edits:
        assert not set(hashes(CODE.replace(old, new))) & set(before), old
    # A function's hash covers only its own code.
    whole, alone = hashes(CODE.replace("# no docstring", "# a text"))
    assert (whole == before[0], alone == before[1]) == (False, True)


def copy_of_the_project(folder):
    """Return a copy of both packages."""
    for package in ("kernels", "sweep"):
        shutil.copytree(CHECKOUT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


_HASHES = """
import json, pathlib, sys
from sweep.engine.compute import arithmetic_hash
from sweep.model.kernel import closure, code_hash
from sweep.request.spec import SweepSpec

spec = SweepSpec()
ways = {"rk4": spec, "exact": spec.replace(method="exact"), "contact": spec.replace(contact="yes"),
        "steady": spec.replace(tilt=0.1, precession_rate=1.0, roll_rate="steady")}
hashes = lambda: {name: arithmetic_hash(way) for name, way in ways.items()}
before, changed = hashes(), {}
for path, old, new in json.load(sys.stdin):
    file = pathlib.Path(path)
    source = file.read_text(encoding="utf-8")
    edited = source.replace(old, new, 1) if old else source + new
    assert edited != source, (path, old)
    file.write_text(edited, encoding="utf-8")
    changed[f"{path}: {old} -> {new}"] = [name for name, value in hashes().items() if value != before[name]]
    file.write_text(source, encoding="utf-8")
assert hashes() == before
files = {name: pathlib.Path(sys.modules["kernels"].__file__).parents[1].joinpath(*name.split(".")) for name in
         closure([ways["rk4"].model.integrate.module])}
files = [path / "__init__.py" if path.is_dir() else path.with_suffix(".py") for path in files.values()]
print(json.dumps([before, list(changed.values()), "numba" in sys.modules, list(map(str, files))]))
"""

ALL, RK4 = ["rk4", "exact", "contact", "steady"], ["rk4", "contact", "steady"]
EDITS = [
    ("kernels/disk/equations.py", "unit * tilt_rate,", "3.0 * unit * tilt_rate,", ALL),
    ("kernels/disk/rk4.py", "", "_MORE = 1\n", RK4),
    ("kernels/lanes/schedule.py", "", "_MORE = 1\n", RK4),
    ("kernels/native/function.py", '"contract"', '"contract", "reassoc"', ALL),
    ("kernels/reduction/turning.py", "", "_MORE = 1\n", ["exact", "contact"]),
    ("kernels/bodies/trajectory.py", "", "_MORE = 1\n", []),
    ("kernels/reduction/contact_extremes.py", "", "_MORE = 1\n", ["contact"]),
    ("kernels/disk/equations.py", "", "# a remark\n", []),
    ("kernels/lanes/schedule.py", '"""', '"""In other words: ', []),
    ("kernels/disk/steady.py", "", "_MORE = 1\n", ["steady"]),
    (
        "sweep/model/disk/initial_conditions.py",
        "    return completed\n",
        "    return {**starts}\n",
        ["steady"],
    ),
    (
        "sweep/model/disk/initial_conditions.py",
        "    return completed\n",
        "    # a remark\n    return completed\n",
        [],
    ),
    ("sweep/model/disk/initial_conditions.py", 'hint="Give a number', 'hint="Write a number', []),
    ("sweep/model/disk/contact.py", "np.empty(", "np.zeros(", ["contact"]),
    ("sweep/model/disk/exact.py", "vague = ", "vague = True | ", ["exact"]),
    ("sweep/model/disk/exact.py", "from sweep", "_MORE = 1\nfrom sweep", []),
    ("sweep/request/sources.py", "return np.linspace(", "return 1.0 * np.linspace(", ALL),
    ("sweep/request/sources.py", "return np.array(self.values)", "return np.array(sorted(self.values))", ALL),
    ("sweep/request/sources.py", '"A range must have count', '"The range must have count', []),
    ("sweep/engine/grid.py", "np.full(cells.size, source)", "np.full(cells.size, 1.0 * source)", ALL),
    ("sweep/engine/grid.py", "BLOCK_CELLS = 2**17", "BLOCK_CELLS = 2**16", []),
    ("sweep/model/description.py", "0.0 if isinstance(value, str)", "1.0 if isinstance(value, str)", ALL),
    ("sweep/engine/compute.py", "np.zeros((len(model.counts)", "np.ones((len(model.counts)", ALL),
    ("sweep/engine/compute.py", "amplification = np.where(", "amplification = 1.0 * np.where(", []),
]


def edited(tree, edits):
    """Make edits one by one in a copy of the project, in a new process; return what `_HASHES` prints."""
    done = subprocess.run(
        [sys.executable, "-c", _HASHES],
        cwd=tree,
        env={**os.environ, "PYTHONPATH": str(tree)},
        input=json.dumps([edit[:3] for edit in edits]),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.slow_lane
def test_the_hash_follows_the_code_that_decides_the_bits(tmp_path):
    """An edit changes only the hashes of the methods that use that code; a comment changes none."""
    before, changed, compiler, files = edited(copy_of_the_project(tmp_path), EDITS)
    assert dict(zip((edit[:3] for edit in EDITS), changed, strict=True)) == {
        edit[:3]: edit[3] for edit in EDITS
    }
    assert len(set(before.values())) == 4
    assert all(re.fullmatch("[0-9a-f]{64}", each) for each in before.values())
    # The hash of a request needs no compiler.
    assert not compiler
    # Every module of the kernel counts, whether imported directly or indirectly.
    everywhere = [(str(Path(each).relative_to(tmp_path)), "", "_MORE = 1\n") for each in files]
    assert len(everywhere) > 10
    assert all("rk4" in each for each in edited(tmp_path, everywhere)[1])


def test_modules_of_another_distribution_are_followed(tmp_path, monkeypatch):
    """For every form of import, the model's own modules count, and those that it uses from `kernels`."""
    package = tmp_path / "pendulum_kernels"
    (package / "deep").mkdir(parents=True)
    parts = ("absolute", "relative", "sibling", "listed", "aliased", "second", "continued", "unused")
    for name in parts:
        (package / f"{name}.py").write_text("G = 9.81\n")
    (package / "__init__.py").write_text("")
    (package / "deep" / "__init__.py").write_text("from ..relative import G\n")
    (package / "integrate.py").write_text(
        "import pendulum_kernels.absolute\nfrom . import (\n    sibling,\n    listed as other,  # why\n)\n"
        "from .deep import G\nimport math, pendulum_kernels.aliased as short, pendulum_kernels.second\n"
        "from pendulum_kernels import missing_function, \\\n    continued\nfrom kernels.lanes.binding import bind\n"
        "# import pendulum_kernels.unused\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    before = code_hash(["pendulum_kernels.integrate"])
    counts = {}
    for name in parts:
        (package / f"{name}.py").write_text("G = 1.62\n")
        counts[name] = code_hash(["pendulum_kernels.integrate"]) != before
        (package / f"{name}.py").write_text("G = 9.81\n")
    assert counts == {name: name != "unused" for name in parts}
    assert "kernels.lanes.schedule" in closure(["pendulum_kernels.integrate"])


_TOY = {
    "numbers.py": "G = 2.0\n",
    "run.py": """
from kernels.native.entry import entry
from toy_kernels.numbers import G

@entry(x="float64")
def run(x):
    return G * x
""",
    "__init__.py": "",
}
_CALL = """
from sweep.model.kernel import Kernel
import sys
print(Kernel("toy_kernels.run", "run").load()(3.0), "numba" in sys.modules)
"""


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """Return the folder of a package with two modules, one of them a kernel, with an empty cache."""
    folder = tmp_path / "models" / "toy_kernels"
    folder.mkdir(parents=True)
    for name, source in _TOY.items():
        (folder / name).write_text(source)
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path / "cache"))
    return folder


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_an_edited_kernel_is_compiled_anew(toy):
    """An edit in an imported module gives a new result; the first result stays cached."""
    for source, expected in (("G = 2.0\n", "6.0"), ("G = 4.0\n", "12.0")):
        (toy / "numbers.py").write_text(source)
        assert python(_CALL, folder=toy.parent).split() == [expected, "True"]
    for source, expected in (("G = 2.0  # a remark\n", "6.0"), ("G = 4.0\n", "12.0")):
        (toy / "numbers.py").write_text(source)
        assert python(_CALL, folder=toy.parent).split() == [expected, "False"]


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_without_a_cache_the_kernel_is_compiled(toy, tmp_path, monkeypatch):
    """If the cache folder cannot be created, the kernel is compiled each time: same result, no warning."""
    occupied = tmp_path / "file"
    occupied.write_text("a file where the folder should be")
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(occupied / "cache"))
    for _ in range(2):
        assert python(_CALL, folder=toy.parent).split() == ["6.0", "True"]
    assert occupied.read_text() == "a file where the folder should be"


def test_the_cache_folder_is_named_after_all_that_matters(tmp_path, monkeypatch):
    """It is in the configured folder; its name contains the source hash and the compiler versions."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    folder = cache_folder([INTEGRATE])
    assert folder.parent == tmp_path
    assert folder.name.startswith(code_hash([INTEGRATE])[:16])
    assert f"numba{numba.__version__}-llvmlite" in folder.name
    assert cache_folder(["kernels.bodies.trajectory"]) != folder
    monkeypatch.delenv("EULERDISK_CACHE_DIR")
    assert "eulerdisk" in str(cache_folder([INTEGRATE]))


def test_a_folder_that_others_can_write_is_not_used(tmp_path):
    """Anyone who can write to it could run code here; a warning gives the reason and the remedy."""
    safe = [(0o755, 0o755), (0o700, 0o700), (0o1777, 0o755)]
    for i, (root, folder) in enumerate(
        [*safe, (0o777, 0o755), (0o775, 0o755), (0o755, 0o775), (0o755, 0o1777)]
    ):
        path = tmp_path / str(i) / "key"
        path.mkdir(parents=True)
        path.chmod(folder)
        path.parent.chmod(root)
        if i < len(safe):
            assert kernel._usable_folder(path) == path
        else:
            with pytest.warns(SurroundingsWarning) as caught:
                assert kernel._usable_folder(path) is None
            (warning,) = caught
            place, mode = (path.parent, root) if root in (0o777, 0o775) else (path, folder)
            assert_facts(
                str(warning.message), str(place), f"mode {mode:o}", "chmod -R go-w", "EULERDISK_CACHE_DIR"
            )


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_a_cache_can_be_used_under_every_umask(toy, tmp_path):
    """Only the owner can write folders and files, even with umask 002, where new files belong to a group."""
    python(f"import os; os.umask(0o002){_CALL}", folder=toy.parent)
    assert python(_CALL, folder=toy.parent).split() == ["6.0", "False"]
    modes = {
        stat.S_IMODE(path.stat().st_mode) - 0o111 * path.is_dir() for path in (tmp_path / "cache").rglob("*")
    }
    assert modes == {0o644}


def test_a_full_disk_costs_the_next_compilation(tmp_path, monkeypatch):
    """A compiled kernel that cannot be stored is still used, and a warning names the folder."""

    def refuse(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(kernel, "publish_bytes", refuse)
    with pytest.warns(SurroundingsWarning, match=r"No space left.*EULERDISK_CACHE_DIR"):
        kernel._publish(tmp_path / "a", b"")


def test_a_width_of_vectors_that_is_none_is_refused(toy, monkeypatch):
    """LLVM itself would ignore it."""
    monkeypatch.setenv("EULERDISK_VECTOR_BITS", "wide")
    with refused("128", "256", "512", "'wide'"):
        # A kernel that nothing in this process has loaded yet.
        Kernel("kernels.page.starts", "complete", seconds=7.25).load()


def test_a_cache_that_holds_nothing_is_refused(tmp_path, monkeypatch):
    """If the used kernels are not stored, each run compiles them again: the message names the folder."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    used = [DISK.integrate, REDUCE]
    # Kernels stored by another version do not count.
    modules = sorted({module for each in used for module, _ in each._entries()})
    folders = [tmp_path / "another version", *(cache_folder([each]) for each in modules)]
    for folder in folders:
        with pytest.raises(RequestError, match=re.escape(str(tmp_path))) as caught:
            check_cache(used)
        assert "EULERDISK_CACHE_DIR" in caught.value.hint
        folder.mkdir()
        (folder / "a.nbc").write_bytes(b"")
    check_cache(used)


_USED = """
import builtins, io, os, sys
usual = open
builtins.open = lambda name, *more, **rest: (
    io.StringIO(sys.argv[1]) if name == "/sys/fs/cgroup/cpu.max" else usual(name, *more, **rest)
)
os.sched_getaffinity = lambda process: set(range(8))
from kernels.native import workers
from sweep.model.kernel import Kernel
Kernel("kernels.page.starts", "complete").load()
print(workers.used())
workers.use(5)
print(workers.used())
"""


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="a system without affinity")
def test_threads_without_a_choice(monkeypatch):
    """One thread per processor of the affinity, limited by the CPU quota and by NUMBA_NUM_THREADS."""
    for quota, named, expected in (
        ("max 100000", "", "8"),
        ("250000 100000", "", "3"),
        ("250000 100000", "2", "2"),
    ):
        monkeypatch.setenv("NUMBA_NUM_THREADS", named)
        assert python(_USED, quota).split() == [expected, "5"], (quota, named)
