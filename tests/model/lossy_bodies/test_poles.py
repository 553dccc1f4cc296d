"""Atlases of balls and spheroids with losses: what verify says of them, and what explain says."""

import numpy as np
import pytest
from messages import assert_facts, row

import sweep
from sweep.checks.explain import explain
from sweep.checks.verify import findings, verify
from sweep.request.spec import SweepSpec

LENS = SweepSpec(
    body="spheroid", flattening="-0.4:0.4:3", tilt="10deg:80deg:5", tilt_rate=0.3, scaled_precession_rate="0.3:1.2:3",
    roll_rate=0.2, radius="37mm", mass="0.4kg", rolling_friction="50um", pivoting_friction="20um",
    contour_friction="30um", contour_damping="1e-7", criterion="departure:20deg", duration="1s",
)  # fmt: skip


@pytest.mark.slow_lane
def test_verify_agrees_and_finds_a_wrong_loss():
    """Every cell follows from itself, a sample from half the step and from DOP853; a loss that is off is told."""
    atlas = sweep.run(LENS)
    found = verify(atlas, seed=3)
    assert findings(found).passed
    assert_facts(found.attrs["audit_sample"], "8", "DOP853")
    wrong = atlas.copy(deep=True)
    wrong["contour_loss"].values[...] *= 1.0 + 1e-4
    assert not findings(verify(wrong, seed=3)).passed


def test_verify_finds_another_law_of_the_motion_itself():
    """The second computation integrates other equations: it sees a friction that the cells did not have."""
    atlas = sweep.run(LENS)
    other = sweep.run(LENS.replace(rolling_friction="51um"))
    mixed = atlas.copy(deep=True)
    for name in ("tilt_min", "tilt_max", "end_tilt", "peak_tilt", "heading_turned", "path_length"):
        mixed[name].values[...] = other[name].values
    assert not findings(verify(mixed, seed=3)).passed


def test_bodies_that_come_to_rest_leave_nothing_but_their_height():
    """A ball with its centre of mass off its centre rests near its lower pole, a prolate one near its equator."""
    laws = {"rolling_friction": "1mm", "pivoting_friction": "0.1mm", "radius": "37mm", "duration": "60s"}
    ball = SweepSpec(
        body="ball",
        offset=0.2,
        axial_moment=0.42,
        transverse_moment=0.38,
        tilt="-40deg:60deg:5",
        roll_rate=2.0,
        **laws,
    )
    egg = SweepSpec(body="spheroid", flattening=-0.5, tilt="-40deg:60deg:5", roll_rate=2.0, **laws)
    for spec, low in ((ball, -0.5 * np.pi), (egg, 0.0)):
        atlas = sweep.run(spec)
        assert {spec.model.endings.of(code).name for code in np.unique(atlas["ending"])} == {"rest"}
        assert np.abs(atlas["end_tilt"].values - low).max() < 0.2
        assert findings(verify(atlas, seed=1)).passed


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (
            {"body": "ball", "tilt": "30deg", "roll_rate": 20.0, "rolling_friction": "10um", "radius": "10mm"},
            ["rolling", "ball", "24.7184 s"],
        ),
        (
            {
                "body": "ball", "offset": 0.2, "axial_moment": 0.42, "transverse_moment": 0.38, "tilt": "89deg",
                "roll_rate": 40.0, "pivoting_friction": "10um", "radius": "22mm", "criterion": "departure:20deg",
            },
            ["pivoting friction", "spin", "15.7286 rad s-1", "50.2946 s"],
        ),
    ],
)  # fmt: skip
def test_explain_says_what_theory_says(words, told):
    """How a uniform ball stops, and how an egg loses its spin."""
    atlas = sweep.run(SweepSpec(**words, duration="5s"))
    said = row(explain(atlas, {}).text, "theory")
    assert_facts(said, *told)
