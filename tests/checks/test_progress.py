"""verify, compare and refine report their progress, and their results do not depend on it."""

import functools
import itertools
import time

import pytest
from messages import refused

import sweep
from sweep.checks import verify as verifying
from sweep.checks.cell_audit import CellAudit
from sweep.checks.compare import COMPARING
from sweep.checks.verify import CHECKING
from sweep.progress.timetable import SEARCHING, Timetable

#: More cells than a reader's block.
SPEC = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:600", tilt="0.1deg:5deg:400", method="exact")


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas."""
    return sweep.run(SPEC)


def stages(heard):
    """Return the stages in order, each with its progress counts."""
    return [
        (name, [each.done for each in some])
        for name, some in itertools.groupby(heard, lambda each: each.stage)
    ]


@pytest.mark.compiled
def test_verify_tells_its_cells(atlas):
    """The cells are reported first, then the boundary; the findings equal those without a callback."""
    heard = []
    found = sweep.verify(atlas, seed=1, progress=heard.append)
    (checking, cells), (searching, _) = stages(heard)
    assert (checking, searching) == (CHECKING, SEARCHING)
    assert (cells[0], cells[-1], cells) == (0, SPEC.size, sorted(set(cells)))
    assert len(cells) > 2
    # as text, where NaN equals NaN
    assert repr(sweep.findings(found)) == repr(sweep.findings(sweep.verify(atlas, seed=1)))


@pytest.mark.compiled
def test_compiling_in_the_first_block_is_no_pace(atlas, monkeypatch):
    """The compilation in the first block does not count towards the pace of the others."""
    heard, audited, waited = [], CellAudit.audited, [0.0]

    def compiling(self, stored):
        waited[0] += 3600.0
        yield from audited(self, stored)

    clocked = functools.partial(Timetable, clock=lambda: time.monotonic() + waited[0])
    monkeypatch.setattr(CellAudit, "audited", compiling)
    monkeypatch.setattr(verifying, "Timetable", clocked)
    sweep.verify(atlas, progress=heard.append)
    seconds = [each.seconds for each in heard if each.stage == CHECKING]
    assert seconds[:2] == [None, None]
    assert max(each for each in seconds if each is not None) < 60.0


@pytest.mark.compiled
def test_compare_tells_how_far_it_is(atlas):
    """All cells are read once, and the results do not depend on the callback."""
    heard = []
    other = atlas.assign(peak_tilt=atlas["peak_tilt"] * (1 + 1e-3))
    found = sweep.compare(other, atlas, progress=heard.append)
    assert not found.same
    assert found == sweep.compare(other, atlas)
    ((comparing, cells),) = stages(heard)
    assert comparing == COMPARING
    assert len(cells) > 2
    assert (cells[0], cells[-1], cells) == (0, SPEC.size, sorted(set(cells)))


def test_refine_tells_its_search():
    """The progress of `refine` runs from nothing to everything."""
    coarse, heard = sweep.run("rolling", roll_rate="2:4:9", tilt="0.1deg:5deg:5"), []
    sweep.refine(coarse, 1e-6, progress=heard.append)
    assert {(each.stage, each.size, each.things) for each in heard} == {(SEARCHING, 1000, "parts")}
    dones = [each.done for each in heard]
    assert (dones[0], dones) == (0, sorted(dones))
    assert dones[-1] == 1000


def test_another_wish_is_refused(atlas):
    """Another kind of progress argument is refused, as by `sweep.run`."""
    calls = (sweep.verify, sweep.refine, functools.partial(sweep.compare, atlas))
    for call in calls:
        with refused("progress"):
            call(atlas, progress="bar")
