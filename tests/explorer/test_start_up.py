"""The first window needs no slow imports."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[2]

#: Libraries that take a tenth of a second or more to load.
HEAVY = {"numba", "scipy", "xarray", "pandas", "dask", "matplotlib", "netCDF4", "rich", "pydantic"}

FIRST_WINDOW = """
import sys
from explorer_client import ask, post
from sweep.explorer.explorer import explore
import json
with explore({given}) as explorer:
    view = json.loads(ask(explorer.url, "about").body)["bases"][0]["view"]
    post(explorer.url, "window", view=view, width=256, height=192, quantity="peak_tilt")
    post(explorer.url, "lines", view=view)
    post(explorer.url, "point", view=view, x=view["x"]["centre"], y=0.02)
print(*sys.modules)
"""


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_the_first_window_loads_no_heavy_library():
    """With compiled kernels, a window, its lines and a point need only numpy and the kernel loader."""
    paths = os.pathsep.join(map(str, (CHECKOUT, CHECKOUT / "tests")))
    for _ in range(2):
        # the first run compiles kernels that are not cached
        done = subprocess.run(
            [sys.executable, "-c", FIRST_WINDOW.format(given="'circling', alpha=1.0")],
            env=os.environ | {"PYTHONPATH": paths},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
    assert {name.partition(".")[0] for name in done.stdout.split()} & HEAVY == set()
