"""The exported page also works in Firefox, in a frame of another page on a static host."""

import http.server
import os
import shutil
import subprocess
import threading
import time
from functools import partial

import numpy as np
import pytest
from PIL import Image

from sweep.explorer.explorer import subject_of
from sweep.explorer.export import export

pytestmark = pytest.mark.release

FIREFOX = next(filter(None, map(shutil.which, ("firefox-esr", "firefox"))), None)

#: A page with an explorer and a late image, because Firefox takes its screenshot after all images.
AROUND = '<iframe src="page.html#base=" style="width: 1200px; height: 800px; border: 0"></iframe><img src="late.png">'

#: Delay of the image [s], enough to compute a window on a busy machine.
LATE = 12.0


class Host(http.server.SimpleHTTPRequestHandler):
    """A static host with one slow image."""

    def do_GET(self):
        """Send a file."""
        if self.path == "/late.png":
            time.sleep(LATE)
        super().do_GET()

    def log_message(self, *_):
        """Log nothing."""


@pytest.mark.skipif(FIREFOX is None, reason="no Firefox is installed")
def test_the_page_computes_in_firefox(tmp_path):
    """The map has its colors: dark where disks tilt far, bright where they stay upright."""
    export(subject_of("rolling", {}), tmp_path / "page.html")
    (tmp_path / "around.html").write_text(AROUND)
    shot = tmp_path / "shot.png"
    options = ("--headless", "--no-remote", "--profile", str(tmp_path), "--window-size", "1240,840")
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(Host, directory=tmp_path)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_port}/around.html"
        subprocess.run(
            [FIREFOX, *options, "--screenshot", str(shot), address],
            env=os.environ | {"HOME": str(tmp_path)}, check=True, capture_output=True, timeout=300,
        )  # fmt: skip
        server.shutdown()
    pixels = np.asarray(Image.open(shot).convert("RGB")).astype(int)
    colour = pixels.max(axis=2) - pixels.min(axis=2)
    # more than a fifth of the page is colored; a map without cells has gray hatching
    assert (colour > 40).mean() > 0.15
    coloured = pixels[colour > 40]
    bright, dark = coloured.sum(axis=1) > 450, coloured.sum(axis=1) < 260
    assert bright.mean() > 0.02
    assert dark.mean() > 0.05
