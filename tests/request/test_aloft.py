"""The criterion of a motion that has to last: how it is written, its verdicts, and what it says of a cell."""

import math
import pickle

import numpy as np
import pytest

import sweep
from sweep.checks.verify import findings, verify
from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE
from sweep.request.criterion import Criterion
from sweep.request.spec import SweepSpec

NONE = np.array([np.nan])
LOSSY = {"contour_friction": "1um", "criterion": "aloft:10s"}


def test_it_is_read_and_written():
    """Text, kind and number make the same criterion, and so do its text, its plain types and its pickle."""
    for text, limit in [("aloft:10s", 10.0), (" aloft : 2min", 120.0), ("aloft:0.5", 0.5)]:
        found = Criterion.parse(text)
        assert found == Criterion("aloft", limit)
        assert Criterion.parse(str(found)) == found == pickle.loads(pickle.dumps(found))
        assert Criterion(**found.kept()) == found
        spec = SweepSpec(**LOSSY | {"criterion": text})
        assert SweepSpec.from_canonical(spec.canonical()) == spec
        assert spec.criterion == found


def test_what_is_no_time_is_refused():
    """Zero, negative, another unit, a list: refused by the word."""
    for text in ["aloft:0s", "aloft:-1", "aloft:nan", "aloft:5deg", "aloft:", "aloft:1,2"]:
        with pytest.raises(RequestError) as caught:
            Criterion.parse(text)
        assert "criterion" in str(caught.value.where)


def test_motions_have_to_be_followed_as_long():
    """A criterion that asks for more than the duration is refused; so is one of a method without time."""
    with pytest.raises(RequestError, match=r"asks for more time .* duration=5s") as caught:
        SweepSpec(**LOSSY, duration="5s")
    assert caught.value.where == "criterion"
    assert SweepSpec(**LOSSY, duration="10s").duration == 10.0
    with pytest.raises(RequestError, match="fall_time, of which method=exact knows no value"):
        SweepSpec(criterion="aloft:10s", method="exact")


def verdict(model, ending, time):
    """Return the verdict of aloft:10s on one cell."""
    measured = {"ending": np.array([model.endings.code(ending)]), model.endings.lost_time: np.array([time])}
    return int(Criterion("aloft", 10.0).verdict(model.endings, measured, NONE, NONE)[0])


def test_the_verdict():
    """Unstable is what is lost before the time alone; what nobody followed as long is undecided."""
    for model, ending, time, expected in [
        (LOSSY_DISK, "flat", 9.999, UNSTABLE),
        (LOSSY_DISK, "flat", 10.0, STABLE),
        (LOSSY_DISK, "rest", 3.0, STABLE),
        (LOSSY_DISK, "horizon", 10.0, STABLE),
        (LOSSY_DISK, "lift_off", 9.0, UNDECIDED),
        (LOSSY_DISK, "slip", 11.0, STABLE),
        (LOSSY_DISK, "undisturbed", np.nan, UNDECIDED),
        (LOSSY_DISK, "unresolved", np.nan, UNDECIDED),
        (LOSSY_DISK, "not_computed", np.nan, UNDECIDED),
        (DISK, "fell", 9.0, UNSTABLE),
        (DISK, "fell", 11.0, STABLE),
        (DISK, "bounded", np.nan, STABLE),
        (DISK, "horizon", np.nan, STABLE),
        (DISK, "steady", np.nan, UNDECIDED),
        (DISK, "invalid", np.nan, UNDECIDED),
    ]:
        assert verdict(model, ending, time) == expected


@pytest.mark.compiled
def test_a_map_of_the_disk_without_losses():
    """The verdict is that of an expression over the fall time; reasons name both times; the file is verified."""
    words = {"tilt": "10deg:80deg:8", "roll_rate": "0:3:7", "duration": "20s"}
    atlas = sweep.run(SweepSpec(**words, criterion="aloft:0.7s"))
    fell = atlas.ending == DISK.endings.code("fell")
    expected = verdicts_where(fell & (atlas.fall_time < 0.7))
    np.testing.assert_array_equal(atlas.stability, expected)
    assert {UNSTABLE, STABLE} == set(np.unique(atlas.stability).tolist())
    assert findings(verify(atlas)).passed
    spec = atlas.eulerdisk.spec
    cell = {"ending": DISK.endings.code("fell"), "fall_time": 0.5, "stability": UNSTABLE}
    assert spec.criterion.reason(spec, cell, math.nan, math.nan) == (
        "the disk falls after 0.5 s, less than the 0.7 s of the criterion"
    )
    open_ = {"ending": DISK.endings.code("horizon"), "fall_time": math.nan, "stability": STABLE}
    assert "the duration of 20 s was over before" in spec.criterion.reason(spec, open_, math.nan, math.nan)


def verdicts_where(unstable):
    """Return verdicts where something is unstable and all else is stable."""
    return np.where(unstable, UNSTABLE, STABLE)


def test_a_time_within_its_error_leaves_the_verdict_open():
    """A motion that is lost within the stated error of the time is on the edge, others are not."""
    spec = SweepSpec(**LOSSY, tilt="1deg,2deg,3deg")
    flat, horizon = (LOSSY_DISK.endings.code(name) for name in ("flat", "horizon"))
    measured = {
        "ending": np.array([flat, flat, horizon]),
        "end_time": np.array([9.999, 9.9, 10.0]),
        "time_error": np.array([1e-3, 1e-3, 1e-3], np.float32),
        "tilt_min": np.zeros(3),
        "tilt_max": np.array([1.57, 1.57, 0.5]),
        "stability": np.array([UNSTABLE, UNSTABLE, STABLE]),
    }
    found = spec.criterion.is_open(spec, {}, measured, np.zeros(3))
    assert found.tolist() == [True, False, False]


def test_its_words():
    """What is unstable, as messages, figures and the file say it."""
    found = Criterion("aloft", 10.0)
    assert found.unstable_if(LOSSY_DISK) == "the disk falls flat in less than 10 s"
    assert (found.label(DISK), found.caption(DISK)) == ("aloft 10 s", "aloft for less than 10 s")
    assert "end_time" in found.comment(LOSSY_DISK)
    assert "fall_time" in found.comment(DISK)
