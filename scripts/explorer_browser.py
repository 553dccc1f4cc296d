"""A real browser with the explorer's page: a Chromium without a window, the server, and a watch on what goes wrong.

The tests in `tests/explorer/browser`, the random use and the recordings stand on this.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Page, Request, Response

#: Names of the program: the engine alone, which takes half the processor time of a whole browser, then Debian's name.
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")

#: A container has no user namespaces for the sandbox, and no graphics card for WebGL.
OPTIONS = ("--no-sandbox", "--enable-unsafe-swiftshader")

#: The part of the page that is the map; and the map while its picture is that of the view, at full resolution.
MAP = "[data-lane]"
COMPLETE = f"{MAP}[data-lane=fine][aria-busy=false]"

_ADDRESS = re.compile(r"http://127\.0\.0\.1:\d+/[\w-]+/")

#: What the driver of the graphics says of its own speed is nothing that a page can help.
_HARMLESS = re.compile(r"GL Driver Message|swiftshader", re.IGNORECASE)


def find_browser() -> str | None:
    """Return the path of a Chromium that is installed."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


@contextmanager
def launched(executable: str) -> Iterator[Browser]:
    """Run a browser without a window; what a page does in it is seen by a driver, Playwright."""
    # where the driver is missing its tests are skipped; what they import is found all the same
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=list(OPTIONS))
        try:
            yield browser
        finally:
            browser.close()


@dataclass(frozen=True)
class Served:
    """A server that runs in a process of its own, as a user starts it."""

    url: str
    process: subprocess.Popen[str]

    @property
    def memory(self) -> float:
        """Memory [MB] that is its own or shared with others, at the moment."""
        return self._megabytes("VmRSS")

    @property
    def peak(self) -> float:
        """The most memory [MB] that it has ever had."""
        return self._megabytes("VmHWM")

    def _megabytes(self, name: str) -> float:
        status = Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii")
        (kilobytes,) = re.findall(rf"{name}:\s+(\d+) kB", status)
        return int(kilobytes) / 1000


@contextmanager
def served(*words: str) -> Iterator[Served]:
    """Run ``eulerdisk explore`` with these words until the block ends; it may have printed nothing but its address.

    Raises
    ------
    RuntimeError
        If it printed no address, or an error while it ran.
    """
    command = (sys.executable, "-m", "sweep", "explore", *words, "--no-browser")
    with tempfile.TemporaryFile("w+", encoding="utf-8") as errors:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=os.environ)
        assert process.stdout is not None
        try:
            found = _ADDRESS.search(process.stdout.readline())
            if found is None:
                process.wait(timeout=30)
                raise RuntimeError(f"The explorer printed no address: {_all(errors)}")
            yield Served(found[0], process)
        finally:
            process.terminate()
            process.wait(timeout=30)
            process.stdout.close()
        if "Traceback" in _all(errors):
            raise RuntimeError(f"The explorer printed an error:\n{_all(errors)}")


def _all(file: IO[str]) -> str:
    file.seek(0)
    return file.read()


@dataclass
class Watch:
    """Notes what must not happen in a page.

    A message in its console, an exception that nobody caught, a request that failed, and one to another address than
    those with which `own` begins.
    """

    page: Page
    own: Sequence[str]
    problems: list[str] = field(default_factory=list)
    #: What was asked and is not answered yet, and when it was asked, by the clock `time.monotonic`.
    under_way: dict[Request, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Listen from now on."""
        self.page.on("console", self._message)
        self.page.on("pageerror", lambda error: self.problems.append(f"exception: {error.stack or error}"))
        self.page.on("crash", lambda _: self.problems.append("the page has crashed"))
        self.page.on("request", self._request)
        self.page.on("requestfailed", self._failed)
        self.page.on("requestfinished", self._finished)
        self.page.on("response", self._response)

    def waits_for(self) -> list[str]:
        """Return what the page waits for, that which was asked first at the head: seconds, address and question."""
        now = time.monotonic()
        return [
            f"{now - since:.1f} s: {request.url.rsplit('/', 1)[-1]} {request.post_data or ''}".rstrip()
            for request, since in self.under_way.items()
        ]

    def _message(self, message: ConsoleMessage) -> None:
        if not _HARMLESS.search(message.text):
            self.problems.append(
                f"console, {message.type}: {message.text} ({message.location.get('url', '')})"
            )

    def _request(self, request: Request) -> None:
        self.under_way[request] = time.monotonic()
        if not request.url.startswith((*self.own, "data:", "blob:")):
            self.problems.append(f"a request to another address: {request.url}")

    def _finished(self, request: Request) -> None:
        self.under_way.pop(request, None)

    def _failed(self, request: Request) -> None:
        self._finished(request)
        # the page itself ends requests whose answers are of no use any more
        if request.failure != "net::ERR_ABORTED":
            self.problems.append(f"a request failed: {request.url} {request.failure}")

    def _response(self, response: Response) -> None:
        if response.status >= 400:
            asked = response.request.post_data or ""
            self.problems.append(f"status {response.status}: {response.url} {asked}")
