import html
import json
import math
import queue
import re
import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from cases import case
from explorer_client import about, ask, post, post_refused
from messages import assert_facts, refused

import sweep
from sweep.errors import RequestError
from sweep.explorer.explorer import Explorer, explore, subject_of_words
from sweep.explorer.point import NO_CELL
from sweep.figures.panels import panel
from sweep.model.disk.path import PATH_VARIABLES
from sweep.request.spec import SweepSpec

SPEC = sweep.SweepSpec.preset("rolling", roll_rate="2:4:20", tilt="0.1deg:10deg:12:log")


def centres(side, count):
    """Return the values at the centers of pixels."""
    at = side["centre"] + side["half"] * ((2 * np.arange(count) + 1) / count - 1)
    return np.exp(at) if side["scale"] == "log" else at


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Return the path of an integrated atlas."""
    path = tmp_path_factory.mktemp("explorer") / "rolling.nc"
    sweep.run_to_file(SPEC, path)
    return path


@pytest.fixture(scope="module")
def losses(tmp_path_factory):
    """Return the path of an atlas with losses."""
    path = tmp_path_factory.mktemp("losses") / "toy.nc"
    sweep.run_to_file(
        "toy", path, tilt="20deg:60deg:5", precession_rate="5:20:6", duration="5s", criterion="aloft:5s"
    )
    return path


def test_the_browser_is_given_no_address_that_others_can_read(tmp_path, monkeypatch):
    """The browser gets a file only this user can read, which leads to the page until the explorer closes."""
    given = queue.Queue()
    monkeypatch.setattr("webbrowser.open", given.put)
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr("sweep.explorer.explorer._CONFINED", tmp_path / "none")
    with explore(open_browser=True) as explorer:
        address = given.get(timeout=60)
        (door,) = tmp_path.iterdir()
        assert address == door.as_uri()
        assert door.stat().st_mode & 0o777 == 0o600
        assert re.search(r'content="0; url=(.*)"', door.read_text())[1] == explorer.url
        explorer.open_browser()
        assert given.get(timeout=60) == address
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr("sweep.explorer.explorer._CONFINED", tmp_path)
    with explore(open_browser=True) as explorer:
        assert given.get(timeout=60) == explorer.url


def test_stored_cells_are_shown_as_they_are(file):
    """Each pixel has the value and the verdict of its nearest cell, for a file or a dataset."""
    for given in ["file", "dataset", "selection"]:
        with case(given), sweep.open_atlas(file) as atlas:
            chosen = atlas.isel(tilt=slice(2, 9)) if given == "selection" else atlas
            with explore(file if given == "file" else chosen) as explorer:
                view = about(explorer.url)["bases"][0]["view"]
                head, arrays = post(
                    explorer.url, "window", view=view, width=48, height=40, quantity="peak_tilt", stored=True
                )
                x, y = centres(view["x"], 48), centres(view["y"], 40)
                columns = abs(np.log(chosen["tilt"].values / x[:, None])).argmin(1)
                rows = abs(chosen["roll_rate"].values - y[:, None]).argmin(1)
                expected = chosen.transpose("roll_rate", "tilt").isel(tilt=columns, roll_rate=rows)
                assert np.array_equal(
                    arrays["value"].reshape(40, 48), expected["peak_tilt"].values.astype("f4")
                )
                assert np.array_equal(arrays["verdict"].reshape(40, 48), expected["stability"].values)
                assert (arrays["stored"] == 1).all()
                assert head["low"] == float(expected["peak_tilt"].min())


def test_beyond_the_grid_no_cells_are_stored(file):
    """Pixels more than half a cell outside are marked as not stored, and the page computes them."""
    with explore(file) as explorer:
        view = about(explorer.url)["bases"][0]["view"]
        view["y"] = {**view["y"], "centre": 4.0, "half": 2.0}
        _, found = post(explorer.url, "window", view=view, width=60, height=40, quantity="peak_tilt")
    inside = found["stored"].reshape(40, 60) == 1
    half = (4.0 - 2.0) / 19 / 2
    y = centres(view["y"], 40)[:, None]
    assert np.array_equal(inside, np.broadcast_to((y > 2.0 - half) & (y < 4.0 + half), (40, 60)))
    assert np.isnan(found["value"].reshape(40, 60)[~inside]).all()
    assert (found["verdict"].reshape(40, 60)[~inside] == 0).all()


def test_other_words_have_no_stored_cells(file):
    """A view with another parameter or criterion than the file has only computed cells."""
    for words in [{"alpha": 0.7}, {"criterion": "departure:1deg"}, {"tilt_rate": 0.01}]:
        with case(words), explore(file) as explorer:
            view = {**about(explorer.url)["bases"][0]["view"], "words": words}
            asked = {"view": view, "width": 8, "height": 8, "quantity": "peak_tilt"}
            assert post(explorer.url, "window", **asked) == {"head": None}
            assert post(explorer.url, "point", view=view, x=0.02, y=2.5) == {"stored": None}
            same = {**view, "words": {"alpha": 0.5, "criterion": "departure:5deg"}}
            assert "stored" in post(explorer.url, "window", **{**asked, "view": same})[1]


def test_what_integration_alone_tells_is_stored(file):
    """The time of a fall is shown for stored cells; a quantity that no cell has is refused."""
    with explore(file) as explorer:
        view = about(explorer.url)["bases"][0]["view"]
        asked = {"view": view, "width": 8, "height": 6}
        head, arrays = post(explorer.url, "window", **asked, quantity="fall_time")
        assert head["note"] == ""
        assert (arrays["stored"] == 1).all()
        status, problem = post_refused(explorer.url, "window", **asked, quantity="secret")
        assert (status, problem["where"]) == (400, "quantity")


def test_a_third_axis_is_cut_at_its_nearest_value(tmp_path):
    """For an atlas of three axes, the plane nearest to the slider's value is shown."""
    atlas = sweep.run(SPEC.replace(alpha=[0.5, 0.8, 1.0], method="exact"))
    with explore(atlas) as explorer:
        base = about(explorer.url)["bases"][0]
        assert base["words"]["alpha"] == 0.8
        for alpha in (0.52, 0.8, 1.0):
            view = {**base["view"], "words": {"alpha": alpha}}
            _, arrays = post(
                explorer.url, "window", view=view, width=12, height=20, quantity="amplification", stored=True
            )
            plane = atlas["amplification"].sel(alpha=alpha, method="nearest").transpose("roll_rate", "tilt")
            assert np.array_equal(arrays["value"].reshape(20, 12), plane.values.astype("f4"))


