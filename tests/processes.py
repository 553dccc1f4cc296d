"""Python in a process of its own, on this checkout or on a copy of it."""

import os
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[1]


def python(*words, folder, packages=CHECKOUT, environment=None, **how):
    """Run Python on words in a folder, with the packages of this checkout if not given; return what came of it."""
    return subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(packages), **(environment or {})},
        capture_output=True,
        text=True,
        check=False,
        **how,
    )
