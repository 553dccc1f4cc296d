"""Reading the sweeps of a batch from files."""

import pytest
from messages import assert_facts, refused

from sweep.batch.sweeps import read_sweeps
from sweep.request.spec import SweepSpec

SEVERAL = """
tilt = "1deg:4deg:3"
alpha = 1
[[sweep]]
name = "hoop"
roll_rate = "1:3:4"
[[sweep]]
name = "disk"
alpha = 0.5
roll_rate = "2:4:4"
"""


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """Run in the folder of the test, so that files have relative names."""
    monkeypatch.chdir(tmp_path)


def test_one_for_each_file_and_one_for_each_table(spec_file):
    """Each preset, file and table is a sweep; words above the tables apply to all, and a table's own come first."""
    spec_file(SEVERAL, "several.toml")
    spec_file('roll_rate = 3\ntilt = "1deg"\n', "one.toml")
    found = read_sweeps(["rolling", "one.toml", "several.toml"])
    assert [(each.name, each.source) for each in found] == [
        ("rolling", "rolling"),
        ("one", "one.toml"),
        ("hoop", "several.toml, [[sweep]] 1"),
        ("disk", "several.toml, [[sweep]] 2"),
    ]
    assert [each.spec for each in found] == [
        SweepSpec.preset("rolling"),
        SweepSpec(roll_rate=3, tilt="1deg"),
        SweepSpec(tilt="1deg:4deg:3", alpha=1, roll_rate="1:3:4"),
        SweepSpec(tilt="1deg:4deg:3", alpha=0.5, roll_rate="2:4:4"),
    ]
    assert found[2].spec.axes == ("tilt", "roll_rate")


def test_a_table_may_give_a_rate_in_another_way(spec_file):
    """A table's own word for a rate replaces the file's; two in one table are that table's problem."""
    spec_file(
        'scaled_roll_rate = "0.5:1:4"\ntilt = "1deg,2deg"\n'
        '[[sweep]]\nname = "coin"\nradius = "12mm"\n'
        '[[sweep]]\nname = "slow"\nspeed = "1:2:4"\n'
        '[[sweep]]\nname = "both"\nspeed = 1\nroll_rate = 2\n',
        "a.toml",
    )
    coin, slow, both = read_sweeps(["a.toml"])
    assert coin.spec == SweepSpec(scaled_roll_rate="0.5:1:4", tilt="1deg,2deg", radius="12mm")
    assert slow.spec == SweepSpec(roll_rate="2:4:4", tilt="1deg,2deg")
    assert both.spec is None
    assert_facts(both.problem, "a.toml, [[sweep]] 3", "speed=1", "roll_rate=2")


def test_a_spec_that_is_wrong_is_kept_as_a_problem(spec_file):
    """An invalid spec is kept as a problem with its position and reason, so that other sweeps can run."""
    for text, facts in [
        ("rol_rate = 3\n", ["a.toml: rol_rate", "roll_rate?"]),
        ("[[sweep]]\nname = 'b'\nrol_rate = 3\n", ["a.toml, [[sweep]] 1: rol_rate", "roll_rate?"]),
        ("tilt = 3\n", ["a.toml: tilt"]),
        ("sweep = 3\n", ["a.toml", "[[sweep]]"]),
        ("sweep = []\n", ["a.toml", "[[sweep]]"]),
        ("sweep = [3]\n", ["a.toml", "[[sweep]]"]),
        ("]", ["a.toml", "TOML"]),
    ]:
        spec_file(text, "a.toml")
        (found,) = read_sweeps(["a.toml"])
        assert found.spec is None, text
        assert_facts(found.problem, *facts)
    assert read_sweeps(["missing.toml"])[0].problem.startswith("missing.toml: ")


