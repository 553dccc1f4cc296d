"""The strings of a system agree with Python, use the units they name, and are refused at their position."""

import math

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from messages import assert_facts, refused

from sweep.errors import RequestError
from sweep.model.system.definition import FUNCTIONS, OPERATIONS
from sweep.model.system.evaluation import evaluated
from sweep.model.system.spelling import spelled
from sweep.request.system_text import read_conserved, read_ending, read_label, read_measure, read_theory
from sweep.request.system_tree import Tree, symbol
from sweep.request.system_units import read_dimension

UNITS = {
    "x": "m",
    "y": "m",
    "angle": "rad",
    "rate": "rad/s",
    "k": "1/s2",
    "mass": "kg",
    "p": "",
    "q": "",
    "t": "s",
}
STATES = ("x", "y", "angle", "rate", "p", "q")


def tree():
    """Return the names that the strings may use."""
    return Tree(bare=True, names={name: symbol(name, read_dimension(unit)) for name, unit in UNITS.items()})


def values(nodes, **given):
    """Return the values of expressions at a point."""
    return evaluated(nodes, dict.fromkeys(UNITS, 1.0) | given)


@pytest.mark.parametrize(
    ("text", "given", "expected"),
    [
        ("x > 2", {"x": 3.0}, (1.0,)), ("x < 2", {"x": 3.0}, (-1.0,)), ("x > 2 cm", {"x": 3.0}, (2.98,)),
        ("0 < x", {"x": 3.0}, (3.0,)), ("x < 0", {"x": 3.0}, (-3.0,)), ("x > y", {"y": 0.5}, (0.5,)),
        ("abs(x) > 2", {"x": 3.0}, (1.0, -5.0)), ("2 < abs(x - y)", {"x": -4.0}, (-7.0, 3.0)),
        ("angle > 90deg", {}, (1.0 - math.pi / 2,)), ("angle > 3*pi/2", {}, (1.0 - 1.5 * math.pi,)),
        ("rate > 1 turn/s", {}, (1.0 - math.tau,)),
        ("angle > 90 deg or rate < 6 rpm", {}, (1 - math.pi / 2, math.pi / 5 - 1)),
        ("-x**2 > -4", {"x": 3.0}, (-5.0,)), ("2*-x > 1", {"x": 3.0}, (-7.0,)), ("x/2/2 > 1", {"x": 8.0}, (1.0,)),
        ("x - 1 - 1 > 0", {"x": 3.0}, (1.0,)), ("p**-2 > 2**3**-1", {"p": 2.0}, (0.25 - 2 ** (1 / 3),)),
        ("(x + y)*(x - y) > 0", {"x": 3.0}, (8.0,)), ("x>-2", {"x": 3.0}, (5.0,)), ("x -2>+1e0", {"x": 3.5}, (0.5,)),
        ("sqrt(mass*mass + 1) > 0", {"mass": 2.0, "x": 0.0}, None), ("t > 5s", {}, (-4.0,)),
    ],
)  # fmt: skip
def test_endings(text, given, expected):
    """The result is positive where the ending holds; numbers take the units of their neighbors."""
    if expected is None:
        with refused("sqrt(mass*mass + 1)"):
            read_ending(text, tree(), STATES)
    else:
        assert values(read_ending(text, tree(), STATES), **given) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "given", "expected"),
    [
        ("x > 2 and y < 3", {}, (-1.0, 2.0)), ("abs(x) < 2", {"x": -1.5}, (3.5, 0.5)),
        ("x > 2 and y < 3 and x < 9", {}, (-1.0, 2.0, 8.0)),
        ("abs(x) > 2", {"x": -3.0}, (5.0,)), ("abs(x) > 2 and 1 > y", {"x": 0.0, "y": 0.5}, (-4.0, 0.5)),
    ],
)  # fmt: skip
def test_labels(text, given, expected):
    """All results are positive where the label fits; |x| > number becomes a product of two factors."""
    assert values(read_label(text, tree(), STATES), **given) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("text", "kind", "units", "count", "spelled_text"),
    [
        ("max  abs(angle)", "max", "rad", 2, "max abs(angle)"), ("min x", "min", "m", 1, "min x"),
        ("last (x-y) / 2", "last", "m", 1, "last (x - y)/2"), ("max rate", "max", "rad s-1", 1, "max rate"),
        ("max rate**2", "max", "s-2", 1, "max rate**2"), ("max rate*x", "max", "m s-1", 1, "max rate*x"),
        ("max mass*x**2*k", "max", "kg m2 s-2", 1, "max mass*x**2*k"),
        ("last sin(angle)", "last", "1", 1, "last sin(angle)"),
        ("max sqrt(k)*angle", "max", "rad s-1", 1, "max sqrt(k)*angle"),
        ("last sqrt(x*y)", "last", "m", 1, "last sqrt(x*y)"),
        ("max p + angle", "max", "rad", 1, "max p + angle"), ("max 90deg + p", "max", "1", 1, f"max {math.pi / 2} + p"),
        ("last (x**(1/3))**3", "last", "m", 1, "last (x**0.3333333333333333)**3"),
        ("last ((x*y)**0.7/x**0.4)", "last", "m", 1, "last (x*y)**0.7/x**0.4"),
        ("max p + 90deg", "max", "1", 1, f"max p + {math.pi / 2}"),
        ("last t", "last", "s", 1, "last t"), ("max(x)", None, None, 0, ""), ("min abs(x)", None, None, 0, ""),
        ("last sqrt(x)", None, None, 0, ""), ("max mass", None, None, 0, ""),
        ("mean rate*x", "mean", "m s-1", 1, "mean rate*x"), ("integral  x", "integral", "m s", 1, "integral x"),
        ("integral rate", "integral", "rad", 1, "integral rate"), ("count x > 2", "count", "1", 0, "count x > 2"),
        ("count abs(x) < 2", "count", "1", 0, "count abs(x) < 2"),
        ("count 2 > abs(x)", "count", "1", 0, "count abs(x) < 2"),
        ("count abs(x) > 2", "count", "1", 0, "count abs(x) > 2"),
        ("count x > y and rate > 0", "count", "1", 0, "count x > y and rate > 0"),
        ("count abs(angle) < 400deg", "count", "1", 0,
         f"count {math.radians(400)} - angle > 0 and {math.radians(400)} - -angle > 0"),
        ("count x - y < y - (x - y)", "count", "1", 0, "count y - (x - y) > x - y"),
        ("count -x > 1 and abs(y) > 1", "count", "1", 0, "count -x > 1 and (y - 1)*(y + 1) > 0"),
        ("time  of first x > 2", "time", "s", 0, "time of first x > 2"),
        ("time of last x > 2 or y > 2", "time", "s", 0, "time of last x > 2 or y > 2"),
        ("time of max abs(angle)", "time", "s", 0, "time of max abs(angle)"),
        ("time of min x", "time", "s", 0, "time of min x"),
        ("value of x/3 at first angle > 90deg", "value", "m", 1, f"value of x/3 at first angle > {math.pi / 2}"),
        ("value of x*y at max rate", "value", "m2", 1, "value of x*y at max rate"),
    ],
)  # fmt: skip
def test_measures(text, kind, units, count, spelled_text):
    """They have a kind, units and a spelling that reads back unchanged."""
    if kind is None:
        with pytest.raises(RequestError):
            read_measure("m", text, tree(), STATES)
        return
    found = read_measure("m", text, tree(), STATES)
    assert (found.kind, found.units, len(found.expressions), found.text) == (kind, units, count, spelled_text)
    assert read_measure("m", found.text, tree(), STATES) == found


