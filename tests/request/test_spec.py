"""The request for an atlas: the same in Python, TOML and words, stored as text, and immutable."""

import math
import os
import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from messages import assert_facts, refused

from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.request.criterion import Criterion
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.spec_file import presets

POSITIVE = st.floats(1e-3, 1e3)
AXES = st.one_of(
    POSITIVE,
    st.builds(lambda start, count: Range(start, 2 * start, count, "log"), POSITIVE, st.integers(2, 60)),
    st.lists(POSITIVE, min_size=1, max_size=4, unique=True).map(lambda values: Values(tuple(sorted(values)))),
)
SPECS = st.builds(
    lambda words, **rest: SweepSpec(**dict(words), **rest),
    st.dictionaries(
        st.sampled_from(["precession_rate", "roll_rate", "radius", "gravity", "tilt_rate"]), AXES
    ).flatmap(lambda words: st.permutations(list(words.items()))),
    criterion=st.builds(lambda limit: Criterion("amplification", limit), POSITIVE),
    duration=POSITIVE,
    step=st.one_of(st.just("auto"), POSITIVE),
    title=st.text(st.characters(categories=["L", "N", "P", "S"]), max_size=20),
)


def test_an_empty_request_is_one_cell():
    """Without inputs it is one cell of the default disk, at rest and upright, judged by 5 degrees."""
    spec = SweepSpec()
    assert (spec.axes, spec.shape, spec.size, spec.computed) == ((), (), 1, ())
    assert spec.fixed == tuple(DISK.parameters)
    assert spec.model is DISK
    assert (spec.tilt, spec.alpha, spec.radius, spec.gravity) == (0.0, 0.5, 0.5, 9.81)
    assert (spec.step, spec.tolerance, spec.method) == ("auto", 1e-8, "rk4")
    assert spec.fall_tilt == math.radians(85)
    assert spec.criterion == Criterion("departure", math.radians(5))


def test_python_toml_and_words_say_the_same(spec_file):
    """The same inputs give equal specs in Python, in a file and on the command line."""
    python = SweepSpec(
        roll_rate=Range(0.5, 6, 400), tilt="1deg:5deg:3", alpha=[0.5, 1], criterion="departure:2deg"
    )
    path = spec_file(
        'roll_rate = "0.5:6:400"\ntilt = "1deg:5deg:3"\nalpha = [0.5, 1]\ncriterion = "departure:2deg"\n'
    )
    words = ["roll_rate=0.5:6:400", "tilt=1deg:5deg:3", "alpha=0.5,1", "criterion=departure:2deg"]
    assert SweepSpec.from_toml(path) == python
    assert SweepSpec.from_words(spec_file(""), words) == python
    assert python.replace(alpha=np.array([0.5, 1.0])) == python


def test_axes_are_in_the_order_given():
    """The dimensions are the ranges and lists in the order of the inputs; numbers are no dimensions."""
    spec = SweepSpec(alpha="0.5,1", tilt="1deg:5deg:3", radius=1, roll_rate=[2.0])
    assert (spec.axes, spec.shape, spec.size) == (("alpha", "tilt", "roll_rate"), (2, 3, 1), 6)
    assert SweepSpec(tilt="1deg:5deg:3", alpha="0.5,1") != SweepSpec(alpha="0.5,1", tilt="1deg:5deg:3")
    assert SweepSpec(tilt="1deg:5deg:3", alpha="0.5,1", axes=["alpha", "tilt"]).shape == (2, 3)


def test_changes_keep_the_place_of_an_axis(spec_file):
    """A changed axis keeps its place, a new one comes last, a removed one disappears."""
    path = spec_file('roll_rate = "2:4:5"\ntilt = "1deg:5deg:3"\n')
    changed = SweepSpec.from_words(path, ["radius=1,2", "alpha=0.5,1", "roll_rate=1:2:7"])
    assert (changed.axes, changed.shape) == (("roll_rate", "tilt", "radius", "alpha"), (7, 3, 2, 2))
    replaced = SweepSpec.from_toml(path).replace(radius="1,2", alpha="0.5,1", roll_rate="1:2:7")
    assert replaced == changed
    assert SweepSpec.from_toml(path).replace(roll_rate=3).axes == ("tilt",)


def test_the_presets_straddle_the_critical_rates():
    """For the released presets the range contains the uniform disk's critical rates, g/3R and 4g/5R."""
    assert presets(DISK) == ("circling", "rolling", "spinning")
    rolling, spinning = SweepSpec.preset("rolling").roll_rate, SweepSpec.preset("spinning").precession_rate
    assert rolling.start**2 < 9.81 / (3 * 0.5) < rolling.stop**2
    assert spinning.start**2 < 4 * 9.81 / (5 * 0.5) < spinning.stop**2


