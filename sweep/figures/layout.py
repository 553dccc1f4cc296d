"""Lay out the panels of a figure: axes as large as labels and legends leave room for, and no word on another.

The places of all axes are computed once, from the sizes of their words, and then fixed: matplotlib's own layouts let a
legend that is wider than its panel take the width of the panel.
"""

import math
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from matplotlib import rc_context, rcParams
from matplotlib.container import ErrorbarContainer
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import ScaledTranslation

from sweep.errors import RequestError
from sweep.figures.drawing import INK, OUTSIDE, analytic_lines, joined, joined_heights
from sweep.figures.look import Look
from sweep.figures.panels import Panel
from sweep.figures.room import Room, forget_names, name_end, name_line, name_regions, point_at
from sweep.figures.scales import name_ends, thin_ticks
from sweep.figures.texts import broken, wrapped
from sweep.model.quantity import Truths

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend

#: Gaps in sizes of a letter: around the figure, between columns, between map and strip, above and below a legend.
_MARGIN, _GAP, _CLOSE, _ABOVE, _BELOW = 0.6, 1.4, 1.2, 0.6, 0.8

#: Width of the bar of colours, and its distance from the maps.
_BAR, _TO_BAR = 1.0, 1.2

#: Height of a map, or of a profile, over its width; and of a strip over that of its map, and at least in letters.
_SHAPE, _PROFILE, _STRIP, _LEAST_STRIP = 0.95, 0.65, 0.3, 4.6

#: Height of the title of a figure, and of each further line of it.
_TITLE, _LINE = 2.2, 1.35

#: Least width and height of a panel, and the width from which a legend below all panels has another column.
_LEAST, _COLUMN = 7.0, 32.0

#: How often sizes and ticks, which depend on each other, are computed.
_ROUNDS = 2

#: Looks of the marker for a region that is too small for its name.
_POINTERS: tuple[dict[str, Any], ...] = (
    {"marker": "*", "markerfacecolor": "white"},
    {"marker": "*", "markerfacecolor": INK},
    {"marker": "X", "markerfacecolor": "white"},
    {"marker": "P", "markerfacecolor": "white"},
    {"marker": "P", "markerfacecolor": INK},
)
_POINTER: dict[str, Any] = {
    "linestyle": "", "color": INK, "markersize": 8.0, "markeredgewidth": 0.8, "zorder": 8,
}  # fmt: skip


@dataclass
class Block:
    """A panel in a figure: its map or profile, the strip below it if there is one, and their words.

    `regions` are the names and cells that are written into a map; those that are `explained` have an entry in the
    legend in any case, and `pointed` are those whose names have no room: the legend shows what `symbols` gives for
    their names, or a marker that points at them. `unnamed` are ends of a curve whose names have no room.
    """

    axes: "Axes"
    panel: Panel
    title: str = ""
    caption: tuple[str, ...] = ()
    strip: "Axes | None" = None
    regions: Sequence[tuple[str, Truths]] = ()
    explained: Sequence[str] = ()
    symbols: Callable[[str], Any] | None = None
    pointed: list[str] = field(default_factory=list)
    unnamed: list[str] = field(default_factory=list)
    is_mathematics: bool = False

    @property
    def lowest(self) -> "Axes":
        """The lower of both axes."""
        return self.strip or self.axes


def arrange(
    drawn: "Figure",
    blocks: Sequence[Block],
    columns: int,
    *,
    height: float | None = None,
    bar: "Axes | None" = None,
    common: Sequence[str] | None = None,
    title: str = "",
) -> None:
    """Give all axes of a figure their places, write legends, titles and names.

    Parameters
    ----------
    drawn : Figure
        As wide as it shall be.
    blocks : sequence of Block
        Row by row.
    columns : int
        Blocks in a row.
    height : float, optional
        Of the figure [in]; by default the maps have a good shape.
    bar : Axes, optional
        The bar of colours, to the right of all.
    common : sequence of str, optional
        Caption of one legend below all panels; without it each has its own.
    title : str
        Of the whole figure.

    Raises
    ------
    RequestError
        If there is no room.
    """
    layout = _Layout(drawn, blocks, columns, height, bar, title)
    for _ in range(2):
        for block in blocks:
            forget_names(block.axes)
        layout.write_legends(common)
        for _ in range(_ROUNDS):
            layout.place()
            layout.break_labels()
        for axes in layout.axes():
            thin_ticks(axes)
        if bar is not None:
            name_ends(bar)
        layout.place()
        # all of them, for the legends are written again with what has no room
        if not sum(name_block(block) for block in blocks):
            break


