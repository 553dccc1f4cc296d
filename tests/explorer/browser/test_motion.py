"""The panel of a motion in a real browser: disk, clock, curves, losses, and two synchronous motions."""

import math
import re

import numpy as np
import pytest
from explorer_browser import COMPLETE, Watch

import sweep
from sweep.explorer.explorer import subject_of
from sweep.explorer.export import export
from tests.explorer.browser.holding import HOLD, wait_for_held
from tests.explorer.browser.map_page import entries, wait_for_picture
from tests.messages import assert_facts

pytestmark = pytest.mark.slow_lane

SHOWN = ".motion.shown:not(.waiting)"

#: The time of the clock, and if it runs.
CLOCK = """async () => {
  const { clock } = await import("eulerdisk/motion/clock");
  return { time: clock.time, playing: clock.playing, length: clock.length, speed: clock.speed };
}"""

#: Pixels of the disk's picture that differ from its corner: the disk, its shadow, its path.
DRAWN = """async (number) => {
  const canvas = document.querySelectorAll(".motion .stage canvas")[number];
  const { clock } = await import("eulerdisk/motion/clock");
  clock.seek(clock.time);
  // what was drawn in a frame can be read before its end
  await new Promise(requestAnimationFrame);
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, copy.width, copy.height);
  const seen = new Set();
  for (let i = 0; i < data.length; i += 4) seen.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
  return seen.size;
}"""

#: Color of the table in the upper left corner of the picture.
CORNER = """async () => {
  const canvas = document.querySelector(".motion .stage canvas");
  const { clock } = await import("eulerdisk/motion/clock");
  clock.seek(clock.time);
  // what was drawn in a frame can be read before its end
  await new Promise(requestAnimationFrame);
  const copy = document.createElement("canvas");
  copy.width = copy.height = 1;
  const context = copy.getContext("2d");
  context.drawImage(canvas, 5, 5, 1, 1, 0, 0, 1, 1);
  return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3);
}"""


#: Colors of the disk's rim and of the table, from 0 to 255.
RIM_AND_TABLE = """() => ["--motion-rim", "--motion-ground"].map((name) => {
  const probe = document.createElement("i");
  probe.style.color = `var(${name})`;
  document.querySelector(".motion").append(probe);
  const { color } = getComputedStyle(probe);
  probe.remove();
  return color.match(/\\d+/g).map(Number);
})"""


def contrast(*colours):
    """Return the contrast of two colors as defined by WCAG; a ring seen edge-on shows only its rim."""
    light = []
    for colour in colours:
        shares = [each / 255 for each in colour]
        linear = [each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in shares]
        light.append(0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2])
    return (max(light) + 0.05) / (min(light) + 0.05)


def choose(page, x=0.6, y=0.5, number=0):
    """Click the map at a place, as shares of its width and height, and wait for the motion of that slot."""
    box = page.locator("#map").bounding_box()
    page.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])
    page.locator(SHOWN).nth(number).wait_for()


def clock(page):
    """Return the clock of the page."""
    return page.evaluate(CLOCK)


def seek(page, time):
    """Set the clock."""
    page.evaluate("(time) => import('eulerdisk/motion/clock').then(({ clock }) => clock.seek(time))", time)


def test_a_click_shows_the_disk_and_its_curves(opened):
    """After a click, the disk is drawn, with three plots, an ending and a verdict in words."""
    page = opened()
    choose(page)
    panel = page.locator(".motion").first
    assert page.evaluate(DRAWN, 0) > 100
    assert panel.locator(".plot svg path.curve").count() == 5
    assert re.search(r"\d s$", panel.locator(".ending").inner_text())
    panel.locator(".verdict", has_text="stable").wait_for()
    # turning points have as many digits as the numbers next to the map
    titles = panel.locator(".plot.potential .dot.turn title").all_text_contents()
    page.locator("#readout dd", has_text="stable").wait_for()
    numbers = dict(
        zip(
            page.locator("#readout dt").all_inner_texts(),
            page.locator("#readout dd").all_inner_texts(),
            strict=True,
        )
    )
    assert titles == [f"turning point at {numbers[name]}" for name in ("tilt min", "tilt max")]


