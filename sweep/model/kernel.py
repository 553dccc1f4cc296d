"""The compiled functions of models: imported on first use, and cached on disk under a key made from their code.

The cache folder is named after the hash of all modules of a function, without comments and docstrings: after an edit
the old machine code is not found. The owner and the checksum of a file are checked before it is loaded
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
        Its module and its name there.
    cached : tuple of str, optional
        The entry points (`kernels.native.entry`) that are cached on disk, each as ``module:function``; by default the
        function itself. A plain Python function names the compiled functions that it calls.
    seconds : float, optional
        Approximate time to compile all of them, for the notice.
    told : str, optional
        Its name in the notice; by default module and function.
    """

    module: str
    function: str
    cached: tuple[str, ...] = ()
    seconds: float = 5.0
    told: str = ""

    def load(self) -> Callable[..., Any]:
        """Return the function; its machine code is cached on disk if the cache folder is writable."""
        return _loaded(self)

    def make_ready(self) -> None:
        """Load every entry point, and compile those that are not cached on disk."""
        self.load()
        for _, entry in self._entries():
            entry.make_ready()

    def _entries(self) -> Iterator[tuple[str, Any]]:
        """Yield each entry point after the module that binds it, which may differ from the module that defines it."""
        for name in self.cached or (f"{self.module}:{self.function}",):
            module, _, function = name.partition(":")
            yield module, getattr(import_module(module), function)


@lru_cache
def _loaded(kernel: Kernel) -> Callable[..., Any]:
    _check_vectors()
    platforms.warn_of_processor()
    import_module("kernels.native.workers").use_usually(platforms.usual_threads())
    function: Callable[..., Any] = getattr(import_module(kernel.module), kernel.function)
    # one notice for all entry points of the kernel
    announce = lru_cache(partial(_announce, kernel))
    for module, entry in kernel._entries():
        folder = _usable_folder(cache_folder([module]))
        entry.source = import_module(_CACHE).KernelCache(folder, _publish, announce).machine_code
    return function


def kept_bytes(name: str, modules: Iterable[str], key: str, make: Callable[[], bytes]) -> bytes:
    """Return bytes that depend on the code of modules: read from the kernel cache, or made.

    Parameters
    ----------
    name : str
        The start of the file name.
    modules : iterable of str
        The modules that the bytes depend on, as in `code_hash`.
    key : str
        Everything else that the bytes depend on.
    make : callable
    """
    cache = import_module(_CACHE).KernelCache(_usable_folder(cache_folder(modules)), _publish, lambda: None)
    content: bytes = cache.bytes_of(name, key, make)
    return content


def is_compiling() -> bool:
    """Return whether any thread of this process is compiling."""
    cache = sys.modules.get(_CACHE)
    return bool(cache and cache.compiling)


def _check_vectors() -> None:
    bits = os.environ.get("EULERDISK_VECTOR_BITS", "")
    if bits not in ("", "128", "256", "512"):
        raise RequestError(
            f"The environment variable EULERDISK_VECTOR_BITS must be 128, 256 or 512; got {shown(bits)!r}.",
            hint="Run `unset EULERDISK_VECTOR_BITS`.",
            where="EULERDISK_VECTOR_BITS",
        )


def _announce(kernel: Kernel) -> None:
    # a module may have several kernels, for example one for each set of loss laws
    name = kernel.told or (
        kernel.module
        if kernel.module.endswith(f".{kernel.function}")
        else f"{kernel.module}.{kernel.function}"
    )
    is_cached = _usable_folder(cache_folder([kernel.module])) is not None
    work = f"compiling {name} for this processor takes about {kernel.seconds:.0f} s"
    notice(f"{work}; {'it will' if is_cached else 'it cannot'} be kept in {cache_root()}")


def _publish(path: Path, content: bytes) -> None:
    """Write a file of the cache; if that fails, warn: the next process has to compile again."""
    try:
        # an explicit mode, whatever the umask: see `_usable_folder`
        publish_bytes(path, content, mode=0o644)
    except OSError as problem:
        warnings.warn(
            f"A compiled kernel could not be kept in {path.parent}, and will be compiled again: {problem}. Set "
            "EULERDISK_CACHE_DIR to a writable folder.",
            SurroundingsWarning,
            stacklevel=2,
        )


