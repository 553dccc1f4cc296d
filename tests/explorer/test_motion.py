import json
import math
import re

import numpy as np
import pytest
from cases import case
from explorer_client import ROLLING, about, post, refused, side
from hypothesis import given, settings
from hypothesis import strategies as st

import sweep
from sweep.errors import RequestError
from sweep.explorer.losses import controls
from sweep.explorer.motion import motion, quantities, stored_motions, words_of
from sweep.motion.disk_path import _TRAJECTORY
from sweep.motion.request import LossyTrajectorySpec
from sweep.motion.request import start_of as start_of_request
from sweep.request.spec import SweepSpec

SPEC = SweepSpec.preset("rolling")

DISK = {"alpha": 0.5, "radius": 0.5, "gravity": 9.81}


def start_of(**values):
    """Return a start with these values, all others those of a disk at rest."""
    return {"tilt": 0.0, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 0.0, **DISK, **values}


#: One well, two wells, a start beside the barrier, a kick, a spin, a hoop that leans and does all at once.
STARTS = [
    start_of(tilt=0.02, roll_rate=3.0),
    start_of(tilt=0.02, roll_rate=2.3),
    start_of(tilt=0.1, roll_rate=0.5),
    start_of(tilt_rate=0.05, roll_rate=2.8),
    start_of(tilt=0.02, precession_rate=4.5),
    start_of(tilt=-0.4, tilt_rate=0.3, roll_rate=1.5, precession_rate=2.0, alpha=1.0, radius=0.1),
]


def by_scipy(start, times):
    """Return the same motion by SciPy's DOP853, at times that are evenly spaced."""
    interval = times[1]
    return sweep.simulate(**start, duration=times[-1], interval=interval, method="dop853")


def test_samples_are_those_of_the_motion():
    """State, angles, path and forces agree with SciPy's DOP853 on the textbook equations."""
    for start in STARTS:
        with case(start):
            head, arrays = motion(SPEC, start)
            assert not head["ended"]
            every = max(1, arrays["time"].size // 200)
            times = arrays["time"][::every]
            other = by_scipy(start, times)
            weight = start["gravity"]
            for name in ("tilt", "tilt_rate", "roll_rate", "heading", "roll_angle", "contact_x", "contact_y"):
                np.testing.assert_allclose(arrays[name][::every], other[name].values, rtol=2e-7, atol=2e-7)
            for name in ("normal_force", "friction_across", "friction_along"):
                np.testing.assert_allclose(arrays[name][::every], other[name].values / weight, atol=2e-6)
            np.testing.assert_allclose(arrays["energy"], arrays["energy"][0], rtol=1e-9)


def test_a_swing_is_followed_for_three_periods_and_a_fall_to_its_end():
    """The time that is shown follows from the motion; a request may name one."""
    head, arrays = motion(SPEC, start_of(tilt=0.02, roll_rate=2.56))
    assert arrays["time"][-1] == pytest.approx(3.0 * head["period"])
    assert head["ending"].startswith("followed for")
    fallen, samples = motion(SPEC, start_of(tilt=0.02))
    assert fallen["ended"]
    assert fallen["ending"] == f"fell at {samples['time'][-1]:.4g} s"
    assert samples["tilt"][-1] == pytest.approx(SPEC.fall_tilt)
    assert motion(SPEC, STARTS[0], duration=1.5)[1]["time"][-1] == 1.5


def test_a_fast_disk_is_shown_for_a_shorter_time():
    """A disk at 100 rad/s has few thousand samples, and is integrated twice, not until rounding has no more to give."""
    calls = []
    kernel = _TRAJECTORY.load()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(_TRAJECTORY), "load", lambda self: counted(self, kernel, calls))
        _, arrays = motion(SPEC, start_of(tilt=0.02, roll_rate=100.0))
    assert arrays["time"][-1] * 100.0 <= 401.0
    assert arrays["time"].size < 5000
    assert len(calls) <= 4


_LOAD = type(_TRAJECTORY).load


