"""Helpers for tests of the map: read the page's address and picture, and use the page like a person."""

import json
import math
from decimal import Decimal
from random import Random
from urllib.parse import parse_qsl, urlsplit

import sweep

random = Random(3)

#: Time limit of any action in a page [ms]. A kernel of losses takes ten seconds, and several times as long on
#: a busy machine.
PATIENCE = 120_000

COMPLETE = "#map[data-lane=fine][aria-busy=false]"

#: A window of the rolling disk that contains both verdicts.
BOTH = "base=rolling&x=roll_rate,2.7,0.5,linear&y=tilt,-4.5,1.5,log&quantity=stability"

#: The page's colors of the verdicts undecided, stable and unstable.
VERDICTS = {(154, 154, 154): 0, (59, 118, 175): 1, (238, 138, 46): 2}


def entries(page):
    """Return the entries of the address."""
    return dict(parse_qsl(urlsplit(page.url).fragment, keep_blank_values=True))


def axis(page, which):
    """Return (name, center, half, scale) of an axis from the address, once it is written."""
    page.wait_for_url(lambda url: "#" in url)
    name, centre, half, scale = entries(page)[which].split(",")
    return name, float(centre), float(half), scale


def value_at(found, place):
    """Return the value of an axis at a place from -1 to 1."""
    _, centre, half, scale = found
    at = centre + half * place
    return math.exp(at) if scale == "log" else at


def wait_for_picture(page):
    """Wait until the address and the complete picture show the last action."""
    page.wait_for_timeout(300)
    page.wait_for_selector(COMPLETE)


def wait_for_text(page, selector, text):
    """Wait until an element contains a text or matches a pattern."""
    page.locator(selector).filter(has_text=text).wait_for(state="attached")


def shown(page):
    """Return the view, the quantity and the size of the picture."""
    return json.loads(page.locator("#map").get_attribute("data-shown"))


def plot(page):
    """Return the place of the picture on the screen."""
    return page.locator("#map .picture").bounding_box()


def point(page, across, up):
    """Return the screen pixel at a place of the picture from -1 to 1, as integers, like browsers report clicks."""
    box = plot(page)
    return round(box["x"] + (across + 1) / 2 * box["width"]), round(box["y"] + (1 - up) / 2 * box["height"])


def click(page, across, up):
    """Click a place of the picture."""
    page.mouse.click(*point(page, across, up))


def colours(page, pixels):
    """Return (red, green, blue) of pixels (column, row from the bottom) of the picture, None if unpainted."""
    found = page.evaluate(
        """pixels => {
            const shown = document.querySelector("#map .picture");
            const { width, height } = shown;
            // a copy: browsers warn of a canvas that is read more than once
            const copy = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
            copy.drawImage(shown, 0, 0);
            const { data } = copy.getImageData(0, 0, width, height);
            return pixels.map(([column, row]) => {
                const from = 4 * ((height - 1 - row) * width + column);
                return Array.from(data.slice(from, from + 4));
            });
        }""",
        pixels,
    )
    return [tuple(each[:3]) if each[3] else None for each in found]


def lines(page, name):
    """Return the points [pixels of the plot] of a line of the overlay."""
    path = page.locator(f"#map .lines .line.{name}").get_attribute("d")
    return [tuple(map(float, each.split())) for part in path.split("M") if part for each in part.split("L")]


def ticks(page, which):
    """Return the labeled ticks of an axis as (place from -1 to 1, displayed value as a Decimal)."""
    box = plot(page)
    group = page.locator("#map .overlay .axis").nth(0 if which == "x" else 1)
    title = group.locator(".title").text_content()
    offset, power = _scale(title)
    found = []
    # in one call, because the axis may be redrawn between two
    read = "(all, name) => all.map((each) => [each.getAttribute(name), each.textContent])"
    for at, text in group.locator("text:not(.title)").evaluate_all(read, which):
        at = float(at)
        place = 2 * at / box["width"] - 1 if which == "x" else 1 - 2 * at / box["height"]
        text = text.replace("\u2212", "-")
        found.append((place, offset + Decimal(text).scaleb(power)))
    return title, found


def _scale(title):
    """Return the offset and the power of ten in a title: "roll rate: 2.557342371 + labels x 10^-11 rad/s"."""
    offset = title.split(": ")[1].split(" + ")[0] if " + labels" in title else "0"
    if "\u00d7" not in title:
        return Decimal(offset), 0
    digits = title.split("\u00d7\u2009")[1].split(" ")[0].rstrip(")").removeprefix("10")
    superscripts = str.maketrans(
        "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079\u207b", "0123456789-"
    )
    return Decimal(offset.replace("\u2212", "-")), int(digits.translate(superscripts) or 1)


def cells(pixels, x, y, width, height, **words):
    """Return the verdicts of the exact reduction at pixels of a window."""
    starts = {
        x[0]: [value_at(x, (2 * column + 1) / width - 1) for column, _ in pixels],
        y[0]: [value_at(y, (2 * row + 1) / height - 1) for _, row in pixels],
    }
    found = [
        sweep.run("rolling", roll_rate=roll, tilt=[tilt], method="exact", progress=False, **words)
        for roll, tilt in zip(starts["roll_rate"], starts["tilt"], strict=True)
    ]
    return [int(each.stability.values.ravel()[0]) for each in found]


def random_pixels(width, height, count):
    """Return random pixels of a picture."""
    return [[random.randrange(width), random.randrange(height)] for _ in range(count)]


def check_verdicts(page, count=12, **words):
    """Check the colors of random pixels against a run's verdicts at their starts, and return these verdicts."""
    width, height = (shown(page)[name] for name in ("width", "height"))
    pixels = random_pixels(width, height, count)
    painted = [VERDICTS[colour] for colour in colours(page, pixels)]
    assert painted == cells(pixels, axis(page, "x"), axis(page, "y"), width, height, **words)
    return painted
