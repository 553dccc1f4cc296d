"""The page's arithmetic in Node compared with Python: doubles, addresses, clipping, nearest cells."""

import math
import re
from itertools import pairwise
from pathlib import Path
from random import Random

import numpy as np
import pytest
from messages import assert_facts

import sweep
from sweep.explorer.about import sides
from sweep.explorer.plan import plan
from sweep.explorer.view import View
from sweep.request.spec import SweepSpec

random = Random(3)

SPEC = sweep.SweepSpec.preset("rolling", method="exact")

CHECKOUT = Path(__file__).resolve().parents[3]

#: Range of binary exponents of doubles on axes.
EXPONENTS = (-300, 300)


def random_doubles(count):
    """Return doubles of all magnitudes and signs, and powers of two with their neighbors."""
    found = [
        random.choice((-1, 1)) * random.random() * 2.0 ** random.randint(*EXPONENTS) for _ in range(count)
    ]
    powers = [2.0**exponent for exponent in range(-40, 41)]
    near = [math.nextafter(power, side) for power in powers for side in (0.0, math.inf)]
    return [*found, *powers, *near]


def test_unit_in_the_last_place(node):
    """ulp() equals Python's for doubles of every magnitude."""
    values = random_doubles(500)
    found = node.evaluate(
        "async values => { const { ulp } = await import('eulerdisk/axis_window'); return values.map(ulp) }",
        values,
    )
    assert [float(each) for each in found] == [math.ulp(value) for value in values]


def test_addresses_are_read_back_to_the_bit(node):
    """All doubles of a state are read back from its address unchanged."""
    values = [value for value in random_doubles(300) if value]
    differing = node.evaluate(
        """async values => {
            const [{ fragmentOf, stateOf }, { firstState }] = await Promise.all([
                import("eulerdisk/address"), import("eulerdisk/state")]);
            const about = await (await fetch("./about")).json();
            const first = firstState(about);
            return values.filter((value, each) => {
                const other = values[values.length - 1 - each];
                // a number of an axis is at most 1e12, in its address as well
                const [centre, half] = [value, Math.abs(other)].map((x) => Math.abs(x) > 1e12 ? 1 / x : x);
                const x = { ...first.view.x, centre, half };
                const view = { ...first.view, x, words: { alpha: other, criterion: "departure:1.5deg" } };
                // ends of colours are two, the lower one first
                const range = other < value ? [other, value] : other > value ? [value, other] : null;
                const state = { ...first, view, points: [{ x: value, y: other }, null], range };
                return JSON.stringify(stateOf(fragmentOf(state), about)) !== JSON.stringify(state);
            });
        }""",
        values,
    )
    assert differing == []


def test_a_pair_is_read_however_large_its_numbers_are(node):
    """Two numbers are a point even if their sum overflows."""
    found = node.evaluate(
        """async () => {
            const { stateOf } = await import("eulerdisk/address");
            const about = await (await fetch("./about")).json();
            return stateOf("a=1e308,1.5e308", about).points[0];
        }"""
    )
    assert found == {"x": 1e308, "y": 1.5e308}


def test_zoom_keeps_the_value_at_its_place(node):
    """Repeated zooming about a place moves its value by less than a thousandth of a pixel."""
    for _ in range(20):
        place, centre = random.uniform(-1, 1), random.uniform(-5, 5)
        found = node.evaluate(
            """async ([centre, place]) => {
                const { zoomed } = await import("eulerdisk/axis_window");
                let axis = { name: "x", centre, half: 1, scale: "linear" };
                for (let each = 0; each < 200; each += 1) axis = zoomed(axis, 0.85, place, { least: 1e-11, most: 9 });
                return [axis.centre, axis.half];
            }""",
            [centre, place],
        )
        assert found[1] == 1e-11
        assert found[0] + found[1] * place == pytest.approx(centre + place, rel=0, abs=1e-11 * 2 / 1000 * 10)


