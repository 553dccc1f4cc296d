"""Every variable of every kind of atlas has a comparison rule, and known regressions are found.

A new variable without a rule, or with a rule that is more lenient than it states, fails these tests.
"""

import itertools
import json

import numpy as np
import pytest
from comparing import CIRCLING, REFINED, SPEC, STEADY, changed, found
from messages import assert_facts, refused

import sweep
from sweep.atlas.completion import BOUNDARY
from sweep.checks.alignment import align
from sweep.checks.cell_pair import CellPair
from sweep.checks.compare import compare
from sweep.checks.variables import FOREIGN, allowed, allowed_of_cells, variables
from sweep.errors import RequestError

KINDS = {
    "rolling with contact": SPEC.replace(contact="yes"),
    "refined": REFINED,
    "refined, both signs": REFINED.replace(roll_rate="-4:4:14", tilt="0.1deg:1deg:4"),
    "circling": CIRCLING.replace(boundary="refined:1e-9"),
    "computed rate": STEADY,
    "exact": SPEC.replace(method="exact"),
    "own": REFINED.replace(criterion="peak_tilt > 3*tilt and nutation_period > 3s"),
    "cube": SPEC.replace(roll_rate="0:3:7", tilt="0.1deg,1deg", alpha="0.5,1", tolerance=1e-6),
    "kicked": SPEC.replace(tilt=0, tilt_rate="0.01:3:4:log", duration=1.0),
}

#: The tolerances of other variables follow from these, so they are moved separately.
STATED = ("tilt_error", "_halfwidth")


@pytest.fixture(scope="module")
def atlases():
    """Return one atlas of every kind."""
    return {name: sweep.run(spec) for name, spec in KINDS.items()}


def rules_of(atlas):
    """Return the comparison rules of an atlas by variable."""
    return {each.name: each for each in variables(align(atlas, atlas, common=False))}


def limits(pair, quantity):
    """Return the tolerance of each value of a variable."""
    shape = pair.reference[quantity.name].shape
    if quantity.name not in CellPair(pair).names:
        return np.broadcast_to(allowed(quantity, pair), shape)
    (block,) = CellPair(pair).blocks()
    return allowed_of_cells(quantity, *block.stated, block.starts).reshape(shape)


