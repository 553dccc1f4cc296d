"""A small map of an atlas for a notebook: verdicts, the measured boundary and the analytic line, as SVG.

Without matplotlib, which takes longer to load than such a map to draw.
"""

import html
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from sweep.model.quantity import STABLE, UNSTABLE

#: Size of the map, and the space for words on its left and below it, in dots of the screen.
_WIDTH, _HEIGHT, _LEFT, _BELOW = 240, 150, 18, 18

#: Cells of the picture along each axis at most; of more, some are left out.
_MOST_CELLS = 120

#: Colours of verdicts, which everybody tells apart; the rest is undecided.
COLOURS = {STABLE: "#9ecae1", UNSTABLE: "#e6844a"}
UNDECIDED_COLOUR = "#bdbdbd"

Array = npt.NDArray[np.float64]

#: A line over the map: the axis of its values is the one upward. Values, in SI, one for each place across.
Line = tuple[Array, str]


def thumbnail(
    verdicts: npt.NDArray[np.int8],
    up: Array,
    lines: Sequence[Line],
    labels: tuple[str, str],
) -> str:
    """Return an SVG of a plane of verdicts, each cell as large as any other, whatever the spacing of the axes.

    Parameters
    ----------
    verdicts : array of int8, shape (len(up), n)
        STABLE, UNSTABLE or another code.
    up : array of float, shape (m,)
        The values of the axis upward, increasing or decreasing [SI].
    lines : sequence of (array of float, shape (n,), str)
        Values along the axis upward, NaN where there is none, and the style of the line in SVG.
    labels : (str, str)
        What stands below, and beside the map.
    """
    rows, columns = verdicts.shape
    cells = verdicts[np.ix_(_some(rows), _some(columns))][::-1]
    parts = [f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="{UNDECIDED_COLOUR}"/>']
    parts += [f'<path fill="{colour}" d="{_runs(cells == code)}"/>' for code, colour in COLOURS.items()]
    parts += [
        f'<polyline fill="none" {style} points="{points}"/>'
        for values, style in lines
        for points in _points(values, up)
    ]
    across, upward = (html.escape(label) for label in labels)
    words = 'font-size="11" fill="currentColor" text-anchor="middle" font-family="sans-serif"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH + _LEFT}" height="{_HEIGHT + _BELOW}" role="img" '
        f'aria-label="map of verdicts"><g transform="translate({_LEFT} 0)">{"".join(parts)}</g>'
        f'<text x="{_LEFT + _WIDTH / 2:g}" y="{_HEIGHT + 13}" {words}>{across}</text>'
        f'<text transform="translate(12 {_HEIGHT / 2:g}) rotate(-90)" {words}>{upward}</text></svg>'
    )


def _some(count: int) -> npt.NDArray[np.intp]:
    """Return at most so many indices as a map shows, evenly spread."""
    return np.unique(np.linspace(0, count - 1, min(count, _MOST_CELLS)).round().astype(np.intp))


def _runs(where: npt.NDArray[np.bool_]) -> str:
    """Return the path of the cells of a kind: one rectangle for each run of them in a row, first row on top."""
    rows, columns = where.shape
    high, wide = _HEIGHT / rows, _WIDTH / columns
    path = []
    for row, line in enumerate(where):
        ends = np.flatnonzero(np.diff(np.concatenate(([False], line, [False])).astype(np.int8)))
        for start, stop in ends.reshape(-1, 2):
            # a little larger than it is: no gaps shine through between rows
            path.append(
                f"M{start * wide:.4g} {row * high:.4g}h{(stop - start) * wide:.4g}v{high + 0.3:.4g}H{start * wide:.4g}z"
            )
    return "".join(path)


def _points(values: Array, up: Array) -> Iterator[str]:
    """Yield the points of each piece of a line; it has gaps where a value is missing or outside the map."""
    count, order = len(values), np.argsort(up)
    place = np.interp(values, up[order], order.astype(float), left=np.nan, right=np.nan)
    x = (np.arange(count) + 0.5) * (_WIDTH / count)
    y = _HEIGHT - (place + 0.5) * (_HEIGHT / len(up))
    there = np.isfinite(y)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], there, [False])).astype(np.int8)))
    for start, stop in edges.reshape(-1, 2):
        if stop - start == 1:
            # a single point would not be seen
            half = 0.5 * _WIDTH / count
            yield f"{x[start] - half:.4g},{y[start]:.4g} {x[start] + half:.4g},{y[start]:.4g}"
        else:
            step = max(1, (stop - start) // _WIDTH)
            chosen = np.unique(np.append(np.arange(start, stop, step), stop - 1))
            yield " ".join(f"{x[i]:.4g},{y[i]:.4g}" for i in chosen)
