"""Use the explorer's page at random in a real browser: no error, no leak and no stale picture may come of it.

    python scripts/explorer_random_use.py --minutes 10
    python scripts/explorer_random_use.py --minutes 2 --seed 7 hoop.nc     words as of `eulerdisk explore`

It zooms, drags, clicks, types, moves sliders, presses buttons, changes the address, the size and the colours. Every
so often it lets the page rest and compares the picture with one that is asked for anew for the address. Every half a
minute it goes back to where it began and measures the memory. It ends with 1 at the first problem, and says what it
did before.
"""

from __future__ import annotations

import argparse
import random
import statistics
import sys
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from explorer_browser import COMPLETE, Served, Watch, find_browser, launched, served
from explorer_visitor import ProblemError, Visitor

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext, CDPSession, Page

#: Milliseconds in which a picture has to be complete, and after which the address is that of the picture.
PATIENCE, REST = 20_000, 400

#: Actions between two looks at the picture.
LOOK = 12

#: Seconds between two measurements of memory.
MEASURE = 30.0

#: What may grow between the first and the last third of the measurements, and the most of it at any time.
GROWTH = {"heap": 20.0, "nodes": 3000, "listeners": 600, "server": 80.0}
MOST = {"contexts": 2, "server": 600.0}

#: Keeps account of the contexts of WebGL; those that were collected or lost are gone.
COUNT_CONTEXTS = """
    window.contextsOfWebGL = [];
    const ordinary = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
      const context = ordinary.call(this, kind, ...rest);
      const known = window.contextsOfWebGL.some((each) => each.deref() === context);
      if (context && kind.startsWith("webgl") && !known) window.contextsOfWebGL.push(new WeakRef(context));
      return context;
    };
"""
LIVING_CONTEXTS = (
    "window.contextsOfWebGL.filter((each) => each.deref() && !each.deref().isContextLost()).length"
)

#: How many pixels differ between the picture and one that is asked for anew for the address.
COMPARE = """
async () => {
  const [{ stateOf }, { Picture }, { ServerSource }, { quantityOf }] = await Promise.all(
    ["address", "picture", "server_source", "state"].map((name) => import(`eulerdisk/${name}`)));
  const source = new ServerSource();
  const about = await source.about();
  const { view, quantity, stored, range } = stateOf(location.hash, about);
  const shown = document.querySelector("[data-lane] canvas.picture");
  const { width, height } = shown;
  const answer = await source.window({ view, quantity, stored, width, height, lane: "fine" });
  const anew = new Picture();
  anew.take(view, quantityOf(about, quantity), answer, range);
  anew.draw(view, width, height);
  const [a, b] = [shown, anew.canvas].map((canvas) => {
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [width, height];
    const context = copy.getContext("2d", { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    return new Uint32Array(context.getImageData(0, 0, width, height).data.buffer);
  });
  return a.reduce((count, pixel, index) => count + Number(pixel !== b[index]), 0);
}
"""


def new_page(context: BrowserContext, url: str) -> tuple[Page, Watch]:
    """Open the explorer in a context; its contexts of WebGL are counted and its problems noted."""
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    page = context.new_page()
    page.add_init_script(COUNT_CONTEXTS)
    watch = Watch(page, (url,))
    page.goto(url)
    settle(page)
    return page, watch


def settle(page: Page) -> None:
    """Wait until the picture is complete and the address is that of the picture."""
    from playwright.sync_api import TimeoutError as TooLateError

    page.wait_for_timeout(REST)
    try:
        page.wait_for_selector(COMPLETE, timeout=PATIENCE)
    except TooLateError:
        raise ProblemError(f"the picture was not complete after {PATIENCE / 1000:g} s") from None


def look(page: Page) -> None:
    """Compare the picture with one that is asked for anew for the address."""
    settle(page)
    differing = page.evaluate(COMPARE)
    if differing:
        raise ProblemError(f"the picture is not that of its address: {differing} pixels differ")


