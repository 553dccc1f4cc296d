import json

import numpy as np
import pytest
from cases import case
from explorer_client import ROLLING, about, ask, post, side

import sweep
from sweep.engine.compute import compute
from sweep.explorer.view import View


def view_of(url, base):
    """Return the initial view of a preset."""
    bases = json.loads(ask(url, "about").body)["bases"]
    return next(each["view"] for each in bases if each["name"] == base)


def lines(url, view):
    """Return the polylines of every line by name, each an array of shape (2, n)."""
    found = post(url, "lines", view=view)["lines"]
    return {line["name"]: [np.array(points).T for points in line["points"]] for line in found}


def test_the_analytic_line_is_that_of_theory(url):
    """The line of a vanishing perturbation is at the critical rate of the upright disk, for every tilt."""
    for base, square in [("rolling", 9.81 / (3 * 0.5)), ("spinning", 4 * 9.81 / (5 * 0.5))]:
        with case(base, square):
            (found,) = lines(url, view_of(url, base))["analytic"]
            assert np.allclose(found[1], np.sqrt(square), rtol=1e-14)
            assert found[0].min() < 2e-5
            assert found[0].max() > 0.08


@pytest.mark.slow_lane
def test_the_measured_line_parts_stable_from_unstable(url):
    """Exact cells slightly on either side of the measured line have different verdicts, all along it."""
    for base in ["rolling", "spinning", "circling"]:
        with case(base):
            view = view_of(url, base)
            (found,) = lines(url, view)["measured"]
            assert found.shape[1] > 80
            x, y = (view[name] for name in "xy")
            chosen = found[:, 3:-3:7]
            # a thousandth of the window along each side, in both directions
            steps = [
                np.diff(view_ends(side))[0] / 1000 if side["scale"] == "linear" else 0.0 for side in (x, y)
            ]
            factors = [np.exp(side["half"] / 500) if side["scale"] == "log" else 1.0 for side in (x, y)]
            for here in chosen.T:
                codes = set()
                for k, sign in ((0, -1), (0, 1), (1, -1), (1, 1)):
                    there = here.copy()
                    there[k] = there[k] * factors[k] ** sign + sign * steps[k]
                    given = {x["name"]: [there[0]], y["name"]: [there[1]]}
                    codes.add(int(sweep.run(base, method="exact", **given)["stability"].item()))
                assert codes == {1, 2}


def view_ends(side):
    """Return the ends of one side, in SI."""
    ends = np.array([side["centre"] - side["half"], side["centre"] + side["half"]])
    return np.exp(ends) if side["scale"] == "log" else ends


def test_the_measured_line_is_the_boundary_of_an_atlas(url):
    """The line agrees with an atlas's refined boundary to a pixel of a screen of 4096."""
    view = {**ROLLING, "x": side("roll_rate", 2.7, 0.3), "y": side("tilt", 0.02, 0.015)}
    (found,) = lines(url, view)["measured"]
    atlas = sweep.run(
        "rolling", method="exact", roll_rate="2.4:3:60", tilt="0.005:0.035:40", boundary="refined:1e-9"
    )
    edge = atlas.eulerdisk.boundary()["measured"]
    known = edge.where(np.isfinite(edge), drop=True)
    order = np.argsort(found[1])
    interpolated = np.interp(known["tilt"].values, found[1][order], found[0][order])
    inside = (known["tilt"] > found[1].min()) & (known["tilt"] < found[1].max())
    assert inside.sum() > 8
    assert np.abs(interpolated - known.values)[inside].max() < 0.6 / 4096


def test_the_predicted_line_follows_the_criterion(url):
    """The predicted line equals that of an atlas with the criterion; one without theory has no line."""
    for criterion in ("departure:5deg", "departure:2deg", "amplification:30"):
        view = {**ROLLING, "words": {"criterion": criterion}}
        (found,) = lines(url, view)["predicted"]
        rates, tilts = found[:, np.argsort(found[1])]
        atlas = sweep.run(
            "rolling", criterion=criterion, method="exact", roll_rate="1:9:3", tilt=tilts.tolist()
        )
        expected = atlas.eulerdisk.boundary()["predicted"].values
        # a pixel of a window that is 2.75 rad/s wide
        assert np.allclose(rates, expected, rtol=0.0, atol=2e-3)
    view = {**ROLLING, "words": {"criterion": "peak_tilt > 10deg"}}
    assert lines(url, view).keys() == {"analytic", "measured"}


