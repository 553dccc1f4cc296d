"""Motions computed by the page, compared with SciPy's DOP853 and the energy balance."""

import math
import re

import numpy as np
import pytest
from cases import case
from explorer_client import ROLLING, about, post, side
from messages import assert_facts, refused, row
from thin_disk import motion_by_scipy

import sweep
from sweep.explorer.about import base_of
from sweep.explorer.motion import words_of
from sweep.explorer.plan import motion_tables, plan
from sweep.explorer.view import View
from sweep.motion.request import LossyTrajectorySpec
from sweep.motion.request import start_of as start_of_request
from sweep.request.spec import SweepSpec

from .asking import Refused, ask

SPEC = SweepSpec.preset("rolling")

DISK = {"alpha": 0.5, "radius": 0.5, "gravity": 9.81}


@pytest.fixture
def motion(opened):
    """Return a function that asks the page for the motion of a start."""
    page = opened()

    def asked(start, duration=None, losses=None):
        words = {name: value for name, value in start.items() if name not in ("tilt", "roll_rate")}
        view = {**ROLLING, "words": words}
        place = {"x": start["roll_rate"], "y": start["tilt"]}
        return ask(page, "motion", view=view, **place, duration=duration, losses=losses or {})

    return asked


def start_of(**values):
    """Return a start with these values; the others are those of a disk at rest."""
    return {"tilt": 0.0, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 0.0, **DISK, **values}


#: One well, two wells, a start near the barrier, a kick, a spin, a tilted hoop with all of these.
STARTS = [
    start_of(tilt=0.02, roll_rate=3.0),
    start_of(tilt=0.02, roll_rate=2.3),
    start_of(tilt=0.1, roll_rate=0.5),
    start_of(tilt_rate=0.05, roll_rate=2.8),
    start_of(tilt=0.02, precession_rate=4.5),
    start_of(tilt=-0.4, tilt_rate=0.3, roll_rate=1.5, precession_rate=2.0, alpha=1.0, radius=0.1),
]


def test_a_slow_fall_is_followed_to_its_end(motion):
    """A disk released almost upright falls after more than 6 s, the minimum time for any motion."""
    start = start_of(tilt=1e-3, radius=20.0)
    head, arrays = motion(start)
    fallen = sweep.simulate(**start, duration=100.0)
    assert head["ended"]
    assert arrays["time"][-1] == pytest.approx(float(fallen["elapsed_time"][-1]), rel=1e-6)
    assert arrays["time"][-1] > 6.0


