"""The map of an atlas in a real browser: stored and computed cells, available quantities, and the exported page."""

import math
import re
import subprocess
import sys

import numpy as np
import pytest

import sweep
from sweep.explorer.point import NO_CELL
from tests.explorer.browser.map_page import (
    VERDICTS,
    axis,
    cells,
    check_verdicts,
    colours,
    entries,
    point,
    random_pixels,
    shown,
    value_at,
    wait_for_picture,
    wait_for_text,
)
from tests.messages import assert_facts

pytestmark = pytest.mark.slow_lane


@pytest.fixture(scope="module")
def atlas(tmp_path_factory):
    """Return the path of an atlas of 24 x 16 cells."""
    path = tmp_path_factory.mktemp("map") / "atlas.nc"
    sweep.run_to_file(
        "rolling", path, roll_rate="2.3:3.1:24", tilt="0.2deg:4deg:16:log", method="exact", progress=False
    )
    return path


def check_cells(page, atlas):
    """Check the colors of random pixels against the verdicts of their nearest cells, and return the pixels."""
    size, x, y = shown(page), axis(page, "x"), axis(page, "y")
    pixels = random_pixels(size["width"], size["height"], 60)
    stored, expected = sweep.open_atlas(atlas), []
    verdicts = stored.stability.transpose("roll_rate", "tilt").values
    for column, row in pixels:
        tilt = value_at(x, (2 * column + 1) / size["width"] - 1)
        roll = value_at(y, (2 * row + 1) / size["height"] - 1)
        across = int(np.abs(np.log(stored.tilt.values) - math.log(tilt)).argmin())
        up = int(np.abs(stored.roll_rate.values - roll).argmin())
        expected.append(int(verdicts[up, across]))
    assert [VERDICTS[colour] for colour in colours(page, pixels)] == expected
    return pixels


def test_cells_of_a_file_are_told_from_computed_ones(opened, served_with, atlas):
    """Inside the grid, a pixel has its stored cell's verdict and says so; outside it has a computed one."""
    served = served_with(atlas)
    page = opened("quantity=stability", url=served.url)
    wait_for_picture(page)
    size, x, y = shown(page), axis(page, "x"), axis(page, "y")
    pixels = check_cells(page, atlas)
    page.mouse.move(*point(page, 0.3, 0.3))
    wait_for_text(page, "#readout", "stored cell")
    page.locator("#show-stored").uncheck()
    wait_for_picture(page)
    assert entries(page)["stored"] == "no"
    assert not opened(page.url.split("#")[1], url=served.url).locator("#show-stored").is_checked()
    pixels = pixels[:12]
    painted = [VERDICTS[colour] for colour in colours(page, pixels)]
    assert painted == cells(pixels, x, y, size["width"], size["height"])


@pytest.fixture(scope="module")
def lossy(tmp_path_factory):
    """Return the path of an atlas with losses, 3 x 4 cells, of which nothing can be recomputed."""
    path = tmp_path_factory.mktemp("lossy") / "toy.nc"
    sweep.run_to_file(
        "toy",
        path,
        tilt="20deg:60deg:3",
        precession_rate="5:20:4",
        duration="5s",
        criterion="aloft:5s",
        progress=False,
    )
    return path


def test_each_base_offers_what_it_can_show(opened, served_with, lossy):
    """Disks without losses have no end time, so another base switches to a quantity that it has."""
    page = opened("quantity=end_time", url=served_with(lossy).url)
    offered = page.locator("#quantity option")
    assert "end time" in offered.all_text_contents()
    assert shown(page)["quantity"] == "end_time"
    page.locator("#base").select_option("rolling")
    wait_for_picture(page)
    assert shown(page)["view"]["base"] == "rolling"
    assert shown(page)["quantity"] == entries(page)["quantity"] == page.locator("#quantity").input_value()
    assert "end time" not in offered.all_text_contents()
    page.evaluate("location.hash = 'base=rolling&quantity=end_time'")
    wait_for_picture(page)
    assert shown(page)["quantity"] != "end_time"


