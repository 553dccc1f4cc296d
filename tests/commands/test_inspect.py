"""`info`, `boundary`, `plot`: the reports and figures of an atlas; a damaged file is refused."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import sweep
from sweep.atlas.reclassify import reclassify
from sweep.commands.report import boundary_table, describe
from sweep.files.reading import open_atlas

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


@pytest.mark.parametrize(
    "line", ["info a.nc", "boundary a.nc", "export a.nc --to csv -o a.csv", "plot a.nc -o a.png"]
)
def test_what_a_user_has_added_is_left_out(command, tmp_path, line):
    """A string and a variable of another dimension do not keep an atlas from being read; one line says so."""
    atlas = sweep.run(sweep.SweepSpec(tilt="1deg:2deg:3", roll_rate="2:3:4"))
    added = atlas.assign(remark="of June", sst=("time", [1.0, 2.0]))
    added.to_netcdf(tmp_path / "a.nc", format="NETCDF4", engine="netcdf4")
    status, _, err = command(line)
    assert (status, err.count("left out")) == (0, 1)
    assert err.startswith("eulerdisk: warning: a.nc: no part of an atlas, and left out: ")
    if "csv" in line:
        head = (tmp_path / "a.csv").read_text().partition("\n")[0].split(",")
        assert not {"remark", "sst", "time"}.intersection(head)
