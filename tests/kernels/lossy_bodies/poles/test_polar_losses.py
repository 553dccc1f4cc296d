"""Balls and spheroids with losses, against Newton and Euler in space, closed forms, and what friction can hold."""

import math
from dataclasses import replace

import body_runner
import numpy as np
import pytest
from body_referee import UP, Body, cross
from lossy_body_referee import LEDGER, run, scaled, starts
from lossy_pole_referee import Polar, drawn_polar

from kernels.bodies import arrays as of_bodies
from kernels.lossy_disk.arrays import MOFFATT
from kernels.lossy_disk.endings import HORIZON, INVALID, REST, SLIP, UNDISTURBED, UNRESOLVED

EGG = {"offset": 0.2, "axial_moment": 0.42, "transverse_moment": 0.38}
BALL = {"axial_moment": 0.4, "transverse_moment": 0.4}

#: Values whose error a cell states, and by which measure.
STATED = {
    "end_time": "time_error", "end_tilt": "tilt_error", "tilt_min": "tilt_error", "tilt_max": "tilt_error",
    "heading_turned": "heading_error", "path_length": "path_error",
}  # fmt: skip


def drawn_many(name, n, seed, most=-1.3):
    """Return the words, referees and starts of bodies at random."""
    rng = np.random.default_rng(seed)
    words, bodies = zip(*(drawn_polar(name, rng, most) for _ in range(n)), strict=True)
    return words, bodies, np.concatenate([starts(**each) for each in words], axis=1)


@pytest.mark.slow_lane
@pytest.mark.parametrize("name", ["ball", pytest.param("spheroid", marks=pytest.mark.release)])
def test_random_motions_are_those_of_newton_and_euler(name):
    """Until dry friction turns round: tilts, heading, way, and what each law took."""
    words, bodies, given = drawn_many(name, 14, 41)
    found, checked = run(given, name, duration=4.0), 0
    for cell in np.flatnonzero((found.switches == 0) & (found.ending == HORIZON)):
        motion, tilts = bodies[cell].follow(scaled(words[cell]), 4.0)
        expected = dict(zip(LEDGER, motion.y[6:, -1], strict=True)) | {
            "end_time": motion.t[-1], "end_tilt": tilts[1], "tilt_min": tilts.min(), "tilt_max": tilts.max(),
        }  # fmt: skip
        assert bodies[cell].energy(motion.y[:, -1]) == pytest.approx(
            bodies[cell].energy(motion.y[:, 0]), abs=1e-9
        )
        for measure, value in expected.items():
            allowed = 2.0 * getattr(found, STATED[measure])[cell] if measure in STATED else 3e-8
            assert abs(getattr(found, measure)[cell] - value) < allowed + 1e-9, (measure, words[cell])
        checked += 1
    assert checked > 8


@pytest.mark.parametrize("name", ["ball", "spheroid"])
def test_without_losses_it_is_the_motion_of_the_other_engine(name):
    """The extreme tilts of motions that pass near both poles are those found in other variables."""
    rng, n = np.random.default_rng(42), 40
    bodies = [body_runner.drawn(name, rng) for _ in range(n)]
    words = {each: np.array([lengths[each] for lengths, _, _ in bodies]) for each in bodies[0][0]}
    words |= {
        "axial_moment": np.array([moments[0] for _, moments, _ in bodies]),
        "transverse_moment": np.array([moments[1] for _, moments, _ in bodies]),
        "tilt": rng.uniform(-1.5, 1.5, n), "tilt_rate": rng.normal(0.0, 0.5, n),
        "precession_rate": rng.normal(size=n), "roll_rate": rng.normal(size=n),
    }  # fmt: skip
    found = run(starts(n, **words), name, duration=200.0)
    other = body_runner.run(starts(n, **words)[: len(of_bodies.PARAMETERS)], name, duration=200.0)
    known = (found.ending == HORIZON) & (other.period < 100.0)
    assert known.sum() > n / 2
    for ours, theirs in ((found.tilt_min, other.least), (found.tilt_max, other.greatest)):
        apart = np.abs(ours - theirs)[known]
        assert (apart <= 2.0 * (found.tilt_error + other.tilt_error)[known] + 1e-10).all()
    assert np.abs(found.tilt_max[known]).max() > 1.4


