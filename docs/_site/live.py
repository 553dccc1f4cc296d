"""Explorers that compute in the pages of the site, where a page has ``<div data-explorer="NAME"></div>``.

Each is a page as ``eulerdisk explore --export`` writes it, in a frame that a browser loads when it comes into view. A
reader of the repository sees nothing of such an element.
"""

import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import sweep
from sweep.explorer.explorer import Subject, subject_of
from sweep.explorer.export import export

_PLACE = re.compile(r'<div data-explorer="(\w+)"></div>')
_FOLDER = "_static/explorers"

_TITLES = {
    "rolling": "A disk that rolls along a line: zoom into the boundary, click on each side of it",
    "circling": "A disk that circles at a constant tilt: zoom into the boundary, click on each side of it",
    "toy": "The toy on its mirror: how long it stays aloft, and how it stops",
}


def setup(app: Sphinx) -> dict[str, bool]:
    """Put frames into pages, and write what they show."""
    app.connect("html-page-context", _put)
    app.connect("build-finished", _write)
    return {"parallel_read_safe": True, "parallel_write_safe": False}


def _put(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Replace the places of explorers by frames."""

    def frame(found: re.Match[str]) -> str:
        name = found[1]
        address = context["pathto"](f"{_FOLDER}/{name}.html", 1)
        return f'<iframe class="explorer" loading="lazy" src="{address}" title="{_TITLES[name]}"></iframe>'

    if "body" in context:
        context["body"] = _PLACE.sub(frame, context["body"])


def _write(app: Sphinx, problem: Exception | None) -> None:
    """Write the pages of all explorers that a page may show."""
    if problem is not None:
        return
    folder = Path(app.outdir, *_FOLDER.split("/"))
    folder.mkdir(parents=True, exist_ok=True)
    for name in _TITLES:
        export(_subject(name), folder / f"{name}.html", overwrite=True)


def _subject(name: str) -> Subject:
    """Return what an explorer shows: a preset, and of one with losses an atlas of few cells."""
    if name != "toy":
        return subject_of(name, {})
    axes = {"tilt": "20deg:75deg:12", "precession_rate": "10:60:12"}
    return subject_of(sweep.run(name, **axes, progress=False), {})
