"""The reduction of bodies, compared with Newton and Euler, the engine, and known facts about its linear pair."""

import math

import numpy as np
import pytest
from body_referee import LENGTHS, REFERENCE, Body, start_of, starts
from body_runner import FALL_TILT, TORUS, drawn, reduce, run

from kernels.bodies.arrays import PARAMETERS, REDUCED
from kernels.bodies.shapes import FIRST_WITH_POLES, NAMES
from kernels.disk.endings import BOUNDED, EDGE_CHANGE, FELL, INVALID, STEADY
from sweep.model.bodies.exact import kernel_of
from sweep.model.bodies.theory import CARRY
from sweep.model.disk.path import call_by_body


def many(body, n, seed):
    """Return random starts of a body."""
    rng = np.random.default_rng(seed)
    columns = []
    for _ in range(n):
        lengths, (axial, transverse), _ = drawn(body, rng)
        tilt = rng.uniform(-1.4, 1.4) * 10.0 ** rng.uniform(-3.0, 0.0)
        w, o, s = rng.normal(size=3) * (rng.random(3) < 0.8)
        columns.append(start_of(body, tilt, w, o, s, axial, transverse, **lengths)[0])
    return np.concatenate(columns, axis=1)


def test_the_table_of_reference_values():
    """Ten digits agree with another form of the equations, and more with Newton and Euler."""
    for name, (body, *expected) in REFERENCE.items():
        word, lengths = LENGTHS[name]
        given, _ = start_of(word, 0.2, 0.1, 0.5, 0.6, body.axial, body.transverse, **lengths(body))
        found = reduce(given, word)
        values = [float(found[each][0]) for each in ("tilt_min", "tilt_max", "nutation_period")]
        assert values == pytest.approx(expected, abs=6e-11), name
        assert values == pytest.approx(body.extremes(0.2, 0.1, 0.5, 0.6), abs=3e-12, rel=3e-12), name


@pytest.mark.compiled
def test_the_engine_and_the_reduction_say_the_same():
    """Endings agree, extremes are within the tolerance, and 99.9 % within twice the stated error."""
    beyond, counted, endings = 0, 0, set()
    for number, body in enumerate(NAMES[:FIRST_WITH_POLES]):
        given = many(body, 800, number)
        engine, exact = run(given, body, duration=1e4), reduce(given, body)
        assert np.array_equal(engine.ending, exact["ending"]), body
        endings |= set(exact["ending"].tolist())
        apart = np.maximum(
            np.abs(engine.least - exact["tilt_min"]), np.abs(engine.greatest - exact["tilt_max"])
        )
        assert apart.max() < 1e-8, body
        bounded = exact["ending"] == BOUNDED
        beyond += (apart > 2.0 * engine.tilt_error + exact["tilt_error"] + 2e-14)[bounded].sum()
        counted += bounded.sum()
        known = bounded & np.isfinite(exact["nutation_period"])
        assert (bounded & ~known).sum() <= 4, body
        np.testing.assert_allclose(engine.period[known], exact["nutation_period"][known], rtol=1e-7)
    assert beyond <= 1e-3 * counted + 1
    assert endings == {BOUNDED, FELL, EDGE_CHANGE}


def test_periods_beside_a_separatrix():
    """A slow ring kicked off upright, and one released near it, linger there, as in the referee."""
    axial, transverse, ring = (
        TORUS["axial_moment"],
        TORUS["transverse_moment"],
        Body(0.75, 0.0, 0.25, 0.609375, 0.3203125),
    )
    for tilt, w, s in ((0.0, 1e-3, 0.3), (1e-3, 0.0, 0.3)):
        given, _ = start_of("torus", tilt, w, 0.0, s, axial, transverse, tube=0.25)
        found = reduce(given, "torus")
        if w:
            period = ring.extremes(tilt, w, 0.0, s)[2]
        else:
            # from rest, the first turning point is half a period away
            period = 2.0 * ring.motion(tilt, w, 0.0, s, 100.0, most=2).t_events[0][-1]
        assert abs(found["separatrix"][0]) < 1e-3
        assert found["nutation_period"][0] == pytest.approx(period, rel=1e-8), (tilt, w)


