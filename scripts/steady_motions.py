"""Growth rates and nutation frequencies of steady motions, measured from trajectories and by linear theory."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from kernels.disk.steady import marginal_precession_rates, stability_coefficient, steady_roll_rate
from sweep.atlas.cf_metadata import created
from sweep.atlas.dataset import spec_of
from sweep.engine.grid import whole
from sweep.errors import RequestError
from sweep.model.disk.initial_conditions import circling
from sweep.model.kernel import Kernel
from sweep.model.quantity import FILL, Array, Quantity, Tolerance, table

if TYPE_CHECKING:
    import xarray as xr

_RATE = Tolerance(1e-6, 1e-6, "measured over a short time, accurate to the square of the kick")

# fmt: off
STEADY: Mapping[str, Quantity] = table(
    Quantity("stability_coefficient", "k", "s-2", "coefficient of small oscillations about the steady motion",
             _RATE, "from linear theory, without integration: the motion is stable where it is positive"),
    Quantity("measured_coefficient", "k", "s-2", "coefficient of small oscillations, measured from trajectories",
             _RATE, "from a short trajectory kicked up and down, without theory of the coefficient"),
    Quantity("growth_rate", r"\sqrt{-k}", "s-1", "rate at which a kick to the steady motion grows", _RATE,
             "root of minus measured_coefficient; missing where a kick does not grow"),
    Quantity("nutation_frequency", r"\sqrt{k}", "rad s-1", "angular frequency of nutation", _RATE,
             "2 pi over nutation_period; missing where the cell has no period"),
)
# fmt: on

_COEFFICIENTS = Kernel("kernels.disk.growth_rates", "coefficients", seconds=1.0)

_THEORY = ("tilt", "precession_rate", "roll_rate", "alpha", "radius", "gravity")


def with_coefficients(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return an atlas of steady motions with the variables of `STEADY`.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas whose spec lets each cell compute a rate (``steady``).

    Returns
    -------
    xarray.Dataset
        Adds k of linear theory and the measured k; the growth rate where a kick grows; the nutation frequency 2
        pi/period where the motion is bounded by two turning points. NaN where a cell has no such value.

    Raises
    ------
    RequestError
        If the atlas does not consist of steady motions.
    """
    spec = spec_of(dataset)
    if not circling(spec):
        raise RequestError(
            "This is not an atlas of steady motions, which needs a steady rate; got "
            f"precession_rate={spec.precession_rate} roll_rate={spec.roll_rate}.",
            hint="Compute one with roll_rate=steady, or with precession_rate=steady-slow or steady-fast.",
        )
    given = whole(spec)
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
    """Return k [s-2] of steady motions, measured from short trajectories, shape (n,).

    Parameters
    ----------
    starts : array, shape (7, n)
        Rows in the order of the parameters, in SI.
    """
    found = np.full(starts.shape[1], np.nan)
    possible = np.isfinite(starts).all(axis=0)
    some = np.empty(int(possible.sum()))
    _COEFFICIENTS.load()(np.ascontiguousarray(starts[:, possible]), some)
    found[possible] = some
    return found


def marginal_curve(alpha: float, radius: float, gravity: float, coefficient: float = 0.0) -> dict[str, Array]:
    """Return the steady motions of positive tilt and precession whose k has a given value, as one curve.

    Parameters
    ----------
    alpha, radius, gravity : float
        The disk: mass distribution [1], radius [m], gravity [m/s^2].
    coefficient : float
        k [s-2]; 0 for the boundary of stability.

    Returns
    -------
    dict of str to array
        `tilt` [rad], `precession_rate`, `roll_rate` [rad/s], from the rolling end at upright over the largest tilt to
        the spinning end, and `faster`: whether the precession rate is the faster of the two that belong to the roll
        rate.
    """
    # dense where the curve bends back: 17.6 deg (alpha to 0) to 19.2 deg (hoop), and slightly more for k > 0
    bend = np.linspace(17.0, 20.0, 4000)
    tilt = np.radians(np.sort(np.concatenate((np.geomspace(1e-4, 30.0, 4000), bend))))
    slow, fast = marginal_precession_rates(tilt, coefficient, alpha, radius, gravity)
    there = np.isfinite(slow)
    tilts = np.concatenate((tilt[there], tilt[there][::-1]))
    rates = np.concatenate((slow[there], fast[there][::-1]))
    # the product of the two precession rates of a roll rate is 2g/[(2+alpha) R cos]
    faster = rates**2 > 2.0 * gravity / ((2.0 + alpha) * radius * np.cos(tilts))
    rolls = steady_roll_rate(tilts, rates, alpha, radius, gravity)
    return {"tilt": tilts, "precession_rate": rates, "roll_rate": rolls, "faster": faster}
