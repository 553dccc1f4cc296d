"""Motions of systems against SciPy with the C library's functions, closed forms, and the cells of a sweep."""

import math
import re
import shutil
from itertools import pairwise
from pathlib import Path

import compile_ahead
import netCDF4
import numpy as np
import pytest
import xarray as xr
from messages import assert_facts, assert_in_order, refused, row
from scipy.integrate import solve_ivp

import sweep
from sweep.figures import plots
from sweep.motion.request import MotionRequest
from sweep.motion.sampling import end_of, ending_of, peaks_of, request_of
from sweep.request.system_file import read_system
from sweep.systems import System, system

pytestmark = pytest.mark.compiled

BEAD = Path(__file__).parents[1] / "models" / "bead.py"
B = math.sqrt(3.0) / 2.0


OSCILLATOR = System(
    read_system("""
@system(duration="20 s", ends={"above": "x > level"}, measures={"top": "max x", "now": "last x + v/one"},
        label={"right": "x > 0", "left": True}, conserved="x**2*one**2 + v**2")
def oscillator(x: "m" = 1.0, v: "m/s" = 0.0, *, level: "m" = 10.0, one: "1/s" = 1.0):
    return v, -(one**2)*x
""")
)


@system(duration="60")
def lorenz(x=1.0, y=1.0, z=1.0, *, s=10.0, r=28.0, b=8.0 / 3.0):
    """The Lorenz system."""
    return s * (y - x), x * (r - z) - y, x * y - b * z


@system(duration="2", ends={"high": "y > level"})
def hyperbola(y=1.0, *, level=1e9):
    """Solution: 1/(1 - t)."""
    return y**2


def magnets(_, s):
    """Return the rates of the magnetic pendulum, magnet by magnet."""
    x, y, u, v = s
    pull = [-0.5 * x - 0.2 * u, -0.5 * y - 0.2 * v]
    for east, north in ((1.0, 0.0), (-0.5, B), (-0.5, -B)):
        cube = math.sqrt((x - east) ** 2 + (y - north) ** 2 + 0.0625) ** 3
        pull[0] += (east - x) / cube
        pull[1] += (north - y) / cube
    return [u, v, *pull]


#: Preset -> inputs of a motion that is not chaotic, and its right-hand side as a physicist writes it.
SYSTEMS = {
    "kapitza": ({"shake": 120.0, "angle": 0.3, "duration": "5s"}, lambda t, s: [
        s[1], (9.81 - 0.02 * 120.0**2 * math.cos(120.0 * t)) / 0.2 * math.sin(s[0])]),
    "driven_pendulum": ({"torque": 0.2, "duration": 60.0}, lambda t, s: [
        s[1], 0.2 * math.cos(0.8 * t) - 0.1 * s[1] - math.sin(s[0])]),
    "henon_heiles": ({"u": 0.2, "v": 0.3, "duration": 60.0}, lambda _, s: [
        s[2], s[3], -s[0] - 2.0 * s[0] * s[1], -s[1] - s[0] ** 2 + s[1] ** 2]),
    "magnets": ({"x": 0.9, "y": 0.2, "duration": 20.0}, magnets),
    "thomas": ({"b": 0.3, "duration": 60.0}, lambda _, s: [
        math.sin(s[1]) - 0.3 * s[0], math.sin(s[2]) - 0.3 * s[1], math.sin(s[0]) - 0.3 * s[2]]),
    str(BEAD): ({"hoop_rate": 6.0, "duration": "10s"}, lambda _, s: [
        s[1], 36.0 * math.sin(s[0]) * math.cos(s[0]) - 9.81 / 0.5 * math.sin(s[0])]),
}  # fmt: skip


@pytest.mark.slow_lane
@pytest.mark.parametrize(
    "name",
    [
        each if each in compile_ahead.SYSTEMS else pytest.param(each, marks=pytest.mark.release)
        for each in SYSTEMS
    ],
)
def test_the_whole_path_is_that_of_scipy(name):
    """500 samples of every state match DOP853 at tolerance 1e-12, within DOP853's own error and 1e-12.

    That error is taken as a tenth of the largest difference from DOP853 at tolerance 1e-10.
    """
    words, rate = SYSTEMS[name]
    motion = sweep.simulate(name, **words, interval=float(str(words["duration"]).strip("s")) / 500)
    times, names = motion.elapsed_time.values, [*motion.data_vars][: 2 * len(rate(0.0, [0.1] * 4)) : 2]
    ours = np.array([motion[each].values for each in names])
    assert ours.shape[1] == 501
    fine, rough = (
        solve_ivp(
            rate, (0.0, times[-1]), ours[:, 0], "DOP853", times, rtol=tolerance, atol=1e-2 * tolerance
        ).y
        for tolerance in (1e-12, 1e-10)
    )
    size = np.abs(fine).max(axis=1, keepdims=True)
    off = np.abs(rough - fine).max() / size.max()
    assert 1e-12 < off < 1e-5
    assert np.all(np.abs(ours - fine) <= (0.1 * off + 1e-12) * size), name


