"""The warning that a range misses the predicted boundary, and the range it suggests."""

import re

import numpy as np
from messages import assert_facts

import sweep
from sweep.atlas.boundary import theory_lines
from sweep.atlas.outlook import one_sided

#: Critical rate of a uniform disk: the square root of g / 3R.
COIN = float(np.sqrt(9.81 / (3 * 0.012)))


def request(text):
    """Return the spec of these words."""
    name, *words = text.split()
    return sweep.SweepSpec.from_words(name, words)


def test_the_range_to_paste_holds_the_prediction_of_every_row():
    """The warning names the side; the suggested range has the user's count and contains all predicted edges."""
    for words, side in [
        ("rolling radius=12mm roll_rate=2:4:801", "unstable"),
        ("rolling roll_rate=20:30:9", "stable"),
        ("rolling roll_rate=-1:-0.5:9", "unstable"),
        ("rolling roll_rate=-30:-20:9", "stable"),
        ("rolling roll_rate=-1:1:9", "unstable"),
        ("rolling roll_rate=0.5:1:9:log tilt=1deg", "unstable"),
        ("rolling roll_rate=0.5,1,1.5 alpha=0.3:1:3", "unstable"),
        ("circling precession_rate=1:2:9 tilt=3deg,5deg", "unstable"),
        ("circling precession_rate=5:6:9", "stable"),
        ("circling precession_rate=-2:-1:9 tilt=3deg,5deg", "unstable"),
        ("spinning precession_rate=60rpm:80rpm:5 tilt=0.1deg", "stable"),
    ]:
        spec = request(words)
        (warning,) = one_sided(spec)
        assert_facts(warning, side)
        axis, pasted = re.search(r": (\w+)=(\S+)$", warning).groups()
        wider = request(f"{words.split()[0]} {' '.join(words.split()[1:])}").replace(**{axis: pasted})
        assert one_sided(wider) == []
        assert len(getattr(wider, axis)) == len(getattr(spec, axis))
        assert pasted.endswith(":log") == words.endswith("log tilt=1deg")
        low, high = getattr(wider, axis).ends()
        for _, predicted in theory_lines(spec, axis).values():
            # with cells on both sides of it
            assert np.nanmin(predicted) > low + 0.1 * abs(low)
            assert np.nanmax(predicted) < high - 0.1 * abs(high)


def test_the_coin():
    """A classic mistake: a large disk's range for a coin, whose critical rate is sqrt(g/3R)."""
    (warning,) = one_sided(request("rolling radius=12mm roll_rate=2:4:801"))
    start, stop, count = re.search(r"roll_rate=([\d.]+):([\d.]+):(\d+)$", warning).groups()
    assert float(start) < COIN < float(stop)
    assert count == "801"
    assert_facts(warning, "16.46 to 112.8 rad s-1")


def test_no_warning_where_nothing_is_missed():
    """There is no warning if one row crosses the boundary or if theory has no prediction."""
    for words in [
        "rolling",
        "spinning",
        "circling",
        # some of the rows cross the boundary
        "rolling roll_rate=2.6:2.7:9",
        "rolling roll_rate=-3:3:9",
        # no prediction: a tilt beyond the limit, a rolling and spinning disk, two controls, one value
        "rolling roll_rate=2:4:9 tilt=10deg,20deg",
        "rolling roll_rate=0.1:0.2:9 precession_rate=1",
        "rolling roll_rate=0.1:0.2:9 precession_rate=0:1:3",
        # at 10 deg slow circling is stable too: with rates of both signs, theory gives only the outer edges
        "circling tilt=10deg,20deg precession_rate=-1:1:5",
        "rolling roll_rate=0.1,",
        "rolling roll_rate=3",
    ]:
        assert one_sided(request(words)) == []


def test_an_atlas_holds_its_prediction():
    """The prediction stored in a finished atlas gives the same warning for any number of rows."""
    spec = request("rolling radius=12mm roll_rate=2:4:5 tilt=0.1deg,1deg")
    atlas = sweep.run(spec)
    assert one_sided(spec, atlas) == one_sided(spec)
    assert one_sided(spec, atlas.drop_vars("predicted_roll_rate")) == []


def test_rows_are_spread_over_a_large_grid(monkeypatch):
    """In a large grid, only some rows are checked, including the first and the last."""
    monkeypatch.setattr("sweep.atlas.outlook._MOST_ROWS", 9)
    spec = request("rolling radius=12mm roll_rate=2:4:9 tilt=0.01deg:1deg:50:log alpha=0.3:1:40")
    (warning,) = one_sided(spec)
    predicted = theory_lines(spec, "roll_rate")["upper"][1]
    assert f"{predicted.min():.4g} to {predicted.max():.4g} rad s-1" in warning
