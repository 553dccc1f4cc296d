"""Motions of bodies of revolution: stated errors, endings as in a sweep, presets, cells, and refusals."""

import math
import re

import numpy as np
import pytest
from body_motion import apart, referee_of
from body_referee import Body
from body_runner import drawn
from messages import assert_facts, refused, row

import sweep
from kernels.bodies.shapes import NAMES
from sweep.model.bodies.tables import VARIABLES
from sweep.motion.sampling import ending_of

pytestmark = pytest.mark.compiled

#: Quantities compared with the referee -> their stated errors.
STATED = {
    "axis": "orientation_error", "painted": "orientation_error", "turning": "rate_error", "centre": "path_error",
    "contact": "path_error", "force": "force_error",
}  # fmt: skip


def followed(word, tilt, rates, lengths, moments, **words):
    """Simulate a body's start with scaled rates, for radius and gravity 1."""
    precession = rates[1] / math.cos(tilt)
    return sweep.simulate(
        body=word, tilt=tilt, tilt_rate=rates[0], precession_rate=precession,
        roll_rate=rates[2] - precession * math.sin(tilt), axial_moment=moments[0], transverse_moment=moments[1],
        radius=1.0, gravity=1.0, **lengths, **words,
    )  # fmt: skip


@pytest.mark.slow_lane
@pytest.mark.parametrize("step", ["auto", 0.1])
def test_a_motion_is_within_its_stated_errors(step):
    """The errors hold for random bodies of all kinds, with the automatic step and a far too long one."""
    rng = np.random.default_rng(31)
    largest = 0.0
    for number in range(2 * len(NAMES)):
        word = NAMES[number % len(NAMES)]
        lengths, moments, arc = drawn(word, rng)
        tilt, rates = rng.uniform(-1.1, 1.1), rng.normal(size=3) * rng.choice([0.3, 1.0])
        motion = followed(word, tilt, rates, lengths, moments, duration=4.0, interval=0.25, step=step)
        of = {name: motion[name].values for name in motion.data_vars}
        times = motion["elapsed_time"].values
        off = apart(of, referee_of(word, arc, moments, tilt), tilt, rates, times)
        for name, error in STATED.items():
            stated = of[error]
            largest = max(largest, float(stated.max()))
            # The referee's own error is up to about 1e-11.
            assert (off[name] <= stated + 3e-12 * (1.0 + times)).all(), (word, number, name)
    assert largest < 1e-8 if step == "auto" else largest > 1e-6


def test_a_disk_is_within_its_stated_errors():
    """The errors of the thin disk hold for random mass distributions and rates, up to near flat."""
    rng, largest = np.random.default_rng(47), 0.0
    for _ in range(12):
        alpha, tilt = rng.uniform(0.05, 1.0), rng.uniform(-1.45, 1.45)
        rates = rng.normal(size=3) * rng.choice([0.3, 1.0, 2.0])
        precession = rates[1] / math.cos(tilt)
        start = {
            "tilt": tilt, "tilt_rate": rates[0], "precession_rate": precession,
            "roll_rate": rates[2] - precession * math.sin(tilt),
        }  # fmt: skip
        motion = sweep.simulate(
            **start, alpha=alpha, radius=1.0, gravity=1.0, mass=1.0, duration=4.0, interval=0.25
        )
        of = {name: motion[name].values for name in motion.data_vars}
        times = motion["elapsed_time"].values
        off = apart(of, Body(1.0, 0.0, 0.0, alpha, 0.5 * alpha), tilt, rates, times)
        for name, error in STATED.items():
            largest = max(largest, float(of[error].max()))
            assert (off[name] <= of[error] + 3e-12 * (1.0 + times)).all(), (alpha, start, name)
    assert largest < 1e-7


def test_a_torus_without_a_tube_is_the_thin_disk():
    """It gives the same file to 1e-10, including energy, forces and the effect of friction."""
    start = {
        "tilt": "25deg",
        "tilt_rate": 0.4,
        "precession_rate": 1.5,
        "roll_rate": -6.0,
        "duration": "3s",
        "mass": 2.0,
    }
    disk = sweep.simulate(**start)
    body = sweep.simulate(**start, body="torus", tube=0.0, axial_moment=0.5, transverse_moment=0.25)
    for name in disk.data_vars:
        if name not in ("ending", "fall_time", "energy_drift"):
            np.testing.assert_allclose(body[name], disk[name], rtol=1e-10, atol=1e-10, err_msg=name)


