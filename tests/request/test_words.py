"""The words of a request: what each may say, where they come from, and which one was meant by an unknown one."""

import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.request.spec import SweepSpec
from sweep.request.spec_file import read_regular
from sweep.request.start_list import WORDS
from sweep.request.words import known_words, names, options, read_word


def refused(facts, make, *given):
    """Make a request, and return the refusal, which has to hold the facts and say what to do."""
    with pytest.raises(RequestError) as caught:
        make(*given)
    assert all(fact in str(caught.value) for fact in facts), str(caught.value)
    assert caught.value.status == 2
    assert caught.value.message
    assert caught.value.hint
    return caught.value


@pytest.mark.parametrize(
    ("words", "facts"),
    [
        ({"precesion_rate": 3}, ["precession_rate?"]),
        ({"boundary": "refined:0"}, ["width above 0", "refined:0"]),
        ({"boundary": "refined:fine"}, ["width above 0", "refined:fine"]),
        ({"boundary": "refined:inf"}, ["width above 0", "refined:inf"]),
        ({"boundary": "coarse"}, ["grid", "refined:WIDTH", "coarse"]),
        (
            {"precession_rate": "steady"},
            [
                "steady-slow asks for the slower one, steady-fast for the faster",
                "=steady-slow or precession_rate=steady-fast",
            ],
        ),
        ({"precession_rate": "steady-slo"}, ["steady-slow?"]),
        ({"roll_rate": "steaady", "precession_rate": 1.0}, ["steaady", "steady?"]),
        ({"tilt": "\u22121deg"}, ["hyphen"]),
        ({"tilt": "\u20131deg:1deg:5"}, ["hyphen"]),
        ({"xyz": 3}, ["tilt, tilt_rate, precession_rate"]),
        ({"mass": 1}, ["eulerdisk simulate"]),
        ({"alpha": 0}, ["0 is not possible", "0 < alpha <= 1"]),
        ({"alpha": 1.5}, ["1.5 is not possible", "0 < alpha <= 1"]),
        ({"alpha": "0.5,1.5"}, ["1.5 is not possible", "0.5,1.5"]),
        ({"radius": "-10cm"}, ["-10 cm is not possible", "radius > 0"]),
        ({"gravity": 0}, ["gravity > 0"]),
        ({"gravity": "0:9.81:5"}, ["gravity > 0"]),
        ({"tilt": "95deg"}, ["95 deg is not possible", "|tilt| < 90 deg", "tilt=95deg"]),
        ({"tilt": "-90deg:0:5"}, ["-90 deg is not possible"]),
        ({"tilt": 5}, ["bare number is in radians", "tilt=5deg"]),
        ({"tilt": "0:20:300"}, ["bare number is in radians"]),
        ({"tilt": [0, 5]}, ["bare number is in radians"]),
        ({"roll_rate": "quick"}, ["quick", "steady", "a number"]),
        ({"tilt_rate": "steady"}, ["steady", "a number"]),
        ({"duration": 0}, ["duration > 0"]),
        ({"duration": "1,2"}, ["one number", "axis"]),
        ({"step": "-1ms"}, ["-1 ms is not possible", "step > 0, or auto"]),
        ({"step": "automatic"}, ["automatic", "auto"]),
        ({"step": 1e-8}, ["too many steps", "100000000", "step=1e-08", "duration=300s"]),
        ({"fall_tilt": 0}, ["0 deg < fall_tilt < 90 deg"]),
        ({"fall_tilt": "90deg"}, ["90 deg is not possible"]),
        ({"fall_tilt": 80}, ["fall_tilt=80deg"]),
        ({"tolerance": 0}, ["tolerance <= 0.1 rad"]),
        ({"tolerance": 0.2}, ["tolerance <= 0.1 rad"]),
        ({"criterion": "departure:0deg"}, ["above 0"]),
        ({"criterion": 5}, ["text", "5"]),
        ({"device": "gpu"}, ["cpu or cuda", "gpu", "device=cpu or device=cuda"]),
        ({"method": "euler"}, ["rk4 or exact", "euler", "method=rk4 or method=exact"]),
        ({"method": 4}, ["text", "4"]),
        ({"contact": "maybe"}, ["no or yes", "maybe"]),
        ({"title": "two\nlines"}, ["one line"]),
        ({"title": 3}, ["text"]),
        ({"model": "sphere"}, ["sphere", "disk"]),
        (
            {"tilt": "0:1:1000000", "roll_rate": "0:1:10000000"},
            ["1000000 x 10000000", "at most 1000000000 cells"],
        ),
        ({"tilt": [0.1], "axes": ["alpha"]}, ["alpha", "tilt"]),
        ({"tilt": [0.1], "axes": []}, ["tilt"]),
        ({"tilt": [0.1], "axes": ["tilt", "tilt"]}, ["tilt"]),
        ({"tilt": [0.1], "axes": 3}, ["3", "tilt"]),
        ({"tilt": None}, ["None", "a number"]),
    ],
)
def test_an_impossible_request_is_refused(words, facts):
    """Each broken rule has a message with the key, the rule, what was given and what to do."""
    error = refused(facts, lambda: SweepSpec(**words))
    # a grid of too many cells is the fault of all axes
    assert str(error.where).partition("=")[0] in {*words, "grid"}


