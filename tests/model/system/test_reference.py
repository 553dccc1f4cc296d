"""What `verify` finds in an atlas of a system that was changed, also where its code is another one's."""

import numpy as np
import pytest

import sweep
from sweep.checks.verify import findings
from sweep.model.system.model import model_of
from sweep.model.system.reference import followed
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
    """Nothing is wrong in what was just computed; a sample was held against SciPy."""
    found = findings(sweep.verify(atlas, seed=1))
    assert found.passed
    assert found.counts["agrees"] == 24
    assert found.extremes[2] <= 1e-8


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


@pytest.mark.parametrize("change", CHANGES)
def test_changes_are_found(atlas, change):
    """Each change of one cell is found, and the cell is named."""
    damaged = atlas.copy(deep=True)
    CHANGES[change](damaged)
    found = findings(sweep.verify(damaged, seed=1))
    assert not found.passed
    assert found.disagreeing == 1


#: What follows from no other variable, and is known only to who computes the cells again.
COMPUTED_ALONE = ("a measure", "no label")


@pytest.mark.parametrize("change", [each for each in CHANGES if each not in COMPUTED_ALONE])
def test_changes_of_other_code_are_found(atlas, change):
    """So is it in an atlas of other code, whose cells are not computed again: by the rules, or by SciPy."""
    damaged = atlas.copy(deep=True)
    damaged.attrs["kernel_hash"] = "0" * 64
    CHANGES[change](damaged)
    # a sample of all cells
    damaged = damaged.isel(x=slice(2, 4), rate=slice(3, 9))
    found = findings(sweep.verify(damaged, seed=1))
    assert not found.passed
    assert found.disagreeing == 1


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
