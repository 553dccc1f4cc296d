"""The page is accessible: axe-core finds nothing serious, in light and dark, in any state of the page."""

import os
from pathlib import Path

import pytest
from explorer_browser import MAP

pytestmark = pytest.mark.slow_lane

AXE = Path(__file__).parents[3] / "scripts" / "javascript" / "node_modules" / "axe-core" / "axe.min.js"

#: Rules of WCAG 2.2 up to AA, and axe-core's best practices.
TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]

RUN = "tags => axe.run(document, { runOnly: tags, resultTypes: ['violations', 'incomplete'] })"


@pytest.fixture(scope="module")
def axe():
    """Return the source of axe-core from the tools for checking the page."""
    if not AXE.is_file():
        message = "no axe-core: scripts/javascript/check fetches it"
        pytest.fail(message) if os.environ.get("CI") == "true" else pytest.skip(message)
    return AXE.read_text(encoding="utf-8")


def findings(page, axe):
    """Return axe-core's serious and critical findings with their elements."""
    page.evaluate(axe)
    found = page.evaluate(RUN, TAGS)["violations"]
    return [
        f"{each['impact']}: {each['id']}: {each['help']}: {node['html'][:200]} {node['failureSummary'][:300]}"
        for each in found
        if each["impact"] in ("serious", "critical")
        for node in each["nodes"]
    ]


def choose(page, across, up):
    """Click a place of the map, given as shares of its width and height."""
    box = page.locator(MAP).bounding_box()
    page.mouse.click(box["x"] + across * box["width"], box["y"] + (1 - up) * box["height"])


@pytest.mark.parametrize("light", ["light", pytest.param("dark", marks=pytest.mark.release)])
def test_map_has_no_serious_finding(opened, axe, light):
    """The initial map with its controls has no serious finding."""
    page = opened(color_scheme=light)
    assert findings(page, axe) == []


@pytest.mark.parametrize("light", [pytest.param("light", marks=pytest.mark.release), "dark"])
def test_motions_have_no_serious_finding(opened, axe, light):
    """Two chosen and compared points with their motions have no serious finding."""
    page = opened(color_scheme=light)
    choose(page, 0.4, 0.5)
    page.wait_for_selector("#motions canvas >> nth=0")
    page.keyboard.down("Shift")
    choose(page, 0.7, 0.6)
    page.keyboard.up("Shift")
    page.wait_for_selector("#motions canvas >> nth=1")
    assert findings(page, axe) == []


def test_phone_has_no_serious_finding(opened, axe):
    """On the width of a phone, the small touch targets are acceptable."""
    page = opened(viewport={"width": 360, "height": 740})
    assert findings(page, axe) == []


def test_finding_would_be_seen(opened, axe):
    """An unreadable element is found, so the check does not pass because it checks nothing."""
    page = opened()
    page.evaluate("document.body.append(Object.assign(document.createElement('img'), { src: 'data:,' }))")
    assert any("image-alt" in each for each in findings(page, axe))
