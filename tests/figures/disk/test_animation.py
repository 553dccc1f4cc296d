"""The frames of films, pixel by pixel: the disk is in the picture, the trail fades, and the impossible is shaded."""

from itertools import islice

import numpy as np
import pytest
from figure_words import misplaced
from messages import assert_facts, with_facts
from PIL import Image

import sweep
from sweep.figures.disk import animation
from sweep.figures.disk.animation import FilmWords
from sweep.figures.disk.disk_3d import dots_per_inch
from sweep.figures.disk.film_options import FilmOptions, timing
from sweep.motion.contact import rolling_limit

pytestmark = pytest.mark.compiled


def frames(motion, **given):
    """Return the frames of a film, red, green and blue from 0 to 255, and their times."""
    options = FilmOptions.read("a.gif", **given)
    times = timing(motion, options)
    pictures = [each[..., :3].astype(int) for each in animation._frames(motion, times, options)]
    return pictures, times.moments


def of_the_disk(picture):
    """Return the pixels of the yellow or the blue face: far from gray, from the red trail and from the shade."""
    red, green, blue = np.moveaxis(picture, -1, 0)
    return ((red - blue > 90) & (green - blue > 50)) | (blue - red > 50)


def of_the_trail(picture):
    """Return the strength of the red trail in every pixel, from 0 to 1."""
    red, green, _ = np.moveaxis(picture, -1, 0)
    return np.clip((red - green) / (0xC8 - 0x38), 0.0, 1.0)


@pytest.mark.slow_lane
def test_a_fall_is_whole_in_every_picture(pick):
    """A coin's fall of a fifth of a second is a film of at least four seconds; every frame shows the whole coin."""
    for camera in pick(("fixed", "follow", "top"), 2):
        motion = sweep.simulate(radius="12mm", tilt="1deg", duration=2.0)
        pictures, moments = frames(motion, camera=camera, fps=10, size="320x240")
        assert len(pictures) >= 40
        limit = rolling_limit(motion).time
        sizes = []
        for picture, moment in zip(pictures, moments, strict=True):
            assert picture.shape == (240, 320, 3)
            disk = of_the_disk(picture)
            sizes.append(disk.sum())
            assert not disk[:20].any()
            assert not disk[-20:].any()
            assert not disk[:, :8].any()
            assert not disk[:, -8:].any()
            # the background is white while the disk rolls
            paper = np.median(picture[:, :8].reshape(-1, 3), axis=0)
            assert (paper.min() < 235) == (moment >= limit)
        # an upright disk is a line without color from above, and so is one seen edge-on from the side
        assert max(sizes) > 3000
        assert camera == "top" or np.median(sizes) > 2000


def test_the_trail_fades():
    """The trail is faint far behind the disk and strong near it; its oldest part disappears after a second."""
    motion = sweep.simulate(roll_rate=2.0, duration=12.0)
    pictures, _ = frames(motion, camera="top", fps=1, speed=1.0)
    trail = of_the_trail(pictures[9])
    # upward from the start at one meter a second; the disk itself hides the end
    rows = np.nonzero(trail.max(axis=1) > 0.15)[0]
    strengths = trail[rows].max(axis=1)
    assert strengths[5:15].mean() > 2.0 * strengths[-15:-5].mean()
    # the start of the trail has disappeared
    earlier = np.nonzero(of_the_trail(pictures[5]).max(axis=1) > 0.15)[0]
    assert rows.max() < earlier.max() - 50
    # it fades in seconds of the film, so at twice the speed it is twice as long
    pictures, _ = frames(motion, camera="top", fps=1, speed=2.0)
    faster = np.nonzero(of_the_trail(pictures[4]).max(axis=1) > 0.15)[0]
    assert np.ptp(faster) == pytest.approx(2.0 * np.ptp(rows), rel=0.15)


def test_words_grow_with_the_picture():
    """In pictures of at least 640 x 480, letters are more than 1/30 of the height; no words overlap or are cut."""
    for size in ((320, 240), (480, 640), (640, 480), (1280, 720), (1920, 1080)):
        motion = sweep.simulate(radius="12mm", tilt="1deg", precession_rate=12.34, duration=2.0)
        drawn = animation._sheet(size)
        times = timing(motion, FilmOptions.read("a.gif"))
        words = FilmWords(drawn, motion, times, rolling_limit(motion))
        words.scale(0.005)
        words.write(0.19)
        letters = [each.get_fontsize() * drawn.dpi / 72.0 for each in drawn.texts]
        if size[0] > size[1] and size[1] >= 480:
            assert min(letters) > size[1] / 30.0
        boxes = [each.get_window_extent() for each in drawn.texts if each.get_text()]
        for i, box in enumerate(boxes):
            assert 0.0 < box.x0 < box.x1 < size[0]
            assert 0.0 < box.y0 < box.y1 < size[1]
            assert not any(box.overlaps(other) for other in boxes[:i])


