"""The sketch of docs/theory.md: its directions follow the equations, and it exists for light and dark pages."""

import math
import re
from pathlib import Path

import lagrange
import numpy as np
import plot_angles
import pytest
from matplotlib.colors import to_rgb

from sweep.figures import plots

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_rates_that_are_drawn_move_the_centre_as_the_equations_do():
    """The drawn directions of tilt rate, precession and roll turn the disk about C; G's speed fits its energy."""
    tilting, turning, rolling = 0.3, -0.7, 1.1
    sin, cos = math.sin(plot_angles.TILT), math.cos(plot_angles.TILT)
    along, diameter, axis = plot_angles.ALONG, plot_angles.DIAMETER, plot_angles.AXIS
    rotation = tilting * along + turning * cos * diameter + (rolling + turning * sin) * axis
    # This is a point mass at the center: Lagrange's mass matrix without moments of inertia.
    q = np.array([0.0, 0.0, plot_angles.HEADING, plot_angles.TILT, plot_angles.ROLL])
    v = np.array([*(rolling * along[:2]), turning, tilting, rolling])
    assert lagrange.constraint_matrix(q, 1.0) @ v == pytest.approx([0.0, 0.0])
    velocity = np.cross(rotation, diameter)
    assert velocity @ velocity == pytest.approx(v @ lagrange.mass_matrix(q, 0.0, 1.0, 1.0) @ v)
    # A positive tilt rate increases a positive tilt, and a positive roll moves along the track.
    assert velocity @ plot_angles.ACROSS == pytest.approx(tilting * cos, abs=1e-15)
    assert velocity @ along == pytest.approx(rolling + turning * sin)


@pytest.mark.parametrize(("name", "ink"), [("angles.svg", "LIGHT"), ("angles-dark.svg", "DARK")])
def test_the_drawings_of_the_page_are_those_of_the_script(tmp_path, name, ink):
    """Both have a transparent background and the colors of their ink, and are where the page shows them."""
    colours = getattr(plot_angles, ink)
    drawn = plot_angles.figure(colours)
    assert drawn.patch.get_alpha() == 0.0
    plots.save(drawn, tmp_path / name)
    for text in ((tmp_path / name).read_text(encoding="utf-8"), (DOCS / "theory" / name).read_text("utf-8")):
        assert {colours.tilt, colours.heading, colours.roll} <= set(re.findall(r"#[0-9a-f]{6}", text))
    assert f'"theory/{name}"' in (DOCS / "theory.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(("ink", "ground"), [("LIGHT", "#ffffff"), ("DARK", "#14181e")])
def test_every_colour_stands_out(ink, ground):
    """Lines and words have the text contrast of 4.5 that WCAG requires; faint lines have 3."""

    def light(colour):
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
        return np.dot(linear, [0.2126, 0.7152, 0.0722])

    colours = getattr(plot_angles, ink)
    for name, least in (("line", 4.5), ("tilt", 4.5), ("heading", 4.5), ("roll", 4.5), ("faint", 3.0)):
        low, high = sorted((light(getattr(colours, name)), light(ground)))
        assert (high + 0.05) / (low + 0.05) >= least, name
