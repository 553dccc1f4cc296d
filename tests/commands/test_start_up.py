"""Commands load only the modules they need, because imports are most of the time of a short command."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import sweep

CHECKOUT = Path(__file__).parents[2]

#: Libraries that take a tenth of a second or more to load, some through others.
HEAVY = {
    "numba", "llvmlite", "scipy", "xarray", "pandas", "pyarrow", "dask", "matplotlib", "netCDF4", "numpy",
    "pydantic", "rich",
}  # fmt: skip

_COMMAND, _FILE, _ATLAS, _KERNEL = (
    {"numpy", "pydantic"},
    {"netCDF4"},
    {"netCDF4", "xarray", "pandas", "pyarrow", "dask", "scipy"},
    {"llvmlite"},
)

#: Command lines and the `HEAVY` modules they may load with compiled kernels; the parser uses pydantic.
COMMANDS = {
    "--help": set(),
    "--version": {"pydantic"},
    "info a.nc": _COMMAND | _ATLAS,
    "boundary a.nc": _COMMAND | _ATLAS,
    "plan rolling --no-calibrate": _COMMAND,
    "plan rolling": _COMMAND | _KERNEL,
    "plot a.nc -o a.png": _COMMAND | _ATLAS | {"matplotlib"},
    "explain a.nc roll_rate=3 tilt=1deg": _COMMAND | _ATLAS | _KERNEL,
    "run rolling roll_rate=2:4:4 tilt=1deg --overwrite -o b.nc": _COMMAND | _FILE | _KERNEL,
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with an atlas."""
    folder = tmp_path_factory.mktemp("start_up")
    sweep.run_to_file(sweep.SweepSpec(roll_rate="2:4:9", tilt="1deg:5deg:8"), folder / "a.nc")
    return folder


def loaded_by(line, folder):
    """Run a command line in a fresh process and return the modules loaded at its end."""
    code = (
        "import sys; from sweep.cli import main\ntry: main()\nfinally: print(*sys.modules, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *shlex.split(line)],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return set(done.stderr.splitlines()[-1].split())


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_a_command_loads_what_it_needs(folder, pick):
    """A command loads no other heavy library, not even indirectly, and never pyplot, which looks for windows."""
    for line in pick(COMMANDS, 6):
        modules = loaded_by(line, folder)
        if "numba" in modules:
            # compiles the kernels that are not cached yet
            modules = loaded_by(line, folder)
        assert "sweep.cli" in modules
        assert {name.partition(".")[0] for name in modules} & HEAVY <= COMMANDS[line]
        assert "matplotlib.pyplot" not in modules
