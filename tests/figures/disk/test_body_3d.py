"""Pictures of bodies of revolution: the right shape, standing on the contact point and rolling."""

import math

import numpy as np
import pytest

import sweep
from sweep.figures import plots
from sweep.figures.disk import animation, motion_plots
from sweep.figures.disk.body_3d import poses_of_body, solid_of
from sweep.figures.disk.captions import caption
from sweep.figures.disk.disk_3d import Camera, Pose
from sweep.figures.disk.film_options import FilmOptions, timing
from sweep.figures.disk.solid import FRONT, Solid
from sweep.model.bodies.tables import CALLED

pytestmark = pytest.mark.compiled

#: Motions of all bodies, some with an offset center of mass, on the edge of negative tilts, or through a
#: pole.
MOTIONS = {
    "torus": {"tube": 0.25, "tilt": "30deg", "roll_rate": 4.0},
    "rounded": {"thickness": 0.3, "tilt": "-20deg", "roll_rate": 4.0, "precession_rate": 1.0},
    "rim": {"thickness": 0.3, "fillet": 0.05, "tilt": "-30deg", "roll_rate": 4.0, "precession_rate": -3.0},
    "arc": {"fillet": 0.4, "offset": -0.2, "axial_moment": 0.42, "transverse_moment": 0.38, "tilt": "20deg",
            "roll_rate": 4.0, "precession_rate": 1.0},
    "ball": {"offset": 0.3, "axial_moment": 0.42, "transverse_moment": 0.38, "tilt": "50deg", "tilt_rate": 6.0,
             "precession_rate": 0.2},
    "spheroid": {"flattening": -0.5, "offset": 0.2, "axial_moment": 0.4, "transverse_moment": 0.6, "tilt": "10deg",
                 "roll_rate": 4.0, "tilt_rate": 2.0},
}  # fmt: skip


@pytest.fixture(scope="module")
def motions():
    """Return one motion of each body."""
    return {body: sweep.simulate(body=body, **words, duration="1s") for body, words in MOTIONS.items()}


def test_a_body_stands_on_its_contact_point(motions):
    """The lowest point of the surface is the contact point on the plane, within the size of a facet."""
    for body, motion in motions.items():
        times = motion["elapsed_time"].values
        for pose in poses_of_body(motion, np.linspace(0.0, times[-1], 7)):
            points = pose.placed(pose.solid.vertices).reshape(-1, 3)
            lowest = points[points[:, 2].argmin()]
            assert abs(lowest[2]) < 0.003 * pose.scale, body
            assert math.hypot(lowest[0] - pose.x, lowest[1] - pose.y) < 0.09 * pose.scale, body


def test_a_body_rolls_without_slipping(motions):
    """The material point at the contact has no velocity."""
    for body, motion in motions.items():
        for moment in (0.2, 0.7):
            before, at, after = poses_of_body(motion, moment + np.array([-1e-3, 0.0, 1e-3]))
            touching = (np.array([at.x, at.y, 0.0]) - at.middle) @ at.frame / at.scale
            velocity = (after.placed(touching) - before.placed(touching)) / 2e-3
            speed = np.linalg.norm(after.middle - before.middle) / 2e-3
            assert np.linalg.norm(velocity) < 2e-3 * speed + 1e-3, (body, moment)


def test_beside_a_pole_a_body_turns_evenly_between_samples():
    """If the heading jumps between two samples, interpolation agrees with closer samples."""
    words = {"body": "ball", "tilt": "80deg", "tilt_rate": 4.0, "precession_rate": 0.01, "duration": "0.2s"}
    coarse, fine = (sweep.simulate(**words, interval=interval) for interval in (0.02, 1e-4))
    assert np.abs(np.diff(coarse["heading"])).max() > 2.0
    moments = np.linspace(0.0, 0.2, 81)
    for one, other in zip(poses_of_body(coarse, moments), poses_of_body(fine, moments), strict=True):
        assert np.abs(one.frame - other.frame).max() < 1e-3


def test_the_painted_direction_is_that_of_the_disk():
    """A ring without a tube is painted and placed like the disk; the faces of a coin have the disk's colors."""
    start = {"tilt": "30deg", "roll_rate": -3.0, "precession_rate": 2.0, "duration": "0.5s"}
    disk = motion_plots.poses_at(sweep.simulate(**start), np.array([0.4]))[0]
    ring = sweep.simulate(body="torus", tube=0, axial_moment=0.5, transverse_moment=0.25, **start)
    hoop = motion_plots.poses_at(ring, np.array([0.4]))[0]
    assert isinstance(disk, Pose)
    centre, end = disk.painted()
    np.testing.assert_allclose(hoop.centre(), centre, atol=1e-6)
    np.testing.assert_allclose(hoop.placed(np.array([1.0, 0.0, 0.0])), end, atol=1e-5)
    assert disk.faces(centre - hoop.frame[:, 2])
    coin = Solid.of("rim", 1.0, 0.1, 0.0, 1.0)
    assert coin.shown[coin.normals[:, 0, 2] < -0.5].tolist() == [FRONT]


