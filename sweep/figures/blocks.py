"""A panel in a figure with its words: names in the map, and the legend below it."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from matplotlib import rcParams
from matplotlib.container import ErrorbarContainer
from matplotlib.lines import Line2D
from matplotlib.text import Text

from sweep.figures.drawing import INK, analytic_lines, joined_heights
from sweep.figures.panels import Panel
from sweep.figures.room import Room, name_end, name_line, name_regions, point_at
from sweep.model.quantity import Truths

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.legend import Legend

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

#: What stays together where a line is broken: a word, mathematics, a unit in brackets.
_PIECES = re.compile(r"(?:\([^()]*\)|\$[^$]*\$|[^ $(]|\()+")


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


def broken(probe: Text, text: str, width: float) -> list[str]:
    """Return a text in lines that are at most so wide [dots]; mathematics stays together."""
    lines: list[str] = []
    for piece in _PIECES.findall(text):
        longer = f"{lines[-1]} {piece}" if lines else piece
        probe.set_text(longer)
        if lines and probe.get_window_extent().width > width:
            lines.append(piece)
        else:
            lines[-1:] = [longer]
    return lines


def _is_level(line: Any) -> bool:
    return bool((abs(line - line[0]) <= 1e-9 * abs(line[0])).all())
