"""Systems in lanes compared with closed forms: states, event times, largest values, and no missed event."""

import math

import numpy as np
import pytest
from system_passes import run

from kernels.system.endings import ENDLESS, FIRST_EVENT, GROWS, JUMPS, RUNS_ON, UNRESOLVED
from kernels.system.integrate import numbers_of, program_of
from kernels.system.lanes import LEGS
from sweep.model.system.model import model_of
from sweep.request.system_file import read_system

OSCILLATOR = """
@system(duration="20 s", ends={"above": "x > level"}, measures={"top": "max x", "bottom": "min x"})
def oscillator(x: "m" = 1.0, v: "m/s" = 0.0, *, rate: "rad/s" = 1.0, damping: "1/s" = 0.0, level: "m" = 1e300):
    return v, -(rate**2)*x - 2*damping*v
"""
PENDULUM = """
@system(duration="40", ends={"past": "abs(angle) > level"}, measures={"top": "max abs(angle)"})
def pendulum(angle=0.2, speed=0.0, *, damping=0.0, torque=0.3, drive=0.7, level=1e300, t):
    return speed, torque*cos(drive*t) - damping*speed - sin(angle)
"""
BLOW_UP = """
@system(duration="2")
def blow_up(y=1.0):
    return y**2
"""


@pytest.mark.slow_lane
def test_a_damped_oscillator(rng):
    """Final states agree with the closed form at any rates, to 1e-10 of the amplitude."""
    n = 200
    rate = 10.0 ** rng.uniform(-2.0, 2.0, n)
    damping, x, v = rate * rng.uniform(0.0, 0.9, n), rng.normal(size=n), rate * rng.normal(size=n)
    endings, found, _ = run(OSCILLATOR, {"x": x, "v": v, "rate": rate, "damping": damping}, 3.0)
    own = np.sqrt(rate**2 - damping**2)
    b = (v + damping * x) / own
    truth = np.exp(-damping * 3.0) * (x * np.cos(own * 3.0) + b * np.sin(own * 3.0))
    assert np.all(endings == RUNS_ON)
    assert np.all(np.abs(found[-1, 0] - truth) <= 1e-10 * np.hypot(x, b))


def test_units_and_sizes_do_not_matter(rng):
    """In other units of state or time, the relative error is the same, so no size is preferred."""
    x, v = rng.normal(size=50), rng.normal(size=50)
    for size in (1e-30, 1e-9, 1.0, 1e12):
        for rate in (1e-6, 1.0, 1e6):
            _, found, _ = run(
                OSCILLATOR, {"x": size * x, "v": size * rate * v, "rate": np.full(50, rate)}, 5.0 / rate
            )
            truth = x * math.cos(5.0) + v * math.sin(5.0)
            assert np.all(np.abs(found[-1, 0] / size - truth) <= 1e-10 * np.hypot(x, v)), (size, rate)


def test_greatest_and_least_values(rng):
    """Extreme values between steps are right to 1e-12 of the amplitude."""
    x, v = rng.normal(size=300), rng.normal(size=300)
    _, found, _ = run(OSCILLATOR, {"x": x, "v": v}, 12.0)
    size = np.hypot(x, v)
    assert np.all(np.abs(found[-1, 3] - size) <= 1e-12 * size)
    assert np.all(np.abs(-found[-1, 4] + size) <= 1e-12 * size)


def test_the_time_of_an_event(rng):
    """A motion ends when it passes a level, to 1e-10 of the duration, or at once if it starts beyond."""
    level = np.append(rng.uniform(-0.99, 0.99, 300), [-2.0, 1.5])
    endings, found, _ = run(OSCILLATOR, {"x": np.full(302, -1.0), "level": level}, 20.0)
    truth = np.append(np.arccos(-level[:300]), [0.0, 20.0])
    assert np.all(endings[-1] == np.append(np.full(301, FIRST_EVENT), RUNS_ON))
    assert np.all(np.abs(found[-1, 2] - truth) <= 1e-10 * 20.0)
    assert np.all(np.abs(found[-1, 0, :300] - level[:300]) <= 1e-10)


@pytest.mark.slow_lane
def test_no_excursion_is_missed(rng):
    """A motion that briefly exceeds a level ends there or states that a step was not proved to stay below."""
    n = 256
    starts = {
        "angle": rng.uniform(-2.0, 2.0, n), "speed": rng.uniform(-1.0, 1.0, n), "damping": rng.uniform(0.0, 0.3, n),
        "torque": rng.uniform(0.0, 0.5, n),
    }  # fmt: skip
    _, free, _ = run(PENDULUM, starts)
    top = np.maximum(free[-1, 3], free[-1, 4])
    for beyond, least in ((1e-2, 1.0), (1e-4, 1.0), (1e-6, 1.0), (1e-8, 1.0), (1e-10, 0.9)):
        endings, _, counts = run(PENDULUM, {**starts, "level": (1.0 - beyond) * top})
        ended = endings[-1] == FIRST_EVENT
        assert np.all(ended | (counts[1] > 0)), beyond
        assert ended.mean() >= least, beyond
    # a level above the excursion ends nothing
    endings, _, _ = run(PENDULUM, {**starts, "level": (1.0 + 1e-8) * top})
    assert np.all(endings[-1] == RUNS_ON)


