"""The lanes of the disk with losses: bits, symmetry, order of convergence, limits, endings."""

import itertools
import math
import sys

import lossy_cells
import lossy_referee as referee
import lossy_runner
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kernels.disk.arrays import TILT_ERROR
from kernels.lanes.schedule import CHUNK
from kernels.lossy_disk.arrays import LOSSES, MEASURES, PARAMETERS
from kernels.lossy_disk.endings import FLAT, HORIZON, INVALID, LIFT_OFF, REST, SLIP, UNDISTURBED, UNRESOLVED
from kernels.lossy_disk.integrate import VARIANTS, variant

pytestmark = pytest.mark.compiled

#: A breach within this time of the start [s] means that the start is at the limit, up to rounding.
AT_ONCE = 1e-6
#: Sign changes that keep the equations: the mirror image by a vertical plane through the contact, and the
#: reversed motion.
MIRRORS = {
    "left and right": ("tilt", "tilt_rate", "roll_rate"),
    "the other way round": ("roll_rate", "precession_rate"),
}


def cells(n, seed):
    """Return random mixtures of all laws except air, about n cells."""
    return lossy_cells.random_cells(3 * n, np.random.default_rng(seed))["none"]


def wobbles(n, seed, **parameters):
    """Return nutating wobbles of toys, of about the same length."""
    rng = np.random.default_rng(seed)
    alpha = 0.5
    tilt, turning, rolling = lossy_cells.wobble(rng.uniform(0.05, 0.12, n), alpha)
    return referee.starts(
        tilt=tilt, precession_rate=turning * rng.uniform(0.97, 1.03, n), roll_rate=rolling, **parameters
    )


def flipped(given, names):
    """Return the starts with the signs of some parameters changed."""
    return given * np.array([[-1.0 if name in names else 1.0] for name in PARAMETERS])


@pytest.mark.slow_lane
def test_mirrored_starts_have_mirrored_motions(pick):
    """Sign changes that keep the equations only change signs, to the last bit."""
    mixtures = lossy_cells.random_cells(300, np.random.default_rng(3))
    runs = {air: lossy_runner.run(mixtures[air], air=air) for air in lossy_runner.AIR_LAWS}
    for air, mirror in itertools.product(pick(lossy_runner.AIR_LAWS, 1), MIRRORS):
        found, names = runs[air], MIRRORS[mirror]
        other = lossy_runner.run(flipped(mixtures[air], names), air=air)
        tilted, turned = "tilt" in names, "precession_rate" in names
        expected = dict(vars(other))
        if tilted:
            expected |= {
                "tilt_min": -other.tilt_max,
                "tilt_max": -other.tilt_min,
                "end_tilt": -other.end_tilt,
            }
        if turned:
            expected["heading_turned"] = -other.heading_turned
        for name, column in vars(found).items():
            assert np.array_equal(column, expected[name], equal_nan=True), name


@pytest.mark.slow_lane
def test_the_bits_of_a_cell_depend_on_the_cell_alone():
    """Threads, order, number of cells and position in a chunk do not change the bits of a cell."""
    given = np.concatenate([cells(CHUNK, 5), referee.starts(tilt=[0.0, 1.5705, math.nan])], axis=1)
    rng = np.random.default_rng(6)
    given = np.ascontiguousarray(given[:, rng.permutation(given.shape[1])])
    n = given.shape[1]
    assert n > CHUNK
    found = lossy_runner.run(given, threads=1)
    assert set(found.ending) >= {FLAT, REST, HORIZON, LIFT_OFF, SLIP, UNDISTURBED, INVALID}
    bits = lossy_runner.bits(found)
    order = rng.permutation(n)
    again = lossy_runner.run(np.ascontiguousarray(given[:, order]), threads=2)
    assert np.array_equal(lossy_runner.bits(again), bits[order])
    for start, stop in ((0, 1), (5, 22), (n - 1, n), (100, 400), (CHUNK - 1, CHUNK + 1)):
        part = lossy_runner.run(np.ascontiguousarray(given[:, start:stop]))
        assert np.array_equal(lossy_runner.bits(part), bits[start:stop])


