r"""Formulas of the pages become MathML when the site is built: browsers draw it, and no script is needed.

Docutils has the converter. What it would misread without a word (``\frac12`` becomes 12 over what follows) is refused.
"""

import re
from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging

_LOG = logging.getLogger(__name__)
_BARE_FRACTION = re.compile(r"\\[td]?frac(?!\{)|\\sqrt(?![{\[])")


def mathml(text: str, as_block: bool) -> str:
    """Return the MathML element of a formula.

    Raises
    ------
    MathError
        If it cannot be converted, or would be read wrongly.
    """
    if found := _BARE_FRACTION.search(text):
        raise MathError(f"write braces after {found[0]}")
    return str(tex2mathml(text, as_block=as_block))


def _converted(node: nodes.Element, as_block: bool) -> str:
    text = node.astext()
    try:
        return mathml(text, as_block)
    except MathError as problem:
        _LOG.warning("formula %s: %s", text, problem, location=node)
        return ""


def _inline(writer: Any, node: nodes.math) -> None:
    writer.body.append(_converted(node, as_block=False))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:
    writer.body.append(f'<div class="formula">{_converted(node, as_block=True)}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