def test_shapes():
    """The facets enclose the body's volume, their normals point outward, and the reach is right."""
    for solid, volume in (
        (Solid.of("torus", 0.75, 0.0, 0.25, 1.0), 2.0 * math.pi**2 * 0.75 * 0.25**2),
        (Solid.of("ball", 0.0, 0.4, 1.0, 1.0), 4.0 / 3.0 * math.pi),
        (Solid.of("spheroid", 0.0, -0.2, 1.0, 0.25), 2.0 / 3.0 * math.pi),
        (Solid.of("rim", 1.0, -0.1, 0.0, 1.0), 0.2 * math.pi),
        (
            Solid.of("rounded", 0.9, 0.0, 0.1, 1.0),
            math.pi * (2.0 * 0.81 * 0.1 + math.pi * 0.9 * 0.01 + 4e-3 / 3.0),
        ),
    ):
        one, two, three, four = np.moveaxis(solid.corners, 2, 0)
        areas = 0.5 * np.cross(three - one, four - two)
        # the flux of a field with divergence 3
        flow = np.einsum("ijk,ijk->ij", solid.corners.mean(axis=2), areas).sum() / 3.0
        assert abs(flow) == pytest.approx(volume, rel=0.01)
        outwards = np.einsum("ijk,ijk->ij", solid.corners.mean(axis=2), solid.normals)
        sizes = np.linalg.norm(areas, axis=-1)
        assert (outwards * sizes).sum() / 3.0 == pytest.approx(volume, rel=0.01)
    assert Solid.of("ball", 0.0, 0.4, 1.0, 1.0).reach == pytest.approx(1.4)


def test_the_outline_of_a_ring():
    """Where a ray from the eye touches the tube, it is perpendicular to the normal."""
    ring = Solid.of("torus", 0.7, 0.0, 0.3, 1.0)
    eye = np.array([2.0, 1.0, 3.0])
    for line in ring.contours(eye):
        out = np.hypot(line[:, 0], line[:, 1])
        assert np.hypot(out - 0.7, line[:, 2]) == pytest.approx(0.3, rel=1e-12)
        middle = np.column_stack([0.7 * line[:, :2] / out[:, None], 0.0 * out])
        ray = np.einsum("ij,ij->i", line - middle, eye - line)
        assert np.abs(ray).max() < 1e-12


@pytest.mark.release
def test_every_body_can_be_drawn(motions, tmp_path):
    """Figure and film of each body are drawn without a warning, name the body, and are reproducible byte for byte."""
    for body, motion in motions.items():
        for name in ("first", "second") if body == "torus" else (body,):
            plots.save(plots.motion_figure(motion), tmp_path / f"{name}.png")
        film = tmp_path / f"{body}.gif"
        motion.eulerdisk.animate(film, fps=1, size="240x200")
        assert film.stat().st_size > 5_000, body
        assert caption(motion).startswith(f"{CALLED[body]}, R = 0.5 m")
    assert (tmp_path / "first.png").read_bytes() == (tmp_path / "second.png").read_bytes()


def test_a_thin_body_that_stands_upright_can_be_drawn(tmp_path):
    """A thin upright body, which is a line from the top and from the light, can be drawn."""
    thin = {"body": "torus", "tube": 0.0, "axial_moment": 0.5, "transverse_moment": 0.25, "roll_rate": 3.0}
    motion = sweep.simulate(**thin, tilt=0.0, duration="1s")
    plots.save(plots.motion_figure(motion), tmp_path / "thin.png")
    motion.eulerdisk.animate(tmp_path / "thin.gif", fps=1, size="240x200", camera="top")


@pytest.mark.slow_lane
def test_a_body_is_whole_in_every_picture(motions):
    """In every frame and from every camera, the body is visible and surrounded by background."""
    for motion in (motions["torus"], motions["spheroid"]):
        for camera in ("fixed", "follow", "top"):
            options = FilmOptions.read("a.gif", fps=1, size="240x200", camera=camera)
            for picture in animation._frames(motion, timing(motion, options), options):
                red, _, blue = np.moveaxis(picture[..., :3].astype(int), -1, 0)
                coloured = np.abs(red - blue) > 60
                assert coloured.sum() > 300
                assert not coloured[:, :4].any()
                assert not coloured[:, -4:].any()


def test_a_ring_throws_a_shadow_with_a_hole():
    """The shadow of a ring that lies almost flat has a bright center; the shadow of an upright one has no hole."""
    import matplotlib.pyplot as plt

    flat, upright = (
        sweep.simulate(body="torus", tube=0.2, tilt=tilt, duration="1ms", fall_tilt="89deg")
        for tilt in ("80deg", "5deg")
    )
    for motion, holes in ((flat, 1), (upright, 0)):
        pose = poses_of_body(motion, np.array([0.0]))[0]
        figure, axes = plt.subplots()
        pose.draw(axes, Camera.on(pose.centre(), 1.0, 30.0))
        starts = [
            code for path in axes.collections[0].get_paths() for code in path.codes if code == path.MOVETO
        ]
        assert len(starts) == 1 + holes
        plt.close(figure)


def test_an_edge_has_its_shape():
    """A rim at negative tilt has the same shape, because it is its own mirror image."""
    shapes = [
        solid_of(sweep.simulate(body="rim", thickness=0.3, tilt=tilt, duration="1ms"))
        for tilt in ("20deg", "-20deg")
    ]
    np.testing.assert_array_equal(shapes[0].meridian, shapes[1].meridian)