@pytest.mark.parametrize("scale", ["linear", "log"])
def test_windows_end_where_numbers_do(node, scale):
    """For any address, both ends of an axis are finite, and nonzero if it is logarithmic."""
    found = node.evaluate(
        """async ([scale, numbers]) => {
            const [{ withinDomain, firstState }, { ends }] = await Promise.all([
                import("eulerdisk/state"), import("eulerdisk/axis_window")]);
            const about = await (await fetch("./about")).json();
            const { view } = firstState(about);
            return numbers.map(([centre, half]) => {
                const x = { name: "gravity", centre, half, scale };
                return ends(withinDomain(about, { ...view, x }).x);
            });
        }""",
        [scale, [[0.0, 1e4], [1e5, 3.0], [-1e5, 3.0], [386.6, 513.5], [1e305, 1.7e308], [-9.9, 1e308]]],
    )
    assert all(math.isfinite(low) and math.isfinite(high) and 0.0 <= low < high for low, high in found)
    if scale == "log":
        assert all(low > 0.0 for low, _ in found)


def test_zoom_out_ends(node):
    """For a parameter that is not an axis of the base, the slider limits zooming out."""
    half = node.evaluate(
        """async () => {
            const { halfOfRange, firstState } = await import("eulerdisk/state");
            const about = await (await fetch("./about")).json();
            const { view } = firstState(about);
            const wide = { ...view, x: { name: "gravity", centre: 0, half: 500, scale: "log" } };
            return halfOfRange(about, wide, "x");
        }"""
    )
    # the slider of gravity goes from 0.1 to 30
    assert half == pytest.approx(math.log(300.0) / 2.0)


def inside(point, box):
    """Return True if a point is in a box, up to rounding."""
    return box[0] - 1e-9 <= point[0] <= box[2] + 1e-9 and box[1] - 1e-9 <= point[1] <= box[3] + 1e-9


def test_clipping_keeps_what_is_inside(node):
    """Points of a polyline inside a box are on its clipped pieces, which stay in the box."""
    box = [0.0, 0.0, 10.0, 6.0]
    for scale in (1.0, 10.0, 1e9):
        points = [[random.uniform(-scale, scale + 10), random.uniform(-scale, scale + 6)] for _ in range(30)]
        pieces = node.evaluate(
            """async ([points, [left, top, right, bottom]]) => {
                const { clipped } = await import("eulerdisk/overlay");
                return clipped(points, { left, top, right, bottom });
            }""",
            [points, box],
        )
        assert all(inside(point, box) for piece in pieces for point in piece)
        length = sum(math.dist(*pair) for piece in pieces for pair in pairwise(piece))
        # the length inside, measured in small steps along each segment
        steps = np.linspace(0.0, 1.0, 200_001)
        expected = 0.0
        for (x0, y0), (x1, y1) in pairwise(points):
            x, y = x0 + steps * (x1 - x0), y0 + steps * (y1 - y0)
            share = np.mean((x >= box[0]) & (x <= box[2]) & (y >= box[1]) & (y <= box[3]))
            expected += share * math.hypot(x1 - x0, y1 - y0)
        if scale < 1e6:
            assert length == pytest.approx(expected, rel=2e-3, abs=0.02)


@pytest.mark.parametrize("falling", [False, True])
def test_pixels_show_the_nearest_cell(node, falling):
    """A place has the nearest cell, or none if it is more than half a cell outside."""
    places = sorted(random.uniform(0, 10) for _ in range(40))
    ordered = places[::-1] if falling else places
    wanted = [random.uniform(-1, 11) for _ in range(300)]
    found = node.evaluate(
        """async ([places, wanted]) => {
            const { nearest } = await import("eulerdisk/stored_cells");
            return wanted.map((each) => nearest(places, each));
        }""",
        [ordered, wanted],
    )
    array = np.array(ordered)
    first, last = (places[1] - places[0]) / 2, (places[-1] - places[-2]) / 2
    for value, index in zip(wanted, found, strict=True):
        outside = value < places[0] - first or value > places[-1] + last
        assert index == (-1 if outside else int(np.abs(array - value).argmin()))


