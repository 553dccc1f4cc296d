"""The accessor ``dataset.eulerdisk`` of an xarray.Dataset with an atlas or a motion.

It is registered once this package and xarray have been imported, in either order. Heavy modules are imported on first
use.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from sweep.atlas.cf_metadata import edge_names, status_name
from sweep.atlas.selection import check_numbers, is_atlas, require_atlas
from sweep.errors import RequestError
from sweep.model.quantity import STABLE, UNSTABLE
from sweep.motion.sampling import check_filmed, check_motion, is_motion, kind_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sweep.atlas.share import Share
    from sweep.explorer.explorer import Explorer
    from sweep.request.criterion import Criterion
    from sweep.request.spec import SweepSpec

NAME = "eulerdisk"


class Eulerdisk:
    """The accessor of an atlas or a motion.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, or a selection from one, which is treated as a complete atlas. Or a motion from `sweep.simulate`, or
        part of one; for a motion, only `plot` and `animate` work.
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset
        self._own: xr.Dataset | None = None

    @property
    def atlas(self) -> xr.Dataset:
        """The selection as an atlas: its spec requests only these cells, and its boundary lies among them.

        For a whole atlas, the same atlas with its dimensions in the order of its spec.

        Raises
        ------
        RequestError
            If the dataset is not an atlas, or the selection lost a coordinate or the order of its values.
        """
        if self._own is None:
            from sweep.atlas.selection import as_atlas

            self._check()
            self._own = as_atlas(self._dataset)
        return self._own

    @property
    def spec(self) -> "SweepSpec":
        """The request for the cells of the atlas or the selection.

        Raises
        ------
        RequestError
            As in `atlas`.
        """
        from sweep.atlas.dataset import spec_of

        return spec_of(self.atlas)

    @property
    def stable(self) -> xr.DataArray:
        """Array of bool over the grid, true in stable cells. Undecided cells are neither stable nor unstable."""
        return self._verdict(STABLE, "stable")

    @property
    def unstable(self) -> xr.DataArray:
        """Array of bool over the grid, true in unstable cells."""
        return self._verdict(UNSTABLE, "unstable")

    @property
    def unstable_share(self) -> "Share":
        """The share of unstable motions among the random starts.

        It has the ``value``, its 95 % ``interval``, and the numbers of starts ``unstable``, ``stable``, ``undecided``,
        ``failed`` and ``missing``.

        Raises
        ------
        RequestError
            If the atlas is a grid.
        """
        from sweep.atlas.share import unstable_share

        self._check()
        return unstable_share(self._dataset)

    def trusted(self, variable: str | None = None, *, within: float | None = None) -> xr.DataArray:
        """Return which cells to trust: cells with a known ending, or with a variable that is known well enough.

        ``atlas.where(atlas.eulerdisk.trusted())`` drops cells that were not computed, could not be followed, or are too
        sensitive to their start. Such a cell may still have a known measure: ``trusted("peak", within=1e-3)``.

        Parameters
        ----------
        variable : str, optional
            A measure or another numeric variable of the cells.
        within : float, optional
            The largest error allowed, in the unit of the variable, for twice the error that a cell states.

        Returns
        -------
        xarray.DataArray
            Array of bool over the axes.

        Raises
        ------
        RequestError
            If only one argument is given, the variable is not a numeric variable of the cells, or the dataset is not an
            atlas.
        """
        from sweep.atlas.trust import trusted_cells

        atlas = self.atlas
        return xr.DataArray(
            trusted_cells(atlas, variable, within),
            coords=atlas["ending"].coords,
            dims=atlas["ending"].dims,
            name="trusted",
        )

    @property
    def critical(self) -> xr.DataArray:
        """The analytic critical value [SI], the upper edge of the unstable band, along the remaining axes."""
        return self.boundary()["critical"]

    def boundary(self, axis: str | None = None, edge: str = "upper") -> xr.Dataset:
        """Return the boundary of stability along a control parameter (for the disk, a rate).

        Parameters
        ----------
        axis : str, optional
            The parameter; required only if the atlas has boundaries along two.
        edge : {"upper", "lower"}
            The edge of the unstable band: the motion is stable above the upper edge, or below the lower one.

        Returns
        -------
        xarray.Dataset
            ``measured`` and its ``halfwidth``, ``predicted`` and ``critical`` [SI], along the remaining axes; also
            ``status``, the reason why a row has no boundary, if the atlas has it.

        Raises
        ------
        RequestError
            If the dataset is not an atlas, or has no such boundary.
        """
        from sweep.atlas.dataset import found_edges

        atlas, given = self.atlas, ("measured", "halfwidth", "predicted", "critical")
        found = list(found_edges(atlas, self.spec))
        along = [each for each, side in found if side == edge and axis in (None, each)]
        if len(along) != 1:
            raise RequestError(
                "There is no such boundary, or more than one: this atlas has "
                f"{', '.join(edge_names(*each)[0] for each in found) or 'none'}; the request was the {edge} edge along "
                f"{axis or ' and '.join(along) or 'no parameter'}.",
                hint="Name a parameter and an edge, upper or lower.",
            )
        name = along[0]
        names = dict(zip(edge_names(name, edge), given, strict=True)) | {status_name(name, edge): "status"}
        part = atlas[list(names)].rename(names)
        # the result is not an atlas
        part.attrs = {}
        return part

    def reclassify(self, criterion: "Criterion | str | Callable[[xr.Dataset], Any]") -> xr.Dataset:
        """Return the atlas with the verdicts of a different criterion; see `sweep.reclassify`."""
        from sweep.atlas.reclassify import reclassify

        return reclassify(self.atlas, criterion)

    def cell(self, **given: float | str) -> xr.Dataset:
        """Return the cell nearest to the given axis values: ``cell(roll_rate=2.4, tilt="1deg")``.

        Raises
        ------
        RequestError
            If an axis has no value, or a value lies outside the atlas.
        """
        from sweep.atlas.parts import nearest_cell

        place = nearest_cell(self.spec, given)
        rows = [str(name) for name in self.atlas.data_vars if set(self.atlas[name].dims) == place.keys()]
        return self.atlas[rows].isel(place)

    def interp(self, **given: Any) -> xr.Dataset:
        """Return the variables at points between the cells: ``interp(roll_rate=2.413, tilt="1.5deg")``.

        Measures are interpolated linearly; endings, verdicts and counts come from the nearest cell. (The ``interp`` of
        xarray also interpolates the codes of flags, so that a verdict becomes a fraction.) Interpolation cannot show
        what happens between an unstable and a stable cell: compute an atlas there.

        Parameters
        ----------
        **given
            Axis -> a number, text with a unit, or an array; inside the atlas. A rate may be scaled, or a speed. Arrays
            span a grid; an xarray.DataArray [SI] gives points along its own dimensions.

        Returns
        -------
        xarray.Dataset
            Not an atlas: its values do not belong to starts that were computed.

        Raises
        ------
        RequestError
            If a name is not an axis, or a value lies outside the atlas.
        """
        from sweep.atlas.interpolation import interpolated

        return interpolated(self.atlas, given)

    def simulate(self, **words: float | str) -> xr.Dataset:
        """Return the motion in time of the cell nearest to the given axis values; see `sweep.simulate`.

        ``simulate(roll_rate=2.4, tilt="1deg", duration="10s")``: arguments other than axes change the motion.

        Raises
        ------
        RequestError
            If an axis has no value, a value lies outside the atlas, an argument is unknown, or the motion does not
            exist.
        """
        from sweep.atlas.parts import nearest_cell
        from sweep.motion.origin import cell_and_changes, request_of_cell
        from sweep.motion.trajectory import simulate

        spec = self.spec
        cell, changes = cell_and_changes(spec, words)
        request = request_of_cell(self.atlas, nearest_cell(spec, cell), changes)
        return simulate(request, command="dataset.eulerdisk.simulate")

    def plot(
        self,
        ax: "Axes | None" = None,
        *,
        rate: str | None = None,
        quantity: str | None = None,
        contours: Any = None,
        family: bool = False,
        losses: bool = False,
        regimes: bool = False,
        friction: float | None = None,
        bare: bool = False,
        without: "str | Sequence[str] | None" = None,
        width: "str | float | None" = None,
        height: "str | float | None" = None,
        font_size: float | None = None,
        dpi: int | None = None,
    ) -> "Figure":
        """Return the stability map, or the figure of a motion, as a matplotlib Figure.

        The arguments are the options of ``eulerdisk plot`` (docs/figures.md); the figure of a motion takes none.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Draw into these axes, with the settings of their figure; the legend is below them and can be removed.
        rate : {"linear", "squared", "scaled", "speed"}, optional
            Quantity on the axis of a rate. Scaled: in units of sqrt(g/R). Speed: the speed of the contact point, roll
            rate times radius.
        quantity : str, optional
            The cell variable shown by the colors; the peak by default.
        contours : str, number or sequence, optional
            Levels of contour lines of `quantity`, such as ``"5deg,20deg"`` (numbers are SI), or ``"auto"``.
        family : bool
            Draw an atlas with more than two axes as a family of boundary curves instead of several maps.
        losses : bool
            For a disk with losses: draw how long it stays aloft, and which law took most of its energy.
        regimes : bool
            Without losses: draw the number of wells of the potential, and the motions that cross upright.
        friction : float, optional
            Hatch where rolling without slip needs a larger friction coefficient.
        bare : bool
            Draw no title and no caption, and a short legend. ``figure.get_label()`` returns the text of title, caption,
            legend and color bar.
        without : str or sequence of str, optional
            Parts to omit: title, caption, legend, strip, bar; for example ``"strip,bar"``.
        width, height : str or float, optional
            Size of the figure, such as ``"86mm"``; a number is in m.
        font_size : float, optional
            Size of the text [points].
        dpi : int, optional
            Dots per inch of the figure.

        Raises
        ------
        RequestError
            If an argument is invalid, or the atlas cannot be drawn.
        """
        words = {
            "rate": rate, "quantity": quantity, "contours": contours, "family": family, "width": width,
            "height": height, "font_size": font_size, "dpi": dpi, "bare": bare, "without": without,
        }  # fmt: skip
        if is_motion(self._dataset):
            maps = {"losses": losses, "regimes": regimes, "ax": ax, "friction": friction}
            return self._plot_motion({**words, **maps})
        from sweep.figures import plots
        from sweep.figures.look import Look

        if not losses and not regimes:
            return plots.figure([self.atlas], friction, Look.read(**words), ax)
        others: dict[str, Any] = {
            "quantity": quantity, "contours": contours, "family": family or None, "friction": friction, "ax": ax,
            "losses": (losses and regimes) or None,
        }  # fmt: skip
        drawn, shown = ("regimes", "kinds of motion") if regimes else ("losses", "times and laws")
        if given := [name for name, value in others.items() if value is not None]:
            raise RequestError(
                f"A map of {drawn} shows only {shown}; got {drawn} with {' and '.join(given)}.",
                hint=f"Omit {' and '.join(given)}.",
            )
        draw = plots.regimes if regimes else plots.losses
        return draw([self.atlas], Look.read(**words))

    def _plot_motion(self, words: "dict[str, Any]") -> "Figure":
        if given := [name for name, value in words.items() if value is not None and value is not False]:
            raise RequestError(
                f"{' and '.join(given)} belong{'s' if len(given) == 1 else ''} to the map of an atlas; "
                "this is a motion, whose figure takes no arguments.",
                hint="Write motion.eulerdisk.plot().",
            )
        from sweep.figures import plots

        return plots.motion_figure(self._dataset)

    def animate(
        self,
        path: str | Path,
        *,
        speed: float | None = None,
        fps: int | None = None,
        size: str | tuple[int, int] | None = None,
        camera: str | None = None,
        overwrite: bool = False,
    ) -> None:
        """Write a film of a motion.

        Parameters
        ----------
        path : str or Path
            An mp4 file, which needs the program ffmpeg, or a gif file.
        speed : float, optional
            Seconds of motion per second of film; if not given, the film lasts some seconds. The film shows its speed.
        fps : int, optional
            Frames per second, 25 if not given.
        size : str or (int, int), optional
            Width and height [pixels], 640x480 if not given.
        camera : {"fixed", "follow", "top"}, optional
            A view of the whole motion, a view that moves with the disk, or a view from above. If not given, the camera
            follows a disk whose initial motion would take it far.
        overwrite : bool, default False
            Replace an existing file.

        Raises
        ------
        RequestError
            If the dataset is not a motion, an option is invalid, or the file cannot be written.
        """
        from sweep.figures.disk.film_options import FilmOptions
        from sweep.files.paths import check_target

        if is_atlas(self._dataset):
            values = {name: self._dataset[name].values for name in self.spec.axes}
            cell = ", ".join(f"{name}={float(axis[axis.size // 2])!r}" for name, axis in values.items())
            raise RequestError(
                "This is a stability atlas; only a motion can be filmed.",
                hint=f"Film the motion of a cell: atlas.eulerdisk.simulate({cell}).eulerdisk.animate(path).",
            )
        check_motion(self._dataset)
        check_filmed(kind_of(self._dataset), "Draw it: motion.eulerdisk.plot().")
        options = FilmOptions.read(path, speed=speed, fps=fps, size=size, camera=camera)
        check_target(Path(path), overwrite)
        from sweep.figures.disk import animation

        animation.save(self._dataset, path, options)

    def explore(self, *, port: int = 0, open_browser: bool = False) -> "Explorer":
        """Open the explorer of the atlas: a map that computes further cells, between and beyond, while you look.

        Parameters
        ----------
        port : int
            Port on this machine; any free port if not given.
        open_browser : bool
            Also open the page in the browser; a notebook shows it anyway.

        Returns
        -------
        Explorer
            See `sweep.explore`.

        Raises
        ------
        RequestError
            If the dataset is not an atlas, its cells do not form a plane, or the port cannot be used.
        """
        from sweep.explorer.explorer import explore

        return explore(self.atlas, port=port, open_browser=open_browser)

    def __repr__(self) -> str:
        """Return a short summary: the sweep, its grid and disk, the verdicts, the boundaries compared with theory."""
        from sweep.figures.summary import as_text

        return as_text(self._dataset)

    def _repr_html_(self) -> str:
        """Return the summary as an HTML table with a small map, for notebooks."""
        from sweep.figures.summary import as_html

        return as_html(self._dataset)

    def _check(self) -> None:
        if is_motion(self._dataset):
            raise RequestError(
                "This is not a stability atlas: it is one motion in time, whose accessor has plot and animate.",
                hint="Compute an atlas with sweep.run.",
            )
        if not is_atlas(self._dataset):
            require_atlas(self._dataset)
            given = ", ".join(map(str, self._dataset.data_vars)) or "no variables"
            raise RequestError(
                "This is not a stability atlas: the accessor eulerdisk needs a dataset from sweep.run or eulerdisk "
                f"run. Got a dataset of {given}.",
                hint="Open an atlas and keep its attributes (xarray.set_options(keep_attrs=True)).",
            )
        check_numbers(self._dataset)

    def _verdict(self, code: int, name: str) -> xr.DataArray:
        self._check()
        verdict: xr.DataArray = self._dataset["stability"] == code
        verdict.attrs = {}
        return verdict.rename(name)


# after importlib.reload, xarray would warn of a second registration
if not hasattr(xr.Dataset, NAME):
    xr.register_dataset_accessor(NAME)(Eulerdisk)  # type: ignore[no-untyped-call]  # xarray gives it no types
