"""Names in docstrings: pages become links; parameters, words of a request and variables of an atlas may be none.

Any other `name` that leads to nothing on the page of the interface stays unresolved, and the build warns of it: an
internal name, for example.
"""

import inspect
import re
from collections.abc import Iterator
from functools import cache
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

import sweep
from sweep.accessor import Eulerdisk
from sweep.model.description import Model
from sweep.model.disk.model import DISK

#: A page of the documentation as docstrings name it.
_PAGE = re.compile(r"\bdocs/(\w+)\.md")


@cache
def words() -> frozenset[str]:
    """Return the names that a docstring may mention without a link."""
    disk = DISK.parameters.keys() | DISK.settings.keys() | DISK.options.keys() | DISK.variables.keys()
    return (
        frozenset(disk)
        | frozenset(DISK.substitutes)
        | frozenset(Model.__annotations__)
        | frozenset(_parameters())
    )


def _parameters() -> Iterator[str]:
    public = [getattr(sweep, name) for name in sweep.__all__ if name != "__version__"]
    for each in [*public, Eulerdisk, Model]:
        members = [value for _, value in inspect.getmembers(each, callable)] if inspect.isclass(each) else []
        for function in [each, *members]:
            try:
                yield from inspect.signature(function).parameters
            except (TypeError, ValueError):
                continue  # compiled, as some methods of object are


def _missing(
    app: Sphinx, env: Any, node: nodes.Element, content: nodes.TextElement
) -> nodes.TextElement | None:
    return content if node.get("reftarget") in words() else None


def _link_pages(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    lines[:] = [_PAGE.sub(r":doc:`docs/\1.md </docs/\1>`", line) for line in lines]


def setup(app: Sphinx) -> dict[str, Any]:
    """Answer for references that Sphinx cannot resolve, and make links of the pages that docstrings name."""
    app.connect("autodoc-process-docstring", _link_pages)
    app.connect("missing-reference", _missing)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
