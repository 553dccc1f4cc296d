import base64
import json
import os
import re
import signal
import stat
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from messages import assert_facts, refused

import sweep
from sweep.explorer.explorer import Subject, subject_of
from sweep.explorer.export import export

CHECKOUT = Path(__file__).resolve().parents[2]
SPEC = sweep.SweepSpec.preset("rolling", roll_rate="2:4:20", tilt="0.1deg:10deg:12:log", method="exact")


def held_in(path):
    """Return the JSON content of a page."""
    (text,) = re.findall(
        r'<script type="application/json" id="stored">(.*?)</script>',
        path.read_text(encoding="utf-8"),
        re.DOTALL,
    )
    return json.loads(text)


def array(packed):
    """Return an array of a page."""
    kind = np.dtype(packed["type"]).newbyteorder("<")
    return np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), kind)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Return the page of an atlas."""
    path = tmp_path_factory.mktemp("export") / "page.html"
    export(subject_of(sweep.run(SPEC), {}), path)
    return path


def test_the_page_has_the_cells_of_the_atlas(page):
    """Every quantity, the verdicts and the coordinates equal the atlas's, at its own resolution."""
    held, atlas = held_in(page), sweep.run(SPEC).transpose("roll_rate", "tilt")
    stored = held["stored"]
    assert np.array_equal(array(stored["x"]), atlas["tilt"].values)
    assert np.array_equal(array(stored["y"]), atlas["roll_rate"].values)
    names = [each["name"] for each in held["about"]["quantities"]]
    assert {"peak_tilt", "amplification", "nutation_period", "stability", "separatrix"} <= set(names)
    assert {*names, "verdict"} == stored["cells"].keys()
    for name in {*names} - {"regime"}:
        expected, found = atlas[name].values, array(stored["cells"][name])
        assert np.array_equal(found.reshape(20, 12), expected.astype(found.dtype), equal_nan=True), name
    crosses = (atlas["tilt_min"] < 0.0) & (atlas["tilt_max"] > 0.0)
    regime = np.where(atlas["ending"] == 4, 4, 2 * (atlas["wells"] - 1) + crosses)
    assert np.array_equal(array(stored["cells"]["regime"]).reshape(20, 12), regime)
    assert np.array_equal(array(stored["cells"]["verdict"]).reshape(20, 12), atlas["stability"].values)
    assert stored["starts"] == {
        "tilt_rate": 0.0, "precession_rate": 0.0, "alpha": 0.5, "radius": 0.5, "gravity": 9.81,
        "fall_tilt": float(np.radians(85.0)),
    }  # fmt: skip
    assert {line["name"] for line in held["lines"]} == {"analytic", "predicted", "measured"}
    assert held["about"]["atlas"]["live"] is True
    assert "12 x 20 cells" in held["about"]["atlas"]["note"]


def test_an_atlas_that_no_page_computes_keeps_its_measured_boundary(tmp_path):
    """For a disk with losses, the lines are the edges measured in the file."""
    words = {"roll_rate": "1:6:12", "tilt": "0.1deg:5deg:5", "contour_friction": "20um", "duration": "2s"}
    atlas = sweep.run("rolling", **words)
    export(subject_of(atlas, {}), tmp_path / "page.html")
    held = held_in(tmp_path / "page.html")
    assert held["about"]["atlas"]["live"] is False
    (measured,) = (line for line in held["lines"] if line["name"] == "measured")
    edge = atlas.eulerdisk.boundary()
    places = sorted(tuple(place) for points in measured["points"] for place in points)
    known = np.isfinite(edge.measured.values)
    assert np.allclose(places, np.stack([edge.tilt.values, edge.measured.values], axis=1)[known], rtol=1e-12)
    assert known.sum() == 3


def test_cells_have_the_rates_that_they_compute(tmp_path):
    """For circling disks, the page has every cell's roll rate, because a motion needs it."""
    atlas = sweep.run(
        "circling", method="exact", precession_rate="1:4:10", tilt="1deg:20deg:8", progress=False
    )
    export(subject_of(atlas, {}), tmp_path / "a.html")
    stored = held_in(tmp_path / "a.html")["stored"]
    assert "roll_rate" not in stored["starts"]
    found = array(stored["cells"]["roll_rate"]).reshape(10, 8)
    assert np.array_equal(found, atlas["roll_rate"].transpose("precession_rate", "tilt").values)


