"""The canonical text of a request restores it, and only equal requests share a text."""

import hashlib
import json
import math
import shlex

import numpy as np
import pytest

from sweep.errors import RequestError
from sweep.model import registry
from sweep.request.spec import SweepSpec

#: Requests by their words. Requests on one line are equal; requests on different lines differ.
REQUESTS = (
    ("rolling", "rolling body=disk", "rolling contact=no boundary=grid", "same.toml"),
    ("spinning",),
    ("circling",),
    ("rolling roll_rate=3", "rolling roll_rate=3rad/s"),
    ("rolling roll_rate=30rpm", "rolling roll_rate=0.5turn/s", "rolling roll_rate=180deg/s"),
    ("rolling roll_rate=2:4:100",),
    ("rolling roll_rate=2:4:100:log",),
    ("rolling roll_rate=2,3,4.5",),
    ("rolling roll_rate=-2:2:5",),
    ("rolling radius=1 speed=2", "rolling radius=1 speed=200cm/s", "rolling radius=1 roll_rate=2"),
    ("rolling scaled_roll_rate=0.3:0.9:50",),
    ("rolling tilt=0.5", "rolling tilt=500mrad"),
    ("rolling tilt=-5deg:5deg:11",),
    ("rolling inclination=80deg",),
    ("rolling tilt_rate=0.001:1:10:log",),
    ("rolling precession_rate=steady-slow",),
    ("rolling precession_rate=steady-fast",),
    ("rolling roll_rate=steady precession_rate=1:3:5",),
    ("rolling precession_rate=wobble roll_rate=wobble tilt=10deg:60deg:6",),
    ("rolling alpha=1", "rolling alpha=100%"),
    ("rolling alpha=0.5,1",),
    ("rolling radius=12mm", "rolling radius=1.2cm"),
    ("rolling gravity=1.62", "rolling gravity=1.62m/s^2", 'rolling gravity="1.62 m s-2"'),
    ("rolling duration=2min", "rolling duration=120s"),
    ("rolling step=1ms",),
    ("rolling fall_tilt=60deg",),
    ("rolling tolerance=1e-9",),
    ("rolling method=exact",),
    ("rolling contact=yes",),
    ("rolling path=yes",),
    ("rolling contact=yes path=yes",),
    ("rolling device=cuda",),
    ("rolling boundary=refined", "rolling boundary=refined:1e-9"),
    ("rolling boundary=refined:1e-6",),
    ("rolling title='Größe \"α\"'",),
    ("rolling criterion=departure:2deg", "rolling criterion=departure:2°"),
    ("rolling criterion=amplification:10", "rolling criterion=amplification:1000%"),
    ("rolling criterion=aloft:10s",),
    ("rolling 'criterion=peak_tilt > 10deg'", "rolling 'criterion=peak_tilt>10deg'"),
    ("rolling 'criterion=peak_tilt > 10deg or fall_time < 2s'",),
    ("rolling 'criterion=ending == fell'",),
    (
        "rolling roll_rate=3 samples=100 tilt=uniform:1deg:5deg",
        "rolling roll_rate=3 samples=1e2 seed=0 tilt=uniform:1°:5deg",
    ),
    ("rolling roll_rate=3 samples=100 seed=3 tilt=uniform:1deg:5deg",),
    ("rolling roll_rate=3 samples=100 seed=3 tilt=loguniform:1deg:5deg",),
    ("rolling roll_rate=3 samples=100 seed=3 tilt=normal:1deg:5deg",),
    ("rolling roll_rate=3 samples=100 seed=3 start=3,4,5 tilt=uniform:1deg:5deg",),
    ("rolling roll_rate=3 samples=100 seed=3 start=3:99 tilt=uniform:1deg:5deg",),
    (
        "rolling roll_rate=3 samples=9 tilt=uniform:1deg:5deg",
        "rolling roll_rate=3 samples=9 start=0:8 tilt=uniform:1deg:5deg",
    ),
    ("rolling starts=good.csv",),
    ("rolling starts=good.csv start=0,2",),
    ("rolling starts=good.csv alpha=1",),
    ("toy",),
    ("coin",),
    ("toy precession_rate=wobble starts=lossy.csv",),
    ("toy contour_friction=0",),
    ("toy contour_friction=1um:1mm:9:log",),
    ("toy air_law=none air_viscosity=0 air_density=0",),
    ("toy friction=0.3",),
    ("rolling contour_friction=0.1mm", "rolling contour_friction=0.0001"),
    ("rolling rolling_friction=0.1mm",),
    ("torus",),
    ("egg",),
    ("thick_coin",),
    ("rolling body=torus tube=0.02:0.5:9",),
    ("rolling body=torus tube=0.02:0.5:9 filling=hollow",),
    ("rolling body=spheroid flattening=0.2:0.5:4",),
    ("true_edge",),
    ("toy body=rim thickness=12.8mm fillet=2mm",),
    ("kapitza",),
    ("thomas",),
    ("kapitza criterion=peak>1",),
    ("lens.py tilt=5deg:60deg:12 roll_rate=0:6:20", "lens.py q=0.5 tilt=5deg:60deg:12 roll_rate=0:6:20"),
    ("lens.py tilt=5deg:60deg:12 roll_rate=0:6:20 q=0.3",),
)

