"""The inputs of bodies: which model they choose, their units, and what is refused."""

import math
import re
import tomllib

import numpy as np
import pytest
from messages import assert_facts, missing, refused

from sweep.engine.grid import whole
from sweep.errors import RequestError
from sweep.model.bodies.model import BODIES
from sweep.model.bodies.shape import LENGTHS
from sweep.model.bodies.theory import pole_prediction
from sweep.model.disk.model import DISK
from sweep.motion.request import TrajectorySpec
from sweep.request.spec import SweepSpec

TORUS = {"body": "torus", "tube": 0.25}
BALL = {"body": "ball", "offset": 0.2, "axial_moment": 0.42, "transverse_moment": 0.38}

PROLATE = {"body": "spheroid", "flattening": -0.5}

#: Inputs -> text of the refusal.
REFUSED = {
    "body=cube": "body is torus or rounded or rim or arc or ball or spheroid",
    "body=torus": "needs its tube",
    "tube=0.2": "the request names no body; got tube=0.2. Add body=torus",
    "body=torus tube=1": "0 <= tube < 1",
    "body=torus tube=-0.1": "0 <= tube < 1",
    "body=torus tube=30mm radius=20mm": "0 <= tube < 1",
    "body=torus tube=3deg": "takes m, cm, inch",
    "body=torus tube=0.2 thickness=0.2": "has no thickness; it has tube",
    "body=torus tube=0.2 alpha=1": "alpha is for the thin disk",
    "body=torus tube=0.2 speed=1": "Write roll_rate",
    "body=torus tube=1cm radius=0.1,0.2": "radius varies here",
    "body=rounded": "needs its thickness",
    "body=rounded thickness=2.5": "at most two radii thick",
    "body=rounded thickness=0.2 filling=hollow": "Only a torus is solid or hollow",
    "body=rim thickness=0": "thicker than 0",
    "body=rim thickness=0.1 fillet=0.06": "0 <= fillet <= thickness/2",
    "body=rim thickness=0.1:0.3:3 fillet=0.06": "0 <= fillet <= thickness/2",
    "body=arc fillet=0.2 offset=0.1": "Give axial_moment and transverse_moment",
    "body=arc fillet=1.2 axial_moment=0.4 transverse_moment=0.3": "0 <= fillet <= 1",
    "body=arc thickness=0.2 axial_moment=0.4 transverse_moment=0.3": "has no thickness; it has fillet and offset",
    "body=ball offset=0.1": "do not follow from its shape",
    "body=ball offset=1 axial_moment=0.4 transverse_moment=0.4": "lies inside: -1 < offset < 1",
    "body=ball fall_tilt=89deg": "does not fall",
    "body=ball flattening=0.2": "A ball has no flattening",
    "body=spheroid": "needs its flattening",
    "body=ball criterion=aloft:2s": "A ball does not fall: by the criterion",
    "body=spheroid flattening=0.9": "-2 <= flattening <= 0.8",
    "body=spheroid flattening=5mm": "takes no unit",
    "body=arc fillet=0.2 offset=-5 axial_moment=0.4 transverse_moment=0.3": "-3 < offset < 3",
    "body=arc fillet=0.2 offset=5 axial_moment=0.4 transverse_moment=0.3": "-3 < offset < 3",
    "body=spheroid flattening=0.4 offset=0.1": "The moments of a spheroid",
    "body=spheroid flattening=0.2:0.4:3 offset=0.6 axial_moment=0.4 transverse_moment=0.4": "-0.6 < offset < 0.6",
    "body=ball offset=0.1 axial_moment=0.9 transverse_moment=0.4": "axial_moment <= 2 transverse_moment",
    "body=ball offset=0.1 axial_moment=-0.4 transverse_moment=0.4": "axial_moment > 0",
    "body=ball offset=0.1 axial_moment=solid transverse_moment=0.4": "what follows from the shape",
    "body=torus tube=0.2 precession_rate=wobble": "roll_rate=wobble",
}


def spec_of(words):
    """Return the spec of command-line words that change the preset `rolling`."""
    return SweepSpec.from_words("rolling", words.split())


def test_what_no_body_is_is_refused_in_a_sentence():
    """Each refusal says what is wrong, the bounds, and what to do."""
    for words, told in REFUSED.items():
        with pytest.raises(RequestError) as caught:
            spec_of(words)
        assert told in str(caught.value), words
        assert caught.value.hint, words