@pytest.mark.slow_lane
@settings(max_examples=20)
@given(st.data())
def test_impossible_neighbours_disturb_nobody(data):
    """Impossible starts are invalid, and the cells between them keep their bits."""
    given = cells(60, 7)
    n = given.shape[1]
    bits = lossy_runner.bits(lossy_runner.run(given, duration=1.0))
    chosen = data.draw(st.lists(st.integers(0, n - 1), min_size=1, max_size=30, unique=True))
    broken = given.copy()
    for cell in chosen:
        # mass and air matter only for laws that use them
        row = data.draw(st.sampled_from([name for name in PARAMETERS if name[:3] not in ("mas", "air")]))
        wrong = [math.nan, -math.inf] if row == "friction" else [math.nan, math.inf, -math.inf]
        broken[PARAMETERS.index(row), cell] = data.draw(st.sampled_from(wrong))
    found = lossy_runner.run(broken, duration=1.0)
    assert (found.ending[chosen] == INVALID).all()
    assert all(np.isnan(getattr(found, name)[chosen]).all() for name in MEASURES)
    others = np.setdiff1d(np.arange(n), chosen)
    assert np.array_equal(lossy_runner.bits(found, others), bits[others])


def test_what_is_no_disk():
    """Arms must be shorter than the radius; forces not proportional to the weight need a mass."""
    for wrong in [
        {"rolling_friction": -1e-9},
        {"pivoting_friction": 1.0},
        {"contour_friction": math.inf},
        {"friction": -0.1},
        {"contour_damping": 1e-3, "mass": 0.0},
        {"contour_damping": -1e-3},
        {"alpha": 1.1},
        {"tilt": 1.6},
    ]:
        assert lossy_runner.run(referee.starts(**{"tilt": 0.3, **wrong})).ending == INVALID, wrong


def test_air_needs_its_viscosity_and_the_mass():
    """Without an air law, the numbers of the air do not matter."""
    given = referee.starts(tilt=0.1, roll_rate=2.0, mass=math.nan, air_viscosity=-1.0)
    assert lossy_runner.run(given).ending == HORIZON
    assert lossy_runner.run(given, air="moffatt").ending == INVALID


def test_what_does_not_move():
    """Upright without a tilt rate, the disk is undisturbed; from flat_tilt on, it is flat at once."""
    found = lossy_runner.run(referee.starts(tilt=[0.0, 1.5705, -1.5705], precession_rate=3.0))
    assert list(found.ending) == [UNDISTURBED, FLAT, FLAT]
    assert list(found.end_time[1:]) == [0.0, 0.0]
    assert list(found.steps) == [0, 0, 0]


def test_times_converge_with_the_fourth_power_of_the_step():
    """Compared with the referee, with a tolerance that sets the step and accepts every step."""
    for case in [
        ({"contour_friction": 1e-3}, "none"),
        ({"contour_damping": 1e-4}, "none"),
        ({"rolling_friction": 5e-3}, "none"),
        ({"air_viscosity": 1e-5}, "moffatt"),
        ({"air_viscosity": 1e-7, "air_density": 1.0}, "bildsten"),
    ]:
        law, air = case
        given, limits = wobbles(6, 12, **law), {"duration": 400.0, "flat_tilt": math.radians(88.0)}
        truth = referee.run(given, air=air, rtol=1e-13, **limits).end_time
        worst = []
        for share in (1.5, 0.75):
            found = lossy_runner.run(given, air=air, tolerance=1e-8 * share**4, **limits)
            assert (found.ending == FLAT).all(), case
            assert (found.refinements == 0).all(), case
            worst.append(np.abs(found.end_time - truth).max())
        # third order would give 8
        assert worst[0] > 8.0 * worst[1], case


