"""The regression check finds all changes, their places, and nothing else."""

import re
from dataclasses import replace

import numpy as np
import pytest
from comparing import CIRCLING, REFINED, SPEC, STEADY, changed, finding, found
from messages import assert_facts, missing, refused, with_facts

import sweep
from sweep.checks.compare import compare
from sweep.checks.comparison_report import in_words
from sweep.model.disk import tables
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import VARIABLES
from sweep.model.quantity import FILL, STABLE, UNDECIDED, UNSTABLE, Word, table


@pytest.fixture(scope="module")
def reference():
    """Return an atlas with falls, which lacks some measures in some cells."""
    return sweep.run(SPEC)


def test_an_atlas_is_the_same_as_itself():
    """Two runs of one spec are identical; every value of every variable is compared, coordinates first."""
    for spec in [
        SPEC,
        CIRCLING,
        STEADY,
        REFINED,
        REFINED.replace(alpha=[0.5, 1.0]),
        SPEC.replace(roll_rate=3, tilt=0.1),
    ]:
        atlas = sweep.run(spec)
        comparison = compare(sweep.run(spec), atlas)
        assert comparison.same, spec
        assert comparison.identical, spec
        assert comparison.cells == spec.size, spec
        assert {each.name: each.values for each in comparison.findings} == {
            name: variable.size for name, variable in atlas.variables.items()
        }, spec
        assert [each.name for each in comparison.findings][: len(atlas.coords)] == [
            name for name in spec.model.parameters if name in atlas.coords
        ], spec
        assert all(each.bitwise and each.on_edge == 0 for each in comparison.findings), spec


def test_missing_has_to_be_missing(reference):
    """A value that only one of the two atlases has is a difference; the report names both cells."""
    gap = tuple(np.argwhere(np.isnan(reference["fall_time"].values))[0])
    known = tuple(np.argwhere(np.isfinite(reference["fall_time"].values))[0])
    for place, value, told in (
        (gap, 1.0, (1.0, None)),
        (known, np.nan, (None, float(reference.fall_time[known]))),
    ):
        comparison = compare(changed(reference, "fall_time", place, value), reference)
        assert found(comparison) == {"fall_time": 1}
        worst = finding(comparison, "fall_time").worst
        assert (worst.new, worst.reference) == told
    assert FILL not in reference["fall_time"].values


def test_a_decision_that_changes_in_the_midst_differs(reference):
    """A verdict or an ending that flips far from any edge is a difference."""
    for name in ("stability", "ending"):
        place = next(
            tuple(cell)
            for cell in np.argwhere(reference[name].values == 1)
            if (reference[name].values[max(0, cell[0] - 1) : cell[0] + 2, cell[1]] == 1).all()
        )
        assert found(compare(changed(reference, name, place, 2), reference)) == {name: 1}


def test_a_verdict_may_flip_on_the_edge_alone(reference):
    """A cell whose departure is the criterion's limit may have any verdict; its neighbor may not."""
    place = tuple(np.argwhere(reference["stability"].values == STABLE)[0])
    reach = float(reference["peak_tilt"].values[place])
    edge = sweep.reclassify(reference, f"departure:{reach!r}rad")
    # the limit is within the cell's error, so the verdict is undecided
    assert edge["stability"].values[place] == UNDECIDED
    for verdict in (STABLE, UNSTABLE):
        new = changed(edge, "stability", place, verdict)
        comparison = compare(new, edge)
        assert comparison.same
        assert finding(comparison, "stability").on_edge == 1
        assert_facts(in_words(comparison), "1 borderline cell")
    # an ending that no neighbor has excuses no verdict
    assert found(compare(changed(new, "ending", place, 77), edge)) == {"ending": 1, "stability": 1}
    # with the limit 1e-4 rad further away, the flip is not a matter of rounding
    inside = sweep.reclassify(reference, f"departure:{reach + 1e-4!r}rad")
    assert found(compare(changed(inside, "stability", place, UNSTABLE), inside)) == {"stability": 1}