@pytest.mark.release
def test_what_stored_cells_alone_have_is_not_asked_of_others(opened, served_with, tmp_path):
    """The time of a fall is stored only for the file's alpha: for another one, the map is empty and says so."""
    path = tmp_path / "integrated.nc"
    sweep.run_to_file("rolling", path, roll_rate="2.3:3.1:8", tilt="0.2deg:4deg:6:log", progress=False)
    page = opened("quantity=fall_time", url=served_with(path).url)
    wait_for_picture(page)
    assert shown(page)["quantity"] == "fall_time"
    page.locator("#slide-alpha").fill("800")
    wait_for_picture(page)
    assert_facts(page.locator("#notice").text_content().lower(), "fall time")
    assert set(colours(page, [[column, 20] for column in range(0, 300, 10)])) == {None}
    page.locator("#quantity").select_option("peak_tilt")
    wait_for_picture(page)
    assert page.locator("#notice").text_content() == ""


@pytest.mark.release
def test_a_refused_window_leaves_no_picture_of_another_plane(opened, served_with, lossy):
    """If the window of another base is refused, the message stays and the old picture disappears."""
    page = opened(url=served_with(lossy).url)
    assert page.get_by_role("button", name="data, CSV", include_hidden=True).evaluate("each => each.hidden")
    # with status 200, because the watch reports error responses, and this one is intended
    page.route("**/plan", lambda route: route.fulfill(status=200, content_type="text/plain", body="none"))
    page.locator("#base").select_option("rolling")
    page.wait_for_selector("#map:not([data-shown])[aria-busy=false]")
    page.wait_for_selector("#map .lines:not(.stale) .line.analytic", state="attached")
    assert page.locator("#notice").text_content().strip()
    assert set(colours(page, [[column, 20] for column in range(0, 300, 10)])) == {None}
    page.unroute("**/plan")
    page.locator("#base").select_option("")
    wait_for_picture(page)
    assert page.locator("#notice").text_content() == ""


def test_outside_the_grid_it_is_said_that_there_is_no_cell(opened, served_with, lossy):
    """Outside the cells of an atlas with losses, there is no color, number or verdict, and one line says so."""
    page = opened("quantity=stability", url=served_with(lossy).url)
    box = page.locator("#map .picture").bounding_box()
    # there is nothing else to show
    assert page.locator("#show-stored").is_hidden()
    page.mouse.move(*point(page, 0.0, 0.0))
    wait_for_text(page, "#readout", "verdict")
    for _ in range(2):
        page.mouse.wheel(0, 800)
    wait_for_picture(page)
    width = shown(page)["width"]
    assert set(colours(page, [[column, 3] for column in range(0, width, 20)])) == {None}
    page.mouse.move(*point(page, 0.9, -0.9))
    wait_for_text(page, "#readout", NO_CELL)
    told = page.locator("#readout").inner_text()
    assert not [word for word in ("verdict", "undecided", "end time", "\u2026") if word in told]
    assert box["width"] == page.locator("#map .picture").bounding_box()["width"]
    # a click shows a motion, which exists everywhere with losses, and the words next to it are about it
    page.mouse.click(*point(page, 0.9, -0.9))
    page.wait_for_selector("#motions .slot[data-shown] .motion.shown:not(.waiting)")
    page.locator(".motion .verdict", has_text=re.compile("stable|undecided")).wait_for()
    assert NO_CELL in page.locator("#readout").inner_text()
    page.locator("#map").focus()
    for _ in range(2):
        page.keyboard.press("Shift+ArrowLeft")
    wait_for_text(page, "#spoken", NO_CELL)
    # the window extends as far as tilts do: the cells are in its right half
    page.mouse.move(*point(page, 0.44, 0.0))
    wait_for_text(page, "#readout", "stored cell")
    assert NO_CELL not in page.locator("#readout").inner_text()


