"""The words on the frames of a film: title and caption above; time, speed, scale and what is impossible below."""

import math
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from matplotlib.text import Text

from sweep.errors import plain_text
from sweep.figures.disk.captions import caption, spell_length
from sweep.figures.disk.film_files import WARNING
from sweep.figures.disk.film_timing import Timing
from sweep.figures.texts import fitted, wrapped
from sweep.motion.contact import RollingLimit
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr

#: Sizes of the words [points] of a narrow picture and of one of `_WIDE` inches or more; a caption that is too long is
#: written smaller, down to this share, and in several lines if that is not enough.
_WORDS, _WIDE, _SMALLER = (9.0, 12.0), 6.4, 0.8

#: The title in letters of the others.
_TITLE = 1.1

#: Where the words begin [in] from the left, and from above or below; where the caption begins below a title of one
#: line, and the height of one line below.
_LEFT, _FROM_ABOVE, _FROM_BELOW, _CAPTION, _LINE = 0.16, 0.12, 0.14, 0.36, 0.24

#: Between lines of different letters, and around the words [in].
_GAP = 0.06

#: Height of the words of a picture [in] above and below, at least: most films have the same.
_ROOM = 0.62, 0.55

#: Lines of a title, a caption, or what is impossible, at most.
_MOST_LINES = 5

#: As long as the side of the squares of a floor ever is in words.
_LONGEST_SIDE = "squares of 500 mm"


class FilmWords:
    """The words of a film on its sheet.

    Parameters
    ----------
    drawn : Figure
        The sheet of all frames.
    dataset : xarray.Dataset
        The motion.
    times : Timing
    limit : RollingLimit

    Attributes
    ----------
    room : (float, float)
        Height of the words above and below [in], with what is free around them.
    """

    def __init__(self, drawn: Figure, dataset: "xr.Dataset", times: Timing, limit: RollingLimit) -> None:
        self._drawn, self._limit, self._start = drawn, limit, float(dataset[TIME.name][0])
        self._width, self._height = drawn.get_size_inches()
        self._letter = min(max(_WORDS[0], _WORDS[1] * self._width / _WIDE), _WORDS[1])
        self._speed = "real time" if times.speed == 1.0 else f"{times.speed:g} \u00d7 real time"
        # as many decimals as tell one frame from the next
        self._decimals = max(0, math.ceil(-math.log10(times.speed / times.fps) - 1e-9))
        above = self._write_above(plain_text(dataset.attrs.get("title", "")), caption(dataset))
        self.room = above, self._write_below(float(times.moments[-1]))

    def scale(self, spacing: float) -> None:
        """Write the side of the squares of the floor [m]."""
        self._squares.set_text(f"squares of {spell_length(spacing)}")

    def write(self, moment: float) -> None:
        """Write what belongs to a moment [s]."""
        self._time.set_text(self._time_text(moment))
        self._impossible.set_text(self._impossible_text(moment))

    def _text(self, x: float, y: float, text: str, size: float, **look: Any) -> Text:
        """Write at a place [in] from the left and, if above 0, from below, else from above."""
        up = y if y > 0.0 else self._height + y
        return self._drawn.text(
            x / self._width, up / self._height, text, parse_math=False, fontsize=size, **look
        )

    def _across(self) -> float:
        return float(self._width) - 2.0 * _LEFT

    def _write_above(self, title: str, words: str) -> float:
        """Write title and caption; return their height [in]."""
        size = _TITLE * self._letter
        lines = wrapped(title, size, self._across(), most=_MOST_LINES)
        bold = self._text(_LEFT, -_FROM_ABOVE, lines, size, fontweight="bold", va="top")
        begin = max(_CAPTION, _FROM_ABOVE + self._high(bold) + _GAP)
        size, lines = self._caption(words)
        small = self._text(_LEFT, -begin, lines, size, va="top")
        return max(_ROOM[0], begin + self._high(small) + _GAP)

    def _caption(self, words: str) -> tuple[float, str]:
        """Return the size of the letters of a caption, and its lines."""
        sizes = (self._letter * share for share in (1.0, 0.9, _SMALLER))
        for size in sizes:
            if fitted(words, size, self._across(), "normal") == words:
                return size, words
        return size, wrapped(words, size, self._across(), "normal", _MOST_LINES)

    def _write_below(self, last: float) -> float:
        """Write what no moment changes, and make room for the rest; return the height of all [in]."""
        size, up = self._letter, _FROM_BELOW
        beside = f"{self._time_text(last)}   {_LONGEST_SIDE}"
        self._time = self._text(_LEFT, up, "", size)
        if fitted(beside, size, self._across(), "normal") == beside:
            self._squares = self._text(self._width - _LEFT, up, _LONGEST_SIDE, size, ha="right")
        else:
            up += _LINE
            self._squares = self._text(_LEFT, up, _LONGEST_SIDE, size)
        self._impossible = self._text(_LEFT, up + _LINE, "", size, color=WARNING)
        self._impossible.set_text(self._impossible_text(last))
        return max(_ROOM[1], up + _LINE + self._high(self._impossible) + _GAP)

    def _high(self, text: Text) -> float:
        """Return the height of a text [in]."""
        return float(text.get_window_extent().height) / self._drawn.dpi if text.get_text() else 0.0

    def _time_text(self, moment: float) -> str:
        return f"{TIME.symbol} = {moment:.{self._decimals}f} {TIME.units}   ({self._speed})"

    def _impossible_text(self, moment: float) -> str:
        limit, text = self._limit, ""
        if limit.lifts_off is not None and moment >= limit.lifts_off:
            text = f"Impossible: the disk would have lifted off {limit.when(limit.lifts_off, self._start)}"
        elif limit.slips is not None and moment >= limit.slips:
            text = f"Impossible: the disk would have slipped {limit.when(limit.slips, self._start)}"
        return wrapped(text, self._letter, self._across(), "normal", _MOST_LINES)
