"""The look of a figure of atlases, read from text and numbers and checked before anything is drawn."""

import dataclasses
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from sweep.errors import RequestError, shown
from sweep.model.quantity import DECISION, Quantity
from sweep.request.suggestions import suggestion
from sweep.request.values import read_number, read_value

#: What the axis of a rate shows: the rate, its square, the rate in units of sqrt(g/R), or the rate times the radius.
RATES = LINEAR, SQUARED, SCALED, SPEED = ("linear", "squared", "scaled", "speed")

#: Parts that can be left out of a figure; ``bare`` leaves out the first two.
PARTS = ("title", "caption", "legend", "strip", "bar")

#: The word for automatic levels of contour lines.
AUTO = "auto"

#: Default dots per inch of a png.
DPI = 200

#: Largest number of contour lines in a map: more would hide it.
_MOST_LEVELS = 12

#: Least and largest width and height of a figure [m], font size [points], and dots per inch.
_SIZES, _LETTERS, _DOTS = (0.02, 2.0), (4.0, 40.0), (10, 2400)

_SHOWN = Quantity("shown", "", "1", "a number of an option", DECISION)

_INCH = 0.0254

#: Largest number of panels in a row; width [in] of a colour bar with its numbers, in letters of 8 points.
_MOST_IN_ROW, BAR = 3, 0.7


@dataclass(frozen=True)
class Look:
    """How atlases are drawn.

    Attributes
    ----------
    rate : {"linear", "squared", "scaled", "speed"}
        What the axis of a rate shows.
    quantity : str or None
        The variable that colours maps and gives profiles their height; None for the peak of the model.
    contours : "auto", or anything that `sweep.request.values.read_value` reads, or None
        Levels of the contour lines of that quantity.
    width, height : float or None
        Width and height of the figure [m]; None lets them follow from the number of panels.
    font_size : float
        Font size [points].
    dpi : int or None
        Dots per inch of a png, and of the coloured cells in a pdf or svg; None for 200.
    family : bool
        Whether atlases of more than two axes are drawn as one family of boundary curves instead of one map each.
    without : frozenset of str
        The `PARTS` that are left out. Without the caption, the labels of a legend are short.
    """

    rate: str = LINEAR
    quantity: str | None = None
    contours: Any = None
    width: float | None = None
    height: float | None = None
    font_size: float = 8.0
    dpi: int | None = None
    family: bool = False
    without: frozenset[str] = frozenset()

    @classmethod
    def read(
        cls,
        *,
        rate: object = None,
        quantity: str | None = None,
        contours: Any = None,
        width: object = None,
        height: object = None,
        font_size: object = None,
        dpi: object = None,
        family: bool = False,
        bare: bool = False,
        without: str | Sequence[str] | None = None,
    ) -> Self:
        """Return the look that text or numbers ask for; None stands for a default.

        Parameters
        ----------
        width, height : str or float
            A length with a unit, as in ``86mm``; a bare number is in m.

        Raises
        ------
        RequestError
            If a value is invalid.
        """
        if rate is not None and rate not in RATES:
            raise RequestError(
                f"rate must be {', '.join(RATES[:-1])} or {RATES[-1]}; got {shown(rate)}.",
                suggestion(rate, RATES) or "For instance, write scaled for the rate in units of sqrt(g/R).",
                "rate",
            )
        if family and (quantity is not None or contours is not None):
            raise RequestError(
                "A family of boundary curves shows neither a quantity nor contour lines; got family with "
                f"{'quantity' if quantity is not None else 'contours'}.",
                "Leave out one of them.",
                "family",
            )
        return cls(
            rate=LINEAR if rate is None else str(rate),
            quantity=quantity,
            contours=contours,
            width=_length("width", width),
            height=_length("height", height),
            font_size=8.0 if font_size is None else _within("font_size", font_size, *_LETTERS, "points"),
            dpi=None if dpi is None else _dots(dpi),
            family=family,
            without=_parts(without) | frozenset(PARTS[:2] if bare else ()),
        )

    def levels(self, quantity: Quantity) -> tuple[float, ...]:
        """Return the levels of the contour lines in the unit of the quantity's label, increasing; empty for ``auto``.

        Raises
        ------
        RequestError
            If they are not numbers with a fitting unit, or too many.
        """
        if self.contours is None or (isinstance(self.contours, str) and self.contours == AUTO):
            return ()
        raw, named = self.contours, dataclasses.replace(quantity, name="contours")
        if isinstance(raw, Sequence) and not isinstance(raw, str):
            numbers: list[float] = [read_number(each, named) for each in raw]
        else:
            value = read_value(raw, named)
            numbers = [value] if isinstance(value, float) else value.array().tolist()
        levels = sorted({each * quantity.plot_scale for each in numbers})
        if not 1 <= len(levels) <= _MOST_LEVELS:
            raise RequestError(
                f"A map can have 1 to {_MOST_LEVELS} contour lines; got {len(levels)}.",
                f"Give fewer levels, or {AUTO}.",
                "contours",
            )
        return tuple(levels)


