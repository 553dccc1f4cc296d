"""What the journal stores of a block: less than the columns, from which they come back bit by bit."""

import numpy as np
import pytest

from sweep.engine.compute import compute
from sweep.engine.grid import Span
from sweep.model.disk.audit import DERIVED
from sweep.request.spec import SweepSpec
from sweep.runs.journal import packed, unpacked

ROLLING = SweepSpec(roll_rate="0.5:6:30", tilt="0.01deg:60deg:20:log")
CIRCLING = {"roll_rate": "steady", "precession_rate": "-5:5:30", "tilt_rate": 0.01}

SPECS = {
    "rolling": ROLLING,
    "short": ROLLING.replace(duration=0.05),
    "exact": ROLLING.replace(method="exact"),
    "contact": ROLLING.replace(contact="yes"),
    "criterion": ROLLING.replace(criterion="amplification:3"),
    "circling": SweepSpec(tilt="-20deg:20deg:21", **CIRCLING),
    "steady-slow": SweepSpec(tilt="1deg:20deg:20", roll_rate="-9:5:30", precession_rate="steady-slow"),
    "no axis": SweepSpec(tilt="1deg", roll_rate=3),
    "failing": ROLLING.replace(step=0.3),
}


@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
@pytest.mark.parametrize("share", [1.0, 0.4, 0.01], ids=["whole", "part", "few"])
def test_columns_come_back(spec, share):
    """Names, order, types and bits are those that were computed, whichever cells a block has."""
    middle, half = spec.size // 2, int(spec.size * share / 2)
    span = Span(middle - half, max(middle + half, middle - half + 1))
    columns = compute(spec, span)
    stored = packed(spec, columns)
    assert not set(stored) & set(DERIVED)
    back = unpacked(spec, span, stored)
    assert list(back) == list(columns)
    for name, column in columns.items():
        assert (name, back[name].dtype, back[name].shape) == (name, column.dtype, column.shape)
        assert (name, back[name].tobytes()) == (name, column.tobytes())


def test_what_repeats_is_stored_once():
    """A constant is one value, a column that is the same in every row is one row; counts have the smallest type."""
    columns = compute(SPECS["short"], Span(7, 600))
    stored = packed(SPECS["short"], columns)
    assert {
        name: stored[name].size for name in ("ending", "fall_time", "nutation_period", "refinements")
    } == {
        "ending": 1,
        "fall_time": 1,
        "nutation_period": 1,
        "refinements": 1,
    }
    # released at rest, every motion starts from an extreme tilt
    assert stored["tilt_min"].size == 20
    assert stored["steps"].dtype.itemsize == 1
    assert sum(column.nbytes for column in stored.values()) < 18 * 593 + 400


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("tilt_max", -0.0),
        ("tilt_max", np.nan),
        ("fall_time", 1.0),
        ("ending", 5),
        ("steps", -129),
        ("steps", 70000),
    ],
)
@pytest.mark.parametrize("place", [0, 7, 299, 598, 599])
def test_one_cell_makes_the_difference(name, value, place):
    """A column of zeros but for one cell, or one bit, is not taken for one that repeats."""
    spec = ROLLING
    columns = {each: np.zeros_like(column) for each, column in compute(spec, Span(0, 600)).items()}
    columns[name][place] = value
    (whole, back) = columns[name], unpacked(spec, Span(0, 600), packed(spec, columns))[name]
    assert back.dtype == whole.dtype
    assert back.tobytes() == whole.tobytes()


def test_two_kinds_of_nan_are_two_values():
    """NaN with other bits is another value."""
    columns = dict(compute(ROLLING, Span(0, 600)))
    period = np.full(600, np.nan)
    period.view(np.uint64)[300] += 1
    columns["nutation_period"] = period
    back = unpacked(ROLLING, Span(0, 600), packed(ROLLING, columns))
    assert back["nutation_period"].tobytes() == period.tobytes()
