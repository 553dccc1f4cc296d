"""The starts of the disk: computed rates, the undisturbed motion, and the size of the perturbation.

Atlases with a computed precession rate are verified and compared like those with a computed roll rate.
"""

import math

import numpy as np
import pytest
import referee
from messages import assert_facts, refused

import sweep
from sweep.checks.compare import compare
from sweep.checks.verify import findings, verify
from sweep.engine.grid import whole
from sweep.errors import RequestError
from sweep.model.disk.initial_conditions import (
    circling,
    computed_rates,
)
from sweep.request.spec import SweepSpec

WORDS = {
    "roll_rate": {"roll_rate": "steady", "precession_rate": "0.5,1"},
    "precession_rate": {"precession_rate": "steady-slow", "roll_rate": "-6,-4"},
    None: {"precession_rate": 0.5, "roll_rate": 2.0},
}


def test_a_computed_rate_makes_a_disk_circle():
    """Either rate may follow from the other one and the tilt; then the disk circles at its tilt."""
    for rate in WORDS:
        spec = SweepSpec(tilt="10deg", **WORDS[rate])
        assert computed_rates(spec) == ((rate,) if rate else ()), rate
        assert circling(spec) == (rate is not None), rate
        assert spec.computed == ((rate,) if rate else ()), rate


def test_a_circling_cell_rolls_at_its_steady_rate():
    """At 10 degrees and 0.5 rad/s a uniform disk of 0.5 m radius rolls at -4.6851 rad/s, as published."""
    found = whole(SweepSpec(roll_rate="steady", tilt="10deg", precession_rate=0.5))
    assert found["roll_rate"] == pytest.approx(-4.6851, abs=5e-5)


def test_a_computed_rate_keeps_the_tilt():
    """By the equations of motion, a start with a computed precession rate has no tilt acceleration."""
    for branch in ["steady-slow", "steady-fast"]:
        found = whole(SweepSpec(tilt="2deg,10deg", roll_rate=-6.0, precession_rate=branch))
        for tilt, precession, roll in zip(
            *(found[name] for name in ("tilt", "precession_rate", "roll_rate")), strict=True
        ):
            # The terms that cancel are as large as gravity over radius.
            assert referee.accelerations((tilt, 0.0, precession, roll), 0.5, 0.5, 9.81)[0] == pytest.approx(
                0.0, abs=1e-12
            ), branch


def test_the_branches_are_the_slower_and_the_faster_rate():
    """Of the two precession rates that keep a tilt, steady-slow is the smaller in magnitude."""
    slow, fast = (
        whole(SweepSpec(tilt="2deg:20deg:5", roll_rate=-8.0, precession_rate=branch))["precession_rate"]
        for branch in ("steady-slow", "steady-fast")
    )
    assert (np.abs(slow) < np.abs(fast)).all()


def test_a_rate_that_does_not_exist_is_not_finite():
    """Without precession no roll rate keeps the tilt: only that cell has none."""
    found = whole(SweepSpec(roll_rate="steady", tilt="10deg", precession_rate="-1:1:3"))
    assert np.isfinite(found["roll_rate"]).tolist() == [True, False, True]


def test_the_wobble_keeps_its_tilt_while_its_centre_rests():
    """By the equations of motion the tilt has no acceleration and the center of mass no velocity."""
    for alpha in [0.3, 0.5, 1.0]:
        found = whole(
            SweepSpec(tilt="-60deg,20deg,89.9deg", precession_rate="wobble", roll_rate="wobble", alpha=alpha)
        )
        for tilt, precession, roll in zip(
            *(found[name] for name in ("tilt", "precession_rate", "roll_rate")), strict=True
        ):
            push = 9.81 / 0.5 + precession**2
            assert referee.accelerations((tilt, 0.0, precession, roll), alpha, 0.5, 9.81)[0] == pytest.approx(
                0.0, abs=1e-13 * push
            ), alpha
            # The contact point moves by -R f (sin, -cos)(heading); the center is R sin(tilt) (cos, sin) away
            # from it.
            assert 0.5 * (roll + precession * np.sin(tilt)) == pytest.approx(
                0.0, abs=1e-13 * abs(precession)
            ), alpha