EXAMPLE = ["abs(angle) > 90deg"]
NAMES = ["x, y, angle, rate, k, mass, p, q, t, pi"]
STATES_ALONE = ["x, y, angle, rate, p, q"]


@pytest.mark.parametrize(
    ("text", "facts", "hint"),
    [
        ("first time of x > 2", ["max", "count", "value"], ["Write time of first x > 2."]),
        ("last time of x > 2", ["last"], ["Write time of last x > 2."]),
        ("rate at first x > 2", ["max", "count", "value"], ["Write value of rate at first x > 2."]),
        ("average x", ["mean", "average x"], ["mean x"]), ("count", ["count"], ["count x > 2"]),
        ("count x", ["comparison"], []), ("count x > 1 and y > 1 or rate > 1", ["or", "only and"], ["separately"]),
        ("count 1 < x < 2", ["two sides"], ["1 < x and x < 2"]), ("count mass > 1", ["constant"], STATES_ALONE),
        ("time of x > 2", ["first, last, max, min", "x"], []), ("time x", ["of"], []),
        ("value of x", ["at", "end"], []),
        ("value of mass at max x", ["constant"], STATES_ALONE), ("mean abs(x)", ["abs", "comparison", "max"], []),
        ("time of min abs(x)", ["abs", "max"], ["max abs(x)"]), ("integral x**0.5", ["fractional"], ["whole power"]),
    ],
)  # fmt: skip
def test_measures_that_are_refused(text, facts, hint):
    """The message says what is wrong, and what to write instead."""
    with pytest.raises(RequestError) as caught:
        read_measure("m", text, tree(), STATES)
    assert_facts(caught.value.message, *facts)
    assert_facts(caught.value.hint, *hint)


