"""The motion of one cell in time, for a look at it: the equations of motion as they stand, integrated by SciPy.

Nothing here comes from the kernels: that the extremes agree with the atlas says something.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sweep.schema import Array

_SAMPLES = 2000


@dataclass(frozen=True)
class Swing:
    """A motion sampled in time: time [s], tilt [rad], and the point of contact x, y [m]; arrays of shape (n,)."""

    time: Array
    tilt: Array
    x: Array
    y: Array


def swing(start: Mapping[str, float], duration: float, fall_tilt: float) -> Swing:
    """Integrate one start until `duration` [s] is over or the tilt reaches `fall_tilt` [rad].

    Parameters
    ----------
    start : mapping of str to float
        Every parameter of `schema.PARAMETERS`, in SI.
    duration, fall_tilt : float

    Notes
    -----
    DOP853 at a relative tolerance of 1e-10 (Dormand and Prince), on tilt, its rate, the precession and the roll rate,
    the heading, and the point of contact: x' = -R roll sin(heading), y' = R roll cos(heading).
    """
    from scipy.integrate import solve_ivp

    alpha, radius, gravity = start["alpha"], start["radius"], start["gravity"]

    def motion(_time: float, state: Array) -> list[float]:
        tilt, rate, precession, roll, heading = state[:5]
        sin, cos = np.sin(tilt), np.cos(tilt)
        push = 4.0 * gravity * sin + (2.0 + alpha) * radius * precession**2 * np.sin(2.0 * tilt)
        push += 4.0 * (1.0 + alpha) * radius * roll * precession * cos
        turn = 2.0 * (1.0 + alpha) * roll * sin - (2.0 + alpha) * precession * cos**2
        return [
            rate,
            push / (2.0 * (2.0 + alpha) * radius),
            -2.0 * roll * rate / cos,
            rate * turn / ((1.0 + alpha) * cos),
            precession,
            -radius * roll * np.sin(heading),
            radius * roll * np.cos(heading),
        ]

    def fall(_time: float, state: Array) -> float:
        return fall_tilt - abs(float(state[0]))

    fall.terminal = True  # type: ignore[attr-defined]
    rates = [start[name] for name in ("tilt", "tilt_rate", "precession_rate", "roll_rate")]
    found = solve_ivp(
        motion,
        (0.0, duration),
        [*rates, 0.0, 0.0, 0.0],
        method="DOP853",
        rtol=1e-10,
        atol=1e-12,
        dense_output=True,
        events=fall,
    )
    time = np.linspace(0.0, float(found.t[-1]), _SAMPLES)
    state = found.sol(time)
    return Swing(time, state[0], state[5], state[6])
