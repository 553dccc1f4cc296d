"""Answers that come in another order than they were asked for: what is shown is what was wanted last."""

import json

from tests.explorer.browser.map_page import BOTH, axis, click, shown, wait_for_picture

#: Begin to note lane and words of each picture that is shown, in `lanes`.
RECORD = """() => {
    const lanes = [];
    const map = document.getElementById("map");
    new MutationObserver(() => lanes.push([map.dataset.lane, JSON.parse(map.dataset.shown).view.words]))
        .observe(map, { attributeFilter: ["data-lane", "data-shown"] });
    return (window.lanes = lanes);
}"""


def lane_of(route):
    """Return whether a window is asked for as a preview, which has few pixels."""
    asked = json.loads(route.request.post_data)
    return "coarse" if asked["width"] * asked["height"] <= 256 * 192 else "fine"


def test_a_coarse_picture_that_comes_late_is_not_shown(opened):
    """Where the fine picture of the last view is there, the coarse one of a view before it is of no use."""
    page = opened(BOTH)
    held = []

    def hold_the_first_coarse_one(route):
        if not held and lane_of(route) == "coarse":
            held.append(route)
        else:
            route.continue_()

    page.route("**/window", hold_the_first_coarse_one)
    page.locator("#slide-alpha").fill("300")
    page.wait_for_timeout(150)
    page.locator("#slide-alpha").fill("700")
    wait_for_picture(page)
    words = shown(page)["view"]["words"]
    assert page.evaluate(RECORD) == []
    (late,) = held
    with page.expect_response("**/window"):
        late.continue_()
    page.wait_for_timeout(500)
    assert {lane for lane, _ in page.evaluate("lanes")} <= {"fine"}
    assert page.locator("#map").get_attribute("data-lane") == "fine"
    assert shown(page)["view"]["words"] == words
    assert axis(page, "x") == ("roll_rate", 2.7, 0.5, "linear")


def test_a_coarse_picture_does_not_take_the_place_of_the_fine_one_of_its_view(opened):
    """Also where another view is wanted by then, whose own fine picture takes long."""
    page = opened(BOTH)
    held, fine_ones_wait = {"coarse": [], "fine": []}, False

    def hold_the_first_coarse_one_and_fine_ones_after_it(route):
        lane = lane_of(route)
        if fine_ones_wait if lane == "fine" else not held["coarse"]:
            held[lane].append(route)
        else:
            route.continue_()

    page.route("**/window", hold_the_first_coarse_one_and_fine_ones_after_it)
    page.locator("#slide-alpha").fill("300")
    wait_for_picture(page)
    first = shown(page)["view"]["words"]
    (late,) = held["coarse"]
    fine_ones_wait = True
    page.locator("#slide-alpha").fill("700")
    while not held["fine"]:
        page.wait_for_timeout(20)
    assert page.evaluate(RECORD) == []
    with page.expect_response("**/window"):
        late.continue_()
    page.wait_for_timeout(500)
    assert ["coarse", first] not in page.evaluate("lanes")
    fine_ones_wait = False
    for route in held["fine"]:
        route.continue_()
    wait_for_picture(page)
    assert shown(page)["view"]["words"] != first


def test_words_of_a_refused_motion_do_not_stand_beside_another_one(opened):
    """Losses of an address leave no motion: what that says is forgotten where another start is chosen meanwhile."""
    page = opened(BOTH)
    asked = []

    def answer(route):
        asked.append(route)
        if len(asked) == 1:
            # as a start without a motion is answered
            route.fulfill(json={"error": "OLD WORDS", "hint": "", "where": "friction"})

    def wait_for(count):
        while len(asked) < count:
            page.wait_for_timeout(50)
        return json.loads(asked[-1].request.post_data)

    page.route("**/motion", answer)
    page.evaluate("fragment => { location.hash = fragment }", f"{BOTH}&a=2.4,0.02&a.loss.friction=0.1")
    # it is asked for once more, without the losses, and the answer to that takes long
    assert wait_for(2)["losses"] == {}
    assert json.loads(asked[0].request.post_data)["losses"] == {"friction": 0.1}
    click(page, 0.3, 0.2)
    assert wait_for(3)["x"] != 2.4
    page.wait_for_timeout(200)
    assert page.locator(".motion .problem").first.text_content() == ""
    assert page.locator(".motion.waiting").count() == 1
    asked[-1].continue_()
    page.locator(".motion.shown:not(.waiting)").wait_for()
    assert page.locator(".motion .problem").first.text_content() == ""


def test_two_pages_of_one_server_do_not_take_each_other_s_pictures(opened):
    """What one page asks for drops nothing that another one waits for."""
    pages = [opened(BOTH), opened("base=spinning")]
    for turn in range(4):
        for number, page in enumerate(pages):
            page.evaluate(
                "fragment => { location.hash = fragment; }",
                f"base={('rolling', 'spinning')[number]}&quantity=nutation_period&with.alpha={0.5 + turn / 10}",
            )
            # both ask at the same time
            page.wait_for_timeout(40)
    for number, page in enumerate(pages):
        wait_for_picture(page)
        view = shown(page)["view"]
        assert (view["base"], view["words"]) == (("rolling", "spinning")[number], {"alpha": 0.8})
        assert page.locator("#notice").inner_text() == ""