#: A title too long for one line of 640 pixels, and one of more than two lines.
TITLE = "A coin of twelve millimetres on a table of glass, nudged by one degree while it spins"
TITLES = ("", TITLE, f"{TITLE}, and what happens to it within two seconds of time")


@pytest.mark.parametrize("size", [(200, 300), (320, 240), (480, 640), (640, 480), (1280, 720)])
@pytest.mark.parametrize("title", TITLES, ids=["short", "long", "longer"])
def test_no_word_of_a_film_is_cut(title, size, monkeypatch):
    """Titles, captions with all rates, and notes of what is impossible are wrapped; no word is cut or overlaps."""
    start = {"tilt": "1.234deg", "tilt_rate": -12.34, "precession_rate": -12.34, "roll_rate": -123.4}
    motion = sweep.simulate(
        radius="12.345mm", gravity=1.625, duration=2.0, **start, **({"title": title} if title else {})
    )
    sheets, made = [], animation._sheet
    monkeypatch.setattr(animation, "_sheet", lambda size: sheets.append(made(size)) or sheets[-1])
    options = FilmOptions.read("a.gif", size=size, fps=1)
    words = set()
    for _ in islice(animation._frames(motion, timing(motion, options), options), 5):
        assert misplaced(sheets[0]) == []
        words |= {" ".join(each.get_text().split()) for each in sheets[0].texts}
    assert motion.attrs["title"] in words
    assert not title or motion.attrs["title"] == title
    assert with_facts(
        words, "tilt rate -12.34 rad/s", "precession rate -12.34 rad/s", "roll rate -123.4 rad/s"
    )
    assert rolling_limit(motion).lifts_off == 0.0
    assert with_facts(words, "lifted off", "start")


@pytest.mark.slow_lane
def test_the_disk_is_below_the_lines_of_a_long_title():
    """A long title needs more room, and the disk becomes smaller."""
    for size in ((200, 200), (640, 480)):
        motion = sweep.simulate(radius="12mm", tilt="1deg", duration=2.0, title=TITLE)
        options = FilmOptions.read("a.gif", size=size, fps=5)
        times = timing(motion, options)
        words = FilmWords(animation._sheet(size), motion, times, rolling_limit(motion))
        inch = dots_per_inch(size)
        for picture in animation._frames(motion, times, options):
            disk = of_the_disk(picture[..., :3].astype(int))
            assert not disk[: int(words.room[0] * inch)].any()
            assert not disk[-int(words.room[1] * inch) :].any()


def test_words_say_disk_speed_and_scale():
    """The picture has a caption, a time that distinguishes frames, the speed and the size of the squares."""
    motion = sweep.simulate(radius="12mm", tilt="1deg", duration=2.0)
    times = timing(motion, FilmOptions.read("a.gif"))
    drawn = animation._sheet((640, 480))
    words = FilmWords(drawn, motion, times, rolling_limit(motion))
    words.scale(0.005)
    words.write(0.1)
    title, caption, time, scale, impossible = (each.get_text() for each in drawn.texts)
    assert (title, impossible) == (motion.attrs["title"], "")
    assert_facts(caption, "R = 12 mm", "α = 0.5", "tilt 1 deg", "rest")
    assert_facts(time, "t = 0.100 s", "0.05 \u00d7")
    assert_facts(scale, "5 mm")
    words.write(0.185)
    assert_facts(drawn.texts[-1].get_text(), "slipped", "0.1816 s")
    words.write(0.19)
    assert_facts(drawn.texts[-1].get_text(), "lifted", "0.1881 s")


@pytest.mark.parametrize("fps", [7, 15, 25, 50])
def test_a_gif_keeps_its_time(fps, tmp_path):
    """Frames last whole hundredths of a second, none is off by more than half of one, and the last is held."""
    path = tmp_path / "a.gif"
    path.touch()
    # equal frames would be merged
    pictures = (np.full((8, 8, 4), 255 * (i % 2), np.uint8) for i in range(24))
    animation.write_gif(pictures, 24, fps, path)
    with Image.open(path) as film:
        assert film.n_frames == 24
        assert film.info["loop"] == 0
        durations = []
        for i in range(24):
            film.seek(i)
            durations.append(film.info["duration"])
    durations[-1] -= 1500
    ends = np.cumsum(durations)
    assert (ends % 10 == 0).all()
    assert np.abs(ends - 1000.0 * np.arange(1, 25) / fps).max() <= 5.0
