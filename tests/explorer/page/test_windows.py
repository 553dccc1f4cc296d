"""Windows and points computed by the page equal those of `sweep.run` at the same starts."""

import numpy as np
import pytest
from cases import case
from explorer_client import ROLLING, about, side

import sweep
from sweep.explorer.view import Side

from .asking import ask

#: Rate and tilt on the boundary of the preset, where numbers change most.
EDGE = 2.5494838, 2.0e-3

BASES = ("rolling", "spinning", "circling")


def values(given, count):
    """Return the values at the centers of pixels, by the formula of the protocol."""
    places = [given["centre"] + given["half"] * ((2 * i + 1) / count - 1) for i in range(count)]
    return np.exp(places) if given["scale"] == "log" else np.array(places)


def same(one, other):
    """Return True if all values are equal, including NaN, except for rounding of elementary functions."""
    return np.allclose(one, other, rtol=1e-9, atol=1e-13, equal_nan=True)


@pytest.fixture
def asked(opened):
    """Return a function that asks the page."""
    page = opened()
    return lambda what, **request: ask(page, what, **request)


@pytest.mark.slow_lane
def test_a_window_has_the_numbers_of_an_atlas_at_every_depth(asked):
    """A window of 10**depth of its center has the values and verdicts of `sweep.run` at the same starts."""
    for depth in range(0, -11, -1):
        for quantity in ["peak_tilt", "nutation_period", "amplification", "separatrix"]:
            with case(depth, quantity):
                x, y = (
                    side(name, at, 0.3 * at * 10.0**depth)
                    for name, at in zip(("roll_rate", "tilt"), EDGE, strict=True)
                )
                view = {**ROLLING, "x": x, "y": y}
                head, arrays = asked("window", view=view, width=40, height=30, quantity=quantity)
                atlas = sweep.run(
                    "rolling", method="exact", roll_rate=list(values(x, 40)), tilt=list(values(y, 30))
                ).transpose("tilt", "roll_rate")
                expected = atlas[quantity].values
                assert same(arrays["value"].reshape(30, 40), expected)
                assert np.array_equal(arrays["verdict"].reshape(30, 40), atlas["stability"].values)
                known = expected[np.isfinite(expected)]
                ends = (known.min(), known.max()) if known.size else (None, None)
                assert (
                    (head["low"], head["high"]) == pytest.approx(ends, rel=1e-9)
                    if known.size
                    else (None, None)
                )


def test_a_narrow_window_is_sent_in_double_precision(asked):
    """If single precision cannot show the differences, values are sent as doubles."""
    x, y = side("roll_rate", 3.5, 1e-9), side("tilt", 0.01, 1e-11)
    _, arrays = asked("window", view={**ROLLING, "x": x, "y": y}, width=64, height=48, quantity="peak_tilt")
    assert arrays["value"].dtype == np.float64
    assert np.unique(arrays["value"]).size > 1000


def test_zoom_ends_where_pixels_are_a_few_units_wide(asked):
    """The end of zooming is reported exactly when a pixel is less than 8 units in the last place wide."""
    for scale in ["linear", "log"]:
        with case(scale):
            centre = np.log(0.01) if scale == "log" else 0.01
            unit = np.finfo(float).eps if scale == "log" else np.spacing(0.01)
            unit = max(unit, np.spacing(abs(centre)))
            for pixels, expected in ((7.0, True), (9.0, False)):
                half = 0.5 * pixels * unit * 30
                view = {**ROLLING, "y": side("tilt", centre, half, scale)}
                head, _ = asked("window", view=view, width=40, height=30, quantity="peak_tilt")
                assert head["end"] is expected


def test_a_window_of_1e_10_shows_no_steps():
    """A window of 1e-10 of its center has a different start in every screen pixel."""
    for given in (Side("roll_rate", 2.5573, 2.5573e-10, "linear"), Side("tilt", -4.0, 1e-10, "log")):
        at = given.values(1000)
        assert (np.diff(at) > 0.0).all()
        assert not given.is_too_fine(1000)


def test_the_first_view_of_a_preset_is_all_of_it(asked, url):
    """The initial window of a preset has as many stable and unstable cells as its atlas."""
    for base in BASES:
        with case(base):
            (given,) = (each for each in about(url)["bases"] if each["name"] == base)
            view = given["view"]
            _, arrays = asked("window", view=view, width=160, height=120, quantity="stability")
            assert np.array_equal(arrays["value"], arrays["verdict"])
            spec = sweep.SweepSpec.preset(base, method="exact")
            axes = {
                view[name]["name"]: list(values(view[name], count))
                for name, count in (("x", 160), ("y", 120))
            }
            atlas = sweep.run(spec.replace(**axes)).transpose(view["y"]["name"], view["x"]["name"])
            assert np.array_equal(arrays["verdict"].reshape(120, 160), atlas["stability"].values)
            assert {1, 2} <= set(np.unique(arrays["verdict"]))


