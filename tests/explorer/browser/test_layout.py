"""The layout: the initial motion, two motions side by side, and one column on a phone."""

import pytest
from explorer_browser import COMPLETE

from tests.explorer.browser.map_page import BOTH, axis, click, entries, plot, point, wait_for_picture
from tests.explorer.browser.test_motion import SHOWN, clock

pytestmark = pytest.mark.slow_lane


def box(page, selector):
    """Return left, top, right and bottom of an element on the screen."""
    found = page.locator(selector).first.bounding_box()
    return found["x"], found["y"], found["x"] + found["width"], found["y"] + found["height"]


def test_the_page_opens_with_a_motion_that_plays(opened):
    """Without an address, the page plays an unstable start with few digits; another base does, too."""
    page = opened(reduced_motion="no-preference")
    page.locator(SHOWN).first.wait_for()
    assert clock(page)["playing"]
    page.locator(".motion .verdict", has_text="unstable").wait_for()
    page.wait_for_function("() => location.hash.includes('&a=')")
    assert page.locator("#map text.region").all_text_contents() == ["stable", "unstable"]
    first = entries(page)["a"]
    for word in page.locator("#motions header p").first.inner_text().split(", "):
        digits = [each for each in word if each.isdigit()]
        assert len(digits) <= 4, word
    page.locator("#base").select_option("spinning")
    wait_for_picture(page)
    page.locator(SHOWN).first.wait_for()
    assert entries(page)["a"] != first
    # the address decides: without a motion in it, none is shown
    page.get_by_role("button", name="Close A").dispatch_event("click")
    wait_for_picture(page)
    page.reload()
    page.wait_for_selector(COMPLETE)
    page.wait_for_timeout(300)
    assert page.locator(SHOWN).count() == 0


@pytest.mark.parametrize(
    "width",
    [1200, pytest.param(1280, marks=pytest.mark.release), pytest.param(1920, marks=pytest.mark.release)],
)
def test_two_motions_stand_beside_each_other_and_last_as_long(opened, width):
    """From 1200 pixels on, A and B are side by side next to the map and last as long as the longer one."""
    short, long = "0.002,3.2", "0.001,2.6"
    page = opened(f"base=rolling&a={short}", viewport={"width": width, "height": 800})
    page.locator(SHOWN).first.wait_for()
    own = page.locator(".motion .ending").first.inner_text()
    alone = clock(page)["length"]
    page.evaluate("long => { location.hash = location.hash + `&b=${long}&compare=yes` }", long)
    page.locator(SHOWN).nth(1).wait_for()
    both = clock(page)["length"]
    assert both > 1.5 * alone
    endings = page.locator(".motion .ending")
    page.wait_for_function(
        "() => new Set([...document.querySelectorAll('.motion .ending')].map((each) => each.textContent)).size === 1"
    )
    assert endings.first.inner_text() != own
    curves = page.locator(".plot.tilt .curve").evaluate_all("all => all.map((each) => each.getBBox().width)")
    assert curves[0] == pytest.approx(curves[1], abs=1.5)
    a, b = (box(page, f".slot >> nth={number}") for number in (0, 1))
    assert a[1] == b[1]
    assert box(page, "#map")[2] < a[0] < a[2] < b[0]
    assert a[2] - a[0] == pytest.approx(b[2] - b[0], abs=1.0)
    assert a[2] - a[0] > 300
    page.get_by_role("button", name="Close B").click()
    page.wait_for_function("own => document.querySelector('.motion .ending').textContent === own", arg=own)
    assert clock(page)["length"] == alone


@pytest.mark.parametrize("width", [360, pytest.param(768, marks=pytest.mark.release)])
def test_a_tap_leads_to_the_motion_below_the_map(opened, width):
    """In one column, the motion is directly below the map; a tap scrolls to it, a key does not."""
    page = opened(BOTH, viewport={"width": width, "height": 800}, has_touch=True)
    page.locator("#map").focus()
    page.keyboard.press("Enter")
    page.locator(SHOWN).first.wait_for()
    assert page.evaluate("scrollY") == 0
    atlas, slot, numbers = (box(page, each) for each in ("#atlas", ".slot", "#readout"))
    assert 0 < slot[1] - atlas[3] < 24
    assert slot[3] < numbers[1]
    page.touchscreen.tap(*point(page, 0.3, 0.2))
    page.wait_for_function("() => Math.abs(document.querySelector('.slot').getBoundingClientRect().top) < 20")


def test_a_mouse_beside_a_motion_scrolls_nothing(opened):
    """If the motion is next to the map, a click does not scroll the page."""
    page = opened(BOTH)
    click(page, 0.3, 0.2)
    page.locator(SHOWN).first.wait_for()
    assert page.evaluate("scrollY") == 0


@pytest.mark.parametrize("place", ["#map .picture", ".stage canvas"])
def test_a_finger_on_a_picture_scrolls_the_page(opened, place):
    """One finger that moves up over the map or the disk scrolls the page; window and start do not change."""
    page = opened(BOTH + "&a=3.1,0.01", viewport={"width": 360, "height": 740}, has_touch=True)
    page.locator(SHOWN).first.wait_for()
    before = axis(page, "x"), axis(page, "y"), entries(page)["a"]
    if place != "#map .picture":
        page.evaluate("scrollTo(0, 300)")
    left, top, right, bottom = box(page, place)
    from_top, x, y = page.evaluate("scrollY"), (left + right) / 2, (top + bottom) / 2
    session = page.context.new_cdp_session(page)

    def finger(kind, up):
        places = [] if kind == "touchEnd" else [{"x": x, "y": y - up}]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": places})

    finger("touchStart", 0)
    for up in range(10, 201, 10):
        finger("touchMove", up)
        page.wait_for_timeout(16)
    finger("touchEnd", 200)
    page.wait_for_function("from => scrollY > from + 100", arg=from_top)
    wait_for_picture(page)
    assert (axis(page, "x"), axis(page, "y"), entries(page)["a"]) == before


def test_two_fingers_move_the_map(opened):
    """Two fingers that move up together move the map's window, and the page does not scroll."""
    page = opened(BOTH, viewport={"width": 360, "height": 740}, has_touch=True)
    before = axis(page, "y")
    x, y = point(page, 0.0, 0.0)
    session = page.context.new_cdp_session(page)
    for up in (0, *range(5, 101, 5), None):
        kind = "touchStart" if up == 0 else "touchEnd" if up is None else "touchMove"
        ends = [] if up is None else [{"x": x + 40 * side, "y": y - up, "id": side} for side in (0, 1)]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": ends})
        page.wait_for_timeout(16)
    wait_for_picture(page)
    height = plot(page)["height"]
    assert axis(page, "y")[1] == pytest.approx(before[1] - 2 * before[2] * 100 / height, abs=0.1)
    assert axis(page, "y")[2] == pytest.approx(before[2], rel=1e-6)
    assert page.evaluate("scrollY") == 0