def test_a_disk_that_falls_stays_where_it_fell(opened):
    """At its end the disk lies flat, the dot is at the end of the potential, and the text states the ending."""
    page = opened("base=rolling&a=0.5,0&b=0.02,2.2&compare=yes")
    page.locator(SHOWN).nth(1).wait_for()
    panel = page.locator(".motion").first
    ending = panel.locator(".ending")
    assert re.search(r"fell.* 0\.\d+ s$", ending.inner_text())
    # the other motion continues
    seek(page, 3.0)
    assert re.search(r"fell.* 0\.\d+ s\W+\w", ending.inner_text())
    assert_facts(page.locator(".motion").nth(1).locator(".ending").inner_text(), "10 s")
    curve = panel.locator(".plot.potential .curve").get_attribute("d")
    end = [float(each) for each in re.findall(r"-?\d+\.\d+", curve)[-2:]]
    dot = panel.locator(".plot.potential .cursor circle")
    assert [float(dot.get_attribute(name)) for name in ("cx", "cy")] == pytest.approx(end, abs=0.5)
    tilts = panel.locator(".plot.tilt .curve").get_attribute("d")
    line = float(panel.locator(".plot.tilt .cursor line").get_attribute("x1"))
    assert line == pytest.approx(float(re.findall(r"-?\d+\.\d+", tilts)[-2]), abs=0.5)
    canvas = panel.locator(".stage canvas")
    canvas.focus()
    canvas.press(" ")
    assert clock(page)["playing"]
    canvas.press(" ")
    assert not clock(page)["playing"]


def test_the_disk_plays_pauses_and_ends(opened):
    """The motion starts by itself, can be paused, and restarts after its end."""
    page = opened(reduced_motion="no-preference")
    choose(page)
    assert clock(page)["playing"]
    # without a graphics card, drawing leaves no time for the checks of a click
    page.get_by_role("button", name="pause", exact=True).dispatch_event("click")
    paused = clock(page)
    assert not paused["playing"]
    page.wait_for_timeout(100)
    assert clock(page)["time"] == paused["time"]
    seek(page, paused["length"])
    page.get_by_role("button", name="play", exact=True).dispatch_event("click")
    again = clock(page)
    assert again["playing"]
    assert again["time"] < paused["length"]


@pytest.mark.release
def test_motion_is_not_begun_for_those_who_want_less_of_it(opened):
    """With prefers-reduced-motion, a motion waits for its button."""
    page = opened(reduced_motion="reduce")
    choose(page)
    assert not clock(page)["playing"]
    assert clock(page)["time"] == 0.0
    page.get_by_role("button", name="play", exact=True).click()
    assert clock(page)["playing"]


def test_a_curve_is_dragged_through_time(opened):
    """Dragging moves the cursor of the tilt to the pointer, and the slider agrees."""
    page = opened()
    choose(page)
    box = page.locator(".plot.tilt > svg").first.bounding_box()
    page.mouse.move(box["x"] + 100, box["y"] + 40)
    page.mouse.down()
    first = clock(page)
    page.mouse.move(box["x"] + 250, box["y"] + 60, steps=4)
    second = clock(page)
    page.mouse.up()
    page.mouse.move(box["x"] + 300, box["y"] + 60)
    assert 0.0 < first["time"] < second["time"] == clock(page)["time"]
    line = page.locator(".plot.tilt .cursor line")
    assert box["x"] + float(line.get_attribute("x1")) == pytest.approx(box["x"] + 250, abs=1.0)
    share = float(page.locator(".transport .time").input_value()) / 1000
    assert share == pytest.approx(second["time"] / second["length"], abs=1e-3)


def test_two_motions_are_synchronous(opened):
    """One clock moves both motions, curves share the longer time, and closing one panel leaves the other."""
    page = opened()
    choose(page, 0.2, 0.5)
    alone = clock(page)["length"]
    page.click("#compare")
    choose(page, 0.7, 0.5, number=1)
    both = clock(page)["length"]
    assert both >= alone
    seek(page, 0.2 * both)
    places = page.locator(".plot.tilt .cursor line").evaluate_all(
        "all => all.map((each) => each.getAttribute('x1'))"
    )
    assert len(places) == 2
    assert float(places[0]) == pytest.approx(float(places[1]), abs=1.5)
    assert page.evaluate(DRAWN, 0) > 100
    assert page.evaluate(DRAWN, 1) > 100
    page.get_by_role("button", name="Close B").click()
    page.wait_for_function("() => document.querySelectorAll('.stage canvas').length === 1")
    assert clock(page)["length"] == alone
    choose(page, 0.7, 0.4, number=0)
    assert page.evaluate(DRAWN, 0) > 100


