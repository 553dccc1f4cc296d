"""The page on every screen: widths, sharp pixels, dark and light, and no clipped text."""

import re
from itertools import pairwise

import pytest
from explorer_browser import COMPLETE

import sweep
from tests.explorer.browser.map_page import BOTH, click, entries, plot, shown, wait_for_picture

pytestmark = pytest.mark.slow_lane


def test_dark_and_light(opened):
    """The page follows the system's theme, the button switches it, and the address keeps the choice."""
    page = opened(BOTH, color_scheme="dark")
    background = "getComputedStyle(document.body).backgroundColor"
    dark = page.evaluate(background)
    page.locator("#theme").click()
    wait_for_picture(page)
    light = page.evaluate(background)
    assert sum(map(int, re.findall(r"\d+", dark))) < 120 < 600 < sum(map(int, re.findall(r"\d+", light)))
    assert entries(page)["theme"] == "light"
    page.locator("#theme").click()
    wait_for_picture(page)
    assert page.evaluate(background) == dark
    assert "theme" not in entries(page)


@pytest.mark.release
@pytest.mark.parametrize(
    ("system", "fragment"), [("dark", ""), ("light", ""), ("light", "theme=dark"), ("dark", "theme=light")]
)
def test_a_page_that_begins_does_not_flash(browser, explorer, system, fragment):
    """The page has its theme before the first response and keeps it."""
    context = browser.new_context(color_scheme=system, reduced_motion="reduce")
    page = context.new_page()
    asked = []
    page.route("**/about", lambda route: asked.append(route))
    page.add_init_script(
        """const look = () => {
            const { backgroundColor } = getComputedStyle(document.body);
            window.seen = [...(window.seen ?? []), backgroundColor];
            requestAnimationFrame(look);
        };
        addEventListener("DOMContentLoaded", look);"""
    )
    with page.expect_request("**/about"):
        page.goto(f"{explorer.url}#{fragment}")
    while not asked:
        page.wait_for_timeout(50)
    # that the address has another theme than the system is known once the modules are loaded
    if fragment:
        page.evaluate("seen = []")
    page.wait_for_timeout(100)
    asked[0].continue_()
    page.wait_for_selector(COMPLETE)
    seen = [sum(map(int, re.findall(r"\d+", each))) for each in page.evaluate("seen")]
    dark = "dark" in (fragment or system)
    assert len(seen) > 3
    assert all(each < 120 if dark else each > 600 for each in seen)
    context.close()


def test_page_fits_its_width(opened):
    """Nothing is wider than the screen, the picture fills most of a phone's width, and its pixels are the screen's."""
    page = opened(BOTH)
    for width in (320, 360, 768, 1280, 2560):
        page.set_viewport_size({"width": width, "height": 800})
        page.reload()
        page.wait_for_selector(COMPLETE)
        assert page.evaluate("document.documentElement.scrollWidth") == width
        box = plot(page)
        assert box["width"] > (0.7 if width < 500 else 0.35) * width
        assert shown(page)["width"] == box["width"]
        page.set_viewport_size({"width": width - 40, "height": 800})
        wait_for_picture(page)
        assert shown(page)["width"] == plot(page)["width"] < box["width"]


#: Elements with clipped text, drawn text outside its drawing, and overlapping or misplaced legend text.
CUT = """() => {
  const shown = (each) => each.getClientRects().length && !each.closest("#spoken, label[for^=value-criterion]");
  const cut = [...document.querySelectorAll("body *")].filter((each) =>
    shown(each) && each.clientWidth > 1 && each.scrollWidth > each.clientWidth + 1 &&
    !["visible", "auto"].includes(getComputedStyle(each).overflowX));
  const beyond = [...document.querySelectorAll("svg.overlay text, .plot svg text")].filter((each) => {
    const [word, all] = [each.getBoundingClientRect(), each.ownerSVGElement.getBoundingClientRect()];
    return word.left < all.left - 0.5 || word.right > all.right + 0.5 || word.top < all.top - 0.5 ||
      word.bottom > all.bottom + 0.5;
  });
  const frame = document.querySelector("#map .frame").getBoundingClientRect();
  const words = [...document.querySelectorAll("#map .legend :is(text, path.line)")];
  const boxes = words.map((each) => each.getBoundingClientRect());
  // the labels of a scale stand across its ends
  const beside = (each, { left, right }) =>
    !each.hasAttribute("text-anchor") && (left < frame.left - 0.5 || right > frame.right + 0.5);
  const crowded = words.filter((each, i) =>
    beside(each, boxes[i]) || boxes.some((other, j) =>
      j < i && boxes[i].left < other.right && other.left < boxes[i].right &&
      boxes[i].top + 3 < other.bottom && other.top + 3 < boxes[i].bottom));
  // a choice is as wide as the longest of its words, so that none of them is cut when it is chosen
  const narrow = [...document.querySelectorAll("select")].filter((each) => {
    const copy = each.cloneNode(true);
    copy.style.cssText = "position: absolute; width: max-content; max-width: none";
    each.after(copy);
    const wide = copy.offsetWidth;
    copy.remove();
    return shown(each) && each.offsetWidth < wide;
  });
  return [...cut, ...beyond, ...crowded, ...narrow].map((each) => each.textContent);
}"""