def test_a_centred_ball_slows_evenly_also_over_its_poles():
    """Rolling and contour friction stop it after (1 + I) p/(arms) on a way of half of p times that, pivoting apart."""
    tilt, rate = 0.3, np.array([2.0, -0.7, 0.0])
    words = {**BALL, "tilt": tilt, "tilt_rate": rate, "roll_rate": [0.0, 1.2, 0.5], "precession_rate": 0.4}
    laws = {"rolling_friction": 0.03, "contour_friction": 0.02, "pivoting_friction": 0.01}
    found = run(starts(3, **words, **laws), "ball", duration=200.0)
    horizontal = np.hypot(rate, math.cos(tilt) * np.array(words["roll_rate"]))
    turning = np.abs(0.4 + math.sin(tilt) * np.array(words["roll_rate"]))
    rolling_time, turning_time = 1.4 * horizontal / 0.05, 0.4 * turning / 0.01
    assert found.ending.tolist() == [REST] * 3
    assert found.end_time == pytest.approx(np.maximum(rolling_time, turning_time), rel=1e-8)
    assert found.path_length == pytest.approx(0.5 * horizontal * rolling_time, rel=1e-8)
    assert found.rolling_loss == pytest.approx(0.6 * 0.7 * horizontal**2, rel=1e-8)
    assert found.contour_loss == pytest.approx(0.4 * 0.7 * horizontal**2, rel=1e-8)
    assert found.pivoting_loss == pytest.approx(0.5 * 0.4 * turning**2, rel=1e-8)


def test_an_egg_sleeps_until_pivoting_friction_has_slowed_it_to_the_critical_spin():
    """Its spin sinks by the arm over I; it falls over soon after it is 4(A+h^2)(h-1)/(I+h)^2, and not before."""
    critical, spin = math.sqrt(4.0 * (0.38 + 1.44) * 0.2 / 1.62**2), 1.5
    assert critical == pytest.approx(0.7448445990, abs=1e-10)
    found = run(
        starts(2, **EGG, tilt=0.5 * math.pi - 1e-6, roll_rate=spin, pivoting_friction=[2e-3, 5e-4]), "ball",
        duration=1000.0, limited=1.0, limit=0.1, from_start=2.0,
    )  # fmt: skip
    sinking = (spin - critical) * 0.42 / np.array([2e-3, 5e-4])
    late = found.breach_time / sinking
    assert (late > 1.0).all()
    # it grows like exp of the integral of the root of the time since: by as much in a time of the power -1/3 of the arm
    assert late[0] < 1.5
    assert (late[1] - 1.0) / (late[0] - 1.0) == pytest.approx(4.0 ** (-2.0 / 3.0), rel=0.1)


@pytest.mark.slow_lane
def test_friction_that_stops_and_turns_round_is_the_limit_of_a_steep_one():
    """The set-valued laws against dry friction without a jump, ever steeper: the difference falls in proportion."""
    words = {"flattening": 0.45, "offset": 0.1, "axial_moment": 0.4, "transverse_moment": 0.3}
    words |= {"tilt": 0.6, "tilt_rate": 0.1, "precession_rate": 0.4, "roll_rate": -0.3}
    laws = {"rolling_friction": 0.03, "pivoting_friction": 0.03, "contour_friction": 0.05}
    found = run(starts(**words, **laws), "spheroid", duration=8.0, tolerance=1e-10)
    assert found.switches[0] > 2
    apart = []
    for soft in (1e-3, 1e-4):
        polar = Polar(Body(0.0, 0.1, 1.0, 0.4, 0.3, 0.55**2), *laws.values(), soft=soft)
        motion, tilts = polar.follow(scaled(words), 8.0, method="Radau", accuracy=1e-7)
        ledger = [getattr(found, name)[0] for name in LEDGER]
        apart.append(np.abs(np.array([*ledger, found.end_tilt[0]]) - [*motion.y[6:, -1], tilts[1]]).max())
    assert apart[0] < 0.05
    assert apart[1] < 0.25 * apart[0]


