"""Spec files can name a system by file or preset; texts that a program wrote cannot."""

import json

import pytest
import xarray as xr
from messages import refused

from sweep.errors import RequestError
from sweep.motion.sampling import request_of
from sweep.request import system_file
from sweep.request.spec import SweepSpec

TWO = """
from sweep.systems import system


@system(duration="10")
def decay(x=1.0, *, rate=0.5):
    return -rate * x


@system(duration="10")
def growth(x=1.0, *, rate=0.5):
    return rate * x
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return a folder with a file of systems; it is not the current folder."""
    monkeypatch.chdir(tmp_path)
    made = tmp_path / "sweeps"
    made.mkdir()
    (made / "two.py").write_text(TWO, encoding="utf-8")
    return made


@pytest.mark.parametrize("word", ["system", "model"])
def test_a_spec_file_names_a_file_or_a_preset(folder, word):
    """A path is relative to the spec file; from a preset only the system is used, not its axes."""
    spec_file = folder / "sweep.toml"
    for named, model, axis in (("two.py:growth", "growth", "rate"), ("kapitza", "kapitza", "shake")):
        spec_file.write_text(f'{word} = "{named}"\n{axis} = "50:60:3"\n', encoding="utf-8")
        for spec in (SweepSpec.from_toml(spec_file), SweepSpec.read(str(spec_file))):
            assert (spec.model.name, spec.axes, spec.shape) == (model, (axis,), (3,))
            # The spec contains the system's text, so the file is not needed again.
            assert SweepSpec.from_canonical(spec.canonical()) == spec


def test_a_name_that_is_none(folder):
    """The message lists the presets, the nearest one, or the path of the missing file."""
    spec_file = folder / "sweep.toml"
    for named, facts in (
        ("kapitsa", ["thomas", "kapitza?"]),
        ("three.py", [str(folder / "three.py")]),
        ("", ["henon_heiles", 'system = "mine.py"']),
    ):
        spec_file.write_text(f'system = "{named}"\n', encoding="utf-8")
        with refused(*facts):
            SweepSpec.from_toml(spec_file)


def test_in_python_the_file_is_the_spec(folder):
    """In Python, `system` contains a text and opens no file; the hint says what to do instead."""
    with refused("system:", "as the spec"):
        SweepSpec(system=str(folder / "two.py:decay"), rate="1:2:3")
    assert SweepSpec.read(str(folder / "two.py:decay"), rate="1:2:3").model.name == "decay"


def test_what_a_program_wrote_opens_no_file(folder, monkeypatch):
    """The spec of an atlas and the request of a motion never make the program read a file."""
    text = SweepSpec.read(str(folder / "two.py:decay"), rate="1:2:3").canonical()
    file = str(folder / "two.py:decay")

    def read(*_):
        pytest.fail("a file was opened")

    monkeypatch.setattr(system_file, "read_regular", read)
    held = json.loads(text)
    for changes in ({"system": file}, {"system": "kapitza"}, {"model": file}, {"model": "kapitza"}):
        words = {name: value for name, value in held.items() if name not in ("model", "system")} | changes
        with pytest.raises(RequestError):
            SweepSpec.from_canonical(json.dumps(words))
        motion = xr.Dataset(attrs={"trajectory_request": json.dumps({"duration": 1.0} | changes)})
        with pytest.raises(RequestError):
            request_of(motion)