def test_without_losses_the_extremes_are_those_of_the_disk():
    """With zero coefficients, the lossless kernel agrees within both stated errors, although the steps differ."""
    from sweep.model.disk.model import DISK

    rng = np.random.default_rng(9)
    given = referee.starts(
        tilt=10.0 ** rng.uniform(-4, -0.3, 300), roll_rate=rng.uniform(0.7, 2.0, 300),
        precession_rate=rng.uniform(-0.5, 0.5, 300),
    )  # fmt: skip
    measures, counts = np.empty((len(DISK.measures), 300)), np.empty((len(DISK.counts), 300), np.int32)
    DISK.integrate.load()(
        np.ascontiguousarray(given[:7]), np.array([60.0, 0.0, lossy_runner.FLAT_TILT, 1e-8]), measures, counts
    )
    found = lossy_runner.run(given, duration=60.0, variant="integrate_bare")
    bounded = counts[0] == 1
    assert bounded.sum() > 250
    allowed = found.tilt_error + measures[TILT_ERROR]
    for mine, its in ((found.tilt_min, measures[0]), (found.tilt_max, measures[1])):
        assert (np.abs(mine - its) <= allowed)[bounded].all()
        assert np.abs(mine - its)[bounded].max() < 1e-8
    assert all((getattr(found, name) == 0.0).all() for name in LOSSES)


@pytest.mark.slow_lane
def test_a_criterion_changes_nothing_but_when_it_was_broken():
    """Another criterion changes only the breach times, so an atlas can be reclassified without integration."""
    given = cells(100, 10)
    found = lossy_runner.run(given)
    for limit in [0.1, 0.7]:
        judged = lossy_runner.run(given, limited=1.0, limit=limit)
        truth = referee.run(given, duration=30.0, flat_tilt=lossy_runner.FLAT_TILT, limit=limit)
        same = truth.ending == judged.ending
        assert same.mean() > 0.98, limit
        broken = same & np.isfinite(judged.breach_time)
        assert broken.sum() > 25, limit
        assert np.array_equal(np.isfinite(truth.breach_time)[same], np.isfinite(judged.breach_time)[same]), (
            limit
        )
        np.testing.assert_allclose(
            judged.breach_time[broken], truth.breach_time[broken], rtol=1e-5, atol=AT_ONCE
        )
        later = broken & (truth.breach_time > AT_ONCE)
        np.testing.assert_allclose(judged.breach_time[later], truth.breach_time[later], rtol=1e-5, atol=1e-9)
        judged.breach_time = found.breach_time
        assert np.array_equal(lossy_runner.bits(found), lossy_runner.bits(judged)), limit


def test_a_criterion_in_sizes_of_the_perturbation():
    """A tilt rate counts as the tilt it is worth; a standing disk falls like exp(t/sqrt(1 + alpha/2))."""
    rate = 1e-3
    given = referee.starts(tilt=0.0, tilt_rate=rate, alpha=0.5)
    found = lossy_runner.run(given, limited=2.0, limit=20.0)
    # small tilts: tilt = (rate/k) sinh(k t) with k^2 = 1/(1 + alpha/2)
    k = 1.0 / math.sqrt(1.25)
    assert found.breach_time == pytest.approx(math.asinh(20.0) / k, rel=1e-4)


def test_a_law_that_a_cell_lacks_changes_it_by_less_than_its_errors():
    """A cell with a zero arm, computed by the variant with the law, has no event and no force from it."""
    lacked = ("contour_damping", "rolling_friction", "pivoting_friction", "friction")
    given = lossy_cells.without(lossy_cells.random_cells(900, np.random.default_rng(11))["bildsten"], lacked)
    plain, full = (
        lossy_runner.run(given, air="bildsten", variant=name) for name in ("integrate_dry_bildsten", "")
    )
    assert np.array_equal(plain.ending, full.ending)
    assert UNRESOLVED not in plain.ending
    assert (np.abs(plain.end_time - full.end_time) <= full.time_error).all()
    assert (np.abs(plain.tilt_max - full.tilt_max) <= full.tilt_error).all()