def test_a_point_of_a_file_has_the_numbers_of_its_cell(file):
    """A point has the stored numbers of the nearest cell, and none outside the grid."""
    with explore(file) as explorer, sweep.open_atlas(file) as atlas:
        view = about(explorer.url)["bases"][0]["view"]
        found = post(explorer.url, "point", view=view, x=0.02, y=2.512)["stored"]
        cell = atlas.eulerdisk.cell(roll_rate=2.512, tilt=0.02)
        stored = {each["name"]: each["value"] for each in found["numbers"]}
        assert stored["peak_tilt"] == float(cell["peak_tilt"])
        assert found["start"]["tilt"]["value"] == float(cell["tilt"])
        assert post(explorer.url, "point", view=view, x=0.02, y=5.0)["stored"] is None


def test_the_colour_is_that_of_the_numbers_however_the_axis_is_seen():
    """Everywhere, a pixel has the value of the cell at its point, and is empty if there is none."""
    for spacing, scale in [("log", "linear"), ("linear", "log")]:
        with case(spacing, scale):
            tilt = "1deg:16deg:5:log" if spacing == "log" else "1deg:16deg:5"
            atlas = sweep.run("rolling", method="exact", roll_rate="2:4:6", tilt=tilt)
            low, high = np.radians([0.3, 25.0])
            ends = np.log([low, high]) if scale == "log" else (low, high)
            side = {"name": "tilt", "centre": np.mean(ends), "half": np.ptp(ends) / 2, "scale": scale}
            with explore(atlas) as explorer:
                view = {**about(explorer.url)["bases"][0]["view"], "x": side}
                asked = {"view": view, "width": 60, "height": 6, "quantity": "peak_tilt", "stored": True}
                _, arrays = post(explorer.url, "window", **asked)
                y = centres(view["y"], 6)[2]
                for column, x in enumerate(centres(side, 60)):
                    told = post(explorer.url, "point", view=view, x=x, y=y)["stored"]
                    assert (told is not None) == (arrays["stored"].reshape(6, 60)[2, column] == 1), (
                        np.degrees(x)
                    )
                    if told is not None:
                        peak = {each["name"]: each["value"] for each in told["numbers"]}["peak_tilt"]
                        assert arrays["value"].reshape(6, 60)[2, column] == np.float32(peak), np.degrees(x)


