import os
import re
import shlex
import shutil
import signal
import sys

import imageio_ffmpeg
import netCDF4
import numpy as np
import pytest
import xarray as xr
from messages import assert_facts, refused
from PIL import Image

import sweep
from sweep.cli import main
from sweep.figures.disk import animation

pytestmark = pytest.mark.compiled

WORDS = "tilt_rate=0.01 roll_rate=2 duration=0.2s"


@pytest.fixture
def simulate(monkeypatch, capsys, tmp_path):
    """Return a function that runs `eulerdisk simulate` in an empty folder and returns status and messages."""
    monkeypatch.chdir(tmp_path)
    # hides all programs, unless a test adds one
    monkeypatch.setenv("PATH", str(tmp_path))

    def run(line):
        monkeypatch.setattr(sys, "argv", ["eulerdisk", "simulate", *shlex.split(line)])
        with pytest.raises(SystemExit) as end:
            main()
        out, err = capsys.readouterr()
        assert out == ""
        return end.value.code, err

    return run


@pytest.fixture
def ffmpeg(tmp_path_factory):
    """Return a folder that contains only ffmpeg."""
    folder = tmp_path_factory.mktemp("bin")
    (folder / "ffmpeg").symlink_to(imageio_ffmpeg.get_ffmpeg_exe())
    return folder


@pytest.mark.slow_lane
def test_everything_at_once(simulate, tmp_path, ffmpeg, monkeypatch):
    """File, figure and film are written; the messages give the samples, frames and playback speed."""
    monkeypatch.setenv("PATH", str(ffmpeg))
    status, words = simulate(f"{WORDS} -o path.nc --plot path.png --animate disk.mp4")
    assert status == 0
    # 0.2 s become four seconds of 25 frames each; a busy machine shows its progress before
    film, file = words.splitlines()[-2:]
    assert_facts(film, "eulerdisk: disk.mp4", "101 frames", "4.04 s", "0.05 times")
    assert_facts(file, "eulerdisk: path.nc", "1001 samples", "peak tilt 0.119 deg", "moving", "0.2 s")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["disk.mp4", "path.nc", "path.png"]
    assert (tmp_path / "path.png").read_bytes().startswith(b"\x89PNG")
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "disk.mp4"))
    assert frames == 101
    assert seconds == pytest.approx(101 / 25, abs=0.01)
    with xr.open_dataset(tmp_path / "path.nc") as read:
        assert read.attrs["history"].endswith(
            f"Z eulerdisk simulate {WORDS} -o path.nc --plot path.png --animate disk.mp4"
        )


@pytest.mark.slow_lane
def test_a_gif_needs_no_ffmpeg(simulate, tmp_path):
    """A gif needs only Python and has the requested size, rate and speed.

    Its frame times are whole hundredths of a second that keep the film's duration; the last frame is held.
    """
    options = "--speed 0.2 --fps 30 --size 321x241 --camera top"
    assert simulate(f"{WORDS} -o path.nc --animate disk.gif {options}")[0] == 0
    with Image.open(tmp_path / "disk.gif") as film:
        assert film.n_frames == 31
        assert film.size == (321, 241)
        durations = []
        for frame in range(film.n_frames):
            film.seek(frame)
            durations.append(film.info["duration"])
    assert set(durations[:-1]) == {30, 40}
    assert sum(durations[:-1]) == 1000
    assert durations[-1] > 1000


def test_a_fall_is_told(simulate):
    """The message gives the time of the fall."""
    status, words = simulate("tilt=0.1 tilt_rate=0.1 -o path.nc")
    assert status == 0
    first, second = words.splitlines()
    assert_facts(first, "eulerdisk: path.nc", "1001 samples", "peak tilt 85 deg", "fell", "0.810989 s")
    # the times are those of tests/motion/test_rolling_limit.py
    assert second.startswith("eulerdisk: ")
    assert re.search(r"slips .*0\.\d+ s", second)
    assert_facts(second, "friction=0.5", "0.718016 s")


