"""The integrator of exported pages, in the browser that runs it: no other program reads its JavaScript for users."""

import json
import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import sweep
from sweep.explorer.motion import motion, stored_motions
from sweep.figures.disk.disk_3d import Pose
from sweep.request.spec import SweepSpec

#: Numbers that are new in every run; a failure prints the start.
RANDOM = np.random.default_rng(3)

NAMES = ("tilt", "tilt_rate", "precession_rate", "roll_rate", "alpha")

#: Ranges of the starts; rates in units of sqrt(gravity/radius).
LOW, HIGH = (-1.2, -0.5, -2.5, -2.5, 0.2), (1.2, 0.5, 2.5, 2.5, 1.0)

#: Samples of a motion.
SAMPLES = 200

INTEGRATE = """async ([starts, times, fall]) => {
  const { integrate } = await import("eulerdisk/motion/integrator");
  const plain = (key, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value);
  return JSON.stringify(starts.map((start) => integrate(start, times, fall)), plain);
}"""

STORED = """async ([start, stored, title]) => {
  const { storedMotion } = await import("eulerdisk/motion/stored_motion");
  const plain = (key, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value);
  return JSON.stringify(storedMotion(start, stored, title), plain);
}"""

POTENTIAL = """async ([start, fall]) => {
  const { potentialOf } = await import("eulerdisk/motion/potential");
  const plain = (key, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value);
  return JSON.stringify(potentialOf(start, fall), plain);
}"""

POSE = """async (poses) => {
  const { poseOf } = await import("eulerdisk/motion/disk_scene");
  const names = ["centre", "painted", "aside", "axis"];
  return poses.map((pose) => {
    const found = poseOf(...pose);
    return Object.fromEntries(names.map((name) => [name, found[name].toArray()]));
  });
}"""


@pytest.fixture(scope="module")
def page(browser, explorer):
    """Return a page of the explorer, for its modules."""
    context = browser.new_context()
    page = context.new_page()
    page.goto(explorer.url)
    yield page
    context.close()


def answer(page, code, given):
    """Return what a function of the page says, as JSON: ten times as fast as arrays, and NaN is None."""
    return json.loads(page.evaluate(code, given))


def random_starts(count, radius):
    """Return starts as the page has them, in SI units."""
    unit = math.sqrt(radius / 9.81)
    starts = []
    for values in RANDOM.uniform(LOW, HIGH, (count, len(NAMES))):
        scaled = dict(zip(NAMES, values.tolist(), strict=True))
        rates = {name: value / unit for name, value in scaled.items() if name.endswith("rate")}
        starts.append({**scaled, **rates, "radius": radius, "gravity": 9.81})
    return starts


@pytest.mark.parametrize(("radius", "duration", "count"), [(0.5, 20.0, 100), (0.011, 3.0, 20)])
def test_motions_are_those_of_the_kernels(page, radius, duration, count):
    """New starts in every run, of a large disk for 20 s and of a coin, are within 1e-6 of the kernels; so are falls."""
    spec = SweepSpec.preset("rolling")
    starts = random_starts(count, radius)
    times = np.linspace(0.0, duration, SAMPLES + 1)
    found = answer(page, INTEGRATE, [starts, times.tolist(), spec.fall_tilt])
    for start, each in zip(starts, found, strict=True):
        compare(each, sweep.simulate(**start, duration=duration, interval=duration / SAMPLES), start)


def compare(found, expected, start):
    """Hold a motion of the page against one of the kernels, in units of the radius and sqrt(radius/gravity)."""
    unit, weight = math.sqrt(start["radius"] / start["gravity"]), start["gravity"]
    assert found["ended"] == ("fell" if np.isfinite(expected["fall_time"]) else ""), start
    arrays = {name: np.array(values) for name, values in found["arrays"].items()}
    assert arrays["time"].size == expected["elapsed_time"].size, start
    np.testing.assert_allclose(arrays["time"], expected["elapsed_time"], atol=1e-7 * unit, err_msg=str(start))
    scales = {
        "tilt": 1.0, "heading": 1.0, "roll_angle": 1.0, "contact_x": start["radius"], "contact_y": start["radius"],
        "tilt_rate": 1.0 / unit, "precession_rate": 1.0 / unit, "roll_rate": 1.0 / unit,
        "normal_force": weight, "friction_across": weight, "friction_along": weight,
    }  # fmt: skip
    for name, scale in scales.items():
        mine = arrays[name] * (weight if scale == weight else 1.0)
        other = expected[name].values
        # a rate that grows without end near flat, or an angle of many turns, is held in its leading digits
        allowed = 1e-6 * np.maximum(scale, np.abs(other))
        assert (np.abs(mine - other) <= allowed).all(), (name, np.abs(mine - other).max() / scale, start)


