"""The page's WebAssembly module contains the current kernels and is reproducible."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from build_page_module import TARGET, sources

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "build_page_module.py"


def note_of(content):
    """Return the module's note about itself, its last section."""
    return json.loads(content[content.rindex(b'{"entries"') :])


def test_it_is_made_of_the_kernels_of_today():
    """A changed kernel requires a rebuild with python scripts/build_page_module.py."""
    assert note_of(TARGET.read_bytes())["made_of"]["code"] == sources()["code"]


def test_its_note_says_how_it_is_called():
    """Every entry point is listed with its arguments, and those of the kernels with their types."""
    entries = note_of(TARGET.read_bytes())["entries"]
    assert entries["reduce"]["arguments"][4:8] == [
        ["starts", "float64", 2],
        ["kind", "float64", 0],
        ["fall_tilt", "float64", 0],
        ["timed", "int64", 0],
    ]
    assert entries["trajectory"]["results"] == ["int64", "int64", "float64", "int64"]


@pytest.mark.release
def test_it_is_the_same_when_it_is_built_again(tmp_path):
    """With the recorded versions, a rebuild gives the same bytes."""
    made_of = note_of(TARGET.read_bytes())["made_of"]
    if made_of != sources():
        pytest.skip(f"it was made with numba {made_of['numba']} and llvmlite {made_of['llvmlite']}")
    again = tmp_path / "kernels.wasm"
    subprocess.run([sys.executable, str(SCRIPT), str(again)], check=True, capture_output=True)
    assert again.read_bytes() == TARGET.read_bytes()