def test_the_boundary_may_move_with_a_cell_on_the_edge(reference):
    """If a cell on the edge flips, its row's boundary may move by a cell; other rows' boundaries may not."""
    rows = np.flatnonzero(np.isfinite(reference["boundary_roll_rate"].values))
    row = int(rows[0])
    first = int(np.argmax(reference["stability"].values[:, row] == STABLE))
    reach = float(reference["peak_tilt"].values[first, row])
    edge = sweep.reclassify(reference, f"departure:{reach!r}rad")
    new = changed(edge, "stability", (first, row), UNSTABLE)
    moved = changed(new, "boundary_roll_rate", row, float(edge["boundary_roll_rate"][row]) + 0.25)
    comparison = compare(moved, edge)
    assert comparison.same
    assert finding(comparison, "boundary_roll_rate").on_edge == 1
    # lines of theory do not depend on cells and are never excused
    assert found(compare(changed(moved, "predicted_roll_rate", row, 9.0), edge)) == {"predicted_roll_rate": 1}
    other = int(rows[-1])
    assert found(compare(changed(new, "boundary_roll_rate", other, 9.0), edge)) == {"boundary_roll_rate": 1}


def test_an_ending_may_flip_beside_its_like(reference):
    """A bounded cell next to a fall may fall, with all consequences; one amid bounded cells may not."""
    codes = {name: code for code, name in VARIABLES["ending"].flags.items()}
    fell = reference["ending"].values == codes["fell"]
    beside = np.zeros_like(fell)
    beside[1:] |= fell[:-1]
    place = tuple(np.argwhere(beside & ~fell)[0])
    fallen = reference
    for name, value in {
        "ending": codes["fell"],
        "stability": UNSTABLE,
        "tilt_max": 1.48,
        "fall_time": 1.0,
    }.items():
        fallen = changed(fallen, name, place, value)
    comparison = compare(fallen, reference)
    assert comparison.same
    assert finding(comparison, "ending").on_edge == 1
    apart = tuple(np.argwhere(~beside & ~fell)[-1])
    assert "ending" in found(compare(changed(reference, "ending", apart, codes["fell"]), reference))


def test_other_units_or_codes_mean_another_thing(reference):
    """Other units, or flags with other meanings, are a difference."""
    for name, key, value in (("tilt_max", "units", "degree"), ("stability", "flag_meanings", "a b c")):
        copy = reference.copy(deep=True)
        copy[name].attrs[key] = value
        for exact in (False, True):
            comparison = compare(copy, reference, exact=exact)
            assert list(found(comparison)) == [name]
            assert value in finding(comparison, name).note


def test_what_the_reference_has_of_its_cells_the_new_atlas_must_have(reference):
    """A measure that only the reference has is a difference; one that only the new atlas has is only noted.

    So a run with contact=yes passes against a reference without it.
    """
    comparison = compare(reference.drop_vars("nutation_period"), reference)
    assert found(comparison) == {"nutation_period": SPEC.size}
    assert finding(comparison, "nutation_period").note
    comparison = compare(reference, reference.drop_vars("nutation_period"))
    assert comparison.same
    assert not comparison.identical
    (note,) = comparison.notes
    assert_facts(note, "nutation_period", "not compared", "reference")
    assert_facts(in_words(comparison), note)
    forces = sweep.run(SPEC.replace(contact="yes"))
    assert found(compare(reference, forces)) == dict.fromkeys(tables.CONTACT_VARIABLES, SPEC.size)
    comparison = compare(forces, reference)
    assert comparison.same
    for name in tables.CONTACT_VARIABLES:
        assert with_facts(comparison.notes, name, "not compared")


def test_a_boundary_that_one_does_not_have(reference):
    """An edge that only one of the two atlases has is a difference, because edges are not optional.

    A missing boundary that every atlas has is computed again from the verdicts.
    """
    more = reference.assign(boundary_lower_roll_rate=reference["boundary_roll_rate"])
    for new, trusted in ((reference, more), (more, reference)):
        assert list(found(compare(new, trusted))) == ["boundary_lower_roll_rate"]
    assert compare(reference, reference.drop_vars("boundary_roll_rate")).same


def test_provenance_is_listed_and_not_judged(reference):
    """Differences in author, date and wording are listed as provenance and are not judged."""
    copy = reference.copy(deep=True)
    copy.attrs.update(history="another day", kernel_hash="0", title="Mine")
    copy["tilt_max"].attrs["long_name"] = "greatest tilt"
    comparison = compare(copy, reference)
    assert comparison.same
    assert comparison.provenance.keys() == {"history", "kernel_hash", "title", "tilt_max:long_name"}
    assert comparison.provenance["title"] == ("Mine", reference.attrs["title"])


