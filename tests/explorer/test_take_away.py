"""Words, commands and files from the page agree with the command line and `sweep.run`."""

import contextlib
import json
import shlex
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from cases import case
from explorer_client import ROLLING, ask, post, post_refused
from messages import assert_facts, row

import sweep
from sweep.engine.compute import compute
from sweep.explorer import server
from sweep.explorer.explorer import explore
from sweep.explorer.view import View

VIEWS = {
    "rolling": ROLLING,
    "words": {**ROLLING, "words": {"alpha": 1.0, "criterion": "amplification:20", "radius": 0.0125}},
    "circling": {
        "base": "circling",
        "words": {},
        "x": {"name": "precession_rate", "centre": 2.5, "half": 2.4, "scale": "linear"},
        "y": {"name": "tilt", "centre": 0.2, "half": 0.1, "scale": "linear"},
    },
    "deep": {
        **ROLLING,
        "x": {"name": "roll_rate", "centre": 2.55, "half": 2.55e-11, "scale": "linear"},
        "y": {"name": "tilt", "centre": -4.0, "half": 1e-11, "scale": "log"},
    },
    "alpha": {
        **ROLLING,
        "words": {"roll_rate": 2.6},
        "x": {"name": "alpha", "centre": 0.5, "half": 0.4, "scale": "linear"},
    },
}


