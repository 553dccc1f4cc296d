r"""Formulas of the pages become MathML when the site is built: browsers draw it, and no script is needed.

Docutils has the converter. What it would misread without a word (``\frac12`` becomes 12 over what follows) is
refused, and four things are mended in what it returns: a dotted letter with a subscript, the space around sin and its
like, bars of absolute values, and the size of fractions in lines of a displayed formula.
"""

import re
from importlib.resources import files
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from fontTools.ttLib import TTFont
from sphinx.application import Sphinx
from sphinx.util import logging

Element = ElementTree.Element

_LOG = logging.getLogger(__name__)
_BARE_FRACTION = re.compile(r"\\[td]?frac(?!\{)|\\sqrt(?![{\[])")
_NAMESPACE = ' xmlns="http://www.w3.org/1998/Math/MathML"'
_SCRIPTS = ("msup", "msub", "msubsup")
_APPLY, _DOTS, _OPEN, _CLOSED = "\u2061", ("˙", "¨"), ("(", "[", "{"), (")", "]", "}")
_FUNCTIONS = {"sin", "cos", "tan", "cosh", "sinh", "tanh", "artanh", "ln", "exp"}


def mathml(text: str, as_block: bool) -> str:
    """Return the MathML element of a formula.

    Raises
    ------
    MathError
        If it cannot be converted, or would be read wrongly.
    """
    if found := _BARE_FRACTION.search(text):
        raise MathError(f"write braces after {found[0]}")
    written = str(tex2mathml(text, as_block=as_block)).replace("&ApplyFunction;", _APPLY)
    formula = ElementTree.fromstring(re.sub(r">\s+<", "><", written.replace(_NAMESPACE, "").strip()))
    for element in list(formula.iter()):
        _place_dots(element)
        _pair_bars(element)
        _space_functions(element)
        if element.tag == "mtable":
            element.set("displaystyle", "true")
    return ElementTree.tostring(formula, encoding="unicode", short_empty_elements=False)


def _place_dots(element: Element) -> None:
    """Put the subscript of a dotted letter beside it; docutils puts it below, as that of a sum."""
    if element.tag != "munderover" or element[2].text not in _DOTS:
        return
    letter, subscript, dots = element
    element.clear()
    element.tag = "msub"
    dotted = ElementTree.SubElement(element, "mover", {"accent": "true"})
    dotted.extend([letter, dots])
    element.append(subscript)


def _pair_bars(row: Element) -> None:
    """Make pairs of bars brackets: browsers space them as relations, and raise a power beside the second one alone."""
    if row.tag in _SCRIPTS:
        return
    opened: list[int] = []
    for each in list(row):
        bar = each[0] if each.tag in _SCRIPTS else each
        if bar.tag != "mo" or bar.text != "|":
            continue
        bar.attrib.update(form="postfix" if opened else "prefix", fence="true", stretchy="false")
        if not opened:
            opened.append(list(row).index(each))
            continue
        if bar is not each:
            start, stop = opened[0], list(row).index(each)
            each[0] = group = Element("mrow")
            group.extend([*row[start:stop], bar])
            row[start:stop] = []
        opened.clear()


def _is_function(element: Element) -> bool:
    named = element[0] if element.tag == "msup" and len(element) else element
    return named.tag == "mi" and named.text in _FUNCTIONS


def _space_functions(row: Element) -> None:
    """Put a thin space before a function that follows a factor, and after one whose argument has no parentheses."""
    if row.tag in ("msup", "msub", "mover"):
        return
    kept = [each for each in row if each.text != _APPLY]
    spaced = list[Element]()
    for i, each in enumerate(kept):
        if _is_function(each) and i and (kept[i - 1].tag != "mo" or kept[i - 1].text in _CLOSED):
            spaced.append(_thin_space())
        spaced.append(each)
        if _is_function(each) and i + 1 < len(kept) and kept[i + 1].text not in _OPEN:
            spaced.append(_thin_space())
    row[:] = spaced


def _thin_space() -> Element:
    return Element("mspace", {"width": "0.1667em"})


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


def write_font(target: Path) -> None:
    """Write the font of the formulas, STIX Two Math with all its root signs as wide as the lowest one.

    A browser that lays out a line keeps room for the widest, 0.42 em more, and so leaves a gap after a low root.
    """
    font = TTFont(files("ziamath") / "fonts" / "STIXTwoMath-Regular.ttf")
    sign, variants = font.getBestCmap()[ord("\u221a")], font["MATH"].table.MathVariants
    made = variants.VertGlyphConstruction[variants.VertGlyphCoverage.glyphs.index(sign)]
    width = font["hmtx"][sign][0]
    parts = [each.glyph for each in made.GlyphAssembly.PartRecords]
    for name in {each.VariantGlyph for each in made.MathGlyphVariantRecord} | {*parts}:
        advance, left = font["hmtx"][name]
        font["glyf"][name].coordinates.scale((width / advance, 1.0))
        font["glyf"][name].recalcBounds(font["glyf"])
        font["hmtx"][name] = width, round(left * width / advance)
    font.save(target)


def _finish(app: Sphinx, problem: Exception | None) -> None:
    if problem is None and app.builder.format == "html":
        write_font(Path(app.outdir) / "_static" / "STIXTwoMath-Regular.ttf")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.connect("build-finished", _finish)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