def test_a_length_that_a_body_lacks_is_refused():
    """Even a length that is optional for another body is refused; the message names the body's own."""
    needed = {"tube": 0.2, "thickness": 0.2, "flattening": 0.1}
    names = sorted({name for lengths in LENGTHS.values() for name in lengths})
    for body, lengths in LENGTHS.items():
        own = {name: value for name, value in needed.items() if name in lengths}
        for name in names:
            if name not in lengths:
                with refused(f"body={body}", f"{name}=0.1", *lengths):
                    SweepSpec.preset("rolling", body=body, **own, **{name: 0.1})


def test_a_length_is_a_share_of_the_radius_or_has_a_unit():
    """Both forms work, also in ranges and files; the spec stores the share."""
    assert SweepSpec(body="torus", tube="5mm", radius="20mm").tube == 0.25
    axis = SweepSpec(body="rim", thickness="1mm:3mm:3", radius="10mm").thickness
    assert axis.array().tolist() == pytest.approx([0.1, 0.2, 0.3])
    assert SweepSpec(body="rim", thickness=0.2, fillet="0.5mm", radius="10mm").fillet == 0.05
    assert SweepSpec(body="rounded", thickness="0.02:0.5:200").shape == (200,)
    text = 'body = "torus"\ntube = "5mm"\nradius = "20mm"\nroll_rate = "1:2:3"\n'
    assert SweepSpec(**tomllib.loads(text)).tube == 0.25


def test_a_table_has_a_body_for_each_start():
    """Its columns are compared with each other row by row."""
    table = {"tilt": [0.1, 0.7], "thickness": [0.1, 0.4], "fillet": [0.02, 0.15]}
    spec = SweepSpec(body="rim", starts=table)
    assert whole(spec)["fillet"].tolist() == [0.02, 0.15]
    assert SweepSpec.from_canonical(spec.canonical()).model is BODIES
    with refused("0 <= fillet <= thickness/2"):
        SweepSpec(body="rim", starts=table | {"fillet": [0.06, 0.15]})


def test_the_thin_disk_is_the_model_without_a_body(tmp_path):
    """body=disk does not appear in a request's text; it replaces another body with all its inputs."""
    thin = SweepSpec.preset("rolling")
    assert SweepSpec.preset("rolling", body="disk").canonical() == thin.canonical()
    assert SweepSpec.preset("rolling", body="disk").fingerprint() == thin.fingerprint()
    ring = thin.replace(**TORUS)
    assert ring.model is BODIES
    assert ring.replace(body="disk").canonical() == thin.canonical()
    file = tmp_path / "ring.toml"
    file.write_text(ring.to_toml())
    assert SweepSpec.from_toml(file) == ring
    assert SweepSpec.from_words(file, ["body=disk"]).model is DISK
    assert SweepSpec.from_canonical(ring.canonical()) == ring
    file.write_text('body = "disk"\nalpha = 1\n')
    assert SweepSpec.from_toml(file).alpha == 1.0
    file.write_text('body = "torus"\ntube = 0.2\nalpha = 1\n')
    with pytest.raises(RequestError, match="alpha"):
        SweepSpec.from_toml(file)


def test_moments_follow_from_the_body_or_are_given():
    """The moments of a hoop, tori, a cylinder, a disk with a semicircular edge and a ball are known."""
    axial, transverse = 0.47998914980, 0.24319566028
    known = (
        ({"body": "torus", "tube": 0.0}, 1.0, 0.5),
        (TORUS, 0.609375, 0.3203125),
        ({"body": "torus", "tube": 0.3, "filling": "hollow"}, 0.625, 0.3575),
        ({"body": "rounded", "thickness": 0.2}, axial, transverse),
        ({"body": "rounded", "thickness": 2.0}, 0.4, 0.4),
        ({"body": "rim", "thickness": 0.2, "fillet": 0.1}, axial, transverse),
        ({"body": "rim", "thickness": 0.6}, 0.5, 0.25 + 0.6**2 / 12.0),
        ({"body": "ball"}, 0.4, 0.4),
        ({"body": "spheroid", "flattening": 0.5}, 0.4, 0.25),
        ({"body": "spheroid", "flattening": -0.5}, 0.4, 0.65),
        (BALL, 0.42, 0.38),
        (TORUS | {"axial_moment": 0.5}, 0.5, 0.3203125),
    )
    for words, axial, transverse in known:
        starts = whole(SweepSpec(**words))
        assert starts["axial_moment"][0] == pytest.approx(axial, abs=1e-10), words
        assert starts["transverse_moment"][0] == pytest.approx(transverse, abs=1e-10), words


