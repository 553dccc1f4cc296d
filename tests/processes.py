"""Python in a separate process, on this checkout or a copy of it."""

import os
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[1]


def python(*words, folder, packages=CHECKOUT, environment=None, **how):
    """Run Python in a folder, by default with this checkout's packages; return the completed process."""
    return subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(packages), **(environment or {})},
        capture_output=True,
        text=True,
        check=False,
        **how,
    )
