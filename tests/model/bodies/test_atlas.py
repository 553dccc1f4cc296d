"""Atlases of bodies: theory next to measurements, endings, and the commands that check them."""

import numpy as np
import pytest
from messages import assert_facts, row

import sweep
from sweep.checks.explain import explain

RINGS = {"body": "torus", "tube": "0.05,0.3", "roll_rate": "2:3:11", "tilt": "0.1deg,0.4deg"}


@pytest.fixture(scope="module")
def rings():
    """Return an atlas of two rings with a bisected boundary."""
    return sweep.run(sweep.SweepSpec(**RINGS, boundary="refined"))


def test_the_measured_boundary_is_where_theory_puts_it(rings):
    """Rolling rings and spinning coins, released or kicked, match the predicted line to 1e-6."""
    spun = {"body": "rounded", "thickness": "0.05,0.3", "precession_rate": "3:5:11"}
    released = sweep.run(sweep.SweepSpec(**spun, tilt="0.1deg", boundary="refined"))
    kicked = sweep.run(
        sweep.SweepSpec(**spun, tilt_rate="0.001", boundary="refined", criterion="amplification:10")
    )
    for atlas, axis in ((rings, "roll_rate"), (released, "precession_rate"), (kicked, "precession_rate")):
        measured, predicted = (atlas[f"{kind}_{axis}"].values for kind in ("boundary", "predicted"))
        assert np.isfinite(measured).all()
        np.testing.assert_allclose(measured, predicted, rtol=1e-6)
    words = {"tilt": "10deg", "precession_rate": "2:5:13", "roll_rate": "steady", "tilt_rate": 1e-6}
    for body in ({"body": "torus", "tube": 0.25}, {"body": "rim", "thickness": 0.2, "fillet": 0.05}):
        atlas = sweep.run(
            sweep.SweepSpec(**words, **body, criterion="amplification:30", boundary="refined", duration=2000)
        )
        measured, critical = (float(atlas[f"{kind}_precession_rate"]) for kind in ("boundary", "critical"))
        assert measured == pytest.approx(critical, rel=2e-3)
        assert measured > critical


def test_the_ball_falls_from_its_end_where_theory_says():
    """As the start approaches the vertical, the boundary approaches the linear motion's, 0.7448445990."""
    words = {"body": "ball", "offset": 0.2, "axial_moment": 0.42, "transverse_moment": 0.38}
    apart = []
    for tilt in (88.0, 89.0):
        spec = sweep.SweepSpec(
            **words, tilt=f"{tilt}deg", scaled_roll_rate="0.6:0.9:7", criterion="departure:10deg",
            boundary="refined",
        )  # fmt: skip
        atlas = sweep.run(spec)
        unit = np.sqrt(spec.radius / spec.gravity)
        assert float(atlas.critical_roll_rate) * unit == pytest.approx(0.7448445990, abs=1e-9)
        apart.append(abs(float(atlas.boundary_roll_rate) * unit - 0.7448445990))
    assert apart[1] < apart[0] < 0.02


def test_a_spheroid_upright_and_on_its_tip():
    """Oblate ones match the predicted boundary, prolate ones have none; a tip is stable from 2.2208045364."""
    for words, axis in (
        ({"roll_rate": "2:4:11", "tilt": "0.1deg"}, "roll_rate"),
        (
            {"precession_rate": "2:6:11", "tilt_rate": 0.001, "criterion": "amplification:10"},
            "precession_rate",
        ),
    ):
        spec = sweep.SweepSpec(body="spheroid", flattening="0.2,0.5", **words, boundary="refined")
        atlas = sweep.run(spec)
        measured, predicted = (atlas[f"{kind}_{axis}"].values for kind in ("boundary", "predicted"))
        np.testing.assert_allclose(measured, predicted, rtol=1e-6)
        assert sweep.findings(sweep.verify(atlas)).agreeing == atlas.ending.size
    words = {"body": "spheroid", "flattening": -0.5}
    rugby = sweep.run(sweep.SweepSpec(**words, roll_rate="0:4:5", tilt="1deg"))
    assert (rugby.stability == 1).all()
    assert np.isnan(rugby.critical_roll_rate)
    assert "swings" not in explain(rugby, {"roll_rate": 0}).text
    tip = sweep.SweepSpec(
        **words, tilt="89.99deg", scaled_roll_rate="1:4:13", criterion="departure:0.5deg", boundary="refined"
    )
    atlas, unit = sweep.run(tip), np.sqrt(tip.radius / tip.gravity)
    assert float(atlas.critical_roll_rate) * unit == pytest.approx(2.2208045364, abs=1e-9)
    assert float(atlas.boundary_roll_rate) * unit == pytest.approx(2.2208045364, rel=2e-3)
    assert (atlas.ending == 1).all()
    assert sweep.findings(sweep.verify(atlas)).agreeing == atlas.ending.size
    text = " ".join(explain(atlas, {"roll_rate": 2.0 / unit}).text.split())
    assert_facts(text, "unstable", "8.85889 rad/s", "9.83694 rad/s")


