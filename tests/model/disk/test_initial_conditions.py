"""Atlases whose precession rate is computed in every cell are checked like those whose roll rate is."""

import numpy as np
import pytest

import sweep
from sweep.checks.compare import compare
from sweep.checks.verify import findings, verify
from sweep.errors import RequestError

pytestmark = pytest.mark.compiled

GRID = {
    "tilt": "-30deg:30deg:8", "roll_rate": "-8:8:10", "tilt_rate": 1e-4, "criterion": "amplification:10",
}  # fmt: skip


@pytest.fixture(scope="module")
def branches():
    """Return the atlases of both branches, and that of the same tilts by precession rate."""
    found = {branch: sweep.run(sweep.SweepSpec(**GRID, precession_rate=branch)) for branch in
             ("steady-slow", "steady-fast")}  # fmt: skip
    words = GRID | {"roll_rate": "steady", "precession_rate": "-4:4:10"}
    return found | {"by precession": sweep.run(sweep.SweepSpec(**words))}


@pytest.mark.parametrize("branch", ["steady-slow", "steady-fast"])
def test_every_cell_is_verified(branches, branch):
    """Cells that exist agree with the exact reduction, the others are invalid, and none is left out."""
    atlas = branches[branch]
    found = findings(verify(atlas))
    missing = int(np.isnan(atlas["precession_rate"]).sum())
    assert missing > 0
    assert found.counts["agrees"] + found.counts["invalid"] == found.cells == 80
    assert found.counts["invalid"] == missing
    assert found.passed


def test_a_wrong_precession_rate_is_caught(branches):
    """The precession rate that is computed for each cell is held against the formula."""
    atlas = branches["steady-slow"].copy(deep=True)
    place = tuple(np.argwhere(np.isfinite(atlas["precession_rate"].values))[5])
    atlas["precession_rate"].values[place] *= 1.0 + 1e-6
    found = findings(verify(atlas))
    assert (found.counts["contradictory"], found.disagreeing) == (1, 1)


def test_branches_are_compared(branches):
    """A branch is the same as itself, every variable of it; two branches, or two forms, are not comparable."""
    atlas = branches["steady-slow"]
    comparison = compare(atlas, atlas)
    assert comparison.same
    assert {each.name for each in comparison.findings} == set(atlas.data_vars)
    for other, fields in (
        ("steady-fast", "precession_rate"),
        ("by precession", "precession_rate, roll_rate"),
    ):
        with pytest.raises(RequestError, match=rf"they differ in {fields}[.:;] ") as refusal:
            compare(atlas, branches[other])
        assert "precession_rate steady-slow and " in str(refusal.value)
        with pytest.raises(RequestError, match="not comparable"):
            compare(branches[other], atlas, common=True)
