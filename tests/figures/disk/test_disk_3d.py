import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from sweep.figures.disk.disk_3d import FACES, Camera, Pose, draw_disk


def test_the_rim_touches_the_plane():
    """All points of the rim are a radius from the center; the lowest one is the contact point."""
    pose = Pose(0.6, 1.0, 2.0, 0.3, -0.2, 0.5)
    rim, centre = pose.rim(), pose.painted()[0]
    assert np.linalg.norm(rim - centre, axis=1) == pytest.approx(0.5)
    assert rim[rim[:, 2].argmin()] == pytest.approx([0.3, -0.2, 0.0], abs=1e-12)


def test_the_camera_sees_in_true_perspective():
    """Straight lines stay straight, twice the distance halves the size, and both picture axes have the same scale."""
    camera = Camera.on(np.zeros(3), 1.0, -55.0)
    ahead = (camera.target - camera.eye) / np.linalg.norm(camera.eye)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    # at the distance of the target, one meter has length one along both axes
    assert camera.project(np.stack([right, up])) == pytest.approx(np.eye(2), abs=1e-12)
    twice = np.linalg.norm(camera.eye) * ahead
    assert camera.project(twice + right) == pytest.approx([0.5, 0.0], abs=1e-12)
    line = camera.project(np.linspace([-1.0, 0.3, 0.0], [0.7, -0.9, 0.4], 9))
    across, along = line - line[0], line[-1] - line[0]
    assert across[:, 0] * along[1] == pytest.approx(across[:, 1] * along[0], abs=1e-12)


def test_the_faces_of_the_disk_are_told_apart():
    """An upright disk heading along y shows its first face towards +x and its second, in another color, to -x."""
    pose = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.5)
    for azimuth, face in ((0.0, FACES[0]), (180.0, FACES[1])):
        camera = Camera.on(np.zeros(3), 1.0, azimuth)
        assert pose.faces(camera.eye) == (face == FACES[0])
        axes = Figure().add_axes((0.0, 0.0, 1.0, 1.0))
        draw_disk(axes, camera, pose)
        assert to_hex(axes.patches[1].get_facecolor()) == face
