import itertools
import math

import numpy as np
import pytest
from disk_reduction import COUNT, ENDING, extremes
from hypothesis import assume, given
from hypothesis import strategies as st

from kernels.bodies.arrays import REDUCED_ERROR, REDUCED_MAX, REDUCED_MIN, REDUCED_PERIOD, REDUCED_SEPARATRIX
from kernels.bodies.shapes import TORUS, Body
from kernels.disk import steady
from kernels.disk.arrays import ALPHA
from kernels.disk.endings import BOUNDED, FELL, INVALID, STEADY, UNRESOLVED
from kernels.reduction import turning
from kernels.reduction.panels import Table, clear_table, table_memory, take_body
from kernels.reduction.pieces import FROM, LENGTH, PANEL, PIECE, SLOPE

# takes minutes without compilation
pytestmark = pytest.mark.compiled

G, R = 9.81, 0.5
DEGREE = math.radians(1.0)
EXTREMES = [REDUCED_MIN, REDUCED_MAX]


def starts(*rows, alpha=0.5, radius=R, gravity=G):
    """Return starts, one for each (tilt, tilt rate, precession rate, roll rate)."""
    state = np.array(rows, dtype=float).T
    others = np.repeat([[alpha], [radius], [gravity]], state.shape[1], axis=1)
    return np.vstack([state, others])


# --- exact values and symmetries ------------------------------------------------------------------------------------


def test_known_extremes():
    """The extremes of five runs with the uniform disk agree with an independent quadrature."""
    for case in [
        ((0.0, 0.01, 0.0, 2.0), -41.6082, 41.6082),
        ((0.0, 0.01, 0.0, 2.5), -13.1205, 13.1205),
        ((0.0, 0.1, 3.5, 0.0), -28.6591, 28.6591),
        ((0.01, 0.0, 0.0, 3.0), 0.5730, 3.5887),
        ((0.5, 0.0, 4.5, 0.0), 28.6479, 79.3831),
    ]:
        start, low, high = case
        measures, _ = extremes(starts(start), 85.0 * DEGREE)
        assert [round(x / DEGREE, 4) for x in measures[EXTREMES, 0]] == [low, high], case


RATES = st.floats(-8.0, 8.0)


@given(st.floats(-1.5, 1.5), RATES, RATES, RATES, st.floats(1e-3, 1.0))
def test_mirrored_start(tilt, rate, precession, roll, alpha):
    """The mirror image of a start has the mirror image's motion, to the last bit."""
    pair = starts((tilt, rate, precession, roll), (-tilt, -rate, -precession, roll), alpha=alpha)
    measures, counts = extremes(pair, 89.0 * DEGREE, True)
    assert (counts[:, 0] == counts[:, 1]).all()
    np.testing.assert_array_equal(measures[EXTREMES, 0], -measures[EXTREMES[::-1], 1])
    others = [REDUCED_SEPARATRIX, REDUCED_ERROR]
    np.testing.assert_array_equal(measures[others, 0], measures[others, 1])


@given(st.floats(-1.4, 1.4), RATES, RATES, st.floats(0.01, 1.0))
def test_released_at_rest(tilt, precession, roll, alpha):
    """A start at rest is exactly one of the extremes."""
    measures, counts = extremes(starts((tilt, 0.0, precession, roll), alpha=alpha), 89.0 * DEGREE)
    assume(counts[ENDING, 0] != UNRESOLVED)
    assert tilt in measures[EXTREMES, 0]


@given(st.floats(-1.4, 1.4), RATES, RATES, RATES, st.floats(0.05, 4.0), st.floats(0.5, 30.0))
def test_radius_and_gravity_only_scale_time(tilt, rate, precession, roll, radius, gravity):
    """The extremes depend only on the rates in units of sqrt(gravity/radius)."""
    unit = math.sqrt(gravity / radius)
    scaled = starts((tilt, rate, precession, roll), radius=1.0, gravity=1.0)
    physical = starts((tilt, rate * unit, precession * unit, roll * unit), radius=radius, gravity=gravity)
    (one, ones), (other, others) = (extremes(x, 80.0 * DEGREE, True) for x in (scaled, physical))
    assume(ones[ENDING, 0] == BOUNDED and one[REDUCED_ERROR, 0] < 1e-13)
    assert ones[COUNT, 0] == others[COUNT, 0]
    np.testing.assert_allclose(
        other[EXTREMES, 0], one[EXTREMES, 0], rtol=0.0, atol=8 * one[REDUCED_ERROR, 0] + 1e-15
    )
    assert other[REDUCED_PERIOD, 0] == pytest.approx(one[REDUCED_PERIOD, 0] / unit, rel=1e-9, nan_ok=True)


# --- wells ----------------------------------------------------------------------------------------------------------