def counted(kernel, trajectory, calls):
    """Return the function of a kernel; calls of the trajectory are noted."""
    if kernel is not _TRAJECTORY:
        return _LOAD(kernel)

    def noted(*arguments):
        calls.append(arguments)
        return trajectory(*arguments)

    return noted


LOSSES = [
    {"rolling_friction": 5e-4},
    {"contour_friction": 1e-3},
    {"pivoting_friction": 1e-3, "rolling_friction": 1e-4},
    {"contour_damping": 0.02},
    {"air_law": "bildsten"},
    {"air_law": "moffatt", "mass": 0.1},
]


def test_the_ledger_adds_up():
    """What the losses have taken, and the energy that is left, are the energy of the start; each loss only grows."""
    for losses in LOSSES:
        with case(losses):
            head, arrays = motion(SPEC, start_of(tilt=0.3, roll_rate=2.0, precession_rate=2.0), 20.0, losses)
            assert head["lossy"]
            taken = [arrays[name] for name in head["ledger"]]
            np.testing.assert_allclose(arrays["energy"] + sum(taken), arrays["energy"][0], atol=1e-7)
            assert all((np.diff(each) >= -1e-12).all() for each in taken)
            assert sum(each[-1] for each in taken) > 1e-9


def test_a_disk_with_losses_stops():
    """A toy that wobbles on its mirror becomes flat within its losses, and the head says when."""
    toy = SweepSpec.preset("toy")
    request = LossyTrajectorySpec.read(
        **{name: getattr(toy, name) for name in ("radius", "mass", "contour_friction", "air_viscosity", "air_density")},
        air_law=toy.air_law, tilt="75deg", precession_rate="wobble", roll_rate="wobble",
    )  # fmt: skip
    start = dict(zip(toy.model.parameters, start_of_request(request), strict=True))
    head, arrays = motion(toy, start)
    assert head["ending"] == f"flat at {arrays['time'][-1]:.4g} s"
    assert abs(arrays["tilt"][-1]) == pytest.approx(toy.flat_tilt)
    assert {each["name"]: each["value"] for each in head["losses"]}[
        "contour_friction"
    ] == toy.contour_friction


def test_a_mass_alone_is_no_loss():
    """The mass of a disk without losses changes no motion."""
    head, _ = motion(SPEC, STARTS[0], losses={"mass": 3.0})
    assert not head["lossy"]


def test_little_friction_lets_the_disk_slip():
    """A friction coefficient below what rolling needs ends the motion, though nothing else is lost."""
    head, arrays = motion(SPEC, start_of(tilt=0.02, roll_rate=2.3), losses={"friction": 0.05})
    assert head["ending"].startswith("slipped at")
    assert arrays["friction_needed"].max() == pytest.approx(0.05, rel=1e-6)


def test_both_ends_of_every_slider_are_possible():
    """A slider of a loss asks for nothing that is refused."""
    for end in ["low", "high"]:
        with case(end):
            for control in controls(SPEC, STARTS[0], {}):
                if "choices" not in control:
                    motion(SPEC, STARTS[0], 0.5, {control["name"]: control[end]})


@settings(max_examples=25, deadline=None)
@given(
    tilt=st.floats(-1.4, 1.4),
    rates=st.tuples(*[st.floats(-30.0, 30.0)] * 3),
    alpha=st.floats(0.05, 1.0),
    radius=st.floats(0.01, 10.0),
)
def test_any_start_has_an_answer_of_json(tilt, rates, alpha, radius):
    """The head has no number that JSON lacks, and every array is described and finite but where it says so."""
    names = ("tilt_rate", "precession_rate", "roll_rate")
    start = start_of(tilt=tilt, alpha=alpha, radius=radius, **dict(zip(names, rates, strict=True)))
    head, arrays = motion(SPEC, start)
    json.dumps(head, allow_nan=False)
    assert arrays.keys() <= head["quantities"].keys()
    assert all(np.isfinite(array).all() for name, array in arrays.items() if name != "friction_needed")
    assert (np.diff(arrays["time"]) > 0.0).all()


