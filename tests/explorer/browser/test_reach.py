"""A page whose server does not answer says what happened and what to do, and continues when it answers."""

import re
from contextlib import ExitStack

import pytest
from explorer_browser import COMPLETE, served

import sweep
from sweep.explorer.explorer import subject_of
from sweep.explorer.export import export
from tests.explorer.browser.map_page import (
    BOTH,
    PATIENCE,
    click,
    entries,
    plot,
    point,
    shown,
    wait_for_picture,
    wait_for_text,
)
from tests.messages import assert_facts

pytestmark = pytest.mark.slow_lane

#: The command that a page suggests when its server has ended.
GONE = "eulerdisk explore"

#: The page's message when another process answers: any text without that command.
REPLACED = re.compile(r"^(?!.*eulerdisk explore).*\S", re.DOTALL)


@pytest.fixture
def unwatched(browser, tabs):
    """Return a function that opens a page of a server whose failures are intended."""
    options = {"reduced_motion": "reduce", "viewport": {"width": 1280, "height": 800}}
    with ExitStack() as stack:

        def open_page(url, load=True):
            if not load:
                # settings made before the page loads stay with its tab
                context = browser.new_context(**options)
                stack.callback(context.close)
                page = context.new_page()
                page.set_default_timeout(PATIENCE)
                return page
            page, used = tabs.take(options)
            stack.callback(tabs.give_back, options, page, used)
            page.goto(f"{url}#{BOTH}")
            page.wait_for_selector(COMPLETE)
            return page

        yield open_page


def test_a_page_says_that_its_server_has_gone(unwatched):
    """After the process has ended, a sentence says so and how to see the same view again, without browser errors."""
    with served() as running:
        page = unwatched(running.url)
        running.process.terminate()
        running.process.wait(timeout=30)
        page.locator("#slide-alpha").fill("900")
        wait_for_text(page, "#notice", GONE)
        page.evaluate("scrollTo(0, 0)")
        click(page, 0.2, 0.2)
        wait_for_text(page, "#motions .problem", GONE)
        notice = page.locator("#notice").text_content()
        assert "eulerdisk explore" in notice
        assert "#" in notice
        assert "Failed to fetch" not in page.locator("body").inner_text()
        page.wait_for_timeout(300)
        assert entries(page)["with.alpha"] == "0.905"


@pytest.mark.release
def test_numbers_come_without_the_server(unwatched, explorer):
    """The page computes windows and numbers by itself, without requests for known words."""
    page = unwatched(explorer.url)
    page.route("**/*", lambda route: route.abort("connectionrefused"))
    page.mouse.move(*point(page, 0.2, 0.2))
    wait_for_text(page, "#readout", "nutation period")
    page.mouse.wheel(0, -400)
    wait_for_picture(page)
    # lines come from the server
    wait_for_text(page, "#notice", GONE)


def test_a_page_goes_on_when_its_server_answers_again(unwatched, explorer):
    """Failed requests are repeated: picture, lines and motions are then those of the page."""
    page = unwatched(explorer.url)
    page.route("**/*", lambda route: route.abort("connectionrefused"))
    page.locator("#slide-alpha").fill("1000")
    wait_for_text(page, "#notice", GONE)
    page.evaluate("scrollTo(0, 0)")
    click(page, 0.2, 0.2)
    wait_for_text(page, "#motions .problem", GONE)
    assert plot(page)["width"] > 100
    page.unroute("**/*")
    page.locator("#notice").filter(has_not_text=GONE).wait_for(state="attached")
    wait_for_picture(page)
    assert shown(page)["view"]["words"] == {"alpha": 1}
    page.wait_for_selector("#motions .motion.shown:not(.waiting)")
    wait_for_text(page, "#readout", "nutation period")
    assert GONE not in page.locator("#motions").inner_text()


def refuse(route):
    """Answer like a server with too many connections."""
    route.fulfill(status=503, json={"error": "The explorer has no room.", "hint": "Close some.", "where": ""})