@pytest.mark.slow_lane
def test_stated_errors(rng, count, pick):
    """For random mixtures, at most two of a hundred cells exceed their stated error, and all are resolved."""
    for case in pick(
        itertools.product(lossy_runner.AIR_LAWS, [lossy_cells.KINDS, ("nearly upright", "slow")]), 2
    ):
        air, kinds = case
        given = lossy_cells.random_cells(count(45, 300), rng, kinds)[air]
        found = lossy_runner.run(given, air=air)
        sharp, truth = (
            referee.run(given, air=air, duration=30.0, flat_tilt=lossy_runner.FLAT_TILT, rtol=rtol)
            for rtol in (1e-12, 1e-13)
        )
        # where the referee agrees with itself
        sure = (sharp.ending == truth.ending) & (
            np.abs(sharp.end_time - truth.end_time) <= 1e-7 * truth.end_time
        )
        assert sure.mean() > 0.95, case
        assert (found.ending != UNRESOLVED).mean() > 0.99, case
        assert (found.ending == truth.ending)[sure].mean() > 0.99, case
        sure &= found.ending == truth.ending
        assert found.energy_imbalance[sure].max() <= 1e-8, case
        beyond = np.abs(found.end_time - truth.end_time) > found.time_error
        beyond |= np.abs(found.tilt_max - truth.tilt_max) > found.tilt_error
        beyond |= np.abs(found.tilt_min - truth.tilt_min) > found.tilt_error
        assert beyond[sure].sum() <= 2, case


@pytest.mark.slow_lane
def test_a_wobble_states_an_informative_error_of_its_time(rng, count):
    """Compared with a thousandth of the tolerance, the median stated error is less than 500 times too large."""
    found_of, true_of, stated = [], [], []
    for air, starts in lossy_cells.random_cells(count(45, 900), rng, ("wobble", "nutating")).items():
        found, true = (lossy_runner.run(starts, air=air, tolerance=each) for each in (1e-8, 1e-11))
        flat = (found.ending == FLAT) & (true.ending == FLAT)
        found_of.append(found.end_time[flat])
        true_of.append(true.end_time[flat])
        stated.append(found.time_error[flat])
    off = np.abs(np.concatenate(found_of) - np.concatenate(true_of))
    too_large = np.concatenate(stated) / np.maximum(off, 1e-300)
    assert too_large.size > count(45, 900) // 4
    assert np.median(too_large) < 500.0
    # one of 10,000 is flat a nutation later, because it turns near flat_tilt
    assert (too_large < 1.0).sum() <= 1


def test_a_falling_disk_states_the_error_of_its_last_tilt():
    """For a disk that falls straight, the error of the largest tilt is the time error times the tilt rate."""
    for tilt in [1e-5, 1e-3]:
        given = referee.starts(tilt=tilt)
        for duration in (5.0, 7.0, 8.0):
            found = lossy_runner.run(given, duration=duration)
            truth = referee.run(given, duration=duration, rtol=1e-13)
            assert found.ending[0] == HORIZON, tilt
            assert abs(found.tilt_max - truth.tilt_max)[0] <= found.tilt_error[0], tilt
            assert found.tilt_error[0] <= 3e-5 * truth.tilt_max[0], tilt


@pytest.mark.slow_lane
def test_a_disk_that_friction_stops_states_the_error_of_what_stopped_it():
    """For small tilts left over from larger rates, the tilt alone says little about the error."""
    given = lossy_cells.random_cells(1800, np.random.default_rng(31), ("slow",))["moffatt"]
    found = lossy_runner.run(given, air="moffatt")
    truth = referee.run(given, air="moffatt", duration=30.0, flat_tilt=lossy_runner.FLAT_TILT, rtol=1e-13)
    rested = (found.ending == REST) & (truth.ending == REST)
    assert rested.sum() > 100
    for name in ("tilt_min", "tilt_max"):
        assert (np.abs(getattr(found, name) - getattr(truth, name)) <= found.tilt_error)[rested].all()
    assert found.tilt_error[rested].max() <= 3e-6


