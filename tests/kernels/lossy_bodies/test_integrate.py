"""Bodies with losses, compared with Newton and Euler in space, the thin disk, and the limits of friction."""

import math

import lossy_runner
import numpy as np
import pytest
from body_referee import Body
from lossy_body_referee import ARMS, LEDGER, Lossy, drawn_lossy, run, scaled, some, starts
from lossy_referee import starts as starts_of_disk

from kernels.lossy_disk.arrays import MEASURES, MOFFATT
from kernels.lossy_disk.endings import (
    EDGE_CHANGE,
    FLAT,
    HORIZON,
    INVALID,
    REST,
    SLIP,
    UNDISTURBED,
    UNRESOLVED,
)

TORUS = {"tube": 0.25, "axial_moment": 0.609375, "transverse_moment": 0.3203125}
RIM = {"thickness": 0.3, "fillet": 0.05, "axial_moment": 0.49, "transverse_moment": 0.255}

#: Values with a stated error, and the measure that states it.
STATED = {
    "end_time": "time_error", "end_tilt": "tilt_error", "tilt_min": "tilt_error", "tilt_max": "tilt_error",
    "heading_turned": "heading_error", "path_length": "path_error",
}  # fmt: skip


@pytest.mark.slow_lane
def test_random_motions_are_those_of_newton_and_euler(count, pick):
    """Until dry friction reverses, time, tilts, heading, path and losses by law agree."""
    rng = np.random.default_rng(31)
    checked = dict.fromkeys(pick(("torus", "rounded", "rim", "arc"), 1), 0)
    while min(checked.values()) < count(1, 4):
        name = min(checked, key=checked.get)
        words, lossy = drawn_lossy(name, rng)
        found = run(
            starts(**words),
            name,
            duration=3.0,
            tolerance=1e-9,
            air_law=MOFFATT * (name in ("rounded", "rim")),
        )
        if found.switches[0] or found.ending[0] not in (FLAT, HORIZON, EDGE_CHANGE):
            continue
        motion, tilts = lossy.follow(scaled(words), 3.0)
        if motion.t_events[1].size or motion.t_events[2].size:
            continue
        expected = dict(zip(LEDGER, motion.y[6:, -1], strict=True)) | {
            "end_time": motion.t[-1], "end_tilt": tilts[1], "tilt_min": tilts.min(), "tilt_max": tilts.max(),
        }  # fmt: skip
        assert lossy.energy(motion.y[:, -1]) == pytest.approx(lossy.energy(motion.y[:, 0]), abs=1e-9)
        for measure, value in expected.items():
            allowed = 2.0 * getattr(found, STATED[measure])[0] if measure in STATED else 1e-8
            assert abs(getattr(found, measure)[0] - value) < allowed + 1e-9, (measure, name, words)
        checked[name] += 1


@pytest.mark.compiled
def test_a_torus_without_a_tube_is_the_thin_disk():
    """Random starts with all laws agree with the disk's own kernel, even while dry friction holds."""
    rng, n = np.random.default_rng(32), 96
    calm = np.where(rng.random(n) < 0.3, 0.1, 1.0)
    words = {name: calm * rng.normal(size=n) for name in ("precession_rate", "roll_rate")}
    words |= {
        "tilt": calm * rng.uniform(-1.3, 1.3, n),
        "tilt_rate": calm * rng.normal(0.0, 0.3, n) * (rng.random(n) < 0.7),
    }
    drawn = [some(rng, (*ARMS, "contour_damping"), -3.0, -0.5) for _ in range(n)]
    words |= {name: np.array([each[name] for each in drawn]) for name in drawn[0]}
    words |= {"friction": np.where(rng.random(n) < 0.5, 1.0, np.inf)}
    disk = lossy_runner.run(starts_of_disk(**words), duration=20.0)
    hoop = run(
        starts(n, axial_moment=0.5, transverse_moment=0.25, **words), "torus", duration=20.0,
        flat_tilt=lossy_runner.FLAT_TILT,
    )  # fmt: skip
    assert (disk.ending == hoop.ending).all()
    assert (disk.switches == hoop.switches).all()
    assert {FLAT, REST, HORIZON, SLIP} <= set(disk.ending)
    for name in MEASURES:
        apart, ours, theirs = 1e-8, getattr(hoop, name), getattr(disk, name)
        if name in STATED:
            apart = 1e-10 + getattr(disk, STATED[name]) + getattr(hoop, STATED[name])
        if not name.endswith("error") and name != "energy_imbalance":
            assert (np.isnan(ours) == np.isnan(theirs)).all(), name
            assert np.nanmax(np.abs(ours - theirs) / apart, initial=0.0) < 1.0, name


@pytest.mark.slow_lane
def test_friction_that_stops_and_turns_round_is_the_limit_of_a_steep_one():
    """Against ever steeper smooth friction, the difference from the set-valued laws falls proportionally."""
    words = {**TORUS, "tilt": 0.214, "precession_rate": 1.922, "roll_rate": 0.492}
    laws = {"rolling_friction": 0.069, "pivoting_friction": 0.053, "contour_friction": 0.106}
    found = run(starts(**words, **laws), "torus", duration=4.0, tolerance=1e-10)
    assert found.switches[0] == 3
    apart = []
    for soft in (1e-3, 1e-4):
        lossy = Lossy(Body(0.75, 0.0, 0.25, 0.609375, 0.3203125), *laws.values(), soft=soft)
        motion, tilts = lossy.follow(scaled({"tilt_rate": 0.0, **words}), 4.0, method="Radau", accuracy=1e-7)
        assert found.end_time[0] == pytest.approx(motion.t[-1], abs=20.0 * soft)
        ledger = [getattr(found, name)[0] for name in LEDGER]
        apart.append(np.abs(np.array([*ledger, found.end_tilt[0]]) - [*motion.y[6:, -1], tilts[1]]).max())
    assert apart[0] < 0.05
    assert apart[1] < 0.2 * apart[0]