def test_an_atlas_with_losses_shows_its_cells_and_refuses_others(losses):
    """Stored cells and their numbers are shown; cells that need integration in time are refused."""
    with explore(losses) as explorer, sweep.open_atlas(losses) as atlas:
        held = about(explorer.url)
        assert held["atlas"]["live"] is False
        view = held["bases"][0]["view"]
        asked = {"view": view, "width": 5, "height": 6, "quantity": "end_time"}
        _, arrays = post(explorer.url, "window", **asked, stored=True)
        expected = atlas["end_time"].transpose(view["y"]["name"], view["x"]["name"])
        assert np.allclose(arrays["value"].reshape(6, 5), expected.values, rtol=1e-7)
        plans = post(explorer.url, "plan", view=view)
        assert plans["cells"] is None
        assert_facts(plans["refused"]["error"], "exact")
        wide = {**view, "x": {**view["x"], "half": 4 * view["x"]["half"]}}
        _, beyond = post(explorer.url, "window", **{**asked, "view": wide}, stored=True)
        assert np.isnan(beyond["value"][beyond["stored"] == 2]).all()
        assert post(explorer.url, "point", view=view, x=0.6, y=12.0)["stored"]["numbers"]


def test_outside_the_grid_of_an_atlas_with_losses_there_is_nothing(losses):
    """Outside the grid, a window has neither numbers nor codes and marks each pixel, and a point has no cell."""
    with explore(losses) as explorer:
        view = about(explorer.url)["bases"][0]["view"]
        wide = {**view, "y": {**view["y"], "half": 4.0 * view["y"]["half"]}}
        asked = {"view": wide, "width": 5, "height": 9, "stored": True}
        for quantity in ("end_time", "stability"):
            head, arrays = post(explorer.url, "window", quantity=quantity, **asked)
            value, origin = arrays["value"].reshape(9, 5), arrays["stored"].reshape(9, 5)
            assert np.array_equal(origin[:, 2], [2, 2, 2, 1, 1, 1, 2, 2, 2])
            empty = value[origin == 2]
            assert (np.isnan(empty) if quantity == "end_time" else empty == 255).all()
            assert head["high"] == np.nanmax(value[origin == 1])
        x, y = view["x"]["centre"], wide["y"]["centre"] + 0.9 * wide["y"]["half"]
        assert post(explorer.url, "point", view=view, x=x, y=y) == {"stored": None}


def test_what_is_no_plane_is_refused(tmp_path, file):
    """A list of starts, an atlas of one axis, and words with a file are refused."""
    with refused("list of starts"):
        explore("rolling", samples=10, tilt="uniform:1deg:2deg", roll_rate=3.0)
    with refused("list of starts"):
        explore("rolling", samples=10, tilt="uniform:1deg:2deg", roll_rate="uniform:2:3")
    with refused("two parameters"):
        explore(sweep.run(SPEC.replace(tilt=0.01)))
    with refused("alpha"):
        explore(file, alpha=1.0)
    with refused("missing.nc", "no such file"):
        explore(tmp_path / "missing.nc")
    with refused("roling", "rolling?"):
        explore("roling")
    with refused("toy", "reduction") as problem:
        explore("toy")
    assert_facts(problem.value.hint, "eulerdisk run toy -o toy.nc")


def test_words_are_those_of_the_model_that_is_explored():
    """Words of the disk with losses are known for its preset; unknown words are refused."""
    with refused("reduction"):
        subject_of_words("toy", ["mass=2kg"])
    with refused("mas"):
        subject_of_words("toy", ["mas=2kg"])
    with pytest.raises(RequestError, match="mass"):
        subject_of_words("rolling", ["mass=2kg"])
    assert subject_of_words("rolling", ["alpha=1"]).spec.alpha == 1.0
    assert subject_of_words("alpha=1", ["gravity=1.6"]).spec.gravity == 1.6
    assert subject_of_words(None, []).spec is None
    # longer than a file name can be
    with pytest.raises(RequestError, match="alpha"):
        subject_of_words(f"alpha={'a' * 300}", [])


@pytest.mark.parametrize("name", ["alpha=1 +5%.nc", "größe & 盤 #1.nc", "a='b'\";<i>.nc"])
def test_the_file_of_an_atlas_may_have_any_name(tmp_path, file, name):
    """Special characters of words, addresses and HTML have no meaning in a file name."""
    path = tmp_path / name
    path.write_bytes(file.read_bytes())
    with Explorer(subject_of_words(str(path), [])) as explorer:
        assert about(explorer.url)["atlas"]["label"] == name


