"""One motion by SciPy's DOP853, from the textbook equations: the independent method that RK4 is compared with."""

import math
from collections.abc import Sequence
from typing import NoReturn

import numpy as np

from sweep.errors import RequestError
from sweep.model.quantity import Array

#: Relative and absolute error per step that DOP853 is asked for.
_RELATIVE, _ABSOLUTE = 1e-12, 1e-15


def integrate(start: Array, fall_tilt: float, times: Array) -> tuple[Array, float | None]:
    """Integrate one start and sample it.

    Parameters
    ----------
    start : float64 array, shape (7,)
        Tilt [rad], tilt rate, precession rate, roll rate [rad/s], alpha, radius [m], gravity [m/s2].
    fall_tilt : float
        Tilt [rad] at which the disk has fallen.
    times : float64 array, shape (n,)
        Increasing, from 0 [s].

    Returns
    -------
    (samples, fall_time)
        Samples, shape (9, m), rows as in `kernels.disk.arrays.SAMPLES`; m < n + 1 and the last is at `fall_time` [s]
        if the disk fell, else m = n and `fall_time` is None.

    Raises
    ------
    RequestError
        If the rates leave the range of floats, or SciPy gives up.

    Notes
    -----
    Shares nothing with the kernels: tilt and rates with their sines and cosines, the heading, the roll angle, the
    contact point and the gain of vertical momentum, all integrated together.
    """
    from scipy.integrate import solve_ivp

    alpha, radius, gravity = start[4:]

    def slope(_: float, y: Array) -> list[float]:
        return _slope(y, alpha, radius, gravity)

    def fall(_: float, y: Array) -> float:
        return abs(float(y[0])) - fall_tilt

    fall.terminal = True  # type: ignore[attr-defined]  # read by solve_ivp
    first = np.concatenate([start[:4], np.zeros(5)])
    try:
        with np.errstate(over="raise", invalid="raise"):
            run = solve_ivp(
                slope,
                (0.0, times[-1]),
                first,
                method="DOP853",
                t_eval=times,
                events=fall,
                rtol=_RELATIVE,
                atol=_ABSOLUTE,
            )
    except ArithmeticError as problem:
        _give_up(f"{problem}")
    if run.status < 0:
        _give_up(str(run.message))
    if not run.t_events[0].size:
        return run.y, None
    time, state = float(run.t_events[0][0]), run.y_events[0][0]
    before = run.y[:, run.t < time]
    return np.column_stack([before, state]), time


def _give_up(words: str) -> NoReturn:
    raise RequestError(
        f"DOP853 could not resolve this motion: {words}.",
        hint="Give a shorter duration, slower rates, or a smaller fall_tilt; or method=rk4.",
    )


def _slope(y: Sequence[float] | Array, alpha: float, radius: float, gravity: float) -> list[float]:
    tilt, tilting, turning, rolling, heading = (float(each) for each in y[:5])
    sin, cos = math.sin(tilt), math.cos(tilt)
    push = 2.0 * gravity * sin + 2.0 * (1.0 + alpha) * radius * rolling * turning * cos
    push += (2.0 + alpha) * radius * turning**2 * sin * cos
    spin_up = tilting * (2.0 * (1.0 + alpha) * rolling * sin - (2.0 + alpha) * turning * cos**2)
    return [
        tilting,
        push / ((2.0 + alpha) * radius),
        -2.0 * rolling * tilting / cos,
        spin_up / ((1.0 + alpha) * cos),
        turning,
        rolling,
        -radius * rolling * math.sin(heading),
        radius * rolling * math.cos(heading),
        radius**2 * rolling * tilting * cos,
    ]
