"""Energy and motion of bodies with losses, independent of the kernels, for the audit of an atlas.

The equations for DOP853 have only the laws in common with the kernels. They use tilt and rates with sines and cosines,
torques about the contact point, and signs of dry friction that are evaluated at every step.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from sweep.model.bodies.shape import body_of, with_body
from sweep.model.description import Request, Starts
from sweep.model.lossy_disk.audit import Mechanics
from sweep.model.lossy_disk.sample import followed
from sweep.model.lossy_disk.tables import BILDSTEN, MOFFATT
from sweep.model.quantity import Array


def _height(spec: Request, starts: Starts, tilt: Array) -> Array:
    """Return the height of the centre of mass over R at the tilts of bodies, shape (n,)."""
    body = body_of(spec, with_body(spec, starts))
    return np.asarray(body.core * np.cos(tilt) + body.shift * np.sin(tilt) + body.edge)


def _energy(spec: Request, starts: Starts) -> Array:
    """Return the energy over m g R of starts, shape (n,)."""
    body = body_of(spec, with_body(spec, starts))
    unit, tilt = np.sqrt(starts["radius"] / starts["gravity"]), starts["tilt"]
    w, turn = starts["tilt_rate"] * unit, starts["precession_rate"] * unit
    s, o = starts["roll_rate"] * unit + turn * np.sin(tilt), turn * np.cos(tilt)
    a, b = body.core + body.edge * np.cos(tilt), -body.shift - body.edge * np.sin(tilt)
    turning = (body.transverse + a**2 + b**2) * w**2 + body.transverse * o**2 + body.axial * s**2
    return np.asarray(0.5 * (turning + (a * s + b * o) ** 2) + _height(spec, starts, tilt))


def _smooth_motion(spec: Request, start: Mapping[str, float]) -> dict[str, float]:
    """Return the measures of a motion that ends flat or after the duration; see `sweep.model.lossy_disk.sample`."""
    return followed(spec, start, _equations(spec, start))


def _equations(spec: Request, start: Mapping[str, float]) -> Callable[[float, Any], list[float]]:
    """Return the right-hand side for (tilt, w, o, s, loss of each law, heading, path), all scaled.

    Notes
    -----
    F is the force along the track that rolling needs without losses. The torques M about the contact point are along
    the tilt axis, the diameter through the contact, and the axis of the body:
    B w' = l (1 + r w^2) + o [I s - A T o + (a - b T)(a s + b o)] + M_t,
    o' = w (T o - I s/A) - b F/A + [(I + a^2) M_d - a b M_n]/D, s' = -a F/I + [(A + b^2) M_n - a b M_d]/D.
    """
    given = {name: np.array([value]) for name, value in start.items()}
    core, shift, edge, _, axial, transverse, ratio = (
        float(np.ravel(values)[0]) for values in body_of(spec, given)
    )
    radius, mass, unit = start["radius"], start["mass"], math.sqrt(start["radius"] / start["gravity"])
    rolling, pivoting, contour = (
        start[name] / radius for name in ("rolling_friction", "pivoting_friction", "contour_friction")
    )
    damping = start["contour_damping"] * unit / (mass * radius**2)
    film, layer = 0.0, 0.0
    if spec.air_law == MOFFATT:
        film = 0.25 * math.pi * start["air_viscosity"] * radius * unit / mass * core**3
    if spec.air_law == BILDSTEN:
        layer = (
            math.sqrt(0.5 * start["air_viscosity"] * start["air_density"] * unit) * radius**2 / mass * core**4
        )

    def right(_: float, y: Any) -> list[float]:
        tilt, w, o, s = (float(value) for value in y[:4])
        sin, cos = math.sin(tilt), math.cos(tilt)
        tan, a, b = sin / cos, core + edge * cos, -shift - edge * sin
        lever, height = a * sin + b * cos, a * cos - b * sin
        tilting, determinant = transverse + a * a + b * b, axial * (transverse + b * b) + transverse * a * a
        run, turning = s - o * tan, o * cos + s * sin
        across = cos * run
        horizontal = math.hypot(w, across) or 1.0
        gyroscopic = axial * s - transverse * tan * o + (a - b * tan) * (a * s + b * o)
        pull = (lever * (1.0 + edge * w * w) + o * gyroscopic) / tilting
        # the normal force depends on the tilt acceleration, and that, through rolling friction, on the normal force
        share = rolling * w / (horizontal * tilting)
        normal = (1.0 + (edge - height) * w * w - lever * pull) / (1.0 - lever * share)
        drag = (film / cos + layer * math.sqrt(abs(run))) * run
        rub = contour * a * normal
        q = -rub * math.copysign(1.0, run) - damping * a * a * run - drag
        h = -rolling * normal * across / horizontal
        v = -pivoting * normal * math.copysign(1.0, turning)
        about, spun = -q * tan - h * sin + v * cos, q + h * cos + v * sin
        along = axial * transverse * w / determinant * (core * o - (edge * sin + ratio * b) * s)
        more_o = ((axial + a * a) * about - a * b * spun) / determinant
        more_s = ((transverse + b * b) * spun - a * b * about) / determinant
        return [
            w,
            pull - share * normal,
            w * (tan * o - ratio * s) - b / transverse * along + more_o,
            -a / axial * along + more_s,
            rolling * normal * horizontal,
            pivoting * normal * abs(turning),
            rub * abs(run),
            damping * (a * run) ** 2,
            drag * run,
            o / cos,
            a * abs(run),
        ]

    return right


#: Functions of bodies for `sweep.model.lossy_disk.audit`.
MECHANICS = Mechanics(_energy, _height, _smooth_motion)
