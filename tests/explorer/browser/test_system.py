"""The page of a user's system in a real browser: the notice while its kernel compiles, and a start's motion."""

import re

import pytest
from explorer_browser import Watch

from tests.explorer.browser.map_page import PATIENCE, click

pytestmark = pytest.mark.slow_lane


@pytest.fixture
def page(browser):
    """Return a tab that has not started to load."""
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    yield page
    context.close()


def test_a_page_that_waits_for_its_kernel_says_so(page, served_with):
    """Until the first picture of a system, a notice says that its kernel is compiled."""
    waiting, of_kernel, is_held = [], re.compile("kernel"), True

    def hold(route):
        if is_held:
            waiting.append(route)
        else:
            route.continue_()

    for path in ("kernels.wasm", "cells"):
        page.route(f"**/{path}", hold)
    page.goto(served_with("thomas").url)
    page.locator("#notice").filter(has_text=of_kernel).wait_for()
    assert page.locator("#map[data-shown]").count() == 0
    is_held = False
    for route in waiting:
        route.continue_()
    page.locator("#map[data-shown]").wait_for()
    page.locator("#notice").filter(has_not_text=of_kernel).wait_for(state="attached")


def test_a_click_shows_the_motion_of_a_start(page, served_with):
    """Each state is plotted over time, and the first two in a plane; the slider moves all cursors."""
    address = served_with("thomas").url
    watch = Watch(page, (address,))
    page.goto(address)
    page.locator("#map[data-shown]").wait_for()
    click(page, 0.3, 0.2)
    motion = page.locator(".motion.system.shown:not(.waiting)")
    motion.wait_for()
    names = motion.locator(".plot").evaluate_all("all => all.map((each) => each.className)")
    assert names == ["plot state-x", "plot state-y", "plot state-z", "plot plane"]
    assert not motion.locator(".stage").is_visible()
    assert not motion.get_by_role("button", name="play").is_visible()
    before = cursors(motion)
    motion.locator("input.time").fill("400")
    after = cursors(motion)
    assert len(before) == len(after) == 4
    # a cursor must move by more than a pixel
    assert all(abs(a - b) > 1.0 for a, b in zip(before[:3], after[:3], strict=True))
    assert before[3] != after[3]
    assert watch.problems == []


def cursors(motion):
    """Return the position of each plot's cursor along its first axis [pixels]."""
    return motion.locator(".plot").evaluate_all(
        """all => all.map((each) => {
            const { x } = each.querySelector(".cursor").getBoundingClientRect();
            return x - each.getBoundingClientRect().x;
        })"""
    )
