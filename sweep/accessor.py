"""``dataset.eulerdisk``: what an atlas, or one motion, can be asked from the xarray.Dataset itself.

The package registers it when both this package and xarray have been imported, in whichever order. Nothing heavy is
imported here before something is asked.
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
    """An atlas, or one motion, as its reader sees it.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas or a selection from one, which is taken for an atlas of its own. Or a motion, as `sweep.simulate`
        returns it, or a stretch of one; it has `plot` and `animate`.
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset
        self._own: xr.Dataset | None = None

    @property
    def atlas(self) -> xr.Dataset:
        """The atlas that a selection is: its spec asks for these cells alone, and its boundary lies among them.

        A whole atlas is returned with its dimensions in the order of its spec.

        Raises
        ------
        RequestError
            If it is no atlas, or the selection has lost a coordinate or its order.
        """
        if self._own is None:
            from sweep.atlas.selection import as_atlas

            self._check()
            self._own = as_atlas(self._dataset)
        return self._own

    @property
    def spec(self) -> "SweepSpec":
        """The request that the atlas was made from; of a selection, the one that asks for its cells.

        Raises
        ------
        RequestError
            As from `atlas`.
        """
        from sweep.atlas.dataset import spec_of

        return spec_of(self.atlas)

    @property
    def stable(self) -> xr.DataArray:
        """Where the criterion says stable: array of bool over the grid. Undecided cells are neither."""
        return self._verdict(STABLE, "stable")

    @property
    def unstable(self) -> xr.DataArray:
        """Where the criterion says unstable: array of bool over the grid."""
        return self._verdict(UNSTABLE, "unstable")

    @property
    def unstable_share(self) -> "Share":
        """The share of the random starts that is unstable.

        It has ``value`` and its 95 % ``interval``, and the numbers of starts: ``unstable``, ``stable``, ``undecided``,
        ``failed``, ``missing``.

        Raises
        ------
        RequestError
            If the atlas is a grid.
        """
        from sweep.atlas.share import unstable_share

        self._check()
        return unstable_share(self._dataset)

    def trusted(self, variable: str | None = None, *, within: float | None = None) -> xr.DataArray:
        """Return which cells to trust: those whose ending is known, or a value of which is known well enough.

        ``atlas.where(atlas.eulerdisk.trusted())`` leaves out cells that were not computed, that could not be followed,
        and those that are too sensitive to their start. A measure may be known of these too:
        ``trusted("peak", within=1e-3)``.

        Parameters
        ----------
        variable : str, optional
            A measure or another number of the cells.
        within : float, optional
            How far it may be off, in its unit, by twice what the cells state.

        Returns
        -------
        xarray.DataArray
            Of bool, over the axes.

        Raises
        ------
        RequestError
            If only one of both is given, the variable is no number of the cells, or the dataset is no atlas.
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
        """The analytic critical value [SI], the upper edge of the unstable band, over the remaining axes."""
        return self.boundary()["critical"]

    def boundary(self, axis: str | None = None, edge: str = "upper") -> xr.Dataset:
        """Return the boundary of stability along a control parameter, for the disk a rate.

        Parameters
        ----------
        axis : str, optional
            The parameter; needed only if the atlas has boundaries along two.
        edge : {"upper", "lower"}
            The edge of the unstable band: stable above it, or below it.

        Returns
        -------
        xarray.Dataset
            ``measured`` and its ``halfwidth``, ``predicted`` and ``critical`` [SI], over the remaining axes, and
            ``status``, which says why a row has no boundary, if the atlas has it.

        Raises
        ------
        RequestError
            If it is no atlas, or has no such boundary.
        """
        from sweep.atlas.dataset import found_edges

        atlas, given = self.atlas, ("measured", "halfwidth", "predicted", "critical")
        found = list(found_edges(atlas, self.spec))
        along = [each for each, side in found if side == edge and axis in (None, each)]
        if len(along) != 1:
            raise RequestError(
                "There is no such boundary, or more than one: this atlas has "
                f"{', '.join(edge_names(*each)[0] for each in found) or 'none'}; asked for was the {edge} edge along "
                f"{axis or ' and '.join(along) or 'no parameter'}.",
                hint="Name a parameter and an edge, upper or lower.",
            )
        name = along[0]
        names = dict(zip(edge_names(name, edge), given, strict=True)) | {status_name(name, edge): "status"}
        part = atlas[list(names)].rename(names)
        # it is not an atlas any more
        part.attrs = {}
        return part

    def reclassify(self, criterion: "Criterion | str | Callable[[xr.Dataset], Any]") -> xr.Dataset:
        """Return the atlas with the verdicts of another criterion; see `sweep.reclassify`."""
        from sweep.atlas.reclassify import reclassify

        return reclassify(self.atlas, criterion)

    def cell(self, **given: float | str) -> xr.Dataset:
        """Return the cell nearest to the values given for the axes: ``cell(roll_rate=2.4, tilt="1deg")``.

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
        """Return the cells' variables at places between them: ``interp(roll_rate=2.413, tilt="1.5deg")``.

        Measures are interpolated linearly; endings, verdicts and counts are those of the nearest cell. (The ``interp``
        of xarray interpolates the codes of flags too, so that a verdict becomes a fraction.) What lies between an
        unstable and a stable cell no interpolation knows: compute an atlas there.

        Parameters
        ----------
        **given
            Axis -> a number, text with a unit, or an array; inside the atlas. A rate may be given scaled, or as a
            speed. Arrays span a grid; an xarray.DataArray [SI] gives points along its own dimensions.

        Returns
        -------
        xarray.Dataset
            Not an atlas any more: its values belong to no start.

        Raises
        ------
        RequestError
            If a name is no axis, or a value lies outside.
        """
        from sweep.atlas.interpolation import interpolated

        return interpolated(self.atlas, given)

    def simulate(self, **words: float | str) -> xr.Dataset:
        """Return the motion in time of the cell nearest to the values given for the axes; see `sweep.simulate`.

        ``simulate(roll_rate=2.4, tilt="1deg", duration="10s")``: words that name no axis change the motion.

        Raises
        ------
        RequestError
            If an axis has no value, a value lies outside the atlas, a word is not known, or there is no such motion.
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

        The words are those of ``eulerdisk plot`` (docs/figures.md); the figure of a motion takes none of them.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Draw into these, with the settings of their figure; the legend is below them, and can be removed.
        rate : {"linear", "squared", "scaled", "speed"}, optional
            What the axis of a rate shows; scaled is in units of sqrt(g/R), the speed of the contact point is the roll
            rate times the radius.
        quantity : str, optional
            The variable of the cells that gives the colours; by default the peak.
        contours : str, number or sequence, optional
            Levels of contour lines of it, as in ``"5deg,20deg"`` (numbers are SI), or ``"auto"``.
        family : bool
            Draw an atlas of more than two axes as a family of boundary curves, not as a map each.
        losses : bool
            Of a disk with losses: draw how long it stays aloft, and which law took most of its energy.
        regimes : bool
            Without losses: draw how many wells the potential has, and which motions cross upright.
        friction : float, optional
            Hatch where rolling without slip needs a larger friction coefficient.
        bare : bool
            Draw no title and no caption, and a short legend. The text of title, caption, legend and bar of colours is
            the label of the figure, ``figure.get_label()``.
        without : str or sequence of str, optional
            Parts to leave out: title, caption, legend, strip, bar, as in ``"strip,bar"``.
        width, height : str or float, optional
            Of the figure, as in ``"86mm"``; a number is in m.
        font_size : float, optional
            Size of the words [points].
        dpi : int, optional
            Dots per inch of the figure.

        Raises
        ------
        RequestError
            If one of them is not possible, or the atlas cannot be drawn.
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
                f"A map of {drawn} has {shown}, and nothing else; got {drawn} with {' and '.join(given)}.",
                hint=f"Leave {' and '.join(given)} out.",
            )
        draw = plots.regimes if regimes else plots.losses
        return draw([self.atlas], Look.read(**words))

    def _plot_motion(self, words: "dict[str, Any]") -> "Figure":
        if given := [name for name, value in words.items() if value is not None and value is not False]:
            raise RequestError(
                f"{' and '.join(given)} belong{'s' if len(given) == 1 else ''} to the map of an atlas; "
                "this is a motion, whose figure takes no words.",
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
            mp4, which needs the program ffmpeg, or gif.
        speed : float, optional
            Seconds of the motion for a second of the film; if not given, the film lasts some seconds. It says how fast
            it plays.
        fps : int, optional
            Frames per second, 25 if not given.
        size : str or (int, int), optional
            Width and height in dots, 640x480 if not given.
        camera : {"fixed", "follow", "top"}, optional
            It sees all of the motion, goes along with the disk, or looks from above; if not given, it follows a disk
            that would go far if it went on as it starts.
        overwrite : bool, default False
            Replace a file of that name.

        Raises
        ------
        RequestError
            If the dataset is no motion, or there can be no such film or file.
        """
        from sweep.figures.disk.film_options import FilmOptions
        from sweep.files.paths import check_target

        if is_atlas(self._dataset):
            values = {name: self._dataset[name].values for name in self.spec.axes}
            cell = ", ".join(f"{name}={float(axis[axis.size // 2])!r}" for name, axis in values.items())
            raise RequestError(
                "This is a stability atlas, and only a motion can be filmed.",
                hint=f"Film the motion of a cell: atlas.eulerdisk.simulate({cell}).eulerdisk.animate(path).",
            )
        check_motion(self._dataset)
        check_filmed(kind_of(self._dataset), "Draw it: motion.eulerdisk.plot().")
        options = FilmOptions.read(path, speed=speed, fps=fps, size=size, camera=camera)
        check_target(Path(path), overwrite)
        from sweep.figures.disk import animation

        animation.save(self._dataset, path, options)

    def explore(self, *, port: int = 0, open_browser: bool = False) -> "Explorer":
        """Open the explorer of the atlas: a map of its cells, and of those between and beyond, computed as one looks.

        Parameters
        ----------
        port : int
            Where this machine answers; any that is free if not given.
        open_browser : bool
            Open the page in the browser too; a notebook shows it by itself.

        Returns
        -------
        Explorer
            See `sweep.explore`.

        Raises
        ------
        RequestError
            If it is no atlas, its cells are no plane, or the port cannot be used.
        """
        from sweep.explorer.explorer import explore

        return explore(self.atlas, port=port, open_browser=open_browser)

    def __repr__(self) -> str:
        """Return a few lines: what was swept, its grid and disk, its verdicts, its boundaries against theory."""
        from sweep.figures.summary import as_text

        return as_text(self._dataset)

    def _repr_html_(self) -> str:
        """Return the same as a table, for a notebook, with a small map."""
        from sweep.figures.summary import as_html

        return as_html(self._dataset)

    def _check(self) -> None:
        if is_motion(self._dataset):
            raise RequestError(
                "This is one motion in time, and no stability atlas: its accessor has plot and animate.",
                hint="Compute an atlas with sweep.run.",
            )
        if not is_atlas(self._dataset):
            require_atlas(self._dataset)
            given = ", ".join(map(str, self._dataset.data_vars)) or "no variables"
            raise RequestError(
                "This is no stability atlas: the accessor eulerdisk serves datasets that sweep.run and eulerdisk run "
                f"have made; got a dataset of {given}.",
                hint="Open an atlas, and keep its attributes (xarray.set_options(keep_attrs=True)).",
            )
        check_numbers(self._dataset)

    def _verdict(self, code: int, name: str) -> xr.DataArray:
        self._check()
        verdict: xr.DataArray = self._dataset["stability"] == code
        verdict.attrs = {}
        return verdict.rename(name)


# importlib.reload would register it again, and xarray warn of it
if not hasattr(xr.Dataset, NAME):
    xr.register_dataset_accessor(NAME)(Eulerdisk)  # type: ignore[no-untyped-call]  # xarray gives it no types
