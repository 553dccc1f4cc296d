"""The warning that a range misses the predicted boundary, and the range that it gives to paste."""

import re

import numpy as np
from messages import assert_facts

import sweep
from sweep.atlas.boundary import theory_lines
from sweep.atlas.outlook import one_sided

#: physics: g / 3R of a uniform disk.
COIN = float(np.sqrt(9.81 / (3 * 0.012)))


def request(text):
    """Return the spec that words ask for."""
    name, *words = text.split()
    return sweep.SweepSpec.from_words(name, words)


def test_the_range_to_paste_holds_the_prediction_of_every_row():
    """The side is told, and the range that is given has the count of the user and holds every edge of theory."""
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
    """The classic mistake: the range of a large disk for a coin, whose critical rate is sqrt(g/3R)."""
    (warning,) = one_sided(request("rolling radius=12mm roll_rate=2:4:801"))
    start, stop, count = re.search(r"roll_rate=([\d.]+):([\d.]+):(\d+)$", warning).groups()
    assert float(start) < COIN < float(stop)
    assert count == "801"
    assert_facts(warning, "16.46 to 112.8 rad s-1")


def test_no_warning_where_nothing_is_missed():
    """A range that meets the boundary in a row, and what theory does not know, give no warning."""
    for words in [
        "rolling",
        "spinning",
        "circling",
        # a part of the rows crosses the boundary
        "rolling roll_rate=2.6:2.7:9",
        "rolling roll_rate=-3:3:9",
        # theory has no prediction: a tilt beyond the limit, a disk that rolls and spins, two controls, one value
        "rolling roll_rate=2:4:9 tilt=10deg,20deg",
        "rolling roll_rate=0.1:0.2:9 precession_rate=1",
        "rolling roll_rate=0.1:0.2:9 precession_rate=0:1:3",
        # at 10 deg slow circling is stable too: of rates of both signs theory gives the outer edges alone
        "circling tilt=10deg,20deg precession_rate=-1:1:5",
        "rolling roll_rate=0.1,",
        "rolling roll_rate=3",
    ]:
        assert one_sided(request(words)) == []


def test_an_atlas_holds_its_prediction():
    """Of a finished atlas the stored prediction says the same, whatever the number of rows."""
    spec = request("rolling radius=12mm roll_rate=2:4:5 tilt=0.1deg,1deg")
    atlas = sweep.run(spec)
    assert one_sided(spec, atlas) == one_sided(spec)
    assert one_sided(spec, atlas.drop_vars("predicted_roll_rate")) == []


def test_rows_are_spread_over_a_large_grid(monkeypatch):
    """Of many rows some are looked at, the first and the last among them."""
    monkeypatch.setattr("sweep.atlas.outlook._MOST_ROWS", 9)
    spec = request("rolling radius=12mm roll_rate=2:4:9 tilt=0.01deg:1deg:50:log alpha=0.3:1:40")
    (warning,) = one_sided(spec)
    predicted = theory_lines(spec, "roll_rate")["upper"][1]
    assert f"{predicted.min():.4g} to {predicted.max():.4g} rad s-1" in warning