#: One well, two wells, a start beside the barrier, a kick, a spin, a hoop that leans and does all at once.
SEVERAL = [
    {"tilt": 0.02, "roll_rate": 3.0},
    {"tilt": 0.02, "roll_rate": 2.3},
    {"tilt": 0.1, "roll_rate": 0.5},
    {"tilt_rate": 0.05, "roll_rate": 2.8},
    {"tilt": 0.02, "precession_rate": 4.5},
    {"tilt": -0.4, "tilt_rate": 0.3, "roll_rate": 1.5, "precession_rate": 2.0, "alpha": 1.0, "radius": 0.1},
]


def start_of(**values):
    """Return a start with these values, all others those of a disk at rest."""
    rest = dict.fromkeys(NAMES, 0.0) | {"alpha": 0.5, "radius": 0.5, "gravity": 9.81}
    return rest | values


def test_the_disk_runs_along_its_potential(page):
    """The energy of the tilt of a motion by SciPy is what the potential lacks; its extremes are wells and barriers."""
    spec = SweepSpec.preset("rolling")
    for values in SEVERAL:
        start = start_of(**values)
        found = answer(page, POTENTIAL, [start, spec.fall_tilt])
        tilts, excess = (np.array(found[name]) for name in ("tilt", "excess"))
        curve = CubicSpline(tilts, excess)
        other = sweep.simulate(**start, duration=10.0, interval=0.05, method="dop853")
        unit = math.sqrt(start["radius"] / start["gravity"])
        energy = 0.5 * (1.0 + 0.5 * start["alpha"]) * (unit * other["tilt_rate"].values) ** 2
        np.testing.assert_allclose(
            -curve(other["tilt"].values), energy, atol=5e-4 * energy.max(), err_msg=values
        )
        # the tilts of the exact reduction are where the potential is as high as the energy
        low, high = (turn for turn, _ in motion(spec, start)[0]["turns"])
        assert tilts[0] < low < high < tilts[-1], values
        np.testing.assert_allclose(curve([low, high]), 0.0, atol=-2e-3 * excess.min(), err_msg=values)
        slope = curve.derivative()
        zeros = slope.roots(extrapolate=False)
        bends = slope.derivative()(zeros)
        for name, sign in (("wells", 1.0), ("barriers", -1.0)):
            told = np.reshape(found[name], (-1, 2))
            np.testing.assert_allclose(
                told[:, 0], zeros[bends * sign > 0.0], atol=2e-3 * np.ptp(tilts), err_msg=values
            )
            np.testing.assert_allclose(
                told[:, 1], curve(told[:, 0]), atol=1e-4 * np.ptp(excess), err_msg=values
            )


def test_the_potential_of_a_narrow_swing_is_no_rounding(page):
    """The curve about a swing of 1e-12 rad has the shape of the parabola of linear theory."""
    for tilt in (1e-3, 1e-6, 1e-9, 1e-12):
        found = answer(
            page, POTENTIAL, [start_of(tilt=tilt, roll_rate=3.0), SweepSpec.preset("rolling").fall_tilt]
        )
        tilts, excess = (np.array(found[name]) for name in ("tilt", "excess"))
        assert np.ptp(tilts) < 20.0 * tilt
        scaled = (tilts - tilts.mean()) / np.ptp(tilts)
        parabola = np.polynomial.Polynomial.fit(scaled, excess, 2)
        assert np.abs(parabola(scaled) - excess).max() <= max(1e-3, 30.0 * tilt) * np.ptp(excess), tilt
        assert len(found["wells"]) == 1


def test_a_stored_motion_is_what_the_server_shows(page):
    """An exported page shows the same motion as the server, in the same form."""
    spec = SweepSpec.preset("rolling")
    for start in random_starts(12, 0.5):
        told, arrays = motion(spec, start)
        found = answer(page, STORED, [start, stored_motions(spec), "where it is"])
        head = found["head"]
        assert head["title"] == "where it is"
        assert head["ended"] == told["ended"]
        assert head["quantities"] == told["quantities"]
        assert head.keys() == told.keys()
        assert found["arrays"].keys() == arrays.keys()
        if told["period"] is not None and head["period"] is not None:
            assert head["period"] == pytest.approx(told["period"], rel=1e-3), start


@pytest.mark.parametrize("radius", [0.005, 0.011, 0.05, 0.5])
def test_turning_points_of_a_stored_motion_are_those_of_the_server(page, radius):
    """Of small and large disks an exported page tells the same turning points, period and ending as the server."""
    spec, unit = SweepSpec.preset("rolling"), math.sqrt(radius / 9.81)
    rest = {"tilt_rate": 0.0, "precession_rate": 0.0, "alpha": 0.5, "radius": radius, "gravity": 9.81}
    # from rest it swings nearly to flat and back
    near_flat = [{**rest, "tilt": 0.4, "roll_rate": roll} for roll in (0.3, 2.0)]
    for start in [*random_starts(12, radius), *near_flat]:
        told, served = motion(spec, start)
        found = answer(page, STORED, [start, stored_motions(spec), "where it is"])
        head = found["head"]
        assert head["title"] == "where it is"
        assert head["ended"] == told["ended"], start
        assert head["ending"].split()[0] == told["ending"].split()[0], start
        assert [turn for turn, _ in head["turns"]] == pytest.approx(
            [turn for turn, _ in told["turns"]], rel=0, abs=1e-6
        ), start
        if told["turns"]:
            assert head["period"] == pytest.approx(told["period"], rel=1e-4), start
            assert found["arrays"]["time"][-1] == pytest.approx(served["time"][-1], rel=1e-4), start
        # close enough to be drawn: neither time nor the turn between two samples is long
        arrays = {name: np.array(values, float) for name, values in found["arrays"].items()}
        assert np.diff(arrays["time"]).max() < 0.16 * unit, start
        turned = sum(np.abs(np.diff(arrays[name])) for name in ("tilt", "heading", "roll_angle"))
        assert told["ended"] or turned.max() < 0.8, start


