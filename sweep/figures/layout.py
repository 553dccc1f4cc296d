"""Lay out the panels of a figure: axes as large as labels and legends allow, without overlapping text.

The positions of all axes are computed once, from the sizes of the texts, and then fixed: matplotlib's own layouts let a
legend that is wider than its panel take width from the panel.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context, rcParams
from matplotlib.container import ErrorbarContainer
from matplotlib.transforms import ScaledTranslation

from sweep.errors import RequestError
from sweep.figures.drawing import OUTSIDE, Bar, analytic_lines, joined, joined_heights
from sweep.figures.look import DPI, Look, columns_of, inches, size_of
from sweep.figures.panels import Panel
from sweep.figures.room import Room, name_end, name_line, name_regions
from sweep.figures.scales import name_ends, thin_ticks
from sweep.figures.sheet import sheet
from sweep.figures.texts import broken, wrapped
from sweep.model.quantity import Array, Truths

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend

#: Gaps: around the figure, between columns, between map and strip, above and below a legend. They and the lengths below
#: are in multiples of the letter size, except where a unit is given.
_MARGIN, _GAP, _CLOSE, _ABOVE, _BELOW = 0.52, 1.4, 1.2, 0.6, 0.8

#: Width of the colour bar, and its distance from the maps.
_BAR, _TO_BAR = 1.0, 1.2

#: Largest width of a figure of one column at which the colour bar is above the maps, which would be narrow next to it.
_NARROW = 36.0

#: Height of a page [in]: a figure of several rows is at most this high if its panels have room in it.
PAGE = 11.7

#: Height / width of a map, and of a profile; height of a strip / height of its map; least height of a strip. Panels of
#: points are at most as high as the last number: they have no cells whose shape must be visible.
_SHAPE, _PROFILE, _STRIP, _LEAST_STRIP, _POINTS = 0.95, 0.65, 0.3, 4.6, 29.0

#: Height of the title of a figure, and of each further line of the title.
_TITLE, _LINE = 2.2, 1.35

#: Least width and height of a panel, and the width that a legend below all panels needs for each column.
_LEAST, _COLUMN = 7.0, 32.0

#: Factor by which text can be wider at the resolution of a file than at the resolution at which it is measured.
_HINTED = 1.05

#: Number of times that sizes and ticks, which depend on each other, are computed.
_ROUNDS = 2


@dataclass
class Block:
    """A panel in a figure: its map or profile, the strip below it if there is one, and its texts.

    `regions` are the names and cells that are written into a map where there is room. `signs` are labelled handles for
    the legend in addition to those of the axes. `letter`, as in ``(a)``, distinguishes the panel from others.
    """

    axes: "Axes"
    panel: Panel | None = None
    title: str = ""
    caption: tuple[str, ...] = ()
    strip: "Axes | None" = None
    regions: Sequence[tuple[str, Truths]] = ()
    is_mathematics: bool = False
    signs: Sequence[Any] = ()
    letter: str = ""

    @property
    def lowest(self) -> "Axes":
        """The lower of the two axes."""
        return self.strip or self.axes

    def legend(self) -> dict[str, Any]:
        """Return the labels and handles of the legend, with the measurement first."""
        handles, labels = self.axes.get_legend_handles_labels()
        named = {each.get_label(): each for each in self.signs} | dict(zip(labels, handles, strict=True))
        order = sorted(named, key=lambda label: not isinstance(named[label], ErrorbarContainer))
        return {label: named[label] for label in order}


#: Labels of a legend -> their short form in a figure without a caption.
_SHORT = (
    (re.compile(r"^\w+ boundary with its bracket(, upper|, lower|).*"), r"measured\1"),
    (re.compile(rf"^(analytic|predicted)\b.*?({re.escape(OUTSIDE)}|)$"), r"\1\2"),
)


def figure_of(
    items: Sequence[Any],
    block: "Callable[[Axes, Any], Block]",
    look: Look,
    widths: tuple[float, float],
    *,
    columns: int | None = None,
    bar: Bar | None = None,
    common: Sequence[str] | None = None,
    title: str = "",
    axes: "Axes | None" = None,
    files: Sequence[str] = (),
) -> "Figure":
    """Draw a figure with one panel for each item.

    Parameters
    ----------
    items : sequence
        The items, row by row.
    block : callable
        Draws an item into axes, and returns them with their texts.
    look : Look
        The sizes of the figure. Without a height, the maps get a good shape.
    widths : (float, float)
        Default width and least width of a panel [in].
    columns : int, optional
        Panels in a row; by default as many as fit.
    bar : Bar, optional
        The colour bar: to the right of all panels, or above them in a narrow figure.
    common : sequence of str, optional
        Caption of a single legend below all panels; without it, each panel has its own legend.
    title : str
        Title of the whole figure.
    axes : Axes, optional
        Axes into which the only item is drawn.
    files : sequence of str
        Names of the items' files, to label the panels together with letters; empty where a name is unknown.

    Returns
    -------
    Figure
        Its label contains the text for a caption: everything in title, caption, legend and colour bar.

    Raises
    ------
    RequestError
        If there is no room, or there are several items for a caller's axes.
    """
    if axes is not None:
        return _draw_in_axes(axes, items, block, look, bar)
    columns = columns or columns_of(len(items), look, *widths)
    with sheet(*size_of(columns, look, widths[0]), look.font_size, "none") as drawn:
        blocks = [block(drawn.add_axes((0.2, 0.2, 0.6, 0.6)), each) for each in items]
        if len(blocks) > 1:
            _add_letters(blocks, files)
        drawn.set_label(_text(title, blocks, common or (), bar))
        layout = _Layout(drawn, blocks, columns, look, bar, title)
        layout.write_legends(common)
        for _ in range(_ROUNDS):
            layout.place()
            layout.break_labels()
        for each in layout.axes:
            thin_ticks(each)
        if layout.bar is not None:
            name_ends(layout.bar)
        layout.place()
        for made in blocks:
            _write_names(made)
    return drawn


def _draw_in_axes(
    axes: "Axes", items: Sequence[Any], block: "Callable[[Axes, Any], Block]", look: Look, bar: Bar | None
) -> "Figure":
    """Draw a panel into a caller's axes, which keep their position, with the legend below their labels.

    The legend takes part in the layout of the figure.
    """
    if len(items) > 1:
        raise RequestError(
            f"These axes can show only one atlas; got {len(items)}.",
            "Draw each atlas into its own axes, or leave out ax.",
            "ax",
        )
    drawn, dots = axes.get_figure(root=True), axes.figure.dpi
    assert drawn is not None
    with nullcontext() if look.font_size == Look.font_size else rc_context({"font.size": look.font_size}):
        made = block(axes, items[0])
        added = bar.draw(drawn, beside=axes) if bar and "bar" not in look.without else None
        drawn.draw_without_rendering()
        room = axes.get_window_extent().width / dots
        title = "" if "title" in look.without else made.title
        axes.set_title(wrapped(title, float(axes.title.get_fontsize()), room), parse_math=False)
        drawn.draw_without_rendering()
        box = axes.get_window_extent()
        legend = _add_legend(axes, made.legend(), made.caption, box.width / dots, look.without)
        tight = axes.get_tightbbox(for_layout_only=True)
        assert tight is not None
        shift = ScaledTranslation(
            0.0, (tight.y0 - box.y0) / dots - 0.5 * _letter(), axes.figure.dpi_scale_trans
        )
        legend.set_bbox_to_anchor((0.0, 0.0), transform=axes.transAxes + shift)
        legend.set_in_layout(True)
        # the legend may have moved the axes, and the space for names depends on their size
        drawn.draw_without_rendering()
        thin_ticks(axes)
        _write_names(made)
        if added is not None:
            name_ends(added)
    return drawn


def _letter() -> float:
    """Return the letter size [in]."""
    return float(rcParams["font.size"]) / 72.0


class _Layout:
    """The positions of all axes of a figure [in]."""

    def __init__(
        self,
        drawn: "Figure",
        blocks: Sequence[Block],
        columns: int,
        look: Look,
        bar: Bar | None,
        title: str,
    ) -> None:
        self.drawn, self.blocks, self.columns, self.without = drawn, blocks, columns, look.without
        self.dpi = look.dpi or DPI
        self.height, self.letter, self.width = inches(look.height), _letter(), drawn.get_size_inches()[0]
        self.rows = -(-len(blocks) // columns)
        # free places at the end of the last row, where a common legend has room
        self.empty = 0 if self.height else self.rows * columns - len(blocks)
        if "bar" in self.without:
            bar = None
        self.bar_is_horizontal = bar is not None and columns == 1 and self.width <= _NARROW * self.letter
        if self.bar_is_horizontal and len(blocks) == 1:
            # write the panel's title above the bar
            title, blocks[0].title = blocks[0].title, ""
        self.bar = None if bar is None else bar.draw(drawn, horizontal=self.bar_is_horizontal)
        self.has_strip = any(block.strip is not None for block in blocks)
        self.common: Legend | None = None
        self.legends: list[Legend] = []
        size = float(rcParams["axes.titlesize"])
        text = "" if "title" in self.without else wrapped(title, size, self.width - 2.0 * self.letter)
        self.title = drawn.text(0.0, 1.0, text, size=size, weight="bold", va="top", parse_math=False)
        every = [*(each for block in blocks for each in (block.axes, block.strip)), self.bar]
        self.axes = [each for each in every if each is not None]
        self.labels = [
            (axis, which, axis.get_label_text())
            for axes in self.axes
            for each in (axes, *axes.child_axes)
            for which, axis in ((0, each.xaxis), (1, each.yaxis))
        ]
        # almost the final sizes, because the numbers on the axes depend on them
        for axes in self.axes:
            axes.set_position((0.2, 0.2, 0.7 / columns, 0.7 / columns))
        for block in blocks:
            if block.strip is not None:
                drawn.align_ylabels([block.axes, block.strip])
            self._write_title(block)

    def _write_title(self, block: Block) -> None:
        """Write the title of a panel, in lines as wide as the column."""
        title, size, column = block.title, float(block.axes.title.get_fontsize()), self._column()
        if block.is_mathematics:
            probe = self.drawn.text(0.0, 0.0, "", fontsize=size)
            # leave room for the numbers of the axes
            title = "\n".join(broken(probe, title, (column - 5.0 * self.letter) * self.drawn.dpi))
            probe.remove()
        else:
            title = block.letter if "title" in self.without else f"{block.letter} {title}".strip()
            title = wrapped(title, size, column - 2.5 * self.letter)
        weight = "normal" if block.is_mathematics else "bold"
        block.axes.set_title(title, parse_math=block.is_mathematics, weight=weight)

    def write_legends(self, common: Sequence[str] | None) -> None:
        """Write legends as wide as the columns, or one legend with a caption common to all panels."""
        if self.without >= {"caption", "legend"}:
            return
        found = [block.legend() for block in self.blocks]
        if common is None:
            for block, named in zip(self.blocks, found, strict=True):
                # the labels of signs are short
                columns = 2 if len(named) == len(block.signs) else 1
                room = self._column()
                legend = _add_legend(block.lowest, named, block.caption, room, self.without, columns)
                self.legends.append(legend)
            return
        named = _merge_entries(found)
        # a legend has no numbers on its left
        room = self.empty * self._column() - 2.5 * self.letter
        if self.empty:
            self.common = self._add_common(named, common, room)
            self.empty = self.empty if _HINTED * self._size(self.common)[0] <= room else 0
        if not self.empty:
            self.common = self._add_common(named, common, self.width - 2.0 * _MARGIN * self.letter)

    def _add_common(self, named: Mapping[str, Any], caption: Sequence[str], room: float) -> "Legend":
        count = max(1, min(len(named), int(room / (_COLUMN * self.letter))))
        return _add_legend(self.blocks[0].axes, named, caption, room, self.without, count)

    def break_labels(self) -> None:
        """Break labels that are longer than their axes."""
        probe = self.drawn.text(0.0, 0.0, "")
        for axis, which, text in self.labels:
            box = axis.axes.get_window_extent()
            probe.set_fontsize(axis.label.get_fontsize())
            # a strip is too low for its label, but has room above it
            length = max((box.width, box.height)[which], 6.0 * self.letter * self.drawn.dpi)
            axis.set_label_text("\n".join(broken(probe, text, length)))
        probe.remove()

    def place(self) -> None:
        """Measure the texts around all axes, and give the axes the remaining space."""
        letter, margin = self.letter, _MARGIN * self.letter
        # left, below, right, above, and the height of the legend; all 0 for a free place
        around = np.zeros((self.rows * self.columns, 5))
        for i, block in enumerate(self.blocks):
            around[i, :4] = self._around(block.axes)
            if block.strip is not None:
                low = self._around(block.strip)
                around[i, :4] = np.maximum(around[i, :4], low * (1, 0, 1, 0))
                around[i, 1] = low[1]
            around[i, 4] = self._size(self.legends[i])[1] + _ABOVE * letter if self.legends else 0.0
        left, below, right, above, legends = around.reshape(self.rows, self.columns, 5).transpose(2, 0, 1)
        tops = above.max(axis=1) + margin
        feet = below.max(axis=1) + legends.max(axis=1) + _BELOW * letter
        across = self._column() - (left.max(axis=0) + right.max(axis=0)).mean()
        foot = self._size(self.common)[1] + _BELOW * letter if self.common else 0.0
        head = (_TITLE + _LINE * self.title.get_text().count("\n")) * letter if self.title.get_text() else 0.0
        if self.bar is not None and self.bar_is_horizontal:
            head += margin + float(self._around(self.bar)[3]) + _BAR * letter
        fixed = tops.sum() + feet.sum() + head
        panel, strip, total = self._heights(across, fixed + (0.0 if self.empty else foot))
        if self.empty:
            # height by which the legend exceeds the free place
            total += max(0.0, foot - panel - feet[-1])
        if self.height is None:
            self.drawn.set_size_inches(self.width, total)
        lefts = margin + np.cumsum(left.max(axis=0) + across + right.max(axis=0) + _GAP * letter)
        lefts -= across + right.max(axis=0) + _GAP * letter
        highs = total - head - np.cumsum(tops + panel + feet) + panel + feet
        for i, block in enumerate(self.blocks):
            x, top = lefts[i % self.columns], highs[i // self.columns]
            low = top - panel + (0.0 if block.strip is None else strip + _CLOSE * letter)
            self._set(block.axes, x, low, across, top - low)
            if block.strip is not None:
                self._set(block.strip, x, top - panel, across, strip)
            if self.legends:
                # below the axes, or further left if the legend is wider than they are
                start = min(x, x + across + around[i, 2] - _HINTED * self._size(self.legends[i])[0])
                foot_of_labels = top - panel - around[i, 1] - _ABOVE * letter
                self._put_legend(self.legends[i], max(start, x - around[i, 0]), foot_of_labels)
        if self.common is not None and self.empty:
            self._put_legend(self.common, lefts[-self.empty] - left.max(axis=0)[-self.empty], highs[-1])
        elif self.common is not None:
            self._put_legend(self.common, margin, highs[-1] - panel - feet[-1])
        self.title.set_position((margin / self.width, 1.0 - margin / total))
        if self.bar is not None and self.bar_is_horizontal:
            self._set(self.bar, lefts[0], total - head, across, _BAR * letter)
        elif self.bar is not None:
            low = min(block.lowest.get_position().y0 for block in self.blocks) * total
            where = self.width - self._bar_width() - margin + _TO_BAR * letter
            self._set(self.bar, where, low, _BAR * letter, highs[0] - low)

    def _column(self) -> float:
        """Return the width of a column including its labels."""
        gaps = 2.0 * _MARGIN + (self.columns - 1) * _GAP
        return float(self.width - self._bar_width() - gaps * self.letter) / self.columns

    def _bar_width(self) -> float:
        if self.bar is None or self.bar_is_horizontal:
            return 0.0
        return (_TO_BAR + _BAR) * self.letter + float(self._around(self.bar)[2])

    def _heights(self, across: float, fixed: float) -> tuple[float, float, float]:
        """Return the heights of a panel with its strip, of a strip, and of the figure.

        `fixed` is the height of all texts.
        """
        letter = self.letter
        gap, least, share = (_CLOSE * letter, _LEAST_STRIP * letter, _STRIP) if self.has_strip else (0.0,) * 3
        total = self.height
        if total is None:
            flat = all(block.panel is not None and block.panel.y is None for block in self.blocks)
            high = across * (_PROFILE if flat else _SHAPE)
            if all(block.panel is None for block in self.blocks):
                high = min(high, _POINTS * letter)
            strip = max(share * high, least)
            panel = high + gap + strip
            total = fixed + self.rows * panel
            # make panels lower so that they fit on a page, if they keep half their height
            if total > PAGE and fixed + self.rows * (gap + strip + 0.5 * high) <= PAGE:
                total = PAGE
        panel = (total - fixed) / self.rows
        strip = max((panel - gap) * share / (1.0 + share), least) if share else 0.0
        self._check_room(across, panel - strip - gap, total)
        return panel, strip, total

    def _check_room(self, across: float, up: float, total: float) -> None:
        least = _LEAST * self.letter
        if min(across, up) >= least:
            return
        needed = []
        # unless the figure's height is given, the height of panels follows from their width
        lacking = least - (across if self.height is not None else min(across, up))
        if lacking > 0.0:
            needed.append(f"width={_round_up(self.width + lacking * self.columns)}")
        if up < least and self.height is not None:
            needed.append(f"height={_round_up(total + (least - up) * self.rows)}")
        raise RequestError(
            f"The figure has no room for its panels: after labels, numbers and legends in letters of "
            f"{72.0 * self.letter:g} points they would be {25.4 * max(across, 0.0):.0f} mm wide and "
            f"{25.4 * max(up, 0.0):.0f} mm high; they need {25.4 * least:.0f} mm.",
            f"Give at least {' and '.join(needed)}, a smaller font_size, or fewer panels.",
        )

    def _set(self, axes: "Axes", left: float, low: float, wide: float, high: float) -> None:
        width, height = self.drawn.get_size_inches()
        # whole dots of a png make sharp cells and a small file
        left, low, wide, high = np.round([self.dpi * each for each in (left, low, wide, high)]) / self.dpi
        axes.set_position((left / width, low / height, wide / width, high / height))

    def _put_legend(self, legend: "Legend", left: float, top: float) -> None:
        # in figure coordinates, so that the legend stays next to its axes if the figure is drawn larger
        width, height = self.drawn.get_size_inches()
        legend.set_bbox_to_anchor((left / width, top / height), transform=self.drawn.transFigure)

    def _size(self, legend: "Legend") -> Array:
        return np.array(legend.get_window_extent().size) / self.drawn.dpi

    def _around(self, axes: "Axes") -> Array:
        """Return the space [in] that numbers and labels need around axes: left, below, right, above."""
        tight, box = axes.get_tightbbox(for_layout_only=True), axes.get_window_extent()
        assert tight is not None
        found = np.array([box.x0 - tight.x0, box.y0 - tight.y0, tight.x1 - box.x1, tight.y1 - box.y1])
        return np.asarray(np.maximum(found, 0.0) / self.drawn.dpi)


def _round_up(inches: float) -> str:
    """Return a length with a margin for labels that change with it: a tenth more, in steps of 5 mm."""
    return f"{5 * math.ceil(1.1 * 25.4 * inches / 5.0)}mm"


def _write_names(block: Block) -> None:
    """Write names into a map in its final size, except those that have no room."""
    panel = block.panel
    if panel is None or panel.y is None:
        return
    room = Room(block.axes)
    if panel.joined is None and panel.edges:
        for _, line in analytic_lines(panel)[:1]:
            if line.size and bool((abs(line - line[0]) <= 1e-9 * abs(line[0])).all()):
                name_line(room, panel.line_name, float(line[0]))
    name_regions(room, panel, block.regions)
    if panel.joined is not None:
        for text, height in zip(panel.joined, joined_heights(panel), strict=True):
            if height is not None:
                name_end(room, text, (0.0, height))


def _merge_entries(found: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the entries of several legends as those of a single one."""
    every = {label: handle for named in reversed(found) for label, handle in named.items()}
    order = dict.fromkeys(label for named in found for label in named)
    # a line that is outside one map and inside another gets one entry
    once = [each for each in order if each.removesuffix(OUTSIDE) not in order.keys() - {each}]
    return joined({label: every[label] for label in once})


