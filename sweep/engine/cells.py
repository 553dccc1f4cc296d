"""The starts of a grid's cells, as arrays."""

from collections.abc import Mapping

import numpy as np

from kernels.disk.steady import steady_precession_rates, steady_roll_rate
from sweep.engine.blocks import Span
from sweep.request.axes import Range, Values
from sweep.request.criterion import perturbation_scale
from sweep.request.spec import SweepSpec
from sweep.schema import PARAMETERS, STEADY_PRECESSION, Array


def starts(spec: SweepSpec, span: Span) -> dict[str, Array]:
    """Return the parameters of the cells of a span.

    Parameters
    ----------
    spec : SweepSpec
    span : Span
        Cells in C order.

    Returns
    -------
    dict of str to float64 array, shape (len(span),)
        Every parameter of `schema.PARAMETERS`, in SI. A steady roll rate that does not exist is not finite.
    """
    cells = np.arange(span.start, span.stop)
    places = dict(zip(spec.axes, np.unravel_index(cells, spec.shape), strict=True)) if spec.axes else {}
    values: dict[str, Array] = {}
    for name in PARAMETERS:
        given = getattr(spec, name)
        if isinstance(given, Range | Values):
            values[name] = given.array()[places[name]]
        elif not isinstance(given, str):
            values[name] = np.full(len(span), given)
    return complete(spec, values)


def complete(spec: SweepSpec, values: dict[str, Array]) -> dict[str, Array]:
    """Return starts with the rate that the spec leaves to the cell, in the order of `schema.PARAMETERS`.

    Parameters
    ----------
    spec : SweepSpec
    values : dict of str to array, shape (n,)
        Every parameter but `spec.computed_rate`, in SI; a value that it has for that one is not looked at.

    Returns
    -------
    dict of str to float64 array, shape (n,)
    """
    disk = [values[name] for name in ("alpha", "radius", "gravity")]
    with np.errstate(divide="ignore", invalid="ignore"):
        if spec.computed_rate == "roll_rate":
            rolling = steady_roll_rate(values["tilt"], values["precession_rate"], *disk)
            values = values | {"roll_rate": rolling}
        elif spec.computed_rate == "precession_rate":
            both = steady_precession_rates(values["tilt"], values["roll_rate"], *disk)
            values = values | {"precession_rate": both[STEADY_PRECESSION.index(str(spec.precession_rate))]}
    return {name: values[name] for name in PARAMETERS}


def steady_tilt(spec: SweepSpec, cells: Mapping[str, Array]) -> Array:
    """Return the tilt [rad] of the motion that each cell disturbs: its own tilt if circling, else upright."""
    return cells["tilt"] if spec.circling else np.zeros_like(cells["tilt"])


def scale(spec: SweepSpec, cells: Mapping[str, Array]) -> Array:
    """Return the scale [rad] of the perturbation in each cell."""
    return perturbation_scale(
        cells["tilt"],
        cells["tilt_rate"],
        steady_tilt(spec, cells),
        cells["alpha"],
        cells["radius"],
        cells["gravity"],
    )