def test_words_of_turning_points_are_those_of_the_server(page):
    """A tilt is written in the same unit, in the digits that the integration in the page can know."""
    spec = SweepSpec.preset("rolling")
    start = {"tilt": 0.02, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 3.0, "alpha": 0.5}
    start |= {"radius": 0.5, "gravity": 9.81}
    found = answer(page, STORED, [start, stored_motions(spec)])["head"]["turns"]
    told = motion(spec, start)[0]["turns"]
    assert len(found) == len(told) == 2
    for (_, mine), (_, served) in zip(found, told, strict=True):
        (value, unit), (exact, its_unit) = mine.split(), served.split()
        assert unit == its_unit == "deg"
        # six digits, of which rounding may decide the last
        assert float(value) == pytest.approx(float(exact), rel=1e-5)
        assert len(value) <= len("12.3456")


def test_a_tilt_that_never_changes_has_one_turning_point(page):
    """A disk that rolls upright, and one that circles, stay at their tilt."""
    spec = SweepSpec.preset("rolling")
    upright = {"tilt": 0.0, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 4.0, "alpha": 0.5}
    # the roll rate of a steady circle at this tilt and precession rate
    sin, cos, turning, gravity = math.sin(0.2), math.cos(0.2), 4.0, 9.81
    roll = -(2 * gravity * sin + 2.5 * 0.5 * turning**2 * sin * cos) / (3.0 * 0.5 * turning * cos)
    circling = {**upright, "tilt": 0.2, "precession_rate": turning, "roll_rate": roll}
    for start in (upright, circling):
        given = {**start, "radius": 0.5, "gravity": gravity}
        head = answer(page, STORED, [given, stored_motions(spec)])["head"]
        assert [turn for turn, _ in head["turns"]] == pytest.approx([start["tilt"]] * 2, abs=1e-9)
        assert not head["ended"]


def test_a_motion_that_is_given_up_has_not_fallen(page):
    """A disk that would need too many steps ends where it was followed to, by its name."""
    start = {"tilt": 0.1, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 1e5, "alpha": 0.5}
    start |= {"radius": 0.5, "gravity": 9.81}
    (found,) = answer(page, INTEGRATE, [[start], [0.0, 0.01, 10.0], SweepSpec.preset("rolling").fall_tilt])
    assert found["ended"] == "given up"
    times = found["arrays"]["time"]
    assert times[:2] == [0.0, 0.01]
    assert 0.01 < times[2] < 10.0
    assert max(found["arrays"]["tilt"]) < 0.2


def test_the_disk_is_drawn_as_in_figures(page):
    """Centre, painted radius and visible face of the page are those of the films; the contact point is on the table."""
    poses = RANDOM.uniform(
        [-1.5, -9.0, -9.0, -2.0, -2.0, 0.01], [1.5, 9.0, 9.0, 2.0, 2.0, 2.0], (50, 6)
    ).tolist()
    for pose, found in zip(poses, page.evaluate(POSE, poses), strict=True):
        drawn, radius = Pose(*pose), pose[-1]
        centre, painted, aside, axis = (
            np.array(found[name]) for name in ("centre", "painted", "aside", "axis")
        )
        np.testing.assert_allclose(centre, drawn.centre(), atol=1e-12)
        np.testing.assert_allclose(centre + radius * painted, drawn.painted()[1], atol=1e-12)
        np.testing.assert_allclose(
            np.stack([painted, aside, axis]) @ np.stack([painted, aside, axis]).T, np.eye(3), atol=1e-12
        )
        assert centre[2] == pytest.approx(radius * math.cos(pose[0]))
        assert drawn.faces(centre + axis)
        angles = np.linspace(0.0, 2.0 * np.pi, 721)[:, None]
        rim = centre + radius * (np.cos(angles) * painted + np.sin(angles) * aside)
        assert rim[:, 2].min() == pytest.approx(0.0, abs=2e-5 * radius)
        down = rim[rim[:, 2].argmin()]
        np.testing.assert_allclose(down, [pose[3], pose[4], 0.0], atol=0.01 * radius)
