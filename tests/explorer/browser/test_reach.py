"""A page whose server does not answer says what has happened and what to do, and goes on when it answers again."""

import pytest
from explorer_browser import COMPLETE, served

from tests.explorer.browser.map_page import BOTH, click, entries, plot, point, settled, shown, wait_for_text

GONE = "The explorer does not answer"


@pytest.fixture
def unwatched(browser):
    """Return a function that opens a page of a server whose failures are meant."""
    context = browser.new_context(reduced_motion="reduce", viewport={"width": 1280, "height": 800})

    def open_page(url):
        page = context.new_page()
        page.set_default_timeout(20_000)
        page.goto(f"{url}#{BOTH}")
        page.wait_for_selector(COMPLETE)
        page.evaluate("import('eulerdisk/motion/panel').then(() => null)")
        return page

    yield open_page
    context.close()


def test_a_page_says_that_its_server_has_gone(unwatched):
    """After the process has ended a sentence says so, and how to see the same view again; no browser's words do."""
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


def test_numbers_that_do_not_come_say_that_the_server_has_gone(unwatched, explorer):
    """Where only the numbers of a start were asked for, the notice says it too; they come when it answers again."""
    page = unwatched(explorer.url)
    page.route("**/*", lambda route: route.abort("connectionrefused"))
    page.mouse.move(*point(page, 0.2, 0.2))
    wait_for_text(page, "#notice", GONE)
    assert "nutation period" not in page.locator("#readout").inner_text()
    page.unroute("**/*")
    wait_for_text(page, "#readout", "nutation period")


def test_a_page_goes_on_when_its_server_answers_again(unwatched, explorer):
    """What was asked for in vain is asked for again: the picture, the lines and the motions are those of the page."""
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
    settled(page)
    assert shown(page)["view"]["words"] == {"alpha": 1}
    page.wait_for_selector("#motions .motion.shown:not(.waiting)")
    wait_for_text(page, "#readout", "nutation period")
    assert GONE not in page.locator("#motions").inner_text()


def test_a_new_server_at_the_old_address_is_told(unwatched, explorer):
    """A process that was started anew lets nobody in with the old token: the page says whose address to open."""
    page = unwatched(explorer.url)
    page.route("**/window", lambda route: route.abort("connectionrefused"))
    page.route(
        "**/about", lambda route: route.fulfill(status=403, json={"error": "no", "hint": "", "where": ""})
    )
    page.locator("#slide-alpha").fill("1000")
    wait_for_text(page, "#notice", "started anew")