def test_an_event_within_the_first_step_has_its_time():
    """A lift-off after 34 us has the right time, with a stated error much smaller than that."""
    given = referee.starts(
        tilt=0.4476072823335149, tilt_rate=2.7809692550328946, precession_rate=-3.8006124038274267,
        alpha=0.4111687503458784, radius=0.8802334701604628, gravity=9.81, mass=0.5366619328046368,
        pivoting_friction=3.834271255551937e-4, contour_damping=3.6557912986185997e-4,
        air_viscosity=1.1297718078817759e-4,
    )  # fmt: skip
    found = lossy_runner.run(given, air="moffatt")
    truth = referee.run(given, air="moffatt", rtol=1e-13)
    assert found.ending[0] == truth.ending[0] == LIFT_OFF
    assert found.end_time[0] == pytest.approx(3.44440404e-5, rel=1e-8)
    assert found.end_time[0] == pytest.approx(truth.end_time[0], rel=1e-9)
    assert found.time_error[0] <= 1e-4 * found.end_time[0]


@pytest.mark.slow_lane
def test_a_duration_far_beyond_the_ending_changes_no_bit():
    """If the duration is far beyond the ending, it changes neither times nor steps."""
    given = cells(60, 5)
    short = lossy_runner.run(given)
    ended = np.isin(short.ending, (FLAT, REST, LIFT_OFF, SLIP))
    assert ended.sum() > 30
    long = lossy_runner.run(given[:, ended], duration=1e7)
    # steps depend on the losses only if these end a motion before its time is over
    np.testing.assert_array_equal(long.ending, short.ending[ended])
    apart = np.abs(long.end_time - short.end_time[ended])
    assert (apart <= long.time_error + short.time_error[ended]).all()
    for duration in [1e15, 1e300, 1.7e308]:
        longer = lossy_runner.run(given[:, ended], duration=duration)
        assert np.array_equal(lossy_runner.bits(longer), lossy_runner.bits(long)), duration


def test_names_of_variants():
    """There is a variant for every set of laws, and other names raise AttributeError."""
    from kernels.lossy_disk import integrate

    assert variant(True, True, False, False, 0, False) == "integrate"
    assert variant(False, False, True, True, 2, True) == "integrate_bare_rolling_pivoting_bildsten_slipping"
    assert variant(False, True, False, False, 1, False) == "integrate_viscous_moffatt"
    assert len(VARIANTS) == 96
    assert integrate.integrate_viscous is integrate.integrate_viscous
    assert not hasattr(integrate, "integrate_sticky")


def test_a_long_motion_to_flat_is_seen_early_to_need_shorter_steps():
    """Toys of 157 and 144 s stay within the tolerance, use a good part of it, and have the right times."""
    tilt, turning = np.radians([50.0, 55.0]), np.array([3.04, 3.68]) / math.sqrt(0.03755 / 9.81)
    given = referee.starts(
        tilt=tilt, precession_rate=turning, roll_rate=-turning * np.sin(tilt), radius=0.03755,
        mass=0.4387, gravity=9.81, contour_friction=5e-6, air_viscosity=1.8e-5, air_density=1.2,
    )  # fmt: skip
    settings = {"air": "bildsten", "duration": 300.0, "variant": "integrate_dry_bildsten"}
    found, finer = (lossy_runner.run(given, tolerance=each, **settings) for each in (1e-8, 1e-10))
    assert (found.ending == FLAT).all()
    assert (found.refinements > 0).any()
    assert (found.energy_imbalance <= 1e-8).all()
    # with equal steps, chosen when the first motion has ended, they use 2.1e-9 and 1.5e-9
    assert (found.energy_imbalance > 2.5e-9).all()
    assert np.abs(found.end_time / finer.end_time - 1.0).max() < 1e-7


