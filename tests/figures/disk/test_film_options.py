"""The options of a film; refusals suggest a valid value."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from messages import refused

from sweep.errors import RequestError
from sweep.figures.disk import film_options
from sweep.figures.disk.film_options import CAMERAS, FilmOptions


@pytest.fixture(autouse=True)
def _with_ffmpeg(monkeypatch):
    monkeypatch.setattr(film_options.shutil, "which", lambda name: f"/bin/{name}")


def test_what_is_not_given_is_chosen():
    """The defaults are 25 frames a second and 640x480; speed and camera depend on the motion."""
    assert FilmOptions.read("a.gif") == FilmOptions("gif", None, 25, (640, 480), None)
    assert FilmOptions.read("A.MP4").ending == "mp4"


def test_what_is_given_is_taken():
    """Numbers and words are accepted as in the command line, and pairs as in Python."""
    read = FilmOptions.read("a.mp4", speed=0.1, fps=np.int64(60), size="1280x720", camera="follow")
    assert read == FilmOptions("mp4", 0.1, 60, (1280, 720), "follow")
    assert FilmOptions.read("a.gif", speed=2, size=(321, 241)).size == (321, 241)
    assert all(FilmOptions.read("a.gif", camera=name).camera == name for name in CAMERAS)


def test_what_no_film_can_be_is_refused():
    """A refusal gives the allowed values, the given value and a suggestion."""
    for name, given, words in (
        ("a.avi", {}, [".mp4 or .gif", "Write a.gif."]),
        ("a.gif", {"speed": 0.0}, ["speed", "got 0.", "Write 1 for real time"]),
        ("a.gif", {"speed": -1}, ["got -1."]),
        ("a.gif", {"speed": float("nan")}, ["got nan."]),
        ("a.gif", {"speed": float("inf")}, ["got inf."]),
        ("a.gif", {"speed": "fast"}, ["got fast."]),
        ("a.gif", {"speed": True}, ["got True."]),
        ("a.mp4", {"fps": 1000}, ["from 1 to 120", "fps=1000"]),
        ("a.gif", {"fps": 60}, ["from 1 to 50", "fps=60", "Write 25, or 50"]),
        ("a.gif", {"fps": 0}, ["fps=0"]),
        ("a.gif", {"fps": 2.5}, ["whole number", "fps=2.5"]),
        ("a.gif", {"fps": True}, ["whole number", "fps=True"]),
        ("a.gif", {"size": "1x1"}, ["from 200 to 4096", "got 1x1", "Write 1280x720."]),
        ("a.gif", {"size": "640x99999"}, ["from 200 to 4096"]),
        ("a.gif", {"size": "640*480"}, ["WIDTHxHEIGHT", "got 640*480"]),
        ("a.gif", {"size": "\u0661\u0662\u0668\u0660x720"}, ["WIDTHxHEIGHT"]),
        ("a.gif", {"size": (640,)}, ["WIDTHxHEIGHT"]),
        ("a.gif", {"size": 640}, ["WIDTHxHEIGHT"]),
        ("a.mp4", {"size": "641x479"}, ["even numbers", "Write 642x480, or make a gif."]),
        ("a.gif", {"camera": "folow"}, ["fixed (", "follow (", "top (", "Did you mean follow?"]),
        ("a.gif", {"camera": 3}, ["got 3."]),
    ):
        with pytest.raises(RequestError) as refused:
            FilmOptions.read(name, **given)
        for word in words:
            assert word in str(refused.value)


def test_an_mp4_needs_ffmpeg(monkeypatch):
    """An mp4 without ffmpeg is refused, but a gif is possible."""
    monkeypatch.setattr(film_options.shutil, "which", lambda _: None)
    assert FilmOptions.read("a.gif").ending == "gif"
    with refused("ffmpeg", "a.gif"):
        FilmOptions.read("a.mp4")


def test_options_are_read_before_anything_heavy_is_loaded():
    """Refusing a film loads neither matplotlib nor xarray nor Pillow."""
    code = (
        "import sys\n"
        "from sweep.figures.disk.film_options import FilmOptions\n"
        "try: FilmOptions.read('a.gif', speed=0)\n"
        "except Exception as refused: print(refused.status)\n"
        "print(*{'matplotlib', 'xarray', 'numba', 'scipy', 'PIL'} & sys.modules.keys())"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert done.stdout == "2\n\n", done.stderr