def test_every_cell_is_held_against_the_reduction(rings):
    """`verify` counts each cell and finds a changed one; method=exact agrees with the stepping method."""
    audited = sweep.verify(rings)
    found = sweep.findings(audited)
    assert found.agreeing == rings.ending.size
    assert float(np.nanmax(audited.tilt_difference)) < 1e-8
    exact = sweep.run(sweep.SweepSpec(**RINGS, method="exact"))
    for name in ("tilt_min", "tilt_max", "nutation_period"):
        np.testing.assert_allclose(exact[name], rings[name], rtol=1e-7)
    assert np.array_equal(exact.stability, rings.stability)
    moved = rings.copy(deep=True)
    moved["tilt_max"].values[0, 3, 1] *= 1.0 + 1e-5
    assert sweep.findings(sweep.verify(moved)).disagreeing == 1
    assert sweep.compare(rings, rings).same


def test_every_cell_of_the_presets_is_resolved():
    """The stated error excludes no cell near a separatrix."""
    for preset in ("egg", "torus", "thick_coin", "true_edge"):
        spec = sweep.SweepSpec.preset(preset)
        assert not np.any(sweep.run(spec).ending == spec.model.endings.code("unresolved")), preset


def test_an_atlas_has_no_length_that_its_body_lacks(rings):
    """It has no moments that follow from the body either. The lengths of its body are coordinates."""
    assert "tube" in rings.coords
    assert {"thickness", "fillet", "offset", "axial_moment"}.isdisjoint(rings.variables)
    assert "a torus" in rings.attrs["title"]
    assert rings.eulerdisk.spec.body == "torus"


def test_contact_forces_are_recorded_on_request():
    """A torus without a tube has the thin disk's forces; `verify` recomputes them; slipping is reported."""
    words = {
        "tilt": "5deg,40deg",
        "roll_rate": "1,3",
        "precession_rate": "0.5,3",
        "tilt_rate": 0.3,
        "contact": "yes",
    }
    disk = sweep.run(sweep.SweepSpec(**words, alpha=0.5))
    thin = {"body": "torus", "tube": 0, "axial_moment": 0.5, "transverse_moment": 0.25}
    for method in ("rk4", "exact"):
        hoop = sweep.run(sweep.SweepSpec(**words, **thin, method=method))
        for name in ("least_normal_force", "friction_needed", "contact_state"):
            np.testing.assert_allclose(hoop[name], disk[name], rtol=1e-6)
    assert {1, 2} <= set(disk.contact_state.values.ravel().tolist())
    spheroids = sweep.run(sweep.SweepSpec(**words, body="spheroid", flattening="-0.5,0.5"))
    assert sweep.findings(sweep.verify(spheroids)).agreeing == spheroids.ending.size
    needed = spheroids.friction_needed.values
    slips = spheroids.eulerdisk.spec.model.slipping(spheroids, 0.3)
    assert np.array_equal(slips, needed > 0.3)
    assert 0 < slips.sum() < needed.size


def test_explain_says_what_a_body_does():
    """A leaning coin comes down on its other edge: what follows is open, and no upright theory applies."""
    coin = {"body": "rim", "thickness": 0.2, "tilt": "2deg,40deg", "roll_rate": "0:4:3"}
    atlas = sweep.run(sweep.SweepSpec(**coin))
    meanings = atlas.ending.attrs["flag_meanings"].split()
    found = np.array(meanings)[np.searchsorted(atlas.ending.attrs["flag_values"], atlas.ending.values)]
    assert found[0].tolist() == ["edge_change"] * 3
    assert (atlas.tilt_min.values[0] == 0.0).all()
    text = explain(atlas, {"tilt": "2deg", "roll_rate": 2}).text
    assert_facts(text, "other edge")
    assert_facts(row(text, "reference"), "upright", "rim")
    assert_facts(" ".join(text.split()), "no steady upright motion")
    assert sweep.findings(sweep.verify(atlas)).agreeing == atlas.ending.size


def test_where_it_goes_is_recorded_on_request():
    """The path adds variables and changes no cell; `verify` recomputes it."""
    words = {"body": "torus", "tube": "0,0.3", "axial_moment": 0.5, "transverse_moment": 0.25}
    spec = sweep.SweepSpec(**words, tilt="20deg", precession_rate=2.0, roll_rate="3,5")
    plain, atlas = sweep.run(spec), sweep.run(spec.replace(path="yes"))
    assert np.array_equal(plain.tilt_max, atlas.tilt_max)
    assert "path_drift" not in plain
    assert (atlas.path_class == 1).all()
    assert (atlas.ring_inner < atlas.ring_outer).all()
    audited = sweep.verify(atlas)
    assert sweep.findings(audited).agreeing == 4
    atlas.ring_inner.values[0, 0] += 1e-6
    wrong = {each.name: each.wrong for each in sweep.findings(sweep.verify(atlas)).statements if each.wrong}
    assert wrong == {"ring_inner": 1}
