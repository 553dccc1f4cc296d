"""Steady motions of an atlas: growth rates and nutation frequencies from trajectories, beside linear theory."""

from typing import TYPE_CHECKING

import numpy as np

from kernels.disk.steady import marginal_precession_rates, stability_coefficient, steady_roll_rate
from sweep.atlas.clock import created
from sweep.atlas.dataset import spec_of
from sweep.engine import cells
from sweep.engine.blocks import Span
from sweep.engine.compiled import coefficients
from sweep.errors import RequestError
from sweep.schema import FILL, Array
from sweep.schema.steady import STEADY

if TYPE_CHECKING:
    import xarray as xr

_THEORY = ("tilt", "precession_rate", "roll_rate", "alpha", "radius", "gravity")


def with_coefficients(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return an atlas of steady motions with the variables of `schema.steady.STEADY`.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas whose spec leaves a rate to each cell (``steady``).

    Returns
    -------
    xarray.Dataset
        k of linear theory and k as measured; the growth rate where a kick grows, the nutation frequency 2 pi/period
        where the motion is bounded by both turning points; NaN where a cell has none.

    Raises
    ------
    RequestError
        If the atlas is not one of steady motions.
    """
    spec = spec_of(dataset)
    if not spec.circling:
        raise RequestError(
            "not an atlas of steady motions",
            "in an atlas of steady motions one rate is steady",
            f"precession_rate={spec.precession_rate} roll_rate={spec.roll_rate}",
            "compute one with roll_rate=steady, or with precession_rate=steady-slow or steady-fast",
        )
    given = cells.starts(spec, Span(0, spec.size))
    measured = measured_coefficients(np.stack(list(given.values()))).reshape(spec.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        theory = stability_coefficient(*(given[name] for name in _THEORY)).reshape(spec.shape)
        values = {
            "stability_coefficient": np.where(np.isfinite(theory), theory, np.nan),
            "measured_coefficient": measured,
            "growth_rate": np.where(measured < 0.0, np.sqrt(-measured), np.nan),
            "nutation_frequency": 2.0 * np.pi / dataset["nutation_period"].values,
        }
    changed = dataset.copy()
    for name, quantity in STEADY.items():
        changed[name] = (spec.axes, values[name], quantity.attributes())
        changed[name].encoding = {**dataset["peak_tilt"].encoding, "_FillValue": FILL}
    return changed.assign_attrs(history=f"{dataset.attrs['history']}\n{created()} coefficients measured")


def measured_coefficients(starts: Array) -> Array:
    """Return k [s-2] of steady motions as short trajectories show it, shape (n,).

    Parameters
    ----------
    starts : array, shape (7, n)
        Rows in the order of `schema.PARAMETERS`, in SI.
    """
    found = np.full(starts.shape[1], np.nan)
    possible = np.isfinite(starts).all(axis=0)
    some = np.empty(int(possible.sum()))
    coefficients()(np.ascontiguousarray(starts[:, possible]), some)
    found[possible] = some
    return found


def marginal_curve(
    alpha: float, radius: float, gravity: float, coefficient: float = 0.0, count: int = 4000
) -> dict[str, Array]:
    """Return the steady motions of positive tilt and precession whose k has a given value, as one curve.

    Parameters
    ----------
    alpha, radius, gravity : float
        The disk: mass distribution [1], radius [m], gravity [m/s^2].
    coefficient : float
        k [s-2]; 0 for the boundary of stability.
    count : int
        Tilts at which the curve is looked for; it bends back and is followed closely there.

    Returns
    -------
    dict of str to array
        `tilt` [rad], `precession_rate`, `roll_rate` [rad/s], from the rolling end at upright over the largest tilt to
        the spinning end, and `faster`: whether the precession is the faster of the two that the roll rate has.
    """
    # close together where the curve bends back: 17.6 deg (alpha to 0) to 19.2 deg (hoop), and a little for k > 0
    bend = np.linspace(17.0, 20.0, count)
    tilt = np.radians(np.sort(np.concatenate((np.geomspace(1e-4, 30.0, count), bend))))
    slow, fast = marginal_precession_rates(tilt, coefficient, alpha, radius, gravity)
    there = np.isfinite(slow)
    tilts = np.concatenate((tilt[there], tilt[there][::-1]))
    rates = np.concatenate((slow[there], fast[there][::-1]))
    # the product of the two precession rates of a roll rate is 2g/[(2+alpha) R cos]
    faster = rates**2 > 2.0 * gravity / ((2.0 + alpha) * radius * np.cos(tilts))
    rolls = steady_roll_rate(tilts, rates, alpha, radius, gravity)
    return {"tilt": tilts, "precession_rate": rates, "roll_rate": rolls, "faster": faster}