def test_a_request_is_computed_by_its_page(tmp_path):
    """The page of a spec has no cells, only the kernels and the plan for its model and criterion."""
    words = {"alpha": 0.7, "criterion": "peak_tilt > 3deg and tilt_min < 1deg"}
    export(subject_of("rolling", words), tmp_path / "a.html")
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    (packed,) = re.findall(r'<script type="text/plain" id="kernels">(.*?)</script>', text)
    kernels = zlib.decompress(base64.b64decode(packed))
    assert kernels == (CHECKOUT / "sweep" / "explorer" / "page" / "kernels.wasm").read_bytes()
    held = held_in(tmp_path / "a.html")
    assert held["stored"] is None
    assert held["plans"]["cells"]["held"]["alpha"] == 0.7
    assert held["plans"]["cells"]["criterion"]["named"] == ["peak_tilt", "tilt_min"]
    assert held["about"]["criteria"] == []
    scripts = sum(path.stat().st_size for path in (CHECKOUT / "sweep" / "explorer" / "page").rglob("*.js"))
    assert len(text) < 1.4 * scripts + 250_000


def test_the_page_needs_nothing_else(page):
    """The page contains its modules, styles and data, has no external address, and its policy forbids them."""
    text = page.read_text(encoding="utf-8")
    assert re.findall(r'(?:src|href)="(?!data:)([^"]*)"', text) == []
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    assert "default-src 'none'" in policy
    assert "http" not in policy
    (imports,) = re.findall(r'<script type="importmap">(.*?)</script>', text, re.DOTALL)
    modules = json.loads(imports)["imports"]
    folder = CHECKOUT / "sweep" / "explorer" / "page"
    sources = {base64.b64decode(each.partition("base64,")[2]) for each in modules.values()}
    assert {path.read_bytes() for path in folder.rglob("*.js")} == sources
    # modules with a data address can import others only by name
    for source in sources:
        for name in re.findall(rb'^(?:import|export)\b[^;]*?from\s*"([^"]+)"', source, re.MULTILINE):
            assert name.decode() in modules


def test_words_of_an_atlas_cannot_end_the_script(tmp_path):
    """A title with a tag in it stays text."""
    export(subject_of(SPEC.replace(title="</script><script>alert(1)</script>"), {}), tmp_path / "a.html")
    assert held_in(tmp_path / "a.html")["about"]["bases"][0]["label"].startswith("</script>")
    assert "<script>alert" not in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_what_cannot_be_exported_is_refused_and_touches_nothing(tmp_path):
    """Another ending, an existing file, a missing folder, one axis and too many cells are refused."""
    subject = Subject(SPEC)
    path = tmp_path / "a.html"
    with refused("HTML"):
        export(subject, tmp_path / "a.png")
    with refused("mkdir -p"):
        export(subject, tmp_path / "b" / "a.html")
    with refused("two axes"):
        export(Subject(SPEC.replace(tilt=0.1)), path)
    with refused("fall_time"):
        export(Subject(SPEC.replace(method="rk4", criterion="fall_time < 2s")), path)
    large = subject_of(sweep.run(SPEC), {})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sweep.explorer.export.MOST_CELLS", 100)
        with refused("100 cells"):
            export(large, path)
    assert list(tmp_path.iterdir()) == []
    path.write_text("mine")
    with refused("--overwrite"):
        export(subject, path)
    assert path.read_text() == "mine"


def test_the_command_writes_a_page(tmp_path):
    """`eulerdisk explore SPEC WORDS --export page.html` writes it with normal permissions and exits with 0."""
    words = ["explore", "rolling", "alpha=1", "roll_rate=2:3:8", "tilt=1deg:5deg:6", "--export", "p.html"]
    done = subprocess.run(
        [sys.executable, "-m", "sweep", *words], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert held_in(tmp_path / "p.html")["plans"]["cells"]["held"]["alpha"] == 1.0
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE((tmp_path / "p.html").stat().st_mode) == 0o666 & ~mask
    assert [path.name for path in tmp_path.iterdir()] == ["p.html"]
    (tmp_path / "p.html").write_text("mine")
    again = subprocess.run(
        [sys.executable, "-m", "sweep", *words], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert again.returncode == 2
    assert_facts(again.stderr, "p.html", "--overwrite")
    assert (tmp_path / "p.html").read_text() == "mine"


INTERRUPTED = """
import os, signal, sys
import sweep.explorer.export as export
from sweep.cli import main

pack = export._deflate
def interrupted(content):
    os.kill(os.getpid(), signal.SIGINT)
    return pack(content)
export._deflate = interrupted
sys.argv = ["eulerdisk", "explore", "rolling", "roll_rate=2:3:8", "tilt=1deg:5deg:6", "--export", "p.html"]
sys.exit(main())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
def test_an_interrupted_export_says_that_nothing_was_written(tmp_path):
    """Ctrl-C ends the command with a message and the signal's status, and no file is left."""
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 128 + signal.SIGINT
    assert done.stderr.count("\n") == 1
    assert_facts(done.stderr, "eulerdisk", "interrupted", "p.html", "not written")
    assert list(tmp_path.iterdir()) == []
