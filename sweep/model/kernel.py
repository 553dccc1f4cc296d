"""The compiled functions of models: imported when first used, and kept on disk under a key made of their code.

The folder of the cache is named after the code of every module that a function is made of, comments and docstrings
aside: after an edit of any of them the old code is not found. What is in it is checked before it is loaded
(`sweep.model.kernel_cache`).
"""

import hashlib
import os
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.metadata import version
from importlib.util import find_spec, resolve_name
from pathlib import Path
from typing import Any

from sweep.errors import RequestError
from sweep.model import vector_width
from sweep.model.kernel_cache import ENDING, KernelCache, usable_folder
from sweep.model.second_process import SecondProcess, compiled_by_another
from sweep.notices import notice
from sweep.platforms import check_settings, usual_threads, warn_of_processor

#: What may hold a quote or a hash sign that means nothing: strings and comments.
_STRING_OR_COMMENT = re.compile(
    r'"""(?:[^\\]|\\.)*?"""'
    r"|'''(?:[^\\]|\\.)*?'''"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'(?:[^'\\\n]|\\.)*'"
    r"|#[^\n]*",
    re.DOTALL,
)
#: What follows a docstring: a new line that closes no bracket.
_NEW_LINE = re.compile(r"[ \t]*(?:#[^\n]*)?(?:\n\s*[^)\]},\s]|\s*\Z)")
_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)|import[ \t]+([^\n]*))", re.MULTILINE
)


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
    beside : tuple of str, optional
        Those of them that a second process compiles, in this order, while this one compiles the others: about half of
        the work.
    seconds : float, optional
        About how long compiling all of them takes in one process, for the notice of it.
    seconds_beside : float, optional
        The same with the second process.
    """

    module: str
    function: str
    cached: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    seconds: float = 5.0
    seconds_beside: float = 5.0

    def load(self) -> Callable[..., Any]:
        """Return the function, kept on disk where the cache folder can be written."""
        return _loaded(self)

    def make_ready(self) -> None:
        """Load every entry point, and compile what is not kept on disk: the share of the second process last."""
        self.load()
        for name in sorted(self._entries, key=self.beside.__contains__):
            _entry(name).make_ready()

    def keep(self) -> None:
        """Compile an entry point that is the function itself, unless it is kept on disk."""
        entry: Any = self.load()
        entry.source(entry)

    @property
    def _entries(self) -> tuple[str, ...]:
        return self.cached or (f"{self.module}:{self.function}",)


def _entry(name: str) -> Any:
    module, _, function = name.partition(":")
    return getattr(import_module(module), function)


_always_apart = False


def compile_apart() -> None:
    """From now on another process compiles what is not kept on disk, for kernels that are loaded later.

    Numba and LLVM take 90 MB once and up to 170 MB for each kernel, and hold up all threads of a process. Where nothing
    can be kept on disk, and where no other process can do it, this one compiles all the same.
    """
    global _always_apart
    _always_apart = True


@lru_cache
def _loaded(kernel: Kernel) -> Callable[..., Any]:
    check_settings()
    warn_of_processor()
    import_module("kernels.native.workers").use_usually(usual_threads())
    found: Callable[..., Any] = getattr(import_module(kernel.module), kernel.function)
    root = cache_root()
    names = kernel._entries
    folders = [usable_folder(root, cache_folder([name.partition(":")[0]]).name) for name in names]
    apart = _always_apart and all(folders)
    beside = () if apart else kernel.beside
    second = SecondProcess(beside)
    # one notice for all entry points of the kernel
    announce = lru_cache(partial(_announce, kernel, root, all(folders), second))
    for name, folder in zip(names, folders, strict=True):
        width = partial(vector_width.bits, root if folder else None)
        cache = KernelCache(folder, width, announce)
        if apart:
            _entry(name).source = partial(_made_apart, cache, root, announce, names)
        elif name in beside:
            _entry(name).source = partial(_made_beside, cache, second)
        else:
            _entry(name).source = cache.machine_code
    return found


def _made_apart(
    cache: KernelCache, root: Path, announce: Callable[[], None], names: tuple[str, ...], entry: Any
) -> Any:
    # without the width of vectors it is not known which file it would be
    if not (vector_width.is_known(root) and cache.holds(entry)):
        announce()
        compiled_by_another(names)
    return cache.machine_code(entry)


def _made_beside(cache: KernelCache, second: SecondProcess, entry: Any) -> Any:
    second.wait()
    return cache.machine_code(entry)


def _announce(kernel: Kernel, root: Path, kept: bool, second: SecondProcess) -> None:
    shared = kept and second.start()
    seconds = kernel.seconds_beside if shared else kernel.seconds
    # a module may have several, as for each set of laws of losses
    named = (
        kernel.module
        if kernel.module.endswith(f".{kernel.function}")
        else f"{kernel.module}.{kernel.function}"
    )
    what = f"compiling {named} for this processor takes about {seconds:.0f} s"
    notice(f"{what}; {'to' if kept else 'cannot'} be kept in {root}")


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
    for name, text in sorted(_closure(names).items()):
        digest.update(f"{name}\0{text}\0".encode())
    digest.update("\0".join(more).encode())
    return digest.hexdigest()


def _closure(names: Iterable[str]) -> dict[str, str]:
    """Return each function, each module, and all that the modules import from their package and `kernels`: its code."""
    found: dict[str, str] = {}
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        module, _, function = name.partition(":")
        spec = _spec(module)
        if name in found or spec is None or spec.origin is None:
            continue
        found[name] = significant(Path(spec.origin).read_text(encoding="utf-8"))
        packages = (name.partition(".")[0], "kernels")
        if function:
            found[name] = _definition(found[name], function)
        elif packages[0] != "sweep":
            waiting += _imported(found[name], spec.parent, packages)
    return found


def _definition(code: str, qualified_name: str) -> str:
    """Return the lines of one function of significant source: up to the next that is not indented further."""
    lines = code.splitlines()
    depth = [len(line) - len(line.lstrip()) for line in lines]
    first = -1
    for part in qualified_name.split("."):
        first = next(
            i for i, line in enumerate(lines) if i > first and re.match(rf"\s*(?:def|class) {part}\b", line)
        )
    after = (
        i for i in range(first + 1, len(lines)) if depth[i] <= depth[first] and lines[i].strip()[0] != ")"
    )
    return "\n".join(lines[first : next(after, len(lines))])


def _imported(code: str, parent: str | None, packages: tuple[str, ...]) -> Iterator[str]:
    """Yield the modules of some packages that a module imports; relative imports start from its package, `parent`."""
    for origin, members, whole in _IMPORT.findall(code.replace("\\\n", " ")):
        named = [each.split()[0] for each in (whole or members.strip("()")).split(",") if each.strip()]
        source = resolve_name(origin, parent) if origin else ""
        for each in [source] if origin else named:
            if each.partition(".")[0] in packages:
                yield each
        found = _spec(source) if source.partition(".")[0] in packages else None
        if found is not None and found.submodule_search_locations is not None:
            yield from (f"{source}.{each}" for each in named)


@lru_cache
def _spec(module: str) -> ModuleSpec | None:
    try:
        return find_spec(module)
    except ModuleNotFoundError:
        return None


@lru_cache(maxsize=1024)
def significant(source: str) -> str:
    """Return Python source without comments, docstrings and blank lines: what is left decides what it computes."""
    kept, after, before = list[str](), 0, ""
    for token in _STRING_OR_COMMENT.finditer(source):
        between, text = source[after : token.start()], token.group()
        kept.append(between)
        before = between.rstrip()[-1:] or before
        after = token.end()
        # a docstring is the first statement of a file, or stands after the colon of a function or class
        docstring = text.startswith('"""') and before in ("", ":") and _NEW_LINE.match(source, after)
        if not text.startswith("#") and not docstring:
            kept.append(text)
            before = text[-1]
    lines = "".join([*kept, source[after:]]).splitlines()
    return "\n".join(line.rstrip() for line in lines if line.strip())


def cache_root() -> Path:
    """Return the folder of all caches: $EULERDISK_CACHE_DIR, or the user's cache folder."""
    import platformdirs

    named = os.environ.get("EULERDISK_CACHE_DIR")
    return Path(named or platformdirs.user_cache_dir("eulerdisk", appauthor=False))


def cache_folder(modules: Iterable[str]) -> Path:
    """Return the folder of the compiled functions that are made of these modules."""
    versions = "-".join(f"{name}{version(name)}" for name in ("numba", "llvmlite"))
    key = f"{code_hash(modules)[:16]}-{versions}"
    return cache_root() / key


def check_cache(kernels: Iterable[Kernel]) -> None:
    """Refuse a cache that does not hold kernels after they have been used.

    Raises
    ------
    RequestError
    """
    if not all(any(cache_folder([kernel.module]).glob(f"*{ENDING}")) for kernel in kernels):
        raise RequestError(
            f"The compiled kernels could not be kept in {cache_root()}. The folder must be writable, by this user "
            "alone, and NUMBA_DISABLE_JIT must not be set.",
            hint="Set EULERDISK_CACHE_DIR to a folder that can be written.",
            where="cache",
        )
