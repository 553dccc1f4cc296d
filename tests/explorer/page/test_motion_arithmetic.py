"""The page's computations for a motion: clock, interpolation, curves, digits, and shapes of the disk."""

import numpy as np
import pytest


def test_a_motion_goes_on_where_it_was_paused(node):
    """A pause does not count as time of the motion, and a hidden page loses at most one frame."""
    times = node.evaluate(
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


def test_between_samples_a_motion_is_smooth(node):
    """A parabola is exact between uneven samples; at both ends and beyond, the motion stays at its samples."""
    times = [0.0, 0.1, 0.4, 0.5, 1.1, 1.3, 2.0]
    values = [3.0 * t * t - 2.0 * t + 1.0 for t in times]
    asked = [0.15, 0.3, 0.45, 0.7, 1.0, 1.2]
    found = node.evaluate(
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


def test_the_trail_ends_at_the_disk(node):
    """The strong part of the path ends at the current time, and its center line passes through the samples."""
    times = [0.0, 0.5, 1.0, 2.0]
    found = node.evaluate(
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


def test_wells_and_barriers_are_told_to_five_digits(node):
    """The labels of dots have the curve's accurate digits and the displayed unit."""
    labels = node.evaluate(
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