def test_impossible_words_are_refused():
    """A word of the command line is refused under its own name, and the word that was meant is named."""
    for words, where, facts in [
        (["alpha=0.5", "alpha=1"], "alpha", ["once", "alpha=0.5 and alpha=1"]),
        (["alpha"], "alpha", ["NAME=VALUE"]),
        (["=3"], "=3", ["NAME=VALUE"]),
        ([""], "an empty word", ["NAME=VALUE"]),
        (["mass=1"], "mass", ["eulerdisk simulate"]),
        (["g=1.6"], "g", ["gravity?"]),
        (["Theta=1.6"], "Theta", ["tilt?"]),
        (["spin_rate=3"], "spin_rate", ["roll_rate", "precession_rate"]),
        (["rollrate=3"], "rollrate", ["roll_rate?"]),
        (["alpha=2"], "alpha=2", ["2 is not possible"]),
        (["criterion=departure:0deg"], "criterion", ["above 0"]),
    ]:
        error = refused(facts, SweepSpec.from_words, "rolling", words)
        assert str(error.where).startswith(where)


def test_a_change_can_repair_a_file(spec_file):
    """Only the result has to be possible, not the file without its changes."""
    path = spec_file('roll_rate = "steady"\ntilt = "1deg:5deg:3"\n')
    assert SweepSpec.from_words(str(path), ["precession_rate=1:2:3"]).shape == (3, 3)


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("tilt = 0.1\nroll_rate = = 3\n", ["not TOML", "line 2"]),
        ("tilt = 0.1\ntilt = 0.2\n", ["not TOML", "line 2"]),
        ("tilt = 0.1\ntilt_rat = 3\n", ["tilt_rat:", "tilt_rate?"]),
        ("tilt = true\n", ["tilt=True", "a number"]),
        ("tilt = 1979-05-27\n", ["tilt=", "a number"]),
        ("[tilt]\nstart = 1\n", ["tilt=", "a number"]),
        ("tilt = nan\n", ["tilt=nan", "finite"]),
        ("alpha = 2\n", ["alpha=2", "2 is not possible"]),
        ('model = "sphere"\n', ["sphere", "disk"]),
        ("model = 3\n", ["disk"]),
    ],
)
def test_a_faulty_file_is_named(spec_file, text, facts):
    """A fault in a file is reported with the file and its line or key."""
    path = spec_file(text)
    assert str(refused(facts, SweepSpec.from_toml, path)).startswith(f"{path}: ")


@pytest.mark.parametrize(
    ("name", "facts"),
    [
        ("missing.toml", ["cannot be read", "No such file"]),
        ("", ["cannot be read"]),
        ("binary.toml", ["not TOML"]),
    ],
)
def test_a_file_that_cannot_be_read_is_named(tmp_path, name, facts):
    """A missing file, a folder and a file that is not text are refused under their paths."""
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    assert refused(facts, SweepSpec.from_toml, tmp_path / name).where == str(tmp_path / name)


