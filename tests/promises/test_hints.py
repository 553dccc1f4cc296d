"""The advice of each refusal works: these tests follow each hint to the letter."""

import re
import shlex

import pytest
import xarray as xr
from messages import assert_facts

import sweep
from sweep.atlas.dataset import spec_of
from sweep.atlas.selection import selected_spec
from sweep.errors import RequestError
from sweep.figures.look import Look
from sweep.request.system_file import read_system

PURE = "@system({words})\ndef decay(x=1.0, *, rate=0.5):\n    return -rate*x\n"
UNITS = '@system({words})\ndef decay(x: "m" = 1.0, *, rate: "1/s" = 0.5):\n    return -rate*x\n'
TWO = '@system(duration="10")\ndef swing(x=1.0, v=0.0):\n    {line}\n'


def hint_of(ask):
    """Return the hint of the refusal that a call raises."""
    with pytest.raises(RequestError) as caught:
        ask()
    return caught.value.hint


def advised(hint):
    """Return the words that a hint says to write, after Write or Use; of two alternatives the first."""
    found = re.search(
        r"(?:Write|Use) (?:it without: )?(.*?)(?: in Python| above it, or .*|, or .*| or .*)?\.$", hint
    )
    assert found, hint
    return found[1]


@pytest.mark.parametrize("text", [PURE, UNITS], ids=["pure", "units"])
@pytest.mark.parametrize(
    "words", ["", '"10 s"', "duration=-1", "duration=[10]", 'duration="soon"', 'duration={"a": 1}'], ids=repr
)
def test_durations_of_systems(text, words):
    """The suggested duration fits the units of the arguments."""
    advice = advised(hint_of(lambda: read_system(text.format(words=words))))
    read_system(text.format(words=advice) if "@" not in advice else text.replace("@system({words})", advice))


@pytest.mark.parametrize("text", [PURE, UNITS], ids=["pure", "units"])
def test_marks_of_systems(text):
    """A decorator without arguments, and a function without a decorator, get working advice."""
    for head in ("@system", "@other"):
        advice = advised(hint_of(lambda head=head: read_system(text.replace("@system({words})", head))))
        read_system(text.replace("@system({words})", advice))


def test_a_duration_of_other_units_than_the_arguments():
    """A unit where the arguments have none, and a missing one where they have units, get working advice."""
    for text, wrong in ((PURE, 'duration="10 s"'), (UNITS, 'duration="10"')):
        hint = hint_of(lambda text=text, wrong=wrong: read_system(text.format(words=wrong)))
        read_system(text.format(words=re.search(r'duration="[^"]*"', hint)[0]))


@pytest.mark.parametrize(
    ("word", "expression"),
    [
        ('ends=["x > 2"]', ""),
        ('ends="x > 2"', ""),
        ('ends={"x > 2", "x < -2"}', ""),
        ('measures="max x"', ""),
        ('label=["x > 0"]', ""),
        ('label="right"', "x > 0"),
        ('theory="rate"', "2"),
        ('conserved={"energy": "x"}', "x"),
        ("stable=True", ""),
    ],
)
def test_tables_of_systems(word, expression):
    """A list or text in place of names, and missing names, get advice that keeps the given texts."""
    words = f'duration="10", {word}'
    advice = advised(hint_of(lambda: read_system(PURE.format(words=words)))).replace("...", expression)
    read_system(PURE.format(words=f'duration="10", {advice}'))


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("return [v, -x]", "return [v, -x]"),
        ('return {"x": v, "v": -x}', 'return {"x": v, "v": -x}'),
        ("return v, -x^3", "^"),
    ],
)
def test_lines_of_systems(line, wrong):
    """Values must be returned without the brackets of a list or dict."""
    advice = advised(hint_of(lambda: read_system(TWO.format(line=line))))
    new = advice.split()[0] if wrong == "^" else advice.replace("dx", "v").replace("dv", "-x")
    read_system(TWO.format(line=line.replace(wrong, new)))


@pytest.mark.parametrize("default", ["[1.0]", "(1, 2)", '{"a": 1}', '"a b"', '"1:2:3"', "None"])
def test_defaults_of_systems(default):
    """The advice is a number, not a list or a range, because a default is no axis."""
    hint = hint_of(lambda: read_system(f'@system(duration="10")\ndef f(x={default}):\n    return -x\n'))
    assert "0.5" in hint or "a number" in hint
    assert "return" not in hint
    assert ":" not in hint


