"""What the page counts for a motion: its clock, the values between samples, curves, digits, and shapes of the disk."""

import math

import numpy as np
import pytest


@pytest.fixture(scope="module")
def quiet(browser, explorer):
    """Open one page for all tests of this module: they only call its modules."""
    context = browser.new_context()
    page = context.new_page()
    page.goto(explorer.url)
    page.wait_for_selector("#map[data-lane=fine]")
    yield page
    context.close()


def test_a_motion_goes_on_where_it_was_paused(quiet):
    """The time of a pause is no time of the motion, and a page that was hidden loses no more than one picture."""
    times = quiet.evaluate(
        """async () => {
            const { Clock } = await import("eulerdisk/motion/clock");
            const frames = [];
            const [ask, cancel] = [window.requestAnimationFrame, window.cancelAnimationFrame];
            window.requestAnimationFrame = (deed) => frames.push(deed);
            window.cancelAnimationFrame = () => { frames.length = 0; };
            const times = [];
            try {
                const clock = new Clock();
                // shown in its own time
                clock.enter({}, 9);
                const frame = (now) => { frames.shift()(now); times.push(clock.time); };
                clock.play();
                for (const now of [1000, 1050, 1090]) frame(now);
                clock.pause();
                clock.play();
                for (const now of [60000, 60040, 70000]) frame(now);
            } finally {
                Object.assign(window, { requestAnimationFrame: ask, cancelAnimationFrame: cancel });
            }
            return times;
        }"""
    )
    assert times == pytest.approx([0.0, 0.05, 0.09, 0.09, 0.13, 0.23], abs=1e-12)


def test_between_samples_a_motion_is_smooth(quiet):
    """A parabola is met exactly between samples at uneven times; at both ends, and beyond, it stays at its samples."""
    times = [0.0, 0.1, 0.4, 0.5, 1.1, 1.3, 2.0]
    values = [3.0 * t * t - 2.0 * t + 1.0 for t in times]
    asked = [0.15, 0.3, 0.45, 0.7, 1.0, 1.2]
    found = quiet.evaluate(
        """async ([times, values, asked]) => {
            const { Samples } = await import("eulerdisk/motion/samples");
            const arrays = { time: Float64Array.from(times), tilt: Float64Array.from(values) };
            const samples = new Samples({ head: {}, arrays });
            return asked.map((time) => samples.at("tilt", time));
        }""",
        [times, values, [*asked, -1.0, 0.0, 2.0, 9.0]],
    )
    expected = [3.0 * t * t - 2.0 * t + 1.0 for t in asked]
    assert found == pytest.approx([*expected, values[0], values[0], values[-1], values[-1]], abs=1e-12)


def test_a_plot_keeps_the_peaks_of_its_curves(quiet):
    """Of ten thousand samples on three hundred pixels the single one that stands out is drawn, to either side."""
    drawn = quiet.evaluate(
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


def test_a_ring_is_as_wide_as_its_inertia_says(quiet):
    """A ring from a R to R has alpha = (1 + a^2)/2: a disk is full, and a hoop is drawn with a tenth of its radius."""
    alphas = [0.3, 0.5, 0.625, 0.75, 0.9, 1.0]
    found = quiet.evaluate(
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


def test_the_trail_ends_at_the_disk(quiet):
    """Of the path as much is strong as has been passed, and its middle goes through the samples."""
    times = [0.0, 0.5, 1.0, 2.0]
    found = quiet.evaluate(
        """async times => {
            const { Trail } = await import("eulerdisk/motion/furniture");
            const [x, y] = [times, times.map((time) => time * time)].map((each) => Float64Array.from(each));
            const trail = new Trail(Float64Array.from(times), x, y, 1, "#ffffff");
            const counts = [-1, 0, 0.4, 0.5, 1.7, 2, 3].map((time) => {
                trail.setTime(time);
                return trail.passed.geometry.drawRange.count / 6;
            });
            return [counts, Array.from(trail.passed.geometry.getAttribute("position").array)];
        }""",
        times,
    )
    assert found[0] == [0, 0, 0, 1, 2, 3, 3]
    corners = np.reshape(found[1], (4, 2, 3))
    assert np.allclose(corners.mean(axis=1)[:, :2], [[t, t * t] for t in times], atol=1e-6)
    assert np.allclose(np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1), 0.035, atol=1e-6)


def test_wells_and_barriers_are_told_to_five_digits(quiet):
    """The labels of dots have the digits that the curve is right to, and the unit that people read."""
    labels = quiet.evaluate(
        """async () => {
            const { potentialFigure } = await import("eulerdisk/motion/figures");
            const quantity = { label: "tilt", unit: "deg", factor: 180 / Math.PI };
            const head = {
                quantities: { tilt: quantity, potential: { label: "", unit: "", factor: 1 } }, turns: [],
            };
            const potential = {
                tilt: Float64Array.of(-1, 0, 1), excess: Float64Array.of(1, 0, 1),
                wells: [[0.0123456789, -0.1]], barriers: [[-0.7654321, 0.2]],
            };
            return potentialFigure({ head, potential }).dots.map(({ label }) => label);
        }"""
    )
    assert labels == ["well at 0.70736 deg", "barrier at \u221243.856 deg"]
