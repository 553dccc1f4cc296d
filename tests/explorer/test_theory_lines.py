"""Theory lines of the circling disk, whose two edges meet, are complete and agree with the closed form."""

from itertools import product

import numpy as np
import pytest
from cases import case
from explorer_client import side
from scipy.optimize import brentq

from sweep.explorer.about import base_of, sides
from sweep.explorer.lines import lines as all_lines
from sweep.explorer.lines import theory
from sweep.explorer.view import View, preset
from sweep.model.disk import theory as disk_theory
from sweep.request.spec import SweepSpec

GRAVITY, RADIUS = 9.81, 0.5


def polynomial(tilt, alpha, kick_over_limit):
    """Return A, B, D of A P^2 + B P + D = 0 for the squared precession rate P at the edge.

    The condition that a steady motion oscillates with the squared frequency (kick/limit)^2, as in
    docs/theory.md.
    """
    cos, sin = np.cos(tilt), np.sin(tilt)
    a = GRAVITY * sin / ((1 + alpha) * RADIUS * cos)
    b = (2 + alpha) * sin / (2 * (1 + alpha))
    squared = (2 + alpha) - (6 + 2 * alpha) * sin * b + 4 * (1 + alpha) * b * b
    linear = (
        -2 * GRAVITY / RADIUS * cos
        - (2 + alpha) * kick_over_limit**2
        - (6 + 2 * alpha) * sin * a
        + 8 * (1 + alpha) * a * b
    )
    return squared, linear, 4 * (1 + alpha) * a * a


def top(alpha, kick_over_limit=0.0):
    """Return the tilt and the rate at which both edges meet, where the quadratic has one root."""

    def discriminant(tilt):
        squared, linear, constant = polynomial(tilt, alpha, kick_over_limit)
        return linear**2 - 4 * squared * constant

    tilt = brentq(discriminant, 0.01, 1.4, xtol=1e-15)
    squared, linear, _ = polynomial(tilt, alpha, kick_over_limit)
    return tilt, np.sqrt(-linear / (2 * squared))


def lines(x, y, **words):
    """Return the polylines of each theory line in a window of the circling disk, arrays of shape (2, n)."""
    view = {"base": "circling", "words": words, "x": x, "y": y}
    found = theory(View.read(view, None))
    return {line["name"]: [np.array(points).T for points in line["points"]] for line in found}


def places(curve, x, y):
    """Return the points of a line in the window, -1 and 1 at its borders."""
    return (curve - [[x["centre"]], [y["centre"]]]) / [[x["half"]], [y["half"]]]


def inside(at):
    """Return which points are in the window."""
    return (np.abs(at) <= 1.0).all(axis=0)


def excess(rates, tilts, alpha):
    """Return the quadratic of the analytic edge at some starts."""
    squared, linear, constant = polynomial(tilts, alpha, 0.0)
    return squared * rates**4 + linear * rates**2 + constant


def test_the_line_has_no_gap_where_both_edges_meet():
    """In a window around the top, the analytic line is a single curve from border to border."""
    depths, each_way = (0.3, 1e-2, 1e-4, 1e-7, 1e-10), (False, True)
    for depth, alpha, turned, level in product(depths, (0.5, 1.0), each_way, each_way):
        with case(depth, alpha, turned, level):
            tilt, rate = top(alpha)
            # the first window is level at the top; the second is so much wider than high that the line bends
            wide = rate * depth if level else 0.5 * rate * depth**0.5
            x, y = side("precession_rate", rate, wide), side("tilt", tilt, tilt * depth)
            (found,) = lines(*((y, x) if turned else (x, y)), alpha=alpha)["analytic"]
            if turned:
                found = found[::-1]
            at = places(found, x, y)
            seen = at[:, inside(at)]
            steps = np.abs(np.diff(seen, axis=1)).max(axis=0)
            # a screen has 1000 pixels from -1 to 1, so points are a few pixels apart
            assert steps.max() < 0.1
            assert seen[1].max() == pytest.approx(0.0, abs=1e-3 + 2e-15 / depth)
            assert seen[0].min() < -0.9
            assert seen[0].max() > 0.9
            # every point solves the quadratic within a pixel or rounding
            rates, tilts = found[:, inside(at)]
            off = excess(rates, tilts, alpha)
            slope = np.abs(excess(rates, tilts * (1 + 1e-7), alpha) - off) / 1e-7 / tilts
            assert (np.abs(off) <= slope * (2e-4 * y["half"] + 4e-15)).all()


def rate_at(level, segment):
    """Return the rate at which a segment of a line has a tilt."""
    rates, tilts = segment[:, np.argsort(segment[1])]
    return np.interp(level, tilts, rates)


