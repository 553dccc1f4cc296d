"""The rates of a body of revolution, from the height of its centre of mass over the plane.

The height as a function of the tilt is the support function of the meridian: the height and its two derivatives give
the contact point and the curvature there. The equations are in docs/bodies.md.
"""

import ast
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sweep.errors import counted
from sweep.model.system.cell_values import evaluated
from sweep.model.system.definition import TIME, Declared, Event, Meridian, Node, symbols
from sweep.model.system.meridian import FALL_TILT, TILT, ended, ends_of_tilts, solid
from sweep.request.system_body import Arithmetic, Body
from sweep.request.system_derivative import Derivative
from sweep.request.system_source import Source
from sweep.request.system_tree import Part, Tree, check_nodes
from sweep.request.system_units import PURE, alike, told

#: Ending of a body that has fallen onto a flat side.
FELL = "fell"

#: Largest distance of the contact from the axis, at the pole of a round side, that is due to rounding.
_ROUND = 1e-9

#: Largest distance of a solid's center of mass from the given one that is due to rounding.
_CENTRED = 1e-9

#: Measures of every body, with the same names as for built-in bodies.
MEASURES = {"peak_tilt": "max abs(tilt)", "tilt_min": "min tilt", "tilt_max": "max tilt"}

#: Parts of the rates, from the height, its derivatives `slope` and `bend` with respect to the tilt, and the moments.
_EQUATIONS = """
sine = sin(tilt)
cosine = cos(tilt)
curvature = height + bend
below = cosine*height - sine*slope
beside = -(sine*height + cosine*slope)
along = precession_rate*cosine
rise = precession_rate*sine
spin = roll_rate + rise
speed = below*roll_rate - slope*precession_rate
strength = gravity/radius
ratio = axial/transverse
inertia = transverse + height**2 + slope**2
both = axial*inertia + (transverse - axial)*below**2
turn = tilt_rate*((below - curvature*cosine)*along - (curvature*sine + ratio*beside)*spin)/both
gyration = along*(axial*spin - transverse*rise) + precession_rate*height*speed
precessing = (tilt_rate*(2*rise - ratio*spin) - axial*beside*turn)/cosine
"""
#: State -> its rate.
_RATES = {
    "tilt": "tilt_rate",
    "tilt_rate": "(gyration - slope*(strength + curvature*tilt_rate**2))/inertia",
    "precession_rate": "precessing",
    "roll_rate": "-transverse*below*turn - precessing*sine - along*tilt_rate",
    "heading": "precession_rate",
    "roll_angle": "roll_rate",
    "contact_x": "radius*(curvature*tilt_rate*cos(heading) - below*roll_rate*sin(heading))",
    "contact_y": "radius*(curvature*tilt_rate*sin(heading) + below*roll_rate*cos(heading))",
}
#: The energy divided by m radius^2.
_ENERGY = "(inertia*tilt_rate**2 + transverse*along**2 + axial*spin**2 + speed**2)/2 + strength*height"


class Motion(NamedTuple):
    """The parts of a body's system: its meridian, the rates of its states, and its energy divided by m radius^2.

    `slope` is the derivative of the height with respect to the tilt.
    """

    meridian: Meridian
    slope: Node
    rates: tuple[Node, ...]
    energy: Node


def read_motion(
    source: Source,
    tree: Tree,
    function: ast.FunctionDef,
    states: tuple[Declared, ...],
    parameters: tuple[Declared, ...],
    fixed: frozenset[str],
) -> Motion:
    """Return the motion of the body that a function describes.

    Parameters
    ----------
    source : Source
    tree : Tree
        The tree that makes the expressions; its `names` are the arguments and the constants.
    function : ast.FunctionDef
    states, parameters : tuple of Declared
    fixed : frozenset of str
        Names that no line may assign.

    Raises
    ------
    RequestError
        With the line.
    """
    arguments = dict(tree.names)
    lines = Body(source, tree, states, fixed)
    line, nodes = lines.returned(
        function,
        "height, axial_moment, transverse_moment",
        "Return height, axial moment and transverse moment.",
    )
    if len(nodes) != 3:
        alone = lines.parts(nodes)[0] if len(nodes) == 1 else None
        source.refuse(
            line.lineno,
            "a body returns three values: the height of its center of mass over the plane as a function of the tilt, "
            "divided by the radius, and its axial and transverse moments of inertia; got "
            f"{counted(len(nodes), 'value')}",
            "Write return height, axial_moment, transverse_moment, with moments divided by mass times radius squared."
            + (_describe_solid(tree, alone, parameters) if alone else ""),
        )
    parts = lines.parts(nodes)
    _check_values(source, nodes, parts, {*(each.name for each in states), TIME})
    height, axial, transverse = parts
    with source.at(line, "the body"):
        derivative = Derivative(tree, TILT)
        slope = derivative.of(height.node)
        known = {"height": height, "slope": slope, "bend": derivative.of(slope.node)}
        known |= {"axial": axial, "transverse": transverse}
        # the same tree, so that expressions share their common parts
        equations = replace(tree, names=arguments | known)
        arithmetic = Arithmetic(source, equations)
        for name, value in _read_assignments(_EQUATIONS, line):
            equations.names[name] = arithmetic.part(value)
        rates = [arithmetic.part(_read_formula(_RATES[each.name], line)) for each in states]
        energy = arithmetic.part(_read_formula(_ENERGY, line))
        check_nodes([*rates, energy])
    meridian = Meridian(height.node, equations.names["curvature"].node, axial.node, transverse.node)
    return Motion(meridian, slope.node, tuple(each.node for each in rates), energy.node)


