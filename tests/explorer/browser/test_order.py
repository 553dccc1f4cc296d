"""Answers that come in another order than they were asked for: what is shown is what was wanted last."""

import json

from tests.explorer.browser.map_page import BOTH, axis, settled, shown


def test_a_coarse_picture_that_comes_late_is_not_shown(opened):
    """Where the fine picture of the last view is there, the coarse one of a view before it is of no use."""
    page = opened(BOTH)
    held = []

    def hold_the_first_coarse_one(route):
        if not held and json.loads(route.request.post_data)["lane"] == "coarse":
            held.append(route)
        else:
            route.continue_()

    page.route("**/window", hold_the_first_coarse_one)
    page.locator("#slide-alpha").fill("300")
    page.wait_for_timeout(150)
    page.locator("#slide-alpha").fill("700")
    settled(page)
    words = shown(page)["view"]["words"]
    lanes = page.evaluate(
        """() => {
            const lanes = [];
            const map = document.getElementById("map");
            new MutationObserver(() => lanes.push([map.dataset.lane, JSON.parse(map.dataset.shown).view.words]))
                .observe(map, { attributeFilter: ["data-lane", "data-shown"] });
            return (window.lanes = lanes);
        }"""
    )
    assert lanes == []
    (late,) = held
    with page.expect_response("**/window"):
        late.continue_()
    page.wait_for_timeout(500)
    assert {lane for lane, _ in page.evaluate("lanes")} <= {"fine"}
    assert page.locator("#map").get_attribute("data-lane") == "fine"
    assert shown(page)["view"]["words"] == words
    assert axis(page, "x") == ("roll_rate", 2.7, 0.5, "linear")