def test_a_file_of_another_editor_is_read(tmp_path):
    """The mark that some editors put before UTF-8 is no part of the first line."""
    (tmp_path / "marked.toml").write_bytes(b'\xef\xbb\xbftilt = "1deg"\r\nroll_rate = 3.0\r\n')
    assert SweepSpec.from_toml(tmp_path / "marked.toml").roll_rate == 3.0


def test_changes_without_a_spec_are_told_so():
    """Who leaves the preset out is told to name one first."""
    refused(["Name a preset", "rolling roll_rate=2:4:3"], SweepSpec.from_words, "roll_rate=2:4:3", [])


def test_an_unknown_preset_is_refused():
    """The message lists the presets and names the nearest."""
    refused(["circling, rolling, spinning", "roling", "rolling?"], SweepSpec.preset, "roling")


def test_a_fault_that_a_preset_brings_is_placed_in_the_preset():
    """If a change makes a word of the preset impossible, the message says where that word stands."""
    error = refused(["roll_rate=steady"], SweepSpec.from_words, "rolling", ["roll_rate=steady"])
    assert error.where == "preset rolling: precession_rate"


def test_every_word_has_a_name_of_its_own():
    """Parameters, settings and options do not share a name: a word of a request says one thing."""
    known = names(DISK)
    assert len(known) == len(set(known))
    assert set(known) == {*DISK.parameters, *DISK.settings, *options(DISK), *WORDS}
    assert set(DISK.synonyms.values()) <= {*known_words(DISK), "mass"}


@given(st.dictionaries(st.sampled_from([*known_words(DISK), "axes", "model"]), st.one_of(
    st.none(), st.booleans(), st.integers(-100, 100), st.floats(), st.text(max_size=5), st.binary(max_size=3),
    st.lists(st.one_of(st.floats(), st.text(max_size=3)), max_size=3), st.just({"start": 1}),
)))  # fmt: skip
def test_whatever_is_given_is_read_or_refused(words):
    """Whatever is given, a request is either read or refused with a RequestError."""
    try:
        SweepSpec(**words)
    except RequestError:
        return


def test_the_width_of_a_boundary_is_a_number_in_ascii():
    """Digits of other scripts, underscores and units are no width."""
    for width in ["\uff11e-6", "1_0e-6", "1e-6 m", "nan", "inf", "0"]:
        with pytest.raises(RequestError, match="boundary is grid, refined or refined:WIDTH"):
            read_word("boundary", f"refined:{width}", DISK)


def test_a_file_that_is_missing_is_refused_with_every_preset(tmp_path):
    """Those of all models, as where no preset has the name."""
    with pytest.raises(RequestError, match=r"preset: circling, rolling, spinning, .*toy.* Check the path"):
        SweepSpec.from_toml(tmp_path / "none.toml")


def test_a_file_is_read_up_to_its_limit(tmp_path):
    """All bytes of a file, or a refusal that says how many it has."""
    path = tmp_path / "a"
    path.write_bytes(b"abc")
    assert read_regular(path, 3) == b"abc"
    with pytest.raises(OSError, match="3 bytes or more, of at most 2"):
        read_regular(path, 2)


def test_what_is_no_file_is_not_waited_for(tmp_path):
    """A pipe without a writer, a device without an end and a folder are refused at once."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "zero").symlink_to("/dev/zero")
    for name in ("pipe", "zero"):
        with pytest.raises(OSError, match="not a regular file"):
            read_regular(tmp_path / name, 10)
    with pytest.raises(IsADirectoryError):
        read_regular(tmp_path, 10)


def test_a_file_without_a_size_has_a_limit_too():
    """What the system says is empty, and is not, is read no further than the limit."""
    with pytest.raises(OSError, match="of at most 5"):
        read_regular("/proc/self/environ", 5)
