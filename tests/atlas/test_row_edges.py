"""The edges of rows and the reason for a missing boundary, compared with formulas and with rows as text."""

import itertools
import re

import boundary_referee as referee
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from messages import assert_facts, assert_in_order, missing, refused

import sweep
from sweep.atlas import row_edges
from sweep.atlas.dataset import edge_status
from sweep.atlas.row_edges import FOUND, ROW_STATUS, RowEdges, in_words, legal
from sweep.atlas.selection import as_atlas
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

#: Verdict codes by letter: stable, unstable, undecided.
_CODES = {"s": STABLE, "u": UNSTABLE, "?": UNDECIDED}

EDGES = ("upper", "lower")

#: A start at 10 deg is beyond the criterion's limit of 5 deg.
ROLLING = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:9", tilt="0.1deg,1deg,10deg")


def as_rows(texts):
    """Return the verdicts of rows, each written as text."""
    return np.array([[_CODES[letter] for letter in text] for text in texts], np.int8)


def status(rows, edge="upper"):
    """Return the status names of the rows along the last axis."""
    return [ROW_STATUS[code] for code in RowEdges.of(rows, rows.ndim - 1).status(edge).reshape(-1).tolist()]


def test_brackets_by_hand():
    """The bracket extends from the outermost unstable cell to the next stable one; undecided cells widen it."""
    cases = [
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
    ]
    for row, *expected in cases:
        edges = RowEdges.of(as_rows([row]), 1)
        brackets = [tuple(int(each[0]) for each in edges.bracket(edge)) for edge in EDGES]
        assert brackets == expected, row


grids = array_shapes(min_dims=1, max_dims=4, max_side=6).flatmap(
    lambda shape: arrays(np.int8, shape, elements=st.sampled_from([UNDECIDED, STABLE, UNSTABLE]))
)


@given(grids, st.integers(1, 50))
def test_any_grid(grid, at_once):
    """Along every axis, for any batch size, brackets and status equal the referee's."""
    kept, row_edges._AT_ONCE = row_edges._AT_ONCE, at_once
    try:
        for axis in range(grid.ndim):
            rows, edges = np.moveaxis(grid, axis, -1), RowEdges.of(grid, axis)
            for edge in EDGES:
                for found, expected in zip(
                    (*edges.bracket(edge), edges.status(edge)),
                    (*referee.bracket(rows, edge), referee.status(rows, edge)),
                    strict=True,
                ):
                    np.testing.assert_array_equal(found, expected, f"{edge} edge along {axis}")
    finally:
        row_edges._AT_ONCE = kept


def by_text(text):
    """Return the status name of the upper edge of a row that is written as text."""
    decided = re.sub(r"(.)\1+", r"\1", text.replace("?", ""))
    changes = decided.count("us")
    if changes:
        return "found" if changes == 1 and decided.endswith("s") else "more_than_one_edge"
    if "?" in text:
        return "undecided"
    return {"s": "stable_throughout", "u": "unstable_throughout"}.get(decided, "other_edge_only")


def test_every_row_of_a_few_cells():
    """All rows of up to seven verdicts have the status of their text; the lower edge has that of the reversed text."""
    for length in range(1, 8):
        texts = ["".join(letters) for letters in itertools.product("su?", repeat=length)]
        rows = as_rows(texts)
        assert status(rows) == [by_text(text) for text in texts]
        assert status(rows, "lower") == [by_text(text[::-1]) for text in texts]


def test_what_is_no_verdict_is_undecided():
    """Damaged codes and NaN, which readers use for masked cells, count as undecided."""
    rows = as_rows(["u?ss", "??ss", "s?us"])
    assert status(rows) == ["found", "undecided", "found"]
    for strange in (7, -1, np.nan):
        np.testing.assert_array_equal(legal(np.where(rows == UNDECIDED, strange, rows)), rows)


def test_an_atlas_says_why_a_row_has_no_boundary():
    """The boundary is found at small tilts; at 10 deg the linked status flag says unstable throughout."""
    for way in ("grid", "refined:1e-6"):
        atlas = sweep.run(ROLLING.replace(boundary=way))
        flag = atlas["boundary_roll_rate_status"]
        assert [ROW_STATUS[code] for code in flag.values.tolist()] == [
            "found",
            "found",
            "unstable_throughout",
        ]
        assert np.array_equal(np.isfinite(atlas["boundary_roll_rate"]), flag == FOUND)
        assert flag.attrs["flag_meanings"].split() == list(ROW_STATUS.values())
        assert flag.attrs["flag_values"].tolist() == list(ROW_STATUS)
        assert flag.attrs["standard_name"] == "status_flag"
        assert "_FillValue" not in {**flag.attrs, **flag.encoding} or flag.encoding["_FillValue"] is None
        assert (
            atlas["boundary_roll_rate"].attrs["ancillary_variables"].split()[1] == "boundary_roll_rate_status"
        )


def test_it_is_found_again_from_the_verdicts():
    """A missing status variable is restored with the same codes; without that it is reported by name."""
    atlas = sweep.run(ROLLING.replace(alpha="0.5,1"))
    part = atlas.drop_vars("boundary_roll_rate_status")
    assert np.array_equal(
        edge_status(as_atlas(part), "roll_rate", "upper"), atlas["boundary_roll_rate_status"].values
    )
    with refused("boundary_roll_rate_status"):
        edge_status(part, "roll_rate", "upper")


def test_the_reasons_in_words():
    """A single reason has no count, several reasons have one each, and a found boundary needs no words."""
    cases = [
        ([3, 3], []),
        ([2], [["unstable throughout"]]),
        ([1, 1, 1], [["stable throughout"]]),
        ([3, 1, 1], [["2 of 3", "roll_rate", "stable throughout"]]),
        ([3, 0, 2, 2], [["3 of 4", "roll_rate", "1 undecided", "2 unstable throughout"]]),
        ([3, 4, 5], [["1 of 3", "roll_rate", "other edge only"], ["more than one", "1 of 3", "roll_rate"]]),
        ([4], [["more than one"]]),
    ]
    for codes, expected in cases:
        lines = in_words(np.array(codes, np.int8), "roll_rate")
        for line, facts in zip(lines, expected, strict=True):
            assert missing(line, facts) == [], codes
            assert len(re.findall(r"\d+", line)) == len(re.findall(r"\d+", " ".join(facts))), codes


def test_the_reasons_of_a_named_edge():
    """If an atlas has two edges, each is named."""
    (line,) = in_words(np.array([3, 5], np.int8), "roll_rate", "upper")
    assert_in_order(line, "upper edge", "lower edge only")
    assert_facts(line, "1 of 2", "roll_rate")
    (line,) = in_words(np.array([4], np.int8), "roll_rate", edge="lower")
    assert_facts(line, "more than one", "lower edge")
