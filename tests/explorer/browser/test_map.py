"""The map in a real browser: its picture, its reaction to mouse, touch and keys, and its exports."""

import csv
import io
import math
import re
import struct
import xml.etree.ElementTree as ElementTree
from decimal import Decimal
from itertools import product
from urllib.parse import parse_qsl, urlsplit

import pytest
from explorer_client import post

import sweep
from tests.explorer.browser.map_page import (
    BOTH,
    axis,
    check_verdicts,
    click,
    entries,
    lines,
    plot,
    point,
    shown,
    ticks,
    value_at,
    wait_for_picture,
    wait_for_text,
)
from tests.explorer.page.asking import ask
from tests.messages import assert_facts

pytestmark = pytest.mark.slow_lane

VERDICT = ("undecided", "stable", "unstable")


def cell_at(roll_rate, tilt):
    """Return the exact cell of the rolling disk with a start."""
    return sweep.run("rolling", method="exact", roll_rate=[roll_rate], tilt=[tilt], progress=False).squeeze()


def test_picture_shows_the_verdicts_of_the_exact_reduction(opened):
    """Random pixels have the colors of a run's verdicts at their starts."""
    page = opened(BOTH)
    assert {1, 2} <= set(check_verdicts(page, 40))


def test_wheel_zooms_about_the_pointer(opened):
    """The values at the pointer stay in place, and the picture belongs to the address."""
    page = opened()
    before = axis(page, "x"), axis(page, "y")
    x, y = point(page, 0.4, -0.3)
    box = plot(page)
    place = 2 * (x - box["x"]) / box["width"] - 1, 1 - 2 * (y - box["y"]) / box["height"]
    page.mouse.move(x, y)
    for _ in range(3):
        page.mouse.wheel(0, -400)
    wait_for_picture(page)
    after = axis(page, "x"), axis(page, "y")
    for old, new, at in zip(before, after, place, strict=True):
        assert new[2] < 0.5 * old[2]
        assert value_at(new, at) == pytest.approx(value_at(old, at), rel=1e-9)
    view = shown(page)["view"]
    assert (view["x"]["centre"], view["x"]["half"]) == after[0][1:3]
    assert (view["y"]["centre"], view["y"]["half"]) == after[1][1:3]


def test_wheel_over_one_axis_zooms_that_axis(opened):
    """The wheel below the picture zooms only the horizontal axis, and left of it only the vertical one."""
    page = opened()
    before = axis(page, "x"), axis(page, "y")
    box = plot(page)
    page.mouse.move(box["x"] + 100, box["y"] + box["height"] + 20)
    page.mouse.wheel(0, -400)
    wait_for_picture(page)
    assert axis(page, "x")[2] < before[0][2]
    assert axis(page, "y") == before[1]


@pytest.mark.release
def test_zoom_ends_where_pixels_are_eight_units_in_the_last_place(opened):
    """Zooming in ends at pixels of 8 units in the last place, and the page says so."""
    page = opened("base=rolling&x=roll_rate,2.5573,1e-10,linear&y=tilt,-5,1e-10,log&quantity=peak_tilt")
    page.mouse.move(*point(page, 0.2, 0.1))
    for _ in range(20):
        page.mouse.wheel(0, -800)
    wait_for_picture(page)
    picture, x, y = shown(page), axis(page, "x"), axis(page, "y")
    assert 8.0 <= 2 * x[2] / picture["width"] / math.ulp(x[1]) < 8.1
    assert 8.0 <= 2 * y[2] / picture["height"] / math.ulp(y[1]) < 8.1
    assert_facts(page.locator("#notice").text_content(), "8")
    page.mouse.wheel(0, 400)
    wait_for_picture(page)
    assert page.locator("#notice").text_content() == ""


