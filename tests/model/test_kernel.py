"""Compiled functions: what of their code counts, and the folder on disk in which they are kept."""

import ast
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tokenize
from pathlib import Path

import numba
import pytest

import kernels
from sweep.errors import RequestError
from sweep.model import kernel
from sweep.model.disk.exact import EXTREMES
from sweep.model.disk.model import DISK
from sweep.model.kernel import Kernel, cache_folder, check_cache, code_hash, significant
from sweep.model.lossy_disk.variants import integrator
from sweep.notices import listen

CHECKOUT = Path(kernels.__file__).parents[1]
INTEGRATE = "kernels.disk.integrate"
CODED = sorted([*(CHECKOUT / "kernels").rglob("*.py"), *(CHECKOUT / "sweep").rglob("*.py")])


def test_the_notice_of_compiling_says_which_laws(tmp_path, monkeypatch):
    """Kernels of one module are told apart: those of two sets of losses are compiled apart, and so told."""
    told = []
    monkeypatch.delenv("EULERDISK_NOTICES", raising=False)
    listen(told.append)
    laws = {"contour": True, "damping": False, "pivoting": False, "air": "none", "slips": False}
    try:
        for rolling in (False, True):
            kernel._announce(integrator(rolling=rolling, **laws), tmp_path, True, kernel.SecondProcess(()))
        kernel._announce(DISK.integrate, tmp_path, True, kernel.SecondProcess(()))
    finally:
        listen(None)
    assert [each.split()[1].rpartition(".")[2] for each in told] == [
        "integrate_dry",
        "integrate_dry_rolling",
        "integrate",
    ]


def stripped(source):
    """Return source without comments, docstrings and blank lines, by Python's own tokenizer and parser."""
    lines = [line.encode() for line in source.splitlines()]
    cuts = [
        (token.start[0], len(token.line[: token.start[1]].encode()), token.end[0], len(token.line.encode()))
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    ]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0] if node.body else None
            if (
                isinstance(first, ast.Expr)
                and isinstance(first.value, ast.Constant)
                and isinstance(first.value.value, str)
            ):
                cuts.append((first.lineno, first.col_offset, first.end_lineno, first.end_col_offset))
    for top, left, bottom, right in cuts:
        before, after = lines[top - 1][:left], lines[bottom - 1][right:]
        lines[top - 1 : bottom] = [before + after] + [b""] * (bottom - top)
    return "\n".join(line.decode().rstrip() for line in lines if line.strip())


@pytest.mark.parametrize("path", CODED, ids=lambda path: str(path.relative_to(CHECKOUT)))
def test_what_counts_is_what_python_parses(path):
    """Of every file the parts that count are those that are left without comments, docstrings and blank lines."""
    source = path.read_text(encoding="utf-8")
    assert significant(source) == stripped(source)


@pytest.mark.parametrize(
    "source",
    [
        'x = "# no comment"\n',
        "x = '''# no comment'''\n",
        'x = """no docstring"""\n',
        'def f():\n    return """no docstring"""\n',
        'x = f("""no docstring""")\n',
        'x = {"a": """no docstring"""}\n',
        'x = {\n    "a":\n    """no docstring""",\n}\n',
        'x = "a \\" # b"\n',
        "x = r'\\''\n",
    ],
)
def test_strings_that_are_values_count(source):
    """A hash sign in a string is no comment, and a string in three quotes that is a value is no docstring."""
    assert significant(source) == source.rstrip("\n")


CODE = '''"""About."""

from math import sin  # a library


def f(x):  # why
    """What."""
    return 0.5 * x + sin(x)
'''


def test_comments_and_docstrings_do_not_count():
    """Neither their words nor whether they are there at all."""
    bare = "from math import sin\ndef f(x):\n    return 0.5 * x + sin(x)"
    assert significant(CODE) == bare
    assert significant(CODE.replace("About.", "Other words:\n\n    of # more lines\n")) == bare
    assert significant(CODE.replace("# why", "# x = 2")) == bare
    assert significant(CODE.replace('    """What."""\n', "    # what\n\n")) == bare


@pytest.mark.parametrize(
    ("old", "new"),
    [("0.5", "0.50000001"), ("+", "-"), ("sin(x)", "sin(-x)"), ("    return", "    y = 0\n    return")],
)
def test_code_counts(old, new):
    """A number, an operator, an argument and a line more change what counts."""
    assert significant(CODE.replace(old, new)) != significant(CODE)


