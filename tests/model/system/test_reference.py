"""What `verify` finds in an atlas of a system that was changed, also where its code is another one's."""

import hashlib

import numpy as np
import pytest

import sweep
from sweep.checks.verify import findings
from sweep.model.system.model import model_of
from sweep.model.system.sample import followed
from sweep.request.system_file import read_system

TEXT = """
@system(duration="10 s", ends={"out": "x > 1.2 m"}, label={"right": "x > 0 m", "left": "x < 0 m"},
        measures={"top": "max abs(x)"}, conserved="v**2 + rate**2*x**2")
def oscillator(x: "m" = 1.0, v: "m/s" = 0.0, *, rate: "1/s" = 1.0):
    return v, -x*rate**2
"""


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas of an oscillator, most of whose cells run on."""
    spec = sweep.SweepSpec(model=model_of(read_system(TEXT)), x="0.1 m:1 m:8", rate="0.5:3:9", v=0.3)
    return sweep.run(spec)


def test_an_atlas_is_verified(atlas):
    """Nothing is wrong in what was just computed; all of its cells were followed by DOP853."""
    found = findings(sweep.verify(atlas, seed=1))
    assert found.passed
    assert found.counts["agrees"] == 72
    assert found.extremes[2] <= 1e-8


def test_a_refined_boundary_is_verified():
    """A system has no exact reduction to hold the ends of its brackets against: they follow from the verdicts."""
    spec = sweep.SweepSpec(
        model=model_of(read_system(TEXT)), x="0.5 m:1.1 m:3", rate="0.5:3:5", v=0.3, boundary="refined"
    )
    atlas = sweep.run(spec)
    assert np.isfinite(atlas["boundary_rate"].values).any()
    assert findings(sweep.verify(atlas, seed=1)).passed


def changed(name, change):
    """Return how an atlas is changed in one cell of a variable."""

    def edit(atlas):
        atlas[name].values[3, 4] = change(atlas[name].values[3, 4])

    return edit


CHANGES = {
    "a state, by a part in a million": changed("x_end", lambda value: value * (1.0 + 1e-6)),
    "a state that is missing": changed("v_end", lambda value: np.nan),
    "a measure": changed("top", lambda value: value + 1e-6),
    "an error below zero": changed("x_end_error", lambda value: -value),
    "an error that is none": changed("top_error", lambda value: np.inf),
    "another label": changed("label", lambda value: 3 - value),
    "no label": changed("label", lambda value: 0),
    "another ending": changed("ending", lambda value: 4),
    "a code that there is not": changed("ending", lambda value: 9),
    "another verdict": changed("stability", lambda value: 2),
    "another time": changed("end_time", lambda value: 9.0),
    "what is conserved": changed("conserved_change", lambda value: value + 1e-3),
}


@pytest.mark.slow_lane
@pytest.mark.parametrize("change", CHANGES)
def test_changes_are_found(atlas, change):
    """Each change of one cell is found, and the cell is named."""
    damaged = atlas.copy(deep=True)
    CHANGES[change](damaged)
    found = findings(sweep.verify(damaged, seed=1))
    assert not found.passed
    assert found.disagreeing == 1


#: What follows from no other variable, and is known only to who computes the cells again.
COMPUTED_ALONE = ("no label",)


@pytest.mark.slow_lane
@pytest.mark.parametrize("change", [each for each in CHANGES if each not in COMPUTED_ALONE])
def test_changes_of_other_code_are_found(atlas, change):
    """So is it in an atlas of other code, whose cells are not computed again: by the rules, or by DOP853."""
    damaged = atlas.copy(deep=True)
    damaged.attrs["kernel_hash"] = "0" * 64
    CHANGES[change](damaged)
    found = findings(sweep.verify(damaged, seed=1))
    assert not found.passed
    assert found.disagreeing == 1


@pytest.mark.slow_lane
def test_an_event_that_was_missed(atlas):
    """Motions that end at 1.1 by their system, but run on in the atlas: those that get there are wrong."""
    damaged = atlas.copy(deep=True)
    text = damaged.attrs["sweep_spec"].replace("x - 1.2 >", "x - 1.1 >")
    damaged.attrs |= {
        "sweep_spec": text,
        "sweep_fingerprint": hashlib.sha256(text.encode()).hexdigest(),
        "kernel_hash": "0" * 64,
    }
    audited = sweep.verify(damaged, seed=1)
    x, rate = np.meshgrid(atlas.x, atlas.rate, indexing="ij")
    # all of them turn within 10 s at their greatest distance
    np.testing.assert_array_equal(
        audited.audit == 6, (np.hypot(x, 0.3 / rate) > 1.1) & (rate * 10.0 > np.arctan(2.0))
    )
    assert not findings(audited).passed


def test_lanes_follow_an_oscillator():
    """Places and greatest values on the way are those of the closed form; of 1e7 swings nothing is said."""
    model = model_of(read_system(TEXT))
    second = model.reference(1)._sample
    starts = {
        "x": np.array([1.0, 0.5, 1.0]),
        "v": np.array([0.0, 1.0, 0.0]),
        "rate": np.array([2.0, 3.0, 1e6]),
    }
    found = second._on_lanes(starts, np.array([4.0, 0.7, 10.0]), 1e-13)
    size = np.hypot(starts["x"], starts["v"] / starts["rate"])
    phase = np.arctan2(starts["v"] / starts["rate"], starts["x"])
    np.testing.assert_allclose(
        found[0, :2], (size * np.cos(starts["rate"] * [4.0, 0.7, 10.0] - phase))[:2], atol=1e-11
    )
    np.testing.assert_allclose(found[2, :2], size[:2], rtol=1e-12)
    # the second cell has not turned at the other side: its least x is that at its end
    np.testing.assert_allclose(found[3, :2], [1.0, -found[0, 1]], rtol=1e-11)
    assert np.isnan(found[:, 2]).all()


def test_scipy_is_another_method():
    """The second method shares nothing with the kernels but the right-hand side: a closed form."""
    definition = read_system(TEXT)
    starts = {"x": np.array([1.0, 0.5]), "v": np.array([0.0, 1.0]), "rate": np.array([2.0, 3.0])}
    times = np.array([1.0, 4.0])
    x, v = followed(definition, starts, times, 1e-12)
    truth = starts["x"] * np.cos(starts["rate"] * times) + starts["v"] / starts["rate"] * np.sin(
        starts["rate"] * times
    )
    np.testing.assert_allclose(x, truth, rtol=0, atol=1e-9)
    assert v.shape == (2,)


LEVEL = """
@system(duration="10", ends={"up": "x > level"})
def rising(x=-1.0, v=0.0, *, w=1.0, level=0.0):
    return v, -w*w*x
