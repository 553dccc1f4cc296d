"""What an explorer's page and its server hold in memory, and whether that grows: a leak is seen by its trend."""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from explorer_browser import Served

if TYPE_CHECKING:
    from playwright.sync_api import CDPSession, Page

#: What is measured -> unit, and how much of it may come in a thousand actions, by the trend of the last two thirds of
#: the measurements; or in all of these, where they have fewer actions: a page that once had a picture saved holds a
#: document of 100 nodes for it.
#:
#: A thousand actions of a `Visitor` choose some 200 starts, move as many sliders and show 2000 windows. What leaks in
#: each of them is seen: a motion has 0.3 MB of samples, a panel 300 elements and 30 listeners, a path four objects of
#: WebGL, a window 0.2 to 5 MB of buffers. Without a leak buffers, listeners and objects of WebGL stay as they are. The
#: heap grows by what the browser compiles, and by its own list of what took long: 3 MB in the first thousand actions.
GROWTH: Mapping[str, tuple[str, float]] = {
    "heap": ("MB", 5.0),
    "buffers": ("MB", 1.0),
    "nodes": ("", 200.0),
    "listeners": ("", 10.0),
    "documents": ("", 2.0),
    "graphics": ("", 8.0),
    "server": ("MB", 30.0),
}

#: The most of it at any time.
MOST = {"contexts": 2.0, "server": 600.0, "peak": 600.0}

#: Measurements that have a trend; of fewer the last third alone would say nothing.
LEAST_MEASUREMENTS = 9

#: Is run before the page: counts what each context of WebGL holds. One that was collected or lost holds nothing.
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
    """More is held than may be; its text says what and how much."""


@dataclass
class Memory:
    """The measurements of one page.

    Parameters
    ----------
    page : Page
        Where `COUNT_GRAPHICS` was run first.
    devtools : CDPSession
        Of this page.
    server : Served
    """

    page: Page
    devtools: CDPSession
    server: Served
    #: Number of actions before a measurement, and what was measured.
    measured: list[tuple[int, Mapping[str, float]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Ask the browser to count."""
        self.devtools.send("Performance.enable")

    def graphics(self) -> float:
        """Return how many objects all contexts of WebGL hold: buffers, textures, programs."""
        return float(self.page.evaluate(f"{_LIVING}.reduce((sum, each) => sum + each.held, 0)"))

    def contexts(self) -> float:
        """Return how many contexts of WebGL there are; browsers keep few."""
        return float(self.page.evaluate(f"{_LIVING}.length"))

    def take(self, actions: int, graphics: float) -> Mapping[str, float]:
        """Collect garbage and measure.

        Parameters
        ----------
        actions : int
            How much was done until now.
        graphics : float
            Objects of WebGL that were held while something stood there to be drawn.

        Raises
        ------
        LeakError
            If there is more of something than may ever be.
        """
        # what is finalized in the first pass is free after the second one
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
        """Return how much of each thing comes in a thousand actions, or in fewer; empty while too little was measured.

        What is loaded once, as compiled code for a law of air, comes in one half of the time: a leak goes on in both.
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
        """Look for a leak in all that was measured.

        Raises
        ------
        LeakError
        """
        too_much = [
            f"{name} grows by {grown:.3g} {GROWTH[name][0]}".rstrip()
            + f" in a thousand actions or fewer, {GROWTH[name][1]:g} may be"
            for name, grown in self.growth().items()
            if grown > GROWTH[name][1]
        ]
        if too_much:
            raise LeakError("; ".join(too_much))

    def _last(self) -> list[tuple[int, Mapping[str, float]]]:
        """Return the last two thirds: before them caches fill and code is compiled."""
        return self.measured[len(self.measured) // 3 :]


def trend(points: Sequence[tuple[float, float]]) -> float:
    """Return the slope that half of all pairs of points exceed (Theil and Sen): a single peak does not move it."""
    slopes = [(y - v) / (x - u) for (u, v), (x, y) in itertools.combinations(points, 2) if x != u]
    return statistics.median(slopes)
