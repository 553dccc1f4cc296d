"""Notebooks among the pages are executed with this checkout, whatever the settings of the user.

Each cell of commands begins with ``%%bash -e``, so that a command that fails ends the build as an exception does.
"""

import json
import os
import sys
import tempfile
from functools import partial
from pathlib import Path

from jupyter_cache.executors import utils as executor
from sphinx.application import Sphinx

_CHECKOUT = Path(__file__).resolve().parents[2]


def setup(app: Sphinx) -> dict[str, bool]:
    """Set what kernels inherit, and have what a command prints arrive in one piece."""
    kept = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join([str(_CHECKOUT), *([kept] if kept else [])])
    os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    # which cell compiles a kernel depends on the cache: no page says so
    os.environ["EULERDISK_NOTICES"] = "no"
    # figures are those of a notebook, not of a program without a screen
    os.environ.pop("MPLBACKEND", None)
    _forget_settings(app)
    # myst-nb hands no options to the client of notebooks; without this one a page breaks lines where a pipe was read
    executor.executenb = partial(executor.executenb, coalesce_streams=True)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _forget_settings(app: Sphinx) -> None:
    """Give kernels a folder of settings, in which they do not warn that they listen on this machine.

    Nor do they show a bar: it would say how fast this machine was.
    """
    folder = tempfile.TemporaryDirectory(prefix="eulerdisk-site-")
    app.connect("build-finished", lambda *_: folder.cleanup())
    profile = Path(folder.name) / "profile_default"
    (profile / "startup").mkdir(parents=True)
    no_bar = "from sweep.progress import display\ndisplay._PATIENCE = float('inf')\ndel display\n"
    (profile / "startup" / "progress.py").write_text(no_bar, encoding="utf-8")
    settings = {"IPKernelApp": {"log_level": "ERROR"}}
    (profile / "ipython_kernel_config.json").write_text(json.dumps(settings), encoding="utf-8")
    os.environ["IPYTHONDIR"] = folder.name