#: The files that they name.
FILES = {
    "good.csv": "tilt [deg],roll_rate [rpm]\n1,30\n2,-4\n3,1e2\n",
    "lossy.csv": "tilt [deg],contour_friction [um]\n60,5\n70,15\n",
    "same.toml": 'model = "disk"\nroll_rate = "2:4:801"\ntilt = "0.001deg:5deg:200:log"\n',
    "lens.py": '@body(duration="10 s", stable="peak_tilt < 60deg")\ndef lens(tilt, *, q=0.5):\n'
    "    return sqrt(cos(tilt)**2 + q**2*sin(tilt)**2), 0.4, (1 + q**2)/5\n",
}


def spec_of(words):
    """Return the request of a line of words."""
    first, *rest = shlex.split(words)
    return SweepSpec.from_words(first, rest)


@pytest.fixture(scope="module")
def specs(tmp_path_factory):
    """Return the lines of `REQUESTS` as specs."""
    folder = tmp_path_factory.mktemp("requests")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for name, text in FILES.items():
            (folder / name).write_text(text, encoding="utf-8")
        return [[spec_of(words) for words in line] for line in REQUESTS]


def test_it_gives_every_request_back(specs):
    """Requests of all models and systems equal what their text reads as, and keep text and hash."""
    assert {spec.model.name for line in specs for spec in line} > {*registry.names()}
    for spec in (spec for line in specs for spec in line):
        again = SweepSpec.from_canonical(spec.canonical())
        assert again == spec
        assert hash(again) == hash(spec)
        assert again.canonical() == spec.canonical()


def test_equal_requests_share_a_fingerprint(specs):
    """All forms of a request have one text and one fingerprint, which no other request shares."""
    for line, words in zip(specs, REQUESTS, strict=True):
        assert len({spec.fingerprint() for spec in line}) == 1, words
        assert all(spec == line[0] for spec in line), words
    assert len({line[0].fingerprint() for line in specs}) == len(specs)


def test_a_text_that_lacks_a_word_is_refused(specs):
    """The text has every input of a request; if one is missing, it is refused by name."""
    judged = set()
    for spec in (line[0] for line in specs):
        words = json.loads(spec.canonical())
        assert words.keys() - {"axes", "model", "system"} == spec.words().keys()
        # Without these the text describes another model, a grid or all starts.
        for name in words.keys() - {"model", "system", "samples", "start", "starts"}:
            part = json.dumps({key: value for key, value in words.items() if key != name})
            with pytest.raises(RequestError, match=rf"it lacks {name}\."):
                SweepSpec.from_canonical(part)
            judged.add(name)
    assert judged > {"axes", "title", "criterion", "device", "seed", "tilt", "body", "air_law", "flattening"}


def test_it_is_json_with_sorted_keys():
    """It is ASCII JSON with sorted keys that stores ranges as ranges; the hash is SHA-256."""
    spec = SweepSpec(tilt="0.1:0.2:3:log", alpha=[0.5, 1], title="Münze")
    text = spec.canonical()
    assert text.isascii()
    words = json.loads(text)
    assert list(words) == sorted(words)
    assert words["axes"] == ["tilt", "alpha"]
    assert words["tilt"] == {"start": 0.1, "stop": 0.2, "count": 3, "spacing": "log"}
    assert words["alpha"] == {"values": [0.5, 1.0]}
    assert words["criterion"] == {"kind": "departure", "limit": math.pi / 36}
    assert spec.fingerprint() == hashlib.sha256(text.encode()).hexdigest()


def test_other_text_is_refused():
    """Invalid JSON, unknown inputs, unknown models and invalid numbers are refused."""
    text = SweepSpec(roll_rate="1:4:13", tilt="0.1,0.2").canonical()
    for other, facts in [
        ("", []),
        ("[]", []),
        ("{}", ["tilt", "axes", "criterion"]),
        ("3", []),
        ("{'tilt': 0.1}", []),
        ("[" * 100_000, []),
        (None, []),
        (text.replace('"radius"', '"size"'), ["radius"]),
        (text.replace('"method"', '"colour":"red","method"'), ["colour"]),
        (text.replace('"method"', '"model":"sphere","method"'), ["sphere", "disk"]),
        (text.replace('"linear"', '"linear","colour":"red"'), ["colour"]),
        (text.replace("9.81", "NaN"), ["gravity"]),
    ]:
        assert other != text
        with pytest.raises(RequestError) as caught:
            SweepSpec.from_canonical(other)
        assert all(fact in str(caught.value) for fact in facts), str(caught.value)
        assert caught.value.hint


def test_the_last_bit_of_a_number_counts():
    """Tiny changes of values, and the order of the axes, change the fingerprint."""
    spec = SweepSpec(tilt="0.1:0.2:3", alpha=[0.5, 1])
    others = [
        spec.replace(tilt=[0.1, 0.15, 0.2]),
        spec.replace(axes=["alpha", "tilt"]),
        spec.replace(step=0.01),
        spec.replace(gravity=np.nextafter(9.81, 10)),
    ]
    assert len({each.fingerprint() for each in [spec, *others]}) == 1 + len(others)


@pytest.mark.parametrize(
    "words", [{"model": "secret.py"}, {"model": "secret.py:name"}, {"starts": "secret.csv"}]
)
def test_a_text_opens_no_file(tmp_path, monkeypatch, words):
    """A text from an untrusted file makes the program read or show no other file."""
    monkeypatch.chdir(tmp_path)
    for name in ("secret.py", "secret.csv"):
        (tmp_path / name).write_text("the password is 1234")
    held = json.loads(SweepSpec.from_words("rolling", []).canonical())
    with pytest.raises(RequestError) as refused:
        SweepSpec.from_canonical(json.dumps({**held, **words}))
    assert "1234" not in str(refused.value)
    assert "canonical" in str(refused.value)