def test_moments_of_a_rim_by_quadrature():
    """They match sums over thin slices of a solid whose edges are quarter circles."""
    starts = whole(SweepSpec(body="rim", thickness=0.5, fillet=0.1))
    z = (np.arange(400_000) + 0.5) / 400_000 * 0.25
    inner = np.maximum(z - 0.15, 0.0)
    r = 0.9 + np.sqrt(0.01 - inner**2)
    axial = 0.5 * (r**4).sum() / (r**2).sum()
    across = 0.5 * axial + (z**2 * r**2).sum() / (r**2).sum()
    assert starts["axial_moment"][0] == pytest.approx(axial, rel=1e-8)
    assert starts["transverse_moment"][0] == pytest.approx(across, rel=1e-8)


def test_rates_that_keep_the_tilt():
    """Thin bodies circle and wobble at the disk's rates; a thick one has a steady motion."""
    words = {"tilt": "20deg,60deg", "precession_rate": 3.0, "roll_rate": "steady"}
    thin, hoop = (whole(SweepSpec(**words, **body)) for body in ({"alpha": 1}, {"body": "torus", "tube": 0}))
    np.testing.assert_allclose(hoop["roll_rate"], thin["roll_rate"], rtol=1e-14)
    wobbling = {"tilt": "80deg", "precession_rate": "wobble", "roll_rate": "wobble"}
    thin, hoop = (
        whole(SweepSpec(**wobbling, **body)) for body in ({"alpha": 1}, {"body": "torus", "tube": 0})
    )
    for rate in ("precession_rate", "roll_rate"):
        np.testing.assert_allclose(hoop[rate], thin[rate], rtol=1e-14)
    # The motions on both edges of a rim are mirror images.
    spec = SweepSpec(body="rim", thickness=0.3, tilt="-70deg,70deg", precession_rate=3.0, roll_rate="steady")
    low, high = whole(spec)["roll_rate"]
    assert low == pytest.approx(-high, rel=1e-14)
    assert math.isfinite(low)


def test_what_starts_disturb():
    """A criterion measures from upright, from circling, or from the ball's spin on its end."""
    for words, tilt in ((TORUS, 0.0), (BALL, math.pi / 2), (BALL | {"tilt": -1.0}, -math.pi / 2)):
        spec = SweepSpec(**{"tilt": 1.0, "tilt_rate": 0.1, **words})
        starts = whole(spec)
        assert spec.model.undisturbed(spec, starts).tolist() == [tilt]
        slow = math.sqrt((1.0 + starts["transverse_moment"][0]) * 0.5 / 9.81)
        away = abs(starts["tilt"][0] - tilt)
        assert spec.model.perturbation(spec, starts)[0] == pytest.approx(math.hypot(away, 0.1 * slow))
    standing, lying = SweepSpec(**PROLATE, tilt="80deg,89deg"), SweepSpec(**PROLATE, tilt="10deg,40deg")
    off_centre = SweepSpec(**BALL | PROLATE, tilt="1deg")
    for spec, found in ((standing, True), (lying, False), (off_centre, True)):
        assert (missing(spec.headline, ["end"]) == []) == found
        tilts = spec.model.undisturbed(spec, whole(spec))
        assert set(tilts.tolist()) == {math.pi / 2 if found else 0.0}
    assert_facts(SweepSpec(**BALL).headline, "end")
    assert_facts(SweepSpec(**TORUS).headline, "torus")


def test_what_a_start_disturbs_is_its_own():
    """In a grid a spheroid disturbs the same motion as alone: the nearer one, or its end if off-center."""
    given = {"body": "spheroid", "axial_moment": 0.4, "transverse_moment": 0.5, "flattening": -0.5}
    spec = SweepSpec(**given, tilt="-80deg:80deg:9", offset="0,0.1", roll_rate=1.0)
    starts = whole(spec)
    ends, model = 0.5 * math.pi, spec.model
    found, sizes = model.undisturbed(spec, starts), model.perturbation(spec, starts)
    named = {0.0: "the upright spheroid", ends: "on its end", -ends: "on its end"}
    for i, (tilt, offset) in enumerate(zip(starts["tilt"], starts["offset"], strict=True)):
        upright = offset == 0.0 and abs(tilt) < 0.8
        alone = SweepSpec(**given, tilt=float(tilt), offset=float(offset), roll_rate=1.0)
        start = whole(alone)
        assert (
            found[i] == model.undisturbed(alone, start)[0] == (0.0 if upright else math.copysign(ends, tilt))
        )
        assert sizes[i] == model.perturbation(alone, start)[0]
        words = model.disturbed_motion(spec, {name: float(values[0]) for name, values in start.items()})
        assert named[found[i]] in words