def test_theory_and_what_is_conserved():
    """A theory has the unit of its parameter; a conserved quantity has any unit."""
    wanted = tree().names["rate"]
    assert values([read_theory("sqrt(k*x/(2*y))", tree(), wanted)], k=8.0) == (2.0,)
    assert values([read_theory("3 turn/s", tree(), wanted)]) == pytest.approx((3 * math.tau,))
    with refused("rad s-1", "x", "m"):
        read_theory("x", tree(), wanted)
    assert values([read_conserved("mass*(rate*x)**2/2 + mass*k*x*y", tree(), STATES)]) == (1.5,)


@pytest.mark.parametrize(
    ("text", "place", "facts", "hint"),
    [
        ("x >", 4, ["number", "name", "bracket", "end"], EXAMPLE), ("x", 2, ["comparison", ">", "<", "end"], EXAMPLE),
        ("x = 2", 3, ["="], [">", "<"]), ("x == 2", 3, ["comparison", ">", "<", "=="], [">", "<"]),
        ("x >= 2", 3, ["comparison", ">", "<", ">="], [">", "<"]), ("1 < x < 2", 7, ["two sides"], ["1 < x and x < 2"]),
        ("x > 1 and y > 2", 7, ["and", "or"], ["two endings"]), ("not x > 1", 1, ["not"], ["x > 2", "not x < 2"]),
        ("abs(x) < 2", 8, ["abs(...)", "two"], ["(x)**2 < (2)**2"]), ("abs(x) > abs(y)", 8, ["abs"], ["x**2 > y**2"]),
        ("x - abs(y) > 2", 5, ["abs", "max"], ["abs(x) > 2", "max abs(x)"]),
        ("abs(x)*2 > 2", 1, ["abs", "max"], ["abs(x) > 2", "max abs(x)"]),
        ("x > 2 s", 3, ["x is in m", "2 is in s"], ["parameter", "units"]),
        ("angle + rate > 1", 7, ["angle is in rad", "rate is in rad s-1"], ["parameter", "units"]),
        ("x > 2 foo", 5, ["unit", "'foo'"], ["m, deg, kg", "rad/s"]), ("2 x > 1 m", 1, ["unit", "x"], ["2*x"]),
        ("2 m*x > 1", 1, ["unit", "'m*x'"], ["(2 unit)/x", "m, deg, kg"]),
        ("(2 m)*x > 1", 6, ["factor", "unit", "m"], ["parameter"]),
        ("z > 1", 1, ["z", *NAMES], ["parameter"]), ("angel > 1", 1, ["angel", *NAMES], ["angle?"]),
        ("sinus(x) > 1", 1, ["sinus", "sin, cos, tan, exp, log, sqrt, tanh"], ["+ - * /", "**"]),
        ("sin(x) > 1", 1, ["sin", "pure number", "angle", "x", "m"], ["parameter", "unit"]),
        ("x(1) > 1", 1, ["x", "function"], ["x*(...)"]), ("max(x, y) > 1", 1, ["max", "kink"], ["sqrt"]),
        ("x**y > 1", 2, ["exponent", "y"], ["exp(y*log(x))"]), ("p**(1m) > 1", 2, ["exponent", "pure number", "m"], []),
        ("x^2 > 1", 2, ["^"], ["**"]), ("x > 1/0", 6, ["1/0", "finite"], ["numbers"]),
        ("x > 1e999", 5, ["finite", "inf"], ["finite"]), ("2 > 1", None, ["1", "constant"], STATES_ALONE),
        ("mass > 1", None, ["mass - 1", "constant"], STATES_ALONE),
        ("", 1, ["number", "name", "bracket", "end"], EXAMPLE),
        ("x > (1", 7, [")", "end"], EXAMPLE),
        ("angle > 90", 7, ["bare number", "90 rad", "turn"], ["90deg", "90rad"]),
        ("x > 1 y", 5, ["unit", "y"], ["1*y"]), ("(" * 2000 + "x", None, ["2000 characters", "2001"], ["shorter"]),
        ("(" * 1900 + "x", 65, ["64 brackets"], EXAMPLE), ("-" * 1900 + "x > 1", 65, ["64 brackets"], EXAMPLE),
        ("x" + "+x" * 900 + " > 1", 130, ["64 operations", "300", "20000"], ["brackets"]),
        ("sin(" * 100 + "p" + ")" * 100 + " > 1", 257, ["64 brackets"], EXAMPLE), ("π > x", 1, ["π"], ["pi"]),
        ("x > __import__", 5, ["__import__", *NAMES], ["parameter"]), ("x.real > 1", 2, ["."], EXAMPLE),
        ("x > 20 degC", 5, ["zero", "'degC'", "K"], ["K"]),
    ],
)  # fmt: skip
def test_what_is_refused_at_its_place(text, place, facts, hint):
    """The message says what is wrong, at which character, and what to write instead."""
    with pytest.raises(RequestError) as caught:
        read_ending(text, tree(), STATES)
    at = [] if place is None else [f"character {place}"]
    assert_facts(caught.value.message, *at, *facts)
    assert_facts(caught.value.hint, *hint)
    assert bool(caught.value.hint) == bool(hint)