def moved(atlas, share, names):
    """Return a copy with the first, middle and last value of each variable moved by a share of its tolerance.

    If the share is above 1, integers are moved by one more than the tolerance, and a variable without values
    gets some.
    """
    copy, pair, rules = atlas.copy(deep=True), align(atlas, atlas, common=False), rules_of(atlas)
    for name in names:
        values, most = copy[name].values, limits(pair, rules[name].quantity)
        known = np.argwhere(np.isfinite(values.astype(float)))
        if not len(known):
            values[...] = 1.0 if share > 1.0 else values
        for place in {tuple(known[i]) for i in (0, len(known) // 2, -1)} if len(known) else ():
            if values.dtype.kind == "i":
                values[place] += round(most[place]) + (share > 1.0)
            else:
                # one spacing more, because the sum is rounded
                values[place] += share * most[place] + (share > 1.0) * abs(np.spacing(values[place]))
    return copy


@pytest.mark.slow_lane
def test_a_change_beyond_what_is_allowed_is_found_in_every_variable(atlases, pick):
    """Changes just within the tolerance pass, and slightly larger ones are found in every variable."""
    for kind in pick(KINDS, 5):
        atlas, rules = atlases[kind], rules_of(atlases[kind])
        assert set(rules) == set(atlas.variables)
        assert FOREIGN not in {each.kind for each in rules.values()}
        measured = [name for name in map(str, atlas.data_vars) if rules[name].has_tolerance]
        stated = [name for name in measured if name.endswith(STATED)]
        others = [name for name in measured if name not in stated]
        for names in (stated, others):
            near = compare(moved(atlas, 0.99, names), atlas)
            assert near.same, found(near)
            far = compare(moved(atlas, 1.01, names), atlas)
            assert found(far).keys() == set(names), set(names) ^ found(far).keys()


@pytest.mark.slow_lane
def test_every_decision_and_every_missing_variable_is_found(atlases):
    """In every atlas, a changed flag and a missing variable are differences."""
    for kind in KINDS:
        atlas, rules = atlases[kind], rules_of(atlases[kind])
        flags = [name for name in map(str, atlas.data_vars) if rules[name].quantity.flags is not None]
        spoilt = atlas.copy(deep=True)
        for name in flags:
            # a code that neither a neighbor nor a cell at a limit has
            spoilt[name].values[...] = 77
        assert found(compare(spoilt, atlas)).keys() >= set(flags)
        needed = {"ending", "stability", "tilt_min", "tilt_max"}
        lost = set(map(str, atlas.data_vars)) - needed
        # a missing boundary is computed again from the verdicts
        again = {name for name in lost if name.startswith(BOUNDARY)}
        assert found(compare(atlas.drop_vars(lost), atlas)).keys() == lost - again
        with refused("lacks tilt_min"):
            compare(atlas.drop_vars("tilt_min"), atlas)


def test_extremes_may_differ_by_what_both_atlases_state(atlases):
    """Extremes may differ by twice the tolerance or twice both stated errors, whichever is larger."""
    atlas, tolerance = atlases["rolling with contact"], SPEC.tolerance
    known = np.isfinite(atlas["tilt_max"].values)
    limit = 2.0 * np.minimum(np.fmax(2.0 * atlas["tilt_error"].values, tolerance), 2.0 * tolerance)
    for share, count in ((0.9, 0), (1.1, int(known.sum()))):
        other = atlas.assign(tilt_max=atlas["tilt_max"] + share * limit)
        assert found(compare(other, atlas)) == ({"tilt_max": count} if count else {})


def test_half_widths_that_were_not_reached_may_differ_by_a_width_and_others_by_none(atlases):
    """A bracket of the requested width has an exact half-width; a wider one may differ by a quarter of the width.

    Other kernels may leave other verdicts open, because their errors differ.
    """
    name, width = "boundary_roll_rate_halfwidth", 1e-6
    atlas = atlases["refined"]
    count = int(np.isfinite(atlas[name].values).sum())
    assert count
    assert (atlas[name].values[np.isfinite(atlas[name].values)] <= 0.5 * width * (1.0 + 1e-9)).all()
    assert found(compare(atlas.assign({name: 0.9 * atlas[name]}), atlas)) == {name: count}
    wide = atlas.assign({name: 0.0 * atlas[name] + 3.0 * width})
    assert compare(wide.assign({name: wide[name] + 0.2 * width}), wide).same
    assert found(compare(wide.assign({name: wide[name] + 0.3 * width}), wide)) == {name: count}
    others = wide.assign_attrs(kernel_hash="0" * 64)
    assert compare(others.assign({name: wide[name] + 3.9 * width}), wide).same
    assert found(compare(others.assign({name: wide[name] + 4.1 * width}), wide)) == {name: count}
    for half in (each for each in atlas.variables if str(each).endswith("_halfwidth")):
        known = int((atlas[half].values > 0.0).sum())
        assert found(compare(atlas.assign({half: 2.0 * atlas[half]}), atlas)) == {half: known} != {half: 0}


#: Errors of earlier versions and damaged files that passed an earlier regression check.
REGRESSIONS = {
    "boundary_roll_rate": lambda values: values * 1.0012,
    "critical_roll_rate": lambda values: values * 1.001,
    "predicted_roll_rate": lambda values: values * 1.001,
    "tilt_min": lambda values: values + 1e-6,
    "tilt_max": lambda values: values + 1e-6,
    "peak_tilt": lambda values: values + 1e-6,
    "nutation_period": lambda values: values * 1.0015,
}


def test_known_regressions_are_found(atlases):
    """Boundaries, lines of theory, tilts and periods with errors beyond the stated ones are found in every value."""
    for kind, name in itertools.product(("rolling with contact", "refined", "cube", "exact"), REGRESSIONS):
        atlas = atlases[kind]
        copy = atlas.copy(deep=True)
        copy[name].values[...] = REGRESSIONS[name](atlas[name].values)
        changed = np.nan_to_num(copy[name].values) != np.nan_to_num(atlas[name].values)
        if kind == "cube" and name.startswith(("tilt", "peak")):
            # this one states a tolerance of 1e-6 itself
            assert compare(copy, atlas).outcome == "within tolerance"
        else:
            assert found(compare(copy, atlas)) == {name: int(changed.sum())}


#: Damages of a coordinate, and the part that the refusal names: a value, the units or the type.
DAMAGES = (
    (lambda axis: axis * np.nan, lambda axis: "nan"),
    (lambda axis: axis * 0 + 0.3, lambda axis: "0.3"),
    (
        lambda axis: (axis * (1 + 1e-9)).assign_attrs(axis.attrs),
        lambda axis: repr(float(axis.values[axis.values != 0][0])),
    ),
    (lambda axis: axis.assign_attrs(units="degree"), lambda axis: "degree"),
    (lambda axis: axis.astype(str), lambda axis: str(axis.dtype)),
)


def test_broken_and_lost_coordinates_are_refused(atlases):
    """An atlas with damaged or missing coordinates is refused on either side, as its cells cannot be identified."""
    atlas = atlases["rolling with contact"]
    broken = [
        (name, atlas.assign_coords({name: damage(atlas[name])}), what(damage(atlas[name])))
        for name in ("tilt", "roll_rate", "alpha")
        for damage, what in DAMAGES
    ]
    broken += [(name, atlas.drop_vars(name), name) for name in ("tilt", "roll_rate")]
    for name, other, what in broken:
        for pair in ((other, atlas), (atlas, other)):
            with pytest.raises(RequestError) as caught:
                compare(*pair)
            assert_facts(caught.value.message, name)
            assert what in caught.value.message, (name, caught.value.message)


def test_a_lost_fixed_parameter_is_that_of_the_spec(atlases):
    """A missing fixed parameter, as in files rewritten by CDO, is taken from the spec."""
    atlas = atlases["rolling with contact"]
    assert compare(atlas.drop_vars("alpha"), atlas).identical


def test_a_variable_that_is_not_known_is_named(atlases):
    """A variable of another program, in one atlas or with different values in both, is named."""
    atlas = atlases["refined"]
    other = atlas.assign(mine=("tilt", np.arange(6.0)))
    for pair, told in (
        ((other, atlas), "reference"),
        ((atlas, other), "new"),
        ((atlas.assign(mine=("tilt", np.ones(6))), other), "version"),
        ((atlas.assign(mine=("tilt", list("abcdef"))), other), "version"),
    ):
        comparison = compare(*pair)
        (note,) = comparison.notes
        assert_facts(note, "mine", told)
        assert (comparison.outcome, compare(*pair, exact=True).outcome) == ("within tolerance", "different")
    assert compare(other, other).identical


@pytest.mark.slow_lane
def test_a_value_that_is_no_number_differs_in_either_file(atlases, pick):
    """An infinite or missing value in either atlas is a difference; the JSON report contains no infinity."""
    values = (np.inf, -np.inf, np.nan)
    for kind, value in pick(itertools.product(("rolling with contact", "refined", "exact"), values), 2):
        atlas = atlases[kind]
        for name, rule in rules_of(atlas).items():
            values = atlas[name].values
            known = np.argwhere(np.isfinite(values)) if values.dtype.kind == "f" else []
            if not len(known) or rule.kind == FOREIGN or name in atlas.coords:
                continue
            broken = atlas.copy(deep=True)
            broken[name].values[tuple(known[-1])] = value
            for new, reference in ((atlas, broken), (broken, atlas)):
                comparison = compare(new, reference)
                assert name in found(comparison), (kind, name, value)
                json.dumps(comparison.to_dict(), allow_nan=False)


def test_a_stated_error_excuses_no_more_than_the_tolerance(atlases):
    """Stated errors beyond the file's own tolerance do not widen the comparison."""
    atlas, broken = atlases["cube"], atlases["cube"].copy(deep=True)
    broken["tilt_error"].values[...] = 1.0
    broken["tilt_max"].values[...] += 1e-3
    comparison = compare(broken, atlas)
    assert "tilt_max" in found(comparison)


def test_times_and_errors_are_not_negative():
    """A negative time is a difference, even if a coarse tolerance would allow it."""
    spec = sweep.SweepSpec.preset("circling").replace(
        tilt="1deg:15deg:5", precession_rate="0.1:5:7", tolerance=1e-3
    )
    atlas = sweep.run(spec)
    for name in ("nutation_period", "fall_time", "tilt_error", "energy_drift", "steps"):
        broken = atlas.copy(deep=True)
        broken[name] = -broken[name] - (name == "energy_drift") * 1e-12
        assert name in found(compare(broken, atlas)), name
    # within the tolerance of an error, which is only an order of magnitude
    for name in ("tilt_error", "energy_drift"):
        new, reference = (changed(atlas, name, (2, 2), value) for value in (-1e-12, 1e-12))
        assert found(compare(new, reference)) == {name: 1}, name


def test_the_exact_reduction_takes_no_steps(atlases):
    """Steps in an atlas of the exact reduction are a difference."""
    broken = atlases["exact"].copy(deep=True)
    broken["steps"].values[...] = 1
    assert "steps" in found(compare(broken, atlases["exact"]))