def test_the_accessor_opens_the_explorer_of_its_atlas(file):
    """`atlas.eulerdisk.explore()` serves the atlas; a notebook shows it in a local frame."""
    with sweep.open_atlas(file) as atlas, atlas.eulerdisk.explore() as explorer:
        assert about(explorer.url)["atlas"]["label"] == "rolling.nc"
        (source,) = re.findall(r'<iframe src="([^"]+)"', explorer._repr_html_())
        assert html.unescape(source) == explorer.url
        policy = ask(explorer.url).headers["Content-Security-Policy"]
        assert "frame-ancestors 'self' http://localhost:* http://127.0.0.1:*" in policy


def test_a_spec_is_a_base_of_its_own():
    """A spec with changes is the first base; the presets are available, too."""
    with explore("spinning", alpha=1.0, criterion="amplification:5") as explorer:
        held = about(explorer.url)
        assert [each["name"] for each in held["bases"]] == ["", "rolling", "circling", "spinning"]
        assert held["bases"][0]["words"]["alpha"] == 1.0
        assert held["bases"][0]["words"]["criterion"] == "amplification:5"
        assert held["atlas"] is None


@pytest.fixture(scope="module")
def log_losses(tmp_path_factory):
    """Return the path of an atlas with losses and logarithmic axes."""
    path = tmp_path_factory.mktemp("log") / "toy.nc"
    axes = {"tilt": "5deg:60deg:3:log", "precession_rate": "5:20:3:log"}
    sweep.run_to_file("toy", path, **axes, duration="1s", criterion="aloft:1s", progress=False)
    return path


def test_the_words_of_a_cell_end_where_its_colour_ends(log_losses):
    """In the outer half cells of logarithmic axes, a point is explained exactly if it has a stored cell."""
    with explore(log_losses) as explorer:
        view = about(explorer.url)["bases"][0]["view"]
        middle = math.sqrt(5.0 * 20.0)
        for name, low, high in (
            ("tilt", math.radians(5.0), math.radians(60.0)),
            ("precession_rate", 5.0, 20.0),
        ):
            half = (high / low) ** 0.25
            for value in (low / half, high * half):
                for factor in (1.001, 0.999):
                    within = (factor > 1.0) == (value < high)
                    at = {"tilt": math.radians(17.0), "precession_rate": middle, name: value * factor}
                    asked = {"view": view, "x": at[view["x"]["name"]], "y": at[view["y"]["name"]]}
                    assert (post(explorer.url, "point", **asked)["stored"] is not None) == within
                    words = post(explorer.url, "explain", **asked)["text"]
                    assert ("verdict" in words) == within
                    assert (words == NO_CELL) != within


def test_cells_are_shown_while_one_is_explained(losses, monkeypatch):
    """The file is locked only while it is read, so windows and points do not wait for an explanation."""
    begun, ended = threading.Event(), threading.Event()

    def endless(dataset, at):
        assert np.isfinite(dataset["tilt"].values).all()
        begun.set()
        ended.wait(30)
        return SimpleNamespace(text="words")

    monkeypatch.setattr("sweep.checks.explain.explain", endless)
    with explore(losses) as explorer, ThreadPoolExecutor(1) as pool:
        view = about(explorer.url)["bases"][0]["view"]
        first = pool.submit(post, explorer.url, "explain", view=view, x=0.6, y=12.0)
        try:
            assert begun.wait(30)
            asked = {"view": view, "width": 6, "height": 5, "stored": True}
            assert post(explorer.url, "window", quantity="end_time", **asked)[1]["stored"].all()
            assert post(explorer.url, "point", view=view, x=0.6, y=12.0)["stored"]
            assert not first.done()
        finally:
            ended.set()
        assert first.result()["text"] == "words"


def test_the_page_has_the_axes_of_a_figure():
    """A map has the same horizontal and vertical axes on the page and in print."""
    tilt, rate = "1deg:4deg:4", "2:4:5"
    for words in [
        {"tilt": tilt, "roll_rate": rate},
        {"spec": "circling", "tilt": tilt, "precession_rate": rate},
        {"tilt": tilt, "alpha": "0.5:1:3", "roll_rate": 3.0},
        {"precession_rate": "0.1:0.4:3", "roll_rate": rate, "tilt": 0.02},
    ]:
        with case(words):
            atlas = sweep.run(**{"spec": "rolling", **words}, method="exact", progress=False)
            drawn = panel(atlas)
            with explore(atlas) as explorer:
                view = about(explorer.url)["bases"][0]["view"]
            assert (view["x"]["name"], view["y"]["name"]) == (drawn.x.quantity.name, drawn.y.quantity.name)


