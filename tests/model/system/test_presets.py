"""The five preset systems, against closed forms, symmetries and numbers of the literature."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import mathieu_a

import sweep
from kernels.system.endings import FIRST_EVENT
from sweep.engine.compute import compute
from sweep.request.system_file import read_system
from sweep.systems import System

pytestmark = pytest.mark.compiled

PRESETS = Path(sweep.__file__).parent / "model" / "system" / "presets"
NAMES = ("driven_pendulum", "henon_heiles", "kapitza", "magnets", "thomas")


def compass(n, rng, most=2.0 * np.pi / 3.0):
    """Return 3n directions: n random ones, then the same turned by 120 and by 240 degrees."""
    first = rng.uniform(0.0, most, n)
    return np.concatenate([first + third * 2.0 * np.pi / 3.0 for third in range(3)])


def cells(spec, **starts):
    """Return the results of a system's kernels for some starts, with all other parameters as in the spec."""
    shape = np.broadcast_shapes(*(np.shape(each) for each in starts.values()))
    known = {name: each.default for name, each in spec.model.parameters.items()} | starts
    return compute(spec, {name: np.full(shape, 0.0) + value for name, value in known.items()})


def runge_kutta(rate, state, step, count):
    """Yield the state after each step of the classical Runge-Kutta method."""
    time = 0.0
    for _ in range(count):
        one = rate(time, state)
        two = rate(time + 0.5 * step, state + 0.5 * step * one)
        three = rate(time + 0.5 * step, state + 0.5 * step * two)
        four = rate(time + step, state + step * three)
        state, time = state + step / 6.0 * (one + 2.0 * two + 2.0 * three + four), time + step
        yield state


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_is_ten_lines_with_a_title(name):
    """Its definition has at most ten lines of code, and its request has two axes."""
    spec = sweep.SweepSpec.preset(name)
    text = (PRESETS / f"{name}.py").read_text(encoding="utf-8")
    assert len(re.findall(r"^.*\S", text[text.index("@system") :], re.M)) <= 10
    assert spec.model.name == name
    assert spec.model.headline(spec)[0].isupper()
    assert len(spec.axes) == 2
    assert spec.size >= 10_000


def kapitza_edges(ratio):
    """Return the measured boundary over sqrt(2 g l)/a for starts at 0.1 and 30 degrees, at a ratio a/l."""
    critical = np.sqrt(2.0 * 9.81 * 0.2) / (0.2 * ratio)
    atlas = sweep.run(
        "kapitza", angle="0.1deg,30deg", shake=f"{0.9 * critical}:{1.2 * critical}:13", amplitude=0.2 * ratio,
        duration="40s", boundary=f"refined:{1e-4 * critical}",
    )  # fmt: skip
    edge = atlas.eulerdisk.boundary()
    # The theory line must not create a lower edge where no cell has one.
    assert "boundary_lower_shake" not in atlas
    assert edge.critical.values == pytest.approx(critical, rel=1e-12)
    return edge.measured.values / critical


@pytest.mark.release
def test_kapitza_holds_from_the_rate_of_theory():
    """As a/l goes to 0 it is sqrt(2 g l)/a for small angles, and that over sqrt(cos angle) at an angle.

    For small angles the equation is Mathieu's: its solutions are bounded from a_0(2 a/l) = -4 g/(l shake^2)
    on. The effective potential cos(angle) + (shake/critical)^2 sin(angle)^2/2 has its maximum where
    cos(angle) is (critical/shake)^2; its error halves with a/l.
    """
    ratios = np.array([0.1, 0.05])
    edges = np.array([kapitza_edges(each) for each in ratios])
    mathieu = ratios * np.sqrt(-2.0 / mathieu_a(0, 2.0 * ratios))
    # Near the boundary growth is slow, so within 40 s a motion seems to stay up a little below it.
    assert np.all((edges[:, 0] < mathieu + 1e-4) & (edges[:, 0] > mathieu - 4e-4))
    wide, narrow = 1.0 - edges[:, 1] * np.sqrt(np.cos(np.radians(30.0)))
    assert 0.0 < narrow < wide < 0.02
    assert abs(2.0 * narrow - wide) < 0.0025


