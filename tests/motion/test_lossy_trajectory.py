"""Motions with losses in time: compared with the referee, and sampled ever closer toward the end."""

import math

import lossy_motion
import lossy_referee as referee
import numpy as np
import pytest
import xarray as xr
from messages import assert_facts, refused

import sweep
from kernels.lossy_disk.arrays import LOSSES
from kernels.lossy_disk.endings import FLAT, HORIZON, LIFT_OFF, REST, SLIP
from sweep.motion.sampling import closely_sampled, end_of

pytestmark = pytest.mark.compiled

TOY = {"radius": 0.03755, "gravity": 9.81, "mass": 0.4387}
AIR = {"air_viscosity": 1.8e-5, "air_density": 1.2}

#: The toy's wobble at a tilt of 80 deg, from the equation of steady motion (scaled rate sqrt(2 / (alpha C))).
TILT = math.radians(80.0)
RATE = math.sqrt(9.81 / 0.03755 * 4.0 / math.cos(TILT))
WOBBLE = {"tilt": TILT, "precession_rate": RATE, "roll_rate": -RATE * math.sin(TILT)}

#: Motions with every ending: their starts and their air laws.
MOTIONS = {
    "toy": (WOBBLE | TOY | AIR | {"contour_friction": 1.5e-5}, "bildsten"),
    "film": (WOBBLE | TOY | AIR | {"contour_damping": 2e-7, "alpha": 0.8}, "moffatt"),
    "dry": (
        {"tilt": 1.1, "precession_rate": 40.0, "roll_rate": -30.0, "rolling_friction": 2e-4, "contour_friction": 5e-5,
         "pivoting_friction": 1e-3} | TOY,
        "none",
    ),
    "rest": (
        {"tilt": 0.01, "precession_rate": 3.0, "rolling_friction": 1e-3, "pivoting_friction": 1e-4} | TOY, "none",
    ),
    "slip": ({"tilt": 0.4, "precession_rate": 30.0, "contour_friction": 1e-5, "friction": 0.3} | TOY, "none"),
    "lift off": ({"tilt": 0.3, "rolling_friction": 1e-5, "tilt_rate": 0.1} | TOY, "none"),
}  # fmt: skip
ENDINGS = {"toy": FLAT, "film": FLAT, "dry": FLAT, "rest": REST, "slip": SLIP, "lift off": LIFT_OFF}


def simulated(name, **words):
    """Return one of the motions, possibly with other inputs."""
    start, law = MOTIONS[name]
    return sweep.simulate(**start, air_law=law, **words)


def refereed(name, **words):
    """Return the referee's result for a motion."""
    start, law = MOTIONS[name]
    return referee.run(referee.starts(**start), air=law, **words)


def test_a_motion_ends_as_the_referee_says():
    """Ending, end time, losses, heading and final state match an integrator that shares no code with it."""
    for name in MOTIONS:
        motion, found = simulated(name), refereed(name, duration=300.0)
        assert int(motion["ending"]) == ENDINGS[name] == found.ending[0], name
        assert float(motion["end_time"]) == pytest.approx(found.end_time[0], rel=1e-6), name
        assert float(motion["elapsed_time"][-1]) == float(motion["end_time"]), name
        weight = 0.4387 * 9.81 * 0.03755
        for loss in LOSSES:
            assert float(motion[loss][-1]) == pytest.approx(
                weight * getattr(found, loss)[0], rel=1e-5, abs=1e-9 * weight
            ), name
        assert float(motion["heading"][-1]) == pytest.approx(found.heading_turned[0], rel=1e-6), name
        for row, quantity in enumerate(("tilt", "precession_rate", "roll_rate")):
            expected = found.state[[0, 2, 3][row], 0]
            assert float(motion[quantity][-1]) == pytest.approx(expected, rel=1e-4, abs=1e-4), name