def executed(command, folder):
    """Run a command line of eulerdisk in a folder."""
    program, *words = shlex.split(command)
    assert program == "eulerdisk"
    done = subprocess.run(
        [sys.executable, "-m", "sweep", *words], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def close(view, name, values, count):
    """Return True if values equal those of the pixels, up to the rounding of a logarithm in another order."""
    side = view[name]
    places = side["centre"] + side["half"] * ((2 * np.arange(count) + 1) / count - 1)
    return np.allclose(values, np.exp(places) if side["scale"] == "log" else places, rtol=4e-15, atol=0.0)


def cells_of(raw, width, height):
    """Return the columns of the cells at the centers of a window's pixels."""
    view = View.read(raw, None)
    x, y = np.meshgrid(view.x.values(width), view.y.values(height))
    return compute(view.live, view.starts(x.ravel(), y.ravel()))


@pytest.mark.slow_lane
@pytest.mark.parametrize("name", VIEWS)
def test_the_command_computes_the_cells_of_the_window(url, name, tmp_path):
    """The command writes an atlas whose cells are the pixels, and the Python code makes the same atlas."""
    view = VIEWS[name]
    given = post(url, "command", view=view, width=12, height=9)
    executed(given["command"], tmp_path)
    cells = cells_of(view, 12, 9)
    x, y = view["x"]["name"], view["y"]["name"]
    with sweep.open_atlas(tmp_path / "window.nc") as atlas:
        assert close(view, "x", atlas[x].values, 12)
        assert close(view, "y", atlas[y].values, 9)
        plane = atlas.transpose(y, x)
        if name != "deep":
            assert np.allclose(cells["peak_tilt"].reshape(9, 12), plane["peak_tilt"].values, rtol=1e-6)
        # near the criterion's limit, a start that is off by one unit may be decided differently
        assert (cells["stability"].reshape(9, 12) == plane["stability"].values).mean() > 0.95
        held = {}
        exec(given["python"].replace("atlas.eulerdisk.plot()", ""), held)
        xr.testing.assert_equal(held["atlas"].drop_dims(("curves", "points"), errors="ignore"), atlas.load())


@pytest.mark.slow_lane
@pytest.mark.parametrize("losses", [None, {"rolling_friction": 1e-4}])
def test_the_command_of_a_point_follows_its_motion(url, losses, tmp_path):
    """The command simulates the point's start with the page's duration and losses."""
    given = post(
        url, "command", view=VIEWS["circling"], width=9, height=9, x=2.0, y=0.2, duration=1.5, losses=losses
    )
    executed(given["command"], tmp_path)
    assert ("rolling_friction=0.0001" in given["command"]) is (losses is not None)
    with contextlib.closing(xr.open_dataset(tmp_path / "motion.nc", decode_times=False)) as motion:
        assert float(motion["tilt"][0]) == 0.2
        assert float(motion["elapsed_time"][-1]) == 1.5
        held = {}
        exec(given["python"].replace("motion.eulerdisk.plot()", ""), held)
        assert np.array_equal(held["motion"]["tilt"].values, motion["tilt"].values)


def test_a_point_without_a_motion_has_no_command(url):
    """If no roll rate keeps the tilt, the point has no command, because the rate would be infinite."""
    _, error = post_refused(url, "command", view=VIEWS["circling"], width=9, height=9, x=0.0, y=0.2)
    assert_facts(error["error"], "roll_rate")


@pytest.mark.slow_lane
def test_the_command_of_a_point_falls_where_the_page_says(url):
    """The fall tilt is the page's; for a disk with losses it is not a word."""
    for losses in [None, {"rolling_friction": 1e-4}]:
        with case(losses):
            view = {**ROLLING, "words": {"fall_tilt": "30deg"}}
            place = {"view": view, "x": 0.5, "y": 0.02, "losses": losses}
            held = {}
            exec(post(url, "command", **place)["python"].replace("motion.eulerdisk.plot()", ""), held)
            steepest = abs(held["motion"]["tilt"].values).max()
            if losses is None:
                assert steepest == pytest.approx(np.radians(30.0))
                assert held["motion"]["ending"] == 4
            else:
                assert steepest > np.radians(60.0)


@pytest.mark.slow_lane
def test_the_command_of_a_toy_lies_flat_where_its_file_says(tmp_path):
    """The flat tilt and the losses of a disk with losses are words of its command."""
    atlas = sweep.run(
        "toy", tilt="20deg:60deg:3", precession_rate="5:20:3", duration="2s", criterion="aloft:1s",
        flat_tilt="70deg",
    )  # fmt: skip
    with explore(atlas) as explorer:
        about = json.loads(ask(explorer.url, "about").body)
        view = about["bases"][0]["view"]
        given = post(explorer.url, "command", view=view, x=0.6, y=12.0, duration=0.5)
    words = dict(word.split("=") for word in shlex.split(given["command"]) if "=" in word)
    assert float(words["flat_tilt"]) == pytest.approx(np.radians(70.0))
    assert {"contour_friction", "air_law"} <= words.keys()
    executed(given["command"], tmp_path)


def test_the_words_of_a_point_are_those_of_explain(url):
    """The explanation has the start, its exact numbers, its row's boundary and the reason for its verdict."""
    found = post(url, "explain", view=ROLLING, x=3.0, y=0.01)["text"]
    cell = sweep.run("rolling", method="exact", roll_rate=[3.0], tilt=[0.01]).squeeze()
    assert_facts(row(found, "cell"), "roll_rate 3 rad s-1", "tilt 0.5729577951 deg")
    assert row(found, "start")
    assert_facts(row(found, "  peak_tilt"), f"{np.degrees(float(cell['peak_tilt'])):.10g} deg")
    edge = sweep.run(
        "rolling", method="exact", roll_rate="2:4:50", tilt=[0.01], boundary="refined:1e-9"
    ).eulerdisk.boundary()["measured"]
    assert f"stable above roll_rate {float(edge.squeeze()):.6g} rad s-1" in found
    assert_facts(found, "stable", "departure:5deg")
    assert "nearest to" not in found


@pytest.mark.parametrize("kind", ["csv", "netcdf"])
def test_a_window_is_saved_as_a_file(url, kind, tmp_path):
    """The file is an atlas, or its table, of the window's cells; its history has the command."""
    answer = ask(url, "data", json.dumps({"view": ROLLING, "width": 8, "height": 6, "format": kind}).encode())
    assert answer.status == 200
    name = {"csv": "window.csv", "netcdf": "window.nc"}[kind]
    assert answer.headers["Content-Disposition"] == f'attachment; filename="{name}"'
    (tmp_path / name).write_bytes(answer.body)
    if kind == "netcdf":
        with sweep.open_atlas(tmp_path / name) as atlas:
            values = atlas["peak_tilt"].transpose("tilt", "roll_rate").values
            assert "eulerdisk run rolling roll_rate=" in atlas.attrs["history"]
    else:
        names, *rows = (line.split(",") for line in answer.body.decode().splitlines())
        columns = dict(zip(names, zip(*rows, strict=True), strict=True))
        values = np.array(columns["peak_tilt"], float).reshape(8, 6).T
        assert set(columns["stability"]) == {"stable", "unstable"}
    assert np.allclose(values, cells_of(ROLLING, 8, 6)["peak_tilt"].reshape(6, 8), rtol=1e-6)


def test_the_history_of_a_window_is_that_of_the_window(url, tmp_path):
    """Even if a point is chosen, the history names only the cells and no motion."""
    asked = {"view": ROLLING, "width": 8, "height": 6, "format": "netcdf"}
    beside = {"x": 3.0, "y": 0.01, "duration": 2.0, "losses": {"rolling_friction": 1e-4}}
    found = []
    for fields in (asked, asked | beside):
        path = tmp_path / f"{len(found)}.nc"
        path.write_bytes(ask(url, "data", json.dumps(fields).encode()).body)
        with sweep.open_atlas(path) as atlas:
            history = atlas.attrs["history"]
            found.append(history[history.index("eulerdisk") :])
    assert found[0] == found[1]
    assert "eulerdisk run rolling roll_rate=" in found[0]


def test_a_file_has_a_limit_and_leaves_nothing(url, tmp_path, monkeypatch):
    """Too many cells are refused with an alternative; the temporary folder stays empty."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    status, error = post_refused(url, "data", view=ROLLING, width=2000, height=1000, format="csv")
    assert status == 400
    assert_facts(error["hint"], "command")
    status, error = post_refused(url, "data", view=ROLLING, width=8, height=8, format="xlsx")
    assert (status, error["where"]) == (400, "format")
    assert (
        ask(
            url, "data", json.dumps({"view": ROLLING, "width": 8, "height": 6, "format": "csv"}).encode()
        ).status
        == 200
    )
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_sent_from_the_disk(url, monkeypatch):
    """The server reads a file in pieces and writes at most one piece at once."""
    written = []
    send = server._Handler._send

    def noted(handler, answer):
        write = handler.wfile.write
        monkeypatch.setattr(handler.wfile, "write", lambda part: written.append(len(part)) or write(part))
        send(handler, answer)

    monkeypatch.setattr(server._Handler, "_send", noted)
    asked = {"view": ROLLING, "width": 80, "height": 60, "format": "csv"}
    answer = ask(url, "data", json.dumps(asked).encode())
    assert len(answer.body) == int(answer.headers["Content-Length"]) > 2 * server._CHUNK
    assert max(written) <= server._CHUNK
    assert answer.body.count(b"\n") == 80 * 60 + 1
