"""Somebody without a plan uses the page: nothing goes wrong, and the picture stays that of its address."""

import random

import explorer_random_use as script
import pytest
from explorer_browser import Watch
from explorer_visitor import ProblemError, Visitor


def test_a_short_random_use_has_no_problem(browser, explorer):
    """A few dozen actions leave no message, no stale picture and no context of WebGL too many."""
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    page, watch = script.new_page(context, explorer.url)
    script.use(page, watch, Visitor(page, random.Random(3)), 30)
    context.close()


def test_a_stale_picture_is_seen(opened):
    """A picture whose address has changed without it is told, with how many pixels differ."""
    page = opened()
    script.look(page)
    page.evaluate("history.replaceState(null, '', '#base=spinning')")
    with pytest.raises(ProblemError, match="pixels differ"):
        script.look(page)


def test_growth_is_seen():
    """Memory that grows from the first third of the measurements to the last is told; what comes and goes is not."""
    steady = {"heap": 5.0, "nodes": 1000.0, "listeners": 100.0, "server": 150.0}
    measured = [{**steady, "heap": 5.0 + (number % 2)} for number in range(10)]
    script.compare_measurements(measured)
    with pytest.raises(ProblemError, match="nodes has grown by"):
        script.compare_measurements([{**steady, "nodes": 1000.0 * number} for number in range(10)])


def test_what_the_watch_notes_ends_the_use(opened):
    """A message in the console ends it at the next action, with its words."""
    page = opened()
    watch = Watch(page, ())
    watch.problems.append("console, error: broken")
    with pytest.raises(ProblemError, match="broken"):
        script.use(page, watch, Visitor(page, random.Random(1)), 1)
