import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.errors import RequestError
from sweep.request.spec import SweepSpec


@pytest.mark.parametrize("text", ["", "[]", "{}", "3", '{"tilt": 0.1}', "{'tilt': 0.1}"])
def test_other_text_is_not_canonical(text):
    """What `canonical` did not write is refused, missing words included."""
    with pytest.raises(RequestError, match="not the canonical text"):
        SweepSpec.from_canonical(text)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"precesion_rate": 3}, r"precesion_rate: unknown word.*did you mean precession_rate\?"),
        ({"boundary": "refined:0"}, "a width above 0"),
        ({"boundary": "refined:fine"}, "not a way to look for the boundary"),
        ({"boundary": "coarse"}, "grid, refined or refined:WIDTH"),
        ({"precession_rate": "steady"}, r"or steady-slow or steady-fast.*did you mean steady-slow\?"),
        ({"roll_rate": "steaady", "precession_rate": 1.0}, r"did you mean steady\?"),
        ({"tilt": "\u22121deg"}, "write the minus sign as a hyphen"),
        ({"tilt": "\u20131deg:1deg:5"}, "write the minus sign as a hyphen"),
        ({"xyz": 3}, "unknown word.*the words are tilt, tilt_rate"),
        ({"mass": 1}, "unknown word"),
        ({"alpha": 0}, "alpha: 0 is not possible.*0 < alpha <= 1"),
        ({"alpha": 1.5}, "0 < alpha <= 1"),
        ({"alpha": "0.5,1.5"}, "alpha: 1.5 is not possible"),
        ({"radius": "-10cm"}, "radius: -0.1 m is not possible"),
        ({"gravity": 0}, "gravity > 0"),
        ({"gravity": "0:9.81:5"}, "gravity > 0"),
        ({"tilt": "95deg"}, r"^tilt: .*95 deg.*\|tilt\| < 90 deg.*tilt=95deg"),
        ({"tilt": "-90deg:0:5"}, "tilt: -90 deg is not possible"),
        ({"tilt": 5}, "bare number is in radians.*tilt=5deg"),
        ({"tilt": "0:20:300"}, "bare number is in radians"),
        ({"tilt": [0, 5]}, "bare number is in radians"),
        ({"roll_rate": "steady"}, "steady needs a precession_rate other than 0"),
        ({"roll_rate": "steady", "precession_rate": [0.0]}, "steady needs a precession_rate other than 0"),
        (
            {"roll_rate": "quick"},
            r"^roll_rate: .*or steady; .*write a value, or roll_rate=steady\.",
        ),
        ({"tilt_rate": "steady"}, "tilt_rate: not a value"),
        ({"duration": 0}, "duration > 0"),
        ({"duration": "1,2"}, "one number for all cells"),
        ({"step": "-1ms"}, "step: -0.001 s is not possible"),
        ({"step": "automatic"}, "step: not a value"),
        ({"step": 1e-8}, "too many steps"),
        ({"fall_tilt": 0}, r"^fall_tilt: .*0 deg < fall_tilt < 90 deg"),
        ({"device": "gpu"}, r"^device: .*cpu or cuda.*write device=cpu or device=cuda\."),
        ({"fall_tilt": "90deg"}, "fall_tilt: 90 deg is not possible"),
        ({"fall_tilt": 80}, "fall_tilt=80deg"),
        ({"tolerance": 0}, "tolerance <= 0.1 rad"),
        ({"tolerance": 0.2}, "tolerance <= 0.1 rad"),
        ({"criterion": "departure:0deg"}, "criterion: .*above 0"),
        ({"criterion": 5}, "criterion: not text"),
        ({"method": "euler"}, "method: unknown method.*method is rk4 or exact"),
        ({"method": 4}, "method: not text"),
        ({"title": "two\nlines"}, "title: not a title"),
        ({"tilt": "0:1:1000000", "roll_rate": "0:1:10000000"}, "grid: too many cells"),
        ({"tilt": [0.1], "axes": ["alpha"]}, "axes: not an order"),
        ({"tilt": [0.1], "axes": []}, "axes: not an order"),
        ({"tilt": [0.1], "axes": 3}, "axes: not an order"),
        ({"tilt": None}, "tilt: not a value"),
    ],
)
def test_an_impossible_request_is_refused(words, message):
    """Each broken rule has one message that names the key, the rule, what was given and what to do."""
    with pytest.raises(RequestError, match=message) as caught:
        SweepSpec(**words)
    assert all((caught.value.where, caught.value.message, caught.value.hint))


