"""Words that select a part of an atlas."""

import numpy as np
import pytest
from messages import refused

import sweep
from sweep.atlas.parts import is_inside, is_other, nearest_cell, part_of
from sweep.request.sources import Range
from sweep.request.spec import SweepSpec


@pytest.fixture(scope="module")
def atlas():
    """Return a small atlas with three axes, one of them logarithmic."""
    return sweep.run(SweepSpec(alpha="0.5,0.7,1", roll_rate="1:4:16", tilt="0.1deg:10deg:5:log"))


def test_words_pick_values(atlas):
    """A number drops the axis, a list or a range keeps it; a note states a value that differs from the request."""
    for words, places, noted in [
        ({"alpha": "0.5"}, {"alpha": 0}, []),
        ({"alpha": "0.7,1"}, {"alpha": [1, 2]}, []),
        ({"alpha": "0.5:0.8"}, {"alpha": [0, 1]}, []),
        ({"roll_rate": "2.2"}, {"roll_rate": 6}, []),
        (
            {"roll_rate": "2.25rad/s"},
            {"roll_rate": 6},
            ["roll_rate 2.2 rad/s", "nearest to 2.25 rad/s"],
        ),
        ({"roll_rate": "0.91"}, {"roll_rate": 0}, ["roll_rate 1 rad s-1"]),
        ({"tilt": "1deg:4deg", "alpha": "1"}, {"tilt": [2, 3], "alpha": 2}, []),
        # nearer to 1 deg in the logarithm, although 3.16 deg is nearer in the value
        ({"tilt": "1.7deg"}, {"tilt": 2}, ["tilt 1 deg"]),
        ({"tilt": "0.1deg,0.11deg"}, {"tilt": [0]}, ["0.11"]),
        # tilts of 1 to 5 deg
        ({"inclination": "85deg:89deg", "alpha": "1"}, {"tilt": [2, 3], "alpha": 2}, []),
        # for the default disk: R = 0.5 m, sqrt(g/R) = 4.43 rad/s
        ({"speed": "1.1m/s"}, {"roll_rate": 6}, []),
        ({"speed": "0.99:1.51"}, {"roll_rate": [5, 6, 7, 8, 9, 10]}, []),
        ({"speed": "50cm/s,1m/s"}, {"roll_rate": [0, 5]}, []),
        ({"scaled_roll_rate": "0.5", "alpha": "1"}, {"roll_rate": 6, "alpha": 2}, ["roll_rate 2.2 rad s-1"]),
    ]:
        part, notes = part_of(atlas, words)
        expected = atlas.isel(places)
        np.testing.assert_array_equal(part["peak_tilt"], expected["peak_tilt"])
        assert part["ending"].dims == expected["ending"].dims
        assert part.eulerdisk.spec.shape == expected["ending"].shape
        assert len(notes) == bool(noted)
        assert all(words in "".join(notes) for words in noted)


def test_bad_words_are_refused(atlas):
    """Bad words are refused with a message that names the axis."""
    for words, facts in [
        ({"alpha": "2"}, ["alpha=2", "0.5", "1"]),
        ({"tilt": "0.5"}, ["tilt=0.5", "radians", "tilt=0.5deg"]),
        ({"tilt": "1,1.5"}, ["tilt=1deg,1.5deg"]),
        ({"tilt": "0.5:1"}, ["tilt=0.5deg:1deg"]),
        ({"alpha": "0.71:0.9"}, ["alpha", "0.71", "0.9"]),
        ({"alpha": "0.8:0.6"}, ["alpha", "smaller"]),
        ({"roll_rate": "1:2:3"}, ["roll_rate", "START:STOP"]),
        ({"radius": "0.5"}, ["radius", "alpha, roll_rate, tilt"]),
        ({"aplha": "1"}, ["aplha", "alpha?"]),
        ({"speed": "9m/s"}, ["speed=9m/s", "18 rad s-1", "roll_rate", "1 rad s-1", "4 rad s-1"]),
        (
            {"sped": "9m/s"},
            ["sped", "alpha, roll_rate, tilt, scaled_roll_rate, speed, inclination", "speed?"],
        ),
        ({"speed": "1:2:3"}, ["START:STOP"]),
        ({"speed": "1:2:3"}, ["1:2:3", "speed=1:2"]),
        ({"inclination": "1"}, ["inclination=1", "tilt"]),
        ({"inclination": "0.5:1"}, ["inclination", "two values"]),
        ({"speed": "1kg"}, ["speed=1kg", "m/s"]),
        ({"speed": "1", "roll_rate": "2"}, ["speed", "roll_rate"]),
        ({"scaled_tilt_rate": "1"}, ["tilt_rate", "alpha, roll_rate, tilt"]),
        ({"alpha": "1deg"}, ["alpha=1deg", "deg"]),
        ({"alpha": "nan"}, ["alpha=nan", "finite"]),
        ({"alpha": ""}, ["alpha=", "start:stop:count[:log]"]),
        ({"alpha": ":"}, ["alpha=:", "start:stop:count[:log]"]),
    ]:
        with refused(*facts):
            part_of(atlas, words)


def test_a_start_has_no_nearest_one():
    """A start is selected by its exact number; a range selects all numbers in between."""
    whole = sweep.run(SweepSpec(tilt="uniform:1deg:2deg", roll_rate=3, samples=12))
    part = whole.isel(start=[2, 5, 7]).eulerdisk.atlas
    for atlas, words, facts in (
        (whole, "0.5", ["12", "from 0 to 11"]),
        (whole, "11.3", ["12", "from 0 to 11"]),
        (whole, "3,7.5", ["12", "from 0 to 11"]),
        (part, "6", ["3", "from 2 to 7"]),
    ):
        with refused(f"start={words.rpartition(',')[2]}", *facts):
            part_of(atlas, {"start": words})
    with refused("start 6", "start=6", "3", "from 2 to 7"):
        nearest_cell(part.eulerdisk.spec, {"start": "6"})
    assert nearest_cell(part.eulerdisk.spec, {"start": "5"}) == {"start": 1}
    assert part_of(part, {"start": "3:7"})[0].start.values.tolist() == [5, 7]


def test_an_axis_reaches_half_a_step_beyond_its_ends():
    """An axis extends half a step beyond its ends, in the logarithm if it is logarithmic."""
    even, log = Range(1.0, 4.0, 4), Range(1.0, 100.0, 3, "log")
    for axis, inside, outside in ((even, (0.51, 4.49), (0.49, 4.51)), (log, (0.32, 316.0), (0.31, 317.0))):
        assert all(is_inside(axis, value) for value in inside)
        assert not any(is_inside(axis, value) for value in outside)


def test_a_value_that_rounding_changed_is_no_other_one():
    """Values that differ by rounding are equal; the rounding is relative to the larger end, as one end may be 0."""
    axis = Range(0.0, 0.3, 4)
    assert not is_other(axis, 3, 0.1 + 0.2)
    assert not is_other(axis, 0, 1e-17)
    assert is_other(axis, 3, 0.3001)
    assert is_other(axis, 0, 1e-6)
