"""`info`, `boundary`, `plot`: the reports and figures of an atlas; a damaged file is refused."""

import os
import subprocess
import sys
from pathlib import Path

import sweep
from sweep.atlas.reclassify import reclassify
from sweep.commands.report import boundary_table, describe
from sweep.files.netcdf import open_atlas

CHECKOUT = Path(__file__).parents[2]
SMALL = ["roll_rate=2:4:9", "tilt=0.1deg,1deg"]


def test_info_and_boundary_print_the_reports(command, tmp_path):
    """What is printed on standard output is the report, and with another criterion that of the reclassified atlas."""
    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    with open_atlas(tmp_path / "a.nc") as atlas:
        assert command("info a.nc") == (0, describe(atlas) + "\n", "")
        assert command("boundary a.nc") == (0, boundary_table(atlas) + "\n", "")
        other = boundary_table(reclassify(atlas, "departure:1deg"))
    assert command("boundary a.nc --criterion departure:1deg") == (0, other + "\n", "")
    assert other != command("boundary a.nc")[1].strip("\n")


def test_an_atlas_that_is_cut(command, tmp_path):
    """A truncated file is refused with one message by every command that reads."""
    command("run rolling roll_rate=3 tilt=1deg -o a.nc")
    (tmp_path / "b.nc").write_bytes((tmp_path / "a.nc").read_bytes()[:-100])
    for line in ("info b.nc", "boundary b.nc"):
        status, out, err = command(line)
        assert (status, out) == (2, "")
        assert err.startswith("eulerdisk: b.nc: ")
        assert "not a readable netCDF file" in err


def test_a_reader_that_leaves_early(tmp_path):
    """Piping into a reader that closes, like head, ends without a traceback."""
    sweep.run_to_file(sweep.SweepSpec(roll_rate="2:4:3", tilt="1deg:5deg:5000"), tmp_path / "a.nc")
    process = subprocess.Popen(
        [sys.executable, "-m", "sweep", "boundary", "a.nc"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdout.readline()
    process.stdout.close()
    assert process.stderr.read() == ""
    process.stderr.close()
    assert process.wait(timeout=60) == 1


def test_regimes_are_drawn(command, tmp_path):
    """`plot --regimes` draws any map, whatever its method; a criterion or friction has no meaning there."""
    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    assert command("plot a.nc --regimes -o a.png")[0] == 0
    assert (tmp_path / "a.png").stat().st_size > 10_000
    for more in ("--criterion departure:2deg", "--friction 0.5"):
        status, _, err = command(f"plot a.nc --regimes {more} -o b.png")
        assert status == 2
        assert "--regimes" in err
        assert more.split()[0] in err
        assert not (tmp_path / "b.png").exists()