def _add_letters(blocks: Sequence[Block], files: Sequence[str]) -> None:
    """Give panels of several atlases letters and the names of their files."""
    for i, (block, name) in enumerate(zip(blocks, files, strict=False)):
        block.letter = f"({ascii_lowercase[i] if i < len(ascii_lowercase) else i + 1})"
        block.caption = (name, *block.caption) if name else block.caption


def _text(title: str, blocks: Sequence[Block], common: Sequence[str], bar: Bar | None) -> str:
    """Return the texts in titles, captions, legends and the colour bar of a figure, one line for each part.

    Formulas are LaTeX.
    """
    parts = [title, *common]
    if common:
        parts += _merge_entries([block.legend() for block in blocks])
    else:
        parts += [
            part for each in blocks for part in (f"{each.letter} {each.title}", *each.caption, *each.legend())
        ]
    parts += [f"colours: {bar.label}"] if bar else []
    return "\n".join(" ".join(each.split()) for each in parts if each)


def _add_legend(
    axes: "Axes",
    named: Mapping[str, Any],
    caption: Sequence[str],
    width: float,
    without: frozenset[str],
    columns: int = 1,
) -> "Legend":
    """Write a legend that is at most `width` wide [in], with broken lines if necessary; no layout includes it.

    Without a caption, the labels are short, and as many entries as fit are side by side.
    """
    if "legend" in without:
        named = {}
    if "caption" in without:
        caption = ()
        for words, short in _SHORT:
            named = {words.sub(short, label): handle for label, handle in named.items()}
    size = axes.figure.dpi * width
    probe = axes.figure.text(0.0, 0.0, "", fontsize=rcParams["legend.fontsize"])
    inside = size / columns - 4.5 * float(probe.get_fontsize()) * axes.figure.dpi / 72.0
    labels = ["\n".join(broken(probe, label, inside)) for label in named]
    probe.set_fontsize(rcParams["legend.title_fontsize"] or rcParams["legend.fontsize"])
    title = "\n".join(line for part in caption if part for line in broken(probe, part, size))
    probe.remove()
    for count in range(max(len(labels), 1), 0, -1) if "caption" in without else (columns,):
        legend = axes.legend(
            list(named.values()), labels, title=title or None, loc="upper left", ncols=count, alignment="left",
            frameon=False, borderpad=0.0, borderaxespad=0.0, handlelength=2.4, columnspacing=1.5,
        )  # fmt: skip
        if _HINTED * legend.get_window_extent().width <= size:
            break
    legend.set_in_layout(False)
    return legend