def test_a_body_that_turns_where_it_stands_comes_to_the_brink_as_it_slows():
    """A turning arc off its center slows until its weight, with a longer lever than friction's arm, tilts it."""
    words = {"fillet": 0.9, "offset": 0.1, "axial_moment": 0.5, "transverse_moment": 0.3, "tilt": 0.5}
    S, C = math.sin(0.5), math.cos(0.5)
    lever = 0.1 * S - 0.1 * C
    turning = math.sqrt(-lever / (0.2 * S * C + (0.1 * C + 0.1 * S + 0.9) * lever))
    laws = {"rolling_friction": -0.7 * lever, "pivoting_friction": 0.02}
    words |= {"precession_rate": turning, "roll_rate": 0.0, "tilt_rate": 0.0}
    given = starts(**words, **laws)
    assert run(given, "arc", duration=1.0).ending[0] == HORIZON
    assert run(given, "arc", duration=40.0).ending[0] == UNRESOLVED


def test_rolling_friction_holds_where_the_weight_has_a_shorter_lever():
    """The lever at rest is c S - d C; a body stands while it is below the arm, on either side."""
    core, shift = 1.0 - RIM["fillet"], 0.5 * RIM["thickness"] - RIM["fillet"]
    tilts = np.linspace(0.02, 0.5, 49)
    found = run(starts(49, **RIM, tilt=tilts, rolling_friction=0.05), "rim", duration=0.5)
    lever = core * np.sin(tilts) - shift * np.cos(tilts)
    assert ((found.ending == REST) == (np.abs(lever) <= 0.05)).all()
    assert 5 < np.count_nonzero(found.ending == REST) < 40


def test_endings_of_starts_without_a_motion():
    """Starts on two edges, undisturbed, flat, impossible, and rings with air get their endings."""

    def ending(body, **words):
        air = MOFFATT if words.get("air_viscosity") else 0.0
        return run(starts(**{"contour_friction": 1e-3, "roll_rate": 1.0, **words}), body, air_law=air).ending[
            0
        ]

    assert ending("rim", **RIM, tilt=0.0) == EDGE_CHANGE
    upright = run(starts(contour_friction=1e-3, roll_rate=1.0, tilt=0.0, **RIM), "rim")
    assert (upright.end_time[0], upright.end_tilt[0]) == (0.0, 0.0)
    assert ending("torus", **TORUS, tilt=0.0) == UNDISTURBED
    # an arc off its center tilts at once
    round_edge = {"fillet": 0.2, "axial_moment": 0.4, "transverse_moment": 0.3}
    assert ending("arc", **round_edge, tilt=0.0) == UNDISTURBED
    assert ending("arc", **round_edge, offset=-0.2, tilt=0.0) != UNDISTURBED
    assert ending("torus", **TORUS, tilt=1.55) == FLAT
    assert ending("torus", **TORUS, tilt=0.1, rolling_friction=-1.0) == INVALID
    assert ending("torus", **TORUS, tilt=0.1, air_viscosity=1e-3) == INVALID
    assert ending("rim", **RIM, tilt=0.1, air_viscosity=1e-3) != INVALID


def test_a_rim_stops_at_the_tilt_of_both_edges():
    """A rim falls back onto its other edge if its weight is between them, and so does its mirror image."""
    words = {**RIM, "rolling_friction": 1e-3, "contour_friction": 1e-3, "roll_rate": 0.3}
    found = run(starts(2, **words, tilt=[0.05, -0.05]), "rim")
    assert found.ending.tolist() == [EDGE_CHANGE, EDGE_CHANGE]
    assert np.abs(found.end_tilt).max() < 1e-12
    assert found.end_time[0] == found.end_time[1]
    assert found.rolling_loss[0] == found.rolling_loss[1] > 0.0


@pytest.mark.compiled
def test_the_ledger_closes():
    """For random starts of all bodies, losses and remaining energy add up within the tolerance."""
    rng, rested = np.random.default_rng(33), 0
    for name in ("torus", "rounded", "rim"):
        cells, bodies = zip(*(drawn_lossy(name, rng, -0.5) for _ in range(200)), strict=True)
        given = np.concatenate([starts(**words) for words in cells], axis=1)
        found = run(given, name, air_law=MOFFATT * (name in ("rounded", "rim")))
        assert np.mean(found.ending == UNRESOLVED) < 0.02
        known = found.ending != UNRESOLVED
        assert found.energy_imbalance[known].max() <= 1e-8
        # at rest only the height is left
        for cell in np.flatnonzero(found.ending == REST):
            words, lossy = cells[cell], bodies[cell]
            nothing = np.zeros(len(LEDGER))
            first = lossy.energy(np.concatenate([lossy.body.start(*scaled(words)), nothing]))
            last = lossy.energy(np.concatenate([lossy.body.start(found.end_tilt[cell], 0, 0, 0), nothing]))
            taken = sum(getattr(found, each)[cell] for each in LEDGER[2:])
            assert first - last == pytest.approx(taken, abs=2e-8)
            rested += 1
    assert rested > 5
