"""What a map of regimes shows: how many wells the potential of each start has, and whether it crosses upright.

All of it from the exact reduction: of an atlas only its starts are looked at.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sweep.atlas.curves import without_curves
from sweep.atlas.folds import fold_rates
from sweep.engine import cells
from sweep.engine.blocks import Span
from sweep.engine.runner import exact_measures, use_threads
from sweep.errors import RequestError
from sweep.figures.panels import Panel, drawn_spec, fixed_parameters, panel
from sweep.request.axes import Values
from sweep.request.spec import SweepSpec
from sweep.schema import VARIABLES, Array, Truths

if TYPE_CHECKING:
    import xarray as xr

#: Name of each regime: of one well and of two, on one side of upright and across it.
NAMES = ("one well\none side", "one well\ncrosses", "two wells\none side", "two wells\ncrosses")

_CODES = {name: code for code, name in (VARIABLES["ending"].flags or {}).items()}

#: Points on a curve of theory.
_FINE = 400


@dataclass(frozen=True)
class Regimes:
    """All that is drawn of one atlas; arrays of the shape (rows of y, columns of x).

    `regime` is an index of `NAMES`, -1 where the disk falls or the reduction says nothing (`fell`, `unknown`);
    `lost` names the endings of the latter. `separatrix` is the saddle of the potential minus the energy, NaN where
    there is no saddle. `folds` are curves in the units of the scales.
    """

    panel: Panel
    caption: str
    regime: npt.NDArray[np.int8]
    fell: Truths
    unknown: Truths
    lost: str
    separatrix: Array
    folds: tuple[tuple[Array, Array], ...]

    def regions(self) -> list[tuple[str, Truths]]:
        """Return the name and the cells of each regime, and of the falls."""
        named = [(name, self.regime == code) for code, name in enumerate(NAMES)]
        return [*named, ("falls", self.fell)]


def regimes(dataset: "xr.Dataset") -> Regimes:
    """Return the regimes of the starts of an atlas.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas of two axes, or a selection from one.

    Returns
    -------
    Regimes

    Raises
    ------
    RequestError
        If the atlas has not two axes.
    """
    dataset = without_curves(dataset).squeeze()
    drawn = panel(dataset)
    if drawn.y is None:
        raise RequestError(
            "one axis is no map", "a map of regimes has two axes", drawn.x.quantity.name, "give another axis"
        )
    spec = drawn_spec(dataset)
    spec = spec.replace(**{name: Values(tuple(dataset[name].values.tolist())) for name in spec.axes})
    use_threads(None)
    exact = exact_measures(spec, cells.starts(spec, Span(0, spec.size)))

    def grid(values: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
        shaped = values.reshape(spec.shape)
        return shaped if drawn.y and spec.axes[0] == drawn.y.quantity.name else shaped.T

    across = (exact["tilt_min"] < 0.0) & (exact["tilt_max"] > 0.0)
    known = np.isin(exact["ending"], (_CODES["bounded"], _CODES["steady"]))
    fell = exact["ending"] == _CODES["fell"]
    regime = np.where(known, 2 * (exact["wells"] - 1) + across, -1).astype(np.int8)
    return Regimes(
        panel=drawn,
        caption=f"{fixed_parameters(spec)}\none side of upright, or crosses it",
        regime=np.asarray(grid(regime), np.int8),
        fell=np.asarray(grid(fell), np.bool_),
        unknown=np.asarray(grid(~known & ~fell), np.bool_),
        lost=", ".join(name for name in ("unresolved", "invalid") if (exact["ending"] == _CODES[name]).any()),
        separatrix=np.asarray(grid(exact["separatrix"]), np.float64),
        folds=tuple(_folds(spec, drawn)),
    )


def _folds(spec: SweepSpec, drawn: Panel) -> list[tuple[Array, Array]]:
    """Return the curve of folds, where the axes are the tilt and the only rate that is not zero."""
    assert drawn.y is not None
    axis, tilts = drawn.y.quantity.name, spec.tilt
    still = {"roll_rate": "precession_rate", "precession_rate": "roll_rate"}.get(axis)
    if not isinstance(tilts, Values) or still is None or getattr(spec, still) != 0.0:
        return []
    alpha, radius, gravity = spec.alpha, spec.radius, spec.gravity
    if not (isinstance(alpha, float) and isinstance(radius, float) and isinstance(gravity, float)):
        return []
    first, last = tilts.values[0], tilts.values[-1]
    tilt = np.geomspace(first, last, _FINE) if drawn.x.log else np.linspace(first, last, _FINE)
    rate = fold_rates(tilt, axis, alpha) * np.sqrt(gravity / radius)
    shown = drawn.x.shown(tilt)
    if drawn.y.squared:
        return [(shown, drawn.y.shown(rate))]
    return [(shown, drawn.y.shown(sign * rate)) for sign in (1.0, -1.0)]
