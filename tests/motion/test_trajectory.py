import math

import numpy as np
import pytest
import referee
from messages import assert_facts, missing, refused
from thin_disk import ROWS, path_by_scipy

import sweep
from kernels.disk.steady import steady_roll_rate
from sweep.model.disk.tables import PARAMETERS
from sweep.motion.request import TrajectorySpec
from sweep.motion.stated_errors import unresolved

pytestmark = pytest.mark.compiled

#: The report's runs: tilt, tilt rate, precession rate, roll rate of a uniform disk of 0.5 m radius.
CIRCLING = float(steady_roll_rate(math.radians(10.0), 0.5, 0.5, 0.5, 9.81))
RUNS = {
    "rolling, stable": (0.0, 0.01, 0.0, 3.0),
    "rolling, unstable": (0.0, 0.01, 0.0, 2.0),
    "spinning, stable": (0.0, 0.1, 4.5, 0.0),
    "spinning, unstable": (0.0, 0.1, 3.5, 0.0),
    "circling": (math.radians(10.0), 0.0, 0.5, CIRCLING),
}


def simulate(start, **words):
    """Simulate a start given by its first four numbers."""
    return sweep.simulate(**dict(zip(list(PARAMETERS)[:4], start, strict=True)), **words)


def test_a_steady_precession_keeps_the_tilt():
    """The two roots of the equation of steady motion both keep the tilt; the fast one is faster."""
    for word in ["steady-slow", "steady-fast"]:
        motion = sweep.simulate(tilt="20deg", roll_rate=5, precession_rate=word, duration="1s")
        assert float(np.abs(motion["tilt"] - math.radians(20.0)).max()) < 1e-9, word
        rate = float(motion["precession_rate"][0])
        assert steady_roll_rate(math.radians(20.0), rate, 0.5, 0.5, 9.81) == pytest.approx(5.0, rel=1e-12), (
            word
        )
        assert (abs(rate) > math.sqrt(2 * 9.81 / (2.5 * 0.5))) == (word == "steady-fast"), word


def test_a_steady_rate_that_does_not_exist_is_refused():
    """Too slow a roll supports no tilt, and upright there is no fast precession."""
    for words in ({"tilt": "20deg", "roll_rate": 0.1}, {"tilt": 0, "roll_rate": 3}):
        with refused("precession_rate", "steady-fast"):
            sweep.simulate(**words, precession_rate="steady-fast")


def test_the_reports_runs():
    """Energy and the balance of H.e3 hold to 1e-10; state and path match DOP853 at 1e-12 to 1e-8."""
    for start in RUNS.values():
        motion = simulate(start, duration="10s")
        assert motion["elapsed_time"].values.tolist() == np.linspace(0.0, 10.0, 1001).tolist(), start
        expected = path_by_scipy(start, motion["elapsed_time"].values)
        for name, row in zip(ROWS, expected, strict=True):
            assert np.abs(motion[name].values - row).max() <= 1e-8, name
        states = np.stack([motion[name].values for name in ROWS[:4]], axis=-1)
        energies = [referee.energy(state, 0.5, 0.5, 9.81) for state in states]
        assert motion["energy"].values == pytest.approx(energies, rel=1e-13), start
        assert np.ptp(energies) <= 1e-10 * energies[0], start
        assert np.abs(motion["energy_drift"]).max() <= 1e-10, start
        assert np.abs(motion["vertical_momentum_residual"]).max() <= 1e-10, start


def test_the_vertical_momentum_is_not_conserved():
    """H.e3 of the unstable rolling disk varies by more than its initial spin; the balance law explains it."""
    motion = simulate(RUNS["rolling, unstable"])
    assert np.ptp(motion["vertical_momentum"].values) > 1.0  # kg m2/s, where m R^2 phi' is 0.5
    times, rate = motion["elapsed_time"].values, motion["vertical_momentum_rate"].values
    # Simpson's rule over the samples, independent of the integral that the motion carries along.
    simpson = (rate[:-2:2] + 4.0 * rate[1::2] + rate[2::2]).sum() * (times[1] - times[0]) / 3.0
    gained = float(motion["vertical_momentum"][-1] - motion["vertical_momentum"][0])
    assert gained == pytest.approx(simpson, abs=1e-7)


