"""`verify` finds changes in an atlas of a system, also if other code computed the atlas."""

import hashlib

import numpy as np
import pytest
from messages import assert_facts

import sweep
from sweep.checks.verify import findings
from sweep.model.system import sample, second_method
from sweep.model.system.model import model_of
from sweep.model.system.sample import tops_of
from sweep.model.system.second_method import follow
from sweep.request.system_file import read_system

TEXT = """
@system(duration="10 s", ends={"out": "x > 1.2 m"}, label={"right": "x > 0 m", "left": "x < 0 m"},
        measures={"top": "max abs(x)"}, conserved="v**2 + rate**2*x**2")
def oscillator(x: "m" = 1.0, v: "m/s" = 0.0, *, rate: "1/s" = 1.0):
    return v, -x*rate**2
"""


@pytest.fixture(autouse=True)
def _follows_all_cells(monkeypatch):
    monkeypatch.setattr(sample, "SECONDS", np.inf)


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas of an oscillator; most of its cells reach the duration."""
    spec = sweep.SweepSpec(model=model_of(read_system(TEXT)), x="0.1 m:1 m:8", rate="0.5:3:9", v=0.3)
    return sweep.run(spec)


def test_an_atlas_is_verified(atlas):
    """A freshly computed atlas has no errors; DOP853 followed all its cells."""
    found = findings(sweep.verify(atlas, seed=1))
    assert found.passed
    assert found.counts["agrees"] == 72
    assert found.extremes[2] <= 1e-8


def test_a_refined_boundary_is_verified():
    """A system has no exact reduction to check the brackets against; their ends follow from the verdicts."""
    spec = sweep.SweepSpec(
        model=model_of(read_system(TEXT)), x="0.5 m:1.1 m:3", rate="0.5:3:5", v=0.3, boundary="refined"
    )
    atlas = sweep.run(spec)
    assert np.isfinite(atlas["boundary_rate"].values).any()
    assert findings(sweep.verify(atlas, seed=1)).passed


def changed(name, change):
    """Return a function that changes one cell of a variable."""

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


#: Changes that no other variable contradicts: only recomputing the cells reveals them.
COMPUTED_ALONE = ("no label",)


@pytest.mark.slow_lane
@pytest.mark.parametrize("change", [each for each in CHANGES if each not in COMPUTED_ALONE])
def test_changes_of_other_code_are_found(atlas, change):
    """In an atlas of other code, whose cells are not recomputed, the rules or DOP853 find the change."""
    damaged = atlas.copy(deep=True)
    damaged.attrs["kernel_hash"] = "0" * 64
    CHANGES[change](damaged)
    found = findings(sweep.verify(damaged, seed=1))
    assert not found.passed
    assert found.disagreeing == 1


@pytest.mark.slow_lane
def test_an_event_that_was_missed(atlas):
    """Motions that continue past an event at 1.1 are wrong, and only those."""
    damaged = atlas.copy(deep=True)
    text = damaged.attrs["sweep_spec"].replace("x - 1.2 >", "x - 1.1 >")
    damaged.attrs |= {
        "sweep_spec": text,
        "sweep_fingerprint": hashlib.sha256(text.encode()).hexdigest(),
        "kernel_hash": "0" * 64,
    }
    audited = sweep.verify(damaged, seed=1)
    x, rate = np.meshgrid(atlas.x, atlas.rate, indexing="ij")
    # All of them reach their greatest distance within 10 s.
    np.testing.assert_array_equal(
        audited.audit == 6, (np.hypot(x, 0.3 / rate) > 1.1) & (rate * 10.0 > np.arctan(2.0))
    )
    assert not findings(audited).passed


def oscillator(times, **starts):
    """Follow oscillator cells: return position, rate, and the maxima of x, -x and x - 1.2."""
    definition, starts = read_system(TEXT), {name: np.array(each) for name, each in starts.items()}
    return follow(definition, tops_of(definition), starts, np.array(times), 1e-12)


def test_the_second_method_is_a_closed_form():
    """Positions and maxima match the closed form, at a different time in each cell."""
    x, v, rate, times = np.array([[1.0, 0.5, 0.5], [0.0, 1.0, 1.0], [2.0, 3.0, 0.01], [4.0, 0.7, 1.0]])
    found = oscillator(times, x=x, v=v, rate=rate)
    size, phase = np.hypot(x, v / rate), np.arctan2(v / rate, x)
    np.testing.assert_allclose(found[0], size * np.cos(rate * times - phase), rtol=0, atol=1e-10)
    # The second cell has not turned on the other side, and the third nowhere.
    np.testing.assert_allclose(found[2], [size[0], size[1], found[0, 2]], rtol=1e-10)
    np.testing.assert_allclose(found[3], [1.0, -found[0, 1], -0.5], rtol=1e-10)
    np.testing.assert_allclose(found[4], found[2] - 1.2, rtol=0, atol=1e-10)


def test_the_second_method_gives_up():
    """It does not follow 1e7 oscillations."""
    assert np.isnan(oscillator([10.0], x=[1.0], v=[0.0], rate=[1e6])).all()


SWITCHES = """
@system(duration="100")
def switches(a=0.0, b=0.0, c=0.0, *, width=0.01, t):
    u = (t - 50)/width
    return exp(-u**2), 1/(1 + u**2)**2, (tanh(u) + 1)/2