def test_nothing_is_cut(opened):
    """At every width, all numbers, titles, ticks and line samples are complete."""
    page = opened(viewport={"width": 320, "height": 900})
    page.wait_for_selector("#map .lines:not(.stale) .line.analytic", state="attached")
    click(page, 0.1, 0.2)
    page.locator("#motions .motion.shown:not(.waiting)").wait_for()
    page.locator("#readout").filter(has_not_text="\u2026").filter(has_text="wells").wait_for()
    for width in (320, 360, 390, 768, 1000, 1440, 1920, 2560):
        page.set_viewport_size({"width": width, "height": 900})
        wait_for_picture(page)
        page.wait_for_selector("#map .lines:not(.stale) .line.analytic", state="attached")
        assert page.evaluate(CUT) == [], width
        assert page.locator("#map .legend .line").count() == 3, width
        assert page.evaluate("document.documentElement.scrollWidth") == width


@pytest.mark.release
def test_the_legend_of_stored_cells_has_room(opened, served_with, tmp_path):
    """The stored cells' border is named next to the title, even with a long title on a narrow screen."""
    path = tmp_path / "atlas.nc"
    sweep.run_to_file(
        "rolling", path, roll_rate="2.3:3.1:8", tilt="0.2deg:4deg:6:log", method="exact", progress=False
    )
    page = opened("quantity=peak_tilt", url=served_with(path).url)
    for quantity in ("peak_tilt", "nutation_period", "stability"):
        page.evaluate("quantity => { location.hash = `quantity=${quantity}` }", quantity)
        for width in (320, 360, 1280):
            page.set_viewport_size({"width": width, "height": 800})
            wait_for_picture(page)
            page.wait_for_selector("#map .legend .line.measured", state="attached")
            assert shown(page)["quantity"] == quantity
            assert page.locator("#map .legend path.line.stored").count() == 1
            assert "stored" in page.locator("#map .legend").text_content()
            assert page.evaluate(CUT) == [], (quantity, width)


@pytest.mark.release
def test_words_of_a_start_fit_a_phone(opened):
    """Long lines of an explanation scroll in their box, so the page is not wider than the screen."""
    page = opened(BOTH, viewport={"width": 360, "height": 740})
    click(page, 0.3, 0.2)
    page.wait_for_selector("#motions .slot[data-shown]")
    page.locator("details.words summary").first.click()
    page.locator(".explanation", has_text="because").first.wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") == 360


@pytest.mark.release
def test_sharp_screens_have_sharp_pictures(opened):
    """On a screen with two pixels per CSS pixel, the picture has that resolution."""
    page = opened(BOTH, device_scale_factor=2)
    assert shown(page)["width"] == 2 * plot(page)["width"]


def test_numbers_of_an_axis_do_not_touch(opened):
    """On a logarithmic axis of less than two decades, where numbers are dense, they do not touch."""
    page = opened("base=rolling&x=tilt,-8.35,0.85,log&y=roll_rate,2.6,0.2,linear")
    for width in (360, 1840):
        page.set_viewport_size({"width": width, "height": 800})
        wait_for_picture(page)
        for words in (
            "#map .axis:nth-child(1 of .axis) text:not(.title)",
            "#map .legend g text[text-anchor=middle]",
        ):
            # in one call, because a redrawn axis has empty boxes
            boxes = page.evaluate(
                "words => [...document.querySelectorAll(words)].map((e) => e.getBoundingClientRect().toJSON())",
                words,
            )
            assert len(boxes) > 1, (width, words)
            gaps = [after["x"] - each["x"] - each["width"] for each, after in pairwise(boxes)]
            assert min(gaps) > 4, (width, words)
