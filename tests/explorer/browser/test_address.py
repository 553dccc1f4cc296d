"""The address of the page contains the settings of the map and the motions, and a bad address does no harm."""

import io

import numpy as np
import pytest
from explorer_browser import COMPLETE
from PIL import Image

from tests.explorer.browser.map_page import BOTH, axis, click, entries, point, shown, wait_for_picture

pytestmark = pytest.mark.slow_lane

#: A panel whose motion is shown.
SHOWN = "#motions .slot[data-shown] .motion.shown:not(.waiting)"

CLOCK = """async () => {
  const { clock } = await import("eulerdisk/motion/clock");
  return [clock.time, clock.playing, clock.speed];
}"""

#: For each slider with a field: the field's text and the slider's text for screen readers.
SPOKEN = """() => [...document.querySelectorAll(".slider")]
  .map((slider) => [slider.querySelector(".number input"), slider.querySelector("input[type=range]")])
  .filter(([field, range]) => field && range?.hasAttribute("aria-valuetext"))
  .map(([field, range]) => [field.value, range.getAttribute("aria-valuetext")])"""


def fragment_of(page):
    """Return the fragment of the address."""
    return page.url.split("#")[1]


def stage(page):
    """Return the picture of the first disk, colors from 0 to 255."""
    return np.asarray(Image.open(io.BytesIO(page.locator(".stage canvas").first.screenshot())), float)


def test_a_slider_is_spoken_as_it_is_read(opened):
    """A screen reader says the field's number with its unit, in degrees instead of the address's radians."""
    page = opened("base=rolling&x=roll_rate,2.5,0.7,linear&y=alpha,0.6,0.3,linear&with.tilt=0.05")
    wait_for_picture(page)
    spoken = page.evaluate(SPOKEN)
    assert any(text.endswith((" deg", " °")) for _, text in spoken)
    assert [text.partition(" ")[0] for _, text in spoken] == [field for field, _ in spoken]


def test_address_holds_all(opened):
    """A page opened with another page's address shows the same and has the same address."""
    fragment = (
        "base=circling&x=precession_rate,2.5,0.7000000000000001,linear&y=tilt,0.3,0.1,linear&with.alpha=0.8"
        "&with.criterion=amplification:20&quantity=amplification"
        "&a=2.4,0.31&a.loss.contour_friction=0.002&a.camera=0.5,0.9,8&a.open=laws"
        "&b=2.6,0.29&b.open=words&time=1.25&speed=0.2&compare=yes&hide=predicted&range=1,50&theme=dark"
    )
    # a motion with a time in the address stands there, even if the system allows motion
    page = opened(fragment, reduced_motion="no-preference")
    page.locator(SHOWN).nth(1).wait_for()
    wait_for_picture(page)
    assert fragment_of(page) == fragment
    assert page.locator("#base").input_value() == "circling"
    assert page.locator("#quantity").input_value() == "amplification"
    assert page.locator("#criterion-kind").input_value() == "amplification"
    assert not page.locator("#line-predicted").is_checked()
    assert page.locator("#hold-colours").is_checked()
    assert page.locator("#map circle.mark").count() == 2
    assert page.evaluate(CLOCK) == [1.25, False, 0.2]
    first, second = page.locator(".motion").nth(0), page.locator(".motion").nth(1)
    assert first.evaluate("each => each.classList.contains('lossy')")
    assert not second.evaluate("each => each.classList.contains('lossy')")
    assert first.get_by_role("slider", name="contour friction").get_attribute("aria-valuetext") == "2 mm"
    assert second.locator("details.words").evaluate("each => each.open")
    page.evaluate("fragment => { location.hash = fragment }", BOTH)
    wait_for_picture(page)
    assert shown(page)["view"]["base"] == "rolling"
    assert shown(page)["quantity"] == "stability"


