"""Reading atlas files: a file that is damaged or not an atlas is refused with the reason."""

import netCDF4
import pytest
from messages import refused

from sweep.atlas.cf_metadata import FORMAT
from sweep.files.reading import open_atlas
from sweep.request.spec import SweepSpec
from sweep.runs.run import run_to_file

SPEC = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)


@pytest.fixture
def path(tmp_path):
    """Return the path where a test writes its atlas."""
    return tmp_path / "atlas.nc"


def test_files_that_are_no_atlas(path, tmp_path):
    """A missing file, a folder, text, a truncated file and another program's netCDF are refused by name."""
    run_to_file(SPEC, path)
    whole = path.read_bytes()
    contents = {
        "text.nc": b"tilt,rate\n",
        "empty.nc": b"",
        "cut.nc": whole[:-2],
        "half.nc": whole[: len(whole) // 2],
    }
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
        with refused(f"{tmp_path / name}:", "netCDF-4", f"{len(content)} bytes"):
            open_atlas(tmp_path / name)
    with netCDF4.Dataset(tmp_path / "foreign.nc", "w") as file:
        file.title = "Ocean"
    with refused("foreign.nc:", "eulerdisk_format", "'Ocean'"):
        open_atlas(tmp_path / "foreign.nc")
    for name in ("missing.nc", "y" * 300):
        with refused("no such file"):
            open_atlas(tmp_path / name)
    with refused("folder"):
        open_atlas(tmp_path)


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        (
            lambda file: file.setncattr("eulerdisk_format", FORMAT + 1),
            ["newer", f"{FORMAT}", f"format {FORMAT + 1}"],
        ),
        (lambda file: file.delncattr("sweep_spec"), ["sweep_spec"]),
        (lambda file: file.renameVariable("tilt_min", "least"), ["lacks tilt_min"]),
    ],
)
def test_atlases_that_this_version_cannot_read(path, change, facts):
    """A newer format and missing parts are refused, and the file is closed again."""
    run_to_file(SPEC, path)
    with netCDF4.Dataset(path, "a") as file:
        change(file)
    with refused("atlas.nc:", *facts):
        open_atlas(path)
    # HDF5 locks a file that is open for reading against writers
    netCDF4.Dataset(path, "a").close()
