"""Tables of starts: CSV files and columns in memory, their units, and refusals by line and column."""

import hashlib
import json
import pickle

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from messages import refused

from sweep.engine.grid import whole
from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.request.sources import Values
from sweep.request.spec import SweepSpec
from sweep.request.start_list import read_list_word
from sweep.request.start_table import StartTable

COLUMNS = {"roll_rate": [2.5, 3.0, 2.0], "tilt": [0.01, 0.02, 0.005]}


def read(raw, model):
    """Read a table for a model."""
    return read_list_word("starts", raw, model)


@pytest.fixture
def table(tmp_path):
    """Return a function that writes a CSV file and returns its path."""

    def write(text, name="table.csv", encoding="utf-8"):
        path = tmp_path / name
        path.write_bytes(text.encode(encoding))
        return path

    return write


@pytest.fixture
def spec():
    """Return a spec with a table."""
    return SweepSpec.preset("rolling").replace(starts=COLUMNS)


def test_a_table_takes_the_place_of_axes(spec):
    """Its columns replace the preset's values of these parameters; rows keep their order."""
    assert spec.axes == ("start",)
    assert spec.shape == (3,)
    assert spec.listed == ("tilt", "roll_rate")
    starts = whole(spec)
    assert starts["roll_rate"].tolist() == COLUMNS["roll_rate"]
    assert starts["tilt"].tolist() == COLUMNS["tilt"]
    assert starts["alpha"].tolist() == [0.5] * 3


def test_spellings_of_a_file(table):
    """Separators, units, comments, quotes, a byte order mark and column order do not change the starts."""
    for text in [
        "roll_rate,tilt [deg]\n2.5,1\n3.0,2\n",
        "# measured\n\nroll_rate [rad/s] , tilt [deg]\n2.5 , 1\n# a comment\n3.0 , 2\n\n",
        "roll_rate (rad/s);tilt (deg)\r\n2.5;1\r\n3.0;2\r\n",
        "roll_rate rad/s\ttilt deg\n2.5\t1\n3.0\t2",
        '"tilt [deg]","roll_rate"\n"1",2.5\n2.0e0,+3\n',
        "\ufefftilt [arcmin],roll_rate [deg/s]\n60,143.2394487827058\n120,171.88733853924697\n",
        "tilt,roll_rate [rad s-1],alpha [1]\n0.017453292519943295,2.5,.5\n0.03490658503988659,3.,0.5\n",
    ]:
        spec = SweepSpec.from_words("rolling", [f"starts={table(text)}"])
        starts = whole(spec)
        np.testing.assert_allclose(starts["roll_rate"], [2.5, 3.0], rtol=1e-15)
        np.testing.assert_allclose(starts["tilt"], np.radians([1.0, 2.0]), rtol=1e-15)


def test_a_column_of_a_body_that_is_not_named(table):
    """The thin disk has no moments: the message names the column and the bodies that have it."""
    path = table("tilt [deg],axial_moment\n1,0.4\n2,0.5\n")
    with refused("axial_moment", "column", "body=ball"):
        SweepSpec.from_words("rolling", ["roll_rate=2", f"starts={path}"])


def test_columns_in_memory():
    """Mappings, data frames and data arrays with units give the same table."""
    given = read(COLUMNS, DISK)
    assert read(pd.DataFrame(COLUMNS), DISK) == given
    assert read(xr.Dataset({name: ("n", values) for name, values in COLUMNS.items()}), DISK) == given
    degrees = xr.DataArray(np.array([1.0, 2.0]), attrs={"units": "deg"})
    for columns in ({"tilt": degrees}, {"tilt [deg]": [1, 2]}, pd.DataFrame({"tilt (deg)": [1, 2]})):
        np.testing.assert_allclose(read(columns, DISK).values("tilt"), np.radians([1.0, 2.0]))
    # Negative zero becomes zero, so equal values have the same SHA-256.
    assert read({"tilt": [-0.0, 1.0]}, DISK) == read({"tilt": [0.0, 1.0]}, DISK)