def copy_of_the_project(folder):
    """Return a copy of both packages."""
    for package in ("kernels", "sweep"):
        shutil.copytree(CHECKOUT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


_HASHES = """
import json, pathlib, sys
from sweep.engine.compute import arithmetic_hash
from sweep.model.kernel import _closure, code_hash
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
         _closure([ways["rk4"].model.integrate.module])}
files = [path / "__init__.py" if path.is_dir() else path.with_suffix(".py") for path in files.values()]
print(json.dumps([before, list(changed.values()), "numba" in sys.modules, list(map(str, files))]))
"""

ALL, RK4 = ["rk4", "exact", "contact", "steady"], ["rk4", "contact", "steady"]
EDITS = [
    ("kernels/disk/equations.py", "unit * tilt_rate,", "3.0 * unit * tilt_rate,", RK4),
    ("kernels/disk/rk4.py", "", "_MORE = 1\n", RK4),
    ("kernels/lanes/schedule.py", "", "_MORE = 1\n", RK4),
    ("kernels/lanes/layout.py", "", "_MORE = 1\n", ALL),
    ("kernels/native/options.py", '"contract"', '"contract", "reassoc"', ALL),
    ("kernels/disk/exact/root.py", "", "_MORE = 1\n", ["exact"]),
    ("kernels/disk/contact.py", "", "_MORE = 1\n", []),
    ("kernels/disk/contact_extremes.py", "", "_MORE = 1\n", ["contact"]),
    ("kernels/disk/trajectory.py", "", "_MORE = 1\n", []),
    ("kernels/disk/growth_rates.py", "", "_MORE = 1\n", []),
    ("kernels/disk/equations.py", "", "# a remark\n", []),
    ("kernels/lanes/schedule.py", '"""', '"""In other words: ', []),
    ("kernels/disk/motion_arrays.py", "", "_MORE = 1\n", ["contact"]),
    ("kernels/disk/exact/arrays.py", "", "_MORE = 1\n", ["exact"]),
    ("kernels/disk/steady.py", "", "_MORE = 1\n", ["steady"]),
    ("sweep/model/disk/initial_conditions.py", "    return found\n", "    return {**starts}\n", ["steady"]),
    (
        "sweep/model/disk/initial_conditions.py",
        "    return found\n",
        "    # a remark\n    return found\n",
        [],
    ),
    ("sweep/model/disk/initial_conditions.py", 'hint="Give a number', 'hint="Write a number', []),
    ("sweep/model/disk/contact.py", "np.empty(", "np.zeros(", ["contact"]),
    ("sweep/model/disk/exact.py", "vague = ", "vague = True | ", ["exact"]),
    ("sweep/model/disk/exact.py", "from sweep", "_MORE = 1\nfrom sweep", []),
    ("sweep/request/axes.py", "return np.linspace(", "return 1.0 * np.linspace(", ALL),
    ("sweep/request/axes.py", "return np.array(self.values)", "return np.array(sorted(self.values))", ALL),
    ("sweep/request/axes.py", '"A range must have count', '"The range must have count', []),
    ("sweep/engine/grid.py", "np.full(cells.size, given)", "np.full(cells.size, 1.0 * given)", ALL),
    ("sweep/engine/grid.py", "BLOCK_CELLS = 2**17", "BLOCK_CELLS = 2**16", []),
    ("sweep/model/description.py", "0.0 if isinstance(value, str)", "1.0 if isinstance(value, str)", ALL),
    ("sweep/engine/compute.py", "np.zeros((len(model.counts)", "np.ones((len(model.counts)", ALL),
    ("sweep/engine/compute.py", "amplification = np.where(", "amplification = 1.0 * np.where(", []),
    ("sweep/engine/estimate.py", "", "_MORE = 1\n", []),
    ("sweep/model/disk/theory.py", "", "_MORE = 1\n", []),
]


def edited(tree, edits):
    """Make edits in a copy of the project, one at a time, in a process of its own; return what `_HASHES` prints."""
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


def test_the_hash_follows_the_code_that_decides_the_bits(tmp_path):
    """An edit changes the hash of the ways of computing whose code it is in, and no other; a remark changes none."""
    before, changed, compiler, files = edited(copy_of_the_project(tmp_path), EDITS)
    assert dict(zip((edit[:3] for edit in EDITS), changed, strict=True)) == {
        edit[:3]: edit[3] for edit in EDITS
    }
    assert len(set(before.values())) == 4
    assert all(re.fullmatch("[0-9a-f]{64}", each) for each in before.values())
    # the hash of a request needs no compiler
    assert not compiler
    # every module that the kernel is made of counts, be it imported by the entry point or by what that imports
    everywhere = [(str(Path(each).relative_to(tmp_path)), "", "_MORE = 1\n") for each in files]
    assert len(everywhere) > 10
    assert all("rk4" in each for each in edited(tmp_path, everywhere)[1])


def test_modules_of_another_distribution_are_followed(tmp_path, monkeypatch):
    """Whatever form its imports have, all modules of a model's own package count, and what it takes from `kernels`."""
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
    assert "kernels.lanes.schedule" in kernel._closure(["pendulum_kernels.integrate"])


_ONE_CELL = f"""
import numpy as np
from sweep.model.disk.model import DISK
from sweep.model.kernel import cache_folder
starts = np.array([[0.3], [0.2], [0.0], [4.0], [0.5], [0.5], [9.81]])
measures, counts = np.zeros((len(DISK.measures), 1)), np.zeros((len(DISK.counts), 1), np.int32)
kernel, compiled = DISK.integrate.load(), []
type(kernel).compiled = lambda entry, compile=type(kernel).compiled: compiled.append(entry) or compile(entry)
kernel(starts, np.array([300.0, 0.0, 1.48, 1e-8]), measures, counts)
tilt = measures[DISK.measures.index("tilt_max"), 0]
print(cache_folder(["{INTEGRATE}"]), repr(float(tilt)), int(not compiled), sep="\\n")
"""


def one_cell(tree, cache):
    """Run one cell in a process of its own: (cache folder, largest tilt, hits of the cache)."""
    env = os.environ | {"EULERDISK_CACHE_DIR": str(cache), "PYTHONPATH": str(tree)}
    run = subprocess.run(
        [sys.executable, "-c", _ONE_CELL], cwd=tree, env=env, capture_output=True, text=True, check=True
    )
    folder, tilt, hits = run.stdout.split("\n")[:3]
    return folder, float(tilt), int(hits)


@pytest.mark.compiled
def test_an_edited_kernel_is_compiled_anew(tmp_path):
    """An edit in a file that the entry point only imports gives a new answer, though the cache folder is shared."""
    cache = os.environ["EULERDISK_CACHE_DIR"]
    before = one_cell(CHECKOUT, cache)
    tree = copy_of_the_project(tmp_path / "copy")
    equations = tree / "kernels" / "disk" / "equations.py"
    source = equations.read_text()
    equations.write_text(source.replace("unit * tilt_rate,", "3.0 * unit * tilt_rate,"))
    after = one_cell(tree, cache)
    shutil.rmtree(after[0])
    assert Path(after[0]).parent == Path(before[0]).parent
    assert after[0] != before[0]
    assert after[1] > before[1] + 1e-3
    assert after[2] == 0
    # the first answer is still there, and found without compiling
    assert one_cell(CHECKOUT, cache) == (*before[:2], 1)


def test_the_cache_folder_is_named_after_all_that_matters(tmp_path, monkeypatch):
    """The folder is the wanted one and holds the hash of the sources and the versions of the compilers."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    folder = cache_folder([INTEGRATE])
    assert folder.parent == tmp_path
    assert folder.name.startswith(code_hash([INTEGRATE])[:16])
    assert f"numba{numba.__version__}-llvmlite" in folder.name
    assert cache_folder(["kernels.disk.contact"]) != folder
    monkeypatch.delenv("EULERDISK_CACHE_DIR")
    assert "eulerdisk" in str(cache_folder([INTEGRATE]))


def test_a_kernel_is_loaded_once(tmp_path, monkeypatch):
    """The functions that it names are kept on disk, in the folder of their module; it is the same each time."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "loaded_once.py").write_text("def run(): pass\ndef first(): pass\ndef second(): pass\n")
    monkeypatch.syspath_prepend(tmp_path)
    one = Kernel("loaded_once", "run", ("loaded_once:first", "loaded_once:second"))
    assert one.load() is one.load() is sys.modules["loaded_once"].run
    loaded = sys.modules["loaded_once"]
    for function in (loaded.first, loaded.second):
        assert function.source.__self__._folder == cache_folder(["loaded_once"])
    assert not hasattr(loaded.run, "source")
    Kernel("loaded_once", "run").load()
    assert loaded.run.source.__self__._folder == cache_folder(["loaded_once"])


@pytest.mark.compiled
def test_without_a_cache_the_kernel_is_compiled(tmp_path):
    """A cache folder that cannot be made costs the compilation and nothing else: same answer, no complaint."""
    occupied = tmp_path / "file"
    occupied.write_text("a file where the folder should be")
    found = one_cell(CHECKOUT, occupied / "cache")
    assert found[1:] == (one_cell(CHECKOUT, os.environ["EULERDISK_CACHE_DIR"])[1], 0)
    assert not found[0].startswith(os.environ["EULERDISK_CACHE_DIR"])
    assert occupied.read_text() == "a file where the folder should be"


def test_a_cache_that_holds_nothing_is_refused(tmp_path, monkeypatch):
    """If the kernels that were used are not kept, they will be compiled each time: the folder is named."""
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path))
    used = [DISK.integrate, EXTREMES]
    # what another version has kept is no use
    folders = [tmp_path / "another version", *(cache_folder([each.module]) for each in used)]
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
Kernel("kernels.rounding", "probe").load()
print(workers.used())
workers.use(5)
print(workers.used())
"""


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="a system without affinity")
@pytest.mark.parametrize(
    ("quota", "named", "expected"),
    [("max 100000", "", 8), ("250000 100000", "", 3), ("max 100000", "2", 2), ("250000 100000", "6", 3)],
)
def test_threads_that_nobody_chose(quota, named, expected):
    """One per processor of the affinity, as many as the CPU quota allows, NUMBA_NUM_THREADS at most."""
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_NUM_THREADS"}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", _USED, quota],
        env={**environment, "PYTHONPATH": str(CHECKOUT), **({"NUMBA_NUM_THREADS": named} if named else {})},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.split() == [str(expected), "5"], done.stderr