EXPRESSIONS = st.recursive(
    st.sampled_from(["p", "q", "p", "q", "1.5", "2", "0", "pi", "1e-3"]),
    lambda parts: st.one_of(
        st.tuples(parts, st.sampled_from("+-*/"), parts).map("({0[0]}) {0[1]} {0[2]}".format),
        st.tuples(parts, st.sampled_from("+-*"), parts).map("".join),
        parts.map("-{}".format),
        parts.map("-({})".format),
        st.tuples(parts, st.sampled_from(["2", "3", "-1", "-(1/2)", "1.5"])).map("({0[0]})**{0[1]}".format),
        st.tuples(st.sampled_from(OPERATIONS[:-1]), parts).map("{0[0]}({0[1]})".format),
        st.tuples(parts, parts).map("atan2({0[0]}, {0[1]})".format),
    ),
    max_leaves=10,
)


def away_from_its_cut(y, x):
    """Return the angle of a point, except where the sign of a zero decides, which constants do not keep."""
    if y == 0.0 and x <= 0.0:
        raise ValueError("on the cut")
    return math.atan2(y, x)


PLAIN = {name: getattr(math, name) for name in (*FUNCTIONS, "pi")} | {"__builtins__": {}}
PLAIN["atan2"] = away_from_its_cut


@given(EXPRESSIONS, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
def test_expressions_have_the_value_that_python_computes(text, p, q):
    """Values are bit-identical, and both this reader and Python read the spelling back."""
    try:
        expected = eval(f"0.0 + ({text})", PLAIN, {"p": p, "q": q})
        node = read_conserved(f"p - p + ({text})", tree(), STATES).arguments[1]
    # TypeError: the root of a negative number is complex
    except (ArithmeticError, TypeError, ValueError, RequestError):
        assume(False)
    assume(not isinstance(expected, complex))
    assert values([node], p=p, q=q) == (expected,)
    assert read_conserved(f"p - p + ({spelled(node)})", tree(), STATES).arguments[1] == node
    assert eval(f"0.0 + ({spelled(node)})", PLAIN, {"p": p, "q": q}) == expected


@pytest.mark.parametrize("name", sorted(set(FUNCTIONS) - set(OPERATIONS)))
def test_composed_functions_have_their_value(name):
    """They agree with Python's to a few units in the last place, near 0 and near 1 too."""
    for x in (-0.999999999, -0.7, -1e-9, 3e-12, 0.1, 0.5, 0.9999):
        (found,) = values([read_conserved(f"{name}(p)", tree(), STATES)], p=x, q=0.0)
        assert found == pytest.approx(getattr(math, name)(x), rel=1e-15), x


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("atan2(p)", ["atan2", "2"]),
        ("sin(p, q)", ["sin", "1", "2"]),
        ("atan2(x, p)", ["atan2", "x", "m", "p", "pure number"]),
    ],
)
def test_wrong_arguments_are_refused(text, facts):
    """The refusal names the function with the right number of arguments, or both units."""
    with pytest.raises(RequestError) as caught:
        read_conserved(text, tree(), STATES)
    assert_facts(caught.value.message, *facts)
