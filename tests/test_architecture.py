"""Checks of the layout: import contracts, names, the content of kernels, and what loading a request loads."""

import ast
import importlib
import os
import re
import subprocess
import sys
from collections.abc import Collection, Iterator
from pathlib import Path

import grimp
import pytest
from importlinter.api import read_configuration
from importlinter.cli import lint_imports

CHECKOUT = Path(__file__).resolve().parents[1]
PYPROJECT = str(CHECKOUT / "pyproject.toml")
CONTRACTS = {contract["id"]: contract for contract in read_configuration(PYPROJECT)["contracts_options"]}
SOURCES = sorted(
    path for folder in ("kernels", "sweep", "scripts", "tests") for path in (CHECKOUT / folder).rglob("*.py")
)
#: The compiled modules; `kernels.native` is the Python code around them.
COMPILED = sorted(
    path for path in (CHECKOUT / "kernels").rglob("*.py") if path.parent != CHECKOUT / "kernels" / "native"
)
PAGES = sorted([*CHECKOUT.glob("*.md"), *(CHECKOUT / "docs").glob("*.md")])
#: Paths and dotted names of the project, as pages and docstrings spell them.
PATH_NAME = re.compile(r"(?<![\w./-])((?:kernels|sweep|scripts|tests|docs)/[\w./-]*\w)(?:::(\w+))?")
DOTTED_NAME = re.compile(r"(?<![\w./-])(?:kernels|sweep)(?:\.[A-Za-z_]\w*)+(?![\w/-])")
#: Files written by commands of the gallery, and the script that docs/extend.md adds.
WRITTEN = (
    "docs/atlases",
    "docs/losses.nc",
    "docs/motion.nc",
    "docs/alphas.nc",
    *(f"docs/{name}.nc" for name in ("driven_pendulum", "henon_heiles", "kapitza", "magnets", "thomas")),
    "docs/random-",
    "scripts/plot_falls.py",
)
DRAWERS = {"utils", "util", "common", "helpers", "helper", "core", "misc", "lib", "tools"}
HEAVY = {"numba", "scipy", "xarray", "netCDF4", "pandas", "matplotlib", "typer", "rich"}


def named(path: Path) -> str:
    """Return the path relative to the checkout."""
    return str(path.relative_to(CHECKOUT))


def text_of(path: Path) -> str:
    """Return the text of a page, or the docstrings of a module."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return text
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    nodes = (node for node in ast.walk(ast.parse(text)) if isinstance(node, kinds))
    return "\n".join(ast.get_docstring(node) or "" for node in nodes)


def exists(name: str) -> bool:
    """Return whether a dotted name is a module, or a name in one."""
    module, members = name, list[str]()
    while not ((CHECKOUT / module.replace(".", "/")).with_suffix(".py").is_file() or is_package(module)):
        module, _, last = module.rpartition(".")
        members.insert(0, last)
    return not members or hasattr(importlib.import_module(module), members[0])


def is_package(name: str) -> bool:
    """Return whether a dotted name is a package of the project."""
    return (CHECKOUT / name.replace(".", "/") / "__init__.py").is_file()


def top_level_imports(path: Path) -> Iterator[str]:
    """Yield the distribution-level name of everything that a kernel file imports, at any depth."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "kernels" if node.level else str(node.module).partition(".")[0]


