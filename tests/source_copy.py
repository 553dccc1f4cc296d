"""A copy of both packages that a test can edit, and commands that it runs: what another version of the program does."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).parents[1]


class SourceCopy:
    """A copy of `kernels` and `sweep` in a folder."""

    def __init__(self, folder):
        self.folder = folder
        for package in ("kernels", "sweep"):
            shutil.rmtree(folder / package, ignore_errors=True)
            shutil.copytree(
                CHECKOUT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__")
            )

    def edit(self, file, before, after):
        """Replace a text that stands once in a file.

        The time of the file stays: Numba keeps a compiled function under the path and the time of its file, and so the
        next test run finds it. That its code has changed, the name of the cache's folder says.
        """
        path = self.folder / file
        source, status = path.read_text(), path.stat()
        assert source.count(before) == 1, (file, before)
        path.write_text(source.replace(before, after))
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))

    def command(self, words, folder):
        """Run a command line of the copy in a folder and return what came of it."""
        return self.python("-m", "sweep", *words.split(), folder=folder)

    def python(self, *words, folder):
        """Run Python on the copy in a folder and return what came of it."""
        return subprocess.run(
            [sys.executable, *words],
            cwd=folder,
            # bytecode is found by the time of its source, which an edit keeps
            env=os.environ | {"PYTHONPATH": str(self.folder), "PYTHONDONTWRITEBYTECODE": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
