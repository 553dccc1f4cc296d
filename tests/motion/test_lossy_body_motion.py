"""Motions of lossy bodies: stated errors, the disk's own motion, endings as in an atlas, and commands."""

import math
import re
from dataclasses import replace
from unittest import mock

import numpy as np
import pytest
from body_motion import in_space
from body_referee import Body
from lossy_body_referee import LEDGER, WITH_ALL_LAWS, drawn_lossy, scaled
from messages import assert_facts, refused, row
from scipy.spatial.transform import Rotation

import sweep
from kernels.lossy_disk.arrays import LOSSES
from sweep.model.kernel import Kernel
from sweep.model.lossy_bodies.model import LossyBodies
from sweep.motion.sampling import end_of, ending_of
from sweep.motion.stated_errors import turned_between

pytestmark = pytest.mark.compiled

#: Quantities compared with the referee -> their stated errors.
STATED = {
    "axis": "orientation_error", "painted": "orientation_error", "turning": "rate_error", "centre": "path_error",
    "contact": "path_error", "force": "force_error",
}  # fmt: skip

#: The toy with its true edge.
TOY = {"body": "rim", "thickness": "12.8mm", "fillet": "2mm", "radius": "37.55mm", "mass": 0.4387}


@pytest.fixture(autouse=True)
def _one_kernel():
    """Use one kernel with all laws for atlases: each set of laws has its own, which compiles for seconds."""
    kernel = Kernel("kernels.lossy_bodies.integrate", WITH_ALL_LAWS)
    with mock.patch.object(LossyBodies, "integrator", return_value=kernel):
        yield


def followed(name, words, **more):
    """Simulate the inputs of `drawn_lossy` with radius, gravity and mass 1."""
    lengths = {key: value for key, value in words.items() if key != "air_viscosity" or value > 0.0}
    air = {"air_law": "moffatt", "air_density": 0.0} if "air_viscosity" in lengths else {}
    return sweep.simulate(body=name, radius=1.0, gravity=1.0, mass=1.0, **lengths, **air, **more)


def slides_on(motion):
    """Return whether roll rate and turn about the vertical keep their signs, so that no friction reverses."""
    roll, turn = motion["roll_rate"], motion["precession_rate"] + motion["roll_rate"] * np.sin(motion["tilt"])
    return all(
        (np.sign(each) == np.sign(each[0])).all() and each[0] != 0.0 for each in (roll.values, turn.values)
    )


def check_errors(motion, lossy, words):
    """Check a motion against a rigid body in space; return its largest stated error."""
    times = motion["elapsed_time"].values
    of = {each: motion[each].values for each in motion.data_vars}
    found, right = in_space(of), lossy.path(*scaled(words), times)
    for each, error in STATED.items():
        off = np.linalg.norm(found[each] - right[each], axis=-1)
        assert (off <= of[error] + 2e-11 * (1.0 + times)).all(), (words, each, off - of[error])
    for each, value in zip(LEDGER, right["ledger"].T, strict=True):
        if each in LOSSES:
            assert (np.abs(of[each] - value) <= of["energy_error"] + 2e-11).all(), (words, each)
    return max(float(of[error].max()) for error in STATED.values())


@pytest.mark.slow_lane
@pytest.mark.parametrize("step", ["auto", 0.02])
def test_a_motion_is_within_its_stated_errors(step):
    """The errors hold against a rigid body with torques, for each law's loss too, and with a given step."""
    rng = np.random.default_rng(41)
    checked, largest = dict.fromkeys(("torus", "rounded", "rim", "arc"), 0), 0.0
    while min(checked.values()) < 2:
        name = min(checked, key=checked.get)
        words, lossy = drawn_lossy(name, rng)
        try:
            motion = followed(name, words, duration=3.0, interval=0.25, step=step)
        except sweep.RequestError:
            # It lifts off at once.
            continue
        if not slides_on(motion) or ending_of(motion) not in ("flat", "horizon", "edge_change"):
            continue
        largest = max(largest, check_errors(motion, lossy, words))
        checked[name] += 1
    assert largest < 1e-8


