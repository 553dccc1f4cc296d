import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import sweep
from sweep.figures import panels, plots
from sweep.figures.disk import motion_plots
from sweep.figures.disk.disk_3d import Camera, Pose

pytestmark = pytest.mark.compiled

CHECKOUT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def unstable():
    """Return the report's unstable rolling."""
    return sweep.simulate(tilt_rate=0.01, roll_rate=2.0, title="Rolling at 2 rad/s")


def test_the_painted_radius_rolls_without_slipping():
    """The material point at the contact point does not move: the paint, the path and the attitude fit together."""
    motion = sweep.simulate(
        tilt=0.4, tilt_rate=0.3, precession_rate=1.0, roll_rate=-2.0, duration=0.1, interval=1e-4
    )
    times = motion["elapsed_time"].values
    first, middle, last = motion_plots.poses_at(motion, times[[499, 500, 501]])
    centre, rim = middle.painted()

    def material(pose):
        """Where the point is that touches the plane in the middle pose: turned back by the roll angle."""
        turned = Pose(
            pose.tilt, pose.heading, pose.roll_angle - middle.roll_angle, pose.x, pose.y, pose.radius
        )
        return turned.painted()[1]

    assert material(middle) == pytest.approx([middle.x, middle.y, 0.0], abs=1e-12)
    velocity = (material(last) - material(first)) / (times[501] - times[499])
    assert np.abs(velocity).max() <= 1e-6
    assert np.linalg.norm(rim - centre) == pytest.approx(0.5, rel=1e-12)


def test_the_rim_touches_the_plane():
    """All points of the rim are a radius from the centre; the lowest one is the contact point."""
    pose = Pose(0.6, 1.0, 2.0, 0.3, -0.2, 0.5)
    rim, centre = pose.rim(), pose.painted()[0]
    assert np.linalg.norm(rim - centre, axis=1) == pytest.approx(0.5)
    assert rim[rim[:, 2].argmin()] == pytest.approx([0.3, -0.2, 0.0], abs=1e-12)


def test_the_camera_sees_in_true_perspective():
    """Straight lines stay straight, what is twice as far is half as large, and both axes of the picture are equal."""
    camera = Camera.on(np.zeros(3), 1.0)
    ahead = (camera.target - camera.eye) / np.linalg.norm(camera.eye)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    # at the distance of the target one metre is one metre, either way
    assert camera.project(np.stack([right, up])) == pytest.approx(np.eye(2), abs=1e-12)
    twice = np.linalg.norm(camera.eye) * ahead
    assert camera.project(twice + right) == pytest.approx([0.5, 0.0], abs=1e-12)
    line = camera.project(np.linspace([-1.0, 0.3, 0.0], [0.7, -0.9, 0.4], 9))
    across, along = line - line[0], line[-1] - line[0]
    assert across[:, 0] * along[1] == pytest.approx(across[:, 1] * along[0], abs=1e-12)


def test_the_faces_of_the_disk_are_told_apart():
    """An upright disk shows one face from one side and the other from the other."""
    pose = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.5)
    assert pose.faces(np.array([3.0, 0.0, 1.0])) != pose.faces(np.array([-3.0, 0.0, 1.0]))


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_same_motion_same_bytes(unstable, tmp_path, ending):
    """A still drawn twice gives the same file; it warns of nothing, on a motion of any kind."""
    for name in ("first", "second"):
        plots.save(motion_plots.figure(unstable), tmp_path / f"{name}.{ending}")
    first, second = ((tmp_path / f"{name}.{ending}").read_bytes() for name in ("first", "second"))
    assert first == second


@pytest.mark.parametrize(
    "words",
    [
        {"tilt": 0.1, "tilt_rate": 0.1},  # falls and lifts off
        {"tilt": "10deg", "precession_rate": 0.5, "roll_rate": "steady"},  # nothing but a circle
        {"precession_rate": 5.0},  # does not move from its place
        {"tilt_rate": 0.0},  # stands still
    ],
)
def test_every_motion_can_be_drawn(words, tmp_path):
    """A fall, a circle, a spin on the spot and a disk at rest are drawn without a warning."""
    plots.save(motion_plots.figure(sweep.simulate(**words, duration=2.0)), tmp_path / "figure.png")


def test_linear_theory_ends_where_it_fails(unstable):
    """The growth of linear theory is drawn up to 1.15 of the largest tilt; its label states the growth rate."""
    axes = motion_plots.tilt_figure([unstable]).axes[0]
    motion, theory = axes.get_lines()
    assert np.abs(theory.get_ydata()).max() <= 1.15 * np.abs(motion.get_ydata()).max() + 1e-9
    # k = [4 (1+alpha) roll^2 - 2 g/R]/(2+alpha), by hand
    assert f"{np.sqrt((2.0 * 9.81 / 0.5 - 6.0 * 4.0) / 2.5):.3g}" in str(theory.get_label())


def test_the_script_draws_six_figures(tmp_path):
    """scripts/plot_report.py writes its six figures into one folder; another format is refused with nothing made."""
    command = [sys.executable, "-W", "error", str(CHECKOUT / "scripts" / "plot_report.py"), "-o"]
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    done = subprocess.run([*command, str(tmp_path / "report")], env=environment, check=False)
    assert done.returncode == 0
    names = ["circling-path", "momentum", "rolling-path", "rolling-tilt", "spinning-path", "spinning-tilt"]
    assert sorted(each.stem for each in (tmp_path / "report").iterdir()) == names
    refused = subprocess.run([*command, str(tmp_path / "b"), "--format", "jpg"], env=environment, check=False)
    assert refused.returncode == 2
    assert not (tmp_path / "b").exists()


@pytest.fixture(scope="module")
def rolling():
    """Return a small atlas with contact forces."""
    spec = sweep.SweepSpec.preset("rolling").replace(
        roll_rate="1:4:12", tilt="0.1deg:20deg:10", contact="yes"
    )
    return sweep.run(spec)


def test_a_map_shows_where_the_disk_would_slip(rolling):
    """Cells that need more than the friction coefficient, or lift off, are hatched; the legend says so."""
    shown = panels.panel(rolling, 0.3)
    needed = rolling["friction_needed"].transpose("roll_rate", "tilt").values
    assert shown.slips.any()
    assert (shown.slips == (np.isnan(needed) | (needed > 0.3))).all()
    labels = plots.figure([rolling], 0.3).axes[0].get_legend_handles_labels()[1]
    assert "slips or lifts off at friction 0.3" in labels
    labels = plots.figure([rolling]).axes[0].get_legend_handles_labels()[1]
    assert not any("slips" in label for label in labels)
    profile = plots.figure([rolling.isel(tilt=-1)], 0.3).axes[0].get_legend_handles_labels()[1]
    assert "slips or lifts off at friction 0.3" in profile


def test_friction_needs_the_forces():
    """An atlas made without contact=yes has no forces, and says how to get them."""
    spec = sweep.SweepSpec.preset("rolling").replace(roll_rate="1:4:3", tilt="0.1deg:20deg:3")
    atlas = sweep.run(spec)
    assert "friction_needed" not in atlas
    with pytest.raises(sweep.RequestError, match=r"holds no contact forces.*contact=yes"):
        plots.figure([atlas], 0.5)