def stars_gone(u, v, duration):
    """Return which stars starting in the middle have passed a gap, by Runge-Kutta steps."""
    gone = np.zeros(u.shape, bool)

    def rate(_, state):
        x, y, u, v = state
        return np.array([u, v, -x - 2.0 * x * y, -y - x * x + y * y])

    start = np.array([0.0 * u, 0.0 * u, u, v])
    for state in runge_kutta(rate, start, 0.04, round(duration / 0.04)):
        x, y = np.where(gone, 0.0, state[:2])
        gone |= np.max([2.0 * y, -np.sqrt(3.0) * x - y, np.sqrt(3.0) * x - y], axis=0) > 2.4
        state[:, gone] = 0.0
    return gone


def test_no_star_leaves_below_the_critical_energy(rng):
    """It is 1/6 for Henon-Heiles; above it each gap gets as many stars as by another method."""
    spec = sweep.SweepSpec.preset("henon_heiles")
    codes = {name: code for code, name in spec.model.endings.flags.items()}
    turned = {codes["right"]: codes["top"], codes["top"]: codes["left"], codes["left"]: codes["right"]}
    for energy in (0.1, 1.0 / 6.0 - 1e-6, 0.18, 0.3):
        way = compass(200, rng)
        speed = np.sqrt(2.0 * energy)
        found = cells(spec, u=speed * np.cos(way), v=speed * np.sin(way))
        ending = found["ending"].reshape(3, -1)
        gone = np.isin(ending, list(turned))
        leave = (
            stars_gone(speed * np.cos(way), speed * np.sin(way), 100.0) if energy > 1.0 / 6.0 else np.zeros(1)
        )
        # The two methods may differ for sensitive cells.
        assert gone.mean() == pytest.approx(
            leave.mean(), abs=(found["ending"] == codes["sensitive"]).mean() + 0.01
        )
        assert np.nanmax(found["conserved_change"]) < 1e-10
        for one, other in pairwise(ending):
            both = np.isin(one, list(turned)) & np.isin(other, list(turned))
            assert [turned[code] for code in one[both]] == list(other[both])


def test_a_faster_star_leaves_earlier(rng):
    """The last one of 600 stars leaves sooner with more energy, at 0.3, 0.6 and 1.2."""
    spec = sweep.SweepSpec.preset("henon_heiles")
    last = []
    for energy in (0.3, 0.6, 1.2):
        way, speed = compass(200, rng), np.sqrt(2.0 * energy)
        last.append(cells(spec, u=speed * np.cos(way), v=speed * np.sin(way))["end_time"].max())
    assert last == sorted(last, reverse=True)


@pytest.mark.slow_lane
def test_the_basins_of_three_magnets_have_their_symmetry(rng):
    """A start turned by 120 degrees stops over the next magnet; only the middle stops over none."""
    spec = sweep.SweepSpec.preset("magnets")
    radius, way = rng.uniform(0.2, 2.0, 500), compass(500, rng, 2.0 * np.pi)
    found = cells(spec, x=np.tile(radius, 3) * np.cos(way), y=np.tile(radius, 3) * np.sin(way))
    label = found["label"].reshape(3, -1)
    after = np.array([0, 2, 3, 1])  # none, east -> north -> south -> east
    decided = (label != 0).all(axis=0)
    assert decided.mean() > 0.99
    for one, other in pairwise(label):
        assert np.array_equal(after[one[decided]], other[decided])
    counts = [np.bincount(row[decided], minlength=4)[1:] for row in label]
    assert [list(np.roll(counts[0], turn)) for turn in range(3)] == [list(each) for each in counts]
    assert min(counts[0]) > 50
    # They stop between the magnet and the middle, where the spring balances the magnet.
    at_rest = np.hypot(found["x_end"], found["y_end"])[found["label"] > 0]

    def pull(x):
        near, far = ((x - 1.0) ** 2 + 0.25**2) ** -1.5, ((x + 0.5) ** 2 + 0.75 + 0.25**2) ** -1.5
        return 0.5 * x + (x - 1.0) * near + 2.0 * (x + 0.5) * far

    assert at_rest == pytest.approx(brentq(pull, 0.9, 1.0), abs=1e-4)
    middle = cells(spec, x=np.zeros(1), y=0.0)
    assert list(middle["label"]) == [0]