@pytest.mark.slow_lane
def test_a_disk_is_within_its_stated_errors():
    """The errors of the thin disk hold against a rigid body with torques, for each law's loss too."""
    rng, checked, largest = np.random.default_rng(43), 0, 0.0
    while checked < 6:
        alpha = rng.uniform(0.1, 1.0)
        words, torus = drawn_lossy("torus", rng)
        disk = replace(torus, body=Body(1.0, 0.0, 0.0, alpha, 0.5 * alpha))
        for name in ("tube", "axial_moment", "transverse_moment", "air_viscosity"):
            words.pop(name)
        try:
            motion = sweep.simulate(
                alpha=alpha, radius=1.0, gravity=1.0, mass=1.0, **words, duration=3.0, interval=0.25
            )
        except sweep.RequestError:
            # it lifts off at once
            continue
        if slides_on(motion) and ending_of(motion) in ("flat", "horizon"):
            largest = max(largest, check_errors(motion, disk, words))
            checked += 1
    assert largest < 1e-8


def test_the_angle_between_two_orientations():
    """It matches SciPy, also near a pole, where heading and roll angle may differ arbitrarily."""
    rng = np.random.default_rng(3)
    one, other = (
        {"tilt": np.arcsin(rng.uniform(-1, 1, 50)), "heading": rng.uniform(-20, 20, 50),
         "roll_angle": rng.uniform(-20, 20, 50)} for _ in range(2)
    )  # fmt: skip
    for each, shift in (("tilt", 0.0), ("heading", 1.0), ("roll_angle", -1.0)):
        one[each][:20] = other[each][:20] + shift
    one["tilt"][:20] = other["tilt"][:20] = 0.5 * math.pi - 1e-9
    first, second = (
        Rotation.from_euler("ZYX", np.stack([of["heading"], of["tilt"], -of["roll_angle"]], axis=-1))
        for of in (one, other)
    )
    found = turned_between(one, other)
    np.testing.assert_allclose(found, (first.inv() * second).magnitude(), atol=1e-13)
    assert found[:20].max() < 1e-8 < found[20:].min()


@pytest.mark.parametrize(
    "words",
    [
        {
            "tilt": "75deg",
            "precession_rate": 12.0,
            "roll_rate": -11.0,
            "contour_friction": "1mm",
            "damping": 1e-3,
        },
        {
            "tilt": "20deg",
            "roll_rate": 3.0,
            "rolling_friction": "2cm",
            "pivoting_friction": "1cm",
            "tilt_rate": 0.1,
        },
        {"tilt": "3deg", "precession_rate": 2.0, "rolling_friction": "4cm", "pivoting_friction": "1cm"},
    ],
)
def test_a_torus_without_a_tube_is_the_disk_with_losses(words):
    """States, energy, losses and forces match within stated errors, even where friction reverses or holds."""
    start = {"mass": 2.0, "duration": "4s", "interval": 0.05, **words}
    start["contour_damping"] = start.pop("damping", 0.0)
    disk = sweep.simulate(**start, step=1e-4)
    hoop = sweep.simulate(**start, body="torus", axial_moment=0.5, transverse_moment=0.25)
    assert ending_of(hoop) == ending_of(disk)
    assert disk.sizes == hoop.sizes
    for name in disk.data_vars:
        if name in ("ending", "energy_imbalance") or name.endswith("_error"):
            continue
        within = 2e-9 * max(1.0, float(np.abs(disk[name]).max()))
        np.testing.assert_allclose(hoop[name], disk[name], rtol=0.0, atol=within, err_msg=name)