@pytest.mark.release
def test_what_is_set_of_a_motion_is_shared(opened):
    """Losses, camera, time, speed and open explanations set by hand are in the address and shown when it is opened."""
    page = opened(BOTH)
    click(page, 0.3, 0.2)
    page.locator(SHOWN).wait_for()
    behind = stage(page)
    page.locator("details.laws summary").click()
    page.get_by_role("slider", name="contour friction").press("PageUp")
    page.locator(".motion.lossy.shown:not(.waiting)").wait_for()
    canvas = page.locator(".stage canvas")
    canvas.focus()
    for key in ("ArrowLeft", "ArrowLeft", "ArrowUp", "+"):
        canvas.press(key)
    page.locator("select[aria-label=speed]").select_option("0.5")
    page.locator("input.time").fill("300")
    wait_for_picture(page)
    held = entries(page)
    assert held["a.open"] == "laws"
    assert float(held["a.loss.contour_friction"]) > 0.0
    assert (held["speed"], float(held["time"]) > 0.0) == ("0.5", True)
    _, elevation, distance = map(float, held["a.camera"].split(","))
    assert elevation == pytest.approx(np.radians(22 + 6), rel=1e-5)
    assert distance == pytest.approx(0.9 * 5.8, rel=1e-5)
    # on a screen of the same size it is the same picture up to rounding, and differs from the initial one
    again = opened(fragment_of(page))
    again.locator(SHOWN).wait_for()
    wait_for_picture(again)
    again.wait_for_timeout(600)
    assert np.abs(stage(again) - stage(page)).mean() < 0.5 < 5.0 < np.abs(stage(page) - behind).mean()
    assert fragment_of(again) == fragment_of(page)
    # a motion that moves to another place keeps its settings
    again.get_by_role("button", name="Close A").click()
    wait_for_picture(again)
    assert not {"a", "a.open", "a.camera", "a.loss.contour_friction"} & entries(again).keys()


@pytest.mark.release
def test_what_takes_the_place_of_a_motion_brings_what_was_set_of_it(opened):
    """Closing the first motion makes the second the first, with its losses and open parts; a new start has none."""
    page = opened(
        f"{BOTH}&a=2.4,0.02&a.open=words&b=2.6,0.03&b.loss.contour_friction=0.002&b.open=laws&time=1&compare=yes"
    )
    page.locator(SHOWN).nth(1).wait_for()
    page.get_by_role("button", name="Close A").click()
    wait_for_picture(page)
    held = entries(page)
    assert (held["a"], held["a.loss.contour_friction"], held["a.open"]) == ("2.6,0.03", "0.002", "laws")
    assert not {"b", "b.open", "b.loss.contour_friction"} & held.keys()
    assert held["time"] == "1"
    page.evaluate("scrollTo(0, 0)")
    click(page, 0.3, 0.2)
    page.wait_for_url(lambda url: "&a=2.6,0.03" not in url)
    wait_for_picture(page)
    assert "a" in entries(page)
    assert "time" not in entries(page)


def test_addresses_that_others_have_written(opened):
    """The characters "+", ",", ":", ">" and spaces are read correctly, whether encoded or not."""
    page = opened(
        "x=roll_rate%2C%2B2.5%2C5e-1%2Clinear&y=tilt,-4.5e+0,1.5,log&with.criterion=departure%3A7deg&theme=dark)"
    )
    wait_for_picture(page)
    assert axis(page, "x") == ("roll_rate", 2.5, 0.5, "linear")
    assert axis(page, "y") == ("tilt", -4.5, 1.5, "log")
    assert entries(page)["with.criterion"] == "departure:7deg"
    assert "theme" not in entries(page)
    criterion = "peak_tilt > 1e+1deg"
    page.evaluate(
        "text => { location.hash = `with.criterion=${encodeURIComponent(text)}`; }",
        criterion,
    )
    wait_for_picture(page)
    assert entries(page)["with.criterion"] == criterion
    assert page.locator(".own-criterion").inner_text() == criterion
    assert page.locator("#notice").inner_text() == ""


def test_back_returns_to_what_was_given_up(opened):
    """The back button returns to a window replaced by another preset or the whole range; forward works, too."""
    page = opened(BOTH + "&a=2.4,0.02")
    first = fragment_of(page)
    page.locator("#base").select_option("spinning")
    # immediately: the previous state is in the history although it was not at rest
    page.locator("#slide-alpha").press("ArrowRight")
    wait_for_picture(page)
    spinning = fragment_of(page)
    assert spinning != first
    page.go_back()
    wait_for_picture(page)
    assert (fragment_of(page), page.locator("#base").input_value()) == (first, "rolling")
    page.locator("#motions .motion.shown").wait_for()
    page.go_forward()
    wait_for_picture(page)
    assert (fragment_of(page), page.locator("#base").input_value()) == (spinning, "spinning")
    page.go_back()
    wait_for_picture(page)
    page.locator("#whole").click()
    wait_for_picture(page)
    assert axis(page, "x") == ("roll_rate", 3.0, 1.0, "linear")
    # showing the whole range again replaces nothing
    page.locator("#whole").click()
    wait_for_picture(page)
    page.go_back()
    wait_for_picture(page)
    assert fragment_of(page) == first
    assert shown(page)["view"]["x"]["half"] == 0.5