"""
UNCONSERVED = """
@system(duration="10", conserved="v**2/2 + x**2/2")
def spring(x=1.0, v=0.0, *, k=2.0):
    return v, -k*x
"""
LABELLED = """
@system(duration="10", label={"right": "x > 0", "left": "x < 0", "middle": True})
def turning(x=0.0, v=1.0, *, w=0.3141592653589793):
    return w*v, -w*x
"""
BLOW_UP = """
@system(duration="10")
def blow_up(y=0.5):
    return y**2
"""
PUSHED = """
@system(duration="100", measures={"peak": "max abs(x)"})
def pushed(x=0.0, v=0.0, *, width=0.5, t):
    return v, -sin(x) - 0.05*v + exp(-((t - 50)/width)**2)
"""


def atlas_of(text, **words):
    """Return the atlas of a system."""
    return sweep.run(sweep.SweepSpec(model=model_of(read_system(text)), **words))


def test_events_at_a_level_of_zero():
    """Where an event happens its terms are nothing; the errors of the states say how near it has to be."""
    found = findings(sweep.verify(atlas_of(LEVEL, x="-2:-0.5:12"), seed=1))
    assert (found.passed, found.compared, found.counts["agrees"]) == (True, 12, 12)


def test_a_place_beside_an_event_is_wrong():
    """A motion that did not end where its event happens contradicts itself."""
    atlas = atlas_of(LEVEL, x="-2:-0.5:4")
    atlas["x_end"].values[2] -= 1e-6
    assert findings(sweep.verify(atlas, seed=1)).disagreeing == 1


def test_what_is_not_conserved_is_found():
    """An energy that the right-hand side changes is wrong, one that it keeps is not."""
    found = findings(sweep.verify(atlas_of(UNCONSERVED, k="0.5,1,2"), seed=1))
    assert [each.name for each in found.wrong] == ["conserved_change"]
    assert (found.passed, found.disagreeing) == (False, 2)


def test_labels_within_the_error_of_a_state_are_not_said():
    """After a quarter of a turn x is 0 to rounding: neither label fits in any case, nor is it surely in the middle."""
    atlas = atlas_of(LABELLED, duration=10.0, x="0,0.5", w="0.3141592653589793")
    names = atlas.label.attrs["flag_meanings"].split()
    values = list(np.atleast_1d(atlas.label.attrs["flag_values"]))
    assert [names[values.index(value)] for value in atlas.label.values.reshape(-1)] == ["undecided", "left"]
    assert findings(sweep.verify(atlas, seed=1)).passed


def test_nothing_that_could_be_compared_is_no_pass():
    """An atlas of unresolved cells is not verified."""
    found = findings(sweep.verify(atlas_of(BLOW_UP, y="0.5,1"), seed=1))
    assert (found.passed, found.compared, found.wrong) == (False, 0, [])


def test_both_methods_see_a_push():
    """DOP853 on lanes and SciPy's pass over no short push either."""
    found = findings(sweep.verify(atlas_of(PUSHED, width="0.02,0.1,0.5"), seed=1))
    assert (found.passed, found.compared) == (True, 3)
