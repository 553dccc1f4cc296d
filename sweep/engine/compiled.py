"""The compiled kernels: found on disk under a key made of their sources, or compiled and put there.

Numba's own key for cached code sees only the file of the function itself: after an edit in another file the old
arithmetic would go on being run. So the folder of the cache is named after the hash of all kernel sources.
"""

import hashlib
import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import kernels
from sweep.errors import RequestError


@lru_cache
def kernel_hash() -> str:
    """Return the SHA-256, in hexadecimal, of all kernel sources."""
    digest = hashlib.sha256()
    folder = Path(kernels.__file__).parent
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def cache_folder() -> Path:
    """Return the folder of the compiled kernels: under $EULERDISK_CACHE_DIR, or the user's cache folder."""
    import llvmlite
    import numba
    import platformdirs

    root = os.environ.get("EULERDISK_CACHE_DIR") or platformdirs.user_cache_dir("eulerdisk", appauthor=False)
    return Path(root) / f"{kernel_hash()[:16]}-numba{numba.__version__}-llvmlite{llvmlite.__version__}"


@lru_cache
def integrate() -> Callable[..., None]:
    """Return `kernels.disk.integrate.integrate`, cached on disk where the cache folder can be written."""
    from kernels.disk import integrate as disk

    kernel: Callable[..., None] = disk.integrate
    _cache_on_disk(kernel)
    return kernel


@lru_cache
def extremes() -> Callable[..., tuple[Any, Any]]:
    """Return `kernels.disk.exact.extremes`, its kernels cached on disk where the cache folder can be written."""
    from kernels.disk.exact import extremes as exact
    from kernels.disk.exact import legendre

    found: Callable[..., tuple[Any, Any]] = exact.extremes
    for kernel in (legendre.build_tables, exact.reduce):
        _cache_on_disk(kernel)
    return found


@lru_cache
def trajectory() -> Callable[..., tuple[int, int, float, int]]:
    """Return `kernels.disk.trajectory.trajectory`, cached in the same way."""
    from kernels.disk import trajectory as path

    kernel: Callable[..., tuple[int, int, float, int]] = path.trajectory
    _cache_on_disk(kernel)
    return kernel


@lru_cache
def derived() -> Callable[..., None]:
    """Return `kernels.disk.trajectory.derived`, cached in the same way."""
    from kernels.disk import trajectory as path

    kernel: Callable[..., None] = path.derived
    _cache_on_disk(kernel)
    return kernel


@lru_cache
def contact_extremes() -> Callable[..., None]:
    """Return `kernels.disk.contact.contact_extremes`, cached in the same way."""
    from kernels.disk import contact

    kernel: Callable[..., None] = contact.contact_extremes
    _cache_on_disk(kernel)
    return kernel


@lru_cache
def coefficients() -> Callable[..., None]:
    """Return `kernels.disk.growth_rates.coefficients`, cached in the same way."""
    from kernels.disk import growth_rates as response

    kernel: Callable[..., None] = response.coefficients
    _cache_on_disk(kernel)
    return kernel


def check_cache() -> None:
    """Refuse a cache that holds nothing after the kernels have been used.

    Raises
    ------
    RequestError
    """
    if next(cache_folder().rglob("*.nbc"), None) is None:
        raise RequestError(
            "the compiled kernels could not be kept",
            "the folder of the cache can be written, and NUMBA_DISABLE_JIT is not set",
            str(cache_folder()),
            "set EULERDISK_CACHE_DIR to a folder that can be written",
            "cache",
        )


def _cache_on_disk(kernel: Any) -> None:
    import numba

    if numba.config.DISABLE_JIT:
        return
    folder = cache_folder()
    before = numba.config.CACHE_DIR
    try:
        folder.mkdir(parents=True, exist_ok=True)
        numba.config.CACHE_DIR = str(folder)
        kernel.enable_caching()
    except (OSError, RuntimeError):
        # an unwritable cache costs the compilation of this process, nothing else
        return
    finally:
        numba.config.CACHE_DIR = before
