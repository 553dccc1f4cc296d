"""The empty figure on which all others are drawn, in the style of this package."""

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def _style(font_size: float) -> dict[Any, Any]:
    """Return the matplotlib settings for a font size [points]."""
    return {
        "font.family": "DejaVu Sans",
        "font.size": font_size,
        "axes.titlesize": 9.0 / 8.0 * font_size,
        "axes.titleweight": "bold",
        "axes.titlelocation": "left",
        "axes.labelsize": font_size,
        "xtick.labelsize": 7.5 / 8.0 * font_size,
        "ytick.labelsize": 7.5 / 8.0 * font_size,
        "legend.fontsize": 7.5 / 8.0 * font_size,
        "legend.title_fontsize": 7.0 / 8.0 * font_size,
        "hatch.linewidth": 0.6,
        "axes.linewidth": 0.7,
        "pdf.fonttype": 42,
        "svg.hashsalt": "eulerdisk",
    }


#: matplotlib's own defaults for everything that the style does not set, except the backend, which the program chooses.
_DEFAULTS: dict[Any, Any] = {
    name: value for name, value in matplotlib.rcParamsDefault.items() if not name.startswith("backend")
}


class ShownFigure(Figure):
    """A figure that shows itself in a notebook: IPython shows a plain one only if pyplot was imported."""

    def _repr_png_(self) -> bytes:
        drawn = BytesIO()
        self.savefig(drawn, format="png")
        return drawn.getvalue()


@contextmanager
def styled(font_size: float = 8.0) -> Iterator[None]:
    """Draw only in the style of this package; matplotlib settings from files or programs have no effect."""
    with matplotlib.rc_context(_DEFAULTS | _style(font_size)):
        yield


@contextmanager
def sheet(
    width: float, height: float, font_size: float = 8.0, layout: str = "constrained"
) -> Iterator[Figure]:
    """Yield an empty figure [in] in the style of this package, on an Agg canvas, not registered with pyplot."""
    with styled(font_size):
        drawn = ShownFigure(figsize=(width, height), layout=layout)  # type: ignore[arg-type]
        FigureCanvasAgg(drawn)
        yield drawn
