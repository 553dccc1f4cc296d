"""The cells of an atlas that can be trusted: their ending is known, or a value is known as well as requested."""

from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.dataset import require, spec_of
from sweep.engine.grid import blocks, starts_of
from sweep.errors import RequestError, shown
from sweep.model.cells import stated_error
from sweep.model.quantity import FINAL, LOST, OPEN, PROMISED, UNDISTURBED, Truths

if TYPE_CHECKING:
    import xarray as xr

#: Roles of the endings of motions that were followed to their end, or to the end of the time.
_KNOWN = (FINAL, LOST, OPEN, UNDISTURBED)


def trusted_cells(atlas: "xr.Dataset", variable: str | None, within: float | None) -> Truths:
    """Return which cells are known; see `sweep.accessor.Eulerdisk.trusted`.

    Parameters
    ----------
    atlas : xarray.Dataset
        A whole atlas.
    variable : str, optional
    within : float, optional

    Returns
    -------
    array of bool, of the shape of the grid

    Raises
    ------
    RequestError
        If only one of `variable` and `within` is given, or the cells state no error of the variable.
    """
    spec = spec_of(atlas)
    if variable is None and within is None:
        codes = spec.model.endings.codes(*_KNOWN)
        return np.isin(atlas["ending"].values, codes)
    quantities = spec.model.cell_variables(spec)
    numbers = [name for name, row in quantities.items() if row.flags is None and row.dtype.startswith("f")]
    if variable not in numbers or within is None or not within >= 0.0:
        raise RequestError(
            "A trusted value needs the name of a variable and its largest allowed error, 0 or more, in its unit; got "
            f"variable={shown(variable)} within={shown(within)}.",
            hint=f'Write trusted("{variable if variable in numbers else numbers[0]}", within=1e-6), for instance; the '
            f"variables are {', '.join(numbers)}.",
            where="trusted",
        )
    model = spec.model
    stated = quantities[variable].tolerance.stated
    needed = dict.fromkeys((variable, *model.extremes, *((model.error_name,) if model.extremes else ())))
    needed |= dict.fromkeys([stated] if stated in quantities else [])
    require(atlas, needed)
    columns = {name: atlas[name].values.reshape(-1) for name in needed}
    found = np.empty(spec.size, bool)
    for span in blocks(spec.size):
        part = {name: values[span.start : span.stop] for name, values in columns.items()}
        of_extremes = PROMISED * np.nan_to_num(model.error(part), nan=np.inf) if model.extremes else 0.0
        error = stated_error(quantities[variable], spec, starts_of(spec, span), part, of_extremes)
        found[span.start : span.stop] = np.isfinite(part[variable]) & (error <= within)
    return found.reshape(spec.shape)