@pytest.mark.release
def test_that_there_is_no_cell_is_said_at_once_and_of_an_address(opened, served_with, lossy):
    """A pixel without a cell is reported without a request; for a start in an address, the server reports it."""
    url = served_with(lossy).url
    page = opened("quantity=stability&a=0.9,25", url=url)
    page.wait_for_selector("#motions .motion:is(.shown, .refused):not(.waiting)")
    wait_for_text(page, "#readout", NO_CELL)
    assert "verdict" not in page.locator("#readout").inner_text()
    page.mouse.move(*point(page, 0.0, 0.0))
    wait_for_text(page, "#readout", "verdict")
    page.mouse.wheel(0, 1600)
    wait_for_picture(page)
    asked = []
    page.on("request", lambda request: asked.append(request.url) if request.url.endswith("/point") else None)
    page.mouse.move(*point(page, 0.9, -0.9))
    wait_for_text(page, "#readout", NO_CELL)
    page.wait_for_timeout(200)
    assert asked == []


def exported(atlas, folder):
    """Return the address of the exported page of a file."""
    target = folder / "page.html"
    command = [sys.executable, "-m", "sweep", "explore", str(atlas), "--export", str(target)]
    subprocess.run(command, check=True, capture_output=True)
    return target.as_uri()


def test_exported_page_opens_from_disk(opened, atlas, tmp_path):
    """Without a server, the page shows the cells of its atlas and computes others."""
    page = opened("quantity=stability", url=exported(atlas, tmp_path))
    wait_for_picture(page)
    check_cells(page, atlas)
    page.mouse.move(*point(page, 0.3, 0.3))
    wait_for_text(page, "#readout", "stored cell")
    page.mouse.wheel(0, -1200)
    wait_for_picture(page)
    assert "16 x 24 cells" in page.locator("#notice").text_content()
    page.locator("#show-stored").uncheck()
    wait_for_picture(page)
    check_verdicts(page, 20)
    page.locator("#show-stored").check()
    page.locator("#whole").click()
    wait_for_picture(page)
    page.mouse.move(*point(page, 0.0, 0.0))
    page.mouse.wheel(0, 400)
    wait_for_picture(page)
    size, x, y = shown(page), axis(page, "x"), axis(page, "y")
    corner = [[1, 1], [size["width"] - 2, 1]]
    painted = [VERDICTS[colour] for colour in colours(page, corner)]
    assert painted == cells(corner, x, y, size["width"], size["height"])


def test_exported_page_of_losses_shows_its_cells_alone(opened, lossy, tmp_path):
    """Outside the cells of an atlas with losses the map is empty, but motions exist everywhere."""
    page = opened("quantity=stability", url=exported(lossy, tmp_path))
    wait_for_picture(page)
    page.mouse.move(*point(page, 0.0, 0.0))
    wait_for_text(page, "#readout", "stored cell")
    page.mouse.wheel(0, 800)
    wait_for_picture(page)
    assert colours(page, [[1, 1]]) == [None]
    page.mouse.move(*point(page, -0.98, -0.98))
    wait_for_text(page, "#readout", NO_CELL)
    page.mouse.click(*point(page, 0.05, 0.05))
    page.wait_for_selector("#motions .motion.lossy.shown:not(.waiting)")
    page.click("#compare")
    page.mouse.click(*point(page, 0.3, 0.2))
    page.wait_for_selector("#motions .slot >> nth=1 >> .motion.lossy.shown:not(.waiting)")
    # both are cells, wherever the click was
    with sweep.open_atlas(lossy) as atlas:
        for chosen in ("a", "b"):
            place = dict(zip("xy", map(float, entries(page)[chosen].split(",")), strict=True))
            for side, value in place.items():
                values = atlas[axis(page, side)[0]].values
                assert np.abs(values - value).min() < 1e-9 * abs(value), (chosen, side)