def test_bits_depend_on_the_cell_alone(rng):
    """A cell has the same bits alone, in another order, and among others that end early."""
    n = 97
    starts = {
        "angle": rng.uniform(-3.0, 3.0, n),
        "speed": rng.uniform(-1.0, 1.0, n),
        "level": np.full(n, 2.5),
    }
    endings, found, counts = run(PENDULUM, starts)
    order = rng.permutation(n)
    again = run(PENDULUM, {name: each[order] for name, each in starts.items()})
    alone = run(PENDULUM, {name: each[:1] for name, each in starts.items()})
    for whole, shuffled, one in zip((endings, found, counts), again, alone, strict=True):
        np.testing.assert_array_equal(whole[..., order], shuffled)
        np.testing.assert_array_equal(whole[..., :1], one)


@pytest.mark.slow_lane
def test_what_cannot_be_followed_is_unresolved():
    """For y' = y^2, which diverges at 1, the cell reports growth and how far it was followed; others continue."""
    endings, found, _ = run(BLOW_UP, {"y": np.array([1.0, 0.1, -1.0, math.nan, math.inf])})
    assert endings[-1].tolist() == [GROWS, RUNS_ON, RUNS_ON, UNRESOLVED, UNRESOLVED]
    assert np.isnan(found[-1, [0, 2]][:, [0, 3, 4]]).all()
    assert found[-1, 1, [0, 3, 4]] == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert found[-1, 0, 1] == pytest.approx(0.1 / (1.0 - 0.2), rel=1e-12)


@pytest.mark.compiled
def test_smaller_tolerances_are_closer(rng):
    """The error falls with the tolerance to the power 12/12 to 12/10, by the term that sets the step."""
    x, v = rng.normal(size=200), rng.normal(size=200)
    errors = []
    for tolerance in (1e-6, 1e-8, 1e-10):
        _, found, _ = run(OSCILLATOR, {"x": x, "v": v}, 20.0, tolerance)
        errors.append(np.median(np.abs(found[-1, 0] - x * math.cos(20.0) - v * math.sin(20.0))))
    slopes = np.log(np.divide(errors[:-1], errors[1:])) / math.log(100.0)
    assert np.all((slopes > 0.95) & (slopes < 1.35)), errors


def test_the_longest_step(rng):
    """A maximum step limits all steps; their number is that of the duration plus one."""
    _, _, counts = run(OSCILLATOR, {"x": rng.normal(size=5)}, 20.0, step=0.05)
    assert np.all(np.abs(counts[0] - len(LEGS) * 400) <= len(LEGS))


@pytest.mark.slow_lane
def test_a_series_without_terms_at_the_start():
    """All terms of t^12 vanish at the start, but the result is right with and without a maximum step."""
    late, y = '@system(duration="2")\ndef late(y=1.0, *, t):\n    return t**12\n', {"y": np.array([1.0, 5.0])}
    for step in (0.0, 0.05):
        endings, found, _ = run(late, y, step=step)
        assert endings[-1].tolist() == [RUNS_ON] * 2
        assert np.all(np.abs(found[-1, 0] - y["y"] - 2.0**13 / 13.0) <= 1e-9)


def test_a_rate_that_jumps_says_so():
    """The terms of cos(t^3) that set the step vanish only at the start; the jump in rate is reported."""
    text = '@system(duration="3")\ndef chirp(y=0.0, *, t):\n    return cos(t**3)\n'
    endings, found, _ = run(text, {"y": np.array([0.0])})
    assert endings[-1].tolist() == [JUMPS]
    assert np.isnan(found[-1, [0, 2]]).all()
    assert found[-1, 1] == [0.0]
    endings, found, _ = run(text, {"y": np.array([0.0])}, step=0.1)
    assert endings[-1].tolist() == [RUNS_ON]


@pytest.mark.slow_lane
def test_whole_powers_of_negative_numbers():
    """Large integer powers of negative numbers work: for y' = y^n, y^(1 - n) changes by (1 - n) t."""
    text = '@system(duration="0.2")\ndef p(a=-1.0, b=-0.9, c=-0.9):\n    return a**-9, b**17, c**40\n'
    endings, found, _ = run(text, {"a": np.array([-1.0])})
    assert endings[-1].tolist() == [RUNS_ON]
    truth = (
        (1.0 + 10.0 * 0.2) ** (1 / 10),
        (0.9**-16 - 16.0 * 0.2) ** (-1 / 16),
        (0.9**-39 + 39.0 * 0.2) ** (-1 / 39),
    )
    np.testing.assert_allclose(found[-1, :3, 0], np.negative(truth), rtol=1e-11)