def test_another_model_or_criterion_is_refused(reference):
    """Atlases of other disks, starts or criteria are refused, also with `common`; the message names the difference."""
    for changes, fields in [
        ({"alpha": 1.0}, {"alpha": ("1", "0.5")}),
        ({"fall_tilt": 1.4835298642}, {"fall_tilt": ("1.4835298642", "1.4835298641951")}),
        ({"radius": 1.0, "gravity": 1.62}, {"radius": ("1", "0.5"), "gravity": ("1.62", "9.81")}),
        ({"criterion": "departure:2deg"}, {"criterion": ("departure:2deg", "departure:5deg")}),
        ({"method": "exact"}, {"method": ("exact", "rk4")}),
        (
            {"duration": 100.0, "fall_tilt": 1.0},
            {"duration": ("100", "300"), "fall_tilt": ("57.29577951deg", "85deg")},
        ),
        ({"roll_rate": "steady", "precession_rate": "1:2:13"}, {"roll_rate": ("steady", "0:3:13")}),
    ]:
        other = sweep.run(SPEC.replace(**changes))
        for common in (False, True):
            with refused("differ in") as refusal:
                compare(other, reference, common=common)
            message = refusal.value.message
            differing = re.findall(r"(\w+) \(([^ ]+) and ([^ ]+)\)", message)
            assert [name for name, _, _ in differing] == list(fields), (changes, fields)
            for name, new, old in differing:
                assert new.startswith(fields[name][0]), (changes, fields)
                assert old.startswith(fields[name][1]), (changes, fields)


def test_another_option_of_the_model_is_refused(monkeypatch):
    """Atlases with another model option are refused, unless the option only adds variables."""
    words, grip = SPEC.words(), Word("grip", "what the plane is made of", "rough", ("rough", "icy"))
    for decides in (True, False):
        options = table(*tables.OPTIONS.values(), replace(grip, decides=decides))
        monkeypatch.setattr(type(DISK), "options", options)
        rough = sweep.SweepSpec(**words)
        reference = sweep.run(rough)
        other = sweep.run(rough.replace(grip="icy"))
        if decides:
            with refused("grip", "icy and rough"):
                compare(other, reference)
        else:
            assert compare(other, reference).same


def test_another_grid_is_refused_unless_the_common_part_will_do(reference):
    """With `common`, shared cells are compared; a note lists what is skipped because it needs whole axes."""
    finer = sweep.run(SPEC.replace(roll_rate="0:3:25", alpha="0.5,1"))
    with refused("roll_rate (0:3:25 and 0:3:13)", "alpha (0.5,1 and 0.5)", "--common"):
        compare(finer, reference)
    comparison = compare(finer, reference, common=True)
    assert comparison.same
    assert comparison.cells == SPEC.size
    assert with_facts(comparison.notes, "boundary_roll_rate", "not compared")
    place = int(np.flatnonzero(np.isclose(finer["roll_rate"], 0.25))[0])
    wrong = changed(finer, "tilt_max", (place, 2, 0), 0.0)
    worst = finding(compare(wrong, reference, common=True), "tilt_max").worst
    assert worst.where == {
        "roll_rate": float(reference["roll_rate"][1]),
        "tilt": float(reference["tilt"][2]),
        "alpha": 0.5,
    }
    with refused("tilt"):
        compare(sweep.run(SPEC.replace(tilt="1deg,2deg")), reference, common=True)


def test_the_order_of_axes_is_part_of_the_grid(reference):
    """A transposed atlas has another grid, but its common cells are the same."""
    turned = sweep.run(SPEC.replace(axes=("tilt", "roll_rate")))
    with refused("axes", "tilt,roll_rate", "roll_rate,tilt", "--common"):
        compare(turned, reference)
    assert compare(turned, reference, common=True).same
    place = (1, 3)
    assert found(compare(changed(turned, "tilt_max", place, 1.0), reference, common=True)) == {"tilt_max": 1}


def test_another_step_is_compared_by_its_results(reference):
    """With another step, the costs are not compared, but the measures are."""
    comparison = compare(sweep.run(SPEC.replace(tolerance=1e-9)), reference)
    assert comparison.same
    assert {"steps", "energy_drift"}.isdisjoint(each.name for each in comparison.findings)
    assert any(not missing(each, ["steps", "tolerance"]) for each in comparison.notes)
    # a coarse atlas is as accurate as it states, and not better
    coarse = compare(sweep.run(SPEC.replace(tolerance=0.01, step=0.1)), reference)
    assert coarse.same
    assert 1e-4 < finding(coarse, "tilt_max").largest < finding(coarse, "tilt_max").allowed
    assert coarse.provenance["sweep_spec:step"] == ("0.1", "auto")


