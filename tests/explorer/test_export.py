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

import sweep
from sweep.errors import RequestError
from sweep.explorer.explorer import Subject, subject_of
from sweep.explorer.export import export

CHECKOUT = Path(__file__).resolve().parents[2]
SPEC = sweep.SweepSpec.preset("rolling", roll_rate="2:4:20", tilt="0.1deg:10deg:12:log", method="exact")


def held_in(path):
    """Return what a page holds, as JSON."""
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
    """Every quantity, the verdicts and the coordinates are those of the atlas, at its own resolution."""
    held, atlas = held_in(page), sweep.run(SPEC).transpose("roll_rate", "tilt")
    assert np.array_equal(array(held["x"]), atlas["tilt"].values)
    assert np.array_equal(array(held["y"]), atlas["roll_rate"].values)
    names = [each["name"] for each in held["about"]["quantities"]]
    assert {"peak_tilt", "amplification", "nutation_period", "stability", "separatrix"} <= set(names)
    assert {*names, "verdict"} == held["cells"].keys()
    for name in {*names} - {"regime"}:
        expected, found = atlas[name].values, array(held["cells"][name])
        assert np.array_equal(found.reshape(20, 12), expected.astype(found.dtype), equal_nan=True), name
    crosses = (atlas["tilt_min"] < 0.0) & (atlas["tilt_max"] > 0.0)
    regime = np.where(atlas["ending"] == 4, 4, 2 * (atlas["wells"] - 1) + crosses)
    assert np.array_equal(array(held["cells"]["regime"]).reshape(20, 12), regime)
    assert np.array_equal(array(held["cells"]["verdict"]).reshape(20, 12), atlas["stability"].values)
    assert held["starts"] == {
        "tilt_rate": 0.0, "precession_rate": 0.0, "alpha": 0.5, "radius": 0.5, "gravity": 9.81,
        "fall_tilt": float(np.radians(85.0)),
    }  # fmt: skip
    assert {line["name"] for line in held["lines"]} == {"analytic", "predicted", "measured"}
    assert held["about"]["atlas"]["live"] is False
    assert "12 x 20 cells" in held["about"]["atlas"]["note"]


def test_cells_have_the_rates_that_they_compute(tmp_path):
    """Of circling disks the page has the roll rate of every cell: a motion needs it."""
    export(subject_of("circling", {"precession_rate": "1:4:10", "tilt": "1deg:20deg:8"}), tmp_path / "a.html")
    held = held_in(tmp_path / "a.html")
    atlas = sweep.run("circling", method="exact", precession_rate="1:4:10", tilt="1deg:20deg:8")
    assert "roll_rate" not in held["starts"]
    found = array(held["cells"]["roll_rate"]).reshape(10, 8)
    assert np.array_equal(found, atlas["roll_rate"].transpose("precession_rate", "tilt").values)


def test_the_page_needs_nothing_else(page):
    """No address in it leads anywhere: modules, styles and data stand in the file, and its policy lets nothing in."""
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
    # a module at an address that holds its content finds others by name alone
    for source in sources:
        for name in re.findall(rb'^(?:import|export)\b[^;]*?from\s*"([^"]+)"', source, re.MULTILINE):
            assert name.decode() in modules


def test_words_of_an_atlas_cannot_end_the_script(tmp_path):
    """A title with a tag in it stays a text."""
    export(subject_of(SPEC.replace(title="</script><script>alert(1)</script>"), {}), tmp_path / "a.html")
    assert held_in(tmp_path / "a.html")["about"]["bases"][0]["label"].startswith("</script>")
    assert "<script>alert" not in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_what_cannot_be_exported_is_refused_and_touches_nothing(tmp_path):
    """Another ending, a file that exists, no folder, one axis and too many cells are refused in words."""
    subject = Subject(SPEC)
    path = tmp_path / "a.html"
    with pytest.raises(RequestError, match="one HTML file"):
        export(subject, tmp_path / "a.png")
    with pytest.raises(RequestError, match="no such folder"):
        export(subject, tmp_path / "b" / "a.html")
    with pytest.raises(RequestError, match="cells of two axes"):
        export(Subject(SPEC.replace(tilt=0.1)), path)
    with pytest.raises(RequestError, match="at most 1000000 cells"):
        export(Subject(SPEC.replace(tilt="1deg:2deg:1000", roll_rate="1:2:1001")), path)
    assert list(tmp_path.iterdir()) == []
    path.write_text("mine")
    with pytest.raises(RequestError, match="exists"):
        export(subject, path)
    assert path.read_text() == "mine"


def test_the_command_writes_a_page(tmp_path):
    """`eulerdisk explore SPEC WORDS --export page.html` writes it with the rights of any file, and ends with 0."""
    words = ["explore", "rolling", "alpha=1", "roll_rate=2:3:8", "tilt=1deg:5deg:6", "--export", "p.html"]
    done = subprocess.run(
        [sys.executable, "-m", "sweep", *words], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert held_in(tmp_path / "p.html")["starts"]["alpha"] == 1.0
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE((tmp_path / "p.html").stat().st_mode) == 0o666 & ~mask
    assert [path.name for path in tmp_path.iterdir()] == ["p.html"]


INTERRUPTED = """
import os, signal, sys
import sweep.explorer.export as export
from sweep.cli import main

pack = export._packed
def interrupted(values):
    os.kill(os.getpid(), signal.SIGINT)
    return pack(values)
export._packed = interrupted
sys.argv = ["eulerdisk", "explore", "rolling", "roll_rate=2:3:8", "tilt=1deg:5deg:6", "--export", "p.html"]
sys.exit(main())
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
def test_an_interrupted_export_says_that_nothing_was_written(tmp_path):
    """Ctrl-C ends the command with a sentence and the status of the signal; no file appears, and none is left."""
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 128 + signal.SIGINT
    assert done.stderr == "eulerdisk: interrupted; p.html was not written, nothing is left behind.\n"
    assert list(tmp_path.iterdir()) == []
