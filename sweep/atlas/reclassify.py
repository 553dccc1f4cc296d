"""Another criterion or a finer boundary on a finished atlas: measures are stored, verdicts follow from them."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, NoReturn

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import Seen, unseen
from sweep.atlas.cf_metadata import ascii_text, cell_declarations, created, spec_attributes
from sweep.atlas.completion import without_boundary
from sweep.atlas.dataset import edge_variables, require, spec_of
from sweep.atlas.selection import as_atlas, require_atlas
from sweep.engine.compute import reach_and_scale
from sweep.engine.grid import blocks, starts_of
from sweep.errors import RequestError, printable, shown
from sweep.model.quantity import Truths
from sweep.progress.display import following
from sweep.progress.timetable import SEARCHING, Progress, Stage, Timetable
from sweep.request.criterion import Criterion
from sweep.request.spec import SweepSpec
from sweep.request.words import GRID, REFINED, REFINED_WIDTH

if TYPE_CHECKING:
    import xarray as xr

#: In how many parts the search for a boundary is counted.
_PARTS: Final = 1000


def reclassify(
    dataset: "xr.Dataset", criterion: Criterion | str | Callable[["xr.Dataset"], Any]
) -> "xr.Dataset":
    """Return an atlas with the verdicts and boundaries that another criterion gives.

    No cell of the grid is integrated again; for a refined boundary the places between cells are.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, as `sweep.run` or `sweep.open_atlas` returns it, or a selection from one.
    criterion : Criterion, str or callable
        For example ``departure:2deg``, ``amplification:10`` or ``peak_tilt > 10deg or fall_time < 2s``. A function is
        called with the atlas, and returns which cells are unstable: an xarray.DataArray over the axes of the atlas, or
        an array of its shape, of bool. What it returns counts as an expression does: a cell that could not be resolved
        is undecided, and where it is false a cell is stable if its ending is final.

    Returns
    -------
    xarray.Dataset
        The same measures, except for those that follow from the criterion, which the atlas then
        lacks; `stability`, the boundaries and the attributes that name the criterion are new. By a function
        the boundary is that of the grid, and the atlas cannot be saved: no file can state it.

    Raises
    ------
    RequestError
        If the dataset is no atlas; if the criterion is none, or judges by variables that the atlas does not have; if a
        function returns something else than one bool for each cell.
    """
    require_atlas(dataset)
    atlas = as_atlas(dataset)
    spec = spec_of(atlas)
    if isinstance(criterion, Criterion | str) or not callable(criterion):
        new = spec.replace(criterion=criterion)
        return _with_verdicts(atlas, new, _judged(atlas, new), f"reclassified with {criterion}")
    name = shown(printable(ascii_text(str(getattr(criterion, "__qualname__", type(criterion).__qualname__)))))
    # between its cells the function gives no verdict
    new = spec.replace(criterion=Criterion("function", name), boundary=GRID)
    truths = _truths(criterion(atlas), atlas["ending"])
    verdicts = new.criterion.outcome(spec.model.endings, atlas["ending"].values, truths)
    return _with_verdicts(atlas, new, verdicts, f"reclassified in memory with the {new.criterion}")


def refine(dataset: "xr.Dataset", width: float = REFINED_WIDTH, *, progress: Progress = None) -> "xr.Dataset":
    """Return an atlas whose boundary is bisected, row by row and as curves.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, as `sweep.run` or `sweep.open_atlas` returns it.
    width : float
        Width of the brackets in the SI unit of each axis.
    progress : bool or callable, optional
        As in `sweep.run`.

    Returns
    -------
    xarray.Dataset
        The same cells; the boundary and the attributes that describe it are new.

    Raises
    ------
    RequestError
        If the dataset is no atlas, the width is not above 0, `progress` is something else, or the criterion is a
        function.
    """
    require_atlas(dataset)
    atlas = as_atlas(dataset)
    spec = spec_of(atlas).replace(boundary=f"{REFINED}:{width!r}")
    spec.criterion.check_new_cells()
    with following(progress) as show:
        timetable = Timetable([Stage(SEARCHING, _PARTS)], show, things="parts")
        timetable.begin(SEARCHING)

        def searched(share: float) -> None:
            timetable.report(int(share * _PARTS))

        return _with_verdicts(atlas, spec, _judged(atlas, spec), f"boundary refined to {width!r}", searched)


def _judged(dataset: "xr.Dataset", spec: SweepSpec) -> npt.NDArray[np.int8]:
    """Return the verdicts of the criterion of a spec, of the shape of the grid."""
    needed = spec.criterion.reads(spec.model)
    require(dataset, needed)
    measured = {name: dataset[name].values.reshape(-1) for name in needed}
    found = np.empty(spec.size, np.int8)
    for span in blocks(spec.size):
        starts = starts_of(spec, span)
        part = {name: values[span.start : span.stop] for name, values in measured.items()}
        reach = reach_and_scale(spec, starts, part)
        found[span.start : span.stop] = spec.criterion.decide(spec, starts, part, *reach)
    return found.reshape(spec.shape)


def _truths(given: Any, ending: "xr.DataArray") -> Truths:
    """Return what a function has returned as an array over the grid, or refuse it."""
    import xarray as xr

    if isinstance(given, xr.DataArray) and set(given.dims) == set(ending.dims):
        given = given.transpose(*ending.dims)
        labels = [name for name in ending.dims if name in given.coords]
        if any(not np.array_equal(given[name].values, ending[name].values) for name in labels):
            _refuse("values of other cells: its coordinates differ", ending)
        given = given.values
    elif isinstance(given, xr.DataArray):
        _refuse(f"a DataArray over {', '.join(map(str, given.dims)) or 'no axis'}", ending)
    if not isinstance(given, np.ndarray | np.bool_ | bool):
        _refuse(f"a {type(given).__name__}", ending)
    truths = np.asarray(given)
    if truths.dtype != np.bool_ or truths.shape != ending.shape:
        _refuse(f"{truths.dtype} of shape {truths.shape}", ending)
    return truths


def _refuse(got: str, ending: "xr.DataArray") -> NoReturn:
    axes = ", ".join(map(str, ending.dims)) or "no axis"
    raise RequestError(
        f"A function that classifies must return a bool for each cell: a DataArray over {axes}, or an array of shape "
        f"{ending.shape}; it returned {got}.",
        hint="Return a comparison of variables, as in lambda atlas: atlas.peak_tilt > 0.1.",
        where="criterion",
    )


def _with_verdicts(
    dataset: "xr.Dataset", spec: SweepSpec, stability: npt.NDArray[np.int8], done: str, seen: Seen = unseen
) -> "xr.Dataset":
    """Return an atlas with other verdicts, and what follows from them and their criterion."""
    edges = edge_variables(spec, stability, seen)
    verdicts = dataset["stability"].copy(data=stability)
    declared = next(each for each in cell_declarations(spec) if each.name == "stability")
    verdicts.attrs["comment"] = declared.attributes["comment"]
    gone = [] if spec.criterion == spec_of(dataset).criterion else [*spec.model.of_criterion]
    changed = (
        without_boundary(dataset).drop_vars(gone, errors="ignore").assign({"stability": verdicts} | edges)
    )
    return changed.assign_attrs(
        **spec_attributes(spec),
        history=f"{dataset.attrs.get('history', '')}\n{created()} {done}".lstrip("\n"),
    )