@lru_cache
def _usable_folder(folder: Path) -> Path | None:
    """Create a folder in the folder of all caches if it does not exist, and return it; None if it must not be used.

    Warns if other users could write the code that would be executed from there. If the folder cannot be created, this
    process compiles its kernels; nothing else changes.
    """
    cache, root = import_module(_CACHE), folder.parent
    try:
        root.parent.mkdir(parents=True, exist_ok=True)
        for path in (root, folder):
            # an explicit mode: with umask 002, usual where each user has a group, the group could write every folder
            path.mkdir(mode=0o755, exist_ok=True)
        # the root first: its problem is reported once, not for every kernel
        place, problem = root, cache.problem_of(os.stat(root), sticky_is_safe=True)
        if not problem:
            place, problem = folder, cache.problem_of(os.lstat(folder))
    except OSError:
        return None
    if problem:
        warnings.warn(
            f"The cache of compiled kernels is not used, because {place} {problem}, and its files would be executed. "
            "Each process compiles the kernels again. If the folder is yours, run `chmod -R go-w` on it; otherwise set "
            "EULERDISK_CACHE_DIR to another folder.",
            SurroundingsWarning,
            stacklevel=2,
        )
        return None
    return folder if os.access(folder, os.W_OK | os.X_OK) or any(folder.glob(f"*{cache.ENDING}")) else None


def chunk_cells() -> int:
    """Return how many cells a thread of a kernel takes at a time."""
    return int(import_module("kernels.lanes.schedule").CHUNK)


def code_hash(code: Iterable[str | Callable[..., Any]], *more: str) -> str:
    """Return the SHA-256, in hexadecimal, of code without its comments and docstrings.

    Parameters
    ----------
    code : iterable of str or callable
        Names of modules, and functions. A module is hashed with everything that it imports from its own package and
        from `kernels`; a module of `sweep`, or a function, without its imports.
    *more : str
        Everything else that determines the bits.
    """
    names = (item if isinstance(item, str) else f"{item.__module__}:{item.__qualname__}" for item in code)
    digest = hashlib.sha256()
    for name, text in sorted(closure(names).items()):
        digest.update(f"{name}\0{text}\0".encode())
    digest.update("\0".join(more).encode())
    return digest.hexdigest()


def closure(names: Iterable[str]) -> dict[str, str]:
    """Return the code of functions, of modules, and of all that the modules import from their package and `kernels`."""
    texts: dict[str, str] = {}
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        module, _, function = name.partition(":")
        spec = _spec(module)
        if name in texts or spec is None or spec.origin is None:
            continue
        package = name.partition(".")[0]
        source = Path(spec.origin).read_text(encoding="utf-8")
        texts[name], imported = _significant(source, function, spec.parent or "", (package, "kernels"))
        if not function and package != "sweep":
            waiting += imported
    return texts


@lru_cache(maxsize=1024)
def _significant(
    source: str, function: str, package: str, packages: tuple[str, ...]
) -> tuple[str, tuple[str, ...]]:
    """Return the code of a source, or of one function in it, without comments and docstrings; and its imports."""
    tree: ast.AST = ast.parse(source)
    for part in filter(None, function.split(".")):
        tree = next(node for node in getattr(tree, "body", ()) if getattr(node, "name", None) == part)
    imported = list[str]()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            first = node.body[0] if node.body else None
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                del node.body[0]
        elif isinstance(node, ast.Import):
            imported += (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            origin = resolve_name("." * node.level + (node.module or ""), package)
            imported.append(origin)
            spec = _spec(origin) if origin.partition(".")[0] in packages else None
            if spec is not None and spec.submodule_search_locations is not None:
                imported += (f"{origin}.{alias.name}" for alias in node.names)
    return ast.unparse(tree), tuple(name for name in imported if name.partition(".")[0] in packages)


@lru_cache
def _spec(module: str) -> ModuleSpec | None:
    try:
        return find_spec(module)
    except ModuleNotFoundError:
        return None


def cache_root() -> Path:
    """Return the folder of all caches: $EULERDISK_CACHE_DIR, or the user's cache folder."""
    folder = os.environ.get("EULERDISK_CACHE_DIR")
    return Path(folder) if folder else platforms.cache_home()


def cache_folder(modules: Iterable[str]) -> Path:
    """Return the cache folder of the functions that are compiled from these modules."""
    versions = "-".join(f"{name}{version(name)}" for name in ("numba", "llvmlite"))
    return cache_root() / f"{code_hash(modules)[:16]}-{versions}"


def check_cache(kernels: Iterable[Kernel]) -> None:
    """Check that the cache contains kernels that have been used.

    Raises
    ------
    RequestError
    """
    ending = import_module(_CACHE).ENDING
    modules = {module for kernel in kernels for module, _ in kernel._entries()}
    if not all(any(cache_folder([module]).glob(f"*{ending}")) for module in modules):
        raise RequestError(
            f"The compiled kernels could not be kept in {cache_root()}. Only this user may be able to write to the "
            "folder, and NUMBA_DISABLE_JIT must not be set.",
            hint="Set EULERDISK_CACHE_DIR to a writable folder.",
            where="cache",
        )
