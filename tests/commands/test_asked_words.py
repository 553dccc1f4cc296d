"""Answers use the user's words: a request for a speed is answered in speeds."""

import json
import math
import pickle
import re

import numpy as np
import pytest
from messages import assert_facts, missing, row

import sweep
from sweep.atlas.outlook import one_sided
from sweep.checks.explain import explain
from sweep.commands.report import boundary_table, describe
from sweep.request.spec import SweepSpec
from sweep.runs.run import run_to_file

pytestmark = pytest.mark.compiled

#: sqrt(R/g) of the disk below.
UNIT = math.sqrt(0.2 / 9.81)

DISK = "radius=0.2 gravity=9.81"

#: For each substitute word: a request, the parameter it replaces, and the conversion from that parameter.
ASKED = {
    "speed": ("rolling speed=0.7:1.2:6 tilt=1deg:3deg:3", "roll_rate", lambda rate: 0.2 * rate),
    "scaled_roll_rate": ("rolling scaled_roll_rate=0.4:0.9:6 tilt=1deg:3deg:3", "roll_rate", lambda rate: UNIT * rate),
    "scaled_precession_rate": (
        "spinning scaled_precession_rate=0.6:3:6 tilt=0.2deg:3deg:3", "precession_rate", lambda rate: UNIT * rate,
    ),
    "inclination": ("rolling roll_rate=4:7:7 inclination=87deg:89deg:3", "tilt", lambda tilt: math.pi / 2 - tilt),
    "scaled_tilt_rate": (
        "rolling roll_rate=4:7:7 tilt=1deg scaled_tilt_rate=0:0.02:3", "tilt_rate", lambda rate: UNIT * rate,
    ),
}  # fmt: skip


@pytest.fixture(params=ASKED)
def asked(request, monkeypatch):
    """Return a substitute word, its parameter, the conversion, and an atlas that was requested with the word."""
    words, parameter, convert = ASKED[request.param]
    preset, *words = (words + " " + DISK).split()
    atlas = sweep.run(SweepSpec.from_words(preset, words))
    return request.param, parameter, convert, atlas


def test_the_boundary_is_told_in_the_word_that_was_asked_for(asked):
    """The table's headers name only the word, and each number is the converted value of the file."""
    word, parameter, convert, atlas = asked
    head, *lines = (re.split(r" {2,}", line.strip()) for line in boundary_table(atlas).splitlines())
    assert parameter not in re.findall(r"(?:boundary_|^)(\w+)", " ".join(each.split()[0] for each in head))
    (control,) = {"roll_rate", "precession_rate"} & {*atlas.ending.dims}
    if parameter == control:
        assert head[1].split()[0] == f"boundary_{word}"
        names = (f"boundary_{parameter}", f"boundary_{parameter}_halfwidth", f"critical_{parameter}")
        stored = np.transpose([convert(atlas[name].values) for name in names])
        shown = [[math.nan if line[i] == "-" else float(line[i]) for i in (1, 2, 4)] for line in lines]
        assert np.isfinite(stored[0]).all()
        np.testing.assert_allclose(shown, stored, rtol=2e-5)
    else:
        units = {"inclination": " [deg]"}.get(word, "")
        assert head[0] == f"{word}{units}"
        scale = 180.0 / math.pi if units else 1.0
        shown = [float(line[0]) for line in lines]
        assert shown == pytest.approx([scale * convert(each) for each in atlas[parameter].values], rel=1e-5)


def test_an_atlas_and_a_cell_are_told_in_it(asked):
    """`info` gives the word's range and its parameter; `explain` uses the word if its own request does."""
    word, parameter, convert, atlas = asked
    units, scale = {"speed": (" m s-1", 1.0), "inclination": (" deg", 180.0 / math.pi)}.get(word, ("", 1.0))
    values = atlas[parameter].values
    low, high = sorted(scale * convert(values[[0, -1]]))
    told = describe(atlas)
    line = row(told, f"  {word}")
    assert_facts(line, f"{low:.6g} to {high:.6g}{units}", f"{values.size} values", "linear", parameter)
    control = next(name for name in atlas.ending.dims if name in ("roll_rate", "precession_rate"))
    shown = word if parameter == control else control
    assert_facts(row(told, "boundary"), f"stable above {shown}", f"along {shown}")
    assert shown == control or control not in row(told, "boundary").replace(shown, "")
    at = {name: float(atlas[name][0]) for name in atlas.ending.dims}
    others = {name: value for name, value in at.items() if name != parameter}
    own = convert(at[parameter])
    for given, is_told in (({**others, word: own}, True), (at, False)):
        text = explain(atlas, given).text
        assert (missing(row(text, "cell"), [f"{word} {scale * own:.6g}"]) == []) == is_told
        boundary = row(text, "boundary")
        assert (missing(boundary, [f"stable above {word}"]) == []) == (is_told and parameter == control)


def test_a_range_on_one_side_is_told_in_it():
    """The suggested range uses the word of the request, can be pasted and contains the boundary."""
    words = ["radius=0.2", "speed=0.1:0.3:5", "tilt=1deg,2deg"]
    (warning,) = one_sided(SweepSpec.from_words("rolling", words))
    assert warning.startswith("speed=0.1:0.3:5 ")
    assert_facts(warning, "unstable")
    offered = warning.rpartition(" ")[2]
    assert re.match(r"speed=[\d.]+:[\d.]+:5$", offered)
    assert one_sided(SweepSpec.from_words("rolling", [words[0], offered, words[2]])) == []


def test_a_word_that_means_another_rate_in_each_cell_is_not_used():
    """With several radii a speed is not unique, so the report uses the file's own parameter."""
    atlas = sweep.run(SweepSpec(roll_rate="2:6:5", tilt="1deg", radius="0.2,0.4"))
    assert "boundary_roll_rate [rad s-1]" in boundary_table(atlas, ["speed"])


def test_python_and_a_file_ask_in_words_too(tmp_path):
    """The atlas keeps the words and their units, also in the file of an interrupted run."""
    given = {"radius": 0.2, "speed": "0.7 m/s:1.2 m/s:6", "tilt": "1deg:3deg:3"}
    atlas = sweep.run("rolling", **given)
    assert (
        json.loads(atlas.attrs["requested_as"]).items()
        >= {"speed": given["speed"], "tilt": given["tilt"]}.items()
    )
    assert pickle.loads(pickle.dumps(atlas.eulerdisk.spec)).requested == atlas.eulerdisk.spec.requested
    assert "boundary_speed [m s-1]" in boundary_table(atlas)
    file = tmp_path / "speeds.toml"
    file.write_text('radius = 0.2\nspeed = "0.7:1.2:6"\ntilt = "1deg:3deg:3"\n')
    spec, asked = SweepSpec.from_toml(file), iter(range(1000))
    with pytest.raises(sweep.StoppedError):
        run_to_file(spec, tmp_path / "a.nc", block_cells=5, stopping=lambda: next(asked) > 1)
    # resuming reads the folder, which has only the rate
    run_to_file(SweepSpec.from_canonical(spec.canonical()), tmp_path / "a.nc")
    with sweep.open_atlas(tmp_path / "a.nc") as stored:
        assert json.loads(stored.attrs["requested_as"]) == dict(spec.requested)
        assert "boundary_speed [m s-1]" in boundary_table(stored)