def beside_a_longer_one(page):
    """Choose two starts and return the number of the shorter one, which is then followed for longer."""
    choose(page, 0.2, 0.5)
    alone = clock(page)["length"]
    page.click("#compare")
    choose(page, 0.7, 0.5, number=1)
    page.wait_for_timeout(500)
    return 1 if clock(page)["length"] == alone else 0


def test_losses_of_two_motions_are_each_its_own(opened):
    """Losses set for B do not change those of A, and vice versa."""
    page = opened("base=rolling&a=0.02,2.4&b=0.02,2.9&compare=yes")
    for number, name in enumerate("ab"):
        slot = page.locator("#motions .slot").nth(number)
        slot.locator(SHOWN).wait_for()
        slot.locator("details.laws summary").click()
        for _ in range(1 + number):
            slot.get_by_role("slider", name="contour friction").press("PageUp")
        page.wait_for_url(lambda url, name=name: f"{name}.loss.contour_friction" in url)
    wait_for_picture(page)
    losses = [float(entries(page)[f"{name}.loss.contour_friction"]) for name in "ab"]
    assert 0.0 < losses[0] < losses[1]
    page.locator("#motions .slot").nth(0).get_by_role("slider", name="contour friction").press("PageUp")
    wait_for_picture(page)
    assert losses[0] < float(entries(page)["a.loss.contour_friction"])
    assert losses[1] == float(entries(page)["b.loss.contour_friction"])


def test_a_motion_that_is_not_followed_for_longer_says_why(opened):
    """The motion keeps its length, is requested once, and its message disappears with the other motion."""
    page = opened()
    page.evaluate(REFUSE)
    shorter = beside_a_longer_one(page)
    problem = page.locator(".motion .problem").nth(shorter)
    problem.filter(has_text="No longer one here.").wait_for()
    seek(page, 0.5)
    page.wait_for_timeout(200)
    assert page.evaluate("refused") == 1
    page.get_by_role("button", name=f"Close {'BA'[shorter]}").click()
    page.locator(".motion .problem").nth(shorter).filter(has_not_text="longer").wait_for(state="attached")


#: Refuse to follow a start for longer than at first.
REFUSE = """() => {
    const send = Worker.prototype.postMessage;
    const lengths = new Map();
    window.refused = 0;
    Worker.prototype.postMessage = function (message, ...more) {
        if (message.what === "call" && message.asked.name === "trajectory") {
            const [start, , times] = message.asked.values.map((each) => each.numbers);
            const first = lengths.get(String(start)) ?? times.at(-1);
            lengths.set(String(start), first);
            if (times.at(-1) > first) {
                window.refused += 1;
                setTimeout(() => this.onmessage({ data: { problem: "No longer one here." } }));
                return;
            }
        }
        send.call(this, message, ...more);
    };
}"""


def test_a_closed_slot_stays_empty(opened):
    """A motion that is closed before its numbers arrive stays closed and delays no other."""
    page = opened()
    page.evaluate(HOLD, "call")
    page.locator("#map").click(position={"x": 500, "y": 300})
    page.wait_for_selector(".motion.waiting", state="attached")
    wait_for_held(page, 1)
    page.locator("#map").click(position={"x": 400, "y": 200})
    wait_for_held(page, 2)
    page.get_by_role("button", name="Close A").click()
    page.wait_for_selector(".motion:not(.waiting)", state="attached")
    page.evaluate("letGo()")
    page.wait_for_timeout(300)
    assert page.locator(".motion.shown").count() == 0
    choose(page)
    assert page.locator(".motion.shown").count() == 1


