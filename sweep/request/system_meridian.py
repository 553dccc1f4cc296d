"""A body of revolution as a system: its states and parameters, and its rates, from the height of its centre of mass.

The height over the plane as a function of the tilt is the support function of the meridian: it and its two derivatives
say where the body touches the plane, and how it is curved there. The equations are those of docs/bodies.md.
"""

import ast
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sweep.errors import RequestError, counted
from sweep.model.system.cell_values import evaluated
from sweep.model.system.definition import TIME, Declared, Event, Meridian, Node, symbols
from sweep.model.system.meridian import TILT, ended, ends_of_tilts
from sweep.request.system_body import Arithmetic, Body
from sweep.request.system_derivative import Derivative
from sweep.request.system_source import Source
from sweep.request.system_tree import Part, Tree, check_nodes
from sweep.request.system_units import PURE, alike, read_dimension, told

#: The tilt from which on a body with a flat side has fallen, and the name of that ending.
FALL_TILT, FELL = "fall_tilt", "fell"

#: The arguments of a body that need not be named, with the defaults of other bodies.
_ALWAYS = ast.parse("""
def body(tilt: "rad" = "5 deg", tilt_rate: "rad/s" = 0.0, precession_rate: "rad/s" = 0.0, roll_rate: "rad/s" = 0.0, *,
         radius: "m" = 0.5, gravity: "m/s2" = 9.81, fall_tilt: "rad" = "85 deg"): ...
""").body[0]
#: States that a body has only if they are named.
_IF_NAMED = ast.parse("""
def path(heading: "rad" = 0.0, roll_angle: "rad" = 0.0, contact_x: "m" = 0.0, contact_y: "m" = 0.0): ...
""").body[0]

#: How far the contact is from the axis at the pole of a round side, by rounding.
_ROUND = 1e-9

#: What is measured of every body, under the names that other bodies have for it.
MEASURES = {"peak_tilt": "max abs(tilt)", "tilt_min": "min tilt", "tilt_max": "max tilt"}

#: What the rates are made of, by the height, its derivatives `slope` and `bend` by the tilt, and the moments.
_EQUATIONS = """
sine = sin(tilt)
cosine = cos(tilt)
curvature = height + bend
below = cosine*height - sine*slope
beside = -(sine*height + cosine*slope)
along = precession_rate*cosine
spin = roll_rate + precession_rate*sine
speed = below*roll_rate - slope*precession_rate
strength = gravity/radius
inertia = transverse + height**2 + slope**2
both = axial*(transverse + beside**2) + transverse*below**2
ratio = axial/transverse
turn = tilt_rate*((below - curvature*cosine)*along - (curvature*sine + ratio*beside)*spin)/both
gyration = precession_rate*(cosine*(axial*spin - transverse*sine*precession_rate) + height*speed)
precessing = (tilt_rate*(2*precession_rate*sine - ratio*spin) - axial*beside*turn)/cosine
"""
#: State -> its rate.
_RATES = {
    "tilt": "tilt_rate",
    "tilt_rate": "(gyration - slope*(strength + curvature*tilt_rate**2))/inertia",
    "precession_rate": "precessing",
    "roll_rate": "-transverse*below*turn - precessing*sine - precession_rate*cosine*tilt_rate",
    "heading": "precession_rate",
    "roll_angle": "roll_rate",
    "contact_x": "radius*(curvature*tilt_rate*cos(heading) - below*roll_rate*sin(heading))",
    "contact_y": "radius*(curvature*tilt_rate*sin(heading) + below*roll_rate*cos(heading))",
}
#: The energy over m radius^2.
_ENERGY = "(inertia*tilt_rate**2 + transverse*along**2 + axial*spin**2 + speed**2)/2 + strength*height"


class Motion(NamedTuple):
    """What makes a system of a body: its meridian, the rates of its states, and its energy over m radius^2.

    `slope` is the derivative of the height by the tilt.
    """

    meridian: Meridian
    slope: Node
    rates: tuple[Node, ...]
    energy: Node


def with_states(source: Source, function: ast.FunctionDef) -> ast.FunctionDef:
    """Return the function of a body with the arguments that it leaves out: states, radius and gravity.

    Raises
    ------
    RequestError
        If it names another state, or one with another unit.
    """
    assert isinstance(_ALWAYS, ast.FunctionDef) and isinstance(_IF_NAMED, ast.FunctionDef)
    given, always = function.args, _ALWAYS.args
    missing = [None] * (len(given.args) - len(given.defaults))
    states = {
        each.arg: (each, default)
        for each, default in zip(given.args, (*missing, *given.defaults), strict=True)
    }
    behind = {
        each.arg: (each, default) for each, default in zip(given.kwonlyargs, given.kw_defaults, strict=True)
    }
    ours = dict(zip(always.args, always.defaults, strict=True))
    more = dict(zip(_IF_NAMED.args.args, _IF_NAMED.args.defaults, strict=True))
    known = [each.arg for each in (*ours, *more)]
    for name, (argument, _) in states.items():
        if name not in known:
            source.refuse(
                argument.lineno,
                f"the states of a body are {', '.join(known)}; got {name} in front of the star",
                f"Write it behind the star: def {function.name}(tilt, *, {name}=0.3).",
            )
    ours |= {each: default for each, default in more.items() if each.arg in states}
    merged = [
        _merged(source, function, each, default, states.get(each.arg)) for each, default in ours.items()
    ]
    own = dict(zip(always.kwonlyargs, always.kw_defaults, strict=True))
    others = [each for name, each in behind.items() if name not in {each.arg for each in own}]
    others += [
        _merged(source, function, each, default, behind.get(each.arg)) for each, default in own.items()
    ]
    arguments = ast.arguments(
        posonlyargs=given.posonlyargs, vararg=given.vararg, kwarg=given.kwarg,
        args=[each for each, _ in merged], defaults=[each for _, each in merged],
        kwonlyargs=[each for each, _ in others], kw_defaults=[each for _, each in others],
    )  # fmt: skip
    return ast.copy_location(
        ast.FunctionDef(**{**dict(ast.iter_fields(function)), "args": arguments}), function
    )