def test_a_circle_of_ten_turns():
    """Ten turns on the circle of radius R|phi'/psi'| stay within 1e-6 of it and return to the start."""
    motion = sweep.simulate(
        tilt="10deg", precession_rate=0.5, roll_rate="steady", duration=10.0 * 2.0 * math.pi / 0.5
    )
    radius = 0.5 * abs(CIRCLING / 0.5)
    # The disk starts at the origin toward -y (its roll rate is negative); psi' > 0 turns it left, toward +x.
    distance = np.hypot(motion["contact_x"] - radius, motion["contact_y"])
    assert np.abs(distance / radius - 1.0).max() <= 1e-6
    assert float(np.hypot(motion["contact_x"][-1], motion["contact_y"][-1])) <= 1e-6 * radius
    assert float(motion["heading"][-1]) == pytest.approx(20.0 * math.pi, rel=1e-9)


def test_the_largest_tilt_is_the_exact_one():
    """After a kick of 0.01 rad/s at roll rate 2, the tilt swings to the exact 41.6082 deg on both sides."""
    tilt = np.degrees(simulate(RUNS["rolling, unstable"], interval=0.001)["tilt"].values)
    assert tilt.max() == pytest.approx(41.6082, abs=1e-4)
    assert tilt.min() == pytest.approx(-41.6082, abs=1e-4)
    assert max(tilt.max(), -tilt.min()) <= 41.60825


def test_centre_of_mass_stands_over_the_contact_point():
    """It is one radius from the contact point, R cos(tilt) high, and leans toward (cos heading, sin heading)."""
    motion = simulate((0.3, 0.2, 1.0, -2.0), alpha=1.0, radius=0.2)
    offset = np.stack([motion["centre_x"] - motion["contact_x"], motion["centre_y"] - motion["contact_y"]])
    assert np.hypot(np.hypot(*offset), motion["centre_z"]).values == pytest.approx(0.2, rel=1e-14)
    lean = 0.2 * np.sin(motion["tilt"].values)
    heading = motion["heading"].values
    assert offset == pytest.approx(np.stack([lean * np.cos(heading), lean * np.sin(heading)]), abs=1e-14)


def test_a_fall_ends_the_motion():
    """A disk without spin falls to either side: the last sample is at fall_tilt, at the expected time."""
    expected = referee.motion([0.1, 0.1, 0.0, 0.0, 0.5, 0.5, 9.81], 5.0)
    for side in [1.0, -1.0]:
        motion = sweep.simulate(tilt=0.1 * side, tilt_rate=0.1 * side, duration=5.0)
        assert float(motion["end_time"]) == pytest.approx(expected.fall_time, rel=1e-10)
        assert float(motion["elapsed_time"][-1]) == float(motion["end_time"])
        assert float(motion["tilt"][-1]) == pytest.approx(side * math.radians(85.0), rel=1e-11)
        assert (np.diff(motion["elapsed_time"]) > 0.0).all()
        flags = dict(
            zip(
                motion["ending"].attrs["flag_values"],
                motion["ending"].attrs["flag_meanings"].split(),
                strict=True,
            )
        )
        assert flags[int(motion["ending"])] == "fell"


def test_a_fall_between_two_steps_is_seen():
    """The disk turns back 1e-4 rad beyond fall_tilt, between two steps: it still fell on the way up."""
    start = (0.0, 0.01, 0.0, 2.0)
    peak = float(referee.extremes(referee.starts(tilt_rate=0.01, roll_rate=2.0)).peak[0])
    motion = simulate(start, fall_tilt=peak - 1e-4, step=0.05, interval=1.0)
    assert float(motion["tilt"][-1]) == pytest.approx(peak - 1e-4, abs=1e-6)
    assert float(motion["tilt_rate"][-1]) > 0.0


def test_the_contact_is_judged_by_the_friction_coefficient():
    """Flags say slips if more friction is needed than available, lifts_off if the plane had to pull."""
    motion = sweep.simulate(tilt=0.1, tilt_rate=0.1, friction=0.4)
    names = motion["contact"].attrs["flag_meanings"].split()
    found = np.array(names)[motion["contact"].values]
    lifted = motion["normal_force"].values <= 0.0
    assert lifted.any()
    assert ((found == "lifts_off") == lifted).all()
    assert np.isnan(motion["friction_needed"].values[lifted]).all()
    needed = motion["friction_needed"].values[~lifted]
    assert ((found[~lifted] == "slips") == (needed > 0.4)).all()
    assert {"rolls", "slips", "lifts_off"} == set(found)