@pytest.mark.release
def test_a_page_begins_when_its_server_answers(unwatched, explorer):
    """If its first request is not answered, a page says so and starts as soon as it is."""
    page = unwatched(explorer.url, load=False)
    page.route("**/about", lambda route: route.abort("connectionrefused"))
    page.goto(f"{explorer.url}#{BOTH}")
    wait_for_text(page, "#notice", GONE)
    page.unroute("**/about")
    page.wait_for_selector(COMPLETE)
    page.locator("#notice").filter(has_not_text=GONE).wait_for(state="attached")


@pytest.mark.release
def test_a_page_that_is_refused_at_first_can_try_again(unwatched, explorer):
    """If its first request is refused, a page has a button to retry."""
    page = unwatched(explorer.url, load=False)
    page.route("**/about", refuse)
    page.goto(f"{explorer.url}#{BOTH}")
    wait_for_text(page, "#notice", "no room. Close some.")
    page.unroute("**/about")
    # a second click would start a second page
    page.get_by_role("button", name="Try again").dblclick()
    page.wait_for_selector(COMPLETE)
    assert page.locator("#notice").inner_text() == ""
    assert page.locator("#map canvas").count() == 1
    assert page.locator("#base").count() == 1


@pytest.mark.parametrize("part", [pytest.param("main.js", marks=pytest.mark.release), "motion/panel.js"])
def test_a_page_with_a_part_missing_says_so(unwatched, explorer, part):
    """If a file of the page is missing, nothing can run, and text in the page itself says what to do."""
    page = unwatched(explorer.url, load=False)
    page.route(f"**/page/{part}", lambda route: route.abort("connectionrefused"))
    page.add_init_script(
        """const look = () => {
            const notice = document.getElementById("notice");
            if (notice) window.first = notice.innerText;
            else requestAnimationFrame(look);
        };
        look();"""
    )
    page.goto(explorer.url)
    page.wait_for_function("window.first !== undefined")
    assert page.evaluate("first") == ""
    page.get_by_text("reload it").wait_for(state="visible")
    page.unroute(f"**/page/{part}")
    page.reload()
    page.wait_for_selector(COMPLETE)
    assert page.locator("#notice").text_content() == ""


@pytest.mark.release
@pytest.mark.parametrize("what", ["plan", "lines"])
def test_what_was_refused_can_be_asked_for_again(unwatched, explorer, what):
    """If the server cannot answer a plan or lines, the page says so and has a button to retry."""
    page = unwatched(explorer.url)
    page.route(f"**/{what}", refuse)
    page.evaluate("fragment => { location.hash = fragment }", f"{BOTH}&with.alpha=0.6&a=2.4,0.02")
    told = page.locator("#notice")
    told.filter(has_text="no room. Close some.").wait_for()
    # later pictures do not replace it
    page.wait_for_selector("#map[aria-busy=false]")
    page.wait_for_timeout(100)
    page.unroute(f"**/{what}")
    # all at once, because a successful retry removes the other buttons
    page.evaluate("document.querySelectorAll('button.again').forEach(each => each.click())")
    told.filter(has_not_text="no room").wait_for(state="attached")
    wait_for_picture(page)
    page.locator("#motions .motion.shown:not(.waiting)").wait_for()
    page.locator("#motions .motion .verdict").first.filter(has_text=re.compile(r"\w")).wait_for()
    page.locator("#map .lines:not(.stale) .line.measured").wait_for(state="attached")


@pytest.mark.release
def test_lines_that_come_late_take_their_refusal_from_the_page(unwatched, explorer):
    """The refusal of lines disappears once they arrive, whichever picture came before."""
    page = unwatched(explorer.url)
    page.route("**/lines", refuse)
    page.evaluate("fragment => { location.hash = fragment }", f"{BOTH}&with.alpha=0.6")
    wait_for_text(page, "#notice", "no room. Close some.")
    held = []
    page.unroute("**/lines")
    page.route("**/lines", lambda route: held.append(route))
    with page.expect_request("**/lines"):
        page.get_by_role("button", name="Try again").click()
    wait_for_picture(page)
    held[0].continue_()
    page.locator("#map .lines:not(.stale) .line.measured").wait_for(state="attached")
    page.locator("#notice").filter(has_not_text="no room").wait_for(state="attached")