def _merged(
    source: Source,
    function: ast.FunctionDef,
    ours: ast.arg,
    default: ast.expr | None,
    given: tuple[ast.arg, ast.expr | None] | None,
) -> tuple[ast.arg, ast.expr | None]:
    """Return an argument of every body, with the unit and the default that a function gives it."""
    argument, own = given if given is not None else (ours, None)
    unit = argument.annotation or ours.annotation
    assert isinstance(ours.annotation, ast.Constant)
    if isinstance(unit, ast.Constant) and isinstance(unit.value, str):
        with source.at(argument, f"the argument {ours.arg}"):
            wanted = read_dimension(str(ours.annotation.value))
            if not alike(read_dimension(unit.value), wanted):
                raise RequestError(f"it is {told(wanted)}; got {unit.value}", hint="Leave its unit out.")
    place = argument if given is not None else function
    found = ast.copy_location(ast.arg(ours.arg, unit), place)
    value = own or default
    if own is None and isinstance(value, ast.Constant):
        value = ast.copy_location(ast.Constant(value.value), place)
    return found, value


def read_motion(
    source: Source, tree: Tree, function: ast.FunctionDef, states: tuple[Declared, ...], fixed: frozenset[str]
) -> Motion:
    """Return the motion of the body that a function describes.

    Parameters
    ----------
    source : Source
    tree : Tree
        Its `names` are arguments and constants.
    function : ast.FunctionDef
    states : tuple of Declared
    fixed : frozenset of str
        Names that no line may assign.

    Raises
    ------
    RequestError
        With the line.
    """
    arguments = dict(tree.names)
    line, read = Body(source, tree, states, fixed).returned(
        function,
        "height, axial_moment, transverse_moment",
        "Return height, axial moment and transverse moment.",
    )
    if len(read) != 3:
        source.refuse(
            line.lineno,
            "a body returns three values: the height of its centre of mass over the plane as a function of the tilt, "
            f"over the radius, and the moments of inertia about its axis and across it; got {counted(len(read), 'value')}",
            "Write return height, axial_moment, transverse_moment, the moments over mass times radius squared.",
        )
    moving = {each.name for each in states} | {TIME}
    for (node, part), called, allowed in zip(
        read, ("the height", "the axial moment", "the transverse moment"), ({TILT}, set(), set()), strict=True
    ):
        if not alike(part.dimension or PURE, PURE):
            source.refuse(
                node.lineno,
                f"{called} of a body is a pure number; {part} is {told(part.dimension or PURE)}",
                "Divide a length by radius, and a moment by mass times radius squared.",
            )
        if strange := sorted({*symbols(part.node)} & moving - allowed):
            source.refuse(
                node.lineno,
                f"{called} of a body depends on {'the tilt and ' if allowed else ''}parameters alone; got {strange[0]}",
                "Leave it out: a body is rigid.",
            )
    height, axial, transverse = (part for _, part in read)
    with source.at(line, "the body"):
        derivative = Derivative(tree, TILT)
        slope = derivative.of(height.node)
        known = {"height": height, "slope": slope, "bend": derivative.of(slope.node)}
        known |= {"axial": axial, "transverse": transverse}
        # the same tree, so that what occurs in several expressions is one object
        equations = replace(tree, names=arguments | known)
        arithmetic = Arithmetic(source, equations)
        for name, value in _assigned(_EQUATIONS, line):
            equations.names[name] = arithmetic.part(value)
        rates = [arithmetic.part(_expression(_RATES[each.name], line)) for each in states]
        energy = arithmetic.part(_expression(_ENERGY, line))
        check_nodes([*rates, energy])
    meridian = Meridian(height.node, equations.names["curvature"].node, axial.node, transverse.node)
    return Motion(meridian, slope.node, tuple(each.node for each in rates), energy.node)


def _assigned(text: str, line: ast.Return) -> Iterator[tuple[str, ast.expr]]:
    for each in ast.parse(text).body:
        assert isinstance(each, ast.Assign) and isinstance(each.targets[0], ast.Name)
        yield each.targets[0].id, _placed(each.value, line)


def _expression(text: str, line: ast.Return) -> ast.expr:
    return _placed(ast.parse(text, mode="eval").body, line)


def _placed(expression: ast.expr, line: ast.Return) -> ast.expr:
    """Return an expression in the line of a user's text that it follows from."""
    for each in ast.walk(expression):
        if isinstance(each, ast.expr):
            each.lineno = line.lineno
    return expression


def falls(motion: Motion, ends: tuple[Event, ...], parameters: tuple[Declared, ...]) -> str:
    """Return when a body with flat sides has fallen on one of them, as an ending says it; empty without them."""
    values = {each.name: each.default for each in parameters}
    over = ends_of_tilts(ends, parameters)
    sides = []
    for side, sign in (("tilt", 1.0), ("-tilt", -1.0)):
        at_pole = {**values, TILT: np.array([sign * 0.5 * math.pi])}
        # there the contact is as far from the axis as the slope says
        far, height = (
            each + np.zeros(1) for each in evaluated([motion.slope, motion.meridian.height], at_pole)
        )
        if abs(far[0]) > _ROUND * max(1.0, abs(height[0])) and not ended(over, at_pole)[0]:
            sides.append(side)
    return " or ".join(f"{side} > {FALL_TILT}" for side in sides)