def test_energy_and_losses_are_what_the_start_had():
    """At every sample, the referee's energy plus all losses is constant to 1e-9 m g R."""
    for name in MOTIONS:
        motion = simulated(name)
        weight, unit = 0.4387 * 9.81 * 0.03755, math.sqrt(0.03755 / 9.81)
        rates = [unit * motion[rate].values for rate in ("tilt_rate", "precession_rate", "roll_rate")]
        states = np.stack([motion["tilt"].values, *rates], axis=-1)
        energies = np.array([lossy_motion.energy(state, float(motion["alpha"])) for state in states])
        np.testing.assert_allclose(motion["energy"].values, weight * energies, rtol=1e-12)
        total = energies + sum(motion[loss].values for loss in LOSSES) / weight
        assert np.ptp(total) < 2e-9, name
        np.testing.assert_allclose(motion["energy_imbalance"].values, total - total[0], atol=1e-13)


def test_moffatts_example():
    """M = 0.4 kg, R = 3.75 cm, 1.8e-5 Pa s, 0.1 rad take "about 100 seconds", by his formula 94."""
    motion = sweep.simulate(
        inclination=0.1, precession_rate="wobble", roll_rate="wobble", radius=0.0375, mass=0.4, air_law="moffatt",
        air_viscosity=1.8e-5,
    )  # fmt: skip
    formula = 0.1**3 * 0.4 / (2.0 * math.pi * 1.8e-5 * 0.0375)
    assert formula == pytest.approx(94.3, abs=0.1)
    assert float(motion["end_time"]) == pytest.approx(formula, rel=0.01)


def test_samples_are_close_and_closer_towards_the_end():
    """There are over a thousand, at most 0.2 rad apart, with gaps that shrink with the remaining time."""
    for name in ("toy", "dry", "rest"):
        motion = simulated(name)
        times = motion["elapsed_time"].values
        assert times.size > 1000
        for angle in ("tilt", "heading", "roll_angle"):
            assert np.abs(np.diff(motion[angle].values)).max() < 0.2, (name, angle)
        left, gaps = times[-1] - times, np.diff(times)
        assert (gaps > 0.0).all()
        near = (left[:-1] < 0.1 * times[-1]) & (left[:-1] > 1e-4 * times[-1])
        assert near.sum() > 100
        assert (gaps[near] < 0.05 * left[:-1][near]).all()
        assert closely_sampled(motion) is motion


def test_an_interval_that_is_asked_for_is_kept():
    """Samples are even up to the end; a figure computes closer ones with the same first and last time."""
    motion = simulated("toy", interval=0.1)
    times = motion["elapsed_time"].values
    np.testing.assert_allclose(np.diff(times)[:-1], 0.1, rtol=1e-9)
    assert times[-1] == float(motion["end_time"])
    closer = closely_sampled(motion)
    assert closer.sizes["elapsed_time"] > 10 * times.size
    assert float(closer["end_time"]) == pytest.approx(times[-1], rel=1e-9)


def test_the_first_sample_is_the_start():
    """It equals the start bit for bit, even where friction must release an upright spinning disk."""
    for start in (WOBBLE, {"tilt": 0.02, "precession_rate": 60.0}):
        motion = sweep.simulate(**start, **TOY, rolling_friction=1e-5, duration=1.0)
        for name in ("tilt", "tilt_rate", "precession_rate", "roll_rate"):
            assert float(motion[name][0]) == start.get(name, 0.0)


def test_what_friction_holds_is_flagged():
    """A coin held by rolling friction pivots on the spot; pivoting friction holds the turn of a wobble."""
    names = dict(enumerate(["none", "roll", "turn", "roll_and_turn", "tilt_and_roll", "", "all"]))
    held = [names[code] for code in np.unique(simulated("rest")["held"])]
    assert held[0] == "tilt_and_roll"
    assert set(held) <= {"tilt_and_roll", "all"}
    wobble = simulated("dry")
    turn = wobble["precession_rate"] * np.cos(wobble["tilt"]) ** 2 + np.sin(wobble["tilt"]) * (
        wobble["roll_rate"] + wobble["precession_rate"] * np.sin(wobble["tilt"])
    )
    held_turn = wobble["held"].values & 2 > 0
    assert held_turn.any()
    assert np.abs(turn.values[held_turn]).max() < 1e-6 * np.abs(wobble["precession_rate"].values).max()


