"""The page as one HTML file that needs no server: its modules, its style, the kernels, and the cells of an atlas.

The file contains the kernels as deflated WebAssembly in ``<script type="text/plain" id="kernels">``, and JSON in
``<script type="application/json" id="stored">``, whose type is StoredPage in the page's types.js:

``about``
    The result of `sweep.explorer.about.about`, with one base.
``plans``
    The result of `sweep.explorer.plan.plan`: how the page computes cells and motions.
``lines``
    The result of `sweep.explorer.lines.lines`.
``stored``
    For an atlas: ``x``, ``y``, the values of the cells along both sides, f8; ``cells``, for every cell, with x fastest
    and y increasing: each quantity that ``about`` lists (f4, or codes as u1), ``verdict`` (u1), and every parameter
    that cells compute themselves (f8), such as a steady rate; ``starts``, the other parameters.

An array is ``{"type": ..., "data": ...}``: its little-endian bytes, deflated by zlib, in base64.
"""

import base64
import json
import re
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atomic import publish_bytes
from sweep.errors import RequestError
from sweep.explorer.about import about, base_of
from sweep.explorer.explorer import Subject
from sweep.explorer.lines import lines
from sweep.explorer.own_module import kernels_of
from sweep.explorer.pages import INDEX, KERNELS, PageFile, modules, page_files, with_imports
from sweep.explorer.plan import plan
from sweep.explorer.stored import Stored
from sweep.explorer.view import View
from sweep.files.paths import check_target
from sweep.request.sources import Range
from sweep.request.spec import SweepSpec
from sweep.request.values import as_written

#: Largest number of cells in a page: some 30 MB of text, or twice that with paths.
MOST_CELLS = 1_000_000

#: The page loads nothing: its modules are in the file, as data addresses.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' data:; worker-src blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"
)

_STYLE = re.compile(r'<link rel="stylesheet" href="\./page/([^"]+)" ?/?>')
_MAIN = re.compile(r'<script type="module" src="\./page/([^"]+)"></script>')


def _continue() -> None:
    """Continue."""


def export(
    subject: Subject, path: Path, *, overwrite: bool = False, check: Callable[[], None] = _continue
) -> None:
    """Write the page, with the cells of an atlas if there is one. The file appears only when it is complete.

    Parameters
    ----------
    subject : Subject
        An atlas, or a spec whose cells the page computes.
    path : Path
        File name, which ends in .html.
    overwrite : bool
        Whether to replace a file of that name.
    check : callable
        Called from time to time before the file appears; an exception that it raises ends the work.

    Raises
    ------
    RequestError
        If the file name is invalid, or the atlas has too many cells.
    StorageError
        If the file system refuses to write.
    """
    from sweep.files.publish import refusals

    if path.suffix.lower() not in (".html", ".htm"):
        raise RequestError(
            f"An exported page must be an HTML file; got {path}.",
            hint=f"Write {path.stem}.html.",
            where="--export",
        )
    check_target(path, overwrite)
    held = held_page(subject, check)
    content = page_of(held, page_files(kernels_of(subject.spec))).encode()
    check()
    with refusals(path.absolute(), lambda: float(len(content))):
        publish_bytes(path.absolute(), content)


def _check_plane(spec: SweepSpec) -> View:
    """Return the view of the whole plane of a spec.

    Raise an error unless it has two axes and the page can compute its cells.
    """
    view = View.read(base_of("", spec)["view"], spec)
    if not {view.x.name, view.y.name} <= set(spec.axes):
        free = next(side for side in (view.y, view.x) if side.name not in spec.axes)
        window = Range(*free.ends(), 100)
        raise RequestError(
            f"An exported page needs two axes; this request has {', '.join(spec.axes) or 'none'}.",
            hint=f"Add a range, as in {free.name}={as_written(window, spec.model.parameters[free.name])}.",
            where="--export",
        )
    view.live  # noqa: B018 - raises an error if cells cannot be computed
    return view


