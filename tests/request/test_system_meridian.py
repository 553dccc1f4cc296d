"""A user's body as a system: its rates against a rigid body in space, its additions, and refusals."""

import cmath
import math

import numpy as np
import pytest
from body_referee import UP, cross
from meridian_referee import Body
from messages import assert_facts, refused
from numpy.polynomial import Polynomial

from sweep.model.system.evaluation import evaluated
from sweep.model.system.model import model_of
from sweep.model.system.spelling import spelled
from sweep.request.spec import SweepSpec
from sweep.request.system_body import Arithmetic
from sweep.request.system_derivative import Derivative
from sweep.request.system_file import read_system
from sweep.request.system_source import Source
from sweep.request.system_tree import Tree, symbol
from sweep.request.system_units import PURE
from sweep.systems import System, body, cos, sin

HEAD = "from sweep.systems import body, cos, sin, sqrt, tan, exp, log, tanh\n"
#: A sum of all shapes that the referee knows: ring, ellipsoid, offset, and terms beyond arcs.
HEIGHT = (
    "core*cos(tilt) + edge*sqrt(cos(tilt)**2 + square*sin(tilt)**2) + shift*sin(tilt) + second*sin(tilt)**2 "
    "+ third*sin(tilt)**3"
)
NAMES = ("core", "shift", "edge", "axial", "transverse", "square")
ALL = ", ".join(f"{name}={value}" for name, value in zip(NAMES, (0.7, 0.1, 0.3, 0.4, 0.3, 0.8), strict=True))


def file(returned, arguments="tilt, *, q=0.5", words='duration="10 s"'):
    """Return the text of a body whose function returns the values on its second line."""
    return f"{HEAD}@body({words})\ndef f({arguments}):\n    return {returned}\n"


def test_rates_and_energy_are_those_of_a_rigid_body_in_space(rng):
    """Random states of random bodies match in angular acceleration, contact path and energy."""
    states = "tilt, tilt_rate, precession_rate, roll_rate, heading, roll_angle, contact_x, contact_y"
    found = read_system(file(f"{HEIGHT}, axial, transverse", f"{states}, *, {ALL}, second=0.1, third=0.02"))
    assert [each.name for each in found.states] == states.split(", ")
    for _ in range(50):
        given = dict(zip(NAMES, rng.uniform(0.2, 1.0, 6), strict=True))
        more = {"second": rng.uniform(-0.1, 0.1), "third": rng.uniform(-0.05, 0.05)}
        referee = Body(**given, more=Polynomial([0.0, 0.0, *more.values()]))
        tilt, w, precession, roll, heading = rng.uniform(-1.4, 1.4, 5)
        radius, gravity = rng.uniform(0.1, 2.0), rng.uniform(1.0, 10.0)
        unit = math.sqrt(gravity / radius)
        rates = (unit * each for each in (w, precession, roll))
        values = dict(
            zip([each.name for each in found.states], (tilt, *rates, heading, 0.0, 0.0, 0.0), strict=True)
        )
        values |= given | more | {"radius": radius, "gravity": gravity}
        tilt_rate, *acceleration, turned, rolled, ahead, aside = evaluated(found.rates, values)
        y = referee.start(tilt, w, precession * math.cos(tilt), roll + precession * math.sin(tilt))
        # The angular velocity is w along e2, the precession along UP and the roll along the axis n.
        n, e2 = y[:3], np.array([0.0, 1.0, 0.0])
        n_rate = cross(y[3:], n)
        forward, upright, about = (each / unit**2 for each in acceleration)
        turning = forward * e2 + w * precession * cross(UP, e2) + upright * UP + about * n + roll * n_rate
        assert turning == pytest.approx(referee.right_side(0.0, y)[3:], abs=2e-12, rel=2e-12)
        assert (tilt_rate, turned, rolled) == (
            values["tilt_rate"],
            values["precession_rate"],
            values["roll_rate"],
        )
        # The contact of a rolling body moves with the center of mass plus the contact's motion relative to
        # it.
        r, r_rate = referee.contact(n, n_rate)
        moved = r_rate - cross(y[3:], r)
        cosine, sine = math.cos(heading), math.sin(heading)
        expected = (
            radius
            * unit
            * np.array([cosine * moved[0] - sine * moved[1], sine * moved[0] + cosine * moved[1]])
        )
        assert (ahead, aside) == pytest.approx(expected, abs=1e-12, rel=1e-12)
        (energy,) = evaluated(found.conserved, values)
        assert energy / unit**2 == pytest.approx(referee.energy(y), rel=1e-13)


