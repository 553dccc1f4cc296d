"""The page as one HTML file that needs no server: its modules, its style, and the cells of an atlas.

The file holds JSON in ``<script type="application/json" id="stored">``, the StoredPage of the page's types.js:

``about``
    As `sweep.explorer.about.about`, with one base, and an atlas that is not live.
``x``, ``y``
    The values of the cells along both sides, f8.
``cells``
    Of every cell, rows of y from the first value on, x fastest: each quantity that ``about`` lists (f4, or the codes as
    u1), ``verdict`` (u1), and every parameter that cells compute for themselves (f8), as a steady rate.
``starts``
    The other parameters, and ``fall_tilt``.
``lines``
    As `sweep.explorer.lines.lines`.
``motions``
    As `sweep.explorer.motion.stored_motions`: the page integrates motions itself.

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
from sweep.explorer.motion import stored_motions
from sweep.explorer.pages import INDEX, PageFile, modules, page_files, with_imports
from sweep.explorer.stored import Stored
from sweep.explorer.view import View
from sweep.files.paths import check_target
from sweep.request.spec import SweepSpec

#: Cells of a page at most: some 30 MB of text.
MOST_CELLS = 1_000_000

#: Nothing is loaded from anywhere: modules stand in the file, as addresses that hold their content.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' data:; style-src 'unsafe-inline'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'"
)

_STYLE = re.compile(r'<link rel="stylesheet" href="\./page/([^"]+)" ?/?>')
_MAIN = re.compile(r'<script type="module" src="\./page/([^"]+)"></script>')


def _go_on() -> None:
    """Go on."""


def export(
    subject: Subject, path: Path, *, overwrite: bool = False, check: Callable[[], None] = _go_on
) -> None:
    """Write the page with the cells of an atlas; the file appears when it is complete.

    Parameters
    ----------
    subject : Subject
        An atlas; or a spec, whose cells are computed.
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
    stored = subject.stored or _computed(subject.spec or SweepSpec.preset("rolling"))
    check()
    content = page_of(stored_page(stored, check), page_files()).encode()
    check()
    with refusals(path.absolute(), lambda: float(len(content))):
        publish_bytes(path.absolute(), content)


def _computed(spec: SweepSpec) -> Stored:
    """Return the atlas of a spec by the exact reduction, in the plane of its first two axes."""
    from sweep.runs.in_memory import run

    view = View.read(base_of("", spec)["view"], spec)
    if not {view.x.name, view.y.name} <= set(spec.axes):
        raise RequestError(
            f"An exported page holds the cells of two axes; this request has {', '.join(spec.axes) or 'none'}.",
            hint="Add a range, as in tilt=1deg:5deg:100.",
            where="--export",
        )
    exact = view.live
    _check_size(exact)
    return Stored(run(exact, progress=False), exact, exact.headline)


def _check_size(spec: SweepSpec) -> None:
    if spec.size > MOST_CELLS:
        raise RequestError(
            f"An exported page holds at most {MOST_CELLS} cells; got {' x '.join(map(str, spec.shape))}.",
            hint="Lower the counts of the axes.",
            where="--export",
        )


def stored_page(stored: Stored, check: Callable[[], None] = _go_on) -> dict[str, Any]:
    """Return what the page holds; see the module, and `export` for the check.

    Raises
    ------
    RequestError
        If the plane has too many cells.
    """
    spec = stored.spec
    motions = stored_motions(spec)
    base = {**base_of("", spec), "quantities": list(stored.quantities()), "hasMotions": motions is not None}
    view = View.read(base["view"], spec)
    x, y = (getattr(spec, side.name).array() for side in (view.x, view.y))
    if x.size * y.size > MOST_CELLS:
        raise RequestError(
            f"An exported page holds at most {MOST_CELLS} cells; this atlas has {x.size} x {y.size} in the plane.",
            hint="Make an atlas with fewer.",
            where=stored.label,
        )
    known = about(spec, stored)
    quantities = stored.quantities()
    cells = {
        name: _narrowed(shown.values(spec, {need: stored.plane(need, view) for need in shown.needs}))
        for name, shown in quantities.items()
    }
    cells["verdict"] = stored.plane("stability", view).astype(np.uint8)
    cells |= {name: stored.plane(name, view).astype(np.float64) for name in spec.computed}
    fixed = (*spec.model.parameters, *(["fall_tilt"] if "fall_tilt" in spec.model.settings else []))
    starts = {name: view.spec.constants.get(name, getattr(view.spec, name)) for name in fixed}
    packed = {}
    for name, values in cells.items():
        # a large one takes a second
        check()
        packed[name] = _packed(values)
    note = f"This page holds {x.size} x {y.size} cells: nothing is known between and beyond them."
    return {
        "about": {
            **known,
            "bases": [base],
            "others": [],
            "quantities": [each for each in known["quantities"] if each["name"] in quantities],
            "criteria": [],
            "losses": [],
            "atlas": {**known["atlas"], "live": False, "note": note},
        },
        "x": _packed(x),
        "y": _packed(y),
        "cells": packed,
        "starts": {
            name: value for name, value in starts.items() if isinstance(value, float) and np.isfinite(value)
        },
        "lines": lines(view, stored),
        "motions": motions,
    }


def _narrowed(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return values.astype(np.uint8 if values.dtype.kind in "iu" else np.float32)


def _packed(values: npt.NDArray[Any]) -> dict[str, str]:
    kind = f"{values.dtype.kind}{values.dtype.itemsize}"
    content = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
    return {"type": kind, "data": base64.b64encode(zlib.compress(content, 9)).decode()}


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

    def main(found: re.Match[str]) -> str:
        content = json.dumps(held, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
        name = f"eulerdisk/{Path(found[1]).stem}"
        return (
            f'<script type="application/json" id="stored">{content}</script>\n'
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
