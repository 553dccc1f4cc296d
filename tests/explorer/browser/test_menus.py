"""Menus close as people expect, and copying works even without access to the clipboard."""

import re
from itertools import pairwise

import pytest

from tests.explorer.browser.map_page import BOTH, plot, wait_for_picture, wait_for_text

pytestmark = pytest.mark.slow_lane

#: Titles of the open menus, and the text of the focused element.
OPEN = "[...document.querySelectorAll('details.menu[open] > summary')].map((each) => each.textContent)"
FOCUSED = "document.activeElement.closest('summary, button')?.textContent ?? document.activeElement.id"

#: A browser without a clipboard, and one that refuses it, as in a frame.
WITHOUT = "Object.defineProperty(Navigator.prototype, 'clipboard', { get: () => undefined });"
REFUSED = "navigator.clipboard.writeText = () => Promise.reject(new DOMException('no', 'NotAllowedError'));"
NO_COPY = "document.execCommand = () => false;"


def choose(page, words):
    """Choose from the copy menu."""
    page.get_by_text("Copy", exact=True).click()
    page.get_by_role("button", name=words).click()


def test_menus_close_and_the_focus_is_where_it_was(opened):
    """Escape, a click elsewhere, Tab past the end and a choice close a menu without losing the focus."""
    page = opened(BOTH)
    page.context.grant_permissions(["clipboard-write"])
    copy, keys = page.locator("summary", has_text="Copy"), page.keyboard
    copy.focus()
    keys.press("Enter")
    keys.press("Tab")
    assert page.evaluate(OPEN) == ["Copy"]
    assert page.evaluate(FOCUSED) == "address of this view"
    keys.press("Escape")
    assert (page.evaluate(OPEN), page.evaluate(FOCUSED)) == ([], "Copy")
    keys.press("Enter")
    for _ in range(3):
        keys.press("Tab")
    assert page.evaluate(OPEN) == ["Copy"]
    keys.press("Tab")
    assert (page.evaluate(OPEN), page.evaluate(FOCUSED)) == ([], "Save")
    keys.press("Enter")
    assert page.evaluate(OPEN) == ["Save"]
    copy.click()
    assert page.evaluate(OPEN) == ["Copy"]
    # a browser that does not focus clicked buttons
    page.evaluate("document.activeElement.blur()")
    keys.press("Escape")
    assert (page.evaluate(OPEN), page.evaluate(FOCUSED)) == ([], "Copy")
    copy.click()
    box = plot(page)
    page.mouse.click(box["x"] + 20, box["y"] + 20)
    assert (page.evaluate(OPEN), page.evaluate(FOCUSED)) == ([], "map")
    copy.focus()
    keys.press("Enter")
    keys.press("Tab")
    keys.press("Enter")
    wait_for_text(page, "#notice", re.compile(r"\S"))
    assert (page.evaluate(OPEN), page.evaluate(FOCUSED)) == ([], "Copy")


def test_keys_go_through_the_page_as_it_is_seen(opened):
    """On a phone, Tab reaches the motion, which is above the sliders, first."""
    page = opened(BOTH + "&a=2.4,0.02", viewport={"width": 360, "height": 740})
    page.locator("#motions .motion.shown").wait_for()
    page.locator("#map").focus()
    place = """() => {
        const { top } = document.activeElement.getBoundingClientRect();
        return [document.activeElement.closest("#bar, #motions, #controls")?.id, top + scrollY];
    }"""
    places = []
    while not places or page.evaluate("document.activeElement.id") != "log-y":
        page.keyboard.press("Tab")
        places.append(page.evaluate(place))
        assert len(places) < 50
    assert list(dict.fromkeys(part for part, _ in places)) == ["bar", "motions", "controls"]
    # elements of one row have almost the same height
    assert all(below > above - 40 for (_, above), (_, below) in pairwise(places))


@pytest.mark.parametrize("clipboard", [pytest.param(WITHOUT, marks=pytest.mark.release), REFUSED])
def test_a_text_is_copied_without_the_clipboard_of_the_page(opened, clipboard):
    """If `navigator.clipboard` is missing or refuses, the text is copied by selecting it."""
    page = opened(BOTH)
    page.context.grant_permissions(["clipboard-read"])
    page.evaluate(f"{clipboard} null")
    choose(page, "window as Python")
    wait_for_text(page, "#notice", re.compile(r"\S"))
    assert page.locator("dialog").count() == 0
    assert page.evaluate(FOCUSED) == "Copy"
    reader = page.context.new_page()
    reader.goto(page.url)
    text = reader.evaluate("navigator.clipboard.readText()")
    assert text.startswith("import sweep\n\natlas = sweep.run('rolling', ")


def test_a_text_that_cannot_be_copied_is_shown(opened):
    """If that fails, the text is shown by line and selected; Escape or a button closes it and restores the focus."""
    page = opened(BOTH)
    wait_for_picture(page)
    page.evaluate(REFUSED + NO_COPY)
    choose(page, "window as Python")
    area = page.get_by_role("dialog").get_by_role("textbox")
    area.wait_for()
    lines = area.input_value().splitlines()
    assert (lines[0], lines[-1]) == ("import sweep", "atlas.eulerdisk.plot()")
    assert area.evaluate("each => each.value.slice(each.selectionStart, each.selectionEnd) === each.value")
    assert "Copied." not in page.inner_text("#notice")
    page.keyboard.press("Escape")
    area.wait_for(state="detached")
    assert page.evaluate(FOCUSED) == "Copy"
    choose(page, "address of this view")
    assert page.get_by_role("dialog").get_by_role("textbox").input_value() == page.url
    page.get_by_role("button", name="Close", exact=True).click()
    area.wait_for(state="detached")
    assert page.evaluate(FOCUSED) == "Copy"
