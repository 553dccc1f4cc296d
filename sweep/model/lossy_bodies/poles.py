"""The motion of a ball or a spheroid with losses by other means than the kernel: for the audit of an atlas.

The kernel follows axis and angular velocity in space. What DOP853 integrates here are the sine u of the tilt, its rate
y = C w, x = C o, the spin s, and the energy, which the losses take: regular at a pole, where the energy says what the
square w^2 + o^2 is (`kernels.bodies.poles.equations`).
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from kernels.bodies.shapes import Body
from sweep.model.bodies.shape import body_of
from sweep.model.description import Request
from sweep.model.lossy_disk.sample import MEASURES, solution
from sweep.model.quantity import Array

#: Square of the cosine of the tilt below which the energy says more of it than the sine does, and below which the
#: heading turns too fast to be compared.
_BESIDE_POLE, _TOO_NEAR = 1e-3, 1e-6

#: Square of a rate that divides, at least.
_LEAST = 1e-300


def smooth_motion(spec: Request, start: Mapping[str, float], energy: float) -> dict[str, float]:
    """Return `sweep.model.lossy_disk.sample.MEASURES` of a motion that goes on until the duration is over.

    Parameters
    ----------
    spec : Request
    start : mapping of str to float
        Every parameter [SI].
    energy : float
        Of the start, over m g R.
    """
    given = {name: np.array([value]) for name, value in start.items()}
    body = Body(*(float(np.ravel(each)[0]) for each in body_of(spec, given)))
    unit, tilt = math.sqrt(start["radius"] / start["gravity"]), start["tilt"]
    rates = (start[name] * unit for name in ("tilt_rate", "precession_rate", "roll_rate"))
    (w, turn, roll), sin, cos = rates, math.sin(tilt), math.cos(tilt)
    first = [sin, cos * w, cos * cos * turn, roll + turn * sin, energy]

    def turning(_: float, state: Any) -> float:
        return float(state[1])

    found = solution(_equations(body, start, unit), [*first, *[0.0] * 7], spec.duration / unit, [turning])
    states = np.concatenate([found.y.T[[0, -1]], *(each for each in found.y_events if len(each))])
    tilts = np.array([_tilt(state, body) for state in states])
    *sums, path = found.y[5:, -1]
    if 1.0 - np.abs(states[:, 0]).max() < _TOO_NEAR:
        sums[-1] = math.nan
    values = (unit * found.t[-1], tilts.min(), tilts.max(), *sums, start["radius"] * path)
    return dict(zip(MEASURES, values, strict=True))


def _square(state: Array, body: Body) -> float:
    """Return w^2 + o^2 of a state (u, y, x, s, energy, ...)."""
    u, _, x, s, energy = (float(each) for each in state[:5])
    normal = 1.0 / math.sqrt(1.0 - (1.0 - body.square) * u * u)
    b, height = -body.square * normal * u - body.shift, 1.0 / normal + body.shift * u
    a_square = normal * normal * (1.0 - u * u)
    whole = 2.0 * (energy - height) - (body.axial + a_square + b * b) * s * s
    return float((whole + (b * s - normal * x) ** 2) / (body.transverse + a_square + b * b))


def _tilt(state: Array, body: Body) -> float:
    u, y, x = (float(each) for each in state[:3])
    square, turning = (1.0 - u) * (1.0 + u), _square(state, body)
    if square < _BESIDE_POLE and turning > 0.0:
        square = (x * x + y * y) / turning
    return math.atan2(u, math.sqrt(max(square, 0.0)))


def _equations(body: Body, start: Mapping[str, float], unit: float) -> Callable[[float, Any], list[float]]:
    """Return the right-hand side for (u, y, x, s, energy, loss of each law, heading, path), all scaled.

    Notes
    -----
    Torques M_1 across the track, M_2 along it and M_3 about the vertical change y by C M_2/B, s by
    [(A + b^2) M_n - a b M_d]/D and o by [(I + a^2) M_d - a b M_n]/D, with M_n = S M_3 - C M_1, M_d = S M_1 + C M_3.
    With C M_1 and C M_2 all is regular, as C f = g/C with g = C^2 s - u x. The height h of the centre of mass is a
    function of u, so that the normal force is 1 + h_u y' + h_uu y^2.
    """
    radius, e, rest = start["radius"], body.shift, 1.0 - body.square
    rolling, pivoting, contour = (
        start[name] / radius for name in ("rolling_friction", "pivoting_friction", "contour_friction")
    )
    damping = start["contour_damping"] * unit / (start["mass"] * radius**2)
    A, I = body.transverse, body.axial  # noqa: N806, E741

    def right(_: float, state: Any) -> list[float]:
        u, y, x, s = (float(each) for each in state[:4])
        n = 1.0 / math.sqrt(1.0 - rest * u * u)
        b, lever, r, height = -body.square * n * u - e, rest * n * u - e, body.square * n**3, 1.0 / n + e * u
        square, turning = 1.0 - u * u, _square(state, body)
        B, D = A + n * n * square + b * b, I * (A + b * b) + A * n * n * square  # noqa: N806
        v, g = x + s * u, square * s - u * x
        size = math.sqrt(max(turning + s * s - v * v, _LEAST))
        way = math.sqrt(max(n * n * size * size + (r * r - n * n) / square * y * y, _LEAST))
        pull = lever * (square + r * y * y) + x * s * (I + height * n) + n * b * x * x
        pull -= u * (n * n * y * y + (A + b * b) * turning)
        free = (pull - damping * r * r * y) / B
        slowed = -(rolling / size + contour * r * r / way) * y / B
        normal = (1.0 - lever * free - rest * n**3 * y * y) / (1.0 + lever * slowed)
        across = (normal * (rolling / size + contour * n * n / way) + damping * n * n) * g
        about = -pivoting * normal * math.copysign(1.0, v)
        axial, along = u * about - across, u * across + square * about
        twist = y * ((n - r) * x - (r * u + body.ratio * b) * s) / D
        return [
            y,
            free + slowed * normal,
            -body.ratio * y * s - I * b * twist + ((I + n * n * square) * along - n * b * square * axial) / D,
            -A * n * twist + ((A + b * b) * axial - n * b * along) / D,
            -normal * (rolling * size + contour * way + pivoting * abs(v)) - damping * way * way,
            rolling * normal * size,
            pivoting * normal * abs(v),
            contour * normal * way,
            damping * way * way,
            0.0,
            x / square,
            way,
        ]

    return right
