"""A visitor who uses the explorer's page at random, in every possible way, by real events of a browser."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from explorer_browser import MAP

if TYPE_CHECKING:
    from playwright.sync_api import ElementHandle, Page

#: Sizes of windows, from a phone's to a large screen's.
SIZES = ((360, 740), (768, 1024), (1280, 800), (1600, 900))

KEYS = (
    "ArrowLeft",
    "ArrowRight",
    "ArrowUp",
    "ArrowDown",
    "+",
    "-",
    "Enter",
    "Escape",
    "Tab",
    "Home",
    "Shift+Enter",
)

TEXTS = ("0.5", "1e-3", "-7", "0", "abc", "", "1e400", "45 deg", "0,5", "departure:10deg", "<b>")

FRAGMENTS = (
    "",
    "base=spinning",
    "base=circling",
    "base=nowhere&x=&y=1",
    "x=roll_rate,3,1e-9,linear",
    "a=3,0.02&b=2,0.02",
    "a=3,0.02&a.loss.rolling_friction=1e-3&a.open=laws,words&a.camera=1,0.5,4&compare=yes",
)


class ProblemError(Exception):
    """Something happened that must not; the text says what."""


@dataclass
class Visitor:
    """A visitor who uses the page at random.

    Parameters
    ----------
    page : Page
        The page with the open explorer.
    chance : random.Random
        Source of all random decisions.
    """

    page: Page
    chance: random.Random
    visited: list[str] = field(default_factory=list)
    held: list[ElementHandle] = field(default_factory=list)
    done: deque[str] = field(default_factory=lambda: deque(maxlen=24))

    def act(self) -> None:
        """Perform one action."""
        from playwright.sync_api import Error as BrowserError

        (name,) = self.chance.choices(list(ACTIONS), [weight for weight, _ in ACTIONS.values()])
        self.done.append(name)
        try:
            ACTIONS[name][1](self)
        except BrowserError as problem:
            # the page may replace a control after it was found and before it is used
            if "not attached" not in problem.message:
                raise
            self.note("that is gone")
        finally:
            # release element handles here, otherwise they would not be collected in the page
            for each in self.held:
                each.dispose()
            self.held.clear()

    def note(self, what: object) -> None:
        """Append details to the description of the last action."""
        self.done[-1] += f" {what}"

    def place(self) -> tuple[float, float]:
        """Return a random place on the map, in screen pixels."""
        self.page.evaluate("window.scrollTo(0, 0)")
        box = self.page.locator(MAP).bounding_box()
        if box is None:
            raise ProblemError("the map is not shown")
        return (
            box["x"] + self.chance.uniform(0.1, 0.9) * box["width"],
            box["y"] + self.chance.uniform(0.1, 0.9) * box["height"],
        )

    def one_of(self, selector: str) -> ElementHandle | None:
        """Return a random element that a person could use now."""
        self.held += self.page.query_selector_all(selector)
        usable = [each for each in self.held if each.is_visible() and each.is_enabled()]
        return self.chance.choice(usable) if usable else None

    def pause(self) -> None:
        """Wait as long as a person would."""
        self.page.wait_for_timeout(self.chance.choice((0, 0, 10, 50, 200)))


def zoom(visitor: Visitor) -> None:
    """Turn the wheel over the map, in steps."""
    visitor.page.mouse.move(*visitor.place())
    direction = visitor.chance.choice((-1, -1, -1, 1, 1))
    for _ in range(visitor.chance.randint(1, 12)):
        visitor.page.mouse.wheel(0, direction * visitor.chance.choice((30, 120, 400)))


def drag(visitor: Visitor) -> None:
    """Drag the map."""
    mouse = visitor.page.mouse
    mouse.move(*visitor.place())
    mouse.down()
    mouse.move(*visitor.place(), steps=visitor.chance.randint(1, 8))
    mouse.up()


def click(visitor: Visitor) -> None:
    """Choose a point, sometimes the second one, sometimes the whole map."""
    x, y = visitor.place()
    kind = visitor.chance.choice(("click", "click", "second", "double", "hover"))
    visitor.note(kind)
    if kind == "hover":
        visitor.page.mouse.move(x, y, steps=5)
        return
    if kind == "second":
        visitor.page.keyboard.down("Shift")
    visitor.page.mouse.click(x, y, click_count=2 if kind == "double" else 1)
    if kind == "second":
        visitor.page.keyboard.up("Shift")


def type_keys(visitor: Visitor) -> None:
    """Press keys on the map, or wherever Tab leads."""
    visitor.page.locator(MAP).focus()
    keys = visitor.chance.choices(KEYS, k=visitor.chance.randint(1, 8))
    visitor.note(keys)
    for key in keys:
        visitor.page.keyboard.press(key)


def slide(visitor: Visitor) -> None:
    """Set a slider to any value, by one jump and some steps."""
    slider = visitor.one_of("input[type=range]")
    if slider is None:
        return
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    if box is None:
        return
    visitor.page.mouse.click(box["x"] + visitor.chance.random() * box["width"], box["y"] + box["height"] / 2)
    for _ in range(visitor.chance.randint(0, 6)):
        visitor.page.keyboard.press(visitor.chance.choice(("ArrowLeft", "ArrowRight")))


def select(visitor: Visitor) -> None:
    """Choose from a list."""
    chosen = visitor.one_of("select")
    if chosen is None:
        return
    values = chosen.evaluate(
        "list => [...list.options].filter((each) => !each.matches(':disabled')).map((each) => each.value)"
    )
    if values:
        value = visitor.chance.choice(values)
        visitor.note(value)
        chosen.select_option(value)


def press(visitor: Visitor) -> None:
    """Press a button, open a menu or tick a box."""
    button = visitor.one_of("button, summary, input[type=checkbox], input[type=radio]")
    if button is None:
        return
    visitor.note(repr(button.evaluate("each => each.innerText || each.ariaLabel || each.id").strip()))
    button.scroll_into_view_if_needed()
    box = button.bounding_box()
    if box is not None:
        visitor.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)


def write(visitor: Visitor) -> None:
    """Write something into a field, sensible or not."""
    written = visitor.one_of("input[type=text], input[type=number], input:not([type])")
    if written is None:
        return
    text = visitor.chance.choice(TEXTS)
    visitor.note(text)
    written.scroll_into_view_if_needed()
    written.focus()
    visitor.page.keyboard.press("Control+A")
    visitor.page.keyboard.insert_text(text)
    visitor.page.keyboard.press("Enter")


def follow_address(visitor: Visitor) -> None:
    """Return to an earlier address, or go to one that somebody else has written."""
    visitor.visited.append(visitor.page.evaluate("location.hash"))
    fragment = visitor.chance.choice((*FRAGMENTS, *visitor.visited[-20:]))
    visitor.note(fragment)
    visitor.page.evaluate("fragment => { location.hash = fragment; }", fragment)


def resize(visitor: Visitor) -> None:
    """Change the size of the window."""
    width, height = visitor.chance.choice(SIZES)
    visitor.note((width, height))
    visitor.page.set_viewport_size({"width": width, "height": height})


def change_light(visitor: Visitor) -> None:
    """Toggle the light and the dark theme."""
    visitor.page.emulate_media(color_scheme=visitor.chance.choice(("light", "dark")))


#: Name of an action -> its relative frequency, and its function.
ACTIONS: Mapping[str, tuple[int, Callable[[Visitor], None]]] = {
    "zoom": (30, zoom),
    "drag": (15, drag),
    "click": (15, click),
    "keys": (10, type_keys),
    "slide": (12, slide),
    "select": (4, select),
    "press": (8, press),
    "write": (3, write),
    "address": (5, follow_address),
    "resize": (2, resize),
    "light": (2, change_light),
}
