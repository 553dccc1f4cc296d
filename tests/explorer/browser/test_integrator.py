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

POSE = """async (poses) => {
  const { poseOf } = await import("eulerdisk/motion/disk_scene");
  return poses.map((pose) => poseOf(...pose));
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


def test_a_stored_motion_is_what_the_server_shows(page):
    """An exported page shows the same motion and potential as the server, in the same form."""
    spec = SweepSpec.preset("rolling")
    other_views = 0
    for start in random_starts(12, 0.5):
        told, arrays = motion(spec, start)
        found = answer(page, STORED, [start, stored_motions(spec), "where it is"])
        head = found["head"]
        assert head["title"] == "where it is"
        assert head["ended"] == told["ended"]
        assert head["quantities"] == told["quantities"]
        assert head.keys() == told.keys()
        assert found["arrays"].keys() == arrays.keys()
        mine = {name: np.array(values, float) for name, values in found["arrays"].items()}
        span = np.ptp(arrays["potential_tilt"])
        ends = [abs(mine["potential_tilt"][end] - arrays["potential_tilt"][end]) for end in (0, -1)]
        same_view = max(ends) < 0.02 * span
        other_views += not same_view
        curve = CubicSpline(arrays["potential_tilt"], arrays["potential"])
        inside = (mine["potential_tilt"] > arrays["potential_tilt"][0]) & (
            mine["potential_tilt"] < arrays["potential_tilt"][-1]
        )
        depth = np.ptp(arrays["potential"])
        apart = np.abs(curve(mine["potential_tilt"]) - mine["potential"])[inside]
        assert apart.max() < 1e-3 * depth, start
        for name in ("wells", "barriers") if same_view else ():
            assert len(head[name]) == len(told[name]), start
            np.testing.assert_allclose(
                head[name], told[name], atol=1e-3 * max(span, depth), err_msg=str(start)
            )
        if told["period"] is not None and head["period"] is not None:
            assert head["period"] == pytest.approx(told["period"], rel=1e-3), start
    # a barrier whose height is just about what is worth seeing is in view here and not there: 22 of 600 starts
    assert other_views <= 4


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
        assert float(value) == pytest.approx(float(exact), rel=1e-7)
        assert len(value) <= len("12.345678")


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