@pytest.mark.slow_lane
def test_states_and_measures_of_an_oscillator():
    """States are cosine and sine, measures are their values up to then, each within its stated error."""
    motion = sweep.simulate(OSCILLATOR, x=0.5, v=1.0, duration="30s")
    t, size = motion.elapsed_time.values, math.hypot(0.5, 1.0)
    truth = {"x": 0.5 * np.cos(t) + np.sin(t), "v": np.cos(t) - 0.5 * np.sin(t)}
    first = math.atan2(1.0, 0.5)
    truth["top"] = np.where(t < first, truth["x"], size)
    truth["now"] = truth["x"] + truth["v"]
    for name, values in truth.items():
        off = np.abs(motion[name].values - values)
        # Rounding of the closed form at t = 30.
        within = off <= motion[f"{name}_error"].values + 8e-15
        assert within.mean() >= 0.999, name
        assert off.max() <= 1e-11, name
        assert motion[f"{name}_error"].values.max() < 1e-9, name
    # The relative error of x^2 is twice that of x.
    assert motion.conserved_change.values.max() < 1e-12
    assert (ending_of(motion), float(motion.end_time), float(motion.sensitive_from)) == pytest.approx(
        ("runs on", np.nan, np.nan), nan_ok=True
    )
    assert int(motion.label) == (1 if truth["x"][-1] > 0.0 else 2)
    # Close enough for a smooth figure.
    assert np.diff(t).max() <= 0.2
    assert [motion.elapsed_time.units, motion.x.units, motion.v.units, motion.top.units] == [
        "s",
        "m",
        "m s-1",
        "m",
    ]


@pytest.mark.slow_lane
def test_a_motion_ends_with_the_sample_of_its_event():
    """1/(1 - t) reaches 8 at 7/8: for any interval the last sample is there and none comes later."""
    at = 0.875
    for interval in ("auto", 0.1, at / 7.0, 2.0):
        motion = sweep.simulate(hyperbola, level=8, interval=interval)
        assert abs(float(motion.end_time) - at) <= float(motion.end_time_error)
        assert float(motion.end_time_error) < 1e-9
        assert motion.elapsed_time.values[-1] == float(motion.end_time)
        assert np.diff(motion.elapsed_time.values).min() > 0.0
        assert motion.y.values[-1] == pytest.approx(8.0, rel=1e-13)
        assert np.all(motion.y.values[:-1] < 8.0)
        assert (ending_of(motion), end_of(motion)) == ("high", "high at 0.875")
    assert motion.sizes["elapsed_time"] == 2


def test_it_ends_as_the_cell_of_a_sweep(rng):
    """Ending, end time and final states match the sweep's cell within its stated errors."""
    angles, shakes = rng.uniform(0.01, 1.2, 4), rng.uniform(70.0, 160.0, 4)
    atlas = sweep.run("kapitza", angle=sorted(angles), shake=sorted(shakes), duration="4s")
    endings = set()
    for angle in atlas.angle.values:
        for shake in atlas.shake.values:
            cell = atlas.sel(angle=angle, shake=shake)
            motion = sweep.simulate("kapitza", angle=angle, shake=shake, duration="4s")
            endings.add(int(cell.ending))
            assert int(motion.ending) == int(cell.ending)
            assert abs(motion.elapsed_time.values[-1] - float(cell.end_time)) <= float(cell.end_time_error)
            # The files of both store it in four bytes.
            assert float(motion.end_time_error) == pytest.approx(float(cell.end_time_error), rel=1e-6)
            for name in ("angle", "speed"):
                stated = float(cell[f"{name}_end_error"])
                assert float(motion[f"{name}_error"].values[-1]) == pytest.approx(stated, rel=1e-6)
                assert abs(motion[name].values[-1] - cell[f"{name}_end"]) <= cell[f"{name}_end_error"], name
            assert abs(motion.peak.values[-1] - cell.peak) <= cell.peak_error
    assert len(endings) == 2
    again = atlas.eulerdisk.simulate(angle=atlas.angle.values[0], shake=atlas.shake.values[0])
    assert float(request_of(again).duration) == 4.0