def test_labels_are_the_values_at_their_places(opened):
    """At any depth, the labels of an axis differ, and each is right to a hundredth of a pixel."""
    page = opened()
    degrees = Decimal(180) / Decimal("3.14159265358979323846264338327950288")
    for half, (which, factor) in product([1.0, 1e-3, 1e-6, 1e-10], [("x", Decimal(1)), ("y", degrees)]):
        fragment = f"base=rolling&x=roll_rate,2.5573423705088838,{half!r},linear&y=tilt,-6.7,{half!r},log"
        page.evaluate("fragment => { location.hash = fragment }", fragment)
        wait_for_picture(page)
        _, centre, reach, scale = axis(page, which)
        assert reach == half
        title, found = ticks(page, which)
        assert 2 <= len(found) == len({value for _, value in found}), title
        for place, value in found:
            si = value / factor
            at = (si.ln() if scale == "log" else si) - Decimal(centre)
            pixels = plot(page)["width" if which == "x" else "height"]
            assert float(at / Decimal(reach)) == pytest.approx(place, abs=0.3 / pixels), (title, value)
            assert len(str(value)) < 24


def test_drag_moves_and_double_click_shows_all(opened):
    """A drag by half the width moves the window by half; a double click resets it and chooses nothing."""
    page = opened(BOTH)
    box, before = plot(page), axis(page, "x")
    page.mouse.move(*point(page, 0.5, 0.0))
    page.mouse.down()
    page.mouse.move(*point(page, 0.0, 0.0), steps=5)
    page.mouse.move(*point(page, -0.5, 0.0), steps=5)
    page.mouse.up()
    wait_for_picture(page)
    moved = axis(page, "x")
    assert moved[1] - before[1] == pytest.approx(before[2], abs=2 * before[2] / box["width"])
    assert moved[2] == before[2]
    page.mouse.dblclick(*point(page, 0.1, 0.1))
    wait_for_picture(page)
    assert axis(page, "x") == ("roll_rate", 3.0, 1.0, "linear")
    assert "a" not in entries(page)


@pytest.mark.parametrize("upright", [False, pytest.param(True, marks=pytest.mark.release)])
def test_pinch_zooms(opened, upright):
    """Two fingers that move apart by a factor of two halve the range."""
    page = opened(BOTH, viewport={"width": 360, "height": 740}, has_touch=True)
    before = axis(page, "x")
    session = page.context.new_cdp_session(page)
    middle, up = point(page, 0.0, 0.0)

    def fingers(kind, apart):
        ends = [] if kind == "touchEnd" else [-apart, apart]
        places = [
            {"x": middle + (0 if upright else end), "y": up + (end if upright else 0), "id": number}
            for number, end in enumerate(ends)
        ]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": places})

    fingers("touchStart", 40)
    for apart in range(44, 81, 4):
        fingers("touchMove", apart)
    fingers("touchEnd", 80)
    wait_for_picture(page)
    assert axis(page, "x")[2] == pytest.approx(0.5 * before[2], rel=0.05)
    assert "a" not in entries(page)


def test_tap_shows_numbers_and_motion(opened):
    """A tap chooses a start and shows its numbers, which a mouse shows by hovering."""
    page = opened(BOTH, viewport={"width": 360, "height": 740}, has_touch=True, reduced_motion="reduce")
    page.touchscreen.tap(*point(page, 0.3, 0.2))
    wait_for_text(page, "#readout", "nutation period")
    wait_for_picture(page)
    assert "a" in entries(page)


def check_analytic_line(page, alpha):
    """Check the rolling disk's analytic line with sqrt(g / (2 (1 + alpha) R)), to 0.05 pixels."""
    page.wait_for_selector("#map .lines:not(.stale) .line.analytic", state="attached")
    _, centre, half, _ = axis(page, "x")
    place = (math.sqrt(9.81 / (2.0 * (1.0 + alpha) * 0.5)) - centre) / half
    pixel = (place + 1) / 2 * plot(page)["width"]
    assert max(abs(x - pixel) for x, _ in lines(page, "analytic")) < 0.05


def test_slider_acts_on_picture_and_lines(opened):
    """Another alpha moves the analytic line to sqrt(g / (2 (1 + alpha) R)), and the verdicts with it."""
    page = opened(BOTH)
    page.locator("#slide-alpha").fill("1000")
    wait_for_picture(page)
    assert float(entries(page)["with.alpha"]) == 1.0
    assert shown(page)["view"]["words"] == {"alpha": 1}
    check_analytic_line(page, alpha=1.0)
    check_verdicts(page, alpha=1.0)


