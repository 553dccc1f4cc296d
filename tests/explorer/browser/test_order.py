"""Answers may arrive out of order: the page shows the last request."""

import pytest

from tests.explorer.browser.holding import HOLD, wait_for_held
from tests.explorer.browser.map_page import BOTH, axis, click, shown, wait_for_picture

pytestmark = pytest.mark.slow_lane

#: Start to record lane and words of each shown picture in `lanes`.
RECORD = """() => {
    const lanes = [];
    const map = document.getElementById("map");
    new MutationObserver(() => lanes.push([map.dataset.lane, JSON.parse(map.dataset.shown).view.words]))
        .observe(map, { attributeFilter: ["data-lane", "data-shown"] });
    return (window.lanes = lanes);
}"""


def test_a_coarse_picture_that_comes_late_is_not_shown(opened):
    """Once the fine picture of the last view is shown, a late coarse picture of an earlier view is dropped."""
    page = opened(BOTH)
    held = []

    def hold_the_first(route):
        if held:
            route.continue_()
        else:
            held.append(route)

    page.route("**/plan", hold_the_first)
    page.locator("#slide-alpha").fill("300")
    page.wait_for_timeout(150)
    page.locator("#slide-alpha").fill("700")
    wait_for_picture(page)
    words = shown(page)["view"]["words"]
    assert page.evaluate(RECORD) == []
    (late,) = held
    with page.expect_response("**/plan"):
        late.continue_()
    page.wait_for_timeout(500)
    assert {lane for lane, _ in page.evaluate("lanes")} <= {"fine"}
    assert page.locator("#map").get_attribute("data-lane") == "fine"
    assert shown(page)["view"]["words"] == words
    assert axis(page, "x") == ("roll_rate", 2.7, 0.5, "linear")


@pytest.mark.release
def test_words_of_a_refused_motion_do_not_stand_beside_another_one(opened):
    """If an address's losses leave no motion, their message disappears when another start is chosen."""
    page = opened(BOTH)
    page.evaluate(HOLD, "call")
    page.evaluate("fragment => { location.hash = fragment }", f"{BOTH}&a=2.4,0.02&a.loss.rolling_friction=5")
    # it is requested again without the losses, and that answer takes long
    wait_for_held(page, 1)
    click(page, 0.3, 0.2)
    wait_for_held(page, 2)
    page.wait_for_timeout(200)
    assert page.locator(".motion .problem").first.text_content() == ""
    assert page.locator(".motion.waiting").count() == 1
    page.evaluate("letGo()")
    page.locator(".motion.shown:not(.waiting)").wait_for()
    assert page.locator(".motion .problem").first.text_content() == ""
    assert "a.loss" not in page.url


@pytest.mark.release
def test_two_pages_of_one_server_do_not_take_each_other_s_pictures(opened):
    """Requests of one page do not cancel those of another."""
    pages = [opened(BOTH), opened("base=spinning")]
    for turn in range(4):
        for number, page in enumerate(pages):
            page.evaluate(
                "fragment => { location.hash = fragment; }",
                f"base={('rolling', 'spinning')[number]}&quantity=nutation_period&with.alpha={0.5 + turn / 10}",
            )
            # both send requests at the same time
            page.wait_for_timeout(40)
    for number, page in enumerate(pages):
        # a busy machine reacts late to an address
        page.wait_for_selector("#map[data-shown*='0.8']", state="attached")
        wait_for_picture(page)
        view = shown(page)["view"]
        assert (view["base"], view["words"]) == (("rolling", "spinning")[number], {"alpha": 0.8})
        assert page.locator("#notice").inner_text() == ""
