"""A saved motion can be drawn, filmed and exported with the same result as when it was made."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from messages import assert_facts

pytestmark = pytest.mark.compiled

MOTION = "tilt_rate=0.01 roll_rate=2 duration=0.2s"


@pytest.fixture
def saved(command):
    """Return a function that runs a command in a folder that contains the file of a disk's motion."""
    assert command(f"simulate {MOTION} -o path.nc --plot first.png")[0] == 0
    return command


def test_a_figure_of_a_file(saved, tmp_path):
    """A figure from the file equals, byte for byte, the one drawn with the motion; --dpi makes it larger."""
    assert saved("plot path.nc -o second.png") == (0, "", "")
    assert (tmp_path / "second.png").read_bytes() == (tmp_path / "first.png").read_bytes()
    assert saved("plot path.nc -o large.png --dpi 300") == (0, "", "")
    assert (tmp_path / "large.png").read_bytes() != (tmp_path / "first.png").read_bytes()


@pytest.mark.slow_lane
def test_a_film_of_a_file(saved, tmp_path):
    """A film from the file equals, byte for byte, the one made with the motion and the same options."""
    options = "--speed 0.4 --size 200x200"
    assert saved(f"plot path.nc -o second.gif {options}")[0] == 0
    assert saved(f"simulate {MOTION} -o again.nc --animate first.gif {options}")[0] == 0
    assert (tmp_path / "second.gif").read_bytes() == (tmp_path / "first.gif").read_bytes()


def test_a_table_of_a_file(saved, tmp_path):
    """The table has a row for each sample and every variable with all digits; flags are words."""
    status, _, err = saved("export path.nc --to csv")
    assert status == 0
    assert_facts(err, "path.csv", "1001 samples")
    table = pd.read_csv(tmp_path / "path.csv")
    with xr.open_dataset(tmp_path / "path.nc", decode_times=False) as motion:
        assert {*table.columns} == {*map(str, motion.variables)}
        assert len(table) == motion.sizes["elapsed_time"]
        for name in ("elapsed_time", "tilt", "energy"):
            assert np.array_equal(table[name], motion[name].values)
        assert {*table["contact"]} == {"rolls"}
        assert {*table["alpha"]} == {float(motion["alpha"])}
    assert saved("export path.nc --to csv")[0] == 2


@pytest.mark.parametrize(
    ("line", "facts"),
    [
        ("plot path.nc -o x.png --rate squared --bare", ["--rate", "--bare"]),
        ("plot path.nc -o x.png --speed 3", ["--speed", "x.gif"]),
        ("plot path.nc -o x.gif --dpi 100", ["--dpi 100", "--size 1280x720"]),
        ("plot path.nc path.nc -o x.png", ["path.nc path.nc"]),
        ("plot path.nc tilt=3 -o x.png", ["tilt=3"]),
        ("export path.nc tilt=3 --to csv", ["tilt=3"]),
        ("export path.nc --to csv -o path.nc", ["path.nc"]),
        ("verify path.nc", ["info", "plot", "export"]),
    ],
)
def test_refused(saved, tmp_path, line, facts):
    """Requests that do not fit a motion, or would overwrite its file, are refused; nothing is written."""
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    status, out, err = saved(line)
    assert (status, out) == (2, "")
    assert_facts(err, *facts)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_motion_of_a_system(command):
    """A motion of a system is drawn and exported; a film is refused with the `plot` command instead."""
    assert command("simulate kapitza shake=80 duration=0.5 -o fall.nc")[0] == 0
    assert command("plot fall.nc -o fall.png") == (0, "", "")
    assert command("export fall.nc --to csv")[0] == 0
    status, _, err = command("plot fall.nc -o fall.gif")
    assert status == 2
    assert_facts(err, "kapitza", "fall.png")


def test_an_atlas_is_not_filmed(command):
    """A film of an atlas, and film options for one, are refused with the name of a figure."""
    assert command("run rolling roll_rate=2:4:3 tilt=1deg -o a.nc")[0] == 0
    for line, fact in (("-o a.gif", "a.gif"), ("-o a.png --fps 3", "--fps 3")):
        status, _, err = command(f"plot a.nc {line}")
        assert status == 2
        assert_facts(err, fact, "a.png", "--from")
    assert command("plot a.nc -o a.png")[0] == 0