def test_wells_change_at_the_fold():
    """A relative 1e-10 below a marginal steady rate, V has two wells; above, it has one."""
    for case in itertools.product([1e-6, 0.2, 0.5, 1.0], [1e-2, 1e-6, 1e-10]):
        alpha, away = case
        tilt = np.concatenate([np.geomspace(1e-3, 0.1, 60), np.linspace(0.1, 0.34, 60)])
        for precession in steady.marginal_precession_rates(tilt, 0.0, alpha, R, G):
            real = np.isfinite(precession)
            t, p = tilt[real], precession[real]
            f = steady.steady_roll_rate(t, p, alpha, R, G)
            for factor, wells in ((1.0 - away, 2), (1.0 + away, 1)):
                rows = np.stack([t, np.full_like(t, 0.3), p * factor, f * factor], axis=1)
                _, counts = extremes(starts(*rows, alpha=alpha), 89.0 * DEGREE)
                assert (counts[COUNT] == wells).all(), case


def test_small_oscillations():
    """Near a steady motion, the period is 2 pi over the square root of the stability coefficient."""
    tilt, precession = 0.6, 3.0
    roll = steady.steady_roll_rate(tilt, precession, 0.5, R, G)
    k = steady.stability_coefficient(tilt, precession, roll, 0.5, R, G)
    measures, _ = extremes(starts((tilt, 1e-6, precession, roll)), 80.0 * DEGREE, True)
    # rounding of the force shifts the middle by 1e-16, and the amplitude is 1e-6, so the period is good to
    # its square
    assert measures[REDUCED_PERIOD, 0] == pytest.approx(2.0 * math.pi / math.sqrt(k), rel=1e-9)
    assert measures[REDUCED_MAX, 0] - tilt == pytest.approx(1e-6 / math.sqrt(k), rel=1e-5)


# --- endings --------------------------------------------------------------------------------------------------------


def end_of(*start, fall=60.0, **others):
    """Return the ending and the extremes in degrees of one start."""
    measures, counts = extremes(starts(start, **others), fall * DEGREE)
    return counts[ENDING, 0], *(float(x) / DEGREE for x in measures[EXTREMES, 0])


def test_fall_forward_shows_nothing_else():
    """A disk kicked towards the fall shows only its start and the fall."""
    ending, low, high = end_of(0.1, 0.5, 0.0, 0.5)
    assert (ending, low, high) == (FELL, pytest.approx(0.1 / DEGREE), pytest.approx(60.0))


def test_fall_after_a_turn():
    """A disk kicked away from the fall turns first, and the turning point is an extreme."""
    ending, low, high = end_of(0.5, -0.5, 0.0, 0.5)
    assert ending == FELL
    assert high == pytest.approx(60.0)
    assert 0.0 < low < 0.5 / DEGREE


def test_fall_sideways_comes_first():
    """If both sides lead to a fall, the disk falls on the side of its kick."""
    assert end_of(0.1, -2.0, 0.0, 0.0)[1:] == pytest.approx((-60.0, 0.1 / DEGREE))


def test_start_beyond_the_fall():
    """A start at or beyond fall_tilt has fallen there."""
    assert end_of(-1.2, 0.3, 1.0, 1.0) == (FELL, pytest.approx(-1.2 / DEGREE), pytest.approx(-1.2 / DEGREE))


def test_upright_without_disturbance():
    """Undisturbed upright rolling, spinning or standing is steady, whether stable or not."""
    for start in [(0.0, 0.0, 0.0, 3.0), (0.0, 0.0, 2.0, 0.0), (0.0, 0.0, 0.0, 0.0)]:
        assert end_of(*start) == (STEADY, 0.0, 0.0), start


@given(st.floats(0.02, 1.3), st.floats(0.2, 8.0), st.floats(0.01, 1.0))
def test_circling_without_disturbance(tilt, precession, alpha):
    """A circling disk is steady, up to the rounding of its own roll rate."""
    roll = steady.steady_roll_rate(tilt, precession, alpha, R, G)
    assert end_of(tilt, 0.0, precession, roll, fall=85.0, alpha=alpha)[0] == STEADY


def test_on_the_separatrix():
    """At exactly the energy of the saddle, it is undecided whether the disk passes."""
    tilt = 0.2
    kinetic = 1.0 - math.cos(tilt)  # without spin the potential is cos(tilt)
    rate = math.sqrt(kinetic / (0.5 * 1.25) * G / R)
    assert end_of(tilt, -rate, 0.0, 0.0)[0] == UNRESOLVED
    assert end_of(tilt, -rate * (1.0 + 1e-12), 0.0, 0.0)[0] == FELL