def test_other_kernels_are_compared_by_their_results(reference):
    """With other kernels, steps and errors are not compared, but everything else is."""
    new = changed(reference, "steps", (2, 2), 10**6).assign_attrs(kernel_hash="0")
    comparison = compare(new, reference)
    assert comparison.same
    assert any(not missing(each, ["steps", "kernels"]) for each in comparison.notes)
    assert found(compare(changed(new, "nutation_period", (2, 2), 1.0), reference)) == {"nutation_period": 1}


def test_events_are_counted_exactly():
    """The same kernels must count the same switches of dry friction; other kernels may count differently."""
    lossy = sweep.run(
        sweep.SweepSpec(contour_friction="0.3mm", tilt="20deg:80deg:5", roll_rate="1,2", duration="5s")
    )
    place = (0, 0)
    more = changed(lossy, "switches", place, int(lossy["switches"][place]) + 2)
    assert found(compare(more, lossy)) == {"switches": 1}
    assert compare(more.assign_attrs(kernel_hash="0" * 64), lossy).same


def test_a_tolerance_of_the_caller_takes_the_place_of_what_is_stated(reference):
    """The caller's tolerance for a variable, in SI or with a unit, wider or narrower, replaces the stated one."""
    place = (2, 2)
    value = float(reference["tilt_max"][place])
    new = changed(changed(reference, "tilt_max", place, value + 1e-6), "peak_tilt", place, value + 1e-9)
    assert found(compare(new, reference)) == {"tilt_max": 1}
    for wide in ({"tilt_max": 1.1e-6}, {"tilt_max": "0.0001deg"}):
        comparison = compare(new, reference, tolerances=wide)
        assert comparison.outcome == "within tolerance"
        assert_facts(finding(comparison, "tilt_max").reason, "given")
    narrow = compare(new, reference, tolerances={"tilt_max": "1arcmin", "peak_tilt": 1e-10})
    assert found(narrow) == {"peak_tilt": 1}
    # a requested variable is compared even for other kernels
    other = changed(reference, "steps", place, 10**6).assign_attrs(kernel_hash="0")
    assert compare(other, reference).same
    assert found(compare(other, reference, tolerances={"steps": 5})) == {"steps": 1}


def test_a_tolerance_that_cannot_be_is_refused(reference):
    """Unknown names, flags, coordinates, wrong units and invalid sizes are refused with the reason."""
    for tolerances, message in [
        ({"tilt_mx": 1.0}, ["tilt_mx", "tilt_max?"]),
        ({"stability": 1.0}, ["stability=1.0", "tilt_min"]),
        ({"tilt": 1.0}, ["tilt=1.0", "tilt_min"]),
        ({"tilt_max": -1.0}, ["tilt_max", "0", "-1.0"]),
        ({"tilt_max": "1s"}, ["tilt_max", "s", "deg", "arcmin"]),
        ({"tilt_max": "nan"}, ["tilt_max=nan", "finite"]),
        ({"tilt_max": "1,2"}, ["tilt_max=1,2", "one number"]),
    ]:
        with refused(*message):
            compare(reference, reference, tolerances=tolerances)


def test_exact_means_bits(reference):
    """With `exact`, one different bit of any variable is a difference; otherwise it is within the tolerance."""
    for name in ("nutation_period", "tilt_error", "steps", "predicted_roll_rate", "tilt"):
        values = reference[name].values.copy()
        place = tuple(np.argwhere(np.isfinite(values) & (values != 0))[0])
        bit = 1 if values.dtype.kind == "i" else np.spacing(values[place])
        values[place] += bit
        new = reference.assign({name: reference[name].copy(data=values)})
        assert compare(new, reference).outcome == "within tolerance", name
        comparison = compare(new, reference, exact=True)
        assert (comparison.outcome, found(comparison)) == ("different", {name: 1})
    same = compare(reference.assign_attrs(history="another day"), reference, exact=True)
    assert (same.outcome, list(same.provenance)) == ("identical", ["history"])
    # the sign of a zero counts as a bit; NaN equals NaN
    zero = changed(reference, "tilt_min", (2, 2), 0.0)
    assert found(compare(changed(zero, "tilt_min", (2, 2), -0.0), zero, exact=True)) == {"tilt_min": 1}
    assert compare(changed(zero, "tilt_min", (2, 2), -0.0), zero).outcome == "within tolerance"
    forces = sweep.run(SPEC.replace(contact="yes"))
    assert set(found(compare(forces, reference, exact=True))) == set(tables.CONTACT_VARIABLES)
    with refused("exact", "tolerances"):
        compare(reference, reference, exact=True, tolerances={"tilt_max": 1.0})