def test_circling_may_pass_through_zero_precession():
    """An axis of precession rates through 0 is accepted: that one cell will be invalid, the others not."""
    assert SweepSpec(roll_rate=" steady ", precession_rate="-1:1:3", tilt=0.1).circling


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["alpha=0.5", "alpha=1"], "alpha: given twice.*alpha=0.5 and alpha=1"),
        (["alpha"], "not a NAME=VALUE word"),
        (["=3"], "not a NAME=VALUE word.*got =3"),
        (["mass=1"], "leave it out: it is a word of eulerdisk simulate"),
        (["g=1.6"], r"did you mean gravity\?"),
        (["spin_rate=3"], "say roll_rate.*or precession_rate"),
        ([""], "not a NAME=VALUE word"),
        (["rollrate=3"], r"did you mean roll_rate\?"),
        (["alpha=2"], "^alpha: 2 is not possible"),
        (["criterion=departure:0deg"], "^criterion: "),
    ],
)
def test_impossible_words_are_refused(words, message):
    """A word of the command line is refused under its own name."""
    with pytest.raises(RequestError, match=message):
        SweepSpec.from_words("rolling", words)


def test_a_change_can_repair_a_file(spec_file):
    """Only the result has to be possible, not the file without its changes."""
    path = spec_file('roll_rate = "steady"\ntilt = "1deg:5deg:3"\n')
    assert SweepSpec.from_words(str(path), ["precession_rate=1:2:3"]).shape == (3, 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tilt = 0.1\nroll_rate = = 3\n", "not TOML.*line 2"),
        ("tilt = 0.1\ntilt = 0.2\n", "not TOML.*line 2"),
        ("tilt = 0.1\ntilt_rat = 3\n", r"tilt_rat: unknown word.*did you mean tilt_rate\?"),
        ("tilt = true\n", "tilt: not a value"),
        ("tilt = 1979-05-27\n", "tilt: not a value"),
        ("[tilt]\nstart = 1\n", "tilt: not a value"),
        ("tilt = nan\n", "tilt: not a finite number"),
        ("alpha = 2\n", "alpha: 2 is not possible"),
    ],
)
def test_a_faulty_file_is_named(spec_file, text, message):
    """A fault in a file is reported with the file and its line or key."""
    path = spec_file(text)
    with pytest.raises(RequestError, match=message) as caught:
        SweepSpec.from_toml(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    """A missing file, a folder and a file that is not text are refused under their paths."""
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    for name, message in [
        ("missing.toml", "cannot be read"),
        ("", "cannot be read"),
        ("binary.toml", "not TOML"),
    ]:
        with pytest.raises(RequestError, match=message) as caught:
            SweepSpec.from_toml(tmp_path / name)
        assert str(caught.value).startswith(f"{tmp_path / name}: ")


def test_a_file_of_another_editor_is_read(tmp_path):
    """The mark that some editors put before UTF-8 is no part of the first line."""
    (tmp_path / "marked.toml").write_bytes(b'\xef\xbb\xbftilt = "1deg"\r\nroll_rate = 3.0\r\n')
    assert SweepSpec.from_toml(tmp_path / "marked.toml").roll_rate == 3.0


def test_changes_without_a_spec_are_told_so():
    """Who leaves the preset out is told to name one first."""
    with pytest.raises(RequestError, match="before the changes, as in rolling roll_rate=2:4:3"):
        SweepSpec.from_words("roll_rate=2:4:3", [])


def test_an_unknown_preset_is_refused():
    """The message lists the presets and names the nearest."""
    with pytest.raises(
        RequestError, match=r"presets are circling, rolling, spinning.*did you mean rolling\?"
    ):
        SweepSpec.preset("roling")


def test_a_fault_that_a_preset_brings_is_placed_in_the_preset():
    """If a change makes a word of the preset impossible, the message says where that word stands."""
    with pytest.raises(RequestError, match=r"^preset rolling: precession_rate: "):
        SweepSpec.from_words("rolling", ["roll_rate=steady"])


@given(st.dictionaries(st.sampled_from(list(SweepSpec.model_fields)), st.one_of(
    st.none(), st.booleans(), st.integers(-100, 100), st.floats(), st.text(max_size=5), st.binary(max_size=3),
    st.lists(st.one_of(st.floats(), st.text(max_size=3)), max_size=3), st.just({"start": 1}),
)))  # fmt: skip
def test_pydantic_is_never_heard(words):
    """Whatever is given, a request is either read or refused with a RequestError."""
    try:
        SweepSpec(**words)
    except RequestError:
        return
