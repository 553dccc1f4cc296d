"""The watch on a page reports messages, exceptions, and requests that fail or leave the server."""

import pytest
from explorer_browser import Watch

pytestmark = pytest.mark.slow_lane

OWN = "http://127.0.0.1:9/token/"


def problems_of(browser, script):
    """Return the problems of a page that runs a script; the page is served at OWN."""
    context = browser.new_context()
    page = context.new_page()
    page.route(
        "**/*",
        lambda route: (
            route.fulfill(
                body=f"<link rel=icon href=data:,><script>{script}</script>", content_type="text/html"
            )
            if route.request.url == OWN
            else route.fulfill(status=404)
        ),
    )
    watch = Watch(page, (OWN,))
    page.goto(OWN, wait_until="networkidle")
    # unhandled rejections are reported a moment later
    page.wait_for_timeout(50)
    context.close()
    return watch.problems


def test_quiet_page_is_no_problem(browser):
    """A page that does nothing, or cancels its own request, has no problem."""
    assert problems_of(browser, "") == []
    ended = "const c = new AbortController(); fetch('x', {signal: c.signal}).catch(() => 0); c.abort();"
    assert problems_of(browser, ended) == []


def test_messages_and_exceptions_are_problems(browser):
    """A console message, an exception and an unhandled rejection are reported with their text."""
    for script in (
        "console.error('broken')",
        "console.warn('broken')",
        "throw Error('broken')",
        "Promise.reject(Error('broken'))",
    ):
        (problem,) = problems_of(browser, script)
        assert "broken" in problem, script


def test_failed_and_foreign_requests_are_problems(browser):
    """A failed request, and one to a foreign address, are reported with the address."""
    refused = problems_of(browser, "fetch('missing')")
    assert any("404" in problem and f"{OWN}missing" in problem for problem in refused)
    foreign = problems_of(browser, "new Image().src = 'http://127.0.0.1:10/picture.png'")
    assert any("another address: http://127.0.0.1:10/picture.png" in problem for problem in foreign)
