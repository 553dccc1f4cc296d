"""The motion of an atlas cell: the one that the atlas measured, unless other inputs change it."""

import math

import numpy as np
import pytest
from messages import refused

import sweep
from sweep.atlas.parts import nearest_cell, other_values
from sweep.errors import RequestError
from sweep.motion.origin import cell_and_changes, request_of_cell
from sweep.motion.request import TrajectorySpec
from sweep.motion.sampling import ending_of

pytestmark = pytest.mark.compiled

#: A rolling coin: unstable cells, stable cells, and one that falls.
ROLLING = sweep.SweepSpec.preset(
    "rolling", radius="12mm", roll_rate="5,15,24", tilt="1deg,5deg", fall_tilt="60deg"
)
CIRCLING = sweep.SweepSpec.preset("circling", precession_rate="0.5,4", tilt="10deg,20deg", duration="20s")


@pytest.fixture(scope="module")
def rolling():
    """Return the atlas of a coin."""
    return sweep.run(ROLLING)


@pytest.fixture(scope="module")
def circling():
    """Return an atlas of disks with computed roll rates."""
    return sweep.run(CIRCLING)


def request(atlas, **words):
    """Return the motion request for a cell, and the text that names the cell."""
    spec = atlas.eulerdisk.spec
    cell, changes = cell_and_changes(spec, words)
    place = nearest_cell(spec, cell)
    return request_of_cell(atlas, place, changes), other_values(spec, place, cell)


def test_the_motion_has_the_extremes_and_the_period_of_the_cell(rolling):
    """In three nutation periods the tilt reaches the stored extremes and returns to its start."""
    for rate in [15.0, 24.0]:
        cell = rolling.sel(roll_rate=rate).isel(tilt=0)
        motion = rolling.eulerdisk.simulate(roll_rate=rate, tilt="1deg")
        # 1000 samples of three periods miss a turning point by at most 5e-5 of the swing.
        swing = float(cell.tilt_max - cell.tilt_min)
        assert float(motion.tilt.max()) == pytest.approx(float(cell.tilt_max), abs=1e-4 * swing), rate
        assert float(motion.tilt.min()) == pytest.approx(float(cell.tilt_min), abs=1e-4 * swing), rate
        assert float(motion.elapsed_time[-1]) == pytest.approx(
            3.0 * float(cell.nutation_period), rel=1e-12
        ), rate
        assert float(motion.tilt[-1]) == pytest.approx(math.radians(1.0), abs=1e-6), rate


def test_a_fall_ends_when_the_cell_fell(rolling):
    """The atlas has no period for a fall: the motion ends at the stored fall time."""
    assert float(rolling.fall_time[0, 1]) > 0.0
    motion = rolling.eulerdisk.simulate(roll_rate=5, tilt="5deg")
    assert float(motion.end_time) == pytest.approx(float(rolling.fall_time[0, 1]), rel=1e-6)
    assert motion.attrs["history"].endswith("dataset.eulerdisk.simulate")


def test_a_rate_that_the_cell_computed_is_that_of_its_motion(circling):
    """A circling cell starts with its own roll rate and kick; a shorter duration of the atlas is kept."""
    found, others = request(circling, precession_rate=0.5, tilt="10deg")
    assert found.roll_rate == float(circling.roll_rate.sel(precession_rate=0.5).isel(tilt=0))
    assert (found.tilt_rate, found.precession_rate, others) == (CIRCLING.tilt_rate, 0.5, "")
    assert found.duration == pytest.approx(3.0 * float(circling.nutation_period.sel(precession_rate=0.5)[0]))
    short = sweep.run(CIRCLING, duration="0.1s")
    assert request(short, precession_rate=0.5, tilt="10deg")[0].duration == 0.1


def test_words_that_name_no_axis_change_the_motion(rolling):
    """Disk, start and settings may change; then the cell's period does not apply, and 10 s are followed."""
    found, _ = request(rolling, roll_rate=15, tilt="1deg", alpha=1, mass="3g", friction=0.2, tilt_rate=0.5)
    expected = TrajectorySpec.read(
        roll_rate=15,
        tilt="1deg",
        alpha=1,
        mass="3g",
        friction=0.2,
        tilt_rate=0.5,
        radius="12mm",
        fall_tilt="60deg",
    )
    assert found == expected
    assert request(rolling, roll_rate=15, tilt="1deg", duration="2s", step="1ms")[0] == TrajectorySpec.read(
        roll_rate=15, tilt="1deg", radius="12mm", fall_tilt="60deg", duration="2s", step="1ms"
    )


def test_the_nearest_cell_is_taken_and_named(rolling):
    """Values between grid points select the nearest cell and name it; scaled rates and speeds work too."""
    found, others = request(rolling, roll_rate="15.2", tilt="1deg")
    assert (found.roll_rate, others) == (15.0, "roll_rate 15 rad s-1")
    found, others = request(rolling, speed="18cm/s", tilt="1.5deg")
    assert (found.roll_rate, others) == (15.0, "tilt 1 deg")
    assert found == request(rolling, scaled_roll_rate=15 / math.sqrt(9.81 / 0.012), tilt="1.5deg")[0]