def lettered(look: Look) -> AbstractContextManager[None]:
    """Draw in the size of letters of a look, if it is not the default, into axes of a caller."""
    return nullcontext() if look.font_size == Look.font_size else rc_context({"font.size": look.font_size})


def finish_in(block: Block, look: Look) -> "Figure":
    """Write title, names and legend of a panel into the axes of a caller, which stay where they are.

    The legend is below the labels, and takes part in the layout of the figure.
    """
    axes = block.axes
    drawn = axes.get_figure(root=True)
    assert drawn is not None
    with lettered(look):
        drawn.draw_without_rendering()
        room = axes.get_window_extent().width / axes.figure.dpi
        axes.set_title(wrapped(block.title, float(axes.title.get_fontsize()), room), parse_math=False)
        for _ in range(2):
            forget_names(axes)
            _put_below(axes, block)
            # the legend may have moved the axes, and names are placed in their size
            drawn.draw_without_rendering()
            thin_ticks(axes)
            if not name_block(block):
                break
    return drawn


def _put_below(axes: "Axes", block: Block) -> None:
    """Write the legend of a panel below its labels, as a part of the layout of the figure."""
    drawn = axes.get_figure(root=True)
    assert drawn is not None
    drawn.draw_without_rendering()
    legend = add_legend(
        axes, *entries(block), block.caption, axes.get_window_extent().width / axes.figure.dpi
    )
    tight = axes.get_tightbbox(for_layout_only=True)
    assert tight is not None
    below = (tight.y0 - axes.get_window_extent().y0) / axes.figure.dpi - 0.5 * _letter() / 72.0
    shift = ScaledTranslation(0.0, below, axes.figure.dpi_scale_trans)
    legend.set_bbox_to_anchor((0.0, 0.0), transform=axes.transAxes + shift)
    legend.set_in_layout(True)


def _letter() -> float:
    return float(rcParams["font.size"])


