"""Measure how long the explorer's page is busy at a time, in a real browser: the longest tasks of its main thread.

    python scripts/page_tasks.py [PRESET ...] [--least 25]

Exported pages of presets, and the page of `eulerdisk explore` with the first preset, are opened, clicked, zoomed and
moved; sliders move, and other quantities are shown. Chromium records the tasks. For each action, the tasks are printed
that take at least LEAST milliseconds of processor time on the page's main thread, together with the elapsed time and
their longest part: while another process draws in software, the page waits without taking processor time.
"""

import argparse
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from explorer_browser import COMPLETE, find_browser, launched, served

from sweep.explorer.explorer import subject_of
from sweep.explorer.export import export

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

#: Categories that Chromium records: its tasks, their parts, and marks.
_CATEGORIES = ["devtools.timeline", "disabled-by-default-devtools.timeline", "blink.user_timing"]

#: Name of a task.
_TASK = "RunTask"

#: A mark that the page sets on its main thread.
_MARK = "of this page"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("presets", nargs="*", default=["rolling", "torus", "kapitza"])
    parser.add_argument("--least", type=float, default=25.0)
    given = parser.parse_args()
    executable = find_browser()
    if executable is None:
        parser.error("no Chromium is installed")
    with tempfile.TemporaryDirectory() as folder, launched(executable) as browser:
        for preset in given.presets:
            path = Path(folder) / f"{preset}.html"
            export(subject_of(preset, {}), path)
            _print_tasks(browser, f"page of {preset}", path.as_uri(), given.least)
        first = given.presets[0]
        with served(first) as running:
            _print_tasks(browser, f"explore {first}", running.url, given.least)


def _print_tasks(browser: "Browser", name: str, address: str, least: float) -> None:
    """Print the longest tasks of each action on a page."""
    page = browser.new_page(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    for deed, do in _actions(page, f"{address}#base="):
        tasks = [each for each in _tasks(browser, page, do) if each[0] >= least]
        told = "; ".join(
            f"{busy:.0f} ms of processor time in {passed:.0f} ms, {what}" for busy, passed, what in tasks[:3]
        )
        print(f"{name}, {deed}: {told or f'no task of {least:.0f} ms'}", flush=True)
    page.close()


def _actions(page: "Page", address: str) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield the actions on a page and their names, one after the other."""
    yield "opened", partial(page.goto, address)
    box = page.locator("#map .picture").bounding_box()
    assert box is not None

    def at(across: float, up: float) -> tuple[float, float]:
        return box["x"] + across * box["width"], box["y"] + up * box["height"]

    def zoom() -> None:
        page.mouse.move(*at(0.4, 0.4))
        for _ in range(10):
            page.mouse.wheel(0, -120)
            page.wait_for_timeout(60)

    def move() -> None:
        page.mouse.move(*at(0.5, 0.5))
        page.mouse.down()
        for step in range(15):
            page.mouse.move(*at(0.5 + 0.02 * step, 0.5))
            page.wait_for_timeout(30)
        page.mouse.up()

    def slide() -> None:
        page.locator("#controls input[type=range]").first.focus()
        for _ in range(10):
            page.keyboard.press("ArrowRight")
            page.wait_for_timeout(40)

    yield "first click", partial(page.mouse.click, *at(0.5, 0.6))
    yield "another click", partial(page.mouse.click, *at(0.3, 0.5))
    yield from (("zoomed", zoom), ("moved", move), ("a slider", slide))
    options = page.locator("#quantity option").evaluate_all("all => all.map((each) => each.value)")
    for quantity in options[1:3]:
        yield quantity, partial(page.select_option, "#quantity", quantity)


def _tasks(browser: "Browser", page: "Page", do: Callable[[], Any]) -> list[tuple[float, float, str]]:
    """Return the tasks of the main thread, longest first: processor time and elapsed time [ms], longest part."""
    events: list[dict[str, Any]] = []
    session = browser.new_browser_cdp_session()
    session.on("Tracing.dataCollected", lambda found: events.extend(found["value"]))
    session.send("Tracing.start", {"traceConfig": {"includedCategories": _CATEGORIES}})
    do()
    page.wait_for_timeout(300)
    page.wait_for_selector(COMPLETE, timeout=90_000)
    page.wait_for_timeout(1200)
    page.evaluate("mark => performance.mark(mark)", _MARK)
    ended: list[dict[str, Any]] = []
    session.on("Tracing.tracingComplete", lambda found: ended.append(found))
    session.send("Tracing.end")
    while not ended:
        page.wait_for_timeout(20)
    session.detach()
    threads = {(each["pid"], each["tid"]) for each in events if each["name"] == _MARK}
    own = [each for each in events if (each["pid"], each["tid"]) in threads and "tdur" in each]
    tasks = [each for each in own if each["name"] == _TASK]
    return sorted(
        ((task["tdur"] / 1000, task["dur"] / 1000, _longest(task, own)) for task in tasks), reverse=True
    )


def _longest(task: dict[str, Any], own: list[dict[str, Any]]) -> str:
    """Return the name of the longest part of a task."""
    end = task["ts"] + task["dur"]
    inner = [each for each in own if task["ts"] <= each["ts"] < end and each["name"] != _TASK]
    return str(max(inner, key=lambda each: each["tdur"])["name"]) if inner else "something else"


if __name__ == "__main__":
    main()
