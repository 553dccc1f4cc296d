"""Many bodies at once, compared with Newton and Euler, closed forms, and the thin disk."""

import math

import body_referee
import kernel_runner
import numpy as np
import pytest
import referee
from body_referee import LENGTHS, REFERENCE, Body, start_of, starts
from body_runner import FALL_TILT, TORUS, drawn, run

from kernels.bodies import equations
from kernels.bodies.arrays import PARAMETERS
from kernels.bodies.shapes import NAMES, solid_moments, torus_moments
from kernels.bodies.shapes import Body as Constants
from kernels.disk.endings import BOUNDED, EDGE_CHANGE, FELL, HORIZON, INVALID, STEADY


def test_the_table_of_reference_values():
    """Extreme tilts and period agree to ten digits with another form of the equations."""
    for name, (body, *expected) in REFERENCE.items():
        word, lengths = LENGTHS[name]
        given, _ = start_of(word, 0.2, 0.1, 0.5, 0.6, body.axial, body.transverse, **lengths(body))
        found = run(given, word, tolerance=1e-10)
        assert found.ending[0] == BOUNDED, name
        for value, right in zip((found.least, found.greatest, found.period), expected, strict=True):
            assert value[0] == pytest.approx(right, abs=3e-10), name


@pytest.mark.slow_lane
def test_random_motions_are_those_of_newton_and_euler():
    """For all bodies and rates over a decade, the extreme tilts are within twice their stated error."""
    rng = np.random.default_rng(20)
    checked = 0
    for number in range(30):
        body = NAMES[number % len(NAMES)]
        lengths, (axial, transverse), (core, shift, edge, square) = drawn(body, rng)
        tilt, rates = rng.uniform(-1.3, 1.3), rng.normal(size=3) * rng.choice([0.3, 1.0, 3.0])
        given, _ = start_of(body, tilt, *rates, axial, transverse, **lengths)
        found = run(given, body)
        if found.ending[0] != BOUNDED:
            assert found.ending[0] in (FELL, EDGE_CHANGE, HORIZON)
            continue
        side = -1.0 if body == "rim" and tilt < 0.0 else 1.0
        least, greatest, period = Body(core, side * shift, edge, axial, transverse, square).extremes(
            tilt, *rates
        )
        allowed = 2.0 * found.tilt_error[0] + 1e-10
        assert abs(found.least[0] - least) < allowed, (body, number)
        assert abs(found.greatest[0] - greatest) < allowed, (body, number)
        assert found.period[0] == pytest.approx(period, rel=1e-7), (body, number)
        checked += 1
    assert checked > 18


def test_a_torus_without_a_tube_is_the_hoop_and_its_difference_is_linear():
    """A torus without a tube equals the thin disk's own kernel; for a thin tube the difference is linear in it."""
    tilt, roll = np.linspace(0.05, 0.9, 12), np.linspace(-1.5, 1.5, 12)
    hoop = kernel_runner.run(
        referee.starts(tilt=tilt, roll_rate=roll, precession_rate=0.4, alpha=1.0, radius=1.0, gravity=1.0),
        fall_tilt=FALL_TILT, tolerance=1e-11,
    )  # fmt: skip
    apart = []
    for tube in (0.0, 1e-4, 2e-4):
        axial, transverse = torus_moments(tube, hollow=False)
        given = starts(
            12, tilt=tilt, roll_rate=roll, precession_rate=0.4, tube=tube, axial_moment=axial,
            transverse_moment=transverse,
        )  # fmt: skip
        found = run(given, "torus", tolerance=1e-11)
        assert np.array_equal(found.ending, hoop.ending)
        apart.append(
            np.nan_to_num(np.concatenate([found.least - hoop.least, found.greatest - hoop.greatest]))
        )
    assert np.abs(apart[0]).max() < 1e-10
    large = np.abs(apart[1]) > 1e-6
    assert large.sum() > 5
    np.testing.assert_allclose(apart[2][large] / apart[1][large], 2.0, rtol=3e-3)


def test_a_rim_without_a_fillet_rolls_on_its_edge():
    """A sharp rim without thickness equals the thin disk, and mirror images end as mirror images."""
    tilt, rates = np.linspace(0.2, 1.2, 8), {"precession_rate": 1.1, "roll_rate": -0.7, "tilt_rate": 0.2}
    thin = kernel_runner.run(referee.starts(tilt=tilt, **rates, radius=1.0, gravity=1.0), fall_tilt=FALL_TILT)
    disk = {"axial_moment": 0.5, "transverse_moment": 0.25}
    found = run(starts(8, tilt=tilt, **rates, thickness=1e-13, **disk), "rim")
    bounded = (found.ending == BOUNDED) & (thin.ending == BOUNDED)
    assert bounded.sum() > 2
    np.testing.assert_allclose(found.greatest[bounded], thin.greatest[bounded], atol=1e-8)
    axial, transverse = solid_moments(0.3, 0.05)
    thick = {"thickness": 0.3, "fillet": 0.05, "axial_moment": axial, "transverse_moment": transverse}
    there = run(starts(8, tilt=tilt, **rates, **thick), "rim")
    mirrored = {"precession_rate": -1.1, "roll_rate": -0.7, "tilt_rate": -0.2}
    back = run(starts(8, tilt=-tilt, **mirrored, **thick), "rim")
    assert np.array_equal(there.ending, back.ending)
    assert np.array_equal(there.greatest, -back.least, equal_nan=True)
    assert {BOUNDED, EDGE_CHANGE} <= set(there.ending.tolist())