def test_words_change_the_cells_as_on_the_command_line(asked):
    """Other parameters, the criterion and the fall tilt affect values and verdicts as in `sweep.run`."""
    for words in [
        {"alpha": 1.0},
        {"alpha": "0.7", "radius": "12mm"},
        {"criterion": "amplification:20", "gravity": 1.62},
        {"criterion": "peak_tilt > 10deg and nutation_period < 3s"},
        {"tilt_rate": 0.01, "precession_rate": 0.3, "fall_tilt": "60deg"},
    ]:
        with case(words):
            view = {**ROLLING, "words": words}
            _, arrays = asked("window", view=view, width=20, height=15, quantity="peak_tilt")
            atlas = sweep.run(
                "rolling", method="exact", **words,
                roll_rate=list(values(view["x"], 20)), tilt=list(values(view["y"], 15)),
            ).transpose("tilt", "roll_rate")  # fmt: skip
            assert same(arrays["value"].reshape(15, 20), atlas["peak_tilt"].values)
            assert np.array_equal(arrays["verdict"].reshape(15, 20), atlas["stability"].values)


def test_any_two_parameters_span_a_map(asked):
    """Every parameter can be an axis of the window, alpha both horizontally and vertically."""
    for x, y in [
        ("alpha", "tilt"),
        ("tilt", "alpha"),
        ("precession_rate", "roll_rate"),
        ("tilt_rate", "radius"),
    ]:
        with case(x, y):
            ranges = {
                "alpha": side("alpha", 0.5, 0.4),
                "tilt": side("tilt", 0.1, 0.05),
                "roll_rate": side("roll_rate", 0.0, 4.0),
                "precession_rate": side("precession_rate", 1.0, 4.0),
                "tilt_rate": side("tilt_rate", 0.0, 0.2),
                "radius": side("radius", -2.0, 1.0, "log"),
            }
            words = {"tilt": 0.02, "roll_rate": 2.6, "alpha": 0.5}
            view = {
                "base": "rolling",
                "words": {name: words[name] for name in words if name not in (x, y)},
                "x": ranges[x],
                "y": ranges[y],
            }
            _, arrays = asked("window", view=view, width=24, height=18, quantity="peak_tilt")
            given = {**view["words"], x: list(values(ranges[x], 24)), y: list(values(ranges[y], 18))}
            atlas = sweep.run("rolling", method="exact", **given).transpose(y, x)
            assert same(arrays["value"].reshape(18, 24), atlas["peak_tilt"].values)


def test_starts_that_do_not_exist_have_no_number(asked):
    """Outside a parameter's domain, or if no rate keeps the tilt, a pixel has no number and no verdict."""
    view = {**ROLLING, "y": side("tilt", 1.5, 0.4)}
    _, arrays = asked("window", view=view, width=8, height=40, quantity="peak_tilt")
    beyond = values(view["y"], 40) >= np.pi / 2
    assert np.isnan(arrays["value"].reshape(40, 8)[beyond]).all()
    assert (arrays["verdict"].reshape(40, 8)[beyond] == 0).all()
    assert np.isfinite(arrays["value"].reshape(40, 8)[~beyond][:5]).all()
    view["x"] = side("alpha", 1.0, 0.5)
    view["words"] = {"roll_rate": 3.0}
    _, arrays = asked("window", view=view, width=8, height=8, quantity="regime")
    assert (arrays["value"].reshape(8, 8)[:, 4:] == 5).all()


def test_a_point_has_the_numbers_of_its_cell(asked):
    """All numbers of a point equal those of an atlas with that start, as doubles and as text."""
    for x, y in ((2.5, 0.02), (2.5494838123456, 0.002), (3.7, 0.08)):
        found = asked("point", view=ROLLING, x=x, y=y)
        cell = sweep.run("rolling", method="exact", roll_rate=[x], tilt=[y]).squeeze()
        assert found["verdict"] == {0: "undecided", 1: "stable", 2: "unstable"}[int(cell["stability"])]
        names = {each["name"]: each for each in found["numbers"]}
        assert {
            "tilt_min",
            "tilt_max",
            "peak_tilt",
            "amplification",
            "nutation_period",
            "wells",
        } <= names.keys()
        for name, each in names.items():
            expected = float(cell[name])
            told = np.nan if each["value"] is None else each["value"]
            assert told == pytest.approx(expected, rel=1e-9, abs=1e-13, nan_ok=True), name
        assert found["start"]["tilt"]["value"] == y
        assert found["start"]["roll_rate"] == {"value": x, "text": f"{x:.6g} rad s-1"}