@pytest.mark.parametrize(
    ("words", "variable"),
    [
        ({"body": "torus", "tube": 0.2, "tilt": "40deg", "precession_rate": 1.5}, "fall time"),
        (
            {"body": "rounded", "thickness": 0.3, "tilt": "30deg", "roll_rate": 2.0, "precession_rate": 2.0},
            "tilt_max",
        ),
        ({"body": "rim", "thickness": 0.2, "fillet": 0.02, "tilt": "4deg"}, "edge change"),
        (
            {"body": "spheroid", "flattening": 0.4, "tilt": "20deg", "roll_rate": 2.0, "tilt_rate": 2.0},
            "tilt_max",
        ),
    ],
)
def test_a_motion_ends_as_the_cell_of_a_sweep(words, variable):
    """Ending, fall time and extremes match the cell, within its stated error."""
    atlas = sweep.run(sweep.SweepSpec(**words, duration="20s"))
    motion = sweep.simulate(**words, duration="20s", interval=0.001)
    assert ending_of(motion) == (
        "horizon" if variable == "tilt_max" else variable.replace("fall time", "fell")
    )
    ending = VARIABLES["ending"].flag(float(atlas["ending"]))
    if variable == "fall time":
        assert ending == "fell"
        assert float(motion["end_time"]) == pytest.approx(float(atlas["fall_time"]), rel=1e-8)
        assert float(motion["tilt"][-1]) == pytest.approx(math.radians(85.0), abs=1e-9)
    elif variable == "edge change":
        assert ending == "edge change"
        assert float(motion["tilt"][-1]) == pytest.approx(0.0, abs=1e-9)
    else:
        assert ending == "bounded"
        # The extreme lies at most half an interval from a sample.
        assert float(motion["tilt"].max()) == pytest.approx(float(atlas["tilt_max"]), abs=1e-5)


def test_a_motion_through_the_poles_is_sampled_for_a_film():
    """Where the heading jumps the body turns evenly: samples are 0.2 rad of its rotation apart."""
    motion = sweep.simulate(body="ball", tilt="20deg", tilt_rate=40.0, roll_rate=1e-3, duration="2s")
    times = motion["elapsed_time"].values
    assert np.abs(np.diff(motion["heading"])).max() > 1.0
    assert 2001 > times.size > 400
    assert float(motion["orientation_error"].max()) < 1e-9
    assert float(np.abs(motion["tilt"]).max()) < 0.5 * math.pi
    # Straight ahead at tilt_rate times the radius.
    assert float(motion["contact_x"][-1]) == pytest.approx(40.0 * 0.5 * 2.0, rel=1e-6)


def test_a_preset_and_a_cell_of_an_atlas():
    """A body preset, an atlas cell with other inputs, and a thin-disk cell as another body are followed."""
    wobble = sweep.simulate("true_edge", tilt="70deg", duration="1s")
    assert np.ptp(wobble["tilt"].values) < 1e-9
    assert (
        float(
            np.hypot(
                wobble["centre_x"] - wobble["centre_x"][0], wobble["centre_y"] - wobble["centre_y"][0]
            ).max()
        )
        < 1e-9
    )
    words = {"tube": "0.2,0.3", "roll_rate": "2,3", "tilt": "5deg", "tilt_rate": 0.3}
    atlas = sweep.run(sweep.SweepSpec(body="torus", **words))
    motion = atlas.eulerdisk.simulate(tube=0.3, roll_rate=3)
    cell = atlas.sel(tube=0.3, roll_rate=3)
    assert float(motion["tube"]) == 0.3
    assert float(motion["elapsed_time"][-1]) == pytest.approx(3.0 * float(cell["nutation_period"]), rel=1e-12)
    assert float(motion["tilt"][-1]) == pytest.approx(math.radians(5.0), abs=1e-8)
    larger = atlas.eulerdisk.simulate(tube=0.3, roll_rate=3, radius="10cm", duration="1s")
    assert (float(larger["radius"]), float(larger["elapsed_time"][-1])) == (0.1, 1.0)
    rolling = sweep.run(sweep.SweepSpec.preset("rolling", roll_rate="2,3", tilt="5deg", alpha=0.5))
    other = rolling.eulerdisk.simulate(roll_rate=3, body="rounded", thickness="5mm", duration="1s")
    assert float(other["thickness"]) == 0.005 / float(other["radius"])
    thin = atlas.eulerdisk.simulate(tube=0.3, roll_rate=3, body="disk", duration="1s")
    assert float(thin["alpha"]) == 0.5


@pytest.mark.parametrize(
    ("words", "facts"),
    [
        ({"body": "torus"}, ["tube", "body=torus"]),
        ({"body": "torus", "tube": 0.2, "alpha": 1}, ["alpha", "axial_moment"]),
        ({"body": "torus", "tube": 0.2, "tilt": "86deg"}, ["fallen"]),
        ({"body": "torus", "tube": 0.2, "path": "yes"}, ["path"]),
        ({"body": "rim", "thickness": 0.2}, ["rim", "tilt=0", "body=rounded"]),
        ({"body": "ball", "tilt": "90deg"}, ["tilt"]),
        (
            {"body": "torus", "tube": 0.2, "precession_rate": "steady-fast", "roll_rate": 2},
            ["precession_rate"],
        ),
    ],
)
def test_what_is_refused(words, facts):
    """A refusal is a sentence, as in a sweep."""
    with refused(*facts):
        sweep.simulate(**words)


