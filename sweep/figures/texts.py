"""Text of files and requests in figures: drawn literally, never as mathematics, and broken into lines that fit."""

import re
from functools import lru_cache
from typing import TYPE_CHECKING

from matplotlib.font_manager import FontProperties, findfont, get_font

from sweep.errors import printable

if TYPE_CHECKING:
    from matplotlib.ft2font import FT2Font
    from matplotlib.text import Text

#: Largest number of characters in a line of a figure, however narrow they are.
_MOST = 400

#: Text that is not broken: a word, mathematics, a unit in brackets.
_PIECES = re.compile(r"(?:\([^()]*\)|\$[^$]*\$|[^ $(]|\()+")


def number(value: float) -> str:
    """Return a number as it was given if it has up to nine digits; otherwise, as for computed ones, with four."""
    given = f"{value:.9g}"
    return given if float(f"{value:.12g}") == float(given) else f"{value:.4g}"


def fitted(text: str, size: float, width: float, weight: str = "bold") -> str:
    """Return a text shortened to fit on one line.

    Parameters
    ----------
    text : str
        Unprintable characters, and those that the font lacks, are replaced by their escapes, as Python writes them.
    size : float
        Font size [points].
    width : float
        Largest width of the line [in]; a longer line is cut and ends in an ellipsis.
    weight : {"bold", "normal"}
        Font weight.

    Returns
    -------
    str
        Text to draw with ``parse_math=False``.
    """
    spelled = _escape(text[: _MOST + 1], weight)
    if len(spelled) <= _MOST and _points(spelled, size, weight) <= 72.0 * width:
        return spelled
    low, high = 0, min(len(spelled), _MOST)
    while low < high:
        middle = (low + high + 1) // 2
        fits = _points(f"{spelled[:middle].rstrip()}\u2026", size, weight) <= 72.0 * width
        low, high = (middle, high) if fits else (low, middle - 1)
    return f"{spelled[:low].rstrip()}\u2026"


def wrapped(text: str, size: float, width: float, weight: str = "bold", most: int = 5) -> str:
    """Return a text broken between words into a few lines, cut only if it needs more than `most` lines.

    Parameters
    ----------
    text, size, width, weight
        As in `fitted`.
    most : int
        Largest number of lines.

    Returns
    -------
    str
        The lines, to draw with ``parse_math=False``.
    """
    words = _escape(text[: _MOST + 1], weight).split(" ")
    lines = [words[0]]
    for i, word in enumerate(words[1:], 1):
        longer = f"{lines[-1]} {word}"
        if _points(longer, size, weight) <= 72.0 * width:
            lines[-1] = longer
        elif len(lines) < most:
            lines.append(word)
        else:
            lines[-1] = " ".join([lines[-1], *words[i:]])
            break
    return "\n".join(fitted(line, size, width, weight) for line in lines)


def broken(probe: "Text", text: str, width: float) -> list[str]:
    """Return a text in lines of at most `width` [dots]; mathematics is not broken."""
    lines: list[str] = []
    for piece in _PIECES.findall(text):
        longer = f"{lines[-1]} {piece}" if lines else piece
        probe.set_text(longer)
        if lines and probe.get_window_extent().width > width:
            lines.append(piece)
        else:
            lines[-1:] = [longer]
    return lines


def _escape(text: str, weight: str) -> str:
    known = _font(weight).get_charmap()
    return "".join(
        each if ord(each) in known else each.encode("ascii", "backslashreplace").decode("ascii")
        for each in printable(text)
    )


def _points(text: str, size: float, weight: str) -> float:
    """Return the width of a line [points]."""
    font = _font(weight)
    font.set_size(size, 72.0)
    font.set_text(text, 0.0)
    # matplotlib measures in 64ths of a dot, here with 72 dots to an inch
    return float(font.get_width_height()[0]) / 64.0


@lru_cache
def _font(weight: str) -> "FT2Font":
    return get_font(findfont(FontProperties(family="DejaVu Sans", weight=weight)))
