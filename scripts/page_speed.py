"""Measure how fast the explorer's page computes in a real browser, compared with the program itself.

    python scripts/page_speed.py [--rounds 7]

Windows of the rolling disk, of a torus and of a system are computed in exported pages, with all their workers, by turns
with the same cells in Python (`sweep.engine.compute.compute`, all threads). For each, the median is printed, and the
least time, which is least affected by other work on the machine. Then the waiting times of a person: the first window
of a fresh page of the disk, and the time from a click until its motion is shown. `page_tasks.py` measures how long the
page's main thread is busy at a time.
"""

import argparse
import statistics
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from explorer_browser import COMPLETE, find_browser, launched

from sweep.engine.compute import compute
from sweep.explorer.about import base_of
from sweep.explorer.explorer import subject_of
from sweep.explorer.export import export
from sweep.explorer.plan import plan
from sweep.explorer.view import View
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    from playwright.sync_api import Page

#: Width, height and quantity of each window.
WINDOWS = [(256, 192, "peak_tilt"), (1000, 700, "peak_tilt"), (1000, 700, "nutation_period")]

#: Other presets, whose pages have their own modules, and windows of them.
OTHERS = {
    "torus": [(256, 192, "peak_tilt"), (256, 192, "nutation_period")],
    "kapitza": [(64, 48, "peak")],
}

#: Create the computation in the page once, and time a window.
WINDOW = """async ([text, plan, view, width, height, quantity]) => {
    const { Computation } = await import("eulerdisk/compute/computation");
    const { computedWindow } = await import("eulerdisk/compute/cells");
    const { unpackedArray } = await import("eulerdisk/packed");
    const kernels = document.getElementById("kernels").textContent;
    window.computation ??= new Computation(unpackedArray({ type: "u1", data: kernels }));
    const begun = performance.now();
    await computedWindow(window.computation, plan, { view, width, height, quantity });
    return performance.now() - begun;
}"""

#: Milliseconds for which windows are computed before one is timed: meanwhile a browser optimizes its machine code.
WARM = 1000.0


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=7)
    rounds = parser.parse_args().rounds
    executable = find_browser()
    if executable is None:
        parser.error("no Chromium is installed")
    with tempfile.TemporaryDirectory() as folder, launched(executable) as browser:
        path = Path(folder) / "page.html"
        export(subject_of("rolling", {}), path)
        page = browser.new_page(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
        begun = time.perf_counter()
        page.goto(f"{path.as_uri()}#base=")
        page.wait_for_selector("#map[data-lane]")
        first = time.perf_counter() - begun
        page.wait_for_selector(COMPLETE)
        print(
            f"{path.stat().st_size / 1e6:.2f} MB; the first window of a fresh page after {1000 * first:.0f} ms"
        )
        _compare(page, "rolling", WINDOWS, rounds)
        page.evaluate("scrollTo(0, 0)")
        clicks = [_click(page, number) for number in range(rounds)]
        print(f"a click until its motion is there: {statistics.median(clicks[2:]):.0f} ms")
        for preset, windows in OTHERS.items():
            other = Path(folder) / f"{preset}.html"
            export(subject_of(preset, {}), other)
            page.goto(f"{other.as_uri()}#base=")
            page.wait_for_selector("#map[data-lane]")
            _compare(page, preset, windows, rounds)


def _compare(page: "Page", preset: str, windows: list[tuple[int, int, str]], rounds: int) -> None:
    """Time windows of the page of a preset by turns with Python, and print the results."""
    spec = SweepSpec.preset(preset)
    view = View.read(base_of("", spec)["view"], spec)
    for width, height, quantity in windows:
        asked = [None, plan(view)["cells"], base_of("", spec)["view"], width, height, quantity]
        warm = [page.evaluate(WINDOW, asked)]
        while sum(warm) < WARM:
            warm.append(page.evaluate(WINDOW, asked))
        _time_python(view, width, height, quantity)
        times = np.array(
            [
                (page.evaluate(WINDOW, asked), _time_python(view, width, height, quantity))
                for _ in range(rounds)
            ]
        )
        of_page, of_python = np.median(times, axis=0)
        least_page, least_python = times.min(axis=0)
        told = f"page {of_page:.0f} ms (least {least_page:.0f}, the first one {warm[0]:.0f})"
        beside = f"Python {of_python:.0f} ms (least {least_python:.0f})"
        ratios = f"{of_page / of_python:.2f} times ({least_page / least_python:.2f})"
        print(f"{preset}, {quantity} {width} x {height}: {told}, {beside}, {ratios}", flush=True)


def _time_python(view: View, width: int, height: int, quantity: str) -> float:
    """Return the time [ms] in which Python computes a window."""
    begun = time.perf_counter()
    x, y = np.meshgrid(view.x.values(width), view.y.values(height))
    compute(view.live, view.starts(x.ravel(), y.ravel()), verdicts_only=quantity != "nutation_period")
    return 1000.0 * (time.perf_counter() - begun)


#: Time from the next click until the motion of its start is shown.
CLICK = """() => {
    const slot = document.querySelector("#motions .slot");
    window.took = new Promise((done) => {
        document.getElementById("map").addEventListener("pointerdown", () => {
            const begun = performance.now();
            const watch = new MutationObserver(() => {
                watch.disconnect();
                done(performance.now() - begun);
            });
            watch.observe(slot, { attributeFilter: ["data-shown"] });
        }, { once: true, capture: true });
    });
}"""


def _click(page: "Page", number: int) -> float:
    """Return the time [ms] from a click on the map until the motion of that start is shown."""
    box = page.locator("#map .picture").bounding_box()
    assert box is not None
    page.evaluate(CLICK)
    page.mouse.click(box["x"] + (0.2 + 0.08 * number) * box["width"], box["y"] + 0.6 * box["height"])
    return float(page.evaluate("took"))


if __name__ == "__main__":
    main()
