"""The page uses the style of printed figures: the same lines, and names of regions."""

import pytest
from matplotlib.colors import to_rgb

from sweep.figures import drawing
from tests.explorer.browser.map_page import BOTH, VERDICTS, colours, plot, wait_for_picture

pytestmark = pytest.mark.slow_lane

#: CSS pixels per point, the unit of widths in figures.
PIXELS = 96 / 72

#: Color from 0 to 1, width and dashes [pixels] of a path as drawn.
STYLE = """path => {
  const { stroke, strokeWidth, strokeDasharray } = getComputedStyle(path);
  return [stroke.match(/[\\d.]+/g).slice(0, 3).map((each) => each / 255), parseFloat(strokeWidth),
    strokeDasharray === "none" ? [] : strokeDasharray.split(", ").map(parseFloat)];
}"""


def test_lines_look_as_in_figures(opened):
    """Colors, widths and dashes of the lines equal those of figures; the measured line is a row of circles."""
    page = opened(BOTH.replace("stability", "peak_tilt"))
    page.wait_for_selector("#map .lines:not(.stale) .line.measured", state="attached")

    def style(kind, name):
        return page.locator(f"#map .lines .{kind}.{name}").evaluate(STYLE)

    for name, look in drawing.LINES.items():
        colour, width, dashes = style("line", name)
        assert colour == pytest.approx(list(to_rgb(look["color"])), abs=0.01), name
        assert width == pytest.approx(PIXELS * look["linewidth"], rel=0.03), name
        _, expected = look.get("linestyle", (0, ()))
        assert dashes == pytest.approx([each * width for each in expected], rel=0.03), name
        assert style("halo", name)[0] == [1.0, 1.0, 1.0]
        assert style("halo", name)[1] == pytest.approx(PIXELS * 2.4, rel=0.07)
    points, (colour, width, (length, apart)) = drawing._POINTS, style("line", "measured")
    assert colour == pytest.approx(list(to_rgb(points["markerfacecolor"])))
    assert width == pytest.approx(PIXELS * (points["markersize"] - points["markeredgewidth"]), rel=0.03)
    colour, outer, dashes = style("halo", "measured")
    assert colour == pytest.approx(list(to_rgb(points["color"])))
    assert outer == pytest.approx(PIXELS * (points["markersize"] + points["markeredgewidth"]), rel=0.03)
    assert dashes == [length, apart]
    assert length == 0.0 < 2 * outer < apart
    # the sample next to a name looks like the line
    for place in ("#map .legend", "#controls label"):
        assert page.locator(place).locator(".line.predicted").first.evaluate(STYLE) == style(
            "line", "predicted"
        )


@pytest.mark.parametrize(
    ("width", "hidden"),
    [
        (360, ""),
        pytest.param(1280, "", marks=pytest.mark.release),
        (1280, "&hide=analytic,predicted,measured"),
    ],
)
def test_regions_are_named_where_they_are(opened, width, hidden):
    """The words "stable" and "unstable" are on the map, completely inside their own regions."""
    page = opened(BOTH + hidden, viewport={"width": width, "height": 800})
    if not hidden:
        page.wait_for_selector("#map .lines:not(.stale) .line.measured", state="attached")
    wait_for_picture(page)
    names = page.locator("#map text.region")
    assert names.all_text_contents() == ["stable", "unstable"]
    box = plot(page)
    lines = page.locator("#map .lines .line").evaluate_all("all => all.map((each) => each.getAttribute('d'))")
    places = [
        tuple(map(float, each.split())) for line in lines for part in line.split("M") for each in part.split("L")
        if each
    ]  # fmt: skip
    for name, code in (("stable", 1), ("unstable", 2)):
        word = page.locator(f'#map text.region >> text="{name}"').bounding_box()
        left, top = word["x"] - box["x"], word["y"] - box["y"]
        right, bottom = left + word["width"], top + word["height"]
        corners = [[int(x), int(box["height"] - y)] for x in (left, right) for y in (top, bottom)]
        assert {VERDICTS[each] for each in colours(page, corners)} == {code}
        assert not [(x, y) for x, y in places if left < x < right and top < y < bottom]
    # a region that is too small for its name has none
    page.evaluate("location.hash = 'base=rolling&x=tilt,0.02,0.001,linear&y=roll_rate,3.5,0.2,linear'")
    wait_for_picture(page)
    assert names.all_text_contents() == ["stable"]
