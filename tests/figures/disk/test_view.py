"""Every film shows the whole disk in every frame, whatever the camera and the shape of the picture."""

import numpy as np
import pytest

import sweep
from sweep.figures.disk.film_options import CAMERAS, FilmOptions
from sweep.figures.disk.film_timing import timing
from sweep.figures.disk.motion_plots import poses_at
from sweep.figures.disk.view import view

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
    """Points of the rim by textbook rotations, shape (n, 3): not as the film makes them."""
    angles = np.linspace(0.0, 2.0 * np.pi, 200)
    upright = pose.radius * np.stack([np.zeros(200), np.sin(angles), 1.0 - np.cos(angles)])
    cos, sin = np.cos(pose.tilt), np.sin(pose.tilt)
    leaning = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]]) @ upright
    cos, sin = np.cos(pose.heading), np.sin(pose.heading)
    turned = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ leaning
    return turned.T + np.array([pose.x, pose.y, 0.0])


def seen(camera, points):
    """Points in the plane of the picture through the target, by rays that a plane cuts."""
    ahead = (camera.target - camera.eye) / np.linalg.norm(camera.target - camera.eye)
    rays = points - camera.eye
    cut = rays * (np.linalg.norm(camera.target - camera.eye) / (rays @ ahead))[:, None]
    up = np.cross(camera.right, ahead)
    return np.stack([cut @ camera.right, cut @ up], axis=-1)


@pytest.mark.parametrize("size", [(640, 480), (1280, 720), (480, 640), (200, 200)])
@pytest.mark.parametrize("camera", [None, *CAMERAS])
@pytest.mark.parametrize("name", MOTIONS)
def test_the_whole_disk_is_in_every_frame(name, camera, size):
    """Every point of the rim is within the picture, between the words, in front of the camera, above the floor."""
    motion = sweep.simulate(**MOTIONS[name])
    moments = timing(motion, FilmOptions.read("a.gif")).moments[::3]
    poses = poses_at(motion, moments)
    shot = view(poses, size, camera)
    assert (shot.high - shot.low)[0] / (shot.high - shot.low)[1] == pytest.approx(size[0] / size[1])
    # half an inch above and below is for words; small pictures have 60 dots per inch, 640x480 has 100
    inch = max(60.0, 100.0 * min(size[0] / 640, size[1] / 480)) / size[1]
    words = 0.5 * inch * (shot.high - shot.low) * [0.0, 1.0]
    for pose, each in zip(poses, shot.cameras, strict=True):
        points = rim(pose)
        assert ((points - each.eye) @ (each.target - each.eye) > 0.0).all()
        assert (seen(each, points) >= shot.low + words).all()
        assert (seen(each, points) <= shot.high - words).all()


def test_a_camera_follows_a_disk_that_goes_far():
    """It keeps the centre of the disk where it is in the picture; a short path is seen by one that stands still."""
    far, near = (
        poses_at(sweep.simulate(**MOTIONS[name]), np.linspace(0.0, 1.0, 5)) for name in ("hoop", "coin")
    )
    cameras = view(far, (640, 480), "follow").cameras
    assert [tuple(each.target[:2]) for each in cameras] == [tuple(pose.centre()[:2]) for pose in far]
    assert len({id(each) for each in view(near, (640, 480), None).cameras}) == 1
    long = poses_at(sweep.simulate(**MOTIONS["hoop"]), np.linspace(0.0, 10.0, 5))
    assert len({id(each) for each in view(long, (640, 480), None).cameras}) == 5
    assert len({id(each) for each in view(long, (640, 480), "fixed").cameras}) == 1


def test_from_above_the_picture_is_a_map():
    """The camera on top has x to the right and y upwards."""
    camera = view(
        poses_at(sweep.simulate(**MOTIONS["coin"]), np.array([0.0, 1.0])), (640, 480), "top"
    ).cameras[0]
    assert camera.right == pytest.approx([1.0, 0.0, 0.0])
    assert camera.eye[:2] == pytest.approx(camera.target[:2])
    assert camera.project(camera.target + np.array([0.0, 1e-3, 0.0])) == pytest.approx([0.0, 1e-3])
