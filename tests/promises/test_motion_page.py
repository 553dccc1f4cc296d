"""docs/motions.md and docs/films.md: what they say can be asked for, and their numbers are those of the code."""

import re
import shlex
from pathlib import Path

import pytest

import sweep
from sweep.figures.disk import film_options, film_timing, view
from sweep.figures.disk.film_options import CAMERAS, FilmOptions
from sweep.motion.preset import is_preset, request_of_preset
from sweep.motion.request import split_motion_words

pytestmark = pytest.mark.compiled

DOCS = Path(__file__).parents[2] / "docs"
PAGE = "".join((DOCS / name).read_text(encoding="utf-8") for name in ("motions.md", "films.md"))


def test_its_commands_are_requests_that_can_be_met(monkeypatch):
    """Words and options of every command are read as the command reads them."""
    monkeypatch.setattr(film_options.shutil, "which", lambda name: name)
    (block,) = re.findall(r"^```bash\n(.*?)^```$", PAGE, re.M | re.S)
    for line in block.splitlines():
        words = shlex.split(line)
        assert words[:2] == ["eulerdisk", "simulate"]
        given = [word for word in words[2:] if "=" in word]
        if is_preset(words[2]):
            request_of_preset(words[2], split_motion_words(given))
        else:
            sweep.TrajectorySpec.from_words(given)
        options = {
            words[i].removeprefix("--"): words[i + 1] for i in range(len(words)) if words[i][:2] == "--"
        }
        options.pop("plot", None)
        if "fps" in options:
            options["fps"] = int(options["fps"])
        FilmOptions.read(options.pop("animate"), **options)


def test_its_python_runs(tmp_path, monkeypatch):
    """The block of Python makes a figure and a film."""
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"^```python\n(.*?)^```$", PAGE, re.M | re.S)
    exec(compile(block, "docs/motions.md", "exec"), {})
    assert sorted(each.name for each in tmp_path.iterdir()) == ["fall.gif", "fall.png"]


def test_its_numbers_are_those_of_the_code():
    """Sizes, rates and lengths of films, and the names of cameras, stand in the page as they are."""
    words = " ".join(PAGE.split())
    assert "25 if not given, at most 50 in a gif and 120 in an mp4" in words
    assert film_options._RATES == {"mp4": (25, 120), "gif": (25, 50)}
    assert f"from {film_options._SMALLEST} to {film_options._LARGEST}, even numbers in an mp4" in words
    assert f"may have {film_timing.MOST_FRAMES} frames" in words
    assert (film_timing._SHORTEST, film_timing._USUAL, film_timing._LONGEST) == (4.0, 20.0, 60.0)
    assert "real time for 4 to 20 s" in words
    assert f"farther than {view._WHOLE:g} radii" in words
    assert all(f"`{name}`" in words for name in CAMERAS)