#: Files of systems without ranges: one with five words, one with only two states.
SYSTEM_FILES = {
    "five.py": "@system(duration=2)\ndef five(x=1.0, y=0.5, *, k=1.0, q=0.1, g=0.1):\n    return y, -k*x - q*y + g\n",
    "two.py": "@system(duration=2)\ndef two(x=1.0, y=0.5):\n    return y, -x\n",
}


@pytest.mark.slow_lane
@pytest.mark.parametrize("given", ["kapitza", *SYSTEM_FILES])
def test_every_question_about_a_system_is_answered(tmp_path, monkeypatch, command, given):
    """Presets and files without ranges are shown in two parameters; a command computes the window's cells."""
    monkeypatch.chdir(tmp_path)
    if given in SYSTEM_FILES:
        text = f"from sweep.systems import system\n\n\n{SYSTEM_FILES[given]}"
        (tmp_path / given).write_text(text, encoding="utf-8")
    with explore(given) as explorer:
        held = about(explorer.url)
        (base,) = held["bases"]
        view = base["view"]
        assert (base["rolls"], base["cost"] > 0.0, held["criteria"]) == (False, True, [])
        place = {"view": view, "x": view["x"]["centre"], "y": view["y"]["centre"]}
        plans = post(explorer.url, "plan", view=view)
        assert (plans["refused"], plans["motion"], "system" in plans["cells"]) == (None, None, True)
        assert post(explorer.url, "point", **place) == {"stored": None}
        assert "verdict" in post(explorer.url, "explain", **place)["text"]
        size = {"view": view, "width": 3, "height": 2}
        line = post(explorer.url, "command", **size)["command"]
        cells = ask(explorer.url, "data", json.dumps({**size, "format": "csv"}).encode())
        assert cells.status == 200
        motion = post(explorer.url, "command", **place)["command"]
    for words in (line, motion):
        status, _, messages = command(words.removeprefix("eulerdisk "))
        assert status == 0, messages
    # the start is that of the place
    with xr.open_dataset("motion.nc") as followed:
        assert [float(np.ravel(followed[view[side]["name"]])[0]) for side in "xy"] == [place["x"], place["y"]]
    assert command("export window.nc --to csv")[0] == 0
    assert (tmp_path / "window.csv").read_bytes() == cells.body


def test_losses_beside_the_motion_of_a_ball_are_refused():
    """Explanation and command for a ball with losses are refused, because it has none."""
    with explore("egg") as explorer:
        view = about(explorer.url)["bases"][0]["view"]
        place = {"view": view, "x": view["x"]["centre"], "y": view["y"]["centre"]}
        place["losses"] = {"pivoting_friction": 1e-4}
        for question in ("explain", "command"):
            refused = ask(explorer.url, question, json.dumps({**place, "duration": 60.0}).encode())
            assert (refused.status, b"A ball rolls without losses" in refused.body) == (400, True), question


@pytest.mark.parametrize(
    "given",
    [
        pytest.param("torus", marks=pytest.mark.slow_lane),
        "egg",
        pytest.param("true_edge", marks=pytest.mark.release),
    ],
)
def test_every_question_about_a_body_is_answered(tmp_path, monkeypatch, command, given):
    """A page has only its own body's lengths; a command computes the window's cells."""
    monkeypatch.chdir(tmp_path)
    with explore(given) as explorer:
        held = about(explorer.url)
        (base,) = held["bases"]
        view, spec = base["view"], SweepSpec.preset(given)
        lengths = {"torus": {"tube"}, "ball": {"offset"}, "rim": {"thickness", "fillet"}}[spec.body]
        rows = {row["name"]: row for row in held["parameters"]}
        assert rows.keys() & {"tube", "thickness", "fillet", "offset", "flattening"} == lengths
        assert ("fall_tilt" in rows) == (spec.body != "ball")
        assert all("none" not in rows[name]["words"] for name in lengths)
        place = {"view": view, "x": view["x"]["centre"], "y": view["y"]["centre"]}
        plans = post(explorer.url, "plan", view=view)
        assert (plans["refused"], "body" in plans["cells"]) == (None, True)
        assert (base["rolls"], plans["motion"]["body"]["name"]) == (True, spec.body)
        assert post(explorer.url, "point", **place) == {"stored": None}
        assert "verdict" in post(explorer.url, "explain", **place)["text"]
        motion = post(explorer.url, "command", **place, duration=0.2)["command"]
        lines = {each["name"] for each in post(explorer.url, "lines", view=view)["lines"]}
        assert "measured" in lines
        size = {"view": view, "width": 3, "height": 2}
        line = post(explorer.url, "command", **size)["command"]
        cells = ask(explorer.url, "data", json.dumps({**size, "format": "csv"}).encode())
        assert cells.status == 200
    status, _, messages = command(line.removeprefix("eulerdisk "))
    assert status == 0, messages
    assert command(motion.removeprefix("eulerdisk "))[0] == 0
    assert command("export window.nc --to csv")[0] == 0
    assert (tmp_path / "window.csv").read_bytes() == cells.body