def test_a_motion_that_is_not_at_its_end_says_what_to_add(simulate):
    """A motion with losses that has not ended gets a suggested duration, which shows the end."""
    words = "toy tilt=70deg -o path.nc --overwrite"
    status, said = simulate(f"{words} duration=2s")
    assert status == 0
    assert_facts(said, "moving", "2 s")
    added = re.search(r"\bduration=(\w+)", said)[1]
    assert added == "20s"
    assert re.search(r"flat .*\d s", simulate(f"{words} duration={added}")[1])


def test_friction_that_is_enough_is_not_mentioned(simulate):
    """A disk that rolls all the time is reported without its friction."""
    status, words = simulate(f"{WORDS} -o path.nc")
    assert (status, words.count("\n")) == (0, 1)
    assert_facts(words, "eulerdisk: path.nc", "1001 samples", "peak tilt 0.119 deg", "moving", "0.2 s")


@pytest.mark.parametrize(
    ("line", "fact"),
    [
        (f"{WORDS} -o path.nc --animate disk.mp4", "ffmpeg"),
        ("tilt_rate=1e200 precession_rate=1e200 -o path.nc", "resolved"),
    ],
)
def test_a_wrong_request_ends_with_2_and_nothing_written(simulate, tmp_path, line, fact):
    """Every refusal has a hint, exits with status 2 and leaves an empty folder (without ffmpeg here)."""
    status, words = simulate(line)
    assert status == 2
    assert_facts(words, fact)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "option"), [("path.nc", ""), ("a.gif", "--animate a.gif"), ("a.png", "--plot a.png")]
)
def test_a_file_that_exists_is_kept(simulate, tmp_path, name, option):
    """No existing file, figure or film is replaced without --overwrite, and none of the others is written."""
    (tmp_path / name).write_text("old")
    status, words = simulate(f"{WORDS} -o path.nc {option}")
    assert status == 2
    assert_facts(words, name, "--overwrite")
    assert [each.name for each in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "old"


def test_an_mp4_has_even_sides(simulate, ffmpeg, monkeypatch, tmp_path):
    """An odd size of an mp4 is refused with the next even ones, as the codec requires."""
    monkeypatch.setenv("PATH", str(ffmpeg))
    status, words = simulate(f"{WORDS} -o path.nc --animate disk.mp4 --size 641x480")
    assert status == 2
    assert_facts(words, "641x480", "642x480")
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_film_leaves_nothing(simulate, tmp_path, monkeypatch):
    """Ctrl-C while drawing frames exits with 130 and leaves an empty folder."""
    draw = animation.draw_floor

    def interrupt(*given, **look):
        os.kill(os.getpid(), signal.SIGINT)
        draw(*given, **look)

    monkeypatch.setattr(animation, "draw_floor", interrupt)
    status, words = simulate(f"{WORDS} -o path.nc --animate disk.gif")
    assert status == 130
    assert_facts(words, "disk.gif", "no")
    assert list(tmp_path.iterdir()) == []


def test_an_ffmpeg_that_fails_leaves_nothing(tmp_path, monkeypatch):
    """The error message of a failing ffmpeg is shown, and no part of a film is left."""
    (tmp_path / "bin").mkdir()
    program = tmp_path / "bin" / "ffmpeg"
    program.write_text(f"#!{shutil.which('sh')}\necho no such codec >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent))
    motion = sweep.simulate(tilt_rate=0.01, roll_rate=2.0, duration=0.1)
    with refused("disk.mp4", "no such codec"):
        motion.eulerdisk.animate(tmp_path / "disk.mp4")
    assert [each.name for each in tmp_path.iterdir()] == ["bin"]


def test_the_file_has_the_profile_of_an_atlas(tmp_path):
    """The file is NETCDF4_CLASSIC with ASCII attributes and units; only floats have a fill value, 9.97e36."""
    motion = sweep.simulate(tilt=0.1, tilt_rate=0.1, duration="2s", title="Fällt")
    sweep.save(motion, tmp_path / "path.nc")
    with netCDF4.Dataset(tmp_path / "path.nc") as file:
        assert file.data_model == "NETCDF4_CLASSIC"
        assert file.Conventions == "CF-1.11, ACDD-1.3"
        assert str(file.title).isascii()
        for name, variable in file.variables.items():
            attributes = {key: variable.getncattr(key) for key in variable.ncattrs()}
            assert all(str(value).isascii() for value in attributes.values())
            assert "long_name" in attributes
            assert ("units" in attributes) != ("flag_values" in attributes)
            filled = variable.dtype.kind == "f" and name not in {"elapsed_time", *variable.dimensions}
            measured = filled and name not in ("alpha", "radius", "gravity", "mass", "friction")
            assert attributes.get("_FillValue") == (9.969209968386869e36 if measured else None), name
    with xr.open_dataset(tmp_path / "path.nc") as read:
        assert read["contact"].dtype == np.int8
        xr.testing.assert_identical(read.load(), motion)


def test_a_motion_says_who_may_use_it_and_how_to_name_it():
    """License, citation, references and software equal those of an atlas."""
    motion, atlas = sweep.simulate(tilt="1deg", duration="1s"), sweep.run("rolling", roll_rate=3, tilt="1deg")
    for name in ("license", "citation", "references", "software"):
        assert motion.attrs[name] == atlas.attrs[name]


def test_info_tells_of_a_motion(tmp_path, command):
    """`info` reports the kind, start and peak of a motion; other commands refuse it and say what to use."""
    peak = np.degrees(np.abs(sweep.simulate(tilt="20deg", roll_rate=1, duration="2s")["tilt"]).max())
    status, _, err = command("simulate tilt=20deg roll_rate=1 duration=2s title=Coin -o path.nc")
    assert status == 0
    assert_facts(err, f"peak tilt {float(peak):.3g} deg")
    status, out, err = command("info path.nc")
    assert (status, err) == (0, "")
    first, *lines = out.splitlines()
    assert_facts(first, "motion", "eulerdisk simulate")
    assert "Coin" in lines
    (start,) = (line for line in lines if line.startswith("start "))
    rates = "tilt_rate 0 rad s-1", "precession_rate 0 rad s-1", "roll_rate 1 rad s-1"
    assert_facts(start, "tilt 20 deg", *rates)
    assert f"peak tilt   {float(peak):.3g} deg" in lines
    for line in ("verify path.nc", "boundary path.nc", "info --json path.nc"):
        status, _, err = command(line)
        assert status == 2
        assert_facts(err, "path.nc", "motion")


def test_info_tells_where_the_energy_of_a_motion_went(command):
    """`info` reports the losses of a motion, its end, and only the nonzero coefficients."""
    assert command("simulate toy tilt=85deg -o stop.nc")[0] == 0
    status, out, _ = command("info stop.nc")
    assert status == 0
    assert "contour_friction 1.5e-05 m" in out
    assert "rolling_friction" not in out
    assert re.search(r"\bflat .*\d s", out)
    (losses,) = (line for line in out.splitlines() if line.startswith("losses "))
    assert re.search(r"\b0\.0\d+ J\b.*\bcontour friction\b.* \d+\.\d %.*\bair\b.* \d+\.\d %", losses)


def test_the_same_request_gives_the_same_bytes(tmp_path, monkeypatch):
    """With a fixed clock, two files of one request are equal byte for byte."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    for name in ("first.nc", "second.nc"):
        sweep.save(sweep.simulate(tilt_rate=0.1, precession_rate=3.5), tmp_path / name)
    assert (tmp_path / "first.nc").read_bytes() == (tmp_path / "second.nc").read_bytes()


@pytest.fixture
def coin(tmp_path):
    """Return the name of an atlas of a coin in the folder of the test."""
    name = "10 p.nc"
    sweep.run_to_file("rolling", tmp_path / name, radius="12mm", roll_rate="13:25:13", tilt="1deg,5deg")
    return name


def test_the_motion_of_a_cell(simulate, coin, tmp_path):
    """A cell given by its exact values is used silently, a nearest one is named; the atlas is unchanged."""
    before = (tmp_path / coin).read_bytes()
    status, words = simulate(f"--from '{coin}' roll_rate=15 tilt=1deg -o on.nc")
    assert (status, words.count("\n")) == (0, 1)
    assert_facts(words, "eulerdisk: on.nc", "1001 samples", "peak tilt 31.1 deg", "moving", "1.67251 s")
    status, words = simulate(f"--from '{coin}' speed=18.1cm/s tilt=1deg duration=2s mass=5g -o near.nc")
    assert status == 0
    assert_facts(words.splitlines()[0], "eulerdisk: 10 p.nc", "nearest", "roll_rate 15 rad s-1")
    with xr.open_dataset(tmp_path / "on.nc") as on, xr.open_dataset(tmp_path / "near.nc") as near:
        assert (float(on.radius), float(on.roll_rate[0]), float(on.mass)) == (0.012, 15.0, 1.0)
        assert (float(near.radius), float(near.roll_rate[0]), float(near.mass)) == (0.012, 15.0, 0.005)
        assert (float(near.elapsed_time[-1]), float(on.elapsed_time[-1]) < 2.0) == (2.0, True)
    assert (tmp_path / coin).read_bytes() == before


def test_an_atlas_that_is_none_is_refused(simulate, tmp_path):
    """A motion is refused as an atlas, and a missing file is named."""
    assert simulate(f"{WORDS} -o path.nc")[0] == 0
    for name in ("path.nc", "absent.nc"):
        status, said = simulate(f"--from {name} roll_rate=15 -o other.nc")
        assert status == 2
        assert_facts(said, name)
    assert [each.name for each in tmp_path.iterdir()] == ["path.nc"]


@pytest.mark.parametrize("cell", ["roll_rate=15.2 tilt=1deg", "'speed=18 cm/s' 'tilt=0.02 rad'"])
def test_explain_ends_with_the_command_of_the_motion(command, coin, tmp_path, cell):
    """The last line of `explain` can be run as printed, for any file name, and repeats the explained start."""
    status, out, _ = command(f"explain '{coin}' {cell}")
    assert status == 0
    label, line = out.splitlines()[-1].split(maxsplit=1)
    assert (label, line.split()[:3]) == ("motion", ["eulerdisk", "simulate", "--from"])
    assert command(line.removeprefix("eulerdisk "))[0] == 0
    with xr.open_dataset(tmp_path / "path.nc") as motion:
        assert float(motion.roll_rate[0]) == 15.0
        assert float(motion.tilt[0]) == pytest.approx(np.radians(1.0), rel=1e-15)


def test_a_cell_without_motion_has_no_command(command, tmp_path):
    """If no rate keeps the tilt, there is no motion, and `explain` does not offer one."""
    sweep.run_to_file(
        "rolling", tmp_path / "a.nc", roll_rate=0.1, tilt="10deg", precession_rate="steady-fast"
    )
    status, out, _ = command("explain a.nc")
    assert status == 0
    assert "simulate" not in out


def test_the_atlas_that_is_read_is_not_replaced(command, tmp_path):
    """The input atlas is not replaced, even with --overwrite."""
    command("run rolling roll_rate=2:4:3 tilt=1deg,2deg -o a.nc")
    before = (tmp_path / "a.nc").read_bytes()
    status, _, err = command("simulate --from a.nc roll_rate=2 tilt=1deg -o a.nc --overwrite")
    assert status == 2
    assert_facts(err, "a.nc", "another file")
    assert (tmp_path / "a.nc").read_bytes() == before


@pytest.mark.release
def test_a_preset_is_followed_to_its_end(simulate, tmp_path):
    """`simulate toy tilt=80deg` writes file, figure and film, and reports the chosen rates and the end."""
    line = "toy inclination=1deg -o stop.nc --plot stop.png --animate stop.gif --speed 0.2 --size 320x240"
    status, words = simulate(line)
    assert status == 0
    first, *_, last = words.splitlines()
    assert first.startswith("eulerdisk: toy: ")
    assert_facts(first, "precession_rate=wobble", "roll_rate=wobble")
    assert last.startswith("eulerdisk: stop.nc: ")
    assert re.search(r"\bflat .*0\.\d+ s", last)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["stop.gif", "stop.nc", "stop.png"]
    with xr.open_dataset(tmp_path / "stop.nc") as read:
        assert read.attrs["history"].endswith(f"Z eulerdisk simulate {line}")
        assert float(read["elapsed_time"][-1]) == float(read["end_time"])