def test_losses_stop_the_disk(opened):
    """A loss slider makes another motion, and a ledger replaces the potential; without losses it returns."""
    page = opened()
    choose(page)
    page.locator("details.laws summary").first.click()
    slider = page.get_by_role("slider", name="contour friction")
    assert slider.get_attribute("aria-valuetext") == "none"
    for _ in range(7):
        slider.press("PageUp")
    page.locator(".motion.lossy.shown:not(.waiting)").wait_for()
    page.locator(".motion .ending", has_text="flat").first.wait_for()
    assert slider.get_attribute("aria-valuetext").endswith(" mm")
    assert page.locator(".plot.potential .area.contour_loss").count() == 1
    # the text next to the motion is about it; the numbers under the map are marked as without losses
    assert "without losses" in page.locator("#readout").inner_text()
    assert page.locator(".motion .verdict").first.inner_text() == ""
    page.locator("details.words summary").first.click()
    page.locator(".explanation", has_text="contour_loss").first.wait_for()
    told = dict(re.findall(r"^ *(\w+) +(\S+)", page.locator(".explanation").first.inner_text(), re.MULTILINE))
    ending = page.locator(".motion .ending").first.inner_text()
    assert values(ending)[0] == pytest.approx(float(told["end_time"]), rel=1e-3)
    page.get_by_role("button", name="no losses").click()
    page.locator(f"{SHOWN}:not(.lossy)").wait_for()
    assert slider.get_attribute("aria-valuetext") == "none"
    assert page.locator(".plot.potential .curve.potential").count() == 1


def test_a_mass_is_asked_for_where_it_matters(opened):
    """The mass slider is shown only with viscous friction or air."""
    page = opened()
    choose(page)
    page.locator("details.laws summary").first.click()
    mass = page.get_by_role("slider", name="mass")
    assert mass.count() == 0
    page.get_by_role("combobox", name="air").select_option("bildsten")
    mass.wait_for()


def test_words_explain_the_start(opened):
    """The text is that of `eulerdisk explain` and is requested when opened."""
    page = opened()
    choose(page)
    page.locator("details.words summary").first.click()
    page.locator(".explanation", has_text="verdict").first.wait_for()
    assert "because" in page.locator(".explanation").first.inner_text()


def test_start_and_words_follow_a_slider(opened):
    """With another gravity, the start keeps its scaled rates; its text follows, and its verdict stays."""
    page = opened("base=rolling&quantity=stability&a=0.02,3.7")
    page.locator(".motion .verdict", has_text=re.compile("^stable$")).wait_for()
    page.locator("details.words summary").first.click()
    page.locator(".explanation", has_text="9.81").first.wait_for()
    page.locator("#value-gravity").fill("30")
    page.keyboard.press("Enter")
    # 3.7 rad/s times the square root of 30/9.81
    page.locator(".explanation", has_text="6.4").first.wait_for()
    assert "9.81" not in page.locator(".explanation").first.inner_text()
    page.locator(".motion .verdict", has_text=re.compile("^stable$")).wait_for()
    page.locator(".explanation", has_text="because").first.wait_for()


def test_a_camera_that_was_dragged_is_in_the_address(opened):
    """The camera is written when the drag ends; then an arrow key turns it by six degrees."""
    page = opened()
    choose(page, 0.3, 0.3)
    canvas = page.locator(".stage canvas").first
    box = canvas.bounding_box()
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    assert "a.camera" not in page.url
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y + 10, steps=4)
    page.mouse.up()
    page.wait_for_url(re.compile(r"a\.camera="))
    dragged = entries(page)["a.camera"]
    canvas.focus()
    canvas.press("ArrowLeft")
    page.wait_for_function("before => !decodeURIComponent(location.hash).includes(before)", arg=dragged)
    first, second = (list(map(float, each.split(","))) for each in (dragged, entries(page)["a.camera"]))
    assert abs(second[0] - first[0]) == pytest.approx(math.radians(6.0), rel=1e-3)
    assert second[1:] == pytest.approx(first[1:], rel=1e-3)


@pytest.mark.release
def test_the_picture_follows_the_clock_the_keys_and_the_theme(opened):
    """The disk moves, keys turn and zoom the camera, and a light page has a light table."""
    page = opened(color_scheme="dark")
    choose(page, 0.3, 0.3)
    stage, canvas = page.locator(".stage").first, page.locator(".stage canvas").first
    pictures = [stage.screenshot()]
    for time in (0.7, 1.9):
        seek(page, time)
        pictures.append(stage.screenshot())
    canvas.focus()
    for key in ("ArrowLeft", "ArrowUp", "+"):
        canvas.press(key)
        pictures.append(stage.screenshot())
    corner = page.evaluate(CORNER)
    page.click("#theme")
    pictures.append(stage.screenshot())
    assert len(set(pictures)) == 7
    for theme in range(2):
        assert contrast(*page.evaluate(RIM_AND_TABLE)) > 4.5, theme
        page.click("#theme")
    canvas.press("0")
    page.wait_for_timeout(400)
    assert "a.camera" not in page.url
    assert max(corner) < 100 < min(page.evaluate(CORNER))


