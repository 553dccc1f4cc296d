"""The search for edges in spans of cells, held against formulas over the whole grid."""

import itertools
import math

import boundary_referee as referee
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from sweep.atlas import row_search
from sweep.atlas.row_search import RowSearch
from sweep.engine.grid import Span
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

#: Verdicts written as they look along an axis: stable, unstable, undecided.
_CODES = {"s": STABLE, "u": UNSTABLE, "?": UNDECIDED}

EDGES = ("upper", "lower")


def as_rows(*texts):
    """Verdicts from one text per row."""
    return np.array([[_CODES[letter] for letter in text] for text in texts], np.int8)


def searched(grid, axis, cuts=()):
    """The search along an axis of a grid that is given in spans between the cuts."""
    search = RowSearch(grid.shape, axis)
    ends = (0, *sorted(cuts), grid.size)
    for start, stop in itertools.pairwise(ends):
        search.add(start, grid.reshape(-1)[start:stop])
    return search


def found(search):
    """Brackets and status of both edges of all rows."""
    rows = Span(0, search.rows)
    return [
        each.tolist() for edge in EDGES for each in (*search.bracket(edge, rows), search.status(edge, rows))
    ]


def expected(grid, axis):
    """The same by the referee."""
    rows = np.moveaxis(grid, axis, -1).reshape(-1, grid.shape[axis])
    return [
        each.tolist() for edge in EDGES for each in (*referee.bracket(rows, edge), referee.status(rows, edge))
    ]


@pytest.mark.parametrize(
    ("row", "upper", "lower"),
    [
        ("uuuss", (2, 3), (-1, -1)),
        ("ssuuu", (-1, -1), (2, 1)),
        ("suus", (2, 3), (1, 0)),
        ("us", (0, 1), (-1, -1)),
        ("su", (-1, -1), (1, 0)),
        ("uu??ss", (1, 4), (-1, -1)),
        ("s??u?s", (3, 5), (3, 0)),
        ("ususs", (2, 3), (-1, -1)),
        ("uuu", (-1, -1), (-1, -1)),
        ("sss", (-1, -1), (-1, -1)),
        ("???", (-1, -1), (-1, -1)),
        ("u???", (-1, -1), (-1, -1)),
        ("?s", (-1, -1), (-1, -1)),
        ("u", (-1, -1), (-1, -1)),
    ],
)
def test_brackets_by_hand(row, upper, lower):
    """The bracket runs from the outermost unstable cell to the next stable one; undecided cells widen it."""
    search = searched(as_rows(row), 1)
    brackets = [search.bracket(edge, Span(0, 1)) for edge in EDGES]
    assert [(int(inside[0]), int(outside[0])) for inside, outside in brackets] == [upper, lower]


grids = array_shapes(min_dims=1, max_dims=4, max_side=6).flatmap(
    lambda shape: arrays(np.int8, shape, elements=st.sampled_from([UNDECIDED, STABLE, UNSTABLE]))
)


@given(st.data(), grids)
def test_any_grid_in_any_spans(data, grid):
    """Along every axis of any grid, in spans of any size, brackets and status are those of the whole grid."""
    cuts = data.draw(st.lists(st.integers(0, grid.size)))
    for axis in range(grid.ndim):
        assert found(searched(grid, axis, cuts)) == expected(grid, axis)


@given(st.data(), st.integers(1, 3), st.integers(1, 3))
def test_long_runs_in_any_spans(data, outer, inner):
    """Rows of a few long runs of equal verdicts, as atlases have them, through spans that end inside the runs."""
    runs = st.lists(st.tuples(st.sampled_from("su?"), st.integers(1, 30)), min_size=1, max_size=6)
    rows = ["".join(code * length for code, length in data.draw(runs)) for _ in range(outer * inner)]
    count = max(map(len, rows))
    lines = as_rows(*(row.ljust(count, row[-1]) for row in rows)).reshape(outer, inner, count)
    grid = np.ascontiguousarray(lines.swapaxes(1, 2))
    cuts = data.draw(st.lists(st.integers(0, grid.size)))
    assert found(searched(grid, 1, cuts)) == expected(grid, 1)


@pytest.mark.parametrize("count", [127, 128, 129, 32768, 32769])
def test_the_last_places_of_long_rows(count):
    """Places fit the type that holds them, at the ends of rows that are as long as the type allows and longer."""
    rows = np.full((3, count), STABLE, np.int8)
    rows[0, -2] = rows[1, -1] = rows[2, 0] = UNSTABLE
    for grid, axis in ((rows, 1), (np.ascontiguousarray(rows.T), 0)):
        assert found(searched(grid, axis)) == expected(grid, axis)


def test_a_span_is_searched_in_parts(monkeypatch):
    """The size of the parts that are searched at a time changes nothing."""
    grid = np.random.default_rng(1).integers(0, 3, (5, 7, 11)).astype(np.int8)
    monkeypatch.setattr(row_search, "_AT_ONCE", 13)
    for axis in range(grid.ndim):
        assert found(searched(grid, axis)) == expected(grid, axis)


def test_some_rows_alone():
    """Brackets and status of a span of rows are those of all rows."""
    grid = np.random.default_rng(2).integers(0, 3, (40, 9)).astype(np.int8)
    search, part = searched(grid, 1), Span(7, 31)
    for edge in EDGES:
        for one, all_rows in zip(search.bracket(edge, part), search.bracket(edge, Span(0, 40)), strict=True):
            assert one.tolist() == all_rows[7:31].tolist()
        assert search.status(edge, part).tolist() == search.status(edge, Span(0, 40))[7:31].tolist()


def test_what_is_kept_does_not_grow_with_the_rows():
    """A search holds a few bytes per row, whatever the number of its cells."""
    small, large = (RowSearch((300, count), 1) for count in (1000, 30000))

    def held(search):
        return sum(each.nbytes for each in vars(search).values() if isinstance(each, np.ndarray))

    assert held(small) == held(large) == 300 * 12
    assert math.prod((300, 30000)) > 1000 * held(large)