def test_next_to_flat():
    """A disk that falls straight reaches every tilt."""
    for fall in (89.9, 89.99, 89.999999):
        assert end_of(1.0, 0.5, 0.0, 0.0, fall=fall)[::2] == (FELL, pytest.approx(fall))


def test_impossible_start():
    """An impossible start is invalid and does not affect its neighbors."""
    for bad in [
        {"tilt": math.nan},
        {"tilt": 1.6},
        {"tilt": -math.pi / 2},
        {"rate": math.inf},
        {"roll": math.nan},
        {"alpha": 0.0},
        {"alpha": 1.5},
        {"alpha": math.nan},
        {"radius": 0.0},
        {"radius": -1.0},
        {"radius": math.inf},
        {"gravity": 0.0},
        {"gravity": math.nan},
    ]:
        good = {
            "tilt": 0.1,
            "rate": 0.0,
            "precession": 0.0,
            "roll": 3.0,
            "alpha": 0.5,
            "radius": R,
            "gravity": G,
        }
        given_ = np.array([list(good.values()), list((good | bad).values()), list(good.values())]).T
        measures, counts = extremes(given_, 80.0 * DEGREE)
        alone, _ = extremes(given_[:, :1], 80.0 * DEGREE)
        assert list(counts[ENDING]) == [BOUNDED, INVALID, BOUNDED], bad
        assert np.isnan(measures[:, 1]).all(), bad
        np.testing.assert_array_equal(measures[:, [0, 2]], alone.repeat(2, axis=1))


@given(st.floats(-1e200, 1e200), st.floats(-1e200, 1e200), st.floats(-1e200, 1e200), st.floats(-1.57, 1.57))
def test_enormous_rates(rate, precession, roll, tilt):
    """With any numbers, every cell has an ending, and its extremes include the start."""
    measures, counts = extremes(starts((tilt, rate, precession, roll)), 85.0 * DEGREE, True)
    assert counts[ENDING, 0] in (BOUNDED, STEADY, FELL, UNRESOLVED)
    if counts[ENDING, 0] != UNRESOLVED:
        assert measures[REDUCED_MIN, 0] <= tilt <= measures[REDUCED_MAX, 0]


# --- a cell's bits depend on the cell alone -------------------------------------------------------------------------


def test_alpha_as_an_axis():
    """Many values of alpha, including bad ones, give the same as each alone."""
    alpha = np.linspace(-0.1, 1.1, 307)
    many = starts(*[(0.1, 0.2, 1.0, 2.0)] * alpha.size)
    many[ALPHA] = alpha
    measures, counts = extremes(many, 80.0 * DEGREE, True)
    assert ((counts[ENDING] == INVALID) == ((alpha <= 0.0) | (alpha > 1.0))).all()
    for i in (0, 40, 200, 300):
        one, _ = extremes(many[:, i : i + 1], 80.0 * DEGREE, True)
        np.testing.assert_array_equal(one[:, 0], measures[:, i])


def test_saddles_that_hide_do_not_change_their_neighbours():
    """Potentials near the fold, whose saddles hide on different panels, have the same bits alone and together."""
    pair = starts(
        (0.0, -0.012600092341794959, -0.05775045673300538, -0.5983179477347507),
        (0.0, 0.0016389466937642668, 0.0026508615347270365, -0.6872035236101626),
        alpha=0.02, radius=1.0, gravity=1.0,
    )  # fmt: skip
    together, _ = extremes(pair, 1.4)
    for cell in (0, 1):
        alone, _ = extremes(pair[:, [cell]], 1.4)
        np.testing.assert_array_equal(alone[:, 0], together[:, cell])


def test_a_kick_off_the_very_bottom_of_a_well():
    """A kick at exactly zero force, as happens without fused products, turns at a nearby maximum, too."""
    table = Table(*table_memory())
    clear_table(table)
    take_body(table, Body(1.0, 0.0, 0.0, 1.0, 0.5, 0.25, 2.0))
    unit = math.sqrt(R / G)
    for tilt, precession in ((0.109833, 0.571375), (0.194209, 1.070375), (0.181228, 0.987208)):
        roll = steady.steady_roll_rate(tilt, precession, 0.5, R, G)
        o, s = unit * precession * math.cos(tilt), unit * (roll + precession * math.sin(tilt))
        piece = np.zeros(PIECE)
        turning._place_start(table, float(TORUS), tilt, 1e-4 * unit, o, s, piece)
        piece[SLOPE] = 0.0
        for sense in (-1.0, 1.0):
            end = table.edges[int(piece[PANEL]) + (1 if sense > 0.0 else 0)]
            turn = turning._first_turn(piece, sense, sense * (end - piece[FROM]) / piece[LENGTH])[0]
            assert turn * piece[LENGTH] < 1e-3, (tilt, sense)