@pytest.mark.release
def test_the_origin_takes_all_of_thomas_above_one(rng):
    """For b > 1 the distance falls at least as exp((1 - b) t), as |sin y| <= |y|; else two points attract."""
    spec = sweep.SweepSpec.preset("thomas").replace(duration=20.0)
    starts = dict(zip("xyz", rng.uniform(-10.0, 10.0, (3, 300)), strict=True))
    b = rng.uniform(1.01, 2.0, 300)
    found = cells(spec, **starts, b=b)
    begun, ended = (np.sqrt(sum(each**2 for each in one)) for one in (
        starts.values(), [found[f"{name}_end"] for name in "xyz"]
    ))  # fmt: skip
    assert np.all(ended <= begun * np.exp((1.0 - b) * 20.0) * (1.0 + 1e-9))
    spec = spec.replace(duration=1000.0)
    for b in (0.95, 0.6):
        point = brentq(lambda x, b=b: np.sin(x) - b * x, 1e-3, 3.1)
        found = cells(spec, x=np.array([0.1, -0.1]), y=0.05 * np.array([1.0, -1.0]), z=0.0, b=b)
        for name in "xyz":
            assert found[f"{name}_end"] == pytest.approx([point, -point], abs=1e-9)
        assert list(found["label"]) == ([1, 2] if 3.0 * point > 1.0 else [3, 3])


@pytest.mark.slow_lane
def test_the_two_points_of_thomas_lose_their_stability_where_they_must():
    """They do where cos x = -2 b and sin x = b x: b = 0.32899, by linear eigenvalues (Thomas 1999).

    The distance from the point changes as exp(-(b + cos(x)/2) t).
    """
    critical = brentq(lambda x: np.tan(x) + x / 2.0, 1.7, 3.1)
    assert np.sin(critical) / critical == pytest.approx(0.32899, abs=1e-5)
    spec = sweep.SweepSpec.preset("thomas")
    for b in (0.35, 0.33, 0.328, 0.32):
        point = brentq(lambda x, b=b: np.sin(x) - b * x, 0.5, 3.1)
        far = []
        for duration in (100.0, 200.0):
            found = cells(
                spec.replace(duration=duration), x=np.array([point + 1e-4]), y=point - 1e-4, z=point, b=b
            )
            far.append(np.sqrt(sum((found[f"{name}_end"] - point) ** 2 for name in "xyz"))[0])
        rate = np.log(far[1] / far[0]) / 100.0
        assert rate == pytest.approx(-(b + np.cos(point) / 2.0), abs=2e-3)
        assert (rate < 0.0) == (b > 0.32899)


@pytest.mark.release
def test_a_weakly_driven_pendulum_has_its_linear_resonance():
    """At time 300 the angle is the linear oscillator's stationary one, up to the square of the torque."""
    off = []
    for torque in (1e-2, 1e-3):
        atlas = sweep.run("driven_pendulum", torque=torque, drive="0.2:1.6:15", duration=300.0)
        w = atlas.drive.values
        response = torque / ((1.0 - w**2) + 0.1j * w)
        stationary = (response * np.exp(1j * w * 300.0)).real
        off.append(np.max(np.abs(atlas.angle_end.values - stationary) / np.abs(response)))
    assert off[0] < 2e-3
    assert off[1] < off[0] / 50.0


