"""Reclassification by another criterion, and refinement of the boundary, of a finished atlas from its measures."""

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

#: Number of parts in which the progress of the boundary search is counted.
_PARTS: Final = 1000


def reclassify(
    dataset: "xr.Dataset", criterion: Criterion | str | Callable[["xr.Dataset"], Any]
) -> "xr.Dataset":
    """Return an atlas with the verdicts and boundaries of another criterion.

    No cell of the grid is integrated again; a refined boundary needs integrations between cells.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, as `sweep.run` or `sweep.open_atlas` returns it, or a selection from one.
    criterion : Criterion, str or callable
        For example ``departure:2deg``, ``amplification:10`` or ``peak_tilt > 10deg or fall_time < 2s``. A function is
        called with the atlas, and returns which cells are unstable: bools in an xarray.DataArray over the axes of the
        atlas, or in an array of its shape. The result is used like that of an expression: a cell that could not be
        resolved is undecided, and a cell with False is stable if its ending is final.

    Returns
    -------
    xarray.Dataset
        The same measures, without those that depend on the old criterion; `stability`, the boundaries and the
        attributes of the criterion are new. With a function, the boundary is not refined, and the atlas cannot be
        saved, because a file cannot contain the function.

    Raises
    ------
    RequestError
        If the dataset is not an atlas; if the criterion is invalid, or needs variables that the atlas does not have; if
        a function does not return one bool for each cell.
    """
    require_atlas(dataset)
    atlas = as_atlas(dataset)
    spec = spec_of(atlas)
    if isinstance(criterion, Criterion | str) or not callable(criterion):
        new = spec.replace(criterion=criterion)
        return _with_verdicts(atlas, new, _judged(atlas, new), f"reclassified with {criterion}")
    name = shown(printable(ascii_text(str(getattr(criterion, "__qualname__", type(criterion).__qualname__)))))
    # the function gives no verdicts between cells
    new = spec.replace(criterion=Criterion("function", name), boundary=GRID)
    truths = _truths(criterion(atlas), atlas["ending"])
    verdicts = new.criterion.outcome(spec.model.endings, atlas["ending"].values, truths)
    return _with_verdicts(atlas, new, verdicts, f"reclassified in memory with the {new.criterion}")


def refine(dataset: "xr.Dataset", width: float = REFINED_WIDTH, *, progress: Progress = None) -> "xr.Dataset":
    """Return an atlas whose boundary is refined by bisection, row by row and as curves.

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
        If the dataset is not an atlas, the width is not above 0, `progress` is invalid, or the criterion is a function.
    """
    require_atlas(dataset)
    atlas = as_atlas(dataset)
    spec = spec_of(atlas).replace(boundary=f"{REFINED}:{width!r}")
    spec.criterion.check_new_cells()
    with following(progress) as show:
        timetable = Timetable([Stage(SEARCHING, _PARTS)], show, things="parts")
        timetable.begin(SEARCHING)

        def report_search(share: float) -> None:
            timetable.report(int(share * _PARTS))

        return _with_verdicts(
            atlas, spec, _judged(atlas, spec), f"boundary refined to {width!r}", report_search
        )


def _judged(dataset: "xr.Dataset", spec: SweepSpec) -> npt.NDArray[np.int8]:
    """Return the verdicts by the criterion of a spec, in the shape of the grid."""
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
    """Return the result of a function as an array over the grid, or refuse it."""
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
        f"A criterion function must return a bool for each cell: a DataArray over {axes}, or an array of shape "
        f"{ending.shape}; it returned {got}.",
        hint="Return a comparison of variables, as in lambda atlas: atlas.peak_tilt > 0.1.",
        where="criterion",
    )


def _with_verdicts(
    dataset: "xr.Dataset", spec: SweepSpec, stability: npt.NDArray[np.int8], done: str, seen: Seen = unseen
) -> "xr.Dataset":
    """Return an atlas with new verdicts, and everything that follows from them and from the criterion."""
    edges = edge_variables(spec, stability, seen)
    verdicts = dataset["stability"].copy(data=stability)
    declaration = next(
        declaration for declaration in cell_declarations(spec) if declaration.name == "stability"
    )
    verdicts.attrs["comment"] = declaration.attributes["comment"]
    gone = [] if spec.criterion == spec_of(dataset).criterion else [*spec.model.of_criterion]
    changed = (
        without_boundary(dataset).drop_vars(gone, errors="ignore").assign({"stability": verdicts} | edges)
    )
    return changed.assign_attrs(
        **spec_attributes(spec),
        history=f"{dataset.attrs.get('history', '')}\n{created()} {done}".lstrip("\n"),
    )