def test_a_start_without_motion_is_refused_in_words():
    """Where no rate keeps the tilt there is no motion."""
    with pytest.raises(RequestError, match="no roll_rate keeps this tilt constant"):
        motion(SPEC, start_of(tilt=0.5, roll_rate=math.nan))


def test_a_start_whose_energy_is_no_number_is_refused_in_words(url):
    """Numbers whose squares are none have no motion, and the page is told so."""
    for name in ["tilt_rate", "precession_rate", "roll_rate", "radius"]:
        with case(name):
            words = {name: "1e220 m" if name == "radius" else "1e160 rad/s"}
            axis = side("alpha" if name == "roll_rate" else "roll_rate", 0.5, 0.4)
            view = {**ROLLING, "x": axis, "words": words}
            status, error = refused(url, "motion", view=view, x=0.5, y=0.02)
            assert status == 400
            assert "its energy is no number" in error["error"]


def test_a_small_disk_is_followed_for_so_many_of_its_own_units():
    """A disk of a micrometre that turns on its edge for ever is shown for a shorter time than one of a metre."""
    for losses, units in [(None, 4e3), ({"rolling_friction": 1e-13}, 4e4)]:
        with case(losses, units):
            start = start_of(radius=1e-6, precession_rate=1.0)
            unit = math.sqrt(start["radius"] / start["gravity"])
            for duration in (None, 100.0):
                _, arrays = motion(SPEC, start, duration, losses)
                assert arrays["time"][-1] <= 1.000001 * units * unit
            assert motion(SPEC, STARTS[0], 100.0)[1]["time"][-1] == 100.0


def test_a_loss_that_cannot_be_is_refused(url):
    """Whatever a page asks for, the answer is a sentence that names the word."""
    for losses, said in [
        ({"magic": 1.0}, "magic is no loss"),
        ({"rolling_friction": -1.0}, "rolling_friction"),
        ({"rolling_friction": [1.0]}, "rolling_friction"),
        ({"rolling_friction": {"a": 1.0}}, "rolling_friction"),
        ({"rolling_friction": True}, "rolling_friction"),
        ({"rolling_friction": None}, "rolling_friction"),
        ({"rolling_friction": 5.0}, "A lever arm must be shorter"),
        ({"air_law": "helium"}, "air_law"),
        ({"air_law": ["none"]}, "air_law"),
    ]:
        with case(losses, said):
            place = {"view": ROLLING, "x": 3.0, "y": 0.02}
            status, error = refused(url, "motion", **place, losses=losses)
            assert status == 400
            assert said in error["error"]


def test_the_server_answers_with_the_same_motion(url):
    """Over the wire a motion is the same to the bit as in Python."""
    head, arrays = post(url, "motion", view=ROLLING, x=3.0, y=0.02)
    expected_head, expected = motion(SPEC, start_of(tilt=0.02, roll_rate=3.0))
    assert {name: head[name] for name in expected_head} == json.loads(json.dumps(expected_head))
    assert arrays.keys() == expected.keys()
    assert all(np.array_equal(arrays[name], expected[name], equal_nan=True) for name in expected)


def test_what_is_said_beside_a_motion_is_said_of_it(url):
    """With losses its numbers and words are those of the disk that stops, at this very place."""
    place = {"view": ROLLING, "x": 3.0, "y": 0.15}
    for losses, ending in [({}, "bounded"), ({"mass": 2.0}, "bounded"), ({"contour_friction": 1e-3}, "flat")]:
        with case(losses):
            asked = place | {"losses": losses}
            numbers = {each["name"]: each for each in post(url, "point", **asked)["numbers"]}
            text = post(url, "explain", **asked)["text"]
            assert numbers["ending"]["text"] == ending
            assert f"ending      {ending}" in text
            assert "repeated" not in text
            _, arrays = post(url, "motion", **asked)
            tilts = arrays["tilt"]
            if ending == "flat":
                assert numbers["end_time"]["value"] == pytest.approx(arrays["time"][-1], abs=1e-6)
                assert numbers["end_time"]["text"] in text
            # no sample is beyond the extremes, and with a sample every few degrees of the swing some are near them
            extremes = [numbers[name]["value"] for name in ("tilt_min", "tilt_max")]
            assert extremes[0] - 1e-6 <= tilts.min() <= tilts.max() <= extremes[1] + 1e-6
            assert np.ptp(tilts) == pytest.approx(np.ptp(extremes), rel=0.01)