def test_number_beside_a_slider_is_exact(opened):
    """A number typed next to a slider is used exactly; other text is refused."""
    page = opened(BOTH)
    page.locator("#value-radius").fill("0.123456789")
    page.keyboard.press("Enter")
    wait_for_picture(page)
    assert shown(page)["view"]["words"] == {"radius": 0.123456789}
    page.locator("#value-radius").fill("thick")
    page.keyboard.press("Enter")
    wait_for_picture(page)
    assert shown(page)["view"]["words"] == {"radius": 0.123456789}


def test_last_of_many_changes_is_shown(opened):
    """After many quick changes of a slider, picture and lines belong to the last one."""
    page = opened(BOTH)
    page.evaluate(
        """() => {
            const slide = document.getElementById("slide-alpha");
            for (let each = 0; each < 60; each += 1) {
                setTimeout(() => {
                    slide.value = String(each * 10);
                    slide.dispatchEvent(new Event("input"));
                }, each * 8);
            }
        }"""
    )
    page.wait_for_timeout(700)
    wait_for_picture(page)
    last = float(entries(page)["with.alpha"])
    assert shown(page)["view"]["words"] == {"alpha": last}
    check_analytic_line(page, last)
    check_verdicts(page, alpha=last)


@pytest.mark.release
def test_a_criterion_without_a_slider_has_its_name(opened, served_with):
    """The menu names a criterion without a slider, and its expression is below."""
    page = opened(url=served_with("rolling", "criterion=peak_tilt > 10deg", "roll_rate=2:4:20").url)
    wait_for_picture(page)
    assert page.locator("#criterion-kind option:checked").text_content() == "other"
    assert "peak_tilt" in page.locator(".own-criterion").text_content()


def test_presets_with_losses_are_named(opened):
    """A preset with losses is in the menu with instructions for its map, but cannot be chosen."""
    page = opened(BOTH)
    others = page.locator("#base optgroup")
    assert "atlas" in others.get_attribute("label")
    assert others.evaluate("each => each.disabled")
    assert "toy" in others.locator("option").all_text_contents()


def test_criterion_acts(opened):
    """A smaller limit makes more of the window unstable, as in a run."""
    page = opened(BOTH)
    page.locator("#value-criterion-departure").fill("1.5")
    page.keyboard.press("Enter")
    wait_for_picture(page)
    assert entries(page)["with.criterion"] == "departure:1.5deg"
    check_verdicts(page, criterion="departure:1.5deg")


def test_numbers_under_the_pointer_are_those_of_the_start(opened):
    """The numbers of the start under the pointer are those of `sweep.run`."""
    page = opened(BOTH)
    page.mouse.move(*point(page, 0.25, 0.5))
    wait_for_text(page, "#readout", "nutation period")
    page.locator("#readout").filter(has_not_text="\u2026").wait_for()
    told = dict(
        zip(
            page.locator("#readout dt").all_text_contents(),
            page.locator("#readout dd").all_text_contents(),
            strict=True,
        )
    )
    x = float(told["roll rate"].split()[0])
    y = math.radians(float(told["tilt"].split()[0]))
    box = plot(page)
    assert x == pytest.approx(value_at(axis(page, "x"), 0.25), abs=2 * axis(page, "x")[2] / box["width"])
    cell = cell_at(x, y)
    # the start is displayed with six digits
    assert float(told["peak tilt"].split()[0]) == pytest.approx(math.degrees(cell["peak_tilt"]), rel=1e-4)
    assert told["verdict"] == VERDICT[int(cell["stability"])]


def test_click_shows_a_motion_and_a_second_one_beside_it(opened):
    """A click chooses a start, and Shift-click a second one; closing the first leaves the second."""
    page = opened(BOTH, reduced_motion="reduce")
    click(page, -0.6, 0.2)
    page.wait_for_selector("#motions .slot[data-shown] >> nth=0")
    assert page.locator("#map circle.mark").count() == 1
    page.keyboard.down("Shift")
    click(page, 0.6, -0.4)
    page.keyboard.up("Shift")
    page.wait_for_selector("#motions .slot[data-shown] >> nth=1")
    wait_for_picture(page)
    chosen = entries(page)
    assert chosen["compare"] == "yes"
    assert chosen["a"] != chosen["b"]
    assert page.locator("#map circle.mark").count() == 2
    page.get_by_role("button", name="Close A").click()
    wait_for_picture(page)
    assert entries(page)["a"] == chosen["b"]
    assert "compare" not in entries(page)
    assert page.locator("#motions .slot").nth(1).is_hidden()