@pytest.mark.release
def test_a_button_that_tries_again_keeps_the_focus(unwatched, explorer):
    """After another refusal the same button stays, without repeated messages; after success the map has the focus."""
    page = unwatched(explorer.url)
    page.route("**/lines", refuse)
    page.evaluate("fragment => { location.hash = fragment }", f"{BOTH}&with.alpha=0.6")
    button = page.locator("#notice button")
    button.wait_for()
    wait_for_picture(page)
    page.evaluate(
        """() => {
            window.changes = 0;
            const watch = new MutationObserver((found) => { window.changes += found.length; });
            watch.observe(document.getElementById("notice"), { childList: true, characterData: true, subtree: true });
        }"""
    )
    button.focus()
    with page.expect_response("**/lines"):
        button.press("Enter")
    wait_for_picture(page)
    assert button.evaluate("each => each === document.activeElement")
    assert page.evaluate("changes") == 0
    page.unroute("**/lines")
    button.press("Enter")
    page.locator("#notice").filter(has_not_text="no room").wait_for(state="attached")
    assert page.evaluate("document.activeElement.id") == "map"


@pytest.mark.parametrize("fault", ["damaged", pytest.param("old browser", marks=pytest.mark.release)])
def test_an_exported_page_that_cannot_be_read_says_so(unwatched, tmp_path, fault):
    """Problems with a page's cells, or with the browser, are in its notice and in the console."""
    path = tmp_path / "page.html"
    words = {"roll_rate": "2.3:3.1:4", "tilt": "0.2deg:4deg:3:log"}
    export(subject_of(sweep.run("rolling", method="exact", progress=False, **words), {}), path)
    page = unwatched(path.as_uri(), load=False)
    thrown = []
    page.on("pageerror", lambda problem: thrown.append(problem.message))
    if fault == "damaged":
        text = path.read_text(encoding="utf-8")
        path.write_text(re.sub(r'("data": ?")\w{8}', r"\1AAAAAAAA", text), encoding="utf-8")
    else:
        page.add_init_script("delete window.DecompressionStream")
    page.goto(path.as_uri())
    wait_for_text(page, "#notice", re.compile(r"\S"))
    notice = page.locator("#notice").inner_text()
    assert ("DecompressionStream" in notice) == (fault == "old browser")
    assert_facts(notice, "export")
    assert len(thrown) == 1


@pytest.mark.release
def test_a_new_server_is_told_to_a_page_that_has_not_begun(unwatched, explorer):
    """A page whose first request was lost says that a new process answers, and does not continue by itself."""
    page = unwatched(explorer.url, load=False)
    page.route("**/about", lambda route: route.abort("connectionrefused"))
    page.goto(f"{explorer.url}#{BOTH}")
    wait_for_text(page, "#notice", GONE)
    page.unroute("**/about")
    page.route(
        "**/about", lambda route: route.fulfill(status=403, json={"error": "no", "hint": "", "where": ""})
    )
    wait_for_text(page, "#notice", REPLACED)


@pytest.mark.release
def test_words_that_were_refused_are_asked_for_again(unwatched, explorer):
    """A failed explanation is reported and requested again when it is reopened."""
    page = unwatched(explorer.url)
    page.route("**/explain", refuse)
    page.evaluate("fragment => { location.hash = fragment }", f"{BOTH}&a=2.4,0.02&a.open=words")
    wait_for_text(page, ".explanation", "no room")
    page.unroute("**/explain")
    for _ in range(2):
        page.locator("details.words summary").first.click()
    wait_for_text(page, ".explanation", "because")


def test_a_new_server_at_the_old_address_is_told(unwatched, explorer):
    """A restarted process refuses the old token, and the page says which address to open."""
    page = unwatched(explorer.url)
    page.route("**/plan", lambda route: route.abort("connectionrefused"))
    page.route(
        "**/about", lambda route: route.fulfill(status=403, json={"error": "no", "hint": "", "where": ""})
    )
    page.locator("#slide-alpha").fill("1000")
    wait_for_text(page, "#notice", REPLACED)
