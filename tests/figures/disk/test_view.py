"""Every film shows the whole disk in every frame, for all cameras and picture shapes."""

import itertools

import numpy as np
import pytest

import sweep
from sweep.figures.disk.disk_3d import view
from sweep.figures.disk.film_options import CAMERAS, FilmOptions, timing
from sweep.figures.disk.motion_plots import poses_at

pytestmark = pytest.mark.compiled

MOTIONS = {
    "fall": {"radius": "12mm", "tilt": "1deg", "duration": 2.0},
    "hoop": {"alpha": 1.0, "roll_rate": 6.0, "tilt_rate": 0.5},
    "circling": {"tilt": "10deg", "precession_rate": 0.5, "roll_rate": "steady"},
    "coin": {"radius": "12mm", "tilt": "5deg", "precession_rate": 60.0, "duration": 2.0},
    "flat": {
        "radius": 0.04,
        "tilt": "80deg",
        "precession_rate": 30.0,
        "roll_rate": "steady",
        "duration": 1.0,
    },
    "big": {"radius": 50.0, "roll_rate": 0.3, "tilt_rate": 0.001, "duration": 60.0},
    "small": {"radius": "1mm", "roll_rate": 50.0, "tilt_rate": 0.1, "duration": 1.0},
}


def rim(pose):
    """Return points of the rim by textbook rotations, shape (n, 3), independently of the film."""
    angles = np.linspace(0.0, 2.0 * np.pi, 200)
    upright = pose.radius * np.stack([np.zeros(200), np.sin(angles), 1.0 - np.cos(angles)])
    cos, sin = np.cos(pose.tilt), np.sin(pose.tilt)
    leaning = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]]) @ upright
    cos, sin = np.cos(pose.heading), np.sin(pose.heading)
    turned = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ leaning
    return turned.T + np.array([pose.x, pose.y, 0.0])


def seen(camera, points):
    """Return points in the picture plane through the target, by intersecting rays with the plane."""
    ahead = (camera.target - camera.eye) / np.linalg.norm(camera.target - camera.eye)
    rays = points - camera.eye
    cut = rays * (np.linalg.norm(camera.target - camera.eye) / (rays @ ahead))[:, None]
    up = np.cross(camera.right, ahead)
    return np.stack([cut @ camera.right, cut @ up], axis=-1)


@pytest.mark.slow_lane
def test_the_whole_disk_is_in_every_frame():
    """Every point of the rim is in the picture, between the words, in front of the camera and above the floor."""
    for name, words in MOTIONS.items():
        motion = sweep.simulate(**words)
        poses = poses_at(motion, timing(motion, FilmOptions.read("a.gif")).moments[::3])
        sizes = ((640, 480), (1280, 720), (480, 640), (200, 200))
        for camera, size in itertools.product((None, *CAMERAS), sizes):
            case = name, camera, size
            shot = view(motion, poses, size, camera)
            assert (shot.high - shot.low)[0] / (shot.high - shot.low)[1] == pytest.approx(
                size[0] / size[1]
            ), case
            # half an inch above and below is for words; small pictures have 60 dots per inch, 640x480 has 100
            inch = max(60.0, 100.0 * min(size[0] / 640, size[1] / 480)) / size[1]
            margin = 0.5 * inch * (shot.high - shot.low) * [0.0, 1.0]
            for pose, each in zip(poses, shot.cameras, strict=True):
                points = rim(pose)
                assert ((points - each.eye) @ (each.target - each.eye) > 0.0).all(), case
                assert (seen(each, points) >= shot.low + margin).all(), case
                assert (seen(each, points) <= shot.high - margin).all(), case


def cameras(motion, camera, end=1.0):
    """Return the cameras at five moments from the start to an end [s]."""
    return view(motion, poses_at(motion, np.linspace(0.0, end, 5)), (640, 480), camera).cameras


def follows(motion):
    """Return True if the default camera follows the disk."""
    return len({id(each) for each in cameras(motion, None)}) == 5


def test_a_camera_follows_a_disk_that_goes_far():
    """A camera that follows keeps the disk's center in place; for a short path, the camera stands still."""
    hoop = sweep.simulate(**MOTIONS["hoop"])
    followed = cameras(hoop, "follow")
    poses = poses_at(hoop, np.linspace(0.0, 1.0, 5))
    assert [tuple(each.target[:2]) for each in followed] == [tuple(pose.centre()[:2]) for pose in poses]
    assert {name for name, words in MOTIONS.items() if follows(sweep.simulate(**words))} == {
        "hoop", "small",
    }  # fmt: skip
    assert len({id(each) for each in cameras(hoop, "fixed", 10.0)}) == 1


def test_like_starts_are_seen_from_the_same_side():
    """Coins just above and just below the critical speed have different paths but the same view."""
    for camera in ("follow", "fixed"):
        motions = [
            sweep.simulate(radius="11.6mm", speed=f"{speed}cm/s", tilt="0.1deg", duration="2s")
            for speed in (18, 19, 19.4, 20, 21)
        ]
        assert all(map(follows, motions))
        rights = [cameras(motion, camera, 2.0)[0].right for motion in motions]
        np.testing.assert_allclose(rights, [rights[0]] * 5, atol=1e-12)


def test_a_disk_starts_across_the_picture_and_a_little_into_it():
    """For any heading and direction, the contact point moves to the same side and away from the camera."""
    for roll_rate in (3.0, -3.0):
        for first in (0, 300, 700):
            whole = sweep.simulate(precession_rate=1.0, roll_rate=roll_rate, duration="6s", interval="1ms")
            motion = whole.isel(elapsed_time=slice(6 * first, None))
            way = np.array([float(motion[name][1] - motion[name][0]) for name in ("contact_x", "contact_y")])
            way /= np.linalg.norm(way)
            camera = cameras(motion, "fixed")[0]
            ahead = (camera.target - camera.eye)[:2]
            assert way @ camera.right[:2] == pytest.approx(np.cos(np.radians(28.0)), abs=5e-3)
            assert way @ ahead / np.linalg.norm(ahead) == pytest.approx(np.cos(np.radians(62.0)), abs=5e-3)


def test_from_above_the_picture_is_a_map():
    """The top camera has x to the right and y upward."""
    camera = cameras(sweep.simulate(**MOTIONS["coin"]), "top")[0]
    assert camera.right == pytest.approx([1.0, 0.0, 0.0])
    assert camera.eye[:2] == pytest.approx(camera.target[:2])
    assert camera.project(camera.target + np.array([0.0, 1e-3, 0.0])) == pytest.approx([0.0, 1e-3])