def test_words_of_a_stored_atlas_are_those_of_the_place(tmp_path):
    """A motion between the cells of a file with losses has its own end, in its picture, numbers and words."""
    path = tmp_path / "toy.nc"
    words = {
        "tilt": "60deg:70deg:3",
        "precession_rate": "40:60:3",
        "duration": "20s",
        "criterion": "aloft:5s",
    }
    sweep.run_to_file(SweepSpec.preset("toy", **words), path)
    with sweep.explore(path) as explorer:
        view = about(explorer.url)["bases"][0]["view"]
        place = {"precession_rate": 47.0, "tilt": math.radians(63.0)}
        asked = {"view": view, "x": place[view["x"]["name"]], "y": place[view["y"]["name"]]}
        _, arrays = post(explorer.url, "motion", **asked)
        text = post(explorer.url, "explain", **asked, losses={})["text"]
        numbers = {each["name"]: each for each in post(explorer.url, "point", **asked, losses={})["numbers"]}
        assert numbers["end_time"]["value"] == pytest.approx(arrays["time"][-1], abs=1e-4)
        assert "tilt 63 deg" in text
        assert numbers["end_time"]["text"] in text
        # what is pointed at is the nearest cell, as before
        assert post(explorer.url, "point", **asked)["stored"] is not None


def test_an_exported_page_knows_what_it_draws():
    """What the page integrates is described as what the server computes; no disk with losses is integrated there."""
    stored = stored_motions(SPEC)
    assert stored["quantities"] == quantities()
    assert stored["fall_tilt"] == SPEC.fall_tilt
    assert stored_motions(SweepSpec.preset("toy")) is None


def test_a_loss_beside_those_of_an_atlas_leaves_them_as_they_are():
    """The air and the mass of the cells stay what they are; only what a slider says is another."""
    for losses, changed in [
        ({"rolling_friction": 1e-3}, {"rolling_friction": 1e-3}),
        ({"contour_damping": 1e-4}, {"contour_damping": 1e-4}),
        ({"air_law": "none"}, {"air_law": "none", "air_viscosity": 0.0, "air_density": 0.0}),
        ({"mass": 2.0}, {"mass": 2.0}),
    ]:
        with case(losses, changed):
            spec = sweep.SweepSpec.preset("toy")
            start = {"tilt": 0.53, "tilt_rate": 0.0, "precession_rate": 24.5, "roll_rate": 2.2}
            start |= {name: getattr(spec, name) for name in spec.model.parameters if name not in start}
            assert spec.air_law == "bildsten"
            words = words_of(spec, start, losses)
            assert words == words_of(spec, start, {}) | changed
            assert motion(spec, start, 0.1, losses)[0]["lossy"]


def test_losses_leave_what_a_start_disturbs(url):
    """A steady circling to which losses are given is judged by how far it leaves its own tilt, not the upright disk."""
    (base,) = (each for each in about(url)["bases"] if each["name"] == "circling")
    asked = {"view": base["view"], "x": 0.3, "y": 2.0, "losses": {"contour_friction": 1e-4}}
    words = post(url, "explain", **asked)["text"]
    assert "reference   steady circling at this tilt" in words
    low, high = (float(re.search(rf"{name} +(\S+) deg", words)[1]) for name in ("tilt_min", "tilt_max"))
    start = math.degrees(0.3)
    assert f"{max(high - start, start - low):.4f}" in words.partition("because")[2]
    assert post(url, "point", **asked)["verdict"] == "unstable"
