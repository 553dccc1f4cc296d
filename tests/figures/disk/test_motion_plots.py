import itertools
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from messages import assert_facts, with_facts

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
    """The material point at the contact does not move, so paint, path and attitude are consistent."""
    motion = sweep.simulate(
        tilt=0.4, tilt_rate=0.3, precession_rate=1.0, roll_rate=-2.0, duration=0.1, interval=1e-4
    )
    times = motion["elapsed_time"].values
    first, middle, last = motion_plots.poses_at(motion, times[[499, 500, 501]])
    centre, rim = middle.painted()

    def material(pose):
        """Return the contact point of the middle pose as a material point, turned back by the roll angle."""
        turned = Pose(
            pose.tilt, pose.heading, pose.roll_angle - middle.roll_angle, pose.x, pose.y, pose.radius
        )
        return turned.painted()[1]

    assert material(middle) == pytest.approx([middle.x, middle.y, 0.0], abs=1e-12)
    velocity = (material(last) - material(first)) / (times[501] - times[499])
    assert np.abs(velocity).max() <= 1e-6
    assert np.linalg.norm(rim - centre) == pytest.approx(0.5, rel=1e-12)


@pytest.mark.slow_lane
def test_same_motion_same_bytes(unstable, tmp_path):
    """Drawing any motion twice gives the same file and no warning."""
    for ending in ("png", "svg"):
        for name in ("first", "second"):
            plots.save(motion_plots.figure(unstable), tmp_path / f"{name}.{ending}")
        first, second = ((tmp_path / f"{name}.{ending}").read_bytes() for name in ("first", "second"))
        assert first == second


@pytest.mark.slow_lane
def test_every_motion_can_be_drawn(tmp_path):
    """A fall, a circle, a spin on the spot and a disk at rest are drawn with their tilt and without a warning."""
    for words in (
        {"tilt": 0.1, "tilt_rate": 0.1},  # falls and lifts off
        {"tilt": "10deg", "precession_rate": 0.5, "roll_rate": "steady"},  # only a circle
        {"precession_rate": 5.0},  # stays in place
        {"tilt_rate": 0.0},  # at rest
    ):
        motion = sweep.simulate(**words, duration=2.0)
        drawn = motion_plots.figure(motion)
        plots.save(drawn, tmp_path / "figure.png")
        x, y = drawn.axes[1].lines[0].get_data()
        np.testing.assert_allclose(x, motion["elapsed_time"].values, err_msg=str(words))
        np.testing.assert_allclose(y, np.degrees(motion["tilt"].values), err_msg=str(words))


def panels(motion):
    """Return the axes of a motion's figure: picture, tilt, path, contact."""
    return motion_plots.figure(motion).axes


def test_a_figure_says_what_it_shows():
    """Title, disk and start are written above the figure; the floor has a scale."""
    figure = motion_plots.figure(sweep.simulate(radius="12mm", tilt="1deg", title="A $coin"))
    title, caption = figure.texts[:2]
    assert title.get_text() == "A $coin"
    assert_facts(caption.get_text(), "R = 12 mm", "α = 0.5", "tilt 1 deg", "rest")
    assert with_facts([each.get_text() for each in figure.axes[0].texts], "2 mm")


def test_a_fall_in_its_place_is_shown_at_several_tilts():
    """The picture of a falling disk shows several tilts, and its path has the scale of the disk."""
    axes = panels(sweep.simulate(radius="12mm", tilt="1deg", duration=2.0))
    # a face and a shadow for each
    assert len(axes[0].patches) >= 8
    assert axes[2].get_xlim() == pytest.approx((-12.0, 12.0))
    assert_facts(axes[2].get_xlabel(), "x", "(mm)")


def test_what_is_impossible_is_shaded_from_its_time_on():
    """Tilt and contact are shaded from the slip, where the needed coefficient exceeds the friction, to the end."""
    motion = sweep.simulate(radius="12mm", tilt="1deg", duration=2.0)
    _, tilt, _, contact = panels(motion)
    time, needed = motion["elapsed_time"].values, motion["friction_needed"].values
    slips = time[np.argmax(needed > 0.5)]
    for axes in (tilt, contact):
        (shade,) = axes.patches
        assert shade.get_x() == pytest.approx(slips, abs=time[1])
        assert shade.get_x() + shade.get_width() == pytest.approx(axes.get_xlim()[1])
    labels = contact.get_legend_handles_labels()[1]
    (label,) = with_facts(labels, "needed")
    assert not re.search(r"\d", label)
    assert with_facts(labels, "slips", "0.1816 s")
    for axes in panels(sweep.simulate(tilt_rate=0.01, roll_rate=2.0))[1:]:
        assert not axes.patches


