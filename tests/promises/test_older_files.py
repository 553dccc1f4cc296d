"""Files outlive versions: atlases of version 0.1 serve a program whose disk has one parameter and one output more.

The files in tests/promises/older were made by version 0.1.0 with SOURCE_DATE_EPOCH=1700000000:
`eulerdisk run rolling roll_rate=2:3:8 tilt=0.1deg:5deg:6:log` and
`eulerdisk run circling precession_rate=0.5:4:6 tilt=5deg,10deg contact=yes method=exact`.
"""

import re
import shutil
from pathlib import Path

import pytest
import xarray as xr
from source_copy import SourceCopy

import sweep
from sweep.atlas.dataset import spec_of
from sweep.checks.compare import compare

OLDER = Path(__file__).parent / "older"

#: What the version with one parameter and one output more does with the older files, in one process.
LINES = [
    "info rolling-0.1.nc",
    "info circling-0.1.nc",
    "plot rolling-0.1.nc circling-0.1.nc -o both.png",
    "boundary rolling-0.1.nc",
    "boundary circling-0.1.nc --criterion departure:1deg",
    "export circling-0.1.nc --to csv -o circling.csv",
    "run --from rolling-0.1.nc -o rolling.nc",
    "run --from circling-0.1.nc -o circling.nc",
    "compare rolling.nc rolling-0.1.nc",
    "compare circling.nc circling-0.1.nc",
    "verify rolling-0.1.nc",
    "verify circling-0.1.nc --write audit.nc",
    "explain rolling-0.1.nc roll_rate=2.5 tilt=1deg",
    "explain circling-0.1.nc precession_rate=2 tilt=5deg",
    "run --from rolling-0.1.nc viscosity=0,1 -o axis.nc",
    "run rolling roll_rate=2:3:8 tilt=1deg viscosity=0.5 -o one.nc",
    "compare one.nc rolling-0.1.nc",
    "compare rolling-0.1.nc rolling.nc",
    "simulate tilt_rate=0.01 roll_rate=2 duration=1s viscosity=0.5 -o path.nc --plot path.png",
    "simulate tilt_rate=0.01 roll_rate=2 duration=1s method=dop853 -o other-path.nc",
    "explain rolling-0.1.nc roll_rate=2 tilt=5deg --plot cell.png",
]

