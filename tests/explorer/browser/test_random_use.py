"""Random use of the page causes no problem, and the picture always belongs to its address."""

import random

import explorer_random_use as script
import pytest
from explorer_browser import Watch
from explorer_memory import GROWTH, LeakError, Memory
from explorer_visitor import ProblemError, Visitor

pytestmark = pytest.mark.slow_lane

#: Leaks objects: 100 motions as objects and as buffers, elements with listeners, a page, textures.
LEAK = """async () => {
  const elements = Array.from({ length: 2000 }, () => document.createElement("p"));
  for (const each of elements.slice(0, 300)) each.addEventListener("click", () => each.remove());
  const objects = Array.from({ length: 100000 }, (_, i) => ({ number: i + 0.5, name: `${i}` }));
  const buffers = Array.from({ length: 100 }, () => new Float64Array(20000).fill(1));
  const pages = Array.from({ length: 20 }, () => document.implementation.createHTMLDocument(""));
  const context = window.contextsOfWebGL[0].deref();
  const textures = Array.from({ length: 40 }, () => context.createTexture());
  window.leak = { elements, objects, buffers, pages, textures };
}"""


@pytest.mark.release
def test_a_short_random_use_has_no_problem(browser, explorer):
    """A dozen actions leave no message, stale picture or WebGL context; then leaked objects are measured."""
    context = browser.new_context(viewport=script.SIZE, reduced_motion="reduce")
    page, watch = script.new_page(context, explorer.url)
    script.use(page, watch, Visitor(page, random.Random(3)), 12)
    memory = Memory(page, context.new_cdp_session(page), explorer)
    before = script.measure(page, watch, memory, 0)
    empty = memory.graphics()
    # with tables, disks, arrows and paths of two motions, and almost nothing without them
    assert before["graphics"] > 100.0 > 4.0 * empty
    page.evaluate(LEAK)
    after = memory.take(0, memory.graphics())
    page.evaluate("leak.more = document.createElement('canvas').getContext('webgl2')")
    with pytest.raises(LeakError, match="contexts: 3, at most 2"):
        memory.take(0, 0.0)
    context.close()
    grown = {name: after[name] - before[name] for name in before}
    assert grown["heap"] > 4.0
    # 16 MB were allocated; others may have been freed
    assert grown["buffers"] > 15.5
    assert grown["nodes"] >= 2000.0
    assert grown["listeners"] >= 300.0
    assert grown["documents"] >= 20.0
    assert after["graphics"] == empty + 40.0


def test_a_stale_picture_is_seen(opened):
    """A picture that does not belong to its address is reported with the number of differing pixels."""
    page = opened()
    watch = Watch(page, (page.url,))
    script.look(page, watch)
    page.evaluate("history.replaceState(null, '', '#base=spinning')")
    with pytest.raises(ProblemError, match="pixels differ"):
        script.look(page, watch)


@pytest.mark.release
def test_a_picture_that_nobody_computes_is_told_from_one_that_takes_long(opened, monkeypatch, capsys):
    """A page that waits for nothing is a problem; while a plan is pending, the wait continues and is reported."""
    page = opened()
    watch = Watch(page, (page.url,))
    monkeypatch.setattr(script, "PATIENCE", 300)
    page.evaluate("document.querySelector('#map').setAttribute('aria-busy', 'true')")
    with pytest.raises(ProblemError, match="no plan is under way"):
        script.settle(page, watch)
    held, ordinary = [], watch.waits_for

    def answered_then():
        """Return the pending requests and let the server answer."""
        found = ordinary()
        for route in held:
            route.continue_()
        return found

    monkeypatch.setattr(watch, "waits_for", answered_then)
    page.route("**/plan", lambda route: held.append(route))
    page.locator("#slide-alpha").fill("300")
    script.settle(page, watch)
    told = capsys.readouterr().err
    assert "after 0.3 s: the page waits for" in told
    assert ' plan {"view"' in told
    assert "it was complete after" in told
    monkeypatch.setattr(watch, "waits_for", ordinary)
    page.locator("#slide-alpha").fill("500")
    monkeypatch.setattr(script, "BUSY", 300)
    with pytest.raises(ProblemError, match=r'(?s)after 0.6 s; lane fine, busy true.* plan {"view"'):
        script.settle(page, watch)


STEADY = dict.fromkeys(GROWTH, 100.0)


def memory_of(values, apart=50):
    """Return the measurements of a page with this many actions between them."""
    memory = object.__new__(Memory)
    memory.measured = [(apart * number, {**STEADY, **value}) for number, value in enumerate(values)]
    return memory


@pytest.mark.parametrize("name", GROWTH)
def test_growth_is_seen(name):
    """A growth slightly above the limit is reported by name, and one below it is not."""
    limit = GROWTH[name][1] / 1000.0
    memory_of({name: 40.0 + 0.9 * limit * 50 * number} for number in range(40)).check()
    with pytest.raises(LeakError, match=f"^{name} grows by"):
        memory_of({name: 40.0 + 1.1 * limit * 50 * number} for number in range(40)).check()
    # of 260 actions, only the last 180 count for the trend
    growing = [{name: 40.0 + 3.0 * limit * 20 * number} for number in range(14)]
    memory_of(growing, apart=20).check()
    growing = [{name: 40.0 + 6.0 * limit * 20 * number} for number in range(14)]
    with pytest.raises(LeakError, match=f"^{name} grows by"):
        memory_of(growing, apart=20).check()


def test_what_fills_at_first_or_comes_and_goes_is_no_growth():
    """Caches that fill and single peaks are not leaks; too few measurements give no trend."""
    memory_of({"heap": min(5.0 + number, 9.0)} for number in range(12)).check()
    memory_of({"server": 300.0 if number < 8 else 430.0} for number in range(12)).check()
    memory_of({"heap": 50.0 if number == 10 else 5.0} for number in range(12)).check()
    assert memory_of({"heap": 5.0 + number} for number in range(4)).growth() == {}


def test_what_the_watch_notes_ends_the_use(opened):
    """A console message ends the use at the next action, with its text."""
    page = opened()
    watch = Watch(page, ())
    watch.problems.append("console, error: broken")
    with pytest.raises(ProblemError, match="broken"):
        script.use(page, watch, Visitor(page, random.Random(1)), 1)