def test_lines_lie_across_where_the_control_is_upward(url):
    """With a vertical rate and a horizontal tilt, the lines are the same with axes exchanged."""
    plain = lines(url, ROLLING)
    turned = lines(url, {**ROLLING, "x": ROLLING["y"], "y": ROLLING["x"]})
    assert np.array_equal(turned["analytic"][0], plain["analytic"][0][::-1])
    assert np.array_equal(turned["predicted"][0], plain["predicted"][0][::-1])


def test_a_window_on_both_sides_of_zero_has_both_edges(url):
    """If a rate changes sign, the band of unstable starts has two analytic edges, one on each side."""
    view = {**ROLLING, "x": side("roll_rate", 0.5, 5.0)}
    found = lines(url, view)["analytic"]
    assert sorted(round(line[0][0], 6) for line in found) == [-2.557342, 2.557342]


def test_a_window_away_from_the_boundary_has_no_line(url):
    """Far above the boundary, or without a control axis, there is no line."""
    small = side("tilt", 0.01, 0.005)
    assert lines(url, {**ROLLING, "x": side("roll_rate", 50.0, 1.0), "y": small}) == {}
    view = {**ROLLING, "words": {"roll_rate": 2.7}, "x": side("alpha", 0.6, 0.35)}
    assert lines(url, view).keys() == {"measured"}


def test_the_measured_line_is_found_at_every_depth(url):
    """Zooming in ten steps to 1e-10 of its place, the line still crosses the window."""
    x, y = 2.55, 0.002
    for depth in range(-1, -11, -1):
        sides = side("roll_rate", x, x * 10.0**depth), side("tilt", y, y * 10.0**depth)
        view = {**ROLLING, "x": sides[0], "y": sides[1]}
        # at great depth, some cells next to it are within their errors of the limit and interrupt it
        found = max(lines(url, view)["measured"], key=lambda line: line.shape[1])
        x, y = found[:, found.shape[1] // 2]
        assert abs(x - sides[0]["centre"]) <= sides[0]["half"]
        read = View.read(view, None)
        places = np.meshgrid(read.x.values(40), read.y.values(40))
        found = compute(read.live, read.starts(*(each.ravel() for each in places)), verdicts_only=True)
        assert {1, 2} <= set(found["stability"])


def test_the_boundary_of_an_island_is_closed(url):
    """For a fast disk, the stable kicks and tilts are an island, whose measured line is closed."""
    view = {"base": "rolling", "words": {"roll_rate": 4.0, "criterion": "peak_tilt > 5deg"}}
    view |= {"x": side("tilt_rate", 0.0, 0.8), "y": side("tilt", 0.0, 0.2)}
    (found,) = lines(url, view)["measured"]
    assert np.array_equal(found[:, 0], found[:, -1])
    assert found.shape[1] > 20
    assert (found.min(axis=1) < 0.0).all()
    assert (found.max(axis=1) > 0.0).all()


def test_lines_end_where_starts_end(url):
    """A window wider than a parameter's domain has lines only inside; one outside has none."""
    (measured,) = [line for line in lines_upward(url, "tilt", 0.0, 100.0) if line["name"] == "measured"]
    tilts = [y for part in measured["points"] for _, y in part]
    assert tilts
    assert max(map(abs, tilts)) < np.pi / 2
    assert lines_upward(url, "tilt", 5.0, 0.4) == []


def lines_upward(url, *y):
    """Return the lines of the rolling disk in a window with another vertical axis."""
    return post(url, "lines", view={**ROLLING, "y": side(*y)})["lines"]


def test_the_ends_of_parameters_are_told(url):
    """The page gets each parameter's domain, to the last double of an end, and null if there is no end."""
    ends = {each["name"]: (each["least"], each["most"]) for each in about(url)["parameters"]}
    upright = np.nextafter(np.pi / 2, 0.0)
    assert ends["tilt"] == (-upright, upright)
    assert ends["roll_rate"] == (None, None)
    assert ends["alpha"][1] == 1.0
    assert 0.0 < ends["alpha"][0] < 1e-30
    assert 0.0 < ends["radius"][0] < 1e-30