def test_colours_are_those_of_the_figures(node):
    """Numbers and flags have the figures' colors, light for small numbers, to 4 of 255 steps."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex, to_rgb

    from sweep.figures.disk import losses_map, regimes
    from sweep.figures.shade import _PART, COLOURS
    from sweep.model.lossy_disk.tables import LOSSES

    shares = [each / 200 for each in range(201)]
    found = node.evaluate(
        "async shares => { const { shade } = await import('eulerdisk/colours'); return shares.map(shade) }",
        shares,
    )
    exact = 255 * np.array([COLOURS(share)[:3] for share in shares])
    assert np.abs(np.array(found) - exact).max() <= 4.0
    painted = node.evaluate(
        """async () => {
            const { flagColour } = await import("eulerdisk/colours");
            const flags = Object.fromEntries([0, 1, 2, 3, 4, 5].map((code) => [code, ""]));
            const codes = Object.keys(flags).map(Number);
            const of = (name) => codes.map((code) => flagColour({ name, flags }, code));
            return { regime: of("regime"), losses: of("largest_loss"), other: of("other") };
        }"""
    )
    assert painted["regime"][:4] == [to_hex(each) for each in regimes._COLOURS]
    laws = [to_hex(losses_map.COLOURS[measure]) for _, measure in LOSSES.values()]
    assert painted["losses"] == [to_hex(losses_map._NONE), *laws]
    others = np.array([to_rgb(each) for each in painted["other"]])
    assert np.abs(others - colormaps["viridis_r"](np.linspace(0.0, _PART, 6))[:, :3]).max() <= 4.0 / 255.0
    # the curves of a motion have these colors, too
    sheet = (CHECKOUT / "sweep/explorer/page/motion/motion.css").read_text(encoding="utf-8")
    names = [measure for _, measure in LOSSES.values()]
    assert [re.findall(rf"\.{name} {{\s*--kind: (#\w+);", sheet) for name in names] == [
        [each] for each in laws
    ]


def test_colours_are_spread_as_in_figures(node, rng):
    """The page has equal steps of the value or its logarithm from end to end, like a figure."""
    from matplotlib.colors import LogNorm

    from sweep.figures.shade import Shade, common_norm
    from sweep.model.disk.model import DISK

    peak, other = DISK.cell_variables(SPEC)["peak_tilt"], DISK.cell_variables(SPEC)["nutation_period"]
    windows = [
        *(rng.uniform(1.0, most, 50) for most in (1.5, 19.0, 25.0, 1e4)),
        np.concatenate(([0.0, 0.0], rng.uniform(0.1, 5.0, 50))),
        np.concatenate(([0.0], rng.uniform(1.0, 5.0, 50))),
        rng.uniform(-3.0, 5.0, 50),
    ]
    for quantity in (peak, other):
        for values in windows:
            norm = common_norm([Shade(quantity, values, np.isnan(values), "")], "peak_tilt")
            if quantity is peak and values.min() < 0.0:
                continue
            asked = [quantity is peak, values.min(), values.max(), values[values > 0.0].min()]
            found = node.evaluate(
                """async ([is_peak, ...ends]) => {
                    const { rangeFor } = await import("eulerdisk/colours");
                    return rangeFor({ is_peak }, ...ends);
                }""",
                [asked[0], *map(float, asked[1:])],
            )
            assert (found["scale"] == "log") == isinstance(norm, LogNorm), asked
            assert (found["low"], found["high"]) == pytest.approx((norm.vmin, norm.vmax)), asked


def test_a_line_crosses_each_of_its_rows_once(node):
    """A line with points on the rows of cells has a value in every row, including the last or only one."""
    open_line = [[2.0, 0.1], [2.1, 0.2], [2.2, 0.3]]
    ring = [[1.0, 0.1], [2.0, 0.2], [1.0, 0.3], [0.0, 0.2], [1.0, 0.1]]
    asked = [
        *(([open_line], row) for row in (0.1, 0.15, 0.2, 0.3, 0.4)),
        ([[[5.0, 0.3]]], 0.3),
        ([[[5.0, 0.3]]], 0.2),
        ([ring], 0.1),
        ([ring], 0.2),
    ]
    found = node.evaluate(
        """async asked => {
            const { crossings } = await import("eulerdisk/cell_words");
            return asked.map(([lines, wanted]) => crossings(lines, wanted, [0, 1]));
        }""",
        asked,
    )
    expected = [[2.0], [2.05], [2.1], [2.2], [], [5.0], [], [1.0], [2.0, 0.0]]
    assert len(found) == len(expected)
    for mine, told in zip(found, expected, strict=True):
        assert mine == pytest.approx(told, abs=1e-12)


def test_cells_of_a_logarithmic_axis_meet_at_their_geometric_mean(node):
    """An exported page has the cell nearest on the atlas's axis, and none far outside."""
    found = node.evaluate(
        """async values => {
            const { StoredCells } = await import("eulerdisk/stored_cells");
            const atlas = { x: { scale: "linear" }, y: { scale: "log" } };
            const sides = [[0, 100], [1, 100]].map((side) => Float64Array.from(side));
            const cells = new StoredCells({ about: { atlas } }, ...sides, {});
            return values.map(([x, y]) => cells.at({ x, y }));
        }""",
        [[49.0, 9.9], [51.0, 10.1], [20.0, 999.0], [-40.0, 1001.0], [160.0, 9.9]],
    )
    cells = [{"x": 0, "y": 1, "index": 0}, {"x": 100, "y": 100, "index": 3}, {"x": 0, "y": 100, "index": 2}]
    assert found == [*cells, None, None]