def _check_values(source: Source, nodes: list[ast.expr], parts: list[Part], moving: set[str]) -> None:
    """Refuse values of a body that have a unit, and a height or moment that depends on states other than the tilt."""
    for called, node, part in zip(("height", "axial moment", "transverse moment"), nodes, parts, strict=True):
        if not alike(part.dimension or PURE, PURE):
            source.refuse(
                node.lineno,
                f"the {called} of a body must be a pure number; {part} is {told(part.dimension or PURE)}",
                "Divide a length by radius, and a moment by mass times radius squared.",
            )
        allowed, of = ({TILT}, "the tilt and ") if called == "height" else (frozenset(), "")
        if strange := sorted({*symbols(part.node)} & moving - allowed):
            source.refuse(
                node.lineno,
                f"the {called} of a body may depend only on {of}parameters; got {strange[0]}",
                f"Remove {strange[0]}: a body is rigid.",
            )


def _describe_solid(tree: Tree, height: Part, parameters: tuple[Declared, ...]) -> str:
    """Return a sentence with the moments of a homogeneous body; empty if no such body has this height."""
    values = {each.name: each.default for each in parameters}
    if not {*symbols(height.node)} <= {TILT, *values}:
        return ""
    derivative = Derivative(tree, TILT)
    slope = derivative.of(height.node)
    curvature = tree.summed("+", height, derivative.of(slope.node))
    axial, transverse, centre = solid(height.node, slope.node, curvature.node, values)
    if not math.isfinite(transverse):
        return ""
    # endings may exclude tilts, as for the flat side of a dome: these moments ignore that
    found = (
        f" A homogeneous body with this height at all tilts has the moments {axial:.6g} and {transverse:.6g}"
    )
    shift = f", if you add {centre:.6g}*sin(tilt) to the height, to measure it from the center of mass"
    return f"{found}{shift if abs(centre) > _CENTRED else ''}."


def _read_assignments(text: str, line: ast.Return) -> Iterator[tuple[str, ast.expr]]:
    for each in ast.parse(text).body:
        assert isinstance(each, ast.Assign)
        assert isinstance(each.targets[0], ast.Name)
        yield each.targets[0].id, _set_line(each.value, line)


def _read_formula(text: str, line: ast.Return) -> ast.expr:
    return _set_line(ast.parse(text, mode="eval").body, line)


def _set_line(expression: ast.expr, line: ast.Return) -> ast.expr:
    """Return an expression, located at the line of the user's text from which it follows."""
    for each in ast.walk(expression):
        if isinstance(each, ast.expr):
            each.lineno = line.lineno
    return expression


def falls(motion: Motion, ends: tuple[Event, ...], parameters: tuple[Declared, ...]) -> str:
    """Return the condition of a fall onto a flat side, in the notation of an ending; empty without flat sides."""
    values = {each.name: each.default for each in parameters}
    over = ends_of_tilts(ends, parameters)
    sides = []
    for side, sign in (("tilt", 1.0), ("-tilt", -1.0)):
        at_pole = {**values, TILT: np.array([sign * 0.5 * math.pi])}
        # at the pole the slope is the distance of the contact from the axis
        far, height = (
            each + np.zeros(1) for each in evaluated([motion.slope, motion.meridian.height], at_pole)
        )
        if abs(far[0]) > _ROUND * max(1.0, abs(height[0])) and not ended(over, at_pole)[0]:
            sides.append(side)
    return " or ".join(f"{side} > {FALL_TILT}" for side in sides)