@pytest.mark.slow_lane
@pytest.mark.parametrize(
    ("words", "ending"),
    [
        (TOY | {"tilt": "80deg", "precession_rate": 48.5, "roll_rate": -46.2, "contour_friction": "15um"}, "flat"),
        (TOY | {"tilt": "30deg", "precession_rate": 5, "rolling_friction": "2mm", "contour_friction": "1mm"}, "flat"),
        ({"body": "torus", "tube": 0.25, "tilt": 0.214, "precession_rate": 1.9, "roll_rate": 0.5,
          "rolling_friction": "35mm", "pivoting_friction": "27mm", "contour_friction": "53mm"}, "flat"),
        ({"body": "rounded", "thickness": 0.3, "tilt": "1deg", "roll_rate": 0.4, "rolling_friction": "30mm",
          "contour_friction": "10mm", "pivoting_friction": "5mm"}, "rest"),
        ({"body": "rim", "thickness": 0.3, "fillet": 0.02, "tilt": "-4deg", "rolling_friction": "1mm"}, "edge change"),
        ({"body": "torus", "tube": 0.2, "tilt": "40deg", "friction": 0.6, "rolling_friction": "1mm"}, "slip"),
        ({"body": "torus", "tube": 0.2, "tilt": "20deg", "roll_rate": 8, "rolling_friction": "1mm"}, "horizon"),
    ],
)  # fmt: skip
def test_a_motion_ends_as_the_cell_of_an_atlas(words, ending):
    """Ending, time and losses match within stated errors, however often friction reverses."""
    cell = sweep.run(sweep.SweepSpec(**words, duration="20s"), progress=False)
    motion = sweep.simulate(**words, duration="20s")
    assert LossyBodies.variables["ending"].flag(float(cell["ending"])) == ending
    assert ending_of(motion) == ending
    times = motion["elapsed_time"].values
    weight = float(motion["mass"] * motion["gravity"] * motion["radius"])
    assert abs(times[-1] - float(cell["end_time"])) <= float(cell["time_error"]) + 1e-9
    assert abs(float(motion["tilt"][-1]) - float(cell["end_tilt"])) <= float(cell["tilt_error"]) + 1e-9
    assert (
        abs(float(motion["heading"][-1]) - float(cell["heading_turned"]))
        <= float(cell["heading_error"]) + 1e-9
    )
    for name in LOSSES:
        assert abs(float(motion[name][-1]) / weight - float(cell[name])) < 3e-8, name
    assert np.isnan(float(motion["end_time"])) == (ending == "horizon")
    assert (end_of(motion) == "") == (ending == "horizon")
    assert float(np.abs(motion["energy_imbalance"]).max()) < 2e-9


def test_a_body_that_friction_holds_is_seen_to_stand():
    """Rolling friction holds it if the lever arm of its weight is smaller; then the stated error is zero."""
    motion = sweep.simulate(body="rim", thickness=0.3, tilt="8.5deg", rolling_friction="30mm", duration="3s")
    assert (ending_of(motion), float(motion["end_time"])) == ("rest", 0.0)
    assert motion["elapsed_time"].values[[0, -1]].tolist() == [0.0, 3.0]
    assert float(motion["orientation_error"].max()) == np.ptp(motion["tilt"].values) == 0.0


