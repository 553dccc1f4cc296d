"""The compiled functions of models: imported when first used, and kept on disk under a key made of their code.

The folder of the cache is named after the code of every module that a function is made of, comments and docstrings
aside: after an edit of any of them the old code is not found. What is in it is checked before it is loaded
(`kernels.native.cache`).
"""

import ast
import hashlib
import os
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.metadata import version
from importlib.util import find_spec, resolve_name
from pathlib import Path
from typing import Any

from sweep import platforms
from sweep.atomic import publish_bytes
from sweep.errors import RequestError, SurroundingsWarning, shown
from sweep.notices import notice

_CACHE = "kernels.native.cache"


@dataclass(frozen=True)
class Kernel:
    """A compiled function that is imported when it is first needed.

    Parameters
    ----------
    module, function : str
        Where it stands.
    cached : tuple of str, optional
        The entry points (`kernels.native.entry`) that are kept on disk, each as ``module:function``; the function
        itself if none is named. A function that is plain Python and calls compiled ones names those.
    seconds : float, optional
        About how long compiling all of them takes, for the notice of it.
    told : str, optional
        What the notice calls it; module and function if not given.
    """

    module: str
    function: str
    cached: tuple[str, ...] = ()
    seconds: float = 5.0
    told: str = ""

    def load(self) -> Callable[..., Any]:
        """Return the function, kept on disk where the cache folder can be written."""
        return _loaded(self)

    def make_ready(self) -> None:
        """Load every entry point, and compile what is not kept on disk."""
        self.load()
        for _, entry in self._entries():
            entry.make_ready()

    def _entries(self) -> Iterator[tuple[str, Any]]:
        """Yield the module that binds an entry point, and the entry point, which may name another one as its own."""
        for name in self.cached or (f"{self.module}:{self.function}",):
            module, _, function = name.partition(":")
            yield module, getattr(import_module(module), function)


@lru_cache
def _loaded(kernel: Kernel) -> Callable[..., Any]:
    _check_vectors()
    platforms.warn_of_processor()
    import_module("kernels.native.workers").use_usually(platforms.usual_threads())
    found: Callable[..., Any] = getattr(import_module(kernel.module), kernel.function)
    # one notice for all entry points of the kernel
    announce = lru_cache(partial(_announce, kernel))
    for module, entry in kernel._entries():
        folder = _usable_folder(cache_folder([module]))
        entry.source = import_module(_CACHE).KernelCache(folder, _publish, announce).machine_code
    return found


def kept_bytes(name: str, modules: Iterable[str], key: str, make: Callable[[], bytes]) -> bytes:
    """Return bytes that are made of the code of modules: kept on disk beside compiled functions, or made.

    Parameters
    ----------
    name : str
        The file is named after it.
    modules : iterable of str
        The code that they are made of, as of `code_hash`.
    key : str
        What else decides them.
    make : callable
    """
    cache = import_module(_CACHE).KernelCache(_usable_folder(cache_folder(modules)), _publish, lambda: None)
    found: bytes = cache.bytes_of(name, key, make)
    return found


def is_compiling() -> bool:
    """Return whether this process compiles now, in any of its threads."""
    cache = sys.modules.get(_CACHE)
    return bool(cache and cache.compiling)


def _check_vectors() -> None:
    given = os.environ.get("EULERDISK_VECTOR_BITS", "")
    if given not in ("", "128", "256", "512"):
        raise RequestError(
            f"The environment variable EULERDISK_VECTOR_BITS must be 128, 256 or 512; got {shown(given)!r}.",
            hint="Run `unset EULERDISK_VECTOR_BITS`.",
            where="EULERDISK_VECTOR_BITS",
        )


def _announce(kernel: Kernel) -> None:
    # a module may have several, as for each set of laws of losses
    named = kernel.told or (
        kernel.module
        if kernel.module.endswith(f".{kernel.function}")
        else f"{kernel.module}.{kernel.function}"
    )
    kept = "to" if _usable_folder(cache_folder([kernel.module])) else "cannot"
    what = f"compiling {named} for this processor takes about {kernel.seconds:.0f} s"
    notice(f"{what}; {kept} be kept in {cache_root()}")


def _publish(path: Path, content: bytes) -> None:
    """Write a file of the cache; a file system that refuses costs the next compilation."""
    try:
        # not by the umask alone: see `_usable_folder`
        publish_bytes(path, content, mode=0o644)
    except OSError as problem:
        warnings.warn(
            f"A compiled kernel could not be kept in {path.parent}, and will be compiled again: {problem}. Set "
            "EULERDISK_CACHE_DIR to a folder that can be written.",
            SurroundingsWarning,
            stacklevel=2,
        )


