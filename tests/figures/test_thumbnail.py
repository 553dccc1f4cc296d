"""The small map, read back from the SVG: colors are the verdicts, and lines are at their values."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np

from sweep.figures.summary import COLOURS, UNDECIDED_COLOUR, thumbnail
from sweep.model.quantity import STABLE, UNSTABLE

SVG = "{http://www.w3.org/2000/svg}"


def drawn(verdicts, up=None, lines=(), labels=("across", "up")):
    """Return the parsed picture of some verdicts."""
    up = np.arange(len(verdicts), dtype=float) if up is None else up
    return ElementTree.fromstring(thumbnail(verdicts, up, lines, labels))


def painted(picture, shape):
    """Return the colors at the centers of the cells, first row at the bottom."""
    (ground,) = picture.iter(f"{SVG}rect")
    wide, high = float(ground.get("width")) / shape[1], float(ground.get("height")) / shape[0]
    found = np.full(shape, ground.get("fill"), dtype=object)
    for path in picture.iter(f"{SVG}path"):
        for left, top, width in re.findall(r"M(\S+) (\S+?)h([\d.e-]+?)v", path.get("d")):
            row = shape[0] - 1 - round(float(top) / high)
            start = round(float(left) / wide)
            found[row, start : start + round(float(width) / wide)] = path.get("fill")
    return found


def test_every_cell_has_the_colour_of_its_verdict():
    """For every pattern, cells have the color of their verdict; unknown codes are undecided."""
    for shape in ((1, 1), (3, 5), (40, 70)):
        verdicts = np.random.default_rng(3).integers(0, 4, shape).astype(np.int8)
        expected = np.full(shape, UNDECIDED_COLOUR, dtype=object)
        expected[verdicts == STABLE], expected[verdicts == UNSTABLE] = COLOURS[STABLE], COLOURS[UNSTABLE]
        np.testing.assert_array_equal(painted(drawn(verdicts), shape), expected)


def test_a_large_map_stays_small():
    """Of a million cells, the map shows a sample that includes the corners."""
    verdicts = np.full((1000, 1000), STABLE, np.int8)
    verdicts[0, -1] = UNSTABLE
    svg = thumbnail(verdicts, np.arange(1000.0), [], ("x", "y"))
    assert len(svg) < 20_000
    found = painted(ElementTree.fromstring(svg), (120, 120))
    assert found[0, -1] == COLOURS[UNSTABLE]
    assert (found == COLOURS[UNSTABLE]).sum() == 1


def test_lines_lie_at_their_values():
    """A line is at the centers of cells or between them, according to its values, and absent outside."""
    for turned in (False, True):
        up = np.array([1.0, 2.0, 4.0, 8.0])[:: -1 if turned else 1]
        values = np.array([1.0, 6.0, np.nan, 8.0, 9.0, 2.0])
        picture = drawn(np.zeros((4, 6), np.int8), up, [(values, 'class="line"')])
        (ground,) = picture.iter(f"{SVG}rect")
        width, height = float(ground.get("width")), float(ground.get("height"))
        found = [
            tuple(float(number) for number in point.split(","))
            for line in picture.iter(f"{SVG}polyline")
            for point in line.get("points").split()
        ]
        # in cells, from the lower left corner; an isolated point is as wide as its cell
        places = [(x / width * 6, 4 - y / height * 4) for x, y in found]
        expected = [(0.5, 0.5), (1.5, 3.0), (3.0, 3.5), (4.0, 3.5), (5.0, 1.5), (6.0, 1.5)]
        if turned:
            expected = [(x, 4 - y) for x, y in expected]
        np.testing.assert_allclose(places, expected, atol=0.02)


def test_labels_are_text():
    """Names from a file are not interpreted as markup."""
    picture = drawn(np.zeros((2, 2), np.int8), labels=("<b>&", "up"))
    assert [each.text for each in picture.iter(f"{SVG}text")] == ["<b>&", "up"]