def test_lines_of_starts_upright_and_on_their_end():
    """Each row has the line of the motion it disturbs; an oblate spheroid on its pole has none."""
    spec = SweepSpec(body="spheroid", flattening=0.5, tilt="10deg,80deg", roll_rate="0.1:2:20")
    rows = {name: values[[0, 20]] for name, values in whole(spec).items()}
    assert np.degrees(rows["tilt"]) == pytest.approx([10.0, 80.0])
    (upper, _), alone = (
        each.model.lines(each, "roll_rate", rows)["upper"]
        for each in (spec, SweepSpec(body="spheroid", flattening=0.5, tilt="10deg", roll_rate="0.1:2:20"))
    )
    assert upper[0] == alone[0][0]
    assert np.isnan(upper[1])


def test_what_rolls_through_its_poles_is_computed_by_the_reduction_alone():
    """Balls and spheroids use method=exact, and drop it when replaced by a body or model that has RK4."""
    for words in (BALL, PROLATE):
        spec = SweepSpec(**words)
        assert spec.method == "exact"
        assert spec.replace(title="x").method == "exact"
        assert SweepSpec.from_canonical(spec.canonical()) == spec
        with refused("method=exact", "method=rk4"):
            SweepSpec(**words, method="rk4")
        with refused("method=exact", "method=rk4"):
            spec.replace(method="rk4")
    bowl = SweepSpec(body="arc", fillet=1.0, offset=0.1, axial_moment=0.4, transverse_moment=0.3)
    assert bowl.method == "rk4"
    assert bowl.replace(body="ball", fillet="none").method == "exact"


@pytest.mark.parametrize(
    ("words", "bodies"),
    [
        ("thickness=1.88mm", ["rounded", "rim"]),
        ("tube=0.2", ["torus"]),
        ("filling=hollow tube=0.2", ["torus"]),
        ("thickness=0.3 fillet=0.1", ["rim"]),
        ("flattening=0.2", ["spheroid"]),
        ("axial_moment=0.3", ["ball"]),
        ("offset=0.1 axial_moment=0.4 transverse_moment=0.4", ["arc", "ball"]),
        ("thickness=0.1 rolling_friction=1um", ["rounded", "rim"]),
    ],
)
def test_a_length_without_a_body(words, bodies):
    """The message names only bodies that have the given length, each with all the inputs it needs."""
    given = dict(word.split("=") for word in words.split())
    for ask in (lambda: spec_of(words), lambda: TrajectorySpec.read(roll_rate=3, **given)):
        with pytest.raises(RequestError) as caught:
            ask()
        said = str(caught.value)
        assert_facts(said, words.split()[0])
        assert re.findall(r"body=(\w+)", said) == bodies
        assert "ball" in bodies or "ball" not in said
    for body in bodies:
        assert spec_of(f"{words} body={body}").body == body


def test_lengths_that_no_body_has_together():
    """The message names a body for the first of them."""
    with refused("tube", "thickness", "body=torus"):
        spec_of("tube=0.2 thickness=0.3")
    assert spec_of("tube=0.2 body=torus").body == "torus"


def test_a_column_of_a_length_without_a_body():
    """The message about a column also suggests a body."""
    starts = {"tilt": [0.1, 0.2], "thickness": [0.1, 0.2]}
    with refused("thickness", "body=rim"):
        SweepSpec(roll_rate=3, starts=starts)
    assert SweepSpec(roll_rate=3, starts=starts, body="rim").size == 2


def test_the_spin_of_a_body_on_its_end_is_the_sum_of_both_rates():
    """About the vertical the two rates add up on one end and subtract on the other."""
    for tilt, spin in ((89.9, 5.0), (-89.9, 1.0)):
        spec = SweepSpec(**PROLATE, tilt=f"{tilt}deg", roll_rate=3.0, precession_rate=2.0)
        start = {name: float(each[0]) for name, each in whole(spec).items()}
        (told,) = re.findall(r"its spin, (\S+) rad/s", pole_prediction(spec, start))
        assert float(told) == pytest.approx(spin, abs=1e-5)