@pytest.mark.slow_lane
def test_the_least_tolerances_are_met(pick):
    """Steps do not follow the rounding of the error: wobbles with air end within the tolerance."""
    for tolerance in pick([1e-12, 6.25e-12], 1):
        rng = np.random.default_rng(7)
        n, unit = 12, math.sqrt(0.03755 / 9.81)
        alpha, tilt = rng.uniform(0.1, 1.0, n), np.radians(rng.uniform(20.0, 86.0, n))
        turning = rng.uniform(0.8, 1.25, n) * np.sqrt(2.0 / (alpha * np.cos(tilt))) / unit
        given = referee.starts(
            tilt=tilt, precession_rate=turning, roll_rate=-turning * np.sin(tilt) * rng.uniform(0.9, 1.1, n),
            tilt_rate=rng.normal(0.0, 0.3, n) / unit, alpha=alpha, radius=0.03755, gravity=9.81, mass=0.4387,
            contour_friction=10.0 ** rng.uniform(-5.5, -3.8, n), air_viscosity=1.8e-5, air_density=1.2,
        )  # fmt: skip
        found = lossy_runner.run(
            given, tolerance=tolerance, air="bildsten", duration=600.0, variant="integrate_dry_bildsten"
        )
        assert np.isin(found.ending, (FLAT, LIFT_OFF)).all(), tolerance
        assert (found.energy_imbalance <= tolerance).all(), tolerance


def test_what_comes_behind_the_end_breaks_no_criterion():
    """A disk that slips while falling has not exceeded its tilt at the slip, although its lane continued."""
    given = referee.starts(
        tilt=np.linspace(0.01, 0.3, 40), roll_rate=0.5, contour_friction=1e-3, friction=0.4
    )
    ended = lossy_runner.run(given)
    assert (ended.ending == SLIP).all()
    for beyond, breaks in ((1e-7, False), (-1e-7, True)):
        for cell, tilt in enumerate(ended.tilt_max):
            one = np.ascontiguousarray(given[:, cell : cell + 1])
            found = lossy_runner.run(one, threads=1, limit=tilt * (1.0 + beyond))
            assert np.isfinite(found.breach_time[0]) == breaks
            assert found.end_time[0] == ended.end_time[cell]


@pytest.mark.slow_lane
def test_falls_are_resolved_with_any_tolerance(rng):
    """If a step of a coarse tolerance passes flat, the cell restarts with shorter steps."""
    for name in ["", "integrate_bare_rolling", "integrate_bare"]:
        seed, n = int(rng.integers(2**31)), 2000
        rng = np.random.default_rng(seed)
        starts = referee.starts(
            tilt=rng.uniform(0.01, 1.5, n),
            tilt_rate=rng.uniform(-1.0, 1.0, n),
            precession_rate=rng.choice([0.0, 0.1, 1.0], n) * rng.normal(size=n),
            roll_rate=rng.choice([0.0, 0.1, 1.0], n) * rng.normal(size=n),
            alpha=rng.uniform(0.05, 1.0, n),
            radius=np.ones(n),
            gravity=np.ones(n),
            mass=np.ones(n),
            pivoting_friction=rng.choice([0.0, 0.01], n) * (name == ""),
        )
        close = lossy_runner.run(starts, variant=name, duration=3.0, tolerance=1e-11)
        assert np.count_nonzero(close.ending == FLAT) > n // 20, name
        for tolerance in (1e-5, 1e-6, 1e-7, 1e-8):
            found = lossy_runner.run(starts, variant=name, duration=3.0, tolerance=tolerance)
            assert not np.any(found.ending == UNRESOLVED), (seed, tolerance)
            watched = lossy_runner.run(starts, variant=name, duration=3.0, tolerance=tolerance, limit=1.2)
            assert np.array_equal(watched.ending, found.ending), (seed, tolerance)
            assert np.array_equal(watched.end_tilt, found.end_tilt), (seed, tolerance)
            # near the end of the duration or of flat, the error decides
            same = found.ending == close.ending
            assert np.count_nonzero(~same) <= n // 100, (seed, tolerance)
            off, stated = np.abs(found.end_time - close.end_time), found.time_error + close.time_error
            assert not np.any(off[same] > stated[same] + 1e-12), (seed, tolerance)