#: Those of them that find a difference, or refuse to look for one.
DIFFERING = ("compare one.nc rolling-0.1.nc", "compare rolling-0.1.nc rolling.nc")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the older files, and what the newer version makes of them."""
    folder = tmp_path_factory.mktemp("older")
    for path in OLDER.iterdir():
        shutil.copy(path, folder)
    return folder


@pytest.fixture(scope="module")
def ends(folder):
    """Return how each of `LINES` ended under the newer version: status, output, messages."""
    copy = SourceCopy(folder / "one-parameter-and-one-output-more")
    copy.edit("kernels/disk/arrays.py", '"radius", "gravity")', '"radius", "gravity", "viscosity")')
    copy.edit("kernels/disk/arrays.py", "RADIUS, GRAVITY = range", "RADIUS, GRAVITY, VISCOSITY = range")
    copy.edit(
        "sweep/model/disk/tables.py",
        '"gravity > 0", positive),\n)',
        '"gravity > 0", positive),\n'
        '    _input("viscosity", r"\\eta", "1", "viscosity of the air", 0.0, "any", np.isfinite, added_later=True),\n)',
    )
    # at the ends of the tables, whatever stands there
    copy.edit("kernels/disk/arrays.py", '")\nTILT_MIN, TILT_MAX,', '", "swing")\nTILT_MIN, TILT_MAX,')
    copy.edit("kernels/disk/arrays.py", " = range(len(MEASURES))", ", SWING = range(len(MEASURES))")
    copy.edit(
        "kernels/disk/leg_control.py",
        "    measures[row.TILT_ERROR, cell] = error\n",
        "    measures[row.TILT_ERROR, cell] = error\n    measures[row.SWING, cell] = greatest - least\n",
    )
    copy.edit(
        "sweep/model/disk/tables.py",
        'STEP_COUNT, "", "i1"),\n)',
        'STEP_COUNT, "", "i1"),\n    Quantity("swing", "", "rad", "between the extreme tilts", _TILT),\n)',
    )
    return copy.session(LINES, folder)


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_an_older_atlas_serves_every_command(ends):
    """Read, plotted, exported, repeated, compared, verified, explained: each command ends well."""
    for line in (line for line in LINES if line not in DIFFERING):
        status, out, err = ends[line]
        assert status == 0, (line, err)
        assert "Traceback" not in out + err, line


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize("name", ["rolling", "circling"])
def test_the_older_atlas_is_the_newer_one(folder, ends, name):
    """Repeated from the file, every cell is the same, and so are the words and the fingerprint of the request."""
    assert ends[f"compare {name}.nc {name}-0.1.nc"][1].startswith("within tolerance: ")
    assert "verified: " in "".join(out for line, (_, out, _) in ends.items() if f"verify {name}" in line)
    with xr.open_dataset(OLDER / f"{name}-0.1.nc") as older, xr.open_dataset(folder / f"{name}.nc") as newer:
        for word in ("sweep_spec", "sweep_fingerprint"):
            assert newer.attrs[word] == older.attrs[word]
        status = {name for name in newer.variables if name.endswith("_status")}
        assert status
        # the first atlases with contact forces did not say what is known of them
        added = {"contact_state"} if name == "circling" else set()
        assert set(newer.variables) - set(older.variables) == {"viscosity", "swing", *status} | added
        assert newer["viscosity"].item() == 0.0


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_the_parameter_that_was_added_is_a_parameter(folder, ends):
    """It is an axis like any other; with another value than its default, a request is another one.

    A single motion has it too, among the fixed parameters of its file.
    """
    with xr.open_dataset(folder / "path.nc") as path:
        assert path["viscosity"].item() == 0.5
        assert "viscosity" in path["tilt"].encoding["coordinates"]
    with xr.open_dataset(folder / "axis.nc") as found, xr.open_dataset(OLDER / "rolling-0.1.nc") as older:
        assert dict(found.sizes) == {**older.sizes, "viscosity": 2}
        for side in (0, 1):
            part = found["tilt_max"].isel(viscosity=side, drop=True)
            xr.testing.assert_allclose(part, older["tilt_max"])
    status, _, err = ends["compare one.nc rolling-0.1.nc"]
    assert status == 2
    assert re.search(r"viscosity.*0\.5.*0\b", err)


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_the_output_that_was_added_is_an_output(folder, ends):
    """The regression check names it where the reference lacks it, and misses it where the reference has it."""
    with xr.open_dataset(folder / "rolling.nc") as newer:
        swing = newer["tilt_max"] - newer["tilt_min"]
        assert swing.notnull().any()
        xr.testing.assert_allclose(newer["swing"], swing)
    told = "not judged: swing is not compared: the reference atlas does not have it"
    assert told in ends["compare rolling.nc rolling-0.1.nc"][1]
    status, words, _ = ends["compare rolling-0.1.nc rolling.nc"]
    assert status == 1
    assert words.startswith("DIFFERENT in swing, boundary_roll_rate_status\n")
    assert "swing" not in ends["explain rolling-0.1.nc roll_rate=2 tilt=5deg --plot cell.png"][1]


@pytest.mark.parametrize("name", ["rolling", "circling"])
def test_this_version_computes_the_older_atlas(name):
    """Read by this version, the request has its fingerprint, and its atlas passes the regression check."""
    with sweep.open_atlas(OLDER / f"{name}-0.1.nc") as older:
        spec = spec_of(older)
        assert spec.fingerprint() == older.attrs["sweep_fingerprint"]
        assert compare(sweep.run(spec), older).same