def test_a_data_frame_wherever_a_table_is_given():
    """A data frame is accepted everywhere; its truth value, which does not exist, is never needed."""
    frame = pd.DataFrame(COLUMNS)
    made = [
        SweepSpec.preset("rolling").replace(starts=frame),
        SweepSpec.preset("rolling", starts=frame),
        SweepSpec.read("rolling", starts=frame),
        SweepSpec(starts=frame),
    ]
    assert {spec.starts for spec in made} == {read(COLUMNS, DISK)}
    for make in (SweepSpec, SweepSpec.preset("rolling").replace):
        with refused("starts", "CSV", "columns"):
            make(starts=np.zeros((2, 2)))


def test_the_text_of_a_spec_holds_a_hash(spec):
    """It has names, count and SHA-256 of the little-endian doubles in model order, but no values."""
    found = json.loads(spec.canonical())["starts"]
    content = np.array([COLUMNS["tilt"], COLUMNS["roll_rate"]]).astype("<f8").tobytes()
    assert found == {
        "names": ["tilt", "roll_rate"],
        "starts": 3,
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    swapped = SweepSpec.preset("rolling").replace(
        starts={name: COLUMNS[name] for name in ("tilt", "roll_rate")}
    )
    assert swapped == spec


def test_a_spec_without_values(spec):
    """A spec from text is equal, knows its cells, reports the missing values and accepts them again."""
    bare = SweepSpec.from_canonical(spec.canonical())
    assert bare == spec
    assert bare.shape == (3,)
    with refused("3 starts of tilt, roll_rate", "SHA-256 e452eb151ee9"):
        whole(bare)
    filled = bare.replace(starts=bare.starts.filled(COLUMNS))
    assert whole(filled)["tilt"].tolist() == COLUMNS["tilt"]
    with refused("tilt, roll_rate", "SHA-256", "e452eb151ee9"):
        bare.starts.filled({**COLUMNS, "tilt": [0.01, 0.02, 0.0050000001]})
    assert whole(pickle.loads(pickle.dumps(spec)))["tilt"].tolist() == COLUMNS["tilt"]
    content = spec.starts.to_bytes()
    assert bare.starts.from_bytes(content).values("tilt").tolist() == COLUMNS["tilt"]
    for damaged in (content[:-1], content + b"x", content[:-8], bytes(48)):
        with refused("tilt, roll_rate", "SHA-256"):
            bare.starts.from_bytes(damaged)


def test_texts_that_cannot_hold_a_table(spec):
    """TOML refuses a table, and `repr` does not look like inputs that recreate the spec."""
    with refused("starts:", "TOML", "3 starts of tilt, roll_rate", 'starts = "pushes.csv"'):
        spec.to_toml()
    shown = repr(spec)
    assert f"starts=<{spec.starts}>" in shown
    assert "column" not in shown
    assert " tilt=" not in shown


def test_a_part_of_a_table(spec):
    """It keeps its start numbers, in its text and through further changes."""
    part = spec.replace(start=[0, 2])
    assert part.start == Values((0.0, 2.0))
    assert whole(part)["tilt"].tolist() == [0.01, 0.005]
    assert SweepSpec.from_canonical(part.canonical()) == part
    again = part.replace(title="x").replace(start=[2])
    assert whole(again)["tilt"].tolist() == [0.005]
    with refused("start 1", "2 starts", "from 0 to 2"):
        part.replace(start=[1])


def test_replacing(spec):
    """Another table, a number or a grid can replace it."""
    assert spec.replace(starts={"tilt": [0.1], "roll_rate": [3.0]}).size == 1
    assert spec.replace(alpha=1).alpha == 1.0
    random = SweepSpec.from_words("rolling", ["roll_rate=uniform:2:4", "tilt=1deg", "samples=5"])
    assert random.replace(starts=COLUMNS).starts == spec.starts
    with refused("tilt:", "3 starts of tilt, roll_rate", "tilt=0.1"):
        spec.replace(tilt=0.1)


def test_a_spec_file_names_a_table(tmp_path, table):
    """The path is relative to the file's folder, wherever the command runs."""
    table("tilt [deg],roll_rate\n1,3\n", "pushes.csv")
    (tmp_path / "sweep.toml").write_text('starts = "pushes.csv"\nalpha = 1.0\n')
    spec = SweepSpec.from_toml(tmp_path / "sweep.toml")
    assert (spec.size, spec.alpha) == (1, 1.0)
    (tmp_path / "sweep.toml").write_text('starts = "other.csv"\n')
    with refused("sweep.toml:", "other.csv:", "No such file or directory"):
        SweepSpec.from_toml(tmp_path / "sweep.toml")


def test_what_is_no_table(table):
    """The message names file, line and column, and gives the remedy."""
    for text, facts in [
        ("", ["column", "none"]),
        ("tilt,roll_rate\n", ["1 to 10000000 starts", "0"]),
        ("tilt,roll_rate\n0.1,2\n0.1\n", ["line 3", "2 cells", "1"]),
        ("tilt,roll_rate\n# x\n\n0.1,2,3\n", ["line 4", "2 cells", "3"]),
        ("tilt,roll_rate\n0.1,abc\n", ["line 2", "column roll_rate", "number", "abc"]),
        ("tilt,roll_rate\n0.1,\n", ["line 2", "column roll_rate", "number", "nothing"]),
        ("tilt,roll_rate\n0.1,1deg\n", ["line 2", "column roll_rate", "number", "1deg", "tilt [deg]"]),
        ("tilt,roll_rate\n0.1,1_0\n", ["line 2", "column roll_rate", "number", "1_0"]),
        ("tilt,roll_rate\n0.1,\u0663\n", ["line 2", "column roll_rate", "number", "\u0663"]),
        ("tilt,roll_rate\n0.1,nan\n", ["line 2", "column roll_rate", "finite", "nan"]),
        ("tilt,roll_rate\n0.1,1e999\n", ["line 2", "column roll_rate", "finite", "inf"]),
        ("tilt [deg],roll_rate\n1,2\n95,3\n", ["line 3", "column tilt [deg]", "|tilt| < 90 deg", "95 deg"]),
        ("alpha,roll_rate\n0,2\n", ["line 2", "column alpha", "0 < alpha <= 1", "0"]),
        ("tilt,tilt [deg]\n1,2\n", ["one column", "tilt", "2"]),
        ("theta,roll_rate\n1,2\n", ["'theta'", "tilt?"]),
        ("tilt,\n1,2\n", ["''", "tilt_rate"]),
        ("duration,roll_rate\n1,2\n", ["'duration'", "tilt_rate"]),
        ("tilt [m],roll_rate\n1,2\n", ["column tilt [m]", "'m'", "deg", "arcmin"]),
        ("tilt,roll_rate [1]\n0.1,2\n", ["column roll_rate [1]", "'1'", "rpm"]),
        ("tilt,roll_rate -\n0.1,2\n", ["column roll_rate -", "'-'", "rpm"]),
        ("tilt [1],roll_rate\n0.1,2\n", ["column tilt [1]", "'1'", "deg"]),
        ("tilt [deg,roll_rate\n1,2\n", ["'tilt [deg'", "tilt_rate"]),
        ('tilt,roll_rate\n0.1,"2\n', ["CSV", "UTF-8", "unexpected end of data"]),
    ]:
        path = table(text)
        with refused(str(path), *facts):
            SweepSpec.from_words("rolling", [f"starts={path}"])
    path = table("tilt\n0.1\n")
    with refused("roll_rate:", "1 start of tilt", "roll_rate=2.0:4.0:801"):
        SweepSpec.from_words("rolling", [f"starts={path}"])


def test_other_encodings_and_missing_files(table, tmp_path):
    """UTF-16 text, a folder and a missing file are refused in a sentence."""
    for path, fact in (
        (table("tilt\n1\n", encoding="utf-16"), "UTF-8"),
        (tmp_path, "Is a directory"),
        (tmp_path / "no.csv", "No such file"),
    ):
        with refused(str(path), fact):
            read(path, DISK)


def test_what_are_no_columns():
    """They are refused with the column name and the start number."""
    for raw, facts in [
        ({}, ["starts:", "column", "none"]),
        ({"tilt": [0.1], "roll_rate": [1, 2]}, ["tilt 1", "roll_rate 2"]),
        ({"tilt": []}, ["1 to 10000000 starts", "0"]),
        ({"tilt": ["a"]}, ["tilt", "numbers"]),
        ({"tilt": [[0.1]]}, ["tilt", "shape (1, 1)"]),
        ({"tilt": [0.1, np.nan]}, ["tilt, start 1", "finite", "nan"]),
        ({"tilt": [0.1, 2.0]}, ["tilt, start 1", "|tilt| <"]),
        ({"tilt": [True]}, ["tilt", "numbers"]),
        ({"tilt": np.ma.masked_array([0.1, 0.2], [False, True])}, ["tilt:", "1", "masked"]),
        (xr.Dataset({"roll_rate": ("n", [1.0], {"units": "1"})}), ["roll_rate", "'1'", "rpm"]),
        (3, ["starts", "CSV", "columns", "3"]),
        (xr.Dataset({"tilt": ("n", [1.0], {"units": "m"})}), ["tilt", "'m'", "deg", "arcmin"]),
    ]:
        with refused(*facts):
            SweepSpec.preset("rolling").replace(starts=raw, roll_rate=3.0) if not isinstance(raw, dict) or (
                "roll_rate" not in raw
            ) else SweepSpec.preset("rolling").replace(starts=raw)


def test_what_does_not_go_with_a_table(table):
    """Each conflicting input is refused by name."""
    for words, where, facts in [
        (["tilt=2deg"], "tilt", ["tilt=2deg"]),
        (["samples=2"], "samples", ["samples=2"]),
        (["seed=2"], "seed", ["seed=2"]),
        (["alpha=0.5,1"], "alpha", ["alpha=0.5,1"]),
        (["alpha=uniform:0.5:1"], "alpha", ["alpha=uniform:0.5:1"]),
        (["boundary=refined"], "boundary", ["boundary=refined", "grid"]),
        (["start=7"], "start", ["start 7", "1 start", "0"]),
    ]:
        path = table("tilt [deg],roll_rate\n1,3\n")
        with refused(*facts) as caught:
            SweepSpec.from_words("rolling", [f"starts={path}", *words])
        assert caught.value.where == where


def test_a_damaged_text(spec):
    """Any damage of a table's description is refused."""
    for change in [
        {"sha256": "0"},
        {"sha256": 5},
        {"starts": 0},
        {"starts": 1.5},
        {"starts": 10**9},
        {"names": []},
        {"names": "tilt"},
        {"names": ["tilt", "duration"]},
        {"names": ["tilt"]},
        {"numbers": {"values": [1.0, 2.0]}},
        {"numbers": 3},
        {"numbers": {"nothing": 1}},
    ]:
        content = json.loads(spec.canonical())
        content["starts"] |= change
        with pytest.raises(RequestError):
            SweepSpec.from_canonical(json.dumps(content))


def test_a_column_without_table(spec):
    """A text without its table is refused."""
    content = json.loads(spec.canonical())
    del content["starts"]
    with refused("table"):
        SweepSpec.from_canonical(json.dumps(content))


def test_the_table_itself_is_not_changed():
    """The given values are copied, so later changes by the caller have no effect."""
    values = np.array([0.01, 0.02])
    made = StartTable.of({"tilt": values})
    values[0] = 0.5
    assert made.values("tilt")[0] == 0.01
    with pytest.raises(ValueError, match="read-only"):
        made.values("tilt")[0] = 1.0