#: Starts, with air law, tolerance and duration, that once never ended: a step landed near flat with enormous
#: rates; a rounded tilt rate reversed again and again; beyond flat, time went backward.
WITHOUT_END = [
    (
        {
            "tilt": -0.6288117402511292,
            "tilt_rate": 14.262279771913253,
            "roll_rate": 3.1393650567441003,
            "alpha": 0.8029336009374162,
            "radius": 0.02566653806696942,
            "gravity": 9.81,
            "mass": 0.030495994609085624,
            "pivoting_friction": 8.880483638088679e-06,
        },
        "none",
        0.020843978725596016,
        0.3112080137576445,
    ),
    (
        {
            "tilt": -1.5487818056464908,
            "tilt_rate": 0.018441115488913088,
            "precession_rate": -152.5159969749508,
            "roll_rate": -152.51853055291843,
            "alpha": 0.9105238399893796,
            "radius": 0.04206082631833925,
            "gravity": 9.81,
            "mass": 0.6360562481094045,
            "rolling_friction": 8.697647374686394e-05,
            "pivoting_friction": 0.000593059152452884,
            "contour_damping": 1.3058475692943483e-06,
        },
        "none",
        0.06219022774911462,
        0.303789560397222,
    ),
    (
        {
            "tilt": -1.4916643939475427,
            "tilt_rate": -1.932956436435591,
            "precession_rate": -50.73911379460104,
            "roll_rate": -53.27685948091348,
            "alpha": 0.45497634137902887,
            "radius": 0.19099068669675093,
            "gravity": 9.81,
            "mass": 0.45316777182840295,
            "rolling_friction": 0.0002453928167497726,
            "contour_friction": 2.3509781265864148e-05,
            "air_viscosity": 0.0042598453382994995,
            "air_density": 1.0,
        },
        "moffatt",
        0.07114854108594351,
        0.1499433257167631,
    ),
]


def test_a_motion_that_was_followed_without_end_ends():
    """The motion ends after few steps, not ten million."""
    for case in WITHOUT_END:
        start, air, tolerance, duration = case
        found = lossy_runner.run(referee.starts(**start), air=air, tolerance=tolerance, duration=duration)
        assert found.steps[0] < 10000, case


def test_every_motion_ends_with_any_tolerance(rng):
    """New mixtures of laws and motions in every run end, even with the coarsest allowed tolerances."""
    seed = int(rng.integers(2**31))
    rng = np.random.default_rng(seed)
    for _ in range(4):
        tolerance, duration = 10.0 ** rng.uniform(-5, -1), 10.0 ** rng.uniform(-1, 0.5)
        # pytest shows this output if the test is killed
        sys.stderr.write(f"{seed} {tolerance} {duration}\n")
        for air, starts in lossy_cells.random_cells(90, rng).items():
            found = lossy_runner.run(starts, air=air, tolerance=tolerance, duration=duration)
            assert found.steps.max() < 1e6, (seed, air, tolerance)
            known = found.ending != UNRESOLVED
            assert (found.energy_imbalance[known] <= tolerance).all(), (seed, air, tolerance)
            moved = known & ~np.isin(found.ending, (INVALID, UNDISTURBED))
            for name in set(MEASURES) - {"breach_time"}:
                values = getattr(found, name)[moved]
                assert np.isfinite(values).all(), (seed, air, tolerance, name)
                assert not name.endswith("_error") or (values >= 0.0).all(), (seed, air, tolerance, name)
            assert np.count_nonzero(~known) <= 1, (seed, air, tolerance)