def test_both_lines_are_whole_in_any_window():
    """Both lines are closed at their tops, also for negative rates, and both edges exist."""
    for window_x in [(2.505, 2.495), (2.5, 0.7), (0.0, 5.0), (-2.5, 2.4)]:
        with case(window_x):
            x, y = side("precession_rate", *window_x), side("tilt", 0.264, 0.2596)
            kick = 0.01
            found = lines(x, y, tilt_rate=kick, criterion="departure:5deg")
            signs = [sign for sign in (-1, 1) if sign * window_x[0] + window_x[1] > 1.0]
            for name, over in (("analytic", 0.0), ("predicted", kick / np.radians(5.0))):
                tilt, rate = top(0.5, over)
                curves = found[name]
                assert len(curves) == len(signs), name
                for curve, sign in zip(curves, signs, strict=True):
                    assert curve[1].max() == pytest.approx(tilt, abs=1e-4 * y["half"])
                    assert curve[0][curve[1].argmax()] == pytest.approx(sign * rate, rel=2e-2)
                    # at a tilt below the top, it has the slow and the fast rate
                    level = 0.8 * tilt
                    squared, linear, constant = polynomial(level, 0.5, over)
                    expected = np.sqrt(np.roots([squared, linear, constant]).real)
                    expected = sorted(sign * each for each in expected)
                    crossed = np.flatnonzero(np.diff(np.sign(curve[1] - level)))
                    low, high = window_x[0] - window_x[1], window_x[0] + window_x[1]
                    met = sorted(rate_at(level, curve[:, i : i + 2]) for i in crossed)
                    met = [each for each in met if low < each < high]
                    # half a pixel of a thousand
                    inside_it = [each for each in expected if low < each < high]
                    assert np.allclose(met, inside_it, rtol=0.0, atol=1e-3 * window_x[1])


def test_an_edge_that_runs_along_the_rows_is_met_by_the_columns():
    """If a line is almost vertical, its points are at most a tenth of the window apart, at every depth."""
    for base in ["rolling", "spinning"]:
        with case(base):
            first = base_of(base, preset(base))["view"]
            view = View.read({**first, "words": {"criterion": "departure:5deg"}}, None)
            curves = {line["name"]: line["points"] for line in theory(view)}["predicted"]
            curve = np.array(curves[0]).T
            index = np.argmin(np.abs(curve[1] - view.y.ends()[1]))
            x, y = curve[:, index]
            for depth in (1e-1, 1e-3, 1e-6):
                sides = {"x": side("tilt", x, x * depth), "y": side(first["y"]["name"], y, 0.3 * y)}
                found = theory(View.read({**first, **sides}, None))
                (line,) = [
                    np.array(points).T
                    for each in found
                    if each["name"] == "predicted"
                    for points in each["points"]
                ]
                at = places(line, sides["x"], sides["y"])
                seen = at[:, inside(at)]
                assert np.abs(np.diff(seen, axis=1)).max() < 0.1


@pytest.mark.parametrize("first", [True, False])
def test_an_edge_that_some_rows_lack_is_drawn_in_the_others(monkeypatch, first):
    """Theory omits an edge that none of the requested rows has; it is drawn in the other rows."""
    ordinary = disk_theory.lines
    middle = 0.3

    def half(spec, axis, starts):
        rows = starts["tilt"]
        known = rows < middle if first else rows > middle
        return {
            name: tuple(np.where(known, each, np.nan) for each in pair)
            for name, pair in ordinary(spec, axis, starts).items()
            if known.any()
        }

    x, y = side("precession_rate", 4.0, 4.0), side("tilt", middle, 0.2)
    whole = np.concatenate([curve[1] for curve in lines(x, y)["analytic"]])
    expected = whole[whole < middle] if first else whole[whole > middle]
    monkeypatch.setattr(disk_theory, "lines", half)
    found = np.concatenate([curve[1] for curve in lines(x, y)["analytic"]])
    assert found.size > 0.8 * expected.size
    assert (found.min(), found.max()) == pytest.approx((expected.min(), expected.max()), abs=2 * 0.4 / 256)


def test_the_line_of_a_system_is_drawn():
    """Kapitza's pendulum is stable if the shaking is faster than sqrt(2 g l) over the amplitude."""
    spec = SweepSpec.preset("kapitza")
    (line,) = all_lines(View.read({"base": "", "words": {}, **sides(spec)}, spec), None)
    rates = [rate for points in line["points"] for _, rate in points]
    assert line["name"] == "analytic"
    assert np.allclose(rates, np.sqrt(2.0 * 9.81 * 0.2) / 0.02, rtol=1e-6)
    assert min(angle for points in line["points"] for angle, _ in points) < np.radians(2.0)