@pytest.mark.slow_lane
def test_the_friction_that_is_needed_is_in_view():
    """The needed friction is fully in view, far above or far below the friction, with both and the normal force."""
    for words in (
        {"radius": 0.04, "tilt": "80deg", "precession_rate": 30.0, "roll_rate": "steady"},  # needs 3.24
        {
            "radius": 0.04,
            "tilt": "88deg",
            "precession_rate": 60.0,
            "roll_rate": "steady",
            "fall_tilt": "89.9deg",
        },
        {
            "tilt": "60deg",
            "precession_rate": 1.0,
            "fall_tilt": "89.9deg",
        },  # needs 5.47 for a moment, otherwise 0.8
        {"tilt_rate": 0.01, "roll_rate": 2.0},
        {"tilt_rate": 0.01, "roll_rate": 2.0, "friction": 4.0},
    ):
        motion = sweep.simulate(**words, duration=1.0)
        low, high = panels(motion)[3].get_ylim()
        needed = motion["friction_needed"].values
        assert low <= needed.min() <= needed.max() < high
        assert high > float(motion["friction"])
        assert with_facts(panels(motion)[3].get_legend_handles_labels()[1], "needed", f"{needed.max():.3g}")


def test_far_samples_draw_the_same_figure():
    """A motion with one sample a second is drawn as a smooth curve through the default samples."""
    words = {"tilt_rate": 0.01, "roll_rate": 2.0}
    coarse, fine = (panels(sweep.simulate(**words, interval=interval)) for interval in (1.0, "auto"))
    for axes, expected in zip(coarse, fine, strict=True):
        for line, other in zip(axes.get_lines(), expected.get_lines(), strict=True):
            np.testing.assert_array_equal(line.get_xydata(), other.get_xydata())


def test_linear_theory_ends_where_it_fails(unstable):
    """The growth of linear theory is drawn up to 1.15 times the largest tilt; its label gives the growth rate."""
    motion, theory = panels(unstable)[1].get_lines()
    assert np.abs(theory.get_ydata()).max() <= 1.15 * np.abs(motion.get_ydata()).max() + 1e-9
    # k = [4 (1+alpha) roll^2 - 2 g/R]/(2+alpha), by hand
    assert f"{np.sqrt((2.0 * 9.81 / 0.5 - 6.0 * 4.0) / 2.5):.3g}" in str(theory.get_label())


@pytest.mark.release
def test_the_script_draws_six_figures(tmp_path):
    """scripts/plot_report.py writes six figures into one folder; another format is refused before any is made."""
    command = [sys.executable, "-W", "error", str(CHECKOUT / "scripts" / "plot_report.py"), "-o"]
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    done = subprocess.run([*command, str(tmp_path / "report")], env=environment, check=False)
    assert done.returncode == 0
    names = ["circling-path", "momentum", "rolling-path", "rolling-tilt", "spinning-path", "spinning-tilt"]
    assert sorted(each.stem for each in (tmp_path / "report").iterdir()) == names
    refused = subprocess.run([*command, str(tmp_path / "b"), "--format", "jpg"], env=environment, check=False)
    assert refused.returncode == 2
    assert not (tmp_path / "b").exists()


@pytest.mark.release
def test_numbers_on_axes_are_round_and_apart():
    """Steps are 1, 2 or 5, numbers do not touch, and the paths of like disks share a unit, mm."""
    for duration in ("0.8s", "2s", "3.3s"):
        for speed in ("19cm/s", "20cm/s"):
            motion = sweep.simulate(radius="11.6mm", speed=speed, tilt="0.1deg", duration=duration)
            drawn = motion_plots.figure(motion)
            drawn.draw_without_rendering()
            _, tilt, path, contact = drawn.axes
            assert_facts(path.get_xlabel(), "x", "(mm)")
            assert_facts(path.get_ylabel(), "y", "(mm)")
            for axes in (tilt, path, contact):
                for axis, side in ((axes.xaxis, 0), (axes.yaxis, 1)):
                    step = np.diff(axis.get_majorticklocs())[0]
                    assert round(step / 10.0 ** np.floor(np.log10(step) + 1e-9), 6) in (1.0, 2.0, 5.0)
                    ends = [
                        each.get_window_extent().extents
                        for each in axis.get_majorticklabels()
                        if each.get_text()
                    ]
                    ends = sorted((each[side], each[side + 2]) for each in ends)
                    assert all(after[0] > before[1] for before, after in itertools.pairwise(ends))