def test_names_that_cannot_be_those_of_files_are_problems(spec_file):
    """A name that cannot be a file name is a problem only of its sweep; the others can run."""
    for text, facts in [
        ("[[sweep]]\nroll_rate = 3\n", ["[[sweep]] 1", "100", "none"]),
        ("[[sweep]]\nname = 3\n", ["[[sweep]] 1", "100", "none"]),
        ("[[sweep]]\nname = '../b'\n", ["[[sweep]] 1", "100", "../b"]),
        ("[[sweep]]\nname = '.b'\n", ["[[sweep]] 1", "100", ".b"]),
        (f"[[sweep]]\nname = '{'a' * 101}'\n", ["[[sweep]] 1", "100", "a" * 60]),
        ("[[sweep]]\nname = 'A'\n[[sweep]]\nname = 'a'\n", ["[[sweep]] 2", "name a"]),
        ("[[sweep]]\nname = 'rolling'\n", ["[[sweep]] 1", "name rolling"]),
    ]:
        spec_file(text, "a.toml")
        *others, found = read_sweeps(["rolling", "a.toml"])
        assert all(each.spec for each in others), text
        assert (found.name, found.spec, found.label) == ("", None, found.source), text
        assert found.problem.startswith("a.toml, ")
        assert_facts(found.problem, *facts)
    with refused("batch"):
        read_sweeps([])


def test_a_preset_beside_a_folder_of_its_name(tmp_path):
    """A folder named like a preset does not hide it; another folder is a problem, and spec words are refused."""
    (tmp_path / "rolling").mkdir()
    (tmp_path / "others").mkdir()
    preset, folder = read_sweeps(["rolling", "others/"])
    assert preset.spec == SweepSpec.preset("rolling")
    assert_facts(folder.problem, "others/*.toml")
    with refused("NAME=VALUE", "tilt=1deg"):
        read_sweeps(["rolling", "tilt=1deg"])


def test_a_file_of_several_sweeps_is_for_batch(spec_file):
    """A file with several sweeps is refused as a single spec; the misspelt [[sweeps]] is refused in both."""
    for name in ("sweep", "sweeps"):
        path = spec_file(f"[[{name}]]\nname = 'b'\nroll_rate = 3\n", "a b.toml")
        with refused(f"eulerdisk batch '{path}' -o DIR"):
            SweepSpec.from_toml(path)
    (found,) = read_sweeps(["a b.toml"])
    assert_facts(found.problem, "[[sweep]]", "[[sweeps]]")


@pytest.mark.parametrize(
    "text",
    [
        'alpha = 1\nstarts = "pushes.csv"\n[[sweep]]\nname = "a"\n',
        'alpha = 1\nroll_rate = "1:3:4"\nsamples = 5\n[[sweep]]\nname = "a"\nstarts = "pushes.csv"\n',
        'alpha = 1\nstarts = "pushes.csv"\n',
    ],
)
def test_a_table_of_starts_lies_beside_its_file(spec_file, tmp_path, text):
    """A table of starts is found next to its file, not in the current folder; it replaces words above the tables."""
    folder = tmp_path / "sweeps"
    folder.mkdir()
    (tmp_path / "pushes.csv").write_text("roll_rate,tilt [deg]\n9,9\n9,9\n")
    (folder / "pushes.csv").write_text("roll_rate,tilt [deg]\n2.5,1\n")
    (folder / "a.toml").write_text(text)
    (found,) = read_sweeps(["sweeps/a.toml"])
    assert found.problem == ""
    assert found.spec == SweepSpec(alpha=1, starts=folder / "pushes.csv")


def test_many_sweeps_of_one_system(spec_file, tmp_path):
    """A file names its system once, by a path relative to it; a table may name another system."""
    tables = "".join(f'[[sweep]]\nname = "s{i}"\nrate = "{i}:{i + 1}:3"\n' for i in range(12))
    spec_file(f'system = "decay.py"\n{tables}[[sweep]]\nname = "shaken"\nsystem = "kapitza"\n', "many.toml")
    (tmp_path / "decay.py").write_text(
        '@system(duration="10")\ndef decay(x=1.0, *, rate=0.5):\n    return -rate * x\n', encoding="utf-8"
    )
    *found, shaken = read_sweeps([str(tmp_path / "many.toml")])
    assert [each.problem for each in found] == [""] * 12
    assert {each.spec.model.name for each in found} == {"decay"}
    assert [each.spec.rate.start for each in found] == [*range(12)]
    assert shaken.spec.model.name == "kapitza"
