"""Why a row has a boundary or none: the flag of each row, held against a reading of the verdicts as text."""

import itertools
import re

import numpy as np
import pytest

import sweep
from sweep.atlas.dataset import edge_status
from sweep.atlas.row_search import row_status
from sweep.atlas.row_status import FOUND, ROW_STATUS, in_words
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

_CODES = {"s": STABLE, "u": UNSTABLE, "?": UNDECIDED}

#: A start at 10 deg is beyond the 5 deg that the criterion allows.
ROLLING = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:9", tilt="0.1deg,1deg,10deg")


def as_rows(texts):
    """Return verdicts from one text for each row."""
    return np.array([[_CODES[letter] for letter in text] for text in texts], np.int8)


def by_text(text):
    """Return the name of the status of the upper edge, from the row as text."""
    decided = re.sub(r"(.)\1+", r"\1", text.replace("?", ""))
    changes = decided.count("us")
    if changes:
        return "found" if changes == 1 and decided.endswith("s") else "more_than_one_edge"
    if "?" in text:
        return "undecided"
    return {"s": "stable_throughout", "u": "unstable_throughout"}.get(decided, "other_edge_only")


@pytest.mark.parametrize("length", range(1, 8))
def test_every_row_of_a_few_cells(length):
    """All rows of up to seven verdicts have the status that their text has, for the lower edge read backward."""
    texts = ["".join(letters) for letters in itertools.product("su?", repeat=length)]
    rows = as_rows(texts)
    assert [ROW_STATUS[code] for code in row_status(rows).tolist()] == [by_text(text) for text in texts]
    lower = row_status(rows, "lower")
    assert lower.dtype == np.int8
    assert [ROW_STATUS[code] for code in lower.tolist()] == [by_text(text[::-1]) for text in texts]


def test_the_shape_of_the_rows_is_kept():
    """Further dimensions are kept, and a single row gives a single code."""
    rows = as_rows(["uuss", "uuus", "ssss", "suus", "u?s?", "????"]).reshape(2, 3, 4)
    assert [[ROW_STATUS[code] for code in line] for line in row_status(rows).tolist()] == [
        ["found", "found", "stable_throughout"],
        ["found", "found", "undecided"],
    ]
    assert row_status(rows[0, 0]).shape == ()


@pytest.mark.parametrize("strange", [7, -1, np.nan])
def test_what_is_no_verdict_is_undecided(strange):
    """A damaged code, and NaN where a reader has masked a cell, count as undecided."""
    rows = as_rows(["u?ss", "??ss", "s?us"])
    damaged = np.where(rows == UNDECIDED, strange, rows)
    assert row_status(damaged).tolist() == row_status(rows).tolist()
    assert [ROW_STATUS[code] for code in row_status(rows)] == ["found", "undecided", "found"]


@pytest.mark.parametrize("way", ["grid", "refined:1e-6"])
def test_an_atlas_says_why_a_row_has_no_boundary(way):
    """Found at small tilts, unstable throughout at 10 deg; the flag stands beside the boundary and is linked to it."""
    atlas = sweep.run(ROLLING.replace(boundary=way))
    status = atlas["boundary_roll_rate_status"]
    assert [ROW_STATUS[code] for code in status.values.tolist()] == ["found", "found", "unstable_throughout"]
    assert np.array_equal(np.isfinite(atlas["boundary_roll_rate"]), status == FOUND)
    assert status.attrs["flag_meanings"].split() == list(ROW_STATUS.values())
    assert status.attrs["flag_values"].tolist() == list(ROW_STATUS)
    assert status.attrs["standard_name"] == "status_flag"
    assert "_FillValue" not in {**status.attrs, **status.encoding} or status.encoding["_FillValue"] is None
    assert atlas["boundary_roll_rate"].attrs["ancillary_variables"].split()[1] == "boundary_roll_rate_status"


def test_it_follows_from_the_verdicts_of_an_older_file():
    """Without the variable the same codes come from the verdicts, whatever the order of the dimensions."""
    spec = ROLLING.replace(alpha="0.5,1")
    atlas = sweep.run(spec)
    older = atlas.drop_vars("boundary_roll_rate_status").transpose("alpha", "roll_rate", "tilt")
    assert np.array_equal(
        edge_status(older, "roll_rate", "upper").T, atlas["boundary_roll_rate_status"].values
    )


@pytest.mark.parametrize(
    ("codes", "words"),
    [
        ([3, 3], []),
        ([2], ["no boundary: unstable throughout"]),
        ([1, 1, 1], ["no boundary: stable throughout"]),
        ([3, 1, 1], ["no boundary in 2 of 3 rows along roll_rate: stable throughout"]),
        ([3, 0, 2, 2], ["no boundary in 3 of 4 rows along roll_rate: 1 undecided, 2 unstable throughout"]),
        (
            [3, 4, 5],
            [
                "no boundary in 1 of 3 rows along roll_rate: other edge only",
                "more than one edge in 1 of 3 rows along roll_rate",
            ],
        ),
        ([4], ["more than one edge"]),
    ],
)
def test_the_reasons_in_words(codes, words):
    """A single reason needs no count, several have one each; a boundary that was found needs no words."""
    assert in_words(np.array(codes, np.int8), "roll_rate") == words


def test_the_reasons_of_a_named_edge():
    """Where an atlas has two edges, each is called by its name."""
    assert in_words(np.array([3, 5], np.int8), "roll_rate", "upper") == [
        "no upper edge in 1 of 2 rows along roll_rate: lower edge only"
    ]
    assert in_words(np.array([4], np.int8), "roll_rate", edge="lower") == ["more than one lower edge"]
