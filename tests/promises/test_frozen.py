"""What must not change by accident: canonical texts with their fingerprints.

They prove sameness, not truth. ``pytest tests/promises/test_frozen.py --eulerdisk-regen`` writes the file anew: read
the difference before it is committed. A canonical text that changes makes older atlases strangers to their own request.
"""

import shlex
from pathlib import Path

import pytest

import sweep
from sweep.errors import RequestError

FROZEN = Path(__file__).with_name("frozen")


def _requests():
    """Return the requests of the first file, a line of words each."""
    lines = (FROZEN / "specs.txt").read_text(encoding="utf-8").splitlines()
    return [line[2:] for line in lines if line.startswith("$ ")]


def _said_of(words):
    """Return the fingerprint and the canonical text of a request, or its refusal."""
    first, *rest = shlex.split(words)
    try:
        spec = sweep.SweepSpec.from_words(first, rest)
    except RequestError as error:
        return f"refused: {error}"
    assert sweep.SweepSpec.from_canonical(spec.canonical()) == spec
    return f"{spec.fingerprint()}\n{spec.canonical()}"


def _write_files():
    """Write the files that the requests name into the current folder."""
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")


def _compare(path, text, regen):
    if regen:
        path.write_text(text, encoding="utf-8")
        pytest.skip(f"{path.name} rewritten")
    told, kept = text.split("\n$ "), path.read_text(encoding="utf-8").split("\n$ ")
    differ = [f"kept:\n{old}\nnow:\n{new}" for old, new in zip(kept, told, strict=True) if old != new]
    assert not differ, "\n\n".join(differ)


def test_canonical_texts(request, tmp_path, monkeypatch):
    """Each request still has the canonical text, and so the fingerprint, that it had."""
    monkeypatch.chdir(tmp_path)
    _write_files()
    text = "".join(f"$ {words}\n{_said_of(words)}\n" for words in _requests())
    _compare(FROZEN / "specs.txt", text, request.config.getoption("--eulerdisk-regen"))


#: Files that the requests name.
FILES = {
    "two.toml": '[[sweep]]\nname = "a"\nspec = "rolling"\n[[sweep]]\nname = "b"\nspec = "spinning"\n',
    "typo.toml": 'roll_rate = "2:4:9"\ntlt = "1deg"\n',
    "unit.toml": 'roll_rate = "2:4:9"\ntilt = "1kg"\n',
    "broken.toml": "roll_rate = [1, 2\n",
    "starts.csv": "tilt [deg],roll_rate [rpm]\n1,30\n2,-4\n3,x\n",
    "short.csv": "tilt [deg],roll_rate [rpm]\n1,30\n2\n",
    "twice.csv": "tilt,tilt\n1,2\n",
    "good.csv": "tilt [deg],roll_rate [rpm]\n1,30\n2,-4\n3,1e2\n",
    "scaled.csv": "inclination [deg],scaled_roll_rate\n80,0.6\n85,0.5\n",
    "speeds.csv": "tilt,speed [cm/s]\n0.1,30\n0.2,40\n",
    "lossy.csv": "tilt [deg],contour_friction [um]\n60,5\n70,15\n",
    "pushed.toml": 'title = "Pushed"\nroll_rate = "12:24:120"\ntilt_rate = "0.001:1:80:log"\nradius = "12mm"\n'
    'criterion = "amplification:10"\nduration = "60s"\n',
    "scaled.toml": 'scaled_roll_rate = "0.4:0.9:9"\ninclination = "80deg"\nradius = "12mm"\n',
    "losses.toml": 'roll_rate = "15:80:5"\nrolling_friction = "1um:1mm:3:log"\nmass = "7.5g"\nradius = "1cm"\n',
    "list.toml": 'samples = 20\nseed = 3\nroll_rate = "uniform:2:4"\ntilt = "loguniform:1deg:9deg"\n',
    "reordered.toml": 'tilt = "1deg:5deg:3"\nroll_rate = [1, 2.5, 4]\nalpha = 1\n',
    "lens.py": '@body(duration="10 s", stable="peak_tilt < 60deg")\ndef lens(tilt, *, q=0.5):\n'
    "    return sqrt(cos(tilt)**2 + q**2*sin(tilt)**2), 0.4, (1 + q**2)/5\n",
    "text.nc": "not a netCDF file\n",
}