@given(SPECS)
def test_a_spec_reads_back_from_its_texts(tmp_path_factory, spec):
    """TOML, canonical text, Python arguments, pickle and `repr` all restore the same spec, bit for bit."""
    path = tmp_path_factory.mktemp("spec") / "sweep.toml"
    path.write_text(spec.to_toml(), encoding="utf-8")
    for same in (
        SweepSpec.from_toml(path),
        SweepSpec.from_canonical(spec.canonical()),
        pickle.loads(pickle.dumps(spec)),
        spec.replace(),
        eval(repr(spec)),
    ):
        assert same == spec
        assert hash(same) == hash(spec)
        assert same.fingerprint() == spec.fingerprint()


def test_a_spec_cannot_be_changed():
    """Assignment is refused with a reference to `replace`; an unknown name raises AttributeError."""
    spec = SweepSpec()
    with refused("spec.replace(tilt=...)") as caught:
        spec.tilt = 0.2
    assert caught.value.where == "tilt"
    assert spec.tilt == 0.0
    with refused("mass", error=AttributeError):
        _ = spec.mass
    assert not hasattr(spec, "_missing")


def test_a_spec_is_a_value():
    """Equal specs are one element of a set, however they were given; other objects are never equal."""
    spec = SweepSpec(tilt="1deg:5deg:3", radius="50cm")
    assert spec == SweepSpec(tilt=Range(math.radians(1), math.radians(5), 3), radius=0.5)
    assert len({spec, spec.replace(), SweepSpec(tilt="1deg:5deg:3"), SweepSpec(tilt="1deg:5deg:4")}) == 2
    assert spec != spec.canonical()


def test_headline_says_what_is_looked_at():
    """A changed preset gets a fitting headline; a user's own title stays."""
    for preset, changes, facts in [
        ("rolling", {}, ["Rolling along a line", "upright"]),
        ("rolling", {"alpha": 1.0}, ["Rolling along a line", "upright"]),
        ("rolling", {"precession_rate": 0.5}, ["Rolling", "precessing", "upright"]),
        ("rolling", {"precession_rate": "steady-slow"}, ["Circling", "steady"]),
        ("spinning", {}, ["Spinning", "vertical", "upright"]),
        ("spinning", {"precession_rate": 0.0}, ["Neither", "rolling", "spinning", "upright"]),
        ("circling", {}, ["Circling", "steady"]),
        ("circling", {"roll_rate": "1:3:5"}, ["Rolling", "precessing", "upright"]),
    ]:
        assert_facts(SweepSpec.preset(preset).replace(**changes).headline, *facts)
    assert SweepSpec.preset("circling", title="Mine", alpha=1.0).headline == "Mine"


def test_a_spec_file_that_nests_without_end_is_refused(spec_file):
    """Arrays, tables and dotted keys nested too deeply for the parser are refused with the file name."""
    for text in ["a = " + "[" * 100_000, "a = " + "{b = " * 5000, ".".join("a" * 20_000) + " = 1"]:
        with refused("sweep.toml:", "nested"):
            SweepSpec.from_toml(spec_file(text))


def test_a_spec_is_a_small_file(tmp_path):
    """A pipe, a device and a file over one megabyte are refused before they are read."""
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "zero.toml").symlink_to("/dev/zero")
    (tmp_path / "large.toml").write_text("# \n" * 400_000, encoding="utf-8")
    for name, facts in (
        ("pipe", ["regular file"]),
        ("zero", ["regular file"]),
        ("large", ["1200000 bytes", "1048576"]),
    ):
        with refused(f"{name}.toml:", *facts):
            SweepSpec.from_toml(tmp_path / f"{name}.toml")


def test_any_word_of_a_file_is_a_word(spec_file):
    """A file may contain the names of Python arguments, or counts beyond any machine number."""
    with refused("sweep.toml:", "self"):
        SweepSpec.from_toml(spec_file("self = 1"))
    held = SweepSpec.preset("rolling").canonical()
    for count in (2**62, 10**400):
        with refused("1099511627776"):
            SweepSpec.from_canonical(re.sub(r'"count":\d+', f'"count":{count}', held, count=1))


def test_words_of_other_models_are_suggested_too():
    """A misspelled loss would have chosen the lossy disk."""
    for word, fact in [
        ("rolling_frcition", "rolling_friction?"),
        ("friktion", "friction?"),
        ("friction", "rolling_friction=10um"),
        ("tillt", "tilt?"),
    ]:
        with pytest.raises(RequestError) as caught:
            SweepSpec(**{word: 1e-5})
        assert_facts(caught.value.hint, fact)