def test_a_centre_at_rest_with_another_precession_rate_is_a_nutating_start():
    """The roll rate follows from the precession rate; the tilt accelerates; upright is disturbed."""
    spec = SweepSpec(tilt="60deg", precession_rate="5,20", roll_rate="wobble")
    found = whole(spec)
    assert (spec.axes, spec.computed) == (("precession_rate",), ("roll_rate",))
    np.testing.assert_allclose(
        found["roll_rate"], -found["precession_rate"] * np.sin(np.radians(60.0)), rtol=1e-15
    )
    assert not circling(spec)
    assert not spec.model.undisturbed(spec, found).any()
    assert spec.model.lines(spec, "precession_rate", found) == {}
    slow, fast = (
        referee.accelerations((math.radians(60.0), 0.0, p, f), 0.5, 0.5, 9.81)[0]
        for p, f in zip(found["precession_rate"], found["roll_rate"], strict=True)
    )
    assert slow > 0.0 > fast


@pytest.mark.compiled
def test_an_atlas_of_wobbles_is_verified():
    """Both computed rates are stored and compared with the wobble equations; a wrong one is found."""
    spec = SweepSpec(tilt="20deg:70deg:6", tilt_rate=1e-3, precession_rate="wobble", roll_rate="wobble")
    atlas = sweep.run(spec)
    assert findings(verify(atlas)).passed
    atlas["roll_rate"][2] += 1e-6
    assert [each.name for each in findings(verify(atlas)).wrong] == ["roll_rate"]


def perturbation(spec):
    """Return the perturbation of each start of a spec."""
    return spec.model.perturbation(spec, whole(spec))


def test_the_motion_that_is_disturbed():
    """A circling disk is disturbed at its own tilt, any other disk upright."""
    released = SweepSpec(tilt=[0.1, 0.2])
    assert released.model.undisturbed(released, whole(released)).tolist() == [0.0, 0.0]
    steady = released.replace(roll_rate="steady", precession_rate=1)
    assert steady.model.undisturbed(steady, whole(steady)).tolist() == [0.1, 0.2]
    circling, upright = (each.model.disturbed_motion(each, {"tilt": 0.1}) for each in (steady, released))
    assert_facts(circling, "circling", "tilt")
    assert_facts(upright, "upright")


def test_the_perturbation_of_a_start():
    """A release counts as its tilt, a kick e as e/W, where W^2 = 2g/((2+alpha)R) = 15.696 / s^2 by hand."""
    released = SweepSpec(tilt=-0.1)
    assert perturbation(released).tolist() == [0.1]
    for kicked in (
        SweepSpec(tilt_rate=1e-4),
        SweepSpec(tilt=0.1, tilt_rate=1e-4, roll_rate="steady", precession_rate=1),
    ):
        # The relative tolerance allows a few roundings.
        assert perturbation(kicked) == pytest.approx(1e-4 / math.sqrt(15.696), rel=1e-14)


def test_the_scale_of_a_kick():
    """A kick counts as kick / W, where W^2 = 4g/5R for the uniform disk and 2g/3R for the hoop."""
    for alpha, squared in [(0.5, 0.8), (1.0, 2 / 3)]:
        radius, gravity, kick = 0.5, 9.81, 0.01
        expected = kick / math.sqrt(squared * gravity / radius)
        # A few roundings on either side.
        kicked = SweepSpec(tilt_rate=kick, alpha=alpha, radius=radius, gravity=gravity)
        assert perturbation(kicked) == pytest.approx(expected, rel=1e-14), (alpha, squared)