def values(text):
    """Return the numbers of a text, as written by page and files."""
    return [float(each.replace("\u2212", "-")) for each in re.findall(r"[-\u2212]?\d+(?:\.\d+)?", text)]


def test_an_exported_page_moves_its_disks(opened, tmp_path):
    """A page opened from disk computes numbers, motion, losses and text of the chosen start."""
    path = tmp_path / "page.html"
    words = {"roll_rate": "2:4:12", "tilt": "0.1deg:10deg:8:log", "alpha": 1.0}
    export(subject_of("rolling", words), path)
    page = opened(url=path.as_uri())
    choose(page, 0.71, 0.47)
    page.wait_for_timeout(400)
    panel = page.locator(".motion").first
    assert panel.locator(".plot svg path.curve").count() == 5
    assert panel.locator(".plot.potential .dot.turn").count() == 2
    assert re.search(r"\d s$", panel.locator(".ending").inner_text())
    assert page.evaluate(DRAWN, 0) > 100

    x, y = (float(each) for each in re.search(r"&a=([^,&]+),([^,&]+)", page.url).groups())
    cell = sweep.run("rolling", method="exact", progress=False, alpha=1.0, roll_rate=[y], tilt=[x]).squeeze()
    assert panel.locator(".verdict").inner_text() == ("undecided", "stable", "unstable")[int(cell.stability)]
    caption = page.locator("#motions .slot").first.locator("header p").inner_text()
    assert values(caption) == pytest.approx([math.degrees(x), y], rel=1e-5)
    panel.locator("details.words summary").click()
    told = panel.locator(".explanation", has_text="verdict").inner_text()
    (peak,) = re.findall(r"peak tilt +(\S+) deg", told)
    assert float(peak) == pytest.approx(math.degrees(float(cell.peak_tilt)), rel=1e-5)
    # the unperturbed boundary is at the square root of g / (3 R), for a hoop g / (4 R)
    (analytic,) = re.findall(r"roll rate (\S+) rad s\S+ +analytic", told)
    assert float(analytic) == pytest.approx(math.sqrt(9.81 / (4 * 0.5)), rel=1e-5)
    (predicted,) = re.findall(r"roll rate (\S+) rad s\S+ +predicted", told)
    assert float(predicted) > float(analytic)

    panel.locator("details.laws summary").click()
    slider = page.get_by_role("slider", name="contour friction").first
    for _ in range(7):
        slider.press("PageUp")
    page.locator(".motion.lossy.shown:not(.waiting)").wait_for()
    panel.locator(".ending", has_text="flat").wait_for()
    panel.locator(".explanation", has_text=re.compile(r"\blosses\b")).wait_for()


@pytest.mark.release
def test_an_exported_page_hides_what_is_not_its_own(opened, tmp_path):
    """The exported window has lines; with another gravity, or far outside, they are hidden with a note."""
    path = tmp_path / "page.html"
    export(subject_of("rolling", {}), path)
    page = opened(url=path.as_uri())
    assert page.locator("#map .line.measured").count() > 0
    assert page.locator("#criterion-kind option").count() <= 1
    page.locator("#value-gravity").fill("3")
    page.keyboard.press("Enter")
    page.locator("#notice", has_text=re.compile(r"\S")).wait_for()
    assert page.locator("#map .line.measured").count() == 0
    page.locator("#value-gravity").fill("9.81")
    page.keyboard.press("Enter")
    page.locator("#map .line.measured").first.wait_for(state="attached")
    page.locator("#notice").filter(has_not_text=re.compile(r"\S")).wait_for(state="attached")
    page.evaluate("location.hash = 'base=&with.criterion=departure:1deg'")
    page.locator("#notice", has_text="criterion").wait_for()