@pytest.mark.parametrize("text", [
    "x**3 - 2/x", "x*sin(3*x)", "cos(x)/(1 + x)", "tan(x/3)", "exp(-x**2)", "log(2 + x)*x", "sqrt(1 + x**2)",
    "tanh(2*x)", "(cos(x)**4 + 0.3*sin(x)**4)**0.25", "(1 + x)**-1.5 - x*(x - x)", "-x + 3", "7",
    "x*atan(2*x)", "asin(x/3)", "acos(x/3)", "sinh(x)*cosh(x)", "atan2(x**2, 1 + x)", "atan2(2, 3)",
])  # fmt: skip
def test_derivatives(text, rng):
    """They match a complex step, which has no cancellation."""
    tree = Tree(names={"x": symbol("x", PURE)})
    functions = {name: getattr(cmath, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh")}
    # all points are right of the origin
    functions["atan2"] = lambda y, x: cmath.atan(y / x)
    source = Source(text)
    node = Arithmetic(source, tree).part(source.parsed().body[0].value).node
    slope = Derivative(tree, "x").of(node).node
    for x in rng.uniform(0.1, 1.4, 20):
        step = eval(spelled(node), functions, {"x": complex(x, 1e-30)})
        assert eval(spelled(slope), functions, {"x": x}) == pytest.approx(
            complex(step).imag / 1e-30, rel=1e-12, abs=1e-12
        )


def test_what_a_body_has_that_is_not_written():
    """States, radius and gravity are added, a fall only for flat sides, and extremes, all just once."""
    lens = read_system(file("sqrt(cos(tilt)**2 + q**2*sin(tilt)**2), 0.4, (1 + q**2)/5"))
    assert [each.name for each in lens.states] == ["tilt", "tilt_rate", "precession_rate", "roll_rate"]
    assert [each.name for each in lens.parameters] == ["q", "radius", "gravity"]
    assert lens.ends == ()
    assert [each.name for each in lens.measures] == ["peak_tilt", "tilt_min", "tilt_max"]
    ring = read_system(file("(1 - q)*cos(tilt) + q, 0.6, 0.4"))
    assert [each.name for each in ring.parameters] == ["q", "radius", "gravity", "fall_tilt"]
    assert [each.name for each in ring.ends] == ["fell"]
    assert len(ring.ends[0].any_positive) == 2
    # A dome falls to one side only.
    words = 'duration="10 s", ends={"edge": "tilt < 0"}, measures={"tilt_max": "max tilt_rate"}'
    dome = read_system(file("1 - q*(sin(tilt) - cos(tilt)/4), 0.4, 0.4", words=words))
    assert [each.name for each in dome.ends] == ["edge", "fell"]
    assert [spelled(each) for each in dome.ends[1].any_positive] == ["tilt - fall_tilt"]
    assert {each.name: each.text for each in dome.measures}["tilt_max"] == "max tilt_rate"
    own = read_system(
        file(
            "cos(tilt), q, q/2",
            'roll_rate="3 rad/s", tilt="2 deg", *, radius="4 cm", q=0.5, fall_tilt: "deg"=80',
        )
    )
    assert {each.name: each.default for each in (*own.states, *own.parameters)} == {
        "tilt": math.radians(2.0), "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 3.0,
        "q": 0.5, "radius": 0.04, "gravity": 9.81, "fall_tilt": math.radians(80.0),
    }  # fmt: skip
    for each in (lens, ring, dome, own):
        assert "@body(" in each.text
        assert read_system(each.text) == each


def test_a_body_in_python(rng):
    """The decorator reads it like a file; calling it returns the rates."""

    @body(duration="5 s", stable="peak_tilt < 60deg")
    def egg(tilt, *, long=0.2):
        """An egg."""
        u = sin(tilt)
        return 1 + long * u**2, 0.4, 0.45

    assert isinstance(egg, System)
    assert egg.definition == read_system(egg.definition.text)
    assert egg.definition.title == "An egg."
    # Rolling upright, nothing changes.
    assert egg(0.0, 0.0, 0.0, 3.0) == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=1e-15)
    assert cos(0.0) == 1.0
    with refused("@body", "duration", '@body(duration="10 s")'):

        @body
        def bare(tilt):
            return 1.0, 0.4, 0.4


@pytest.mark.parametrize(("returned", "arguments", "words", "facts"), [
    ("1 + q*sin(tilt)**2, 0.5, 0.3", "tilt, *, q=1.2", "", ["line 4", "curvature", "-0.199726", "q=1.2"]),
    ("q - sin(tilt), 0.4, 0.4", "tilt, *, q=0.5", "", ["line 4", "height", "0", "-0.00753836", "30.5 deg", "q=0.5"]),
    ("1.0, q, 0.2", "tilt, *, q=0.5", "", ["line 4", "axial moment <= 2 transverse moment", "0.5 and 0.2", "q=0.5"]),
    ("1.0, 0.4, -q", "tilt, *, q=0.5", "", ["line 4", "0 < axial moment <= 2 transverse moment", "0.4 and -0.5"]),
    ("1 + q*sin(tilt)**2", "tilt, *, q=0.5", "", ["line 4", "three values", "1 value"]),
    ("1.0, 0.4, 0.4 + 0.1*cos(tilt)", "tilt", "", ["line 4", "transverse moment", "parameters", "tilt"]),
    ("1 + 0.1*heading, 0.4, 0.4", "tilt, heading", "", ["line 4", "height", "tilt", "heading"]),
    ("radius, 0.4, 0.4", "tilt", "", ["line 4", "height", "pure number", "radius", "m"]),
    ("1.0, 0.4, 0.4", "tilt, speed", "", ["line 3", "tilt, tilt_rate", "contact_y", "def f(tilt, *, speed=0.3)"]),
    ("1.0, 0.4, 0.4", 'tilt: "m"', "", ["line 3", "argument tilt", "rad", "m"]),
    ("1.0, 0.4, 0.4", "tilt, /", "", ["line 3", "mark /"]),
    ("1.0, 0.4, 0.4", "tilt", ', conserved="tilt"', ["line 2", "word conserved", "body(...)", "duration", "theory"]),
    ("1.0, 0.4, 0.4", 'tilt, *, fall_tilt="80 deg"', "", ["line 3", "parameter fall_tilt", "not used"]),
    ("abs(tilt), 0.4, 0.4", "tilt", "", ["line 4", "function abs", "kink"]),
    ("1.0, 0.4, 0.4", 'tilt="90 deg"', "", ["line 4", "-90 deg < tilt < 90 deg", "tilt=90deg"]),
])  # fmt: skip
def test_refused(returned, arguments, words, facts):
    """The message has the line, the bound and the given value."""
    with refused(*facts) as caught:
        read_system(file(returned, arguments, f'duration="10 s"{words}'), where="mine.py")
    assert str(caught.value).startswith("mine.py, line ")


@pytest.mark.parametrize(("height", "axial", "transverse", "shift"), [
    ("1.0", 2 / 5, 2 / 5, None),
    ("sqrt(cos(tilt)**2 + 0.25*sin(tilt)**2)", 2 / 5, 1 / 4, None),
    # A disk with a semicircular edge, from the table of `body_referee`.
    ("0.9*cos(tilt) + 0.1", 0.47998914980, 0.24319566028, None),
    # A ball about a point other than its center.
    ("1 + 0.3*sin(tilt)", 2 / 5, 2 / 5, "-0.3"),
    # A plane disk has no volume.
    ("cos(tilt)", None, None, None),
])  # fmt: skip
def test_moments_that_are_missing_are_told(height, axial, transverse, shift):
    """The hint gives a homogeneous body's moments, and the shift that centers the height on its mass."""
    with refused("three values", "1 value") as caught:
        read_system(file(height, "tilt"))
    told = caught.value.hint
    assert ("homogeneous" in told) == (axial is not None)
    if axial is not None:
        assert_facts(told, f"{axial:.6g}", f"{transverse:.6g}")
    assert ("*sin(tilt)" in told) == (shift is not None)
    assert shift is None or f" {shift}*sin(tilt) " in told


def test_a_body_that_is_followed_in_convex_tilts_alone():
    """An ending by tilt excludes the tilts beyond it from the convexity check."""
    hollow = "cos(tilt) + q*sin(tilt)**2 - 0.1*cos(3*tilt), 0.5, 0.3"
    with refused("curvature", "-1.02058", "-68.5 deg", "q=0.5"):
        read_system(file(hollow))
    words = 'duration="10 s", ends={"hollow": "abs(tilt) > limit"}'
    read_system(file(hollow, 'tilt, *, q=0.5, limit: "rad"="30 deg"', words))
    with refused("duration", "unit", "10", 'duration="10 s"'):
        read_system(file("1.0, 0.4, 0.4", "tilt", "duration=10"))


@pytest.mark.parametrize(("words", "facts"), [
    ({"q": "0.1:1.5:8"}, ["curvature", "-0.0997487", "-89.5 deg", "gap=0", "moment=0.5", "q=1.1"]),
    # The error is not at the ends of the range.
    ({"q": 0.3, "gap": "0:2:3"}, ["curvature", "gap=1", "moment=0.5", "q=0.3"]),
    ({"q": "uniform:0:1.5", "samples": 10}, ["curvature", "gap=0", "moment=0.5"]),
    ({"moment": "0.1:0.9:5"}, ["0.9 and 0.4", "gap=0", "moment=0.9", "q=0.1"]),
    ({"tilt": "0:90deg:4"}, ["-90 deg < tilt < 90 deg", "tilt=90deg"]),
    ({"tilt": -1.6}, ["-90 deg < tilt < 90 deg", "tilt=-91.6732deg"]),
    ({"radius": "-1:1:3"}, ["radius > 0", "radius=-1"]),
    ({"gravity": 0.0}, ["gravity > 0", "gravity=0"]),
])  # fmt: skip
def test_values_of_a_request_that_are_no_body(words, facts):
    """They are refused with their values before anything is computed."""
    height = "1 + (q + 4*gap*(2 - gap))*sin(tilt)**2"
    model = model_of(read_system(file(f"{height}, moment, 0.4", "tilt, *, q=0.1, gap=0.0, moment=0.5")))
    assert SweepSpec(model=model, q="0.1:0.9:8", tilt="-80deg:80deg:9").size == 72
    assert model.controls(["tilt", "roll_rate", "precession_rate", "q"]) == [
        "roll_rate",
        "precession_rate",
        "q",
    ]
    with refused(*facts):
        SweepSpec(model=model, **words)


def test_a_fall_that_is_none():
    """The fall tilt of a body with a flat side is below 90 degrees."""
    model = model_of(read_system(file("cos(tilt), q, q/2")))
    for value in ("0deg", "90deg", "70deg:95deg:3"):
        with refused("0 deg < fall_tilt < 90 deg", f"fall_tilt={value}"):
            SweepSpec(model=model, fall_tilt=value)