def test_a_cell_that_the_atlas_does_not_have_is_refused_by_the_words_given(rolling):
    """The message quotes the given inputs, not the parameters in SI units."""
    for words, said in [
        (
            {"roll_rate": 15, "inclination": "60deg"},
            "inclination=60deg: 30 deg is outside the atlas, whose tilt is 1 deg to 5 deg. Give a value inside",
        ),
        ({"speed": "9m/s", "tilt": "1deg"}, "speed=9m/s: 750 rad s-1 is outside the atlas"),
    ]:
        with pytest.raises(RequestError) as refusal:
            request(rolling, **words)
        assert said in str(refusal.value), (words, said)


def test_a_scaled_rate_names_a_cell_of_the_disk_of_the_atlas(rolling):
    """Gravity and radius change the motion, not the cell; rates that are no axis scale with the new disk."""
    scaled = 15 / math.sqrt(9.81 / 0.012)
    found, others = request(rolling, scaled_roll_rate=scaled, tilt="1deg", gravity=1.62)
    assert (found.roll_rate, found.gravity, others) == (15.0, 1.62, "")
    found, _ = request(rolling, speed="18cm/s", tilt="1deg", radius="24mm", scaled_tilt_rate=0.1)
    assert (found.roll_rate, found.radius) == (15.0, 0.024)
    assert found.tilt_rate == pytest.approx(0.1 * math.sqrt(9.81 / 0.024), rel=1e-12)


def test_an_atlas_without_periods_is_followed_for_ten_seconds(rolling):
    """The variable may have been dropped; a single cell needs no inputs."""
    part = rolling.drop_vars("nutation_period")
    assert request(part, roll_rate=15, tilt="1deg")[0].duration == 10.0
    one = sweep.run("rolling", roll_rate=2, tilt="1deg")
    assert request(one)[0].roll_rate == 2.0


def test_what_names_no_motion_is_refused(rolling):
    """Cells outside the atlas, unknown inputs and impossible values are refused."""
    for words, facts in [
        ({"roll_rate": 15}, ["roll_rate, tilt", "Add tilt="]),
        ({"roll_rate": 55, "tilt": "1deg"}, ["outside the atlas", "5 rad s-1 to 24 rad s-1"]),
        ({"speed": "1m/s", "tilt": "1deg"}, ["outside the atlas", "roll_rate"]),
        ({"speed": "18cm/s", "roll_rate": 15, "tilt": "1deg"}, ["roll_rate is given twice"]),
        ({"roll_rate": "15,24", "tilt": "1deg"}, ["one number"]),
        ({"rol_rate": 15, "tilt": "1deg"}, ["Did you mean roll_rate?"]),
        ({"roll_rate": 15, "tilt": "1deg", "criterion": "departure:2deg"}, ["word of eulerdisk run"]),
        ({"roll_rate": 15, "tilt": "5deg", "fall_tilt": "4deg"}, ["fallen", "tilt=5deg fall_tilt=4deg"]),
        ({"roll_rate": 15, "tilt": "5deg", "mass": 0}, ["mass > 0"]),
    ]:
        with pytest.raises(RequestError) as caught:
            rolling.eulerdisk.simulate(**words)
        assert all(fact in str(caught.value) for fact in facts), str(caught.value)
        assert caught.value.hint, (words, facts)


def test_a_cell_without_a_start_has_no_motion():
    """If no rate keeps the tilt there is nothing to follow, unless a rate is given."""
    atlas = sweep.run("rolling", tilt="0,10deg", roll_rate=0.1, precession_rate="steady-fast")
    assert np.isnan(atlas.precession_rate).all()
    with refused("precession_rate", "precession_rate=2"):
        request(atlas, tilt="10deg")
    assert request(atlas, tilt="10deg", precession_rate=1.0)[0].precession_rate == 1.0


@pytest.mark.parametrize(
    ("words", "ending"),
    [
        ({"radius": 10.0, "roll_rate": "0.0001,0.0002", "tilt": 1e-10}, "fell"),
        (
            {"body": "rim", "thickness": 0.2, "radius": 2000.0, "roll_rate": "0.0001,0.0002", "tilt": 0.09},
            "edge change",
        ),
    ],
)
def test_a_motion_reaches_the_ending_of_its_cell(words, ending):
    """A cell slower than the default duration is followed to its end, unless a duration is given."""
    atlas = sweep.run("rolling", **words)
    motion = atlas.eulerdisk.simulate(roll_rate=0.0001)
    assert ending_of(motion) == ending
    assert float(motion.elapsed_time[-1]) > 10.0
    if ending == "fell":
        assert float(motion.end_time) == pytest.approx(float(atlas.fall_time[0]), rel=1e-6)
    assert float(atlas.eulerdisk.simulate(roll_rate=0.0001, duration=1).elapsed_time[-1]) == 1.0