def held_page(subject: Subject, check: Callable[[], None] = _continue) -> dict[str, Any]:
    """Return the contents of the page; see the module, and `export` for `check`.

    Raises
    ------
    RequestError
        If the plane of an atlas has too many cells, or the cells of a spec cannot be computed.
    """
    spec, stored = subject.spec or SweepSpec.preset("rolling"), subject.stored
    view = _check_plane(spec) if stored is None else View.read(base_of("", spec)["view"], spec)
    known = about(spec, stored)
    bases = [each for each in known["bases"] if not each["name"]]
    words = {word for each in bases for word in each["words"].values() if isinstance(word, str)}
    return {
        "about": {
            **known,
            "bases": bases,
            "others": [],
            "quantities": [each for each in known["quantities"] if each["name"] in bases[0]["quantities"]],
            # only the program can interpret words
            "parameters": [
                {**each, "words": [word for word in each["words"] if word in words]}
                for each in known["parameters"]
            ],
            "criteria": [],
        },
        "plans": plan(view),
        "lines": lines(view, stored),
        "stored": None if stored is None else _stored_cells(view, stored, check),
    }


def _stored_cells(view: View, stored: Stored, check: Callable[[], None]) -> dict[str, Any]:
    """Return the cells of the plane of an atlas."""
    spec = stored.spec
    x, y = (getattr(spec, side.name).array() for side in (view.x, view.y))
    if x.size * y.size > MOST_CELLS:
        raise RequestError(
            f"An exported page can have at most {MOST_CELLS} cells; this atlas has {x.size} x {y.size} in its plane.",
            hint="Make an atlas with fewer cells.",
            where=stored.label,
        )
    cells = {
        name: _narrow(shown.values(spec, {need: stored.plane(need, view) for need in shown.needs}))
        for name, shown in stored.quantities().items()
    }
    cells["verdict"] = stored.plane("stability", view).astype(np.uint8)
    cells |= {name: stored.plane(name, view).astype(np.float64) for name in spec.computed}
    fixed = (*spec.model.parameters, *(["fall_tilt"] if "fall_tilt" in spec.model.settings else []))
    # some parameters are words instead of numbers, such as a moment of inertia that follows from the shape
    starts = {name: getattr(view.spec, name) for name in fixed}
    packed = {}
    for name, values in cells.items():
        # compressing a large variable takes a second
        check()
        packed[name] = _pack(values)
    return {
        "x": _pack(x),
        "y": _pack(y),
        "cells": packed,
        "starts": {
            name: value for name, value in starts.items() if isinstance(value, float) and np.isfinite(value)
        },
    }


def _narrow(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return values.astype(np.uint8 if values.dtype.kind in "iu" else np.float32)


def _pack(values: npt.NDArray[Any]) -> dict[str, str]:
    kind = f"{values.dtype.kind}{values.dtype.itemsize}"
    content = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
    return {"type": kind, "data": _deflate(content)}


def _deflate(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()


def page_of(held: Mapping[str, Any], pages: Mapping[str, PageFile]) -> str:
    """Return the text of the page with everything that it needs.

    Parameters
    ----------
    held : mapping
        The contents; see the module.
    pages : mapping of str to PageFile
        The files of the page.
    """

    def text(path: str) -> str:
        return pages[path].content.decode()

    kernels = _deflate(pages[KERNELS].content)

    def main(found: re.Match[str]) -> str:
        content = json.dumps(held, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
        name = f"eulerdisk/{Path(found[1]).stem}"
        return (
            f'<script type="application/json" id="stored">{content}</script>\n'
            f'    <script type="text/plain" id="kernels">{kernels}</script>\n'
            f'    <script type="module">import "{name}";</script>'
        )

    # modules import one another by name, never by path
    index = with_imports(pages[INDEX], {name: _address(pages[path]) for name, path in modules(pages).items()})
    page = index.content.decode().replace(
        "<head>", f'<head>\n    <meta http-equiv="Content-Security-Policy" content="{_POLICY}" />', 1
    )
    page = _STYLE.sub(lambda found: f"<style>\n{text(found[1])}</style>", page)
    return _MAIN.sub(main, page)


def _address(module: PageFile) -> str:
    return f"data:text/javascript;base64,{base64.b64encode(module.content).decode()}"