def test_a_coin_comes_down_on_its_other_edge():
    """A slightly tilted coin without spin falls upright, with extreme tilt 0 and the rate that energy gives."""
    axial, transverse = solid_moments(0.2, 0.0)
    lean = {"thickness": 0.2, "axial_moment": axial, "transverse_moment": transverse}
    found = run(starts(3, tilt=[0.05, -0.05, 0.0], **lean), "rim")
    assert found.ending.tolist() == [EDGE_CHANGE] * 3
    assert found.least.tolist() == [0.0, -0.05, 0.0]
    assert found.greatest.tolist() == [0.05, 0.0, 0.0]
    # beyond atan(thickness/2) the weight is outside the edge, and the coin falls flat
    over = run(starts(2, tilt=[0.0997, 0.0996], **lean), "rim")
    assert math.tan(0.0997) > 0.1 * 1.0003
    assert over.ending.tolist() == [FELL, EDGE_CHANGE]


def test_what_follows_from_the_equations():
    """At random states, acceleration, energy and potential force agree with Newton and Euler."""
    rng = np.random.default_rng(3)
    for number in range(12):
        _, (axial, transverse), (core, shift, edge, _) = drawn(NAMES[number % 4], rng)
        tilt, w, o, s = rng.uniform(-1.2, 1.2), *rng.normal(size=3)
        body = Constants(core, shift, edge, 1.0, axial, transverse, axial / transverse)
        other = Body(core, shift, edge, axial, transverse)
        state = (math.sin(tilt), math.cos(tilt), math.tan(tilt), w, o, s)
        y = other.start(tilt, w, o, s)
        assert equations.whole_energy(state, body, 0.0) == pytest.approx(other.energy(y), rel=1e-13)
        # n_z = sin(tilt): its second derivative is C w' - S w^2
        rate = other.right_side(0.0, y)
        second = body_referee.cross(rate[3:], y[:3])[2] + body_referee.cross(y[3:], rate[:3])[2]
        expected = (second + state[0] * w * w) / state[1]
        assert equations.tilt_acceleration(state, body) == pytest.approx(expected, rel=1e-12, abs=1e-13)
        still = (*state[:3], 0.0, o, s)
        pull, curvature = equations.force(still, body)
        per = equations.per_inertia(state[0], state[1], body)
        assert pull * per == pytest.approx(abs(equations.tilt_acceleration(still, body)), rel=1e-12)
        near = [equations.carried(still, body, side * 1e-5) for side in (1.0, -1.0)]
        slopes = [
            equations.tilt_acceleration(each, body) / equations.per_inertia(*each[:2], body) for each in near
        ]
        assert curvature == pytest.approx(-(slopes[0] - slopes[1]) / 2e-5, rel=1e-7, abs=1e-7)
        assert equations.pull_and_terms(still, body)[0] == pytest.approx(pull, rel=1e-13)
        S, C = math.sin(tilt + 0.1), math.cos(tilt + 0.1)
        other_state = (S, C, S / C, w - 0.2, o + 0.1, s + 0.3)
        gained = equations.energy_gained(state, (S, C, *other_state[3:]), body, 0.0)
        whole = [equations.whole_energy(each, body, 0.0) for each in (state, other_state)]
        assert gained == pytest.approx(whole[0] - whole[1], abs=1e-14 * whole[0])


def test_endings_of_starts_that_are_none():
    """Impossible bodies, starts beyond fall_tilt and steady motions get their endings."""
    bad = [
        starts(**TORUS | {"axial_moment": 0.7}), starts(**TORUS | {"transverse_moment": 0.0}),
        starts(**TORUS | {"tube": 1.1}), starts(**TORUS, tilt=1.6), starts(**TORUS, roll_rate=math.inf),
    ]  # fmt: skip
    assert run(np.concatenate(bad, axis=1), "torus").ending.tolist() == [INVALID] * 5
    moments = {"axial_moment": 0.5, "transverse_moment": 0.3, "thickness": 0.1, "tilt": [-0.4, 0.4]}
    assert run(starts(2, **moments, fillet=0.06), "rim").ending.tolist() == [INVALID] * 2
    found = run(np.concatenate([starts(**TORUS, tilt=1.55), starts(**TORUS, roll_rate=1.0)], axis=1), "torus")
    assert found.ending.tolist() == [FELL, STEADY]


def test_a_cell_has_its_own_bits():
    """The order of cells and their neighbors do not change the bits of a cell."""
    rng = np.random.default_rng(4)
    n = 150
    given = starts(
        n, tilt=rng.uniform(-1.2, 1.2, n), tilt_rate=rng.normal(size=n), roll_rate=rng.normal(size=n),
        tube=rng.uniform(0.0, 0.5, n), axial_moment=0.5, transverse_moment=0.3,
    )  # fmt: skip
    whole, order = run(given, "torus").bits(), rng.permutation(n)
    assert np.array_equal(run(given[:, order], "torus").bits(), whole[order])
    assert np.array_equal(run(given[:, 7:8], "torus").bits(), whole[7:8])
    assert len(PARAMETERS) == given.shape[0]