"""
PASSER = """
@system(duration="200", measures={"fastest": "max v"})
def passer(x=-100.0, v=1.0, *, width=0.01, depth=0.2):
    return v, -2*depth*x/width**2*exp(-(x/width)**2)
"""


def test_the_second_method_does_not_pass_over_what_hides():
    """It resolves a Gaussian, a squared Lorentzian and a step of 1e-4 of the duration, and a narrow well."""
    width = np.array([0.02, 0.5])
    starts = {name: np.zeros(2) for name in "abc"} | {"width": width}
    found = follow(read_system(SWITCHES), [], starts, np.full(2, 100.0), 1e-11, sizes=np.ones((3, 2)))
    expected = [np.sqrt(np.pi) * width, 0.5 * np.pi * width - 2.0 * width**4 / 3.0 / 50.0**3, [50.0, 50.0]]
    np.testing.assert_allclose(found, expected, rtol=1e-8)
    definition = read_system(PASSER)
    starts = {
        "x": np.full(2, -100.0),
        "v": np.ones(2),
        "width": np.full(2, 0.01),
        "depth": np.array([0.2, -0.2]),
    }
    found = follow(definition, tops_of(definition), starts, np.full(2, 200.0), 1e-12)
    # Energy conservation gives the speed in the middle.
    np.testing.assert_allclose(found[2], [np.sqrt(1.4), 1.0], rtol=1e-9)


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
    """At an event the terms of its condition cancel; the errors of the states set the tolerance."""
    found = findings(sweep.verify(atlas_of(LEVEL, x="-2:-0.5:12"), seed=1))
    assert (found.passed, found.compared, found.counts["agrees"]) == (True, 12, 12)


def test_a_place_beside_an_event_is_wrong():
    """A motion that did not end where its event happens contradicts itself."""
    atlas = atlas_of(LEVEL, x="-2:-0.5:4")
    atlas["x_end"].values[2] -= 1e-6
    assert findings(sweep.verify(atlas, seed=1)).disagreeing == 1


def test_what_is_not_conserved_is_found():
    """An energy that the right-hand side changes is reported; a conserved one is not."""
    found = findings(sweep.verify(atlas_of(UNCONSERVED, k="0.5,1,2"), seed=1))
    assert [each.name for each in found.wrong] == ["conserved_change"]
    assert (found.passed, found.disagreeing) == (False, 2)


def test_labels_within_the_error_of_a_state_are_not_said():
    """After a quarter of a turn x is 0 up to rounding, so no label is certain and the cell is undecided."""
    atlas = atlas_of(LABELLED, duration=10.0, x="0,0.5", w="0.3141592653589793")
    names = atlas.label.attrs["flag_meanings"].split()
    values = list(np.atleast_1d(atlas.label.attrs["flag_values"]))
    assert [names[values.index(value)] for value in atlas.label.values.reshape(-1)] == ["undecided", "left"]
    assert findings(sweep.verify(atlas, seed=1)).passed


def test_nothing_that_could_be_compared_is_no_pass():
    """An atlas of unresolved cells is not verified."""
    found = findings(sweep.verify(atlas_of(BLOW_UP, y="0.5,1"), seed=1))
    assert (found.passed, found.compared, found.wrong) == (False, 0, [])


def test_the_second_method_sees_a_push():
    """It does not step over a short push."""
    found = findings(sweep.verify(atlas_of(PUSHED, width="0.02,0.1,0.5"), seed=1))
    assert (found.passed, found.compared) == (True, 3)


def many():
    """Return an atlas of 7,200 cells."""
    return atlas_of(TEXT, x="0.1 m:1 m:80", rate="0.5:3:90", v=0.3)


def test_the_sample_is_what_time_allows(monkeypatch):
    """A minimum is always followed, and more of the same draw with more time; the report counts the cells."""
    cells = many()
    monkeypatch.setattr(sample, "SECONDS", 0.0)
    few = sweep.verify(cells, seed=1)
    assert findings(few).passed
    assert findings(few).compared == sample.LEAST_CELLS
    assert_facts(few.attrs["audit_sample"], f"{sample.LEAST_CELLS} of 2000 cells", "seed 1", "DOP853")
    monkeypatch.setattr(sample, "SECONDS", np.inf)
    all_of_them = sweep.verify(cells, seed=1)
    assert findings(all_of_them).passed
    assert findings(all_of_them).compared == 2000
    sampled = [np.isfinite(each.place_difference.values) for each in (few, all_of_them)]
    assert (sampled[0] <= sampled[1]).all()


def test_the_sample_is_drawn_from_all_blocks(monkeypatch):
    """Blocks share the time, so the first ones cannot use all of it."""
    times = iter(np.arange(0.0, 1e6, 0.5))
    monkeypatch.setattr(sample.time, "monotonic", lambda: next(times))
    drawn = sample.Sample(read_system(TEXT), 8000, seed=1)
    followed = []
    for first in range(0, 8000, 1000):
        starts = {"x": np.full(1000, 0.5), "v": np.zeros(1000), "rate": np.ones(1000)}
        stored = {
            "steps": np.ones(1000),
            "end_time": np.ones(1000),
            "x_end": np.ones(1000),
            "v_end": np.ones(1000),
        }
        found = drawn.of(starts, first, stored, np.ones(1000, bool))
        followed.append(np.count_nonzero(np.isfinite(found["found: x"])))
    assert min(followed) > 0
    assert drawn.followed == sum(followed)


def test_a_sample_of_which_nothing_is_known_is_no_pass(monkeypatch):
    """If the second method gives up in every cell, the atlas is not verified, even without any error."""
    monkeypatch.setattr(second_method, "MOST_EVALUATIONS", 5)
    found = findings(sweep.verify(atlas_of(LEVEL, x="-2:-0.5:12"), seed=1))
    assert (found.passed, found.compared, found.wrong) == (False, 0, [])


UNRULED = """
@system(duration="10")
def swinging(x=0.5, v=0.0, *, rate=1.0):
    return v, -0.5*sin(x)*rate**2