def measure(page: Page, devtools: CDPSession, server: Served, beginning: str) -> dict[str, float]:
    """Go back to the beginning and return what the page and the server hold: heap [MB], nodes, and so on."""
    page.evaluate("fragment => { location.hash = fragment; }", beginning)
    settle(page)
    devtools.send("HeapProfiler.collectGarbage")
    metrics = {each["name"]: each["value"] for each in devtools.send("Performance.getMetrics")["metrics"]}
    measured = {
        "heap": metrics["JSHeapUsedSize"] / 1e6,
        "nodes": metrics["Nodes"],
        "listeners": metrics["JSEventListeners"],
        "contexts": page.evaluate(LIVING_CONTEXTS),
        "server": server.memory,
    }
    for name, most in MOST.items():
        if measured[name] > most:
            raise ProblemError(f"{name}: {measured[name]:g}, at most {most:g} are allowed")
    return measured


def compare_measurements(measured: list[dict[str, float]]) -> None:
    """Compare the first third of the measurements with the last one; the very first is left out."""
    third = (len(measured) - 1) // 3
    if third < 1:
        return
    for name, most in GROWTH.items():
        values = [each[name] for each in measured[1:]]
        growth = statistics.median(values[-third:]) - statistics.median(values[:third])
        if growth > most:
            raise ProblemError(f"{name} has grown by {growth:g}, at most {most:g} are allowed")


def use(page: Page, watch: Watch, visitor: Visitor, actions: int) -> None:
    """Do a number of things and look at the picture after them."""
    for _ in range(actions):
        visitor.act()
        visitor.pause()
        if watch.problems:
            raise ProblemError("\n".join(watch.problems))
    look(page)
    contexts = page.evaluate(LIVING_CONTEXTS)
    if contexts > MOST["contexts"]:
        raise ProblemError(f"{contexts} contexts of WebGL for two motions")
    if watch.problems:
        raise ProblemError("\n".join(watch.problems))


def spend(context: BrowserContext, server: Served, seconds: float, seed: int) -> None:
    """Use the page for some time, and look for leaks."""
    page, watch = new_page(context, server.url)
    devtools = context.new_cdp_session(page)
    devtools.send("Performance.enable")
    visitor = Visitor(page, random.Random(seed))
    beginning = page.evaluate("location.hash")
    began = time.monotonic()
    count, measured = 0, [measure(page, devtools, server, beginning)]
    try:
        while time.monotonic() < began + seconds:
            use(page, watch, visitor, LOOK)
            count += LOOK
            if time.monotonic() > began + MEASURE * len(measured):
                measured.append(measure(page, devtools, server, beginning))
                report(time.monotonic() - began, count, measured[-1])
        compare_measurements(measured)
    except Exception:
        print(
            f"After {count} actions, seed {seed}; the last ones:",
            *visitor.done,
            sep="\n    ",
            file=sys.stderr,
        )
        print(f"    {page.url}", file=sys.stderr)
        raise
    print(f"{count} actions, {count // LOOK} pictures compared, {len(measured)} measurements: no problem.")


def report(seconds: float, count: int, measured: Mapping[str, float]) -> None:
    """Print a line with what was measured."""
    values = ", ".join(f"{name} {value:.4g}" for name, value in measured.items())
    print(f"{seconds:5.0f} s, {count} actions: {values}", flush=True)


def main() -> None:
    """Read the command line and use the page."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=random.randrange(10**6))
    parser.add_argument("words", nargs="*")
    arguments: Any = parser.parse_args()
    executable = find_browser()
    if executable is None:
        raise SystemExit("No Chromium is installed: scripts/test --readers installs it.")
    with served(*arguments.words) as server, launched(executable) as browser:
        # a frame of a disk takes 0.1 s without a graphics card: motions stand until they are played
        context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
        try:
            spend(context, server, 60.0 * arguments.minutes, arguments.seed)
        except ProblemError as problem:
            raise SystemExit(f"Problem: {problem}") from None


if __name__ == "__main__":
    main()