@pytest.mark.release
def test_back_leads_past_a_double_click_to_what_it_gave_up(opened):
    """The start chosen by a double click's first click was not intended, so no history entry contains it."""
    page = opened(f"{BOTH}&a=2.4,0.02")
    first, entries_before = fragment_of(page), page.evaluate("history.length")
    page.mouse.dblclick(*point(page, 0.1, 0.1))
    wait_for_picture(page)
    whole = fragment_of(page)
    assert axis(page, "x") == ("roll_rate", 3.0, 1.0, "linear")
    # showing the whole range again replaces nothing
    for across in (-0.5, 0.0, 0.5):
        page.mouse.dblclick(*point(page, across, 0.1))
        wait_for_picture(page)
    assert (fragment_of(page), page.evaluate("history.length")) == (whole, entries_before + 1)
    page.go_back()
    wait_for_picture(page)
    assert fragment_of(page) == first


@pytest.mark.release
def test_a_double_click_beside_the_picture_undoes_no_click_before_it(opened):
    """A double click beside the picture chooses nothing; the previously chosen start and words stay."""
    page = opened(BOTH)
    click(page, 0.3, 0.2)
    wait_for_picture(page)
    start = entries(page)["a"]
    page.locator("#slide-alpha").press("ArrowRight")
    wait_for_picture(page)
    page.evaluate("scrollTo(0, 0)")
    page.mouse.dblclick(*point(page, -1.05, 0.0))
    wait_for_picture(page)
    assert axis(page, "x") == ("roll_rate", 3.0, 1.0, "linear")
    assert (entries(page).get("a"), "with.alpha" in entries(page)) == (start, True)


def go_to(page, fragment):
    """Give an open page another address and wait for its picture."""
    page.evaluate("fragment => { location.hash = fragment }", fragment)
    wait_for_picture(page)


def test_address_that_makes_no_sense_shows_the_first_view(opened):
    """Unreadable parts of an address have their initial values, and an unknown format is ignored."""
    page = opened("x=roll_rate,nan,1,linear")
    wait_for_picture(page)
    assert axis(page, "y") == ("roll_rate", 3.0, 1.0, "linear")
    go_to(page, BOTH)
    assert axis(page, "x")[1] == 2.7
    go_to(page, "base=x&quantity=y&a=1&range=&with.alpha=&with.nothing=1&time=-1&speed=3")
    assert axis(page, "y") == ("roll_rate", 3.0, 1.0, "linear")
    assert entries(page).keys() == {"base", "x", "y", "quantity"}


@pytest.mark.release
def test_what_makes_no_sense_of_a_motion_is_not_set(opened):
    """If a camera, a part or a loss cannot be read, the motion is shown without it."""
    page = opened(f"{BOTH}&a=2.4,0.02&a.camera=1,2")
    for set_of_it in ("camera=0,0,-1", "loss.nothing=1"):
        go_to(page, f"{BOTH}&a=2.4,0.02&a.{set_of_it}")
        page.locator(SHOWN).wait_for()
        wait_for_picture(page)
        assert fragment_of(page) == f"{BOTH}&a=2.4,0.02", set_of_it
        assert page.locator(".problem").first.text_content() == "", set_of_it
        lossy = page.locator(".motion").first.evaluate("each => each.classList.contains('lossy')")
        assert not lossy, set_of_it


def test_losses_that_are_not_possible_are_told_and_left_out(browser, explorer):
    """If an address's losses leave no motion, the page says so and shows the motion without them."""
    # not watched, because the server's refusal is intended
    context = browser.new_context(reduced_motion="reduce", viewport={"width": 1280, "height": 800})
    page = context.new_page()
    page.goto(f"{explorer.url}#{BOTH}&a=2.4,0.02&a.loss.air_law=fog&a.loss.friction=-1")
    page.wait_for_selector(COMPLETE)
    page.locator(SHOWN).wait_for()
    wait_for_picture(page)
    assert (
        "friction" in page.locator(".problem").inner_text() or "air" in page.locator(".problem").inner_text()
    )
    assert not page.locator(".motion").first.evaluate("each => each.classList.contains('lossy')")
    assert not [name for name in entries(page) if name.startswith("a.")]
    context.close()
