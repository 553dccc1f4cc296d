"""Take the pictures of the explorer in the documentation, in a real browser.

    python scripts/record_explorer.py [--folder docs]

It writes `explorer.png` and `explorer_dark.png`, the page with the motions of two starts, and `explorer.gif`, a zoom
into the boundary and a click on each side of it.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import imageio_ffmpeg
from explorer_browser import COMPLETE, MAP, Watch, find_browser, launched, served

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

#: Frames per second of the recording, and its displayed width [pixels].
RATE, WIDTH = 8, 1000

#: Largest size of the recording [bytes].
MOST = 3_000_000

#: Window sizes for pictures and for the recording: wide enough for two motions side by side.
PICTURE, RECORDING = {"width": 1840, "height": 1060}, {"width": 1840, "height": 860}

#: Number of turns of the wheel, their size, and number of turns after which the pointer aims at the boundary again.
TURNS, TURN, AIM = 36, -100, 4

#: Horizontal place of the zoom into the boundary, from -1 to 1: at the smallest tilts, where motions differ most.
SMALL = -0.5

#: Distance of the two starts below and above the boundary, as a share of the map's height.
BESIDE = 0.12

#: Share of their duration at which motions are shown in pictures.
SHOWN = 0.3

#: The points of a view's lines in window coordinates from -1 to 1, across and up; "measured" is the boundary itself.
LINES = """
async () => {
  const { view } = JSON.parse(document.querySelector("[data-lane]").dataset.shown);
  const headers = { "Content-Type": "application/json" };
  const answer = await fetch("./lines", { method: "POST", headers, body: JSON.stringify({ view }) });
  const { lines } = await answer.json();
  const place = (axis, value) => ((axis.scale === "log" ? Math.log(value) : value) - axis.centre) / axis.half;
  const flat = (points) => (typeof points[0]?.[0] === "number" ? points : points.flat());
  return Object.fromEntries(lines.map(({ name, points }) =>
    [name, flat(points).map(([x, y]) => [place(view.x, x), place(view.y, y)])]));
}
"""


@dataclass
class Camera:
    """Takes frames of a page into a folder."""

    page: Page
    folder: Path
    count: int = 0

    def frames(self, count: int = 1) -> None:
        """Take frames at the intervals at which they will be shown."""
        for _ in range(count):
            self.page.screenshot(path=self.folder / f"{self.count:05d}.png")
            self.count += 1
            self.page.wait_for_timeout(1000 / RATE)

    def play(self, count: int, until: float) -> None:
        """Take frames of the motions from their start to a share of their duration, with the page's own slider."""
        for number in range(count):
            seek(self.page, until * number / count)
            self.frames()

    def film(self, path: Path) -> None:
        """Write the frames as a GIF with its own palette."""
        palette = "split[a][b];[a]palettegen=stats_mode=diff:max_colors=128[p]"
        film = f"scale={WIDTH}:-1:flags=lanczos,{palette};[b][p]paletteuse=dither=none:diff_mode=rectangle"
        subprocess.run(
            [
                *(imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-loglevel", "error", "-framerate", str(RATE)),
                *("-i", str(self.folder / "%05d.png")),
                *("-vf", film, str(path)),
            ],
            check=True,
        )


def seek(page: Page, part: float) -> None:
    """Set the clock of the motions to a share of their duration."""
    page.locator("input.time").first.evaluate(
        """(slider, part) => {
          slider.value = String(part * Number(slider.max));
          slider.dispatchEvent(new Event("input"));
        }""",
        part,
    )


def settle(page: Page) -> None:
    """Wait until the picture is complete."""
    page.wait_for_timeout(400)
    page.wait_for_selector(COMPLETE)


def window_position(page: Page, across: float, up: float) -> tuple[float, float]:
    """Return the position in the window of a place in the picture, from -1 to 1."""
    box = page.locator(f"{MAP} canvas.picture").bounding_box()
    assert box is not None
    return box["x"] + 0.5 * (across + 1.0) * box["width"], box["y"] + 0.5 * (1.0 - up) * box["height"]


def boundary(page: Page, where: float = 0.0) -> tuple[float, float]:
    """Return the place of the boundary nearest to a place across the map, from -1 to 1."""
    lines: dict[str, Any] = page.evaluate(LINES)
    inside = [place for place in lines["measured"] if max(map(abs, place)) < 0.9]
    if not inside:
        raise SystemExit("The boundary does not cross the recorded map.")
    across, up = min(inside, key=lambda place: abs(place[0] - where))
    return across, up


def zoom_in(page: Page, camera: Camera) -> None:
    """Turn the wheel over the boundary, and take a frame after each turn."""
    for turn in range(TURNS):
        if turn % AIM == 0:
            page.mouse.move(*window_position(page, *boundary(page, SMALL)))
        page.mouse.wheel(0, TURN)
        camera.frames()
    settle(page)
    camera.frames(RATE)


def choose(page: Page, beside: float, *, second: bool) -> None:
    """Click below or above the boundary."""
    across, up = boundary(page)
    if second:
        page.keyboard.down("Shift")
    page.mouse.click(*window_position(page, across, up + beside))
    if second:
        page.keyboard.up("Shift")
    page.wait_for_selector(f"#motions canvas >> nth={int(second)}")


@contextmanager
def open_page(browser: Browser, url: str, size: dict[str, int], light: str) -> Iterator[Page]:
    """Open the page; raise an error if it reports a problem."""
    # frames may be slow, because the clock of the motions is set explicitly
    context = browser.new_context(viewport=size, color_scheme=light, reduced_motion="reduce")  # type: ignore[arg-type]
    page = context.new_page()
    watch = Watch(page, (url,))
    page.goto(url)
    settle(page)
    yield page
    context.close()
    if watch.problems:
        raise SystemExit("\n".join(watch.problems))


def take_picture(browser: Browser, url: str, light: str, path: Path) -> None:
    """Take a picture of the page with the motions of two starts."""
    with open_page(browser, url, PICTURE, light) as page:
        for beside, second in ((-BESIDE, False), (BESIDE, True)):
            choose(page, beside, second=second)
        settle(page)
        seek(page, SHOWN)
        page.wait_for_timeout(2000)
        page.screenshot(path=path)


def record(browser: Browser, url: str, path: Path) -> None:
    """Film a zoom into the boundary and a click on each side of it."""
    with tempfile.TemporaryDirectory() as folder, open_page(browser, url, RECORDING, "light") as page:
        camera = Camera(page, Path(folder))
        camera.frames(RATE)
        zoom_in(page, camera)
        for beside, second in ((-BESIDE, False), (BESIDE, True)):
            choose(page, beside, second=second)
            settle(page)
            camera.play(*((8 * RATE, 1.0) if second else (3 * RATE, SHOWN)))
        camera.film(path)
    if path.stat().st_size > MOST:
        raise SystemExit(f"{path} has {path.stat().st_size} bytes; at most {MOST} are allowed.")


def main() -> None:
    """Read the command line, take the pictures and film the zoom."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--folder", type=Path, default=Path(__file__).parents[1] / "docs")
    folder = parser.parse_args().folder
    executable = find_browser()
    if executable is None:
        raise SystemExit("No Chromium is installed: scripts/test --readers installs it.")
    with served() as server, launched(executable) as browser:
        take_picture(browser, server.url, "light", folder / "explorer.png")
        take_picture(browser, server.url, "dark", folder / "explorer_dark.png")
        record(browser, server.url, folder / "explorer.gif")


if __name__ == "__main__":
    main()
