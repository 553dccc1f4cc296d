"""How large the figures of atlases are, and how many panels stand side by side."""

from sweep.figures.look import Look

_INCH = 0.0254

#: Panels side by side; width [in] of a bar of colours with its numbers, in letters of 8 points.
_MOST_IN_ROW, BAR = 3, 0.7


def inches(length: float | None) -> float | None:
    """Return a length [m] in inches."""
    return None if length is None else length / _INCH


def columns_of(count: int, look: Look, width: float, least: float) -> int:
    """Return how many of `count` panels, of a width and at least so wide [in], stand side by side."""
    most = min(count, _MOST_IN_ROW)
    if look.width is None:
        return most
    scale = look.font_size / 8.0
    return max(1, min(most, int((look.width / _INCH - BAR * scale) / (least * scale))))


def size_of(columns: int, look: Look, width: float) -> tuple[float, float]:
    """Return width and height [in] of a figure; its height changes when it is laid out, if it was not given."""
    scale = look.font_size / 8.0
    wide = inches(look.width) or (columns * width + BAR) * scale
    return wide, inches(look.height) or wide