@pytest.mark.slow_lane
def test_from_where_a_chaotic_motion_is_not_known():
    """At tolerance 1e-11 Lorenz's motion is lost when its last two passes diverge, earlier than at 1e-14."""
    rough, fine = (sweep.simulate(lorenz, tolerance=each, interval=0.01) for each in (1e-11, 1e-14))
    assert (ending_of(rough), ending_of(fine)) == ("sensitive", "sensitive")
    parted = float(rough.sensitive_from)
    apart = np.abs(rough.x.values - fine.x.values)
    until = rough.elapsed_time.values < parted
    assert 15.0 < parted < float(fine.sensitive_from) < 60.0
    # A pass differs from the truth by 1 % of the passes' difference, up to the attractor's size.
    assert apart[until].max() < 0.01
    assert apart[~until].max() > 10.0
    assert_facts(end_of(rough), "sensitive", f"{parted:.6g}")


def test_what_cannot_be_followed_says_until_when():
    """1/(1 - t) has no value at 1, and no sample beyond."""
    with pytest.raises(sweep.RequestError) as caught:
        sweep.simulate(hyperbola, level=1e300)
    assert re.search(r"(?<![\w.])(1|0\.99\d*)(?![\w.]*\d)", caught.value.message), caught.value.message
    assert sweep.simulate(hyperbola, duration=0.9).y.values[-1] == pytest.approx(10.0, rel=1e-11)