def test_keyboard_goes_everywhere(opened):
    """Arrows move a cursor whose numbers are spoken, + zooms about it, Enter chooses its start, 0 shows all."""
    page = opened(BOTH, reduced_motion="reduce")
    page.locator("#map").focus()
    for key in ("ArrowRight", "ArrowRight", "ArrowUp"):
        page.keyboard.press(key)
    x, y = value_at(axis(page, "x"), 2 * 2 / 50), value_at(axis(page, "y"), 2 / 40)
    wait_for_text(page, "#spoken", f"roll rate {x:.6g} rad s-1")
    spoken = page.locator("#spoken").text_content()
    assert VERDICT[int(cell_at(x, y)["stability"])] in spoken
    page.keyboard.press("Enter")
    wait_for_picture(page)
    # within a pixel
    chosen = list(map(float, entries(page)["a"].split(",")))
    assert chosen == [pytest.approx(x, abs=2e-3), pytest.approx(y, rel=1e-2)]
    before = axis(page, "x")
    page.keyboard.press("+")
    wait_for_picture(page)
    assert axis(page, "x")[2] == pytest.approx(0.7 * before[2])
    page.keyboard.press("0")
    wait_for_picture(page)
    assert axis(page, "x") == ("roll_rate", 3.0, 1.0, "linear")
    # at the border, the cursor moves the window
    page.keyboard.press("Shift+ArrowLeft")
    for _ in range(4):
        page.keyboard.press("Shift+ArrowLeft")
    wait_for_picture(page)
    assert axis(page, "x")[1] < 3.0


def test_refusal_is_told_in_words(opened):
    """The server's refusal is shown next to the picture and disappears with its cause."""
    page = opened(BOTH)
    # with status 200, because the watch reports error responses, and this one is intended
    page.route("**/plan", lambda route: route.fulfill(status=200, content_type="text/plain", body="none"))
    page.locator("#slide-alpha").fill("300")
    wait_for_text(page, "#notice", re.compile(r"\S"))
    page.unroute("**/plan")
    page.locator("#slide-alpha").fill("500")
    wait_for_picture(page)
    assert page.locator("#notice").text_content() == ""


def test_the_scale_of_colours_can_be_held(opened):
    """The color scale can be fixed to the current window until it is released."""
    page = opened(BOTH.replace("stability", "peak_tilt"))
    page.locator("#hold-colours").check()
    wait_for_picture(page)
    head, _ = ask(page, "window", **shown(page))
    held = entries(page)["range"]
    assert [float(each) for each in held.split(",")] == [head["low"], head["high"]]
    page.mouse.move(*point(page, 0.6, -0.5))
    page.mouse.wheel(0, -400)
    wait_for_picture(page)
    assert entries(page)["range"] == held
    page.locator("#hold-colours").uncheck()
    wait_for_picture(page)
    assert "range" not in entries(page)
    page.locator("#hold-colours").check()
    wait_for_picture(page)
    assert "range" in entries(page)
    # fixed ends are not used for another quantity
    page.locator("#quantity").select_option("amplification")
    wait_for_picture(page)
    assert "range" not in entries(page)


def test_axes_can_be_others(opened):
    """If another parameter becomes the horizontal axis, the old one keeps its middle value and gets a slider."""
    page = opened(BOTH)
    page.locator("#axis-x").select_option("alpha")
    wait_for_picture(page)
    assert axis(page, "x")[0] == "alpha"
    assert float(entries(page)["with.roll_rate"]) == 2.7
    assert page.locator("#slide-roll_rate").count() == 1
    # a double click on its name: the middle of its axis in the preset
    page.locator(".caption label", has_text="roll rate").dblclick()
    page.wait_for_url(lambda url: float(dict(parse_qsl(urlsplit(url).fragment))["with.roll_rate"]) == 3.0)
    page.locator("#log-x").check()
    wait_for_picture(page)
    assert axis(page, "x")[3] == "log"


