"""The bodies: their meridian as an arc of a circle or an ellipse, and the moments of inertia of their shape.

The *core* of an arc is the distance of its centre from the axis of the body. Its *shift* is the position of the
centre along the axis, relative to the centre of mass. Its *edge* is its radius across the axis. All are over the
outer radius. Along the axis its radius is edge sqrt(square); the *square* is 1 for all bodies except a spheroid. The
height of the centre of mass is then core C + shift S + edge sqrt(C^2 + square S^2), with C and S the cosine and sine
of the tilt (the support function of the meridian).
"""

import math
from typing import Any, NamedTuple

#: Numbers of the bodies, in the order of `NAMES`.
NAMES = ("torus", "rounded", "rim", "arc", "ball", "spheroid")
TORUS, ROUNDED, RIM, ARC, BALL, SPHEROID = range(len(NAMES))

#: Bodies from this number on can roll through their poles, where the axis is vertical; the others lie flat there.
FIRST_WITH_POLES = BALL


class Arc(NamedTuple):
    """The meridian of a body: see the module docstring."""

    core: Any
    shift: Any
    edge: Any
    square: Any


class Body(NamedTuple):
    """The constants of a body: its `Arc`, its axial and transverse moment over m R^2, and the ratio of the two."""

    core: Any
    shift: Any
    edge: Any
    square: Any
    axial: Any
    transverse: Any
    ratio: Any


def thin_disk(alpha):
    """Return the `Body` of a thin disk whose axial moment is alpha m R^2."""
    return Body(1.0, 0.0, 0.0, 1.0, alpha, 0.5 * alpha, 2.0)


def arc_of(body, tube, thickness, fillet, offset, flattening):
    """Return the `Arc` of a body, from lengths over the outer radius; lengths that it does not have are not read.

    Plain Python, which kernels compile.
    """
    if body == TORUS:
        return Arc(1.0 - tube, 0.0, tube, 1.0)
    if body == ROUNDED:
        return Arc(1.0 - 0.5 * thickness, 0.0, 0.5 * thickness, 1.0)
    if body == RIM:
        return Arc(1.0 - fillet, 0.5 * thickness - fillet, fillet, 1.0)
    if body == ARC:
        return Arc(1.0 - fillet, offset, fillet, 1.0)
    if body == BALL:
        return Arc(0.0, offset, 1.0, 1.0)
    return Arc(0.0, offset, 1.0, (1.0 - flattening) * (1.0 - flattening))


def torus_moments(tube, hollow):
    """Return axial and transverse moment of a torus over m R^2.

    Parameters
    ----------
    tube : float or array
        Radius of the tube over the outer radius.
    hollow : bool
        Whether all mass is in the surface of the tube.
    """
    share, core = (2.0 if hollow else 1.0) * tube * tube, 1.0 - tube
    return core * core + 0.75 * share, 0.5 * core * core + 0.625 * share


def solid_moments(thickness, fillet):
    """Return axial and transverse moment of a solid cylinder of radius 1 whose edges are quarter circles.

    Parameters
    ----------
    thickness, fillet : float or array
        Length of the cylinder and radius of its edges, over its radius; fillet at most half the thickness.

    Notes
    -----
    Integrals of r^2, r^4 and z^2 r^2 along the axis, with r = 1 over the straight part, 2 (thickness/2 - fillet) long,
    and r = 1 - fillet + sqrt(fillet^2 - u^2) at the distance u from its ends.
    """
    half, c, f = 0.5 * thickness - fillet, 1.0 - fillet, fillet
    squares = c**2 * f + 0.5 * math.pi * c * f**2 + 2.0 / 3.0 * f**3
    fourths = (
        c**4 * f + math.pi * c**3 * f**2 + 4.0 * c**2 * f**3 + 0.75 * math.pi * c * f**4 + 8.0 / 15.0 * f**5
    )
    first = 0.5 * c**2 * f**2 + 2.0 / 3.0 * c * f**3 + 0.25 * f**4
    second = c**2 * f**3 / 3.0 + 0.125 * math.pi * c * f**4 + 2.0 / 15.0 * f**5
    volume = half + squares
    axial = 0.5 * (half + fourths) / volume
    along = (half**3 / 3.0 + half**2 * squares + 2.0 * half * first + second) / volume
    return axial, 0.5 * axial + along


def spheroid_moments(flattening):
    """Return axial and transverse moment over m R^2 of a homogeneous spheroid with its centre of mass at its centre.

    Parameters
    ----------
    flattening : float or array
        1 - q, with q the radius at a pole over the radius at the equator.
    """
    return 0.4 + 0.0 * flattening, 0.2 + 0.2 * (1.0 - flattening) ** 2