def test_without_webgl_the_curves_are_there(explorer, browser):
    """Without three-dimensional graphics, the page says so and has everything else."""
    context = browser.new_context(reduced_motion="reduce", viewport={"width": 1280, "height": 800})
    page = context.new_page()
    # no WebGL context, as on a machine without a driver
    page.add_init_script(
        """const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
          return kind.startsWith("webgl") ? null : get.call(this, kind, ...rest);
        };"""
    )
    watch = Watch(page, (explorer.url,))
    page.goto(explorer.url)
    page.wait_for_selector(COMPLETE)
    choose(page)
    assert "no WebGL" in page.locator(".stage").first.inner_text()
    assert page.locator(".plot svg path.curve").count() == 5
    context.close()
    # three.js logs that it found no context
    assert all("WebGL" in problem for problem in watch.problems)


def test_a_plot_keeps_the_peaks_of_its_curves(opened):
    """With ten thousand samples on three hundred pixels, a single outlier is drawn, on either side."""
    drawn = opened().evaluate(
        """async () => {
            const { Plot } = await import("eulerdisk/motion/plot");
            const element = document.createElement("div");
            Object.assign(element.style, { width: "300px", height: "200px", position: "absolute" });
            document.body.append(element);
            const x = Float64Array.from({ length: 10000 }, (_, i) => i);
            const y = new Float64Array(10000);
            [y[4003], y[6007]] = [1, -1];
            const plot = new Plot(element);
            const labels = { title: "", xLabel: "", yLabel: "" };
            const [low, high] = [-1, 1];
            const curves = [{ x, y, kind: "tilt" }];
            plot.show({ ...labels, x: { low: 0, high: 9999 }, y: { low, high }, curves });
            const d = element.querySelector("path.curve").getAttribute("d");
            const frame = element.querySelector("svg.inside");
            element.remove();
            return [d, frame.getAttribute("y"), frame.getAttribute("height")];
        }"""
    )
    heights = [float(each.split(",")[1]) for each in drawn[0].replace("L", "M").split("M")[1:]]
    top, height = map(float, drawn[1:])
    assert (min(heights), max(heights)) == pytest.approx((top, top + height), abs=0.01)
    assert np.median(heights) == pytest.approx(top + height / 2, abs=0.01)


@pytest.mark.release
def test_a_ring_is_as_wide_as_its_inertia_says(opened):
    """A ring from a R to R has alpha = (1 + a^2)/2: a disk is full, and a hoop has a tenth of the radius."""
    alphas = [0.3, 0.5, 0.625, 0.75, 0.9, 1.0]
    found = opened().evaluate(
        """async alphas => {
            const { diskBody } = await import("eulerdisk/motion/furniture");
            return alphas.map((alpha) => {
                const { innerRadius, outerRadius } = diskBody(2, alpha, "#000000").children[0].geometry.parameters;
                return [innerRadius, outerRadius];
            });
        }""",
        alphas,
    )
    inner = [min(math.sqrt(max(2.0 * alpha - 1.0, 0.0)), 0.9) for alpha in alphas]
    assert found == [pytest.approx([2.0 * each, 2.0]) for each in inner]


def test_horizontal_lines_of_a_plot_are_as_long_as_its_curves(opened):
    """The lines of turning points and energy extend over the whole plot."""
    page = opened()
    choose(page, 0.3, 0.3)
    ends = page.locator(".plot svg").first.evaluate(
        """svg => [...svg.querySelectorAll(".line, .curve")].map((each) => {
            const { x, width } = each.getBBox();
            return [each.classList.contains("line"), x, x + width];
        })"""
    )
    lines = [[low, high] for is_line, low, high in ends if is_line]
    (curve,) = ([low, high] for is_line, low, high in ends if not is_line)
    assert len(lines) > 1
    assert all(line == pytest.approx(curve, abs=1.0) for line in lines)


def test_squares_of_the_table_have_the_length_that_is_told(opened):
    """One picture is repeated every square length, so the table can move by whole squares unnoticed."""
    found = opened().evaluate(
        """async () => {
            const { tableOfSquares } = await import("eulerdisk/motion/furniture");
            const table = tableOfSquares(0.05, "#ffffff", "#000000");
            const { width, height } = table.geometry.parameters;
            return [width / table.material.map.repeat.x, height / table.material.map.repeat.y];
        }"""
    )
    assert found == pytest.approx([0.05, 0.05])