def test_samples_are_those_of_the_motion(motion):
    """State, angles, path and forces agree with SciPy's DOP853 on the textbook equations."""
    for start in STARTS:
        with case(start):
            head, arrays = motion(start)
            assert not head["ended"]
            every = max(1, arrays["time"].size // 200)
            times = arrays["time"][::every]
            other = motion_by_scipy(start, times)
            for name in ("tilt", "tilt_rate", "roll_rate", "heading", "roll_angle", "contact_x", "contact_y"):
                np.testing.assert_allclose(arrays[name][::every], other[name], rtol=1e-9, atol=1e-9)
            for name in ("normal_force", "friction_across", "friction_along"):
                np.testing.assert_allclose(arrays[name][::every], other[name], rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(arrays["energy"], arrays["energy"][0], rtol=1e-9)


def test_a_swing_is_followed_for_three_periods_and_a_fall_to_its_end(motion):
    """The shown time follows from the motion, unless the request gives one."""
    head, arrays = motion(start_of(tilt=0.02, roll_rate=2.56))
    assert arrays["time"][-1] == pytest.approx(3.0 * head["period"])
    assert head["ending"].startswith("followed for")
    fallen, samples = motion(start_of(tilt=0.02))
    assert fallen["ended"]
    assert fallen["ending"] == f"fell at {samples['time'][-1]:.4g} s"
    assert samples["tilt"][-1] == pytest.approx(SPEC.fall_tilt)
    assert motion(STARTS[0], duration=1.5)[1]["time"][-1] == 1.5


def test_a_fast_disk_is_shown_for_a_shorter_time(motion):
    """A disk at 100 rad/s has only a few thousand samples."""
    _, arrays = motion(start_of(tilt=0.02, roll_rate=100.0))
    assert arrays["time"][-1] * 100.0 <= 401.0
    assert arrays["time"].size < 5000


LOSSES = [
    {"rolling_friction": 5e-4},
    {"contour_friction": 1e-3},
    {"pivoting_friction": 1e-3, "rolling_friction": 1e-4},
    {"contour_damping": 0.02},
    {"air_law": "bildsten"},
    {"air_law": "moffatt", "mass": 0.1},
]


@pytest.mark.slow_lane
def test_the_ledger_adds_up(motion):
    """Losses and remaining energy add up to the start's energy, and each loss only grows."""
    for losses in LOSSES:
        with case(losses):
            head, arrays = motion(start_of(tilt=0.3, roll_rate=2.0, precession_rate=2.0), 20.0, losses)
            assert head["lossy"]
            taken = [arrays[name] for name in head["ledger"]]
            np.testing.assert_allclose(arrays["energy"] + sum(taken), arrays["energy"][0], atol=1e-7)
            assert all((np.diff(each) >= -1e-12).all() for each in taken)
            assert sum(each[-1] for each in taken) > 1e-9


def test_a_disk_with_losses_stops(motion):
    """A toy that wobbles on its mirror becomes flat, and the head gives the time."""
    toy = SweepSpec.preset("toy")
    losses = {
        name: getattr(toy, name)
        for name in ("mass", "contour_friction", "air_viscosity", "air_density", "air_law")
    }
    request = LossyTrajectorySpec.read(
        **{name: getattr(toy, name) for name in ("radius", "mass", "contour_friction", "air_viscosity", "air_density")},
        air_law=toy.air_law, tilt="75deg", precession_rate="wobble", roll_rate="wobble",
    )  # fmt: skip
    start = dict(zip(toy.model.parameters, start_of_request(request), strict=True))
    head, arrays = motion({name: start[name] for name in SPEC.model.parameters}, None, losses)
    assert head["ending"] == f"flat at {arrays['time'][-1]:.4g} s"
    assert abs(arrays["tilt"][-1]) == pytest.approx(toy.flat_tilt)
    assert {each["name"]: each["value"] for each in head["losses"]}[
        "contour_friction"
    ] == toy.contour_friction


def test_a_mass_alone_is_no_loss(motion):
    """Without losses, the mass of a disk does not change its motion."""
    head, _ = motion(STARTS[0], losses={"mass": 3.0})
    assert not head["lossy"]


def test_little_friction_lets_the_disk_slip(motion):
    """A friction coefficient below what rolling needs ends the motion, even without other losses."""
    head, arrays = motion(start_of(tilt=0.02, roll_rate=2.3), losses={"friction": 0.05})
    assert head["ending"].startswith("slipped at")
    assert arrays["friction_needed"].max() == pytest.approx(0.05, rel=1e-6)


def test_both_ends_of_every_slider_are_possible(motion):
    """Both ends of each loss slider are accepted."""
    controls = motion(STARTS[0], 0.5)[0]["losses"]
    for end in ["low", "high"]:
        with case(end):
            for control in controls:
                if "choices" not in control:
                    motion(STARTS[0], 0.5, {control["name"]: control[end]})


@pytest.mark.slow_lane
def test_any_start_has_finite_arrays(motion, rng, count):
    """Every array is described, finite except where stated, and time increases."""
    for _ in range(count(15, 200)):
        rates = dict(
            zip(("tilt_rate", "precession_rate", "roll_rate"), rng.uniform(-30, 30, 3).tolist(), strict=True)
        )
        disk = {"alpha": rng.uniform(0.05, 1.0), "radius": 10.0 ** rng.uniform(-2, 1)}
        start = start_of(tilt=rng.uniform(-1.4, 1.4), **disk, **rates)
        with case(start):
            head, arrays = motion(start)
            assert arrays.keys() <= head["quantities"].keys()
            assert all(
                np.isfinite(array).all() for name, array in arrays.items() if name != "friction_needed"
            )
            assert (np.diff(arrays["time"]) > 0.0).all()


def test_a_start_without_motion_is_refused_in_words(opened):
    """A start without a steady rate, an invalid one, and one with infinite energy have no motion."""
    page = opened()
    steady = {"precession_rate": "steady-slow", "roll_rate": 0.1}
    for words, axis, x, facts in [
        (steady, side("alpha", 0.5, 0.4), 0.5, ["precession_rate"]),
        ({"tilt_rate": "1e160 rad/s"}, side("roll_rate", 0.5, 0.4), 0.5, ["energy"]),
        ({"radius": "1e220 m"}, side("roll_rate", 0.5, 0.4), 0.5, ["energy"]),
        ({}, side("alpha", 0.5, 0.6), 1.05, ["0 < alpha <= 1", "1.05"]),
    ]:
        with case(words), refused(*facts, error=Refused):
            ask(page, "motion", view={**ROLLING, "x": axis, "words": words}, x=x, y=0.02)
    with refused("tilt=86 deg", "fall_tilt=85 deg", error=Refused):
        ask(page, "motion", view=ROLLING, x=3.0, y=math.radians(86.0))


def test_a_small_disk_is_followed_for_so_many_of_its_own_units(motion):
    """A micrometer disk that turns on its edge is shown for a shorter time than a meter disk."""
    for losses, units in [(None, 4e3), ({"rolling_friction": 1e-13}, 4e4)]:
        with case(losses, units):
            start = start_of(radius=1e-6, precession_rate=1.0)
            unit = math.sqrt(start["radius"] / start["gravity"])
            for duration in (None, 100.0):
                _, arrays = motion(start, duration, losses)
                assert arrays["time"][-1] <= 1.000001 * units * unit
            assert motion(STARTS[0], 100.0)[1]["time"][-1] == 100.0


def test_a_loss_that_cannot_be_is_refused(motion):
    """A bad loss is refused with a sentence that names the word."""
    for losses, said in [
        ({"magic": 1.0}, "magic"),
        ({"rolling_friction": -1.0}, "rolling_friction must be a number not below 0; got -1"),
        ({"rolling_friction": "x"}, "rolling_friction must be a number"),
        ({"friction": 0}, "friction must be a number above 0"),
        ({"rolling_friction": 5.0}, "A lever arm must be shorter"),
        ({"air_law": "helium"}, "air_law must be one of none, moffatt, bildsten; got helium"),
    ]:
        with case(losses, said), pytest.raises(Refused, match=said):
            motion(STARTS[0], None, losses)


def test_a_disk_that_leaves_the_table_at_once_has_no_motion(motion):
    """With losses, such a motion ends where it starts, and the page says so."""
    start = start_of(
        tilt=1e-20, roll_rate=-0.28, alpha=0.3901, tilt_rate=-0.696, precession_rate=-0.66, gravity=0.2075
    )
    with refused("lifts off", "losses", error=Refused):
        motion(start, None, {"rolling_friction": 1e-5})


def test_what_is_explained_beside_a_motion_is_said_of_it(opened, url):
    """With losses, the text is about the disk that stops, at exactly this place."""
    page, place = opened(), {"x": 3.0, "y": 0.15}
    for losses, ending in [({}, "bounded"), ({"mass": 2.0}, "bounded"), ({"contour_friction": 1e-3}, "flat")]:
        with case(losses):
            text = post(url, "explain", view=ROLLING, **place, losses=losses)["text"]
            assert f"ending      {ending}" in text
            assert "repeated" not in text
            _, arrays = ask(page, "motion", view=ROLLING, **place, losses=losses)
            told = {
                name: float(each)
                for name, each in re.findall(r"^ *(end_time|tilt_min|tilt_max) +(\S+)", text, re.M)
            }
            if ending == "flat":
                assert told["end_time"] == pytest.approx(arrays["time"][-1], rel=1e-5)
            # no sample is beyond the extremes, and with one every few degrees some are near them
            tilts = np.degrees(arrays["tilt"])
            assert told["tilt_min"] - 1e-3 <= tilts.min() <= tilts.max() <= told["tilt_max"] + 1e-3
            assert np.ptp(tilts) == pytest.approx(told["tilt_max"] - told["tilt_min"], rel=0.01)


@pytest.mark.slow_lane
def test_words_of_a_stored_atlas_are_those_of_the_place(tmp_path, served_with, opened):
    """A motion between the cells of a file with losses has its own end in picture, numbers and text."""
    path = tmp_path / "toy.nc"
    words = {
        "tilt": "60deg:70deg:3",
        "precession_rate": "40:60:3",
        "duration": "20s",
        "criterion": "aloft:5s",
    }
    sweep.run_to_file(SweepSpec.preset("toy", **words), path)
    explorer = served_with(path)
    page = opened(explorer.url)
    view = about(explorer.url)["bases"][0]["view"]
    place = {"precession_rate": 47.0, "tilt": math.radians(63.0)}
    asked = {"view": view, "x": place[view["x"]["name"]], "y": place[view["y"]["name"]]}
    _, arrays = ask(page, "motion", **asked)
    text = post(explorer.url, "explain", **asked, losses={})["text"]
    numbers = {each["name"]: each for each in ask(page, "point", **asked, losses={})["numbers"]}
    assert numbers["end_time"]["value"] == pytest.approx(arrays["time"][-1], abs=1e-4)
    assert "tilt 63 deg" in text
    assert numbers["end_time"]["text"] in text
    # the pointer shows the nearest cell
    nearest = ask(page, "point", **asked)
    assert nearest["numbers"] == nearest["stored"]["numbers"]


def _moved(page, explorer, place):
    """Return the page's text about the motion at a place and about its cell, and the motion's end time."""
    view = about(explorer.url)["bases"][0]["view"]
    asked = {"view": view, "x": place[view["x"]["name"]], "y": place[view["y"]["name"]]}
    _, arrays = ask(page, "motion", **asked)
    return ask(page, "point", **asked, losses={}), arrays["time"][-1]


@pytest.mark.slow_lane
def test_a_loss_may_be_a_side_of_the_map(tmp_path, served_with, opened):
    """The motion at a place has the friction of the place."""
    path, words = tmp_path / "toy.nc", {"precession_rate": 50.0, "duration": "20s", "criterion": "aloft:5s"}
    axes = {"contour_friction": "1e-4:1e-3:3", "tilt": "60deg:70deg:3"}
    sweep.run_to_file(SweepSpec.preset("toy", **words, **axes), path)
    explorer = served_with(path)
    place = {"contour_friction": 4e-4, "tilt": math.radians(63.0)}
    _, ended = _moved(opened(explorer.url), explorer, place)
    spec = SweepSpec.preset("toy", **words, **axes)
    alone = {"roll_rate": spec.roll_rate, "precession_rate": spec.precession_rate}
    expected = sweep.simulate("toy", **place, **alone, duration=20.0)
    assert ended == pytest.approx(float(expected["elapsed_time"][-1]), rel=1e-5)
    without = sweep.simulate("toy", **place | {"contour_friction": 0.0}, **alone, duration=20.0)
    assert ended < 0.9 * float(without["elapsed_time"][-1])


@pytest.mark.slow_lane
def test_an_atlas_of_a_body_with_losses_has_motions(tmp_path, served_with, opened):
    """A motion between cells has its own end but no verdict, because only cells have one."""
    path = tmp_path / "rim.nc"
    words = {"thickness": "12.8mm", "fillet": "2mm", "duration": "20s", "criterion": "aloft:5s"}
    axes = {"contour_friction": "1e-4:1e-3:3", "tilt": "60deg:70deg:3"}
    spec = SweepSpec.preset("toy", body="rim", precession_rate=50.0, **words, **axes)
    sweep.run_to_file(spec, path)
    explorer = served_with(path)
    page = opened(explorer.url)
    place = {"contour_friction": 4e-4, "tilt": math.radians(63.0)}
    told, ended = _moved(page, explorer, place)
    assert told["verdict"] == ""
    assert told["stored"]["verdict"]
    del words["criterion"]
    expected = sweep.simulate(
        "toy", body="rim", **place, precession_rate=50.0, roll_rate=spec.roll_rate, **words
    )
    assert ended == pytest.approx(float(expected["elapsed_time"][-1]), rel=1e-5)
    cell = {name: float(getattr(spec, name).array()[1]) for name in place}
    told, ended = _moved(page, explorer, cell)
    assert told["verdict"] == told["stored"]["verdict"] != ""


WORDS = """async ([tables, plan, losses]) => {
    const { wordsOfMotion } = await import("eulerdisk/compute/losses");
    return wordsOfMotion(tables, plan, losses);
}"""


def test_a_loss_beside_those_of_an_atlas_leaves_them_as_they_are(opened):
    """Air and mass of the cells stay as they are; only the slider's value changes, as in a command."""
    page, spec = opened(), sweep.SweepSpec.preset("toy")
    start = {"tilt": 0.53, "tilt_rate": 0.0, "precession_rate": 24.5, "roll_rate": 2.2}
    start |= {name: getattr(spec, name) for name in spec.model.parameters if name not in start}
    assert spec.air_law == "bildsten"
    held = plan(View.read(base_of("", spec)["view"], spec))["motion"]
    for losses, changed in [
        ({}, {}),
        ({"rolling_friction": 1e-3}, {"rolling_friction": 1e-3}),
        ({"contour_damping": 1e-4}, {"contour_damping": 1e-4}),
        ({"air_law": "none"}, {"air_law": "none", "air_viscosity": 0.0, "air_density": 0.0}),
        ({"mass": 2.0}, {"mass": 2.0}),
    ]:
        with case(losses, changed):
            words = words_of(spec, start, losses)
            assert words == words_of(spec, start, {}) | changed
            of_page = page.evaluate(WORDS, [motion_tables(), held, losses])
            assert of_page == {name: words[name] for name in of_page}
            assert {"mass", "air_law", "contour_friction", "air_viscosity"} <= of_page.keys()


def test_losses_leave_what_a_start_disturbs(url):
    """A steady circling with losses is judged by the departure from its own tilt, not from upright."""
    (base,) = (each for each in about(url)["bases"] if each["name"] == "circling")
    asked = {"view": base["view"], "x": 0.3, "y": 2.0, "losses": {"contour_friction": 1e-4}}
    words = post(url, "explain", **asked)["text"]
    assert_facts(row(words, "reference"), "circling", "tilt")
    low, high = (float(re.search(rf"{name} +(\S+) deg", words)[1]) for name in ("tilt_min", "tilt_max"))
    start = math.degrees(0.3)
    assert f"{max(high - start, start - low):.4f}" in words.partition("because")[2]