def loaded_by(*statements: str, beside: Collection[str] = ()) -> dict[str, set[str]]:
    """Return the heavy modules that each statement loads, run one after another in a fresh interpreter."""
    heavy = HEAVY | set(beside)
    report = "; print(*{name.partition('.')[0] for name in sys.modules})"
    done = subprocess.run(
        [
            sys.executable,
            "-W",
            "error",
            "-c",
            "\n".join(f"import sys; {each}{report}" for each in statements),
        ],
        cwd=CHECKOUT,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = [set(line.split()) & heavy for line in done.stdout.splitlines()]
    return {statement: loaded for statement, loaded in zip(statements, found, strict=True) if loaded}


def test_import_contracts(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    """Every import contract of pyproject.toml holds."""
    monkeypatch.chdir(CHECKOUT)
    status = lint_imports(PYPROJECT, no_cache=True, no_logo=True)
    if status != 0:
        pytest.fail(capsys.readouterr().out, pytrace=False)


def test_no_room_looks_up_to_the_face_of_the_package() -> None:
    """No module of the package imports the package itself, not even inside a function."""
    # The contracts only compare siblings, not the package above them.
    graph = grimp.build_graph("sweep", exclude_type_checking_imports=True, cache_dir=None)
    assert graph.find_modules_that_directly_import("sweep") == set()


def test_kernels_import_arithmetic_only() -> None:
    """A kernel module imports only math, numpy, typing (named tuples) and other kernels, so it loads fast."""
    for path in COMPILED:
        inside = {"numba"} if path.name in ("cuda.py", "intrinsics.py") else set()
        # The kernels of a system are named after its program.
        if path.name == "integrate.py" and path.parent.name == "system":
            inside |= {"json", "hashlib"}
        others = set(top_level_imports(path)) - {"math", "numpy", "typing", "kernels"} - inside
        assert not others, f"{named(path)} imports {others}"


@pytest.mark.slow_lane
def test_kernels_never_raise() -> None:
    """A kernel ends with a code: a raise inside a parallel loop would leave all later cells unwritten.

    Functions that create kernels or their layouts are exempt.
    """
    for path in COMPILED:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        tree.body = [
            node
            for node in tree.body
            if not (isinstance(node, ast.FunctionDef) and node.name in ("bind", "rebound_for", "place_rows"))
        ]
        lines = [node.lineno for node in ast.walk(tree) if isinstance(node, (ast.Raise, ast.Assert))]
        assert not lines, f"{named(path)} raises in lines {lines}"


def test_paths_say_what_they_are_for() -> None:
    """No module or folder has a catch-all name."""
    for path in SOURCES:
        parts = {part.strip("_") for part in path.relative_to(CHECKOUT).with_suffix("").parts}
        assert not parts & DRAWERS, named(path)


@pytest.mark.slow_lane
def test_what_a_text_names_exists() -> None:
    """Every path and dotted name in a page or docstring refers to an existing file, test or module."""
    missing = []
    for path in [*PAGES, *SOURCES]:
        text = text_of(path)
        for file, test in PATH_NAME.findall(text):
            if file.startswith(WRITTEN):
                continue
            there = (CHECKOUT / file).exists()
            if not there or (test and f"def {test}" not in (CHECKOUT / file).read_text(encoding="utf-8")):
                missing.append(f"{named(path)}: {file}{test and f'::{test}'}")
        missing += [f"{named(path)}: {name}" for name in DOTTED_NAME.findall(text) if not exists(name)]
    assert missing == []


def test_a_request_loads_light() -> None:
    """No module needed to read a request loads the compiler or the libraries for files and units."""
    graph = grimp.build_graph("sweep", cache_dir=None)
    rooms = CONTRACTS["light-request"]["source_modules"]
    modules = sorted({*rooms}.union(*(graph.find_descendants(room) for room in rooms)))
    assert loaded_by(*(f"import {module}" for module in modules)) == {}


def test_a_preset_is_read_light() -> None:
    """Reading a preset, its fingerprint and its code hash loads no heavy module either."""
    spec = "SweepSpec.preset('circling')"
    read = f"from sweep.request.spec import SweepSpec; {spec}.fingerprint()"
    hashed = f"from sweep.engine.compute import arithmetic_hash; arithmetic_hash({spec})"
    assert loaded_by(read, hashed) == {}


def test_kernels_load_light() -> None:
    """Entry points import without the compiler: a process with cached machine code does not need it."""
    names = sorted(str(path.relative_to(CHECKOUT).with_suffix("")).replace("/", ".") for path in COMPILED)
    modules = [name for name in names if not name.endswith(("__init__", ".cuda"))]
    assert loaded_by(*(f"import {module}" for module in modules), beside=["llvmlite"]) == {}


def test_the_command_line_loads_light() -> None:
    """The command line answers --help without the compiler, the file libraries and the figures."""
    assert loaded_by("import sweep.cli") == {}