@pytest.mark.slow_lane
def test_no_pendulum_turns_over_below_the_torque_of_melnikov():
    """It is (4 damping/pi) cosh(pi drive/2). Another method finds the same least torque."""
    atlas = sweep.run("driven_pendulum", torque="0.02:1:50", drive="0.2:1.6:50")
    turned = atlas.ending == FIRST_EVENT
    line = 0.4 / np.pi * np.cosh(np.pi * atlas.drive / 2.0)
    assert int(turned.sum()) > 300
    over = (atlas.torque / line).where(turned)
    assert float(over.min()) > 1.0
    # The drive rate whose least torque is nearest to the bound.
    column = int(np.nanargmin(over.min("torque").values))
    torque, drive = atlas.torque.values, float(atlas.drive[column])
    start, turned_over = np.zeros((2, torque.size)), np.zeros(torque.size, bool)

    def rate(t, state):
        return np.array([state[1], torque * np.cos(drive * t) - 0.1 * state[1] - np.sin(state[0])])

    for state in runge_kutta(rate, start, 0.04, 5_000):
        turned_over |= np.abs(state[0]) > np.pi
    assert torque[turned_over].min() == torque[turned.isel(drive=column).values].min()
    assert atlas.critical_lower_torque.values == pytest.approx(line.values)


def test_the_saddles_of_henon_and_heiles():
    """At (0, 1) and rotated by 120 degrees: a star leaves as cosh t and swings across at rate root 3.

    There (x^2 + y^2)/2 + x^2 y - y^3/3 has second derivatives of 3 across the way out and -1 along it.
    """
    for turn in 2.0 * np.pi / 3.0 * np.arange(3):
        x, y = -np.sin(turn), np.cos(turn)
        assert (x * x + y * y) / 2.0 + x * x * y - y**3 / 3.0 == pytest.approx(1.0 / 6.0, rel=1e-14)
        near = 1e-7
        out = sweep.simulate("henon_heiles", x=x * (1.0 - near), y=y * (1.0 - near), u=0, v=0, duration=4)
        along = 1.0 - (x * out.x.values + y * out.y.values)
        # This holds to first order in the distance, which grows by a factor of about 30.
        assert along == pytest.approx(near * np.cosh(out.elapsed_time.values), rel=1e-5)
        swing = sweep.simulate("henon_heiles", x=x + near * y, y=y - near * x, u=0, v=0, duration=4)
        across = y * swing.x.values - x * swing.y.values
        assert across == pytest.approx(
            near * np.cos(np.sqrt(3.0) * swing.elapsed_time.values), abs=1e-5 * near
        )


def test_motions_of_thomas_are_chaotic_where_sprott_and_chlouverakis_say():
    """Chaos begins at b = 0.208186: over 2000 none of 32 motions is sensitive at 0.209, all are at 0.208."""
    words = dict.fromkeys("xyz", "uniform:-3:3") | {"samples": 32, "seed": 3, "duration": 2000}
    for b, expected in ((0.209, 0), (0.208, 32)):
        atlas = sweep.run("thomas", b=b, **words)
        codes = dict(zip(atlas.ending.flag_meanings.split(), atlas.ending.flag_values, strict=True))
        assert int((atlas.ending == codes["sensitive"]).sum()) == expected, b


@pytest.mark.release
def test_the_driven_pendulum_doubles_its_period_where_taylor_says():
    """At 1.0663 and 1.0793 for damping 1/2, drive 2/3, -90 degrees (Taylor, Classical Mechanics, tab. 12.1).

    Taylor's drive rate is 2 pi, his natural rate 1.5 times that, and his damping 2 beta half the natural
    rate. The preset ends when the pendulum turns over, which it does before it settles; so the system here
    has no such ending.
    """
    pendulum = System(
        read_system("""
@system(duration="200")
def pendulum(angle=-1.5707963267948966, speed=0.0, *, damping=0.5, torque=1.0, drive=0.6666666666666666, t):
    return speed, torque*cos(drive*t) - damping*speed - sin(angle)
""")
    )
    turn = 3.0 * np.pi
    for torque, expected in ((1.0655, 1), (1.067, 2), (1.0785, 2), (1.0803, 4)):
        motion = sweep.simulate(pendulum, torque=torque, duration=1000 * turn, interval=turn)
        speed = motion.speed.values
        same = [n for n in (1, 2, 4) if abs(speed[-1] - speed[-1 - n]) < 1e-6]
        assert same[0] == expected, torque