def _parts(raw: object) -> frozenset[str]:
    """Return the parts to leave out, from a list or a text with commas."""
    if isinstance(raw, str):
        raw = raw.split(",")
    elif not isinstance(raw, Collection):
        raw = () if raw is None else (raw,)
    named: list[Any] = [each.strip() if isinstance(each, str) else each for each in raw]
    for each in named:
        if each not in PARTS:
            raise RequestError(
                f"A figure can be drawn without {', '.join(PARTS[:-1])} or {PARTS[-1]}; got {shown(each)}.",
                suggestion(each, PARTS) or "For instance, write strip,bar.",
                "without",
            )
    return frozenset(named)


def _length(name: str, raw: object) -> float | None:
    if raw is None:
        return None
    found = read_number(raw, Quantity(name, "", "m", "of a figure", DECISION))
    low, high = _SIZES
    if not low <= found <= high:
        raise RequestError(
            f"The {name} of a figure must be from {low * 1000:g} mm to {high:g} m; got {shown(raw)}.",
            "Write 86mm; a bare number is in m.",
            name,
        )
    return found


def _within(name: str, raw: object, low: float, high: float, unit: str) -> float:
    found = read_number(raw, dataclasses.replace(_SHOWN, name=name)) if isinstance(raw, str) else raw
    real = isinstance(found, int | float | np.integer | np.floating) and not isinstance(found, bool)
    # refuses NaN too
    if not real or not low <= found <= high:  # type: ignore[operator]
        raise RequestError(
            f"The {name.replace('_', ' ')} of a figure must be from {low:g} to {high:g} {unit}; got {shown(raw)}.",
            "Write 8 for the size of a journal's captions." if unit == "points" else "Write 300 for a print.",
            name,
        )
    return float(found)  # type: ignore[arg-type]


def check_friction(friction: object) -> None:
    """Raise an error unless the value is a friction coefficient or None.

    Raises
    ------
    RequestError
    """
    real = isinstance(friction, int | float | np.integer | np.floating) and not isinstance(friction, bool)
    if friction is not None and not (real and friction > 0.0):  # type: ignore[operator]
        raise RequestError(
            f"A friction coefficient must be greater than 0; got {shown(friction)}.",
            "Write --friction 0.5; in Python friction=0.5.",
            "--friction",
        )


def _dots(raw: object) -> int:
    found = _within("dpi", raw, *_DOTS, "dots per inch")
    if found != int(found):
        raise RequestError(f"dpi must be a whole number; got {shown(raw)}.", "Write 300.", "dpi")
    return int(found)


def inches(length: float | None) -> float | None:
    """Return a length [m] in inches."""
    return None if length is None else length / _INCH


def columns_of(count: int, look: Look, width: float, least: float) -> int:
    """Return how many of `count` panels fit side by side, given their width and least width [in]."""
    most = min(count, _MOST_IN_ROW)
    if look.width is None:
        return most
    scale = look.font_size / 8.0
    return max(1, min(most, int((look.width / _INCH - BAR * scale) / (least * scale))))


def size_of(columns: int, look: Look, width: float) -> tuple[float, float]:
    """Return width and height [in] of a figure. Unless the height is given, the layout changes it later."""
    scale = look.font_size / 8.0
    wide = inches(look.width) or (columns * width + BAR) * scale
    return wide, inches(look.height) or wide