class _Layout:
    """Places [in] of all axes of a figure."""

    def __init__(
        self,
        drawn: "Figure",
        blocks: Sequence[Block],
        columns: int,
        height: float | None,
        bar: "Axes | None",
        title: str,
    ) -> None:
        self.drawn, self.blocks, self.columns, self.height, self.bar = drawn, blocks, columns, height, bar
        self.letter = _letter() / 72.0
        self.width = drawn.get_size_inches()[0]
        self.rows = -(-len(blocks) // columns)
        self.common: Legend | None = None
        self.title: Text | None = None
        if title:
            size = float(rcParams["axes.titlesize"])
            text = wrapped(title, size, self.width - 2.0 * self.letter)
            self.title = drawn.text(0.0, 1.0, text, size=size, weight="bold", va="top", parse_math=False)
        self.legends: list[Legend | None] = []
        self.has_strip = any(block.strip is not None for block in blocks)
        self.labels = [
            (axis, which, axis.get_label_text())
            for axes in self.axes()
            for each in (axes, *axes.child_axes)
            for which, axis in ((0, each.xaxis), (1, each.yaxis))
        ]
        for block in blocks:
            if block.strip is not None:
                drawn.align_ylabels([block.axes, block.strip])
        self._start()

    def axes(self) -> "list[Axes]":
        """Return all axes that have places."""
        every = [each for block in self.blocks for each in (block.axes, block.strip)]
        return [each for each in (*every, self.bar) if each is not None]

    def break_labels(self) -> None:
        """Break the labels that are longer than their axes."""
        probe = self.drawn.text(0.0, 0.0, "")
        for axis, which, text in self.labels:
            box = axis.axes.get_window_extent()
            probe.set_fontsize(axis.label.get_fontsize())
            # a strip is too low for its label, but has room above
            length = max((box.width, box.height)[which], 6.0 * self.letter * self.drawn.dpi)
            axis.set_label_text("\n".join(broken(probe, text, length)))
        probe.remove()

    def _start(self) -> None:
        """Give every axes a size near its final one: the numbers on it depend on it."""
        for block in self.blocks:
            for axes in filter(None, (block.axes, block.strip)):
                axes.set_position((0.2, 0.2, 0.7 / self.columns, 0.7 / self.columns))
        if self.bar is not None:
            self.bar.set_position((0.9, 0.2, 0.02, 0.6))

    def write_legends(self, common: Sequence[str] | None) -> None:
        """Write the legends, as wide as the columns are."""
        bar = self._bar_width()
        room = self.width - bar - 2.0 * _MARGIN * self.letter
        column = (room - (self.columns - 1) * _GAP * self.letter) / self.columns
        for block in self.blocks:
            size, title = float(block.axes.title.get_fontsize()), block.title
            if block.is_mathematics:
                probe = self.drawn.text(0.0, 0.0, "", fontsize=size)
                # beside the numbers of its axes
                title = "\n".join(broken(probe, title, (column - 5.0 * self.letter) * self.drawn.dpi))
                probe.remove()
            else:
                title = wrapped(title, size, column - 2.5 * self.letter)
            weight = "normal" if block.is_mathematics else "bold"
            block.axes.set_title(title, parse_math=block.is_mathematics, weight=weight)
        if common is None:
            self.legends = [
                add_legend(block.lowest, *entries(block), block.caption, column) for block in self.blocks
            ]
            return
        named: dict[str, Any] = {}
        for block in self.blocks:
            for handle, label in zip(*entries(block), strict=True):
                named.setdefault(label, handle)
        # a line that lies outside of one map and inside of another has one entry
        named = {
            label: each
            for label, each in named.items()
            if label.removesuffix(OUTSIDE) not in named.keys() - {label}
        }
        named = joined(named)
        room = self.width - 2.0 * _MARGIN * self.letter
        count = max(1, min(len(named), int(room / (_COLUMN * self.letter))))
        self.common = add_legend(
            self.blocks[0].axes, list(named.values()), list(named), common, room, columns=count
        )

    def place(self) -> None:
        """Measure the words around all axes, and give the axes what is left."""
        letter, columns, rows = self.letter, self.columns, self.rows
        margins = [
            [self._margins(axes) for axes in (block.axes, block.strip) if axes is not None]
            for block in self.blocks
        ]
        left = [
            max(m[0] for i, each in enumerate(margins) if i % columns == c for m in each)
            for c in range(columns)
        ]
        right = [
            max(m[2] for i, each in enumerate(margins) if i % columns == c for m in each)
            for c in range(columns)
        ]
        bar = self._bar_width()
        across = (
            self.width - bar - 2.0 * _MARGIN * letter - (columns - 1) * _GAP * letter - sum(left) - sum(right)
        ) / columns
        heights = self._heights(margins, across)
        total, up = heights.total, heights.panel
        high = up - (heights.strip + _CLOSE * letter if self.has_strip else 0.0)
        if across < _LEAST * letter or high < _LEAST * letter:
            self._refuse(across, high, total)
        if self.height is None:
            self.drawn.set_size_inches(self.width, total)
        top, x_left = total, 0.0
        if self.title is not None:
            height = self.drawn.get_size_inches()[1]
            self.title.set_position((_MARGIN * letter / self.width, 1.0 - _MARGIN * letter / height))
            top -= self._title_height()
        for row in range(rows):
            x_left = _MARGIN * letter
            for column in range(columns):
                i = row * columns + column
                x_left += left[column]
                if i < len(self.blocks):
                    self._place_block(i, x_left, top - heights.above[row], across, up, margins[i], heights)
                x_left += across + right[column] + _GAP * letter
            top -= heights.above[row] + up + heights.below[row]
        if self.common is not None:
            self._put_legend(self.common, _MARGIN * letter, top)
        if self.bar is not None:
            low, high = self._span()
            where = self.width - bar - _MARGIN * letter + _TO_BAR * letter
            self._set(self.bar, where, low, _BAR * letter, high - low)

    def _heights(self, margins: Any, across: float) -> "_Heights":
        letter, columns = self.letter, self.columns
        above, below = [], []
        for row in range(self.rows):
            some = range(row * columns, min((row + 1) * columns, len(self.blocks)))
            above.append(max(margins[i][0][3] for i in some) + _MARGIN * letter)
            legend = max((self._legend_height(i) for i in some), default=0.0)
            below.append(max(margins[i][-1][1] for i in some) + legend + _BELOW * letter)
        common = self._size(self.common)[1] + _BELOW * letter if self.common else 0.0
        fixed = sum(above) + sum(below) + common + self._title_height()
        extra, least = (_CLOSE * letter, _LEAST_STRIP * letter) if self.has_strip else (0.0, 0.0)
        share = _STRIP if self.has_strip else 0.0
        if self.height is None:
            shape = _SHAPE if any(block.panel.y is not None for block in self.blocks) else _PROFILE
            high = across * shape
            strip = max(share * high, least)
            panel = high + extra + strip
            return _Heights(above, below, panel, strip, fixed + self.rows * panel)
        panel = (self.height - fixed) / self.rows
        strip = max((panel - extra) * share / (1.0 + share), least)
        return _Heights(above, below, panel, strip, self.height)

    def _title_height(self) -> float:
        if self.title is None:
            return 0.0
        further = self.title.get_text().count("\n")
        return (_TITLE + _LINE * further) * self.letter

    def _legend_height(self, i: int) -> float:
        if self.common is not None or not self.legends or self.legends[i] is None:
            return 0.0
        return self._size(self.legends[i])[1] + _ABOVE * self.letter

    def _place_block(
        self, i: int, left: float, top: float, across: float, up: float, margins: Any, heights: "_Heights"
    ) -> None:
        block = self.blocks[i]
        high = up if block.strip is None else up - heights.strip - _CLOSE * self.letter
        self._set(block.axes, left, top - high, across, high)
        if block.strip is not None:
            self._set(block.strip, left, top - up, across, heights.strip)
        if self.common is None and self.legends:
            legend = self.legends[i]
            assert legend is not None
            wide = self._size(legend)[0]
            # under the axes, or further left if it is wider than they
            outer = left + across + margins[-1][2]
            start = max(min(left, outer - wide), left - margins[-1][0])
            self._put_legend(legend, start, top - up - margins[-1][1] - _ABOVE * self.letter)

    def _set(self, axes: "Axes", left: float, low: float, wide: float, high: float) -> None:
        width, height = self.drawn.get_size_inches()
        axes.set_position((left / width, low / height, wide / width, high / height))

    def _put_legend(self, legend: "Legend", left: float, top: float) -> None:
        # in the coordinates of the figure, so that it stays beside its axes if the figure is drawn larger
        width, height = self.drawn.get_size_inches()
        legend.set_bbox_to_anchor((left / width, top / height), transform=self.drawn.transFigure)

    def _size(self, legend: "Legend | None") -> tuple[float, float]:
        if legend is None:
            return 0.0, 0.0
        box = legend.get_window_extent()
        return box.width / self.drawn.dpi, box.height / self.drawn.dpi

    def _span(self) -> tuple[float, float]:
        """Return the bottom of the lowest and the top of the highest panel of the figure [in]."""
        height = self.drawn.get_size_inches()[1]
        low = min(block.lowest.get_position().y0 for block in self.blocks)
        return low * height, max(block.axes.get_position().y1 for block in self.blocks) * height

    def _bar_width(self) -> float:
        if self.bar is None:
            return 0.0
        return (_TO_BAR + _BAR) * self.letter + self._margins(self.bar)[2]

    def _margins(self, axes: "Axes") -> tuple[float, float, float, float]:
        """Return the room [in] of numbers and labels: left, below, right, above the axes."""
        tight, box = axes.get_tightbbox(for_layout_only=True), axes.get_window_extent()
        assert tight is not None
        around = (box.x0 - tight.x0, box.y0 - tight.y0, tight.x1 - box.x1, tight.y1 - box.y1)
        left, below, right, above = (max(each, 0.0) / self.drawn.dpi for each in around)
        return left, below, right, above

    def _refuse(self, across: float, up: float, total: float) -> None:
        least = _LEAST * self.letter
        needed = []
        # the height of panels follows their width where that of the figure is not given
        lacking = least - (across if self.height is not None else min(across, up))
        if lacking > 0.0:
            needed.append(f"width={_generous(self.width + lacking * self.columns)}")
        if up < least and self.height is not None:
            needed.append(f"height={_generous(total + (least - up) * self.rows)}")
        size = " and ".join(needed)
        raise RequestError(
            f"The figure has no room for its panels: beside labels, numbers and legends in letters of "
            f"{72.0 * self.letter:g} points they would be {25.4 * max(across, 0.0):.0f} mm wide and "
            f"{25.4 * max(up, 0.0):.0f} mm high; they need {25.4 * least:.0f} mm.",
            f"Give at least {size}, smaller letters, or fewer panels.",
        )


def _generous(inches: float) -> str:
    """Return a length that is enough, though labels take other room there: a tenth more, in steps of 5 mm."""
    return f"{5 * math.ceil(1.1 * 25.4 * inches / 5.0)}mm"


@dataclass(frozen=True)
class _Heights:
    """Heights [in]: above and below the panels of each row, of a panel with its strip, of a strip, of the figure."""

    above: list[float]
    below: list[float]
    panel: float
    strip: float
    total: float


def name_block(block: Block) -> bool:
    """Write names into a map that has its final size; return whether the legend lacks regions that have no name now."""
    panel, axes = block.panel, block.axes
    if panel.y is None:
        return False
    room = Room(axes)
    if panel.joined is None and panel.edges:
        for _, line in analytic_lines(panel)[:1]:
            if line.size and _is_level(line):
                name_line(room, panel.line_name, float(line[0]))
    new = []
    for name in name_regions(room, panel, [each for each in block.regions if each[0] not in block.pointed]):
        if name not in block.explained:
            new.append(name)
            block.pointed.append(name)
    for name, cells in block.regions:
        if name in block.pointed and block.symbols is None:
            point_at(room, panel, cells, pointer(block.regions, name))
    if panel.joined is not None:
        for side, text, height in zip(("upper", "lower"), panel.joined, joined_heights(panel), strict=True):
            label = f"{text} ({side} end)"
            if height is None or label in block.unnamed:
                continue
            if not name_end(room, text, (0.0, height)):
                new.append(label)
                block.unnamed.append(label)
    return bool(new)


def pointer(regions: Sequence[tuple[str, Truths]], name: str) -> dict[str, Any]:
    """Return the look of the marker of a region."""
    place = [each for each, _ in regions].index(name)
    return _POINTER | _POINTERS[place % len(_POINTERS)]


def entries(block: Block) -> tuple[list[Any], list[str]]:
    """Return handles and labels of a panel, the measurement first and regions without room last."""
    handles, labels = block.axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    order = sorted(named, key=lambda label: not isinstance(named[label], ErrorbarContainer))
    found = [named[label] for label in order]
    for name in block.pointed:
        has_symbol = block.symbols is not None
        found.append(block.symbols(name) if block.symbols else Line2D([], [], **pointer(block.regions, name)))
        order.append(name.replace("\n", ", ") if has_symbol else f"{name}, at the marker")
    for label in block.unnamed:
        found.append(Line2D([], [], linestyle="", marker="D", color=INK, markersize=4.5))
        order.append(label)
    return found, order


def add_legend(
    axes: "Axes",
    handles: list[Any],
    labels: list[str],
    caption: Sequence[str],
    width: float,
    columns: int = 1,
) -> "Legend":
    """Write a legend that is at most so wide [in], its lines broken where they have to be; it is not in any layout."""
    size = axes.figure.dpi * width
    probe = axes.figure.text(0.0, 0.0, "", fontsize=rcParams["legend.fontsize"])
    inside = size / columns - 4.5 * float(probe.get_fontsize()) * axes.figure.dpi / 72.0
    labels = ["\n".join(broken(probe, label, inside)) for label in labels]
    probe.set_fontsize(rcParams["legend.title_fontsize"] or rcParams["legend.fontsize"])
    title = "\n".join(line for part in caption if part for line in broken(probe, part, size))
    probe.remove()
    legend = axes.legend(
        handles, labels, title=title or None, loc="upper left", ncols=columns, alignment="left", frameon=False,
        borderpad=0.0, borderaxespad=0.0, handlelength=2.4,
    )  # fmt: skip
    legend.set_in_layout(False)
    return legend


def _is_level(line: Any) -> bool:
    return bool((abs(line - line[0]) <= 1e-9 * abs(line[0])).all())