@pytest.mark.slow_lane
def test_a_body_that_turns_where_it_stands_is_let_go_as_it_slows():
    """Its turning balanced the weight; then friction only just does not hold it, and it begins to creep."""
    words = {"offset": 0.1, "axial_moment": 0.5, "transverse_moment": 0.3, "tilt": 0.8}
    words |= {"tilt_rate": 0.0, "precession_rate": 1.66, "roll_rate": 0.0}
    laws = {"rolling_friction": 0.05, "pivoting_friction": 0.02}
    found = run(starts(**words, **laws), "ball", duration=30.0)
    # it stands while the torque l C of the weight, less what turning takes of it, is below the arm
    S, C = math.sin(0.8), math.cos(0.8)
    per_square = 0.2 * S * C - (1.0 + 0.1 * S) * 0.1 * C
    assert abs(per_square * 1.66**2 - 0.1 * C) < 0.05 < 0.1 * C
    assert found.end_tilt[0] < 0.3
    apart = []
    for soft in (1e-4, 1e-5):
        polar = Polar(Body(0.0, 0.1, 1.0, 0.5, 0.3), 0.05, 0.02, soft=soft)
        motion, _ = polar.follow(scaled(words), 30.0, method="Radau", accuracy=1e-7)
        apart.append(abs(found.path_length[0] - motion.y[7, -1]))
    assert apart[0] < 0.1
    assert apart[1] < 0.3 * apart[0]


def test_friction_holds_where_the_weight_has_a_shorter_lever():
    """A lens stands while the lever of its weight is below the arm of rolling friction and r times that of contour."""
    tilts, square = np.concatenate([np.linspace(0.005, 0.4, 60), np.linspace(1.2, 1.569, 60)]), 0.36
    moments = {"axial_moment": 0.4, "transverse_moment": 0.272}
    found = run(
        starts(120, flattening=0.4, **moments, tilt=tilts, rolling_friction=0.03, contour_friction=0.06),
        "spheroid", duration=0.5,
    )  # fmt: skip
    n = 1.0 / np.sqrt(np.cos(tilts) ** 2 + square * np.sin(tilts) ** 2)
    lever, radius = (1.0 - square) * n * np.sin(tilts) * np.cos(tilts), square * n**3
    assert ((found.ending == REST) == (lever <= 0.03 + 0.06 * radius)).all()
    assert 5 < np.count_nonzero(found.ending[:60] == REST) < 55
    assert 5 < np.count_nonzero(found.ending[60:] == REST) < 55


def test_it_slips_where_the_force_of_newton_needs_more_friction():
    """At that moment the horizontal force is the coefficient times the normal one."""
    words, bodies, given = drawn_many("spheroid", 40, 43)
    given[-1] = 0.3
    found, checked = run(given, "spheroid", duration=5.0), 0
    for cell in np.flatnonzero((found.ending == SLIP) & (found.end_time > 0.1) & (found.switches == 0))[:4]:
        body = bodies[cell].body
        motion, _ = bodies[cell].follow(scaled(words[cell]), found.end_time[cell])
        state = motion.y[:, -1]
        rate = bodies[cell].right_side(0.0, state)
        r, r_rate = body.contact(state[:3], rate[:3])
        force = UP - cross(rate[3:6], r) - cross(state[3:6], r_rate)
        assert math.hypot(*force[:2]) == pytest.approx(0.3 * force[2], rel=1e-5)
        checked += 1
    assert checked > 1


@pytest.mark.parametrize("name", ["ball", "spheroid"])
def test_the_ledger_closes_and_the_axis_may_point_either_way(name):
    """The losses and what is left add up to the tolerance; told by the other end of its axis the motion is the same."""
    words, bodies, given = drawn_many(name, 150, 44, -0.7)
    found = run(given, name, duration=20.0)
    assert np.mean(found.ending == UNRESOLVED) < 0.01
    assert np.nanmax(found.energy_imbalance) <= 1e-8
    rested = np.flatnonzero(found.ending == REST)
    assert rested.size > 5
    for cell in rested:
        nothing, polar = np.zeros(len(LEDGER)), bodies[cell]
        first = polar.energy(np.concatenate([polar.body.start(*scaled(words[cell])), nothing]))
        last = polar.energy(np.concatenate([polar.body.start(found.end_tilt[cell], 0, 0, 0), nothing]))
        taken = sum(getattr(found, each)[cell] for each in LEDGER[2:])
        assert first - last == pytest.approx(taken, abs=3e-8)
    turned_round = dict.fromkeys(("tilt", "tilt_rate", "roll_rate", "offset"), -1.0)
    other = run(
        np.concatenate(
            [
                starts(**{key: value * turned_round.get(key, 1.0) for key, value in each.items()})
                for each in words
            ],
            axis=1,
        ),
        name,
        duration=20.0,
    )
    assert (other.ending == found.ending).all()
    known = found.ending != UNRESOLVED
    assert other.tilt_min[known] == pytest.approx(-found.tilt_max[known], abs=1e-9)
    assert other.path_length[known] == pytest.approx(found.path_length[known], abs=1e-9)


