"""`verify` and `compare` name a single wrong cell, in any variable and block."""

import functools
import itertools
from functools import lru_cache

import numpy as np
import pytest
from comparing import finding, found

import sweep
from sweep.atlas.cf_metadata import cell_declarations
from sweep.checks import cell_audit
from sweep.checks.compare import compare
from sweep.checks.statement import cell_in_words
from sweep.checks.verify import findings, findings_of, verify
from sweep.engine.grid import chunk_shape, chunks
from sweep.files import cell_reader
from sweep.files.cell_reader import CellReader
from sweep.model.disk.tables import ENDINGS
from sweep.request.spec import SweepSpec

pytestmark = pytest.mark.compiled

SPEC = SweepSpec.preset("rolling").replace(roll_rate="1:4:12", tilt="0.1deg:60deg:20", contact="yes")
NAMES = [each.name for each in cell_declarations(SPEC)]

#: The first and last cell, both sides of the ends of a block and of a judged batch, and one in between.
PLACES = (0, 15, 16, 59, 60, 131, 239)

#: The same places, in groups small enough for `verify` to name all of them.
TOGETHER = ((0, 15, 16), (59, 60, 131), (239,))


@lru_cache
def atlas():
    """Return an atlas with falls; tests must not change it."""
    return sweep.run(SPEC)


@pytest.fixture
def small_blocks(monkeypatch):
    """Read 60 cells at a time and judge 16 at a time."""
    for name, function in (("chunk_shape", chunk_shape), ("chunks", chunks)):
        monkeypatch.setattr(cell_reader, name, functools.partial(function, cells=35))
    monkeypatch.setattr(cell_reader, "BLOCK_CELLS", 70)
    monkeypatch.setattr(cell_audit, "_JUDGED_CELLS", 16)
    assert [span.start for span in CellReader(atlas(), NAMES).spans()] == [0, 60, 120, 180]


def wrong_value(name, value):
    """Return a wrong value in place of a right one."""
    if name == "ending":
        return ENDINGS.code("unresolved")
    if name == "stability":
        return 0
    if isinstance(value, np.integer):
        return value + 100
    return 1.0 if np.isnan(value) else 1.5 * value + 1.0


def with_wrong_value(dataset, name, place, value):
    """Return a copy with a wrong value at one or more places."""
    copy = dataset.copy(deep=True)
    copy[name].values.reshape(-1)[np.asarray(place)] = value
    return copy


def where(dataset, place):
    """Return the coordinates of the cell with this flat index."""
    index = np.unravel_index(place, SPEC.shape)
    return {name: float(dataset[name][i]) for name, i in zip(SPEC.axes, index, strict=True)}


@pytest.mark.slow_lane
def test_verify_names_the_cell(small_blocks):
    """`verify` counts the wrong values of a variable, names their cells and flags each cell."""
    assert sorted(place for places in TOGETHER for place in places) == list(PLACES)
    for name, places in itertools.product(NAMES, TOGETHER):
        right = atlas()[name].values.reshape(-1)
        values = [wrong_value(name, right[place]) for place in places]
        found_there = findings_of(with_wrong_value(atlas(), name, places, values))
        line = next(each for each in found_there.statements if each.name == name)
        assert (line.wrong, line.named) == (
            len(places),
            [cell_in_words(SPEC, place) for place in places],
        ), name
        if name != "ending":
            # a cell that claims to be unresolved gets only that flag
            assert found_there.disagreeing == len(places), name
            assert [at for _, at in found_there.named] == [where(atlas(), place) for place in places], name


def test_compare_names_the_cell(small_blocks):
    """If one cell is wrong in all variables, `compare` finds one wrong value in each, also with `exact`."""
    for place in PLACES:
        corrupt, nearly = atlas(), atlas()
        for name in NAMES:
            right = atlas()[name].values.reshape(-1)[place]
            corrupt = with_wrong_value(corrupt, name, place, wrong_value(name, right))
            whole = isinstance(right, np.integer)
            bit = right + 1 if whole else np.nextafter(right, np.inf, dtype=right.dtype)
            nearly = with_wrong_value(nearly, name, place, 0.0 if np.isnan(right) else bit)
        for comparison in (compare(corrupt, atlas()), compare(nearly, atlas(), exact=True)):
            assert found(comparison) == dict.fromkeys(NAMES, 1), place
            for name in NAMES:
                assert finding(comparison, name).worst.where == where(atlas(), place), (place, name)


def test_blocks_change_nothing(small_blocks, monkeypatch):
    """The results of `verify` and `compare` do not depend on the block sizes."""
    wrong = with_wrong_value(with_wrong_value(atlas(), "tilt_max", 61, 0.3), "steps", 200, 7)
    other = sweep.run(SPEC.replace(tolerance=1e-6))
    in_blocks = [findings(verify(each)) for each in (atlas(), wrong, other)]
    compared = [compare(each, atlas()) for each in (atlas(), wrong, other)]
    monkeypatch.undo()
    # as text, where NaN equals NaN
    assert repr(in_blocks) == repr([findings(verify(each)) for each in (atlas(), wrong, other)])
    assert repr(compared) == repr([compare(each, atlas()) for each in (atlas(), wrong, other)])
    assert [each.outcome for each in compared] == ["identical", "different", "within tolerance"]


def test_a_promise_of_a_share_is_broken_in_any_block(small_blocks, monkeypatch):
    """Stated errors that are too small are found in cells that are not integrated again; the first are named."""
    monkeypatch.setattr(cell_audit, "_MOST_STEPS", float(atlas()["steps"].sum()) / 6.5)
    corrupt = atlas().copy(deep=True)
    wrong = [place for place in range(85, 130) if place % 7]
    corrupt["tilt_error"].values.reshape(-1)[wrong] = 1e-30
    line = next(each for each in findings(verify(corrupt)).statements if each.name == "tilt_error")
    assert len(wrong) - 5 < line.wrong <= len(wrong)
    assert line.named == [cell_in_words(SPEC, place) for place in (85, 86, 87)]


def test_neighbours_in_other_blocks(small_blocks):
    """A cell that ends like a neighbor is on an edge, also across blocks; row ends are not neighbors."""
    endings = atlas()["ending"].values.reshape(-1)
    index = np.stack(np.unravel_index(np.arange(endings.size), SPEC.shape))
    for step, axis in ((1, 1), (-1, 1), (20, 0), (-20, 0)):
        places = [
            place
            for place in np.flatnonzero(index[axis] == np.roll(index[axis], -step) - np.sign(step)).tolist()
            if 0 <= place + step < endings.size and endings[place] != endings[place + step]
        ]
        assert places
        for place in places:
            comparison = compare(with_wrong_value(atlas(), "ending", place, endings[place + step]), atlas())
            assert (found(comparison), finding(comparison, "ending").on_edge) == ({}, 1)
    # the ends of adjacent rows are not neighbors
    for place, other, neighbours in ((20, 19, [0, 21, 40]), (19, 20, [18, 39])):
        comparison = compare(with_wrong_value(atlas(), "ending", place, endings[other]), atlas())
        assert found(comparison) == ({} if endings[other] in endings[neighbours] else {"ending": 1})
    assert endings[20] not in endings[[18, 39]]