def test_a_motion_carries_its_system(tmp_path, monkeypatch):
    """The file suffices to read, describe and draw the motion, and to recompute it bit for bit."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(BEAD, "mine.py")
    sweep.save(sweep.simulate("mine.py", hoop_rate=6, duration="3s", interval="0.5s"), "a.nc")
    (tmp_path / "mine.py").unlink()
    with xr.open_dataset("a.nc") as motion:
        assert "start" not in repr(motion.eulerdisk)
        assert motion.attrs["title"] in motion.eulerdisk._repr_html_()
        lines = [len(each.get_xdata()) for each in plots.motion_figure(motion).axes[0].get_lines()]
        assert max(lines) >= 1000
        request = request_of(motion)
        assert MotionRequest.read(**request.words()) == request
        again = sweep.simulate(request)
        assert all((again[name].values == motion[name].values).all() for name in ("angle", "rate"))
        with refused("film", "rolling disk", "bead"):
            motion.eulerdisk.animate("a.gif")
    with netCDF4.Dataset("a.nc") as file:
        assert file.dimensions.keys() == {"elapsed_time"}
        assert file["angle"].coordinates == "hoop_rate radius gravity"
        assert file["ending"].flag_meanings.split()[-1] == "over"


@pytest.mark.slow_lane
def test_the_figure_shows_states_events_and_the_end():
    """One panel per state, a line per event of a single state, and a portrait of two to four states."""
    drawn = plots.motion_figure(sweep.simulate("kapitza", shake=80)).axes
    assert [axes.get_ylabel() for axes in drawn] == ["angle (deg)", *["speed (rad s$^{-1}$)"] * 2]
    levels = [line.get_ydata()[0] for line in drawn[0].get_lines() if line.get_label() == "fell"]
    assert levels == pytest.approx([90.0])
    assert len(drawn[2].get_legend().get_texts()) == 2
    assert_facts(drawn[2].get_legend().get_texts()[1].get_text(), "fell", "1.23264 s")
    x, y = drawn[2].get_lines()[-1].get_data()
    assert (x[0], y[0]) == (drawn[0].get_lines()[-1].get_ydata()[0], drawn[1].get_lines()[-1].get_ydata()[0])
    assert len(plots.motion_figure(sweep.simulate(hyperbola, level=2)).axes) == 1
    chaotic = plots.motion_figure(sweep.simulate(lorenz)).axes
    assert len(chaotic) == 4
    assert_facts(chaotic[0].get_legend().get_texts()[0].get_text(), "sensitive")


REFUSED = {
    "mine.py hoop_rate=3:5:3": ["hoop_rate", "one number"],
    "mine.py hop_rate=3": ["hop_rate", "hoop_rate?"],
    "mine.py tilt=3": ["tilt", "angle, rate, hoop_rate"],
    "mine.py criterion=x": ["criterion", "eulerdisk run"],
    "mine.py duration=0": ["duration", "> 0"],
    "mine.py angle=190deg": ["over", "angle=3.31613", "rate=0"],
    "mine.py duration=1h interval=1us": ["samples", "interval=auto"],
    "mine.py interval=2m": ["interval", "s, ms, min"],
    "mine.py method=rk4": ["method", "eulerdisk run"],
    "mine.py title": ["NAME=VALUE"],
    "mine.py --animate a.gif": ["disk", "--plot"],
    "none.py": ["none.py", "cannot be read"],
    "mine.py --from a.nc": ["mine.py", "preset", "cell"],
    "--from a.nc hoop_rate=4.5": ["hoop_rate", "angle"],
    "--from a.nc hoop_rate=4.5 angle=1deg shake=3": ["shake"],
    "torus tilt=1deg": ["torus", "tube", "roll_rate"],
}  # fmt: skip


@pytest.mark.slow_lane
def test_the_command(command, tmp_path):
    """It follows a file, a preset or a cell; `explain` prints the command; a refusal writes nothing."""
    shutil.copy(BEAD, "mine.py")
    status, _, told = command("simulate mine.py hoop_rate=6 duration=3s -o path.nc --plot path.png")
    assert status == 0
    assert re.search(r"highest 84\.8\d* deg", told)
    assert_facts(told, "path.nc", "1001 samples", "lowest 1 deg", "3 s")
    assert (tmp_path / "path.png").stat().st_size > 10_000
    status, _, told = command("simulate kapitza shake=80 -o k.nc")
    assert_facts(told, "kapitza", "angle=1deg")
    assert_facts(told, "peak 90 deg", "1.23264 s")
    assert command("run mine.py hoop_rate=4:5:3 angle=1deg:3deg:3 -q -o a.nc")[0] == 0
    status, told, _ = command("explain a.nc hoop_rate=4.5 angle=2deg --plot cell.svg")
    assert status == 0
    assert_facts((tmp_path / "cell.svg").read_text(), "unstable", "not highest")
    line = row(told, "motion")
    assert line == "motion eulerdisk simulate --from a.nc hoop_rate=4.5 angle=2deg -o path.nc"
    assert command(f"{line.split('eulerdisk ')[1]} --overwrite")[0] == 0
    _, told, _ = command("info path.nc")
    assert_facts(row(told, "start"), "angle 2 deg", "rate 0 rad s-1")
    assert_facts(row(told, "system"), "hoop_rate 4.5 rad s-1")
    assert_in_order(row(told, "time"), "1001", "0", "10 s")
    assert row(told, "lowest")
    status, _, told = command("verify path.nc")
    assert status == 2
    assert_facts(told, "path.nc", "motion")
    before = {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    for line, words in REFUSED.items():
        status, _, told = command(f"simulate {line} -o new.nc")
        assert status == 2, line
        assert_facts(told, *words)
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before


def test_samples_increase_where_interval_and_duration_do_not_fit():
    """The last sample is at the duration, the others at equal intervals before it."""
    motion = sweep.simulate(OSCILLATOR, duration="1s", interval="0.3s")
    assert motion.elapsed_time.values == pytest.approx(np.linspace(0.0, 1.0, 5))
    assert all(one < other for one, other in pairwise(motion.elapsed_time.values))


@system(duration="10")
def burst(y=1.0, *, rate=1e9):
    """Diverges at 1/rate."""
    return rate * y**2


def test_a_motion_that_cannot_be_followed_far():
    """The message gives the time and repeats no advice."""
    with refused("1e-09", "ends=") as caught:
        sweep.simulate(burst)
    assert str(caught.value).count("shorter duration") == 1


def test_measures_until_a_sample():
    """Counts, moments and integrals so far are those of the closed form; the report names what is missing or open."""
    counted = System(
        read_system("""
@system(duration="20 s", measures={"turns": "count x > 0.5 m", "began": "time of first x > 0.5 m",
    "never": "time of first x > 2 m", "area": "integral x", "when": "time of max x"})
def oscillator(x: "m" = 1.0, v: "m/s" = 0.0, *, one: "1/s" = 1.0):
    return v, -(one**2)*x
""")
    )
    found = sweep.simulate(counted, interval="0.25 s")
    time = found["elapsed_time"].values
    np.testing.assert_allclose(found["area"], np.sin(time), atol=1e-11)
    first = 2.0 * math.pi - math.acos(0.5)
    np.testing.assert_array_equal(found["turns"], np.floor((time - first) / (2.0 * math.pi)) + 1.0)
    np.testing.assert_allclose(found["began"], np.where(time < first, np.nan, first), rtol=0, atol=1e-11)
    assert np.isnan(found["never"]).all()
    assert found["began"].attrs["units"] == "s"
    assert_facts(found["began"].attrs["comment"], "missing", "never became true")
    # all maxima are as great as the start
    told = dict(peaks_of(found))
    assert told == {**told, "turns": "3", "never": "missing", "when": "undecided"}