@pytest.mark.compiled
def test_mirror_images_have_the_same_bits():
    """The motion to one side equals the mirror image's motion to the other."""
    for body in ("torus", "rounded", "rim", "spheroid"):
        given = many(body, 100, 9)
        mirrored = given.copy()
        mirrored[:3] *= -1.0
        mirrored[PARAMETERS.index("offset")] *= -1.0
        there, back = reduce(given, body), reduce(mirrored, body)
        assert np.array_equal(there["ending"], back["ending"])
        assert np.array_equal(there["tilt_max"], -back["tilt_min"], equal_nan=True)
        np.testing.assert_allclose(there["nutation_period"], back["nutation_period"], rtol=1e-13)


def test_starts_that_are_none_and_motions_that_rest():
    """Impossible starts and resting motions have the engine's results."""
    given = np.concatenate(
        [starts(**TORUS | {"tube": 1.1}), starts(**TORUS, tilt=1.55), starts(**TORUS, roll_rate=1.0)], axis=1
    )
    assert reduce(given, "torus")["ending"].tolist() == [INVALID, FELL, STEADY]


def test_the_linear_pair_is_that_of_whole_motions():
    """Transported to another tilt, the rates are Newton and Euler's; back again, they agree to rounding."""
    rng = np.random.default_rng(5)
    for number in range(10):
        name = NAMES[number % len(NAMES)]
        _, (axial, transverse), (core, shift, edge, square) = drawn(name, rng)
        tilt, w, o, s = rng.uniform(0.1, 0.6), 0.5, *rng.normal(size=2)
        found = Body(core, shift, edge, axial, transverse, square).motion(tilt, w, o, s, 0.4)
        n, turning = found.y[:3, -1], found.y[3:, -1]
        there = math.asin(n[2])
        across = (np.array([0.0, 0.0, 1.0]) - n[2] * n) / math.cos(there)
        rates = np.array([[s], [o]])
        body = np.array([[core], [shift], [edge], [square], [axial], [transverse], [axial / transverse]])
        squares = np.empty(1)
        CARRY.load()(np.array([[tilt], [there], [w]]), body, rates, squares)
        assert rates[:, 0] == pytest.approx([turning @ n, turning @ across], rel=1e-11, abs=1e-11)
        CARRY.load()(np.array([[there], [tilt], [w]]), body, rates, squares)
        assert rates[:, 0] == pytest.approx([s, o], rel=1e-13, abs=1e-13)


def test_the_constants_of_a_torus_and_of_a_spheroid():
    """Their rates at tilt 0 agree to twelve digits with another integration."""
    torus = [0.75, 0.0, 0.25, 1.0, 0.609375, 0.3203125, 0.609375 / 0.3203125]
    oblate = [0.0, 0.0, 1.0, 0.25, 0.4, 0.25, 1.6]
    for body, expected in (
        (torus, [0.658404086457, 0.724714169927]),
        (oblate, [0.664235549469, 0.688070153292]),
    ):
        rates, squares = np.array([[0.6], [0.5]]), np.empty(1)
        CARRY.load()(np.array([[0.2], [0.0], [0.1]]), np.array([body]).T.copy(), rates, squares)
        assert rates[:, 0] == pytest.approx(expected, abs=1e-12)


def test_cells_have_the_same_bits_next_to_any_others():
    """Cells of one body share its panels and are sorted for that; each has the same bits alone and among others."""
    for body in ("torus", "spheroid"):
        given = many(body, 24, 3)
        # eight bodies with three motions each, not adjacent
        given[PARAMETERS.index("tube") : PARAMETERS.index("radius")] = np.tile(
            given[PARAMETERS.index("tube") : PARAMETERS.index("radius"), :8], 3
        )
        measures, counts = np.empty((len(REDUCED), 24)), np.empty((1, 24), np.int32)
        settings = (float(NAMES.index(body)), FALL_TILT, 1)
        call_by_body(kernel_of(body, "reduce"), np.ascontiguousarray(given), settings, (measures, counts))
        for cell in range(24):
            alone = reduce(given[:, cell : cell + 1], body)
            assert counts[0, cell] == alone["ending"][0]
            for name, values in zip(REDUCED, measures, strict=True):
                assert np.array_equal(values[cell], alone[name][0], equal_nan=True), (body, cell, name)
