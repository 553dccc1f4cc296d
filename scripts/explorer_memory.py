"""The memory of an explorer's page and its server, and whether it grows: trends reveal leaks."""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from explorer_browser import Served

if TYPE_CHECKING:
    from playwright.sync_api import CDPSession, Page

#: Quantity -> unit, and largest growth in a thousand actions, by the trend of the last two thirds of the measurements;
#: or in all of these, if they have fewer actions, because a page that has saved a picture keeps a document of 100 nodes
#: for it.
#:
#: A thousand actions of a `Visitor` choose some 200 starts, move as many sliders and show 2000 windows. That is enough
#: to detect a leak in any of these: a motion has 0.3 MB of samples, a panel 300 elements and 30 listeners, a path four
#: WebGL objects, a window 0.2 to 5 MB of buffers. Without a leak, the numbers of buffers, listeners and WebGL objects
#: are constant. The heap grows by the code that the browser compiles, and by its list of slow events: 3 MB in the first
#: thousand actions.
GROWTH: Mapping[str, tuple[str, float]] = {
    "heap": ("MB", 5.0),
    "buffers": ("MB", 1.0),
    "nodes": ("", 200.0),
    "listeners": ("", 10.0),
    "documents": ("", 2.0),
    "graphics": ("", 8.0),
    "server": ("MB", 30.0),
}

#: Largest value at any time.
MOST = {"contexts": 2.0, "server": 600.0, "peak": 600.0}

#: Least number of measurements for a trend; the last two thirds of fewer would say nothing.
LEAST_MEASUREMENTS = 9

#: Script to run before the page: counts the objects of each WebGL context. A context that was collected or lost has
#: none.
COUNT_GRAPHICS = """
    window.contextsOfWebGL = [];
    const ordinary = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
      const context = ordinary.call(this, kind, ...rest);
      const known = window.contextsOfWebGL.some((each) => each.deref() === context);
      if (context && kind.startsWith("webgl") && !known) {
        context.held = 0;
        window.contextsOfWebGL.push(new WeakRef(context));
      }
      return context;
    };
    for (const kind of ["Buffer", "Framebuffer", "Program", "Renderbuffer", "Texture", "VertexArray"]) {
      const { [`create${kind}`]: make, [`delete${kind}`]: free } = WebGL2RenderingContext.prototype;
      WebGL2RenderingContext.prototype[`create${kind}`] = function () {
        this.held += 1;
        return make.call(this);
      };
      WebGL2RenderingContext.prototype[`delete${kind}`] = function (object) {
        if (object) this.held -= 1;
        free.call(this, object);
      };
    }
"""

_LIVING = "window.contextsOfWebGL.map((each) => each.deref()).filter((each) => each && !each.isContextLost())"


class LeakError(Exception):
    """Something exceeds its limit; the text says what, and by how much."""


@dataclass
class Memory:
    """The measurements of one page.

    Parameters
    ----------
    page : Page
        The page, in which `COUNT_GRAPHICS` was run first.
    devtools : CDPSession
        The devtools session of this page.
    server : Served
    """

    page: Page
    devtools: CDPSession
    server: Served
    #: Number of actions before each measurement, and the measured values.
    measured: list[tuple[int, Mapping[str, float]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Make the browser count."""
        self.devtools.send("Performance.enable")

    def graphics(self) -> float:
        """Return the number of objects in all WebGL contexts: buffers, textures, programs."""
        return float(self.page.evaluate(f"{_LIVING}.reduce((sum, each) => sum + each.held, 0)"))

    def contexts(self) -> float:
        """Return the number of WebGL contexts, of which browsers keep only a few."""
        return float(self.page.evaluate(f"{_LIVING}.length"))

    def take(self, actions: int, graphics: float) -> Mapping[str, float]:
        """Collect garbage and measure.

        Parameters
        ----------
        actions : int
            Number of actions so far.
        graphics : float
            Number of WebGL objects while something was drawn.

        Raises
        ------
        LeakError
            If something exceeds its absolute limit.
        """
        # objects finalized in the first pass are freed in the second
        for _ in range(2):
            self.devtools.send("HeapProfiler.collectGarbage")
        metrics = {
            each["name"]: each["value"] for each in self.devtools.send("Performance.getMetrics")["metrics"]
        }
        usage = self.devtools.send("Runtime.getHeapUsage")
        found = {
            "heap": usage["usedSize"] / 1e6,
            "buffers": usage["backingStorageSize"] / 1e6,
            "nodes": metrics["Nodes"],
            "listeners": metrics["JSEventListeners"],
            "documents": metrics["Documents"],
            "contexts": self.contexts(),
            "graphics": graphics,
            "server": self.server.memory,
            "peak": self.server.peak,
        }
        self.measured.append((actions, found))
        for name, most in MOST.items():
            if found[name] > most:
                raise LeakError(f"{name}: {found[name]:g}, at most {most:g} are allowed")
        return found

    def growth(self) -> dict[str, float]:
        """Return the growth of each quantity in a thousand actions, or in fewer; empty with few measurements.

        Things that are loaded once, such as compiled code for a law of air, appear in one half of the time; a leak
        continues in both.
        """
        if len(self.measured) < LEAST_MEASUREMENTS:
            return {}
        last = self._last()
        most = min(1000.0, last[-1][0] - last[0][0])
        middle = len(last) // 2
        parts = last, last[: middle + 1], last[middle:]
        return {
            name: most * min(trend([(actions, found[name]) for actions, found in part]) for part in parts)
            for name in GROWTH
        }

    def check(self) -> None:
        """Check all measurements for a leak.

        Raises
        ------
        LeakError
        """
        too_much = [
            f"{name} grows by {grown:.3g} {GROWTH[name][0]}".rstrip()
            + f" in a thousand actions or fewer; allowed is {GROWTH[name][1]:g}"
            for name, grown in self.growth().items()
            if grown > GROWTH[name][1]
        ]
        if too_much:
            raise LeakError("; ".join(too_much))

    def _last(self) -> list[tuple[int, Mapping[str, float]]]:
        """Return the last two thirds: before that, caches fill and code is compiled."""
        return self.measured[len(self.measured) // 3 :]


def trend(points: Sequence[tuple[float, float]]) -> float:
    """Return the slope that half of all pairs of points exceed (Theil and Sen); a single peak does not change it."""
    slopes = [(y - v) / (x - u) for (u, v), (x, y) in itertools.combinations(points, 2) if x != u]
    return statistics.median(slopes)
