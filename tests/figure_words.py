"""The words of a figure and their places: the texts that its canvas draws, by the renderer's boxes."""

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

#: Dots that boxes may extend beyond a figure, or into each other: letters are smaller than their boxes.
SLACK = 1.5


def words_drawn(figure: Figure) -> list[tuple[Text, Bbox]]:
    """Return every drawn text with its box; numbers on axes count only if they are within the axes."""
    found: list[Text] = []
    draw = Text.draw

    def noting(self: Text, renderer: Any, *rest: Any, **words: Any) -> None:
        if self.get_visible() and self.get_text().strip():
            found.append(self)
        draw(self, renderer, *rest, **words)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Text, "draw", noting)
        figure.draw_without_rendering()
    return [(each, Text.get_window_extent(each)) for each in dict.fromkeys(found)]


def misplaced(figure: Figure) -> list[str]:
    """Return the faults of a figure's words: outside the figure, overlapping, or cut."""
    words, sheet = words_drawn(figure), figure.bbox
    assert words
    wrong = [f"cut: {each.get_text()}" for each, _ in words if each.get_text().endswith("\u2026")]
    for each, box in words:
        if min(box.x0 - sheet.x0, box.y0 - sheet.y0, sheet.x1 - box.x1, sheet.y1 - box.y1) < -SLACK:
            wrong.append(f"outside: {each.get_text()}")
    # The box of a slanted text is larger than the area it covers.
    level = [(each.get_text(), box) for each, box in words if each.get_rotation() % 90.0 == 0.0]
    for (one, a), (other, b) in itertools.combinations(level, 2):
        if min(a.x1, b.x1) - max(a.x0, b.x0) > SLACK and min(a.y1, b.y1) - max(a.y0, b.y0) > SLACK:
            wrong.append(f"overlap: {one} / {other}")
    return wrong


@contextmanager
def watched() -> Iterator[list[tuple[str, list[str]]]]:
    """Record the faults of the words of every saved figure, in its size and resolution."""
    noted: list[tuple[str, list[str]]] = []
    save = Figure.savefig

    def noting(self: Figure, name: Any, **words: Any) -> None:
        save(self, name, **words)
        noted.append((str(name), misplaced(self)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", noting)
        yield noted
