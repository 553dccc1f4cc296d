"""A `<picture>` of a page, with a drawing for light and one for dark screens, follows the switch of the site's theme.

The page itself says it in HTML, which is what shows the right one where the repository is read.
"""

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

_DARK = re.compile(r'srcset="([^"]+)"')
_LIGHT = re.compile(r'<img alt="([^"]+)" src="([^"]+)"')


def _replace(app: Sphinx, document: nodes.document) -> None:
    for node in list(document.findall(nodes.raw)):
        text = node.astext()
        if not text.lstrip().startswith("<picture"):
            continue
        (dark,), ((words, light),) = _DARK.findall(text), _LIGHT.findall(text)
        images = [
            nodes.image(uri=uri, alt=words, classes=[theme])
            for uri, theme in ((light, "only-light"), (dark, "only-dark"))
        ]
        node.replace_self(nodes.paragraph("", "", *images))


def setup(app: Sphinx) -> dict[str, Any]:
    """Read pictures before the images of a page are collected."""
    app.connect("doctree-read", _replace, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