def test_window_is_saved(opened):
    """The window can be saved as PNG, SVG, CSV and netCDF that other programs read, with colored lines and text."""
    page = opened(BOTH, accept_downloads=True, viewport={"width": 400, "height": 400})
    files = {}
    for words in ("picture, PNG", "picture, SVG", "data, CSV", "data, netCDF"):
        page.get_by_text("Save", exact=True).click()
        with page.expect_download() as download:
            page.get_by_role("button", name=words).click()
        files[words] = download.value.path().read_bytes()
    png, box = files["picture, PNG"], page.locator("#map").bounding_box()
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", png[16:24]) == (2 * round(box["width"]), 2 * round(box["height"]))
    picture = ElementTree.fromstring(files["picture, SVG"])
    assert "roll rate (rad s\u207b\u00b9)" in "".join(picture.itertext())
    assert any("image" in each.tag for each in picture)
    drawn = {
        kind: [each for each in picture.iter() if each.tag.endswith("}" + kind)]
        for kind in ("text", "line", "path")
    }
    assert all(drawn.values())
    assert {each.get("fill") for each in drawn["path"]} == {"none"}
    assert all(each.get("fill", "").startswith(("rgb", "#")) for each in drawn["text"])
    assert any(each.get("stroke", "").startswith(("rgb", "#")) for each in drawn["line"])
    rows = list(csv.reader(io.StringIO(files["data, CSV"].decode())))
    assert {"roll_rate", "tilt"} <= {name.split(" ")[0] for name in rows[0] if name}
    size = shown(page)
    assert len(rows) > size["width"] * size["height"]
    assert files["data, netCDF"][:4] in (b"\x89HDF", b"CDF\x01", b"CDF\x02")


def test_window_is_copied_as_command(opened, explorer):
    """The copied texts are the address, and the server's command and Python code for the window."""
    page = opened(BOTH)
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])

    def copied(words):
        page.get_by_text("Copy", exact=True).click()
        page.get_by_role("button", name=words).click()
        wait_for_text(page, "#notice", re.compile(r"\S"))
        text = page.evaluate("navigator.clipboard.readText()")
        page.evaluate("document.getElementById('notice').textContent = ''")
        return text

    assert copied("address of this view") == page.url
    size = shown(page)
    asked = {"view": size["view"], "width": size["width"], "height": size["height"]}
    answer = post(explorer.url, "command", **asked)
    assert copied("window as command") == answer["command"]
    assert copied("window as Python") == answer["python"]
    item = page.get_by_role("button", name="motion A as command", include_hidden=True)
    assert item.evaluate("each => each.hidden")
    click(page, 0.3, 0.2)
    page.wait_for_selector("#motions .slot[data-shown]")
    wait_for_picture(page)
    page.locator("details.laws summary").first.click()
    page.get_by_role("slider", name="contour friction").press("PageUp")
    page.locator(".motion.lossy.shown:not(.waiting)").wait_for()
    # a chosen point does not change the window, and its panel's losses belong to its motion
    assert copied("window as command") == answer["command"]
    motion = copied("motion A as command")
    assert motion.startswith("eulerdisk simulate ")
    assert "contour_friction=" in motion


@pytest.mark.release
def test_a_criterion_that_is_none_is_not_asked_for(opened):
    """A limit outside 0 to half a turn is marked with the allowed range and not sent."""
    page = opened()
    field = page.locator("#value-criterion-departure")
    for wrong in ("-7", "0", "180"):
        field.fill(wrong)
        page.keyboard.press("Enter")
        assert field.evaluate("each => each.classList.contains('wrong')"), wrong
        assert_facts(field.get_attribute("title"), "0", "180 deg")
    wait_for_picture(page)
    assert "with.criterion" not in entries(page)
    field.fill("7")
    page.keyboard.press("Enter")
    wait_for_picture(page)
    assert entries(page)["with.criterion"] == "departure:7deg"
    assert not field.evaluate("each => each.classList.contains('wrong')")
    assert not field.get_attribute("title")