def test_mass_scales_energy_and_forces_only():
    """With twice the mass the motion is bit-identical; energy, momentum and forces double."""
    light, heavy = (simulate((0.2, 0.1, 1.0, 2.0), mass=mass) for mass in (1.0, 2.0))
    for name in ROWS:
        assert (light[name] == heavy[name]).all()
    for name in ("energy", "vertical_momentum", "normal_force", "friction_across", "friction_along"):
        assert (2.0 * light[name] == heavy[name]).all()


def test_samples_fit_the_duration():
    """An interval that does not divide the duration becomes the next smaller one; both ends are exact."""
    times = simulate((0.1, 0.0, 0.0, 3.0), duration=1.0, interval=0.3)["elapsed_time"].values
    assert times.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert simulate((0.1, 0.0, 0.0, 3.0), duration=10.0, interval=0.01)["elapsed_time"].size == 1001


def test_a_motion_beyond_all_bounds_is_refused():
    """Overflowing rates give an error with advice, not a file of NaN."""
    for start in [
        (0.1, 1e200, 1.0, 1e200),
        (0.0, 1e100, 1e100, 0.0),
        (0.0, 0.0, 1e200, 1.0),
        (0.1, 0.0, 1e155, -1e155),
    ]:
        with pytest.raises(sweep.RequestError) as caught:
            simulate(start)
        assert_facts(caught.value.hint, "rates", "duration", "fall_tilt")


def test_a_fast_motion_has_more_samples():
    """Heading and roll angle change by at most 0.2 rad per sample, unless an interval is given."""
    words = {"tilt": "20deg", "precession_rate": 300.0, "radius": "1cm", "duration": "0.5s"}
    motion = sweep.simulate(**words, interval="auto")
    assert motion["elapsed_time"].size > 1001
    for name in ("heading", "roll_angle"):
        assert np.abs(np.diff(motion[name].values)).max() < 0.21
    assert np.ptp(np.diff(motion["elapsed_time"].values)) < 1e-12
    assert sweep.simulate(**words, interval=5e-3)["elapsed_time"].size == 101


def test_a_short_fall_has_as_many_samples_as_any_motion():
    """A coin that falls early in a long duration is sampled until its fall, at an unchanged time."""
    words = {"tilt": "1deg", "radius": "12mm"}
    long, short = (sweep.simulate(**words, duration=duration) for duration in ("1000s", "0.25s"))
    for motion in (long, short):
        assert motion["elapsed_time"].size == 1001
        assert np.abs(np.diff(motion["tilt"].values)).max() < 0.01
        assert (np.diff(motion["elapsed_time"].values) > 0.0).all()
    expected = referee.motion([math.radians(1.0), 0.0, 0.0, 0.0, 0.5, 0.012, 9.81], 1.0).fall_time
    assert float(long["end_time"]) == pytest.approx(expected, rel=1e-10)
    assert float(long["elapsed_time"][-1]) == float(long["end_time"])


def test_a_step_that_is_too_long_does_not_lose_the_fall():
    """A fall that a coarse step finds too early is still found when closer samples shorten the step."""
    motion = sweep.simulate(tilt=0.1, tilt_rate=0.1, duration=3000.0, step=0.4)
    assert float(motion["end_time"]) == float(motion["elapsed_time"][-1])


@pytest.mark.parametrize(("until", "fact"), [(1.5, "1.5 s"), (1e-9, "1e-09 s")])
def test_until_when_a_motion_was_followed(until, fact):
    """A time after the start is reported."""
    assert_facts(str(unresolved(TrajectorySpec.read(roll_rate=3), until)), "until", fact, "fall_tilt")


@pytest.mark.parametrize("until", [0.0, -0.07, math.nan])
def test_a_motion_that_fails_from_its_start_on(until):
    """The message reports no time at or before the start."""
    told = str(unresolved(TrajectorySpec.read(roll_rate=3), until))
    assert_facts(told, "100000000 steps", "start", "fall_tilt")
    assert "until" not in told
    assert missing(told, ["0 s", "-0.07"]) == ["0 s", "-0.07"]


def test_too_many_steps_are_taken_once():
    """A motion with too many steps is refused at once if it reaches none of its samples."""
    with refused("100000000", "from its start on"):
        sweep.simulate(roll_rate=1e9, tilt=0.1, duration=100)