@pytest.mark.slow_lane
def test_a_cell_of_too_many_steps_is_given_up_at_once():
    """A cell that exceeds the step limit is not retried, because a smaller tolerance needs more steps."""
    endings, _, counts = run(
        '@system(duration="1")\ndef p(y=1.0):\n    return 1.0\n', {"y": np.array([1.0])}, step=5e-8
    )
    assert endings[:, 0].tolist() == [ENDLESS] * len(LEGS)
    assert 1e7 <= counts[0, 0] <= 1.001e7


@pytest.mark.slow_lane
def test_a_root_that_reaches_zero_is_unresolved():
    """Beyond the zero of a root, the series continues but the motion does not, so there is no result."""
    endings, found, _ = run(
        '@system(duration="3")\ndef drain(y=4.0):\n    return -sqrt(y)\n', {"y": np.array([1.0, 4.0])}
    )
    assert endings[-1].tolist() == [JUMPS, RUNS_ON]
    assert found[-1, 1, 0] == pytest.approx(2.0, rel=1e-6)
    assert found[-1, 0, 1] == pytest.approx(0.25, rel=1e-11)


@pytest.mark.slow_lane
def test_events_at_the_very_end_and_levels_that_are_approached():
    """A ramp that reaches a level at the end, and a motion that converges to one, run on with few steps."""
    text = (
        '@system(duration="2", ends={"over": "x > 1"})\n'
        "def ramp(x=0.0, *, rate=0.5, pull=0.0):\n    return rate + pull*(1 - x)\n"
    )
    endings, found, counts = run(text, {"rate": np.array([0.49, 0.5, 0.51])})
    assert endings[-1].tolist() == [RUNS_ON, RUNS_ON, FIRST_EVENT]
    rest = {"x": np.array([0.0, 0.5, 1.0]), "rate": np.zeros(3), "pull": np.ones(3)}
    endings, found, counts = run(text, rest, 100.0)
    assert endings[-1].tolist() == [RUNS_ON] * 3
    assert np.all(np.abs(found[-1, 0] - 1.0) <= 1e-12)
    assert counts[0].max() <= 20_000


@pytest.mark.slow_lane
def test_an_event_and_a_measure_without_a_value_are_unresolved():
    """If an ending or a measure has no value along the motion, the cell is unresolved; otherwise it runs on."""
    text = (
        '@system(duration="3", ends={"far": "sqrt(y+a) > 4", "big": "y/b > 1"}, measures={"top": "max sqrt(y+c)"})\n'
        "def still(y=1.0, *, r=0.1, a=9.0, b=1.0, c=9.0):\n    return -r\n"
    )
    a, b, c = np.array([[9.0, 0.0, 9.0, 9.0], [1.0, 1.0, 1e-310, 1.0], [9.0, 9.0, 9.0, 0.0]])
    for y in (-1.0, -2.0):
        endings, _, _ = run(text, {"y": np.full(4, y), "a": a, "b": b, "c": c})
        assert endings[-1].tolist() == [RUNS_ON, UNRESOLVED, UNRESOLVED, UNRESOLVED], y


@pytest.mark.slow_lane
def test_a_state_of_rounding_alone_is_followed():
    """If the terms of a rate cancel to rounding, the motion still has its numbers."""
    text = '@system(duration="10")\ndef both(x=1.0, v=0.0, d=0.0):\n    return v, -x, 0.3*(x + v) - 0.3*x - 0.3*v\n'
    endings, found, _ = run(text, {"x": np.array([1.0, 0.3, 7.0])})
    assert endings[-1].tolist() == [RUNS_ON] * 3
    assert np.all(np.abs(found[-1, 0] - np.array([1.0, 0.3, 7.0]) * math.cos(10.0)) <= 1e-10)
    assert np.all(np.abs(found[-1, 2]) <= 1e-12)


def test_code_has_another_name_for_other_endings():
    """Two events with one ending and the same two with two endings have different machine code."""
    one, two = '{"left": "x > 1 or x < -1"}', '{"right": "x > 1", "left": "x < -1"}'
    text = '@system(duration="1", ends={})\ndef walk(x=0.0):\n    return 1.0\n'
    names = []
    for ends in (one, two, two):
        program = model_of(read_system(text.replace("{}", ends))).integrate.function
        names.append(numbers_of(*program_of(program), LEGS)[3])
    assert names[0] != names[1] == names[2]