def test_a_file_of_another_program_keeps_its_fixed_parameters(reference):
    """Fixed parameters are coordinates even if the attribute that lists them was dropped."""
    assert compare(reference.reset_coords(["alpha", "radius"]), reference).identical


@pytest.fixture(scope="module")
def refined():
    """Return `reference` with a bisected boundary and curves."""
    return sweep.run(REFINED)


def test_a_moved_curve_differs(refined):
    """A point of a curve that moved beyond its tolerance is a difference, and the report names it."""
    comparison = compare(changed(refined, "curve_tilt", 2, float(refined.curve_tilt[2]) + 1e-3), refined)
    assert found(comparison) == {"curve_tilt": 1}
    assert finding(comparison, "curve_tilt").worst.where == {"curve_point": 2.0}
    assert_facts(in_words(comparison), "curve_point 2")


def test_a_curve_of_other_length_differs(refined):
    """Curves of different lengths differ, and the report states the lengths."""
    comparison = compare(refined.isel(curve_point=slice(1, None)), refined)
    assert set(found(comparison)) == {
        "curve_roll_rate", "curve_roll_rate_halfwidth", "curve_tilt", "curve_tilt_halfwidth",
    }  # fmt: skip
    length = refined.sizes["curve_point"]
    assert_facts(finding(comparison, "curve_tilt").note, f"{length - 1}", f"{length}")


def test_curves_move_with_a_cell_that_flips_on_an_edge(refined):
    """If a cell may be stable or unstable, the curves around it may move."""
    stable = refined["stability"].values == STABLE
    place = tuple(np.argwhere(stable)[np.argmax(refined["tilt_max"].values[stable])])
    edge = sweep.reclassify(refined, f"departure:{float(refined['tilt_max'].values[place])!r}rad")
    moved = changed(changed(edge, "stability", place, UNSTABLE), "curve_tilt", 0, 9.0)
    comparison = compare(moved, edge)
    assert comparison.same
    assert finding(comparison, "curve_tilt").on_edge == 1


def test_brackets_of_any_width_have_to_overlap(reference, refined):
    """Of a boundary between cells and a bisected one only the brackets are compared, not half-widths and curves."""
    for new, old in ((reference, refined), (refined, reference)):
        comparison = compare(new, old)
        assert comparison.same
        names = {each.name for each in comparison.findings}
        assert not any(name.startswith("curve_") or name.endswith("_halfwidth") for name in names)
        assert {"tilt_max", "predicted_roll_rate", "critical_roll_rate"} <= names
        halfwidths = float((reference.boundary_roll_rate_halfwidth + refined.boundary_roll_rate_halfwidth)[0])
        boundary = finding(comparison, "boundary_roll_rate")
        assert 0.0 < boundary.largest < boundary.allowed == pytest.approx(halfwidths, rel=1e-9)
        told = [note for note in comparison.notes if "boundary differs" in note]
        assert len(told) == 1 + sum(name.startswith("curve_") for name in refined.data_vars)
        place = int(np.flatnonzero(np.isfinite(new["boundary_roll_rate"].values))[0])
        beyond = float(old["boundary_roll_rate"][place]) + 1.001 * halfwidths
        assert found(compare(changed(new, "boundary_roll_rate", place, beyond), old)) == {
            "boundary_roll_rate": 1
        }


def test_another_steady_rate_is_another_motion():
    """The slow and the fast steady precession are not compared, and neither are a computed and a given rate."""
    slow = sweep.run(STEADY)
    for other in (STEADY.replace(precession_rate="steady-fast"), CIRCLING):
        with refused("precession_rate"):
            compare(slow, sweep.run(other))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gravity", 3.7),
        ("duration", 3.0),
        ("radius_units", "mm"),
        ("method", "exact"),
        ("criterion", "departure:9deg"),
    ],
)
def test_an_attribute_that_was_changed_is_refused(reference, name, value):
    """Attributes that contradict the spec are refused in either atlas, with the name of the file."""
    wrong = reference.assign_attrs({name: value})
    for pair in ((wrong, reference), (reference, wrong)):
        with refused(name, str(value), str(reference.attrs[name])):
            compare(*pair)
