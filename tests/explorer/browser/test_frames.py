"""An exported page in a frame of another page, possibly sandboxed, under that page's policy."""

import html

import pytest
from explorer_browser import COMPLETE, Watch

from sweep.explorer.explorer import subject_of
from sweep.explorer.export import export
from sweep.request.spec import SweepSpec

pytestmark = pytest.mark.slow_lane


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return the path of an exported page."""
    path = tmp_path_factory.mktemp("frames") / "page.html"
    export(subject_of(SweepSpec.preset("rolling"), {}), path)
    return path


@pytest.fixture
def framed(tabs, tmp_path):
    """Return a function that opens a page with a frame with these attributes, and returns tab, frame and watch."""
    options = {"reduced_motion": "reduce", "viewport": {"width": 1280, "height": 860}}
    tab, used = tabs.take(options)

    def open_frame(attributes, policy=""):
        host = tmp_path / "host.html"
        head = f'<meta http-equiv="Content-Security-Policy" content="{policy}" />' if policy else ""
        frame = f'<iframe {attributes} width="1240" height="820"></iframe>'
        host.write_text(f"<!doctype html>{head}<title>A lecture</title>{frame}", encoding="utf-8")
        watch = Watch(tab, ("file:", "about:"))
        tab.goto(host.as_uri())
        return tab, tab.frame_locator("iframe"), watch

    yield open_frame
    tabs.give_back(options, tab, used)


def srcdoc(path):
    """Return the attribute of a frame that contains a page."""
    return f'srcdoc="{html.escape(path.read_text(encoding="utf-8"))}"'


@pytest.mark.parametrize("sandbox", ['sandbox="allow-scripts"', ""])
def test_a_page_works_in_a_frame_without_an_address(framed, exported, sandbox):
    """The page zooms, resets, moves a slider, shows a motion and saves, without hidden errors."""
    tab, frame, watch = framed(f"{sandbox} {srcdoc(exported)}")
    frame.locator(COMPLETE).wait_for()
    box = frame.locator("#map .picture").bounding_box()
    tab.mouse.click(box["x"] + 0.7 * box["width"], box["y"] + 0.6 * box["height"])
    tab.mouse.wheel(0, -400)
    # the address is written after a pause
    tab.wait_for_timeout(300)
    frame.locator("#whole").click()
    frame.locator("#slide-alpha").fill("900")
    frame.locator("#theme").click()
    tab.wait_for_timeout(300)
    frame.locator(COMPLETE).wait_for()
    frame.locator("#motions .motion.shown:not(.waiting)").first.wait_for()
    # its address cannot be opened
    assert frame.locator("details.menu summary", has_text="Copy").count() == 0
    frame.locator("details.menu summary", has_text="Save").click()
    frame.get_by_role("button", name="PNG").click()
    frame.locator("#notice").filter(has_text="allow-downloads").wait_for()
    assert watch.problems == []


def test_a_page_in_a_sandbox_with_an_address_keeps_its_state_there(framed, exported):
    """Its frame has its own address with the settings, or the page works without one."""
    tab, frame, watch = framed(f'sandbox="allow-scripts" src="{exported.as_uri()}#theme=dark"')
    frame.locator(COMPLETE).wait_for()
    frame.locator("#slide-alpha").fill("900")
    tab.wait_for_timeout(300)
    frame.locator(COMPLETE).wait_for()
    assert frame.locator("html").get_attribute("data-theme") == "dark"
    assert frame.locator("details.menu summary", has_text="Copy").count() == 1
    assert watch.problems == []


@pytest.mark.parametrize(
    ("policy", "refused"),
    [
        ("script-src 'unsafe-inline' 'wasm-unsafe-eval' data:; worker-src 'none'", "workers"),
        ("script-src 'unsafe-inline' data:; worker-src blob:", "WebAssembly"),
    ],
)
def test_a_page_says_what_the_page_around_it_forbids(framed, exported, policy, refused):
    """Without workers or WebAssembly there is no picture; the notice gives the reason and what to allow."""
    _, frame, _ = framed(srcdoc(exported), policy)
    notice = frame.locator("#notice").filter(has_text="wasm-unsafe-eval")
    notice.wait_for()
    assert refused in notice.inner_text()
    assert "newer browser" not in notice.inner_text()
    assert frame.locator("#map").get_attribute("aria-busy") == "false"