@pytest.mark.slow_lane
def test_a_cell_and_a_preset_keep_their_losses():
    """Cells with losses, lossless cells that get some, thin-disk cells and presets are followed."""
    stops = sweep.run(
        "toy", **{**TOY, "tilt": "75deg,80deg"}, air_law="moffatt", scaled_precession_rate=3, progress=False
    )
    motion = stops.eulerdisk.simulate(tilt="80deg")
    assert motion.attrs["model"] == "lossy_bodies"
    assert float(motion["end_time"]) == pytest.approx(
        float(stops["end_time"][1]), abs=2.0 * float(stops["time_error"][1])
    )
    rings = sweep.run(sweep.SweepSpec(body="torus", tube="0.2,0.3", tilt="5deg", roll_rate=2), progress=False)
    slowed = rings.eulerdisk.simulate(tube=0.3, rolling_friction="5mm", duration="60s")
    assert float(slowed["rolling_loss"][-1]) > 0.0
    thin = sweep.run(
        "toy", tilt="80deg", precession_rate="19,20", duration="1s", criterion="aloft:1s", progress=False
    )
    thick = thin.eulerdisk.simulate(body="rim", thickness="12.8mm", precession_rate=20)
    assert float(thick["contour_friction"]) == pytest.approx(1.5e-5)
    assert float(thick["thickness"]) == pytest.approx(0.0128 / 0.03755)
    disk = stops.eulerdisk.simulate(tilt="80deg", body="disk")
    assert (float(disk["alpha"]), float(disk["contour_friction"])) == (0.5, pytest.approx(1.5e-5))
    wobble = sweep.simulate("toy", **TOY, tilt="80deg")
    assert math.hypot(*(float(np.ptp(wobble[f"centre_{each}"].values[:100])) for each in "xy")) < 1e-4


@pytest.mark.parametrize(
    ("words", "facts"),
    [
        ({"body": "ball", "air_law": "moffatt", "mass": 1}, ["ball", "without losses", "body=torus"]),
        ({"body": "ball", "tilt": "90deg", "rolling_friction": "1mm"}, ["ball", "without losses", "body=arc"]),
        ({"body": "torus", "tube": 0.2, "air_law": "moffatt", "mass": 1}, ["torus", "air_law=none"]),
        ({"body": "rim", "thickness": 0.2, "rolling_friction": "1mm"}, ["rim", "body=rounded"]),
        ({"body": "torus", "tube": 0.2, "tilt": "89.95deg", "rolling_friction": "1mm"}, ["fallen"]),
        ({"body": "torus", "tube": 0.2, "rolling_friction": "1mm", "fall_tilt": "80deg"}, ["flat_tilt"]),
        ({"body": "torus", "tube": 0.2, "rolling_friction": "1mm", "path": "yes"}, ["path"]),
        ({"body": "torus", "tube": 0.2, "rolling_friction": "1mm", "alpha": 1}, ["alpha", "axial_moment"]),
        ({"body": "torus", "tube": 0.2, "tilt": "60deg", "roll_rate": 3, "precession_rate": 5,
          "contour_friction": "1mm"}, ["lifts off"]),
    ],
)  # fmt: skip
def test_what_is_refused(words, facts):
    """A refusal is a sentence, as in a sweep."""
    with refused(*facts):
        sweep.simulate(**words)


@pytest.mark.slow_lane
def test_the_commands(command, tmp_path):
    """`simulate` (also from a cell), `info` and `explain --plot` work; figure and film show the body."""
    toy = "toy body=rim thickness=12.8mm fillet=2mm"
    status, _, told = command(
        f"simulate {toy} tilt=84deg -o stop.nc --plot stop.svg --animate stop.gif --size 240x200 --fps 5 --speed 1"
    )
    assert status == 0
    assert_facts(told, "flat")
    assert_facts((tmp_path / "stop.svg").read_text(), "rim", "R = 37.55 mm", "thickness 12.8 mm")
    _, told, _ = command("info stop.nc")
    assert re.search(r" thickness 0\.34\d*\b", row(told, "body"))
    assert_facts(row(told, "body"), "rim")
    assert "contour friction" in told
    assert command(f"run {toy} air_law=moffatt tilt=80deg,84deg scaled_precession_rate=4 -q -o a.nc")[0] == 0
    status, told, _ = command("explain a.nc tilt=84deg scaled_precession_rate=4 --plot cell.png")
    assert (status, (tmp_path / "cell.png").stat().st_size > 10_000) == (0, True)
    line = next(each for each in told.splitlines() if each.startswith("motion "))
    assert command(line.split("eulerdisk ")[1])[0] == 0