def test_a_heading_that_jumps_at_a_pole_is_stated_as_uncertain():
    """Straight over a pole the heading turns by half a turn at once, to either side."""
    over = run(starts(**BALL, tilt=1.0, tilt_rate=1.0, rolling_friction=1e-3), "ball", duration=2.0)
    beside = run(
        starts(**BALL, tilt=1.0, tilt_rate=1.0, roll_rate=0.05, rolling_friction=1e-3), "ball", duration=2.0
    )
    assert over.heading_error[0] > math.pi
    assert over.tilt_max[0] == pytest.approx(0.5 * math.pi, abs=over.tilt_error[0])
    assert beside.heading_error[0] < 1e-5


def test_errors_are_stated_of_steps_that_are_given():
    """A longest step that is too long for the motion makes errors, and the cell says so."""
    _, _, given = drawn_many("spheroid", 30, 46)
    coarse, fine = (run(given, "spheroid", duration=4.0, tolerance=each, step=0.25) for each in (1e-2, 1e-10))
    known = (coarse.ending == fine.ending) & (coarse.ending == HORIZON)
    apart = np.abs(coarse.end_tilt - fine.end_tilt)[known]
    stated = coarse.tilt_error[known] - 1e-2
    assert np.median(apart) > 1e-6
    assert np.mean(apart <= 2.0 * stated + 1e-9) > 0.9


def test_starts_without_a_motion():
    """Upright and undisturbed, impossible ones, and with air, which has no face to act on."""
    lens = {"flattening": 0.4, "axial_moment": 0.4, "transverse_moment": 0.272, "rolling_friction": 1e-3}

    def ending(**words):
        air = MOFFATT if words.get("air_viscosity") else 0.0
        return run(starts(**{**lens, "roll_rate": 1.0, **words}), "spheroid", air_law=air).ending[0]

    assert ending(tilt=0.0) == UNDISTURBED
    assert ending(tilt=0.1) not in (UNDISTURBED, INVALID)
    assert ending(tilt=0.1, rolling_friction=-1.0) == INVALID
    assert ending(tilt=0.1, offset=0.7) == INVALID
    assert ending(tilt=0.1, air_viscosity=1e-3) == INVALID


def test_a_body_that_friction_hardly_lets_go_creeps():
    """With an excess of 1e-5 over what holds it as with 1e-3 times the steps, to within its stated error."""
    lever = abs(
        -0.2 * math.cos(0.3)
        + 0.25 * (0.04 * math.sin(0.3) - (1.0 + 0.2 * math.sin(0.3)) * 0.2) * math.cos(0.3)
    )
    words = {**EGG, "tilt": 0.3, "precession_rate": 0.5}
    found = run(
        starts(2, **words, rolling_friction=lever / (1.0 + np.array([1e-5, 1e-3]))), "ball", duration=10.0
    )
    assert found.ending.tolist() == [HORIZON, HORIZON]
    assert found.steps[0] < 1e6
    # both fall by about as much as their excess is, the small one a hundredth as far
    assert (0.3 - found.end_tilt[0]) / (0.3 - found.end_tilt[1]) == pytest.approx(0.01, rel=0.2)


def test_a_referee_without_a_law_notices():
    """The comparison with the rigid body would see a law that is a thousandth off."""
    words, bodies, given = drawn_many("spheroid", 1, 45)
    words = {**words[0], "contour_friction": 0.03, "rolling_friction": 0.02}
    polar = replace(bodies[0], contour=0.03 * 1.001, rolling=0.02)
    given = starts(**words)
    found = run(given, "spheroid", duration=2.0)
    motion, _ = polar.follow(scaled(words), 2.0)
    assert abs(found.contour_loss[0] - motion.y[6 + LEDGER.index("contour_loss"), -1]) > 1e-6