def test_a_steady_rate_is_shown_where_it_exists(asked, url):
    """A point of the preset circling has the roll rate that its cell computes, if it exists."""
    (given,) = (each for each in about(url)["bases"] if each["name"] == "circling")
    found = asked("point", view=given["view"], x=0.2, y=2.0)
    cell = sweep.run("circling", method="exact", precession_rate=[2.0], tilt=[0.2]).squeeze()
    assert found["start"]["roll_rate"]["value"] == pytest.approx(float(cell["roll_rate"]), rel=1e-14)
    view = {**given["view"], "words": {"roll_rate": 3.0, "precession_rate": "steady-slow"}}
    view["y"] = side("alpha", 0.5, 0.2)
    found = asked("point", view=view, x=1.4, y=0.5)
    assert found["start"]["precession_rate"] == {"value": None, "text": "none"}


def test_regimes_follow_from_wells_and_extremes(asked):
    """The kind of motion follows from the stored wells and extremes; a fall has its own."""
    view = {**ROLLING, "x": side("roll_rate", 1.6, 1.5), "y": side("tilt", 0.5, 0.45)}
    view["words"] = {"tilt_rate": 1.0}
    _, arrays = asked("window", view=view, width=60, height=40, quantity="regime")
    atlas = sweep.run(
        "rolling", method="exact", tilt_rate=1.0,
        roll_rate=list(values(view["x"], 60)), tilt=list(values(view["y"], 40)),
    ).transpose("tilt", "roll_rate")  # fmt: skip
    crosses = (atlas["tilt_min"] < 0.0) & (atlas["tilt_max"] > 0.0)
    expected = np.where(atlas["ending"] == 4, 4, 2 * (atlas["wells"] - 1) + crosses)
    assert atlas["ending"].attrs["flag_meanings"].split()[4] == "fell"
    assert np.array_equal(arrays["value"].reshape(40, 60), expected)
    assert {0, 1, 2, 3, 4} == set(arrays["value"])


#: Ask the server and only the page for the same window, and return if the server computed the first one.
BOTH = """async (request) => {
    const { ServerSource } = await import("eulerdisk/server_source");
    const { Computation } = await import("eulerdisk/compute/computation");
    const { computedWindow } = await import("eulerdisk/compute/cells");
    const fetched = [];
    const fetching = window.fetch;
    window.fetch = (where, ...more) => (fetched.push(String(where)), fetching(where, ...more));
    const source = new ServerSource();
    const ofServer = await source.window(request);
    const asked = { method: "POST", headers: { "Content-Type": "application/json" } };
    const plans = await fetching("./plan", { ...asked, body: JSON.stringify({ view: request.view }) });
    const { cells } = await plans.json();
    const content = fetching("./page/kernels.wasm").then((answer) => answer.arrayBuffer());
    const ofPage = await computedWindow(new Computation(content), cells, request);
    window.fetch = (where, ...more) =>
        String(where) === "./cells" ? Promise.reject(new TypeError("gone")) : fetching(where, ...more);
    const withoutServer = await source.window(request);
    window.fetch = fetching;
    const told = ({ head, value, verdict }) => [head, Array.from(value), Array.from(verdict)];
    return { byServer: fetched.includes("./cells"), windows: [ofServer, ofPage, withoutServer].map(told) };
}"""

#: For each subject, quantities and if the server computes windows of them.
COMPUTED = {
    "rolling": [("peak_tilt", False), ("nutation_period", True)],
    "rolling path=yes": [("nutation_period", False), ("path_drift", False), ("path_class", False)],
    "torus": [("nutation_period", False)],
    "henon_heiles": [("stability", True)],
}


@pytest.mark.release
def test_windows_of_the_server_are_those_of_the_page(served_with, opened):
    """If the program is much faster, it computes windows; values, verdicts and ends equal the page's.

    Without the server, the page computes them itself.

    Sums have another order, and functions another library; a chaotic cell may be decided differently.
    """
    for given, quantities in COMPUTED.items():
        address = served_with(*given.split()).url
        page = opened(address)
        view = about(address)["bases"][0]["view"]
        for quantity, is_of_server in quantities:
            with case(given, quantity):
                found = page.evaluate(BOTH, {"view": view, "width": 16, "height": 12, "quantity": quantity})
                assert found["byServer"] == is_of_server
                (head, *server), (other, *alone), without = found["windows"]
                assert without == [other, *alone]
                (value, verdict), (expected, decided) = (map(np.array, each) for each in (server, alone))
                assert np.mean(verdict == decided) > 0.99
                alike = np.isclose(
                    value.astype(float), expected.astype(float), rtol=1e-9, atol=1e-12, equal_nan=True
                )
                assert np.mean(alike) > 0.99
                assert np.isfinite(value.astype(float)).any()
                for end in ("low", "high", "least"):
                    assert head[end] == pytest.approx(other[end], rel=1e-6)
