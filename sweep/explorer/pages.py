"""The files of the page: a fixed list, read when the server starts."""

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable

#: File extension -> content type; other files are not served.
_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".woff2": "font/woff2",
    ".wasm": "application/wasm",
}

_IMPORT_MAP = re.compile(rb'<script type="importmap">(.*?)</script>', re.DOTALL)

#: The page itself, and the kernels with which it computes.
INDEX, KERNELS = "index.html", "kernels.wasm"


@dataclass(frozen=True)
class PageFile:
    """A file of the page: its content type and its bytes."""

    kind: str
    content: bytes


def page_files(kernels: bytes | None = None) -> dict[str, PageFile]:
    """Return the files of the page by their paths in its folder, with ``/`` as separator.

    Parameters
    ----------
    kernels : bytes, optional
        The page's WebAssembly module, if it is not the disk's.
    """
    found = dict(_find_files(files("sweep.explorer") / "page", ""))
    if kernels is not None:
        found[KERNELS] = PageFile(_TYPES[".wasm"], kernels)
    return found | {
        INDEX: with_imports(found[INDEX], {name: f"./page/{path}" for name, path in modules(found).items()})
    }


def modules(pages: Iterable[str]) -> dict[str, str]:
    """Return a mapping from the names by which the modules import each other to their paths.

    The name of ``motion/clock.js`` is ``eulerdisk/motion/clock``, the name of ``vendor/three.core.js`` is
    ``three/core``.
    """
    return {
        path.removeprefix("vendor/").removesuffix(".js").replace(".", "/")
        if path.startswith("vendor/")
        else f"eulerdisk/{path.removesuffix('.js')}": path
        for path in pages
        if path.endswith(".js")
    }


def with_imports(index: PageFile, addresses: Mapping[str, str]) -> PageFile:
    """Return the page with the addresses of its modules, by name, in its import map."""
    text = json.dumps({"imports": dict(addresses)}, separators=(",", ":"))
    written = f'<script type="importmap">{text}</script>'.encode()
    return PageFile(index.kind, _IMPORT_MAP.sub(lambda _: written, index.content))


def _find_files(folder: Traversable, path: str) -> list[tuple[str, PageFile]]:
    found: list[tuple[str, PageFile]] = []
    for each in sorted(folder.iterdir(), key=lambda entry: entry.name):
        ending = each.name[each.name.rfind(".") :]
        if each.is_dir():
            found += _find_files(each, f"{path}{each.name}/")
        elif ending in _TYPES:
            found.append((path + each.name, PageFile(_TYPES[ending], each.read_bytes())))
    return found


def content_policy(index: bytes, *, framed: bool) -> str:
    """Return the Content-Security-Policy of the page.

    It forbids other origins, and all inline scripts except the import map.

    Parameters
    ----------
    index : bytes
        The page, including its import map.
    framed : bool
        Whether a notebook on this machine may show the page in a frame.
    """
    maps = (base64.b64encode(hashlib.sha256(each).digest()).decode() for each in _IMPORT_MAP.findall(index))
    scripts = " ".join(["'self'", "'wasm-unsafe-eval'", *(f"'sha256-{each}'" for each in maps)])
    frames = "'self' http://localhost:* http://127.0.0.1:*" if framed else "'none'"
    return (
        f"default-src 'self'; script-src {scripts}; img-src 'self' data: blob:; worker-src 'self' blob:; "
        f"object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors {frames}"
    )
