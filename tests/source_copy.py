"""A copy of both packages that a test can edit, and commands that it runs: what another version of the program does."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).parents[1]


class SourceCopy:
    """A copy of `kernels` and `sweep` in an empty folder."""

    def __init__(self, folder):
        self.folder = folder
        for package in ("kernels", "sweep"):
            shutil.copytree(
                CHECKOUT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__")
            )

    def edit(self, file, before, after):
        """Replace a text that stands once in a file."""
        path = self.folder / file
        source = path.read_text()
        assert source.count(before) == 1, (file, before)
        path.write_text(source.replace(before, after))

    def command(self, words, folder):
        """Run a command line of the copy in a folder and return what came of it."""
        return subprocess.run(
            [sys.executable, "-m", "sweep", *words.split()],
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(self.folder), "PYTHONDONTWRITEBYTECODE": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