@pytest.mark.slow_lane
def test_the_command(command, tmp_path):
    """`simulate`, `info` and `explain` name the body; `explain` follows its cell and its contact forces."""
    status, _, told = command("simulate body=rim thickness=0.2 tilt=4deg -o coin.nc --plot coin.png")
    assert (status, bool(re.search(r"edge .*\b0\.4747\d* s\b", told))) == (0, True)
    assert (tmp_path / "coin.png").stat().st_size > 10_000
    _, told, _ = command("info coin.nc")
    assert_facts(row(told, "start"), "tilt 4 deg", "tilt_rate 0 rad s-1")
    assert_facts(row(told, "body"), "rim", "thickness 0.2", "axial_moment 0.5")
    assert command("run torus tube=0.2,0.3 scaled_roll_rate=0.45,0.6 contact=yes -q -o a.nc")[0] == 0
    status, told, _ = command("explain a.nc tube=0.3 scaled_roll_rate=0.6 --plot cell.svg")
    assert status == 0
    assert_facts((tmp_path / "cell.svg").read_text(), "torus", "R = 0.5 m", "tube 0.15 m")
    assert_facts(row(told, "start"), "body torus", "tilt 0.1 deg")
    assert_facts(told, "no stored value contradicts")
    line = next(each for each in told.splitlines() if each.startswith("motion "))
    assert command(line.split("eulerdisk ")[1])[0] == 0
    status, _, told = command("simulate body=torus tube=0.2 tilt=86deg -o new.nc")
    assert (status, (tmp_path / "new.nc").exists()) == (2, False)
    assert_facts(told, "fallen")


def test_a_motion_goes_around_the_centre_of_its_ring():
    """Over many nutations the contact points keep the radii of path=yes, rising or falling at the start."""
    for rate in (0.4, -0.4):
        words = {
            "body": "torus",
            "tube": 0.2,
            "tilt": 0.3,
            "tilt_rate": rate,
            "roll_rate": 4.0,
            "precession_rate": 1.5,
        }
        ring = sweep.run("rolling", **words, path="yes", method="exact", progress=False)
        motion = sweep.simulate(**words, duration="60s")
        x, y = (motion[f"contact_{axis}"].values - float(ring[f"ring_{axis}"].item()) for axis in "xy")
        apart = np.hypot(x, y)
        assert apart.min() == pytest.approx(ring.ring_inner.item(), abs=1e-4), rate
        assert apart.max() == pytest.approx(ring.ring_outer.item(), abs=1e-4), rate


def test_a_body_that_turns_fast_has_close_samples():
    """A ring that turns ten times a second turns by at most 0.2 rad between samples."""
    motion = sweep.simulate(
        body="torus", tube=0.2, tilt=0.3, roll_rate=60.0, precession_rate=2.0, duration=30.0
    )
    assert float(motion.roll_angle[-1]) > 1700.0
    assert float(np.abs(np.diff(motion.roll_angle)).max()) <= 0.2


def test_what_has_been_apart_is_not_known_better_afterwards():
    """Two integrations may cross by chance, so stated errors never decrease."""
    motion = sweep.simulate(
        body="torus", tube=0.2, tilt="20deg", precession_rate=3.0, roll_rate=1.0, duration="3s"
    )
    names = [name for name in motion.data_vars if name.endswith("_error") and motion[name].ndim]
    assert len(names) >= 4
    for name in names:
        assert (np.diff(motion[name].values) >= 0.0).all(), name
        assert motion[name].values[-1] > 0.0


def test_a_small_body_has_the_errors_of_a_large_one_by_the_radius():
    """With radius and gravity 25 times as large, so are all lengths; angles and rates stay the same."""
    start = {"tilt": "20deg", "precession_rate": 2.0, "roll_rate": 1.0, "tube": 0.2, "duration": "3s"}
    large = sweep.simulate("torus", **start, radius=1.0, gravity=9.81)
    small = sweep.simulate("torus", **start, radius=0.04, gravity=0.04 * 9.81)
    for name in ("contact_x", "contact_y", "centre_z", "path_error"):
        assert float(large[name][-1] / small[name][-1]) == pytest.approx(25.0, rel=1e-3), name
    for name in ("tilt", "roll_rate", "rate_error", "orientation_error"):
        assert float(large[name][-1]) == pytest.approx(float(small[name][-1]), rel=1e-3), name


@pytest.mark.parametrize("body", ["body=ball offset=0.2", "body=spheroid flattening=0.3"])
def test_what_has_poles_may_start_beyond_any_tilt_of_a_fall(command, body):
    """A ball and a spheroid may turn near their pole, where a disk or ring would have fallen."""
    moments = "axial_moment=0.4 transverse_moment=0.4"
    start = "tilt=88deg precession_rate=20 roll_rate=-20 duration=0.1s -o a.nc"
    assert command(f"simulate {body} {moments} {start}")[0] == 0
    status, _, err = command(f"simulate body=torus tube=0.2 {start}")
    assert status == 2
    assert_facts(err, "tilt=88deg", "fall_tilt=85deg")