def test_a_kick_and_a_release_add_as_squares():
    """0.3 and 0.4 give 0.5: for W = 1 the scale is the hypotenuse of tilt and kick."""
    both = SweepSpec(tilt=0.3, tilt_rate=0.4, alpha=1.0, radius=2.0, gravity=3.0)
    assert perturbation(both) == pytest.approx(0.5, rel=1e-15)  # rounding


def test_steady_rates_that_follow_from_nothing_are_refused():
    """At least one rate must be given, and without precession no roll rate keeps a tilt."""
    for words, key in [
        ({"roll_rate": "steady", "precession_rate": "steady-slow"}, "precession_rate"),
        ({"roll_rate": "steady"}, "precession_rate"),
        ({"roll_rate": "steady", "precession_rate": [0.0]}, "precession_rate"),
    ]:
        with pytest.raises(RequestError, match="roll_rate=steady") as caught:
            SweepSpec(tilt=0.1, **words)
        assert caught.value.where == key, (words, key)
        assert caught.value.hint, (words, key)


def test_circling_may_pass_through_zero_precession():
    """An axis of precession rates through 0 is accepted; only the cell at 0 is invalid."""
    for axis in ("-1:1:3", "0:5:6", "-5:0:6"):
        assert circling(SweepSpec(roll_rate=" steady ", precession_rate=axis, tilt=0.1)), axis


GRID = {
    "tilt": "-30deg:30deg:8", "roll_rate": "-8:8:10", "tilt_rate": 1e-4, "criterion": "amplification:10",
}  # fmt: skip


@pytest.fixture(scope="module")
def branches():
    """Return the atlases of both branches, and the atlas of the same tilts by precession rate."""
    found = {branch: sweep.run(sweep.SweepSpec(**GRID, precession_rate=branch)) for branch in
             ("steady-slow", "steady-fast")}  # fmt: skip
    words = GRID | {"roll_rate": "steady", "precession_rate": "-4:4:10"}
    return found | {"by precession": sweep.run(sweep.SweepSpec(**words))}


@pytest.mark.compiled
def test_every_cell_is_verified(branches):
    """Existing motions agree with the exact reduction, the others are invalid; no cell is skipped."""
    for branch in ["steady-slow", "steady-fast"]:
        atlas = branches[branch]
        found = findings(verify(atlas))
        missing = int(np.isnan(atlas["precession_rate"]).sum())
        assert missing > 0, branch
        assert found.counts["agrees"] + found.counts["invalid"] == found.cells == 80, branch
        assert found.counts["invalid"] == missing, branch
        assert found.passed, branch


@pytest.mark.compiled
def test_a_wrong_precession_rate_is_caught(branches):
    """The computed precession rate of each cell is compared with the formula."""
    atlas = branches["steady-slow"].copy(deep=True)
    place = tuple(np.argwhere(np.isfinite(atlas["precession_rate"].values))[5])
    atlas["precession_rate"].values[place] *= 1.0 + 1e-6
    found = findings(verify(atlas))
    assert (found.counts["contradictory"], found.disagreeing) == (1, 1)


@pytest.mark.compiled
def test_branches_are_compared(branches):
    """A branch equals itself in every variable; two branches or two forms of start are not comparable."""
    atlas = branches["steady-slow"]
    comparison = compare(atlas, atlas)
    assert comparison.same
    assert comparison.identical
    assert {each.name for each in comparison.findings} == set(atlas.variables)
    for other, fields in (
        ("steady-fast", ["precession_rate", "steady-slow and steady-fast"]),
        (
            "by precession",
            ["precession_rate", "steady-slow and -4:4:10", "roll_rate", "-8:8:10 and steady"],
        ),
    ):
        with pytest.raises(RequestError) as refusal:
            compare(atlas, branches[other])
        assert all(field in refusal.value.message for field in fields)
        assert ("roll_rate" in refusal.value.message) == ("roll_rate" in fields)
        with refused("precession_rate"):
            compare(branches[other], atlas, common=True)