@lru_cache
def _usable_folder(folder: Path) -> Path | None:
    """Return a folder in the folder of all caches, made if it is not there; None if it must not be used.

    A warning says why others could write what would be executed here. A folder that cannot be made costs the
    compilation of this process, and nothing else.
    """
    cache, root = import_module(_CACHE), folder.parent
    try:
        root.parent.mkdir(parents=True, exist_ok=True)
        for each in (root, folder):
            # not by the umask alone: under 002, usual where each user has a group, every folder could be written by it
            each.mkdir(mode=0o755, exist_ok=True)
        # the root first: what is wrong with it is told once, not for every kernel
        place, problem = root, cache.problem_of(os.stat(root), sticky_is_safe=True)
        if not problem:
            place, problem = folder, cache.problem_of(os.lstat(folder))
    except OSError:
        return None
    if problem:
        warnings.warn(
            f"The cache of compiled kernels is not used, because it {problem}, and what is in it would be executed: "
            f"{place}. The kernels are compiled anew by each process. Run `chmod -R go-w` on a folder of your own, or "
            "set EULERDISK_CACHE_DIR to another one.",
            SurroundingsWarning,
            stacklevel=2,
        )
        return None
    return folder if os.access(folder, os.W_OK | os.X_OK) or any(folder.glob(f"*{cache.ENDING}")) else None


def chunk_cells() -> int:
    """Return how many cells of a kernel one thread takes at a time."""
    return int(import_module("kernels.lanes.schedule").CHUNK)


def code_hash(code: Iterable[str | Callable[..., Any]], *more: str) -> str:
    """Return the SHA-256, in hexadecimal, of code: what it computes, not how it is explained.

    Parameters
    ----------
    code : iterable of str or callable
        Names of modules, each of which counts with all that it imports from its own package and from `kernels` (of a
        module of `sweep` its own code alone counts); and functions, each of which counts alone.
    *more : str
        What else decides the bits.
    """
    names = (each if isinstance(each, str) else f"{each.__module__}:{each.__qualname__}" for each in code)
    digest = hashlib.sha256()
    for name, text in sorted(closure(names).items()):
        digest.update(f"{name}\0{text}\0".encode())
    digest.update("\0".join(more).encode())
    return digest.hexdigest()


def closure(names: Iterable[str]) -> dict[str, str]:
    """Return each function, each module, and all that the modules import from their package and `kernels`: its code."""
    found: dict[str, str] = {}
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        module, _, function = name.partition(":")
        spec = _spec(module)
        if name in found or spec is None or spec.origin is None:
            continue
        package = name.partition(".")[0]
        source = Path(spec.origin).read_text(encoding="utf-8")
        found[name], imported = _significant(source, function, spec.parent or "", (package, "kernels"))
        if not function and package != "sweep":
            waiting += imported
    return found


@lru_cache(maxsize=1024)
def _significant(
    source: str, function: str, package: str, packages: tuple[str, ...]
) -> tuple[str, tuple[str, ...]]:
    """Return the code of a source, or of one function in it, without comments and docstrings; and what it imports."""
    tree: ast.AST = ast.parse(source)
    for part in filter(None, function.split(".")):
        tree = next(each for each in getattr(tree, "body", ()) if getattr(each, "name", None) == part)
    imported = list[str]()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            first = node.body[0] if node.body else None
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                del node.body[0]
        elif isinstance(node, ast.Import):
            imported += (each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            origin = resolve_name("." * node.level + (node.module or ""), package)
            imported.append(origin)
            found = _spec(origin) if origin.partition(".")[0] in packages else None
            if found is not None and found.submodule_search_locations is not None:
                imported += (f"{origin}.{each.name}" for each in node.names)
    return ast.unparse(tree), tuple(each for each in imported if each.partition(".")[0] in packages)


@lru_cache
def _spec(module: str) -> ModuleSpec | None:
    try:
        return find_spec(module)
    except ModuleNotFoundError:
        return None


def cache_root() -> Path:
    """Return the folder of all caches: $EULERDISK_CACHE_DIR, or that of this user."""
    named = os.environ.get("EULERDISK_CACHE_DIR")
    return Path(named) if named else platforms.cache_home()


def cache_folder(modules: Iterable[str]) -> Path:
    """Return the folder of the compiled functions that are made of these modules."""
    versions = "-".join(f"{name}{version(name)}" for name in ("numba", "llvmlite"))
    return cache_root() / f"{code_hash(modules)[:16]}-{versions}"


def check_cache(kernels: Iterable[Kernel]) -> None:
    """Refuse a cache that does not hold kernels after they have been used.

    Raises
    ------
    RequestError
    """
    ending = import_module(_CACHE).ENDING
    modules = {module for kernel in kernels for module, _ in kernel._entries()}
    if not all(any(cache_folder([module]).glob(f"*{ending}")) for module in modules):
        raise RequestError(
            f"The compiled kernels could not be kept in {cache_root()}. The folder must be writable, by this user "
            "alone, and NUMBA_DISABLE_JIT must not be set.",
            hint="Set EULERDISK_CACHE_DIR to a folder that can be written.",
            where="cache",
        )
