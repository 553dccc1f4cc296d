"""Texts of files and requests in figures are drawn literally, not as mathematics, on one line that fits."""

import pytest

import sweep
from sweep.commands.report import describe
from sweep.errors import plain_text
from sweep.figures import plots
from sweep.figures.disk import animation, motion_plots
from sweep.figures.disk.film_options import FilmOptions
from sweep.figures.texts import fitted

#: Titles that are difficult for mathematics, fonts and layouts.
TITLES = (
    "$",
    r"$\frac{\frac{1}{2}}{$",
    "x" * 2**20,
    "\u6eda\u52a8 \U0001f600",
    "cost: 5$ or 6$",
    r"a_b^c \alpha % & #",
    "[red]{}[/]",
)


@pytest.fixture(scope="module")
def spec():
    """Return the spec of a small map."""
    return sweep.SweepSpec(tilt="1deg:2deg:3", roll_rate="2:3:4")


@pytest.mark.slow_lane
def test_a_title_is_drawn_as_it_stands(spec, tmp_path):
    """No title breaks a figure or causes a glyph warning; the panel has the text, cut if too long."""
    for title in TITLES:
        drawn = plots.figure([sweep.run(spec.replace(title=title))])
        plots.save(drawn, tmp_path / "map.png")
        shown = drawn.axes[0].get_title(loc="left")
        assert shown.rstrip("\u2026") == fitted(title, 9.0, 9.0)[: len(shown.rstrip("\u2026"))]
        assert 0 < len(shown) < 80
        # saving leaves sizes in the file's resolution
        drawn.draw_without_rendering()
        box = drawn.axes[0]._left_title.get_window_extent()
        assert 0.0 <= box.x0 < box.x1 <= drawn.bbox.x1


def test_the_figure_of_a_motion_takes_any_title_too(tmp_path):
    """The title of a single motion is drawn literally as well."""
    motion = sweep.simulate(
        sweep.TrajectorySpec.read(tilt_rate=0.01, roll_rate=3, duration=0.1, title="$^$ \u6eda")
    )
    plots.save(motion_plots.figure(motion), tmp_path / "motion.png")


def test_what_fits_stays(spec):
    """Text that fits is unchanged; unprintable or missing characters are escaped; long text ends in an ellipsis."""
    assert fitted("Rolling, 5 $ at \u03b1 = 1", 9.0, 3.3) == "Rolling, 5 $ at \u03b1 = 1"
    assert fitted("a\nb\x1b", 9.0, 3.3) == r"a\nb\x1b"
    assert fitted("\u6eda", 9.0, 3.3) == r"\u6eda"
    cut = fitted("word " * 100, 9.0, 3.3)
    assert cut.endswith("\u2026")
    assert 20 < len(cut) < 60


def test_a_title_with_an_umlaut_is_shown_as_it_was_written(spec, tmp_path, monkeypatch):
    """Files have ASCII titles; figures, films, `info` and the accessor show the original."""
    motion = sweep.simulate(tilt_rate=0.01, roll_rate=3, duration=0.1, title="M\u00fcnze \u03b1")
    assert motion.attrs["title"] == r"M\xfcnze \u03b1"
    assert "M\u00fcnze \u03b1" in [each.get_text() for each in motion_plots.figure(motion).texts]
    written = []
    monkeypatch.setattr(animation, "wrapped", lambda text, *_, **__: written.append(text) or [text])
    animation.save(motion, tmp_path / "film.gif", FilmOptions.read("film.gif", fps=2, size="200x200"))
    assert "M\u00fcnze \u03b1" in written
    atlas = sweep.run(spec.replace(title="M\u00fcnze \u03b1"))
    assert describe(atlas).startswith("M\u00fcnze \u03b1\n")
    assert "M\u00fcnze \u03b1" in repr(atlas.eulerdisk)
    assert "M\u00fcnze \u03b1" in repr(motion.eulerdisk)


def test_what_no_attribute_spells_stays():
    """Escapes of ASCII, unprintable or invalid characters stay text; other escapes are converted back."""
    for kept in (r"\x41", r"\x85", r"\u202e", r"\ud800", r"\Uffffffff", r"\n", r"C:\xy"):
        assert plain_text(kept) == kept
        assert plain_text(rf"\xfc\u6eda\U0001f600{kept}") == f"\u00fc\u6eda\U0001f600{kept}"
