import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import sweep
from sweep.figures import plots
from sweep.figures.disk import motion_plots
from sweep.figures.disk.disk_3d import Pose

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
    axes = motion_plots.side_by_side([unstable], motion_plots.draw_tilt).axes[0]
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