@pytest.mark.compiled
def test_dimensions_that_are_no_axes():
    """Advice works for cells with a foreign dimension, in any order, and for concatenated atlases."""
    whole = sweep.run(
        "rolling", roll_rate="2:4:3", tilt="0.1deg,1deg", alpha="0.4,0.5", boundary="refined:1e-3"
    )
    many = whole.expand_dims("run", axis=0)
    for part in (many, many.isel(alpha=0), many.transpose("tilt", ..., "run")):
        hint = hint_of(lambda part=part: part.eulerdisk.boundary())
        plain = eval(re.search(r"dataset\.\S*\([^)]*\)", hint)[0], {"dataset": part})
        assert float(plain.eulerdisk.boundary().measured.max()) > 2.0


@pytest.mark.compiled
def test_dimensions_in_another_order():
    """The suggested order is the order of the axes, whatever else the atlas contains."""
    whole = sweep.run(
        "rolling", roll_rate="2:4:3", tilt="0.1deg,1deg", alpha="0.4,0.5", boundary="refined:1e-3"
    )
    for part, ask in ((whole, spec_of), (whole, selected_spec), (whole.isel(alpha=0), selected_spec)):
        turned = part.transpose("tilt", "roll_rate", ...)
        advice = advised(hint_of(lambda turned=turned, ask=ask: ask(turned)))
        assert ask(eval(advice, {"dataset": turned})) == ask(part)


@pytest.mark.compiled
def test_a_file_that_is_there(tmp_path, command):
    """The command line and Python each name their own way to replace it."""
    motion = sweep.simulate(roll_rate=2, tilt_rate=0.01, duration=0.1)
    sweep.save(motion, tmp_path / "a.nc")
    hint = hint_of(lambda: sweep.save(motion, tmp_path / "a.nc"))
    assert_facts(hint, "--overwrite", "overwrite=True")
    sweep.save(motion, tmp_path / "a.nc", overwrite=True)
    assert command("simulate roll_rate=2 tilt_rate=0.01 duration=0.1 -o a.nc --overwrite")[0] == 0


@pytest.mark.compiled
def test_atlases_of_unlike_grids():
    """The hint names the command-line option and Python's argument for the common cells."""
    one = sweep.run("rolling", roll_rate="2:4:3", tilt="1deg")
    other = sweep.run("rolling", roll_rate="2:4:5", tilt="1deg")
    assert_facts(hint_of(lambda: sweep.compare(one, other)), "--common", "common=True")
    assert sweep.compare(one, other, common=True).same


@pytest.mark.compiled
def test_a_page_of_one_axis(command, tmp_path):
    """The suggested range belongs to the request; for a system it is one of its own states."""
    (tmp_path / "decay.py").write_text(PURE.format(words='duration="1"'), encoding="utf-8")
    for spec in ("decay.py rate=1:2:3", "rolling tilt=1deg", "kapitza angle=1deg"):
        status, _, err = command(f"explore {spec} --export page.html")
        assert status == 2
        word = re.search(r"as in (\S+)\.\n", err)[1]
        words = [each for each in shlex.split(spec) if not each.startswith(f"{word.partition('=')[0]}=")]
        assert command(f"plan {' '.join(words)} {word} --no-calibrate")[0] == 0


def test_options_are_no_words_of_python():
    """No hint for plotting in Python names an option of the command line."""
    motion = xr.Dataset()
    for ask in (
        lambda: Look.read(rate="wild"),
        lambda: Look.read(without="hat"),
    ):
        assert "--" not in hint_of(ask)
    assert "--" not in hint_of(motion.eulerdisk.plot)


@pytest.mark.compiled
def test_the_film_of_an_atlas(tmp_path):
    """The suggested motion is one of the atlas's own cells and can be followed, also for a list of starts."""
    atlases = (
        sweep.run("rolling", roll_rate="2:4:3", tilt="1deg", alpha="0.4,0.5"),
        sweep.run("kapitza", angle="1deg", shake="80:90:2"),
        sweep.run("rolling", roll_rate="uniform:2:4", tilt="1deg", samples=3),
    )
    for atlas in atlases:
        hint = hint_of(lambda atlas=atlas: atlas.eulerdisk.animate(tmp_path / "a.gif"))
        cell = re.search(r"(atlas\.eulerdisk\.simulate\(.*?\))\.eulerdisk", hint)[1]
        assert eval(cell, {"atlas": atlas}).elapsed_time.size > 1
