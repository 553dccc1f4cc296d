"""The page as one HTML file that needs no server: its modules, its style, the kernels, and the cells of an atlas.

The file holds the kernels as WebAssembly, deflated, in ``<script type="text/plain" id="kernels">``, and JSON in
``<script type="application/json" id="stored">``, the StoredPage of the page's types.js:

``about``
    As `sweep.explorer.about.about`, with one base.
``plans``
    As `sweep.explorer.plan.plan`: how the page computes cells and motions.
``lines``
    As `sweep.explorer.lines.lines`.
``stored``
    Of an atlas ``x``, ``y``, the values of the cells along both sides, f8; ``cells``, of every cell, rows of y from the
    first value on, x fastest: each quantity that ``about`` lists (f4, or the codes as u1), ``verdict`` (u1), and every
    parameter that cells compute for themselves (f8), as a steady rate; ``starts``, the other parameters.

An array is ``{"type": ..., "data": ...}``: its little-endian bytes, deflated as zlib does, in base64.
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

#: Cells of a page at most: some 30 MB of text, with paths twice that.
MOST_CELLS = 1_000_000

#: Nothing is loaded from anywhere: modules stand in the file, as addresses that hold their content.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' data:; worker-src blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"
)

_STYLE = re.compile(r'<link rel="stylesheet" href="\./page/([^"]+)" ?/?>')
_MAIN = re.compile(r'<script type="module" src="\./page/([^"]+)"></script>')


def _go_on() -> None:
    """Go on."""


def export(
    subject: Subject, path: Path, *, overwrite: bool = False, check: Callable[[], None] = _go_on
) -> None:
    """Write the page, with the cells of an atlas if there is one; the file appears when it is complete.

    Parameters
    ----------
    subject : Subject
        An atlas; or a spec, whose cells the page computes.
    path : Path
        Ends in .html.
    overwrite : bool
        Replace a file of that name.
    check : callable
        Is called from time to time before the file appears; what it raises ends the work.

    Raises
    ------
    RequestError
        If there can be no such file, or the atlas has too many cells.
    StorageError
        If the file system refuses.
    """
    from sweep.files.publish import refusals

    if path.suffix.lower() not in (".html", ".htm"):
        raise RequestError(
            f"An exported page is one HTML file; got {path}.",
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
    """Return the view of all of a spec; refuse one without two axes, or whose cells the page could not compute."""
    view = View.read(base_of("", spec)["view"], spec)
    if not {view.x.name, view.y.name} <= set(spec.axes):
        free = next(side for side in (view.y, view.x) if side.name not in spec.axes)
        window = Range(*free.ends(), 100)
        raise RequestError(
            f"An exported page shows the plane of two axes; this request has {', '.join(spec.axes) or 'none'}.",
            hint=f"Add a range, as in {free.name}={as_written(window, spec.model.parameters[free.name])}.",
            where="--export",
        )
    view.live  # noqa: B018 - says why cells cannot be computed
    return view


def held_page(subject: Subject, check: Callable[[], None] = _go_on) -> dict[str, Any]:
    """Return what the page holds; see the module, and `export` for the check.

    Raises
    ------
    RequestError
        If the plane of an atlas has too many cells, or cells of a spec cannot be computed.
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
            # words are read where the program is
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
            f"An exported page holds at most {MOST_CELLS} cells; this atlas has {x.size} x {y.size} in the plane.",
            hint="Make an atlas with fewer.",
            where=stored.label,
        )
    cells = {
        name: _narrowed(shown.values(spec, {need: stored.plane(need, view) for need in shown.needs}))
        for name, shown in stored.quantities().items()
    }
    cells["verdict"] = stored.plane("stability", view).astype(np.uint8)
    cells |= {name: stored.plane(name, view).astype(np.float64) for name in spec.computed}
    fixed = (*spec.model.parameters, *(["fall_tilt"] if "fall_tilt" in spec.model.settings else []))
    # a word, as a moment that follows from the shape, is no number of the cell
    starts = {name: getattr(view.spec, name) for name in fixed}
    packed = {}
    for name, values in cells.items():
        # a large one takes a second
        check()
        packed[name] = _packed(values)
    return {
        "x": _packed(x),
        "y": _packed(y),
        "cells": packed,
        "starts": {
            name: value for name, value in starts.items() if isinstance(value, float) and np.isfinite(value)
        },
    }


def _narrowed(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return values.astype(np.uint8 if values.dtype.kind in "iu" else np.float32)


def _packed(values: npt.NDArray[Any]) -> dict[str, str]:
    kind = f"{values.dtype.kind}{values.dtype.itemsize}"
    content = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
    return {"type": kind, "data": _deflated(content)}


def _deflated(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode()


def page_of(held: Mapping[str, Any], pages: Mapping[str, PageFile]) -> str:
    """Return the text of the page with all that it needs.

    Parameters
    ----------
    held : mapping
        What it holds; see the module.
    pages : mapping of str to PageFile
        The files of the page.
    """

    def text(path: str) -> str:
        return pages[path].content.decode()

    kernels = _deflated(pages[KERNELS].content)

    def main(found: re.Match[str]) -> str:
        content = json.dumps(held, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
        name = f"eulerdisk/{Path(found[1]).stem}"
        return (
            f'<script type="application/json" id="stored">{content}</script>\n'
            f'    <script type="text/plain" id="kernels">{kernels}</script>\n'
            f'    <script type="module">import "{name}";</script>'
        )

    # modules import one another by their names, never by a path
    index = with_imports(pages[INDEX], {name: _address(pages[path]) for name, path in modules(pages).items()})
    page = index.content.decode().replace(
        "<head>", f'<head>\n    <meta http-equiv="Content-Security-Policy" content="{_POLICY}" />', 1
    )
    page = _STYLE.sub(lambda found: f"<style>\n{text(found[1])}</style>", page)
    return _MAIN.sub(main, page)


def _address(module: PageFile) -> str:
    return f"data:text/javascript;base64,{base64.b64encode(module.content).decode()}"
