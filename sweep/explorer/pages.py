"""The files of the page: a fixed list, read when the server starts."""

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable

#: Ending of a file -> its type; others are not sent.
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

#: The page that is shown, and the kernels that it computes with.
INDEX, KERNELS = "index.html", "kernels.wasm"


@dataclass(frozen=True)
class PageFile:
    """A file of the page: its type and its bytes."""

    kind: str
    content: bytes


def page_files(kernels: bytes | None = None) -> dict[str, PageFile]:
    """Return the files of the page by their paths in its folder, with ``/`` between parts.

    Parameters
    ----------
    kernels : bytes, optional
        Its module of WebAssembly, if it is another one than that of the disk.
    """
    found = dict(_found(files("sweep.explorer") / "page", ""))
    if kernels is not None:
        found[KERNELS] = PageFile(_TYPES[".wasm"], kernels)
    return found | {
        INDEX: with_imports(found[INDEX], {name: f"./page/{path}" for name, path in modules(found).items()})
    }


def modules(pages: Iterable[str]) -> dict[str, str]:
    """Return the paths of the modules by the names with which they import each other.

    ``motion/clock.js`` is ``eulerdisk/motion/clock``, and ``vendor/three.core.js`` is ``three/core``.
    """
    return {
        path.removeprefix("vendor/").removesuffix(".js").replace(".", "/")
        if path.startswith("vendor/")
        else f"eulerdisk/{path.removesuffix('.js')}": path
        for path in pages
        if path.endswith(".js")
    }


def with_imports(index: PageFile, addresses: Mapping[str, str]) -> PageFile:
    """Return the page with the addresses of its modules by their names."""
    text = json.dumps({"imports": dict(addresses)}, separators=(",", ":"))
    written = f'<script type="importmap">{text}</script>'.encode()
    return PageFile(index.kind, _IMPORT_MAP.sub(lambda _: written, index.content))


def _found(folder: Traversable, path: str) -> list[tuple[str, PageFile]]:
    found: list[tuple[str, PageFile]] = []
    for each in sorted(folder.iterdir(), key=lambda entry: entry.name):
        ending = each.name[each.name.rfind(".") :]
        if each.is_dir():
            found += _found(each, f"{path}{each.name}/")
        elif ending in _TYPES:
            found.append((path + each.name, PageFile(_TYPES[ending], each.read_bytes())))
    return found


def content_policy(index: bytes, *, framed: bool) -> str:
    """Return the Content-Security-Policy of the page: nothing from elsewhere, no script within it but its import map.

    Parameters
    ----------
    index : bytes
        The page, with its import map.
    framed : bool
        Whether a notebook of this machine may show it in a frame.
    """
    maps = (base64.b64encode(hashlib.sha256(each).digest()).decode() for each in _IMPORT_MAP.findall(index))
    scripts = " ".join(["'self'", "'wasm-unsafe-eval'", *(f"'sha256-{each}'" for each in maps)])
    frames = "'self' http://localhost:* http://127.0.0.1:*" if framed else "'none'"
    return (
        f"default-src 'self'; script-src {scripts}; img-src 'self' data: blob:; worker-src 'self' blob:; "
        f"object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors {frames}"
    )
