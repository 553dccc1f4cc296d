"""The inputs of a request: their allowed values, their origin, and suggestions for unknown ones."""

from hypothesis import given
from hypothesis import strategies as st
from messages import refused

from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.request.spec import SweepSpec
from sweep.request.start_list import WORDS
from sweep.request.words import known_words, names, options, read_word


def refusal(facts, make, *given):
    """Make a request, and return the refusal, which must have the facts and a hint."""
    with refused(*facts) as caught:
        make(*given)
    assert caught.value.status == 2
    assert caught.value.message
    assert caught.value.hint
    return caught.value


def test_an_impossible_request_is_refused():
    """The message for each broken rule has the input, the rule, the given value and the remedy."""
    for words, facts in [
        ({"boundary": "refined:0"}, ["boundary=refined:0", "refined:WIDTH"]),
        ({"boundary": "coarse"}, ["grid", "refined:WIDTH", "coarse"]),
        (
            {"precession_rate": "steady"},
            ["steady-slow", "precession_rate=steady-fast"],
        ),
        ({"precession_rate": "steady-slo"}, ["steady-slow?"]),
        ({"tilt": "\u20131deg:1deg:5"}, ["hyphen"]),
        ({"alpha": "0.5,1.5"}, ["1.5", "alpha=0.5,1.5", "0 < alpha <= 1"]),
        ({"gravity": "0:9.81:5"}, ["gravity > 0"]),
        ({"tilt": "-90deg:0:5"}, ["-90 deg", "|tilt| < 90 deg"]),
        ({"tilt": 5}, ["radians", "tilt=5deg"]),
        ({"tilt": [0, 5]}, ["radians", "5"]),
        ({"roll_rate": "quick"}, ["quick", "steady", "number"]),
        ({"duration": "1,2"}, ["duration=1,2", "one number"]),
        ({"step": "-1ms"}, ["-1 ms", "step > 0", "auto"]),
        ({"step": 1e-8}, ["100000000", "step=1e-08s", "duration=300s"]),
        ({"fall_tilt": 80}, ["fall_tilt=80deg"]),
        ({"tolerance": 0.2}, ["tolerance <= 0.1 rad"]),
        ({"criterion": 5}, ["text", "5"]),
        ({"method": 4}, ["text", "4"]),
        ({"contact": "maybe"}, ["contact=no", "contact=yes", "maybe"]),
        ({"title": "two\nlines"}, ["title", "one line"]),
        ({"tilt": "0:1:1000000", "roll_rate": "0:1:10000000"}, ["1000000 x 10000000", "1000000000"]),
        ({"tilt": [0.1], "axes": ["alpha"]}, ["alpha", "tilt"]),
        ({"tilt": [0.1], "axes": ["tilt", "tilt"]}, ["tilt"]),
        ({"tilt": [0.1], "axes": 3}, ["3", "tilt"]),
        ({"tilt": None}, ["None", "number"]),
    ]:
        error = refusal(facts, lambda words=words: SweepSpec(**words))
        # A grid with too many cells is the fault of all axes.
        assert str(error.where).partition("=")[0] in {*words, "grid"}


def test_impossible_words_are_refused():
    """A word of the command line is refused by name, with the most likely intended word."""
    for words, where, facts in [
        (["alpha"], "alpha", ["NAME=VALUE"]),
        (["=3"], "=3", ["NAME=VALUE"]),
        ([""], "an empty word", ["NAME=VALUE"]),
        (["Theta=1.6"], "Theta", ["tilt?"]),
        (["spin_rate=3"], "spin_rate", ["roll_rate", "precession_rate"]),
        (["rollrate=3"], "rollrate", ["roll_rate?"]),
    ]:
        assert str(refusal(facts, SweepSpec.from_words, "rolling", words).where).startswith(where)


def test_a_faulty_file_is_named(spec_file, tmp_path):
    """A fault is reported with the file and its line or key; so is an unreadable file."""
    for text, facts in [
        ("tilt = 0.1\nroll_rate = = 3\n", ["TOML", "line 2"]),
        ("tilt = 0.1\ntilt_rat = 3\n", ["tilt_rat:", "tilt_rate?"]),
        ("tilt = 1979-05-27\n", ["tilt=datetime.date(1979, 5, 27)", "number"]),
        ("[tilt]\nstart = 1\n", ["tilt={'start': 1}", "number"]),
        ("tilt = nan\n", ["tilt=nan", "finite"]),
        ("alpha = 2\n", ["alpha=2", "0 < alpha <= 1"]),
        ('model = "sphere"\n', ["sphere", "disk"]),
    ]:
        path = spec_file(text)
        assert str(refusal(facts, SweepSpec.from_toml, path)).startswith(f"{path}: ")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    for name, fact in [("missing.toml", "No such file"), ("", "Is a directory"), ("binary.toml", "TOML")]:
        assert refusal([fact], SweepSpec.from_toml, tmp_path / name).where == str(tmp_path / name)


def test_a_change_can_repair_a_file(spec_file):
    """Only the result must be valid, not the file without its changes."""
    path = spec_file('roll_rate = "steady"\ntilt = "1deg:5deg:3"\n')
    assert SweepSpec.from_words(str(path), ["precession_rate=1:2:3"]).shape == (3, 3)


def test_a_file_of_another_editor_is_read(tmp_path):
    """The byte order mark of some editors is not part of the first line."""
    (tmp_path / "marked.toml").write_bytes(b'\xef\xbb\xbftilt = "1deg"\r\nroll_rate = 3.0\r\n')
    assert SweepSpec.from_toml(tmp_path / "marked.toml").roll_rate == 3.0


def test_a_fault_that_a_preset_brings_is_placed_in_the_preset():
    """If a change makes an input of the preset impossible, the message names the preset."""
    error = refusal(["roll_rate=steady"], SweepSpec.from_words, "rolling", ["roll_rate=steady"])
    assert error.where == "preset rolling: precession_rate"


def test_every_word_has_a_name_of_its_own():
    """Parameters, settings and options share no names, so each input has one meaning."""
    known = names(DISK)
    assert len(known) == len(set(known))
    assert set(known) == {*DISK.parameters, *DISK.settings, *options(DISK), *WORDS}
    assert set(DISK.synonyms.values()) <= {*known_words(DISK), "mass"}


@given(st.dictionaries(st.sampled_from([*known_words(DISK), "axes", "model"]), st.one_of(
    st.none(), st.booleans(), st.integers(-100, 100), st.floats(), st.text(max_size=5), st.binary(max_size=3),
    st.lists(st.one_of(st.floats(), st.text(max_size=3)), max_size=3), st.just({"start": 1}),
)))  # fmt: skip
def test_anything_is_read_or_refused(words):
    """Any values give either a request or a RequestError."""
    try:
        SweepSpec(**words)
    except RequestError:
        return


def test_the_width_of_a_boundary_is_a_number_in_ascii():
    """Digits of other scripts, underscores and units are refused."""
    for width in ["\uff11e-6", "1_0e-6", "1e-6 m", "nan", "inf", "0"]:
        with refused(f"boundary=refined:{width}", "grid", "refined:WIDTH"):
            read_word("boundary", f"refined:{width}", DISK)