def test_sliders_have_their_values_where_they_stand(node):
    """The middle of a slider is the arithmetic or geometric mean of its ends; a value has its place."""
    found = node.evaluate(
        """async () => {
            const { shareOnRuler, valueOnRuler } = await import("eulerdisk/elements");
            const { placeOf, valueAt } = await import("eulerdisk/motion/loss_sliders");
            const ruler = (scale) => ({ low: 0.1, high: 40, scale });
            const shares = [0, 0.5, 1].flatMap((share) => ["linear", "log"].map((scale) => [share, scale]));
            const control = (end) => ({ low: 1e-3, high: 0.1, end });
            return {
                values: shares.map(([share, scale]) => valueOnRuler(ruler(scale), share)),
                back: shares.map(([share, scale]) => shareOnRuler(ruler(scale), valueOnRuler(ruler(scale), share))),
                beyond: [0.01, 99].map((value) => shareOnRuler(ruler("log"), value)),
                ends: ["low", "high"].map((end) => [0, 1, 120, 239, 240].map((at) => valueAt(control(end), at))),
                places: ["low", "high"].map((end) => [null, 1e-3, 0.1].map((value) => placeOf(control(end), value))),
            };
        }"""
    )
    assert found["values"] == pytest.approx([0.1, 0.1, 20.05, 2.0, 40.0, 40.0])
    assert found["back"] == pytest.approx([0.0, 0.0, 0.5, 0.5, 1.0, 1.0])
    assert found["beyond"] == [0, 1]
    low, high = found["ends"]
    assert (low[:2], low[4], high[0], high[3:]) == ([None, 1e-3], 0.1, 1e-3, [0.1, None])
    assert [low[2], high[2]] == pytest.approx([0.01, 0.01], rel=0.02)
    assert found["places"] == [[0, 1, 240], [240, 0, 239]]


def test_a_page_of_a_system_takes_numbers_of_its_words_alone(opened):
    """Parameters may change; the duration, which the kernel has fixed, is refused."""
    spec = SweepSpec.preset("kapitza")
    view = {"base": "", **sides(spec)}
    held = plan(View.read({**view, "words": {}}, spec))
    script = """async ([plans, view]) => {
        const { plansWith } = await import("eulerdisk/compute/plans");
        const about = { bases: [{ name: "", words: {} }] };
        try { return plansWith(about, plans, view).cells.held; } catch (problem) { return problem.message; }
    }"""
    page = opened()
    assert page.evaluate(script, [held, {**view, "words": {"length": 0.3}}])["length"] == 0.3
    refused = page.evaluate(script, [held, {**view, "words": {"duration": 3.0}}])
    assert_facts(refused, "duration=3")
