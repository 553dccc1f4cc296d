"""Numbers on the pages match the code and its results."""

import math
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from latex_formula import Page, lines

import sweep
from sweep.explorer import export, server, take_away, view, window
from sweep.explorer import lines as explorer_lines
from sweep.figures.disk import disk_3d as camera
from sweep.figures.disk import film_options
from sweep.model.disk.model import DISK
from sweep.model.lossy_disk.model import LOSSY_DISK

CHECKOUT = Path(__file__).resolve().parents[2]


def page(name):
    """Return the text of a page."""
    return (CHECKOUT / "docs" / f"{name}.md").read_text(encoding="utf-8")


def missing(name, stated):
    """Return the statements that a page lacks or that are false."""
    text = " ".join(page(name).split())
    return [words for words, holds in stated.items() if words not in text or not holds]


def test_the_explorer():
    """The limits in docs/explorer.md are correct."""
    followed = (CHECKOUT / "sweep/explorer/page/compute/motion.js").read_text(encoding="utf-8")
    stated = {
        "at most 64 KiB": server.MOST_BYTES == 65536,
        "a window at most four million pixels": window.MOST_PIXELS == 4_000_000,
        "64 requests at a time": server.MOST_REQUESTS == 64,
        "has not arrived as a whole after 5 s": server._Handler.timeout == 5.0,
        "no room for 6 s gets status 503": server._PATIENCE == 6.0,
        "CSV, netCDF, up to a million": take_away.MOST_CELLS == 1_000_000,
        "4000 of its units of time": "disk: { turns: 400, units: 4e3 }" in followed,
        "in single precision, up to a million": export.MOST_CELLS == 1_000_000,
        "grid of 96 x 72 exact cells": explorer_lines.COARSE == (96, 72),
        "a pixel is 8 units in the last place wide": view.ULPS == 8,
        "listens only at 127.0.0.1": server.HOST == "127.0.0.1",
    }
    assert missing("explorer", stated) == []


def test_films():
    """Sizes, rates and lengths of films in docs/motions.md are correct, and so are the camera names."""
    stated = {
        "25 by default, at most 50 in a gif and 120 in an mp4": film_options._RATES
        == {"mp4": (25, 120), "gif": (25, 50)},
        f"from {film_options._SMALLEST} to {film_options._LARGEST}, even numbers in an mp4": True,
        f"{film_options.MOST_FRAMES} frames": True,
        "4 to 20 s": (film_options._SHORTEST, film_options._USUAL) == (4.0, 20.0),
        f"farther than {camera._WHOLE:g} radii": True,
        **{f"`{name}`": True for name in film_options.CAMERAS},
    }
    assert missing("motions", stated) == []
    assert film_options._LONGEST == 60.0


def test_words():
    """docs/words.md has exactly one row for each input that stands for a parameter."""
    rows = re.findall(r"^\| `(\w+)` \| `(\w+)` \|", page("words"), flags=re.MULTILINE)
    assert sorted(rows) == sorted((name, each.parameter) for name, each in DISK.substitutes.items())


@pytest.mark.compiled
def test_the_report():
    """Extreme tilts, the variation of H.e3 and friction in docs/checked.md are correct; its tests exist."""
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", page("checked"))
    assert len(named) >= 10
    for path, name in named:
        assert f"def {name}(" in (CHECKOUT / path).read_text(encoding="utf-8"), name
    rolling, steady = (sweep.simulate(tilt_rate=0.01, roll_rate=rate) for rate in (2.0, 3.0))
    spinning, fast = (sweep.simulate(tilt_rate=0.1, precession_rate=rate) for rate in (3.5, 4.5))
    assert np.degrees(np.abs(steady["tilt"]).max()) < 0.24
    assert np.degrees(np.abs(fast["tilt"]).max()) < 2.7
    assert np.degrees(np.abs(spinning["tilt"]).max()) == pytest.approx(28.66, abs=0.005)
    assert np.ptp(rolling["vertical_momentum"].values) == pytest.approx(1.03, abs=0.005)
    assert float(rolling["friction_needed"].max()) == pytest.approx(0.45, abs=0.005)
    assert float(spinning["friction_needed"].max()) == pytest.approx(0.25, abs=0.005)
    assert set(np.unique(sweep.simulate(tilt=0.1, tilt_rate=0.1)["contact"])) == {0, 1, 2}


def table(heading):
    """Return the rows of a table of docs/losses.md, selected by its heading, as lists of cells."""
    text = page("losses")
    rows = text[text.index(f"| {heading} |") :].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("|").split(" | ")] for row in rows]


def test_the_names_of_losses():
    """The table of laws lists exactly the coefficients that a request may give."""
    named = set(re.findall(r"`(\w+)`", "".join(row[1] for row in table("law"))))
    assert named == {name for name in LOSSY_DISK.parameters if name.endswith(("friction", "damping"))} - {
        "friction"
    } | {"air_viscosity", "air_density", "mass"}


@pytest.mark.compiled
def test_the_times_of_losses():
    """Each time in the table follows from the inputs next to it, to its last digit."""
    toy = {
        "tilt": math.pi / 2 - 0.1, "precession_rate": "wobble", "roll_rate": "wobble",
        "alpha": 0.5, "radius": 0.03755, "mass": 0.4387, "duration": 300.0,
    }  # fmt: skip
    for words, said, *_ in table("losses"):
        given = dict(word.split("=") for word in words.strip("`").split())
        found = sweep.simulate(**toy, **given)
        assert f"{float(found['elapsed_time'][-1]):.2f} s" == said, words


def test_the_end_of_losses():
    """Exponents, times to flat and drags of docs/losses.md match docs/losses-theory.md."""
    text, theory = page("losses"), Page("losses-theory.md")
    section = text[text.index("## How it ends") :]
    pairs = re.findall(r"^\| [\w, ]+ \| ([\d/]+) \| −([\d/]+) \|", section, flags=re.MULTILINE)
    assert len(pairs) == 5
    # precession^2 is proportional to 1/inclination
    assert all(Fraction(tilt) == 2 * Fraction(rate) for tilt, rate in pairs)
    rows = table(
        r"law | inclination $\propto (t_f-t)^n$ | precession rate $\propto (t_f-t)^{-n/2}$ | $t_f$ from $a_0$"
    )
    for row, time in zip(rows, theory.formulas["times"], strict=True):
        of_any, uniform = (lines(f"t = {cell.strip('$')}")[0] for cell in row[3:])
        known = {"a_0": 0.07, "c": 0.2, "k": 0.3, "q": 0.4}
        for alpha in (0.5, 0.8):
            expected = time.value({**known, "alpha": alpha})
            assert of_any.value({**known, "alpha": alpha}) == pytest.approx(expected), row
        assert uniform.value(known) == pytest.approx(of_any.value({**known, "alpha": 0.5}), rel=3e-3), row
    known = {"pi": math.pi, "mu": 2.0, "rho": 3.0, "R": 0.4, "g": 5.0, "m": 0.6}
    drags = [lines(each)[0].value(known) for each in re.findall(r"\$(q = [^$]+)\$", text)]
    assert drags == pytest.approx([line.value(known) for line in theory.formulas["coefficients"][1:]])