def test_a_coin_that_stands_is_seen_to_stand():
    """Friction holds it from the start: it is at rest at once, with samples over the whole duration."""
    motion = sweep.simulate(tilt="0.5deg", radius="12mm", rolling_friction="1mm", duration="3s")
    assert (int(motion["ending"]), float(motion["end_time"])) == (REST, 0.0)
    assert motion["elapsed_time"].values[[0, -1]].tolist() == [0.0, 3.0]
    assert np.ptp(motion["tilt"].values) == 0.0


def test_a_motion_that_ends_where_it_begins_is_refused():
    """It has fewer than two samples; the message says what the disk does."""
    for words, facts in [
        ({"tilt": 0.3, "friction": 0.01}, ["slips"]),
        (
            {"tilt": "80deg", "precession_rate": 200.0, "radius": 0.0375},
            ["lifts off"],
        ),
    ]:
        with refused(*facts):
            sweep.simulate(**words, contour_friction="10um")


def test_without_an_end_there_is_no_time_of_it():
    """A motion cut off by the duration, or a part of a longer one, has no end time."""
    motion = simulated("toy", duration=1.0)
    assert int(motion["ending"]) == HORIZON
    assert math.isnan(float(motion["end_time"]))
    assert end_of(motion) == end_of(simulated("toy").isel(elapsed_time=slice(0, 50))) == ""
    for name, word in (("toy", "flat"), ("rest", "rest")):
        ended = simulated(name)
        assert_facts(end_of(ended), word, f"{float(ended['end_time']):.6g} s")


def test_without_losses_it_is_the_motion_of_the_disk_without_losses():
    """With all coefficients zero, the lossy model's own kernels give the same motion."""
    start = {"tilt": "20deg", "precession_rate": 3.0, "roll_rate": 4.0, "duration": "2s", "interval": 0.01}
    lossy, plain = sweep.simulate(**start, contour_friction=0), sweep.simulate(**start)
    np.testing.assert_array_equal(lossy["elapsed_time"], plain["elapsed_time"])
    for name in ("tilt", "tilt_rate", "precession_rate", "roll_rate", "heading", "roll_angle", "contact_x", "contact_y",
                 "centre_x", "centre_z", "energy", "normal_force", "friction_across", "friction_along"):  # fmt: skip
        np.testing.assert_allclose(lossy[name], plain[name], rtol=1e-7, atol=1e-7, err_msg=name)


def test_a_file_says_which_model_it_is_of(tmp_path):
    """A saved and reopened motion is the same, and names its model."""
    motion = simulated("toy")
    sweep.save(motion, tmp_path / "stop.nc")
    with xr.open_dataset(tmp_path / "stop.nc") as read:
        assert read.attrs["model"] == "lossy_disk"
        for name in motion.variables:
            np.testing.assert_array_equal(read[name], motion[name])
    assert sweep.simulate(duration=0.1).attrs["model"] == "disk"


def test_a_cell_is_followed_to_its_end():
    """The motion of an atlas cell ends when the cell did, with the same losses."""
    atlas = sweep.run("toy", tilt="75deg,80deg", precession_rate="wobble")
    motion, cell = atlas.eulerdisk.simulate(tilt="80deg"), atlas.isel(tilt=1)
    assert int(cell["ending"]) == FLAT
    assert float(motion["end_time"]) == pytest.approx(float(cell["end_time"]), rel=1e-6)
    weight = 0.4387 * 9.81 * 0.03755
    for loss in LOSSES:
        assert float(motion[loss][-1]) == pytest.approx(weight * float(cell[loss]), rel=1e-5, abs=1e-9)


def test_a_cell_without_losses_is_followed_with_some():
    """Loss inputs change the motion of a lossless disk's cell, up to its end."""
    plain = sweep.run(sweep.SweepSpec(tilt="1deg", roll_rate=2.4))
    motion = plain.eulerdisk.simulate(rolling_friction="5mm")
    assert int(motion["ending"]) == FLAT
    assert float(motion["rolling_loss"][-1]) > 0.0