@pytest.mark.release
def test_an_atlas_of_a_body_with_losses_is_shown(tmp_path, monkeypatch, command):
    """Cells are stored, motions have the cells' losses, and a command reproduces a motion."""
    monkeypatch.chdir(tmp_path)
    words = {"tube": "20mm", "contour_friction": 5e-5, "tilt": "10deg,20deg", "roll_rate": "1,2,3"}
    atlas = sweep.run("torus", **words, duration="1s", progress=False)
    with explore(atlas) as explorer:
        held = about(explorer.url)
        (base,) = held["bases"]
        view = base["view"]
        place = {"view": view, "x": view["x"]["centre"], "y": view["y"]["centre"]}
        plans = post(explorer.url, "plan", view=view)
        assert (plans["cells"], plans["lossy"], held["atlas"]["live"]) == (None, None, False)
        assert plans["motion"]["body"]["name"] == "torus"
        assert (plans["motion"]["lossy"], plans["motion"]["losses"]["contour_friction"]) == (True, 5e-5)
        stored = post(explorer.url, "point", **place)["stored"]
        assert "end_time" in {number["name"] for number in stored["numbers"]}
        assert "contour" in post(explorer.url, "explain", **place, losses={})["text"]
        assert "analytic" in {each["name"] for each in post(explorer.url, "lines", view=view)["lines"]}
        window = post(explorer.url, "command", view=view, width=2, height=2)["command"]
        motion = post(explorer.url, "command", **place, duration=0.2)["command"]
    for line in (window, motion):
        status, _, messages = command(line.removeprefix("eulerdisk "))
        assert status == 0, messages
    with sweep.open_atlas(tmp_path / "window.nc") as again:
        assert again.eulerdisk.spec.contour_friction == 5e-5
    with xr.open_dataset(tmp_path / "motion.nc") as dataset:
        assert float(dataset["contour_loss"][-1]) > 0.0


def test_paths_and_any_length_can_be_shown():
    """A request for paths has their columns, for disks and bodies; any length can be an axis."""
    words = {
        "body": "torus",
        "tube": "0.1:0.3:3",
        "roll_rate": "2:3:3",
        "tilt": "10deg",
        "precession_rate": 0.5,
    }
    for given in (SweepSpec(**words), SweepSpec.preset("rolling")):
        asked = given.replace(path="yes", criterion="path_drift > 10", method="exact")
        with explore(asked) as explorer, explore(given) as other:
            (first, *_), (without, *_) = (about(each.url)["bases"] for each in (explorer, other))
            plans = post(explorer.url, "plan", view=first["view"])
        assert plans["refused"] is None
        assert set(first["quantities"]) - set(without["quantities"]) == set(PATH_VARIABLES)
        assert (
            set(plans["cells"]["path"])
            == set(PATH_VARIABLES)
            == set(PATH_VARIABLES) & set(plans["cells"]["shown"])
        )
    for given, name in (("thick_coin", "fillet"), ("egg", "offset")):
        with explore(given) as explorer:
            view = about(explorer.url)["bases"][0]["view"]
            view["x" if view["y"]["name"] != name else "y"] = {"name": name, "centre": 0.02, "half": 0.01}
            assert post(explorer.url, "plan", view=view)["refused"] is None, given


def test_a_system_without_a_plane_is_refused(tmp_path):
    """A system with one state and no parameter has no plane and is refused."""
    path = tmp_path / "one.py"
    path.write_text(
        "from sweep.systems import system\n\n\n@system(duration=2)\ndef one(x=1.0):\n    return -x\n"
    )
    with refused("one state"):
        explore(str(path))
