"""The speed of films: a motion lasts some seconds, but the disk never seems to turn the wrong way."""

import math

import numpy as np
import pytest
from messages import assert_facts

import sweep
from sweep.figures.disk.film_options import MOST_FRAMES, FilmOptions, timing

pytestmark = pytest.mark.compiled

COIN = {"radius": "12mm", "tilt": "5deg", "precession_rate": 60.0}


def timed(motion, **given):
    """Return the timing of a gif of a motion."""
    return timing(motion, FilmOptions.read("a.gif", **given))


def test_a_motion_is_a_film_of_some_seconds():
    """A short motion is slowed down, a long one sped up, and one of some seconds is shown in real time."""
    for words, speed, seconds in (
        ({"radius": "12mm", "tilt": "1deg", "duration": 2.0}, 0.05, 4.1),  # falls in 0.2 s
        ({"tilt_rate": 0.01, "roll_rate": 2.0}, 1.0, 10.0),
        ({"tilt_rate": 0.01, "roll_rate": 3.0, "duration": 80.0}, 4.0, 20.0),
        ({"radius": 50.0, "roll_rate": 0.3, "tilt_rate": 0.001, "duration": 60.0}, 3.0, 20.0),
        ({"tilt_rate": 0.0, "duration": 1.0}, 0.25, 4.0),  # at rest
    ):
        found = timed(sweep.simulate(**words))
        assert found.speed == speed
        assert found.moments.size / found.fps == pytest.approx(seconds, abs=0.1)
        assert found.whole
        assert not found.aliased


def test_the_disk_is_never_seen_to_turn_backwards():
    """At the chosen speed, heading and painted radius turn by less than half a turn per frame."""
    for words in (
        COIN | {"duration": 2.0},
        {"radius": "1mm", "roll_rate": 500.0, "tilt_rate": 1.0, "duration": 1.0},
        {"radius": "40mm", "tilt": "80deg", "precession_rate": 30.0, "roll_rate": "steady", "duration": 5.0},
        {"tilt": "1deg", "precession_rate": 300.0, "radius": "1cm", "duration": 3.0},
    ):
        motion = sweep.simulate(**words)
        found = timed(motion)
        times = motion["elapsed_time"].values
        # the spin about the disk's axis: roll rate plus the axial part of the precession
        rate = motion["roll_rate"] + motion["precession_rate"] * np.sin(motion["tilt"])
        steps = np.diff(times)
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (rate.values[1:] + rate.values[:-1]) * steps)])
        for angle in (turned, motion["heading"].values):
            assert np.abs(np.diff(np.interp(found.moments, times, angle))).max() < 0.7 * math.pi
        assert not found.aliased


def test_short_sweeps_do_not_slow_a_film_down():
    """In a motion with short sweeps, 90 % of the samples turn at most 1/8 turn per frame and 98 % at most 1/3.

    A disk that almost falls swings its lean around within a millisecond, at thousands of radians a second. A
    film slow
    enough for that would show nothing else.
    """
    for fps in (4, 25):
        sweeps = sweep.simulate(tilt="60deg", precession_rate=1.0, fall_tilt="89.9deg", duration=8.0)
        assert float(np.abs(sweeps["precession_rate"]).max()) > 1000.0
        for motion in (sweeps, sweep.simulate(tilt_rate=0.01, roll_rate=1.0)):
            found = timed(motion, fps=fps)
            names = ("tilt", "precession_rate", "roll_rate")
            tilt, precession, roll = (motion[name].values for name in names)
            rates = np.sort(np.maximum(np.abs(precession), np.abs(roll + precession * np.sin(tilt))))
            for share, turn in ((0.9, math.pi / 4.0), (0.98, 2.0 * math.pi / 3.0)):
                assert rates[int(share * rates.size)] * found.speed / fps <= 1.03 * turn
        assert timed(sweeps).speed >= 0.5
        assert timed(sweeps).whole


def test_a_fast_motion_that_lasts_is_cut_and_says_so():
    """A film lasts at most a minute: of a coin that turns 60 times a second, it shows the beginning."""
    motion = sweep.simulate(**COIN | {"precession_rate": 380.0, "duration": 10.0})
    found = timed(motion)
    assert found.moments.size == 60 * 25
    assert not found.whole
    assert_facts(found.words(), f"{found.shown:.4g} s", "10 s")


def test_a_speed_that_is_asked_for_is_kept_and_its_faults_are_told():
    """A requested speed is kept: if too fast, the text gives the angle per frame; if too slow, the film is cut."""
    motion = sweep.simulate(**COIN | {"duration": 2.0})
    fast = timed(motion, speed=1.0)
    assert (fast.speed, fast.aliased) == (1.0, True)
    # at 25 frames a second; the precession is the fastest of its turns
    fastest = float(np.abs(motion["precession_rate"]).max())
    assert fast.turn == pytest.approx(fastest / 25.0, rel=0.02)
    assert_facts(fast.words(), f"{math.degrees(fast.turn):.0f} deg", "real time")
    slow = timed(motion, speed=1e-4)
    assert slow.moments.size == MOST_FRAMES
    assert_facts(slow.words(), "0.024 s", "2 s")


def test_frames_are_even_and_the_last_one_is_the_end():
    """Frames are speed / fps apart, from the first to the last sample; a part of a motion has its own range."""
    motion = sweep.simulate(tilt_rate=0.01, roll_rate=2.0).isel(elapsed_time=slice(200, 501))
    found = timed(motion, speed=0.7, fps=30)
    assert found.moments[[0, -1]].tolist() == [2.0, 5.0]
    assert np.diff(found.moments)[:-1] == pytest.approx(0.7 / 30)
    assert 0.0 < np.diff(found.moments)[-1] <= 0.7 / 30 * (1.0 + 1e-9)


def test_a_film_of_a_motion_that_stops_shows_its_end():
    """If a stopping motion does not fit, the film shows its last part; the end is held for a second."""
    motion = sweep.simulate("toy", tilt="50deg")
    end = float(motion["end_time"])
    found = timed(motion)
    assert not found.whole
    assert_facts(found.words(), "last")
    held = found.fps
    np.testing.assert_array_equal(found.moments[-held:], end)
    np.testing.assert_allclose(np.diff(found.moments[: -held or None]), found.speed / found.fps, rtol=1e-9)
    assert found.shown == pytest.approx(end - found.moments[0])
    whole = timed(motion, speed=5.0)
    assert whole.whole
    assert whole.moments[0] == 0.0
    cut = timed(sweep.simulate("toy", tilt="50deg", duration="3s"), speed=5.0)
    assert np.diff(cut.moments).min() > 0.0


def test_the_speed_of_a_motion_that_stops_does_not_depend_on_its_samples():
    """The speed depends on shares of time, not of samples, which are much denser near the end."""
    ring = {
        "body": "torus", "tube": 0.3, "radius": "20mm", "tilt": "10deg", "roll_rate": 20,
        "rolling_friction": "0.4mm", "pivoting_friction": "0.1mm",
    }  # fmt: skip
    for words, evenly in (({"spec": "toy", "tilt": "80deg"}, "0.2ms"), (ring, "2ms")):
        close, coarse = (sweep.simulate(**words, interval=interval) for interval in ("auto", evenly))
        assert timed(close).speed == timed(coarse).speed, words
        assert timed(close).turn == pytest.approx(timed(coarse).turn, rel=0.005), words
