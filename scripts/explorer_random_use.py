"""Use the explorer's page at random in a real browser, and check for errors, leaks and stale pictures.

    python scripts/explorer_random_use.py --minutes 10
    python scripts/explorer_random_use.py --minutes 2 --seed 7 hoop.nc     words as of `eulerdisk explore`

It zooms, drags, clicks, types, moves sliders, presses buttons, changes the address, the window size and the theme. From
time to time it lets the page rest and compares the picture with a newly requested one for the same address. Every half
a minute it returns to the beginning, collects garbage and measures the memory (`explorer_memory.py`). It ends with
status 1 at the first problem, and prints the preceding actions; growth is reported at the end.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from explorer_browser import COMPLETE, MAP, Served, Watch, find_browser, launched, served
from explorer_memory import COUNT_GRAPHICS, LeakError, Memory
from explorer_visitor import ProblemError, Visitor

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext, Page

#: Milliseconds in which a picture should be complete; in which it must be while its server still computes it; and after
#: which the address belongs to the picture.
PATIENCE, BUSY, REST = 20_000, 120_000, 400

#: Number of actions between two comparisons of the picture.
LOOK = 12

#: Seconds between two measurements of memory.
MEASURE = 30.0

#: Initial size of the window, restored for every measurement.
SIZE: Any = {"width": 1280, "height": 800}

#: Fragments of a page that shows two motions, both well within the initial view, and of one that shows none.
TWO_MOTIONS = """
async () => {
  const [{ ServerSource }, { fragmentOf }, { firstState }, { valueAt }] = await Promise.all(
    ["server_source", "address", "state", "axis_window"].map((name) => import(`eulerdisk/${name}`)));
  const first = firstState(await new ServerSource().about());
  const { x, y } = first.view;
  const point = (place) => ({ x: valueAt(x, place), y: valueAt(y, place) });
  const two = { ...first, points: [point(-0.3), point(0.4)], compare: true };
  return { none: fragmentOf(first), two: fragmentOf(two) };
}
"""

#: Number of pixels that differ between the picture and a newly requested one for the address.
COMPARE = """
async () => {
  const [{ stateOf }, { Picture }, { ServerSource }, { quantityOf }] = await Promise.all(
    ["address", "map", "server_source", "state"].map((name) => import(`eulerdisk/${name}`)));
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

#: Requests everything that is rarely requested of a server, so that what it loads for that does not count as growth. A
#: refusal also counts as an answer.
ASK_FOR_ALL = """
async () => {
  const [{ ServerSource }, { firstState }, { valueAt }] = await Promise.all(
    ["server_source", "state", "axis_window"].map((name) => import(`eulerdisk/${name}`)));
  const source = new ServerSource();
  const { view } = firstState(await source.about());
  const place = { view, x: valueAt(view.x, 0), y: valueAt(view.y, 0) };
  const size = { width: 8, height: 8 };
  const head = await source.motion(place).then((answer) => answer.head, () => ({ losses: [] }));
  const losses = Object.fromEntries(head.losses.filter(({ low }) => low).map(({ name, low }) => [name, low]));
  const asked = [
    () => source.motion({ ...place, losses }),
    () => source.explain(place),
    () => source.command({ view, ...size }),
    () => source.command(place),
    ...["csv", "netcdf"].map((format) => () => source.data({ view, ...size, format })),
  ];
  for (const ask of asked) await ask().catch(() => null);
}
"""


def new_page(context: BrowserContext, url: str) -> tuple[Page, Watch]:
    """Open the explorer in a context; count its WebGL contexts and record its problems."""
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    page = context.new_page()
    page.add_init_script(COUNT_GRAPHICS)
    watch = Watch(page, (url,))
    page.goto(url)
    settle(page, watch)
    return page, watch


def settle(page: Page, watch: Watch) -> None:
    """Wait until the picture is complete and the address belongs to it.

    If nobody computes the picture, it will never be complete: this is reported at once. A slow server, as when other
    programs use its processors, is reported and waited for.
    """
    from playwright.sync_api import TimeoutError as TooLateError

    page.wait_for_timeout(REST)
    began = time.monotonic()
    try:
        page.wait_for_selector(COMPLETE, timeout=PATIENCE)
        return
    except TooLateError:
        waits = watch.waits_for()
    late = f"the picture was not complete after {PATIENCE / 1000:g} s"
    if not any(" plan " in each for each in waits):
        raise ProblemError(
            f"{late}, and no plan is under way: {waits or 'nothing is'}; {describe_picture(page)}"
        )
    print(f"{late}: the page waits for", *waits, sep="\n    ", file=sys.stderr, flush=True)
    try:
        page.wait_for_selector(COMPLETE, timeout=BUSY)
    except TooLateError:
        still = "\n    ".join(watch.waits_for())
        raise ProblemError(
            f"the picture was not complete after {(PATIENCE + BUSY) / 1000:g} s; {describe_picture(page)}\n    {still}"
        ) from None
    print(f"it was complete after {time.monotonic() - began:.1f} s", file=sys.stderr, flush=True)


def describe_picture(page: Page) -> str:
    """Return the state of the page's picture as text."""
    lane, busy = (page.get_attribute(MAP, name) for name in ("data-lane", "aria-busy"))
    return f"lane {lane}, busy {busy}, notice {page.inner_text('#notice')!r}"


def look(page: Page, watch: Watch) -> None:
    """Compare the picture with a newly requested one for the address."""
    settle(page, watch)
    differing = page.evaluate(COMPARE)
    if differing:
        raise ProblemError(f"the picture does not belong to its address: {differing} pixels differ")


def measure(page: Page, watch: Watch, memory: Memory, actions: int) -> Mapping[str, float]:
    """Measure in a reproducible state: first with two motions, then without any, as in a newly opened page."""
    page.set_viewport_size(SIZE)
    fragments = page.evaluate(TWO_MOTIONS)
    go = "fragment => { location.hash = fragment; }"
    page.evaluate(go, fragments["two"])
    # some starts of a disk with losses have no motion
    page.locator(".motion:is(.shown, .refused):not(.waiting)").nth(1).wait_for(timeout=PATIENCE)
    settle(page, watch)
    graphics = memory.graphics()
    page.evaluate(go, fragments["none"])
    settle(page, watch)
    return memory.take(actions, graphics)


def use(page: Page, watch: Watch, visitor: Visitor, actions: int) -> None:
    """Perform some actions, then check the picture."""
    for _ in range(actions):
        visitor.act()
        visitor.pause()
        if watch.problems:
            raise ProblemError("\n".join(watch.problems))
    look(page, watch)
    if watch.problems:
        raise ProblemError("\n".join(watch.problems))


def spend(context: BrowserContext, server: Served, seconds: float, seed: int) -> None:
    """Use the page for some time, and check for leaks."""
    page, watch = new_page(context, server.url)
    memory = Memory(page, context.new_cdp_session(page), server)
    visitor = Visitor(page, random.Random(seed))
    page.evaluate(ASK_FOR_ALL)
    # the console reports what an atlas refuses
    watch.problems.clear()
    began = time.monotonic()
    count = 0
    try:
        measure(page, watch, memory, count)
        while time.monotonic() < began + seconds:
            use(page, watch, visitor, LOOK)
            count += LOOK
            if time.monotonic() > began + MEASURE * len(memory.measured):
                report(time.monotonic() - began, count, measure(page, watch, memory, count))
        memory.check()
    except Exception:
        print(
            f"After {count} actions, seed {seed}; the last ones:",
            *visitor.done,
            sep="\n    ",
            file=sys.stderr,
        )
        print(f"    {page.url}", file=sys.stderr)
        raise
    finally:
        report_growth(memory)
    print(
        f"{count} actions, {count // LOOK} pictures compared, {len(memory.measured)} measurements: no problem."
    )


def report(seconds: float, count: int, measured: Mapping[str, float]) -> None:
    """Print a line with the measurements."""
    values = ", ".join(f"{name} {value:.4g}" for name, value in measured.items())
    print(f"{seconds:5.0f} s, {count} actions: {values}", flush=True)


def report_growth(memory: Memory) -> None:
    """Print a line with the trends."""
    if grown := memory.growth():
        print(
            "in a thousand actions, or fewer:",
            ", ".join(f"{name} {value:+.3g}" for name, value in grown.items()),
        )


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
        # a frame of a disk takes 0.1 s without a graphics card, so motions do not start on their own
        context = browser.new_context(viewport=SIZE, reduced_motion="reduce")
        try:
            spend(context, server, 60.0 * arguments.minutes, arguments.seed)
        except (ProblemError, LeakError) as problem:
            raise SystemExit(f"Problem: {problem}") from None


if __name__ == "__main__":
    main()