"""


def of_other_code(atlas):
    """Return a copy of an atlas marked as computed by other code, so its cells are not recomputed."""
    copied = atlas.copy(deep=True)
    copied.attrs["kernel_hash"] = "0" * 64
    return copied


@pytest.mark.parametrize("seconds", [0.0, np.inf])
def test_a_state_that_is_off_in_all_cells_is_found(monkeypatch, seconds):
    """An error of 0.1 % that contradicts no rule is found by the cells that are always followed."""
    monkeypatch.setattr(sample, "SECONDS", seconds)
    damaged = of_other_code(atlas_of(UNRULED, x="0.1:1:20", rate="0.5:3:10"))
    assert findings(sweep.verify(damaged, seed=1)).passed
    damaged["x_end"].values[...] *= 1.001
    found = findings(sweep.verify(damaged, seed=1))
    assert [each.name for each in found.wrong] == ["x_end"]
    assert found.disagreeing == found.compared > 0


@pytest.mark.parametrize("seconds", [0.0, np.inf])
def test_a_law_that_is_off_is_found(monkeypatch, seconds):
    """An error of 1e-6: the atlas belongs to a different system than its text says."""
    monkeypatch.setattr(sample, "SECONDS", seconds)
    damaged = of_other_code(
        atlas_of(UNRULED.replace("0.5*sin", "0.5000005*sin"), x="0.1:1:20", rate="0.5:3:10")
    )
    text = damaged.attrs["sweep_spec"].replace("0.5000005", "0.5")
    assert text != damaged.attrs["sweep_spec"]
    damaged.attrs |= {"sweep_spec": text, "sweep_fingerprint": hashlib.sha256(text.encode()).hexdigest()}
    found = findings(sweep.verify(damaged, seed=1))
    assert {each.name for each in found.wrong} == {"x_end", "v_end"}
    assert found.disagreeing == found.compared > 0
