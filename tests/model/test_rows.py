"""Rules for several parameters: rows of a table are checked one by one, a grid with all combinations."""

import pytest
from messages import assert_facts

from sweep.errors import RequestError
from sweep.request.spec import SweepSpec
from sweep.request.system_file import read_system
from sweep.systems import System

TILTS = [0.1, 0.2, 0.3]
LENS = System(
    read_system("""
@body(duration="10 s", stable="tilt_min > 10deg")
def lens(tilt, *, deep=0.5, axial=0.4, transverse=0.3):
    return sqrt(cos(tilt)**2 + deep**2*sin(tilt)**2), axial, transverse
""")
)

#: Inputs, columns whose rows are allowed although their extremes are not, and the values of a forbidden row.
RULES = {
    "moments": (
        {"body": "ball"},
        {"axial_moment": [0.1, 0.4, 0.7], "transverse_moment": [0.06, 0.3, 0.4]},
        {"axial_moment": 0.7, "transverse_moment": 0.3},
    ),
    "moments and one number": ({"body": "ball", "transverse_moment": 0.2}, {"axial_moment": [0.1, 0.3, 0.4]},
                               {"axial_moment": 0.5}),
    "rim": ({"body": "rim"}, {"thickness": [0.1, 0.3, 0.4], "fillet": [0.05, 0.1, 0.2]},
            {"thickness": 0.1, "fillet": 0.06}),
    "offset of a spheroid": (
        {"body": "spheroid", "axial_moment": 0.4, "transverse_moment": 0.4},
        {"flattening": [0.1, 0.5, 0.7], "offset": [-0.8, 0.4, 0.2]},
        {"flattening": 0.7, "offset": -0.4},
    ),
    "lever arm": ({}, {"radius": [0.1, 0.2, 0.3], "rolling_friction": [0.01, 0.1, 0.2]},
                  {"radius": 0.1, "rolling_friction": 0.1}),
    "body of one's own": ({"model": LENS}, {"axial": [0.1, 0.4, 0.7], "transverse": [0.06, 0.3, 0.4]},
                          {"axial": 0.7, "transverse": 0.3}),
}  # fmt: skip


@pytest.mark.parametrize("name", RULES)
def test_rows_are_possible_or_named(name):
    """A table of allowed rows is accepted; the first forbidden row is named with its values."""
    words, columns, wrong = RULES[name]
    words = {"roll_rate": 3, **words}
    assert SweepSpec(**words, starts={"tilt": TILTS, **columns}).size == 3
    for row in range(3):
        spoilt = {key: [*values[:row], wrong[key], *values[row + 1 :]] for key, values in columns.items()}
        with pytest.raises(RequestError) as caught:
            SweepSpec(**words, starts={"tilt": TILTS, **spoilt})
        facts = (
            []
            if name == "body of one's own"
            else [f"row {row + 1}", *(f"{key}={wrong[key]:g}" for key in wrong)]
        )
        assert_facts(str(caught.value), *facts, *(f"{value:g}" for value in wrong.values()))


@pytest.mark.parametrize("name", [name for name, (_, columns, _) in RULES.items() if len(columns) > 1])
def test_of_a_grid_all_values_meet(name):
    """The same values as axes are refused, as the largest of one meets the smallest of the other."""
    words, columns, _ = RULES[name]
    axes = {key: sorted(values) for key, values in columns.items()}
    with pytest.raises(RequestError):
        SweepSpec(**{"roll_rate": 3, "tilt": 0.1, **words, **axes})


@pytest.mark.parametrize("name", [name for name in RULES if name != "body of one's own"])
def test_a_spec_without_its_table(name):
    """A spec's text omits the values of its table, which were checked when it was given."""
    words, columns, _ = RULES[name]
    spec = SweepSpec(**{"roll_rate": 3, **words}, starts={"tilt": TILTS, **columns})
    assert SweepSpec.from_canonical(spec.canonical()) == spec
